"""Plots of pages without a script: where a value stands, and the round values beside an axis."""

from __future__ import annotations

import math
from collections.abc import Iterable

TICKS = 8  # at most
ALIKE = 1e-6  # values that differ by less, as a share of them, are one
ROOM = 0.05  # share of the range that is left free at both ends


class Scale:
    """Maps values to places along an edge of a plot.

    Args:
        values: All that is to stand on it; none are those of an empty plot.
        start: Place where it begins, px.
        end: Place where it ends, px; less than `start` where it points up.
    """

    def __init__(self, values: Iterable[float], start: float, end: float) -> None:
        known = list(values)
        low, high = min(known, default=0.0), max(known, default=1.0)
        alike = high - low <= ALIKE * max(abs(low), abs(high))
        room = (ROOM * abs(high) or 1.0) if alike else ROOM * (high - low)
        self.low, self.high, self.start, self.end = low - room, high + room, start, end

    def at(self, value: float) -> float:
        """Gives the place of a value, px."""
        return round(self.start + (self.end - self.start) * (value - self.low) / (self.high - self.low), 1)

    def ticks(self) -> list[tuple[float, str]]:
        """Gives place and text of round values."""
        return [(self.at(value), f"{value:g}") for value in round_values(self.low, self.high)]


def round_values(low: float, high: float) -> list[float]:
    """Round values between two, at most `TICKS`."""
    decade = 10.0 ** math.floor(math.log10((high - low) / TICKS))
    step = next(k * decade for k in (1.0, 2.0, 5.0, 10.0) if (high - low) / (k * decade) <= TICKS)
    return [round(k * step, 10) for k in range(math.ceil(low / step), math.floor(high / step) + 1)]
