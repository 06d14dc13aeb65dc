"""Templates of the generated files, C and Markdown, and how they are filled in."""

from __future__ import annotations

from functools import cache
from pathlib import Path
from typing import Any


def rendered(file: str, /, **values: Any) -> str:
    """A generated file or a part of one; `jinja2.UndefinedError` if a value is missing."""
    return _environment().get_template(f"{file}.j2").render(values)


@cache
def _environment() -> Any:
    from jinja2 import Environment, FileSystemLoader, StrictUndefined

    folder = FileSystemLoader(Path(__file__).parent)
    return Environment(
        loader=folder,
        undefined=StrictUndefined,
        autoescape=False,
        keep_trailing_newline=True,
        trim_blocks=True,
        lstrip_blocks=True,
    )
