"""Refusal of a file of numbers in one line that names file, field, value and what is allowed."""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping
from typing import Any

LONGEST = 200  # characters of a field's path in a message; those of our files have forty


def printable(text: str) -> str:
    """Writes text that may be anybody's as one line which moves no cursor and turns no direction.

    Args:
        text: May hold line ends, a terminal's commands, marks of writing from right to left, half surrogate pairs.

    Returns:
        The text, each run of white space as one blank and what cannot be printed escaped as in Python.
    """
    line = " ".join(text.split())
    return line if line.isprintable() else "".join(c if c.isprintable() else ascii(c)[1:-1] for c in line)


def not_installed(packages: str, extra: str) -> str:
    """Says that packages are missing and how the checkout installs them: no package index has this project.

    Args:
        packages: Their names.
        extra: Extra of this project's package that has them.
    """
    return f"{packages} is not installed: make install, or pip install '.[{extra}]', in a checkout of delta-haptics"


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
        shown = field if len(field) <= LONGEST else field[: LONGEST - 3] + "..."
        what = " = ".join(part for part in (shown, value) if part)
        super().__init__(printable(": ".join(part for part in (file, what, allowed) if part)))


def meant(word: str, known: Iterable[str]) -> str:
    """Finds the known name that a wrong one was probably meant to be.

    Args:
        word: The wrong name.
        known: All right ones.

    Returns:
        The closest; "" where none is close.
    """
    from difflib import get_close_matches  # only where something is wrong

    found = get_close_matches(word[:LONGEST], list(known), n=1, cutoff=0.6)
    return found[0] if found else ""


def unknown_key(word: str, known: Iterable[str], elsewhere: Iterable[str] = ()) -> str:
    """Says what is allowed in place of a key that is not known.

    Args:
        word: The key.
        known: Keys that the table has.
        elsewhere: Dotted keys of the other tables.

    Returns:
        That it is unknown, what it was probably meant to be, and the keys that are known there.
    """
    names, other = list(known), list(elsewhere)
    found = next((name for name in other if name.rpartition(".")[2] == word), "")
    found = found or meant(word, names) or meant(word, other)
    hint = f"did you mean {found}? " if found else ""
    return f"unknown key; {hint}known here: {', '.join(names)}"


def short(value: object) -> str:
    """Gives a value as short JSON text for a message."""
    try:
        text = json.dumps(value, default=str)
    except (ValueError, RecursionError):  # an integer of thousands of digits, as TOML's hexadecimal ones can have
        text = "too long to tell"
    return text if len(text) <= 60 else text[:57] + "..."


def not_finite(data: object) -> tuple[str, float] | None:
    """Finds the first number of nested data that is not finite.

    Args:
        data: Dictionaries and lists of anything.

    Returns:
        Its dotted path and the number; None where there is none.
    """
    found = _not_finite(data)
    return None if found is None else (found[0].removeprefix("."), found[1])


def _not_finite(data: object) -> tuple[str, float] | None:
    """See `not_finite`; the path begins with the sign that joins it. It is made on the way out: keys may be long."""
    if isinstance(data, float):
        return None if math.isfinite(data) else ("", data)
    parts: Iterable[tuple[str, object]] = ()
    if isinstance(data, Mapping):
        parts = ((f".{key}", value) for key, value in data.items())
    elif isinstance(data, list | tuple):
        parts = ((f"[{i}]", value) for i, value in enumerate(data))
    for name, part in parts:
        if (found := _not_finite(part)) is not None:
            return name + found[0], found[1]
    return None


def bounds_of(metadata: list[Any]) -> str:
    """Gives the bounds of a declared number, such as "> 0 and <= 100"; "" where it has none."""
    bounds = []
    for item in metadata:
        for sign, attribute in ((">", "gt"), (">=", "ge"), ("<", "lt"), ("<=", "le")):
            if getattr(item, attribute, None) is not None:
                bounds.append(f"{sign} {getattr(item, attribute):g}")
    return " and ".join(bounds)
