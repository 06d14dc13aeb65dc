"""One measured figure, and what it is held against."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, fields
from statistics import median
from typing import Any


@dataclass(frozen=True)
class Figure:
    """A measured figure.

    Attributes:
        subject: What it belongs to, the heading it stands under.
        name: What was measured.
        value: The figure; the median where it was repeated.
        unit: Its unit; "x" for a ratio, "" for a slope or a count.
        target: The figure to reach; None when none was set.
        at_most: Whether the target is an upper limit; otherwise a lower one.
        spread: Least and largest of the repeats; None for a single measurement.
        note: How it was measured, or what decides it.
    """

    subject: str
    name: str
    value: float
    unit: str
    target: float | None = None
    at_most: bool = True
    spread: tuple[float, float] | None = None
    note: str = ""

    @property
    def reached(self) -> bool | None:
        """Whether the target is reached; None without one."""
        if self.target is None:
            return None
        return self.value <= self.target if self.at_most else self.value >= self.target

    def to_json(self) -> dict[str, Any]:
        """The figure as JSON types."""
        return {**asdict(self), "reached": self.reached}

    @classmethod
    def from_json(cls, wording: dict[str, Any]) -> Figure:
        """The figure that `to_json` wrote."""
        values = {f.name: wording[f.name] for f in fields(cls)}
        return cls(**{**values, "spread": tuple(values["spread"]) if values["spread"] else None})


def of_repeats(
    subject: str,
    name: str,
    values: Sequence[float],
    unit: str,
    target: float | None = None,
    at_most: bool = True,
    note: str = "",
) -> Figure:
    """The median of repeats as a figure, with their spread."""
    return Figure(subject, name, median(values), unit, target, at_most, (min(values), max(values)), note)
