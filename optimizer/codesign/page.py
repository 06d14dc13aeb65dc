"""Common parts of pages without a script: template and style, and the axis of a plot with round values."""

from __future__ import annotations

import math
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from delta_cad.report.page import ASSETS, environment, page_policy

TICKS = 8  # at most
_ALIKE = 1e-6  # values that differ by less, as a share of them, are one
_ROOM = 0.05  # share of the range that is left free at both ends


def rendered(template: str, own_style: str, title: str, **given: Any) -> str:
    """Fills in one of the templates in `pages/`, which extend `frame.html`.

    The style is that of report.html and what the page adds.
    """
    from markupsafe import Markup

    style = (ASSETS / "page.css").read_text(encoding="utf-8") + own_style
    page = environment(Path(__file__).parent / "pages").get_template(template)
    return page.render(**given, title=title, policy=page_policy((), style), style=Markup(style))


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
        alike = high - low <= _ALIKE * max(abs(low), abs(high))
        room = (_ROOM * abs(high) or 1.0) if alike else _ROOM * (high - low)
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
