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


def ceil_sig(value: float) -> str:
    """Writes a lower bound to four significant digits, rounded up: what is read and typed keeps it, too."""
    if value == 0.0 or not isfinite(value):
        return f"{value:g}"
    places = 3 - floor(log10(abs(value)))
    return f"{round(ceil(value * 10.0**places - 1e-9) / 10.0**places, max(places, 0)):.4g}"


@dataclass(frozen=True)
class Way:
    """Fields of a design that are changed together; how far is for a threshold search to find.

    Attributes:
        fields: Dotted paths.
        larger: Whether they grow; None: either way, or another row of a family.
    """

    fields: tuple[str, ...]
    larger: bool | None = None


def larger(*fields: str) -> Way:
    """Gives fields that grow together."""
    return Way(fields, True)


def smaller(*fields: str) -> Way:
    """Gives fields that shrink together."""
    return Way(fields, False)


def another(*families: str) -> tuple[Way, ...]:
    """Gives families of the catalogue of each of which another row may be taken."""
    return tuple(Way((f"hardware.{name}",)) for name in families)


BASE, PLATFORM = "mechanism.base_radius_mm", "mechanism.platform_radius_mm"
ARM, FOREARM, WIDTH = (f"mechanism.{name}_mm" for name in ("upper_arm_length", "forearm_length", "parallelogram_width"))
SECTOR, RATIO, BOTTOM = "hardware.sector_radius_mm", "hardware.capstan_ratio", "cube.bottom_height_mm"
HEIGHT = "requirements.height_max_mm"
ARM_THICKNESS, PLATFORM_THICKNESS = "hardware.arm_thickness_mm", "hardware.platform_thickness_mm"
FARTHER_OUT = larger(BASE), larger(BASE, PLATFORM)  # what parts neighbouring chains
SWINGS_LESS = larger(ARM), larger(BOTTOM)  # what lets an arm swing over a smaller angle


@dataclass(frozen=True)
class Reason:
    """Why a part cannot be made.

    Attributes:
        part: Part number.
        feature: What of the part.
        message: What was computed and what it is held to, in words.
        ways: What may be changed, the likeliest first; how far is for `delta_cad.structure.hardware.thresholds`.
        margin: Of a load that is too large: what the part bears over it, less than 1; None of anything else.
    """

    part: str
    feature: str
    message: str
    ways: tuple[Way, ...] = ()
    margin: float | None = None

    def __str__(self) -> str:
        return f"{self.part}, {self.feature}: {self.message}"

    @property
    def key(self) -> tuple[str, str]:
        """Which reason it is, whatever the figures."""
        return self.part, self.feature

    @property
    def field(self) -> str:
        """The first field of the likeliest change; "" where nothing may be changed."""
        return self.ways[0].fields[0] if self.ways else ""


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


def require(holds: bool, part: str, feature: str, message: str, *ways: Way) -> None:
    """Raises a DimensionError unless `holds`; inside `all_reasons` it notes the reason and goes on.

    Args:
        holds: The condition.
        part: As all that follows, of `Reason`.
        feature: What of the part.
        message: What was computed and what it is held to, in words.
        ways: What may be changed.
    """
    if holds:
        return
    reason, collected = Reason(part, feature, message, ways), _COLLECTED.get()
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


def reasons_of(make: Callable[[], object]) -> tuple[Reason, ...]:
    """Gives the reasons why something cannot be made, none of which is noted for who asks."""
    token = _COLLECTED.set(None)
    try:
        with all_reasons():
            make()
    except DimensionError as error:
        return error.reasons
    finally:
        _COLLECTED.reset(token)
    return ()
