"""What would do in place of what does not: rows of the catalogue, and borders of a range."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from delta_cad import catalogue
from delta_cad.design import Design

# Times what `lightest` gives is what a told value is to bear; only small sectors and long rods were built heavier.
HEAVIER = 1.25
HALVINGS = 30  # of a range in which something begins to hold: to 1e-9 of it
TOLD = 4  # rows of the catalogue that a message names at most


def border(holds: Callable[[float], bool], bad: float, good: float) -> float:
    """Finds where something begins to hold between a value at which it does not and one at which it does."""
    for _ in range(HALVINGS):
        middle = (bad + good) / 2.0
        bad, good = (bad, middle) if holds(middle) else (middle, good)
    return good


def rows(name: str, design: Design, does: Callable[[Any], bool]) -> list[str]:
    """Finds the rows of a family that would do."""
    return [key for key, row in catalogue.family(name, design.hardware.own_parts).items() if does(row)]


def named(ids: Sequence[str]) -> str:
    """Names rows that would do, for a message."""
    return f" ({', '.join(ids[:TOLD])})" if ids else " (the catalogue has none)"


def one(name: str, ids: Sequence[str]) -> tuple[tuple[str, float | str], ...]:
    """Gives the first of the rows that would do, as what has to change."""
    return tuple((f"hardware.{name}", key) for key in ids[:1])
