"""Refusal of a file of numbers in one line that names file, field, value and what is allowed."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any


class RefusedError(ValueError):
    """A file that is refused.

    Attributes:
        file: Name of the file (its last part), or what stands for it.
        field: Dotted path of the field, such as "cube.half_side_mm"; "" when the whole file is meant.
        value: The offending value as JSON text; "" when there is none.
        allowed: What is wrong or what would be allowed.
    """

    def __init__(self, file: str, field: str, value: str, allowed: str) -> None:
        self.file, self.field, self.value, self.allowed = file, field, value, allowed
        what = " = ".join(part for part in (field, value) if part)
        text = ": ".join(part for part in (file, what, allowed) if part)
        super().__init__(" ".join(text.split()))


def short(value: object) -> str:
    """Gives a value as short JSON text for a message."""
    text = json.dumps(value, default=str)
    return text if len(text) <= 60 else text[:57] + "..."


def floats(data: object, path: str = "") -> list[tuple[str, float]]:
    """Collects all floats of nested data with their dotted paths."""
    if isinstance(data, float):
        return [(path, data)]
    items: list[tuple[str, object]] = []
    if isinstance(data, Mapping):
        items = [(f"{path}.{key}" if path else str(key), value) for key, value in data.items()]
    elif isinstance(data, list | tuple):
        items = [(f"{path}[{i}]", value) for i, value in enumerate(data)]
    return [one for name, value in items for one in floats(value, name)]


def bounds_of(metadata: list[Any]) -> str:
    """Gives the bounds of a declared number, such as "> 0 and <= 100"; "" where it has none."""
    bounds = []
    for item in metadata:
        for sign, attribute in ((">", "gt"), (">=", "ge"), ("<", "lt"), ("<=", "le")):
            if getattr(item, attribute, None) is not None:
                bounds.append(f"{sign} {getattr(item, attribute):g}")
    return " and ".join(bounds)
