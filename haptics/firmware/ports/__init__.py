"""C sources of the ports, written next to a generated controller."""

from __future__ import annotations

from pathlib import Path

ENDINGS = {".c", ".h", ".ld", ".md"}


def files_of_ports() -> dict[str, str]:
    """The files by their path in a controller's folder."""
    here = Path(__file__).parent
    found = (path for path in sorted(here.rglob("*")) if path.suffix in ENDINGS)
    return {path.relative_to(here).as_posix(): path.read_text(encoding="utf-8") for path in found}
