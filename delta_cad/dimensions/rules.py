"""Choices shared by several parts, each with its reason, and the error that says why parts cannot be dimensioned."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from math import ceil, floor, isfinite, log10, radians

RUNNING_GAP_MM = 1.0  # between an arm and the cheeks beside it: room for 0.1 mm parts and a shim
STOP_MARGIN_RAD = radians(3.0)  # the stop pin is met this far outside the cube's shoulder angles
DRILL_DIAMETERS = 10.0  # deepest hole: what a drill of DIN 338 makes with chips lifted out
PRESS_DEPTH_MM = 1.0  # a bearing seat ends in a lip of this thickness
CORNERS_MM = 1.6, 1.1, 0.8, 0.6  # radii of inner corners, the first that has room: cutters of 3, 2, 1.5 and 1 mm
THREAD_WALL_MM = 0.8
"""Least metal beside a thread, from its outer diameter to a face: a tap bulges or breaks through what is thinner.

Source: the least wall that shops cut in metal as a matter of course, super-ingenuity.cn/guides/cnc-design-guidelines
(read 2026-11-23). Where there is room a thread has twice that: three pitches, bjg-design.com/designbook (same day).
"""


def tenths_below(length_mm: float) -> float:
    """Rounds down to tenths of a millimetre what others only have to keep clear of: no function asks for more."""
    return floor(10.0 * length_mm + 1e-9) / 10.0


def tenths_above(length_mm: float) -> float:
    """Rounds up to tenths of a millimetre what only has to be long enough: a shop reads and sets whole tenths."""
    return ceil(10.0 * length_mm - 1e-9) / 10.0


def up(value: float, digits: int = 4) -> str:
    """Writes the least value that does, rounded up: what is read and typed does, too."""
    return _rounded(value, digits, ceil, -1e-9)


def down(value: float, digits: int = 4) -> str:
    """Writes the largest value that does, rounded down."""
    return _rounded(value, digits, floor, 1e-9)


def _rounded(value: float, digits: int, way: Callable[[float], int], slack: float) -> str:
    if value == 0.0 or not isfinite(value):
        return f"{value:g}"
    places = digits - 1 - floor(log10(abs(value)))
    return f"{round(way(value * 10.0**places + slack) / 10.0**places, max(places, 0)):.{digits}g}"


@dataclass(frozen=True)
class Reason:
    """Why a part cannot be made, with what would do.

    Attributes:
        part: Part number.
        feature: What of the part.
        message: Field, value and bound in words.
        field: Dotted path of the design's field to change; "" where a feature follows from several.
        value: Its value; None where there is no field.
        bound: The value that would do, in the field's unit or as the id of a row; None where none is known.
        beside: Fields that have to change with it, each with its value; where the bound is a figure of a row, the
            field with such a row.
        instead: A field that would do in its place, with its value.
    """

    part: str
    feature: str
    message: str
    field: str = ""
    value: float | str | None = None
    bound: float | str | None = None
    beside: tuple[tuple[str, float | str], ...] = ()
    instead: tuple[str, float] | None = None

    def __str__(self) -> str:
        return f"{self.part}, {self.feature}: {self.message}"


class DimensionError(ValueError):
    """Parts cannot be given sound dimensions; says of each which part, which feature and which bound.

    Attributes:
        reasons: All that were found.
        part: Part number of the first.
        feature: What of the part.
    """

    def __init__(self, reasons: Sequence[Reason]) -> None:
        self.reasons = tuple(reasons)
        self.part, self.feature = self.reasons[0].part, self.reasons[0].feature
        super().__init__("; ".join(map(str, self.reasons)))


_COLLECTED: ContextVar[list[Reason] | None] = ContextVar("reasons", default=None)


def require(
    holds: bool,
    part: str,
    feature: str,
    message: str,
    field: str = "",
    value: float | str | None = None,
    bound: float | str | None = None,
    instead: tuple[str, float] | None = None,
    beside: tuple[tuple[str, float | str], ...] = (),
) -> None:
    """Raises a DimensionError unless `holds`; inside `all_reasons` it notes the reason and goes on.

    Args:
        holds: The condition.
        part: As all that follows, of `Reason`.
        feature: What of the part.
        message: Field, value and bound in words.
        field: Dotted path of the design's field.
        value: Its value.
        bound: What would do.
        instead: Another field that would do.
        beside: Fields that have to change with it.
    """
    if holds:
        return
    reason, collected = Reason(part, feature, message, field, value, bound, beside, instead), _COLLECTED.get()
    if collected is None:
        raise DimensionError([reason])
    if reason not in collected:
        collected.append(reason)


@contextmanager
def all_reasons() -> Iterator[list[Reason]]:
    """Lets everything inside note its reasons, and raises them together at the end.

    What follows from a broken number may make no sense: an arithmetic error after a reason ends the search, and is not
    told.

    Raises:
        DimensionError: At least one was noted.
    """
    if (outer := _COLLECTED.get()) is not None:  # one search is going on: it takes these, too
        yield outer
        return
    collected: list[Reason] = []
    token = _COLLECTED.set(collected)
    try:
        yield collected
    except (ValueError, ZeroDivisionError, OverflowError, IndexError, TypeError):
        if not collected:
            raise
    finally:
        _COLLECTED.reset(token)
    if collected:
        raise DimensionError(collected)
