"""The commands: each module has `NAME`, `TEXT`, `OPTIONS` and `run(given) -> exit code`, and is imported when used."""
