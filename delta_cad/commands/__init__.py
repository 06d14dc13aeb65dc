"""The commands: each module has `NAME`, `TEXT`, `arguments(parser)` and `run(given) -> exit code`, and loads late."""
