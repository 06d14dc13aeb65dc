"""Refusal of a file of numbers in one line that names file, field, value and what is allowed."""

from __future__ import annotations

import json
import math
import operator
import re
import sys
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import suppress
from typing import Any

_PREFIX = 3  # letters from which on the beginning of a name stands for it
_PARTS = re.compile(r"[^\W_]+")
LONGEST = 200  # characters of a word in a message, such as a field's path or a value; those of our files have forty
_MOST_DOUBLE = sys.float_info.max
MOST_LINE = 2500  # characters of a message; the longest lists of what is known have a half
FORMULAS = ("=", "+", "-", "@", "\t", "\r")  # first letters of cells that spreadsheets compute
_LONG = re.compile(rf"\S{{{LONGEST + 1},}}")


def visible(text: str) -> str:
    """Writes text that may be anybody's as one line which moves no cursor and turns no direction.

    Args:
        text: May hold line ends, a terminal's commands, marks of writing from right to left, half surrogate pairs.

    Returns:
        The text, each run of white space as one blank and what cannot be printed escaped as in Python.
    """
    line = " ".join(text.split())
    return line if line.isprintable() else "".join(c if c.isprintable() else ascii(c)[1:-1] for c in line)


def printable(text: str) -> str:
    """Writes a message, which may repeat anybody's text, as one visible line of bounded length.

    Args:
        text: As for `visible`.

    Returns:
        The line; of a word of more than `LONGEST` characters, and of a line of more than `MOST_LINE`, the middle is
        left out.
    """
    line = _LONG.sub(lambda word: _shortened(word[0], LONGEST), visible(text))
    return _shortened(line, MOST_LINE)


def _shortened(text: str, most: int) -> str:
    """A text without its middle where it is longer."""
    return text if len(text) <= most else f"{text[: most * 2 // 3]}...{text[3 - most // 3 :]}"


def as_cell(value: Any) -> Any:
    """Gives a value as a cell of a table: text that a spreadsheet would take for a formula begins with an apostrophe.

    Args:
        value: Text, a number or None.
    """
    return f"'{value}" if isinstance(value, str) and value.startswith(FORMULAS) else value


def not_installed(packages: str, extra: str) -> str:
    """Says that packages are missing and how the checkout installs them: no package index has this project.

    Args:
        packages: Their names, or that of a module of one.
        extra: Extra of this project's package that the command needs; the one that has the package is added.
    """
    has = _extras().get(_PACKAGES.get(packages.partition(".")[0], packages).lower(), [extra])
    extra = extra if set(has) & set(extra.split(",")) else f"{extra},{has[0]}"
    ways = f"make install and start .venv/bin/python, or pip install '.[{extra}]', in a checkout of delta-haptics"
    return f"{packages} is not installed in this Python: {ways}"


_PACKAGES = {"OCP": "cadquery", "vtkmodules": "cadquery", "fcl": "python-fcl"}
"""Module -> package, where their names differ."""


def _extras() -> dict[str, list[str]]:
    """Reads package -> extras that have it off this project's metadata."""
    from importlib.metadata import PackageNotFoundError, requires

    found: dict[str, list[str]] = {}
    with suppress(PackageNotFoundError):  # run from a folder that was not installed
        for line in requires("delta-haptics") or ():
            if one := re.match(r"([\w.-]+).*extra == ['\"](\w+)", line):
                found.setdefault(one[1].lower(), []).append(one[2])
    return found


class RefusedError(ValueError):
    """A file that is refused.

    Attributes:
        file: Name of the file (its last part), or what stands for it.
        field: Dotted path of the field, such as "cube.half_side_mm"; "" when the whole file is meant.
        value: The offending value as JSON text; "" when there is none.
        allowed: What is wrong or what would be allowed.
        more: Further faults of the file, each a line as the first one, where several were found at once.
    """

    more: tuple[str, ...] = ()

    def __init__(self, file: str, field: str, value: str, allowed: str) -> None:
        self.file, self.field, self.value, self.allowed = file, field, value, allowed
        what = " = ".join(part for part in (field, value) if part)
        super().__init__(printable(": ".join(part for part in (file, what, allowed) if part)))

    @property
    def lines(self) -> tuple[str, ...]:
        """All that is wrong, a line each."""
        return (str(self), *self.more)


def meant(word: str, known: Iterable[str], whole: bool = False) -> str:
    """Finds the known name that a wrong one was probably meant to be.

    Names are compared part by part: each part of the word that distinguishes names must be, up to a few edits or what
    is left out at its end, in the name. What most names share, such as a unit or a maker, distinguishes none.

    Args:
        word: The wrong name.
        known: All right ones.
        whole: Whether the shared parts must be in the name, too.

    Returns:
        The closest; "" where none is close.
    """
    word, names = word[:LONGEST], list(dict.fromkeys(known))
    parts = {name: _PARTS.findall(name.lower()) for name in names}
    counted = Counter(part for each in parts.values() for part in set(each))
    every = _PARTS.findall(word.lower())
    own = every if whole else [part for part in every if counted[part] < 2] or every
    joined = "".join(every)

    def distance(name: str) -> float:
        letters = "".join(parts[name])
        if (joined in letters and len(joined) >= _PREFIX) or _apart(joined, letters, 6) < math.inf:
            return 0.0
        return sum(min((_apart(part, other) for other in parts[name]), default=math.inf) for part in own)

    apart = {name: distance(name) for name in names} if every else {}
    close = [name for name in apart if apart[name] < math.inf]
    return min(close, key=lambda name: (apart[name], _edits(word, name)), default="")


def _apart(part: str, other: str, letters: int = 3) -> float:
    """Distance of two parts of names; infinite where it is more than one edit in so many letters."""
    if len(part) >= _PREFIX and other.startswith(part):
        return 0.5 * (part != other)
    most = len(part) // letters
    edits = _edits(part, other) if abs(len(part) - len(other)) <= most else math.inf
    return edits if edits <= most else math.inf


def _edits(a: str, b: str) -> int:
    """Counts the letters to change, insert, leave out or exchange with the next, to make a text of another."""
    before: list[int] = []
    row = list(range(len(b) + 1))
    for i, x in enumerate(a):
        older, before, row = before, row, [i + 1]
        for j, y in enumerate(b):
            row.append(min(before[j + 1] + 1, row[j] + 1, before[j] + (x != y)))
            if i and j and x == b[j - 1] and y == a[i - 1]:
                row[-1] = min(row[-1], older[j - 1] + 1)
    return row[-1]


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
    last = {name.rpartition(".")[2]: name for name in reversed(other)}
    found = found or meant(word, names) or last.get(meant(word, last, whole=True), "")
    hint = f"did you mean {found}? " if found else ""
    return f"unknown key; {hint}known here: {', '.join(names)}"


def short(value: object) -> str:
    """Gives a value as short JSON text for a message."""
    try:
        text = json.dumps(value, default=str)
    except (ValueError, RecursionError):  # an integer of thousands of digits, as TOML's hexadecimal ones can have
        text = "too long to tell"
    return text if len(text) <= 60 else text[:57] + "..."


def not_finite(data: object) -> tuple[str, float | int] | None:
    """Finds the first number of nested data that is not finite, or a whole one larger than any double.

    Args:
        data: Dictionaries and lists of anything.

    Returns:
        Its dotted path and the number; None where there is none.
    """
    found = _not_finite(data)
    return None if found is None else (found[0].removeprefix("."), found[1])


def _not_finite(data: object) -> tuple[str, float | int] | None:
    """See `not_finite`; the path begins with the sign that joins it. It is made on the way out: keys may be long."""
    if isinstance(data, float | int):
        return None if -_MOST_DOUBLE <= data <= _MOST_DOUBLE else ("", data)
    parts: Iterable[tuple[str, object]] = ()
    if isinstance(data, Mapping):
        parts = ((f".{key}", value) for key, value in data.items())
    elif isinstance(data, list | tuple):
        parts = ((f"[{i}]", value) for i, value in enumerate(data))
    for name, part in parts:
        if (found := _not_finite(part)) is not None:
            return name + found[0], found[1]
    return None


_SIGNS = {"gt": (">", operator.gt), "ge": (">=", operator.ge), "lt": ("<", operator.lt), "le": ("<=", operator.le)}


def bounds_of(metadata: list[Any]) -> str:
    """Gives the bounds of a declared number, such as "> 0 and <= 100"; "" where it has none."""
    return " and ".join(f"{sign} {bound:g}" for sign, _, bound in _bounds(metadata))


def within(metadata: list[Any], value: float) -> bool:
    """Decides whether a number is within the bounds of a declared one."""
    return all(holds(value, bound) for _, holds, bound in _bounds(metadata))


def _bounds(metadata: list[Any]) -> Iterator[tuple[str, Callable[[float, float], bool], float]]:
    for item in metadata:
        for attribute, (sign, holds) in _SIGNS.items():
            if (bound := getattr(item, attribute, None)) is not None:
                yield sign, holds, bound
