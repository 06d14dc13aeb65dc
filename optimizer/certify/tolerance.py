"""The largest tolerance of a machine's lengths within which its limits are proved, and what a larger one would need."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, NamedTuple

from delta_cad.common.units import MM_PER_M
from delta_cad.mechanism import Cube, DeltaGeometry, GeometryError
from delta_cad.mechanism.geometry import largest_tolerance as most_of
from delta_cad.mechanism.limits import FigureOfMerit, Limits, PoseLimit, Reach

if TYPE_CHECKING:
    from delta_cad.mechanism.proof.prove import Progress

_USUAL = 0.05 / MM_PER_M  # m; what milled parts and bonded rods keep without effort; told where less is proved
CLOSE = 1.01  # the largest is found to 1 %
LEAST = 1e-9 / MM_PER_M  # a millionth of a micrometre: below it roundings rule
_DIGITS = 4  # of a tolerance in mm, so that the one told is the one proved
_MOST_BOXES = 200_000  # of one try; a second or two
# First distance of a threshold that is tried, as a share of it, or in rad; it is doubled from there.
_NEAREST = 1e-6
_TOGETHER = 20  # tenths by which two ends of a range are moved on until they are proved together


class Need(NamedTuple):
    """What one limit would have to be.

    Attributes:
        condition: Its name.
        figure: Which of its figures.
        bound: The threshold with which it is proved, SI units; None where no threshold is enough.
    """

    condition: str
    figure: FigureOfMerit
    bound: float | None


@dataclass(frozen=True)
class LargestTolerance:
    """The largest tolerance that is proved.

    Attributes:
        tolerance: m; 0 where none is.
        first: The conditions that are not proved with 1 % more; empty where the largest that can be asked is proved.
        requested: The tolerance that `needs` is about, m.
        needs: What the conditions that are not proved with that one would need.
        late: For what the time was over: for the largest, which is then that proved so far, or for the needs, of which
            there are then none; "" where it was enough.
    """

    tolerance: float
    first: tuple[str, ...]
    requested: float
    needs: tuple[Need, ...]
    late: Literal["", "largest", "needs"] = ""


class _TimeOverError(Exception):
    """The time was over before a proof came to its end."""


class _Watch:
    """Reports progress of proofs and remembers whether their time is over."""

    def __init__(self, progress: Progress | None) -> None:
        self._progress, self.over = progress, False

    def __call__(self, boxes: int, share: float) -> bool:
        self.over = self.over or (self._progress is not None and bool(self._progress(boxes, share)))
        return self.over


def search_tolerance(
    g: DeltaGeometry,
    cube: Cube,
    limits: Callable[[float], Limits],
    requested: float | None = None,
    progress: Progress | None = None,
) -> LargestTolerance:
    """Finds the largest tolerance with which all limits are proved, and what limits the one asked would need.

    Args:
        g: The mechanism.
        cube: The cube.
        limits: Tolerance in m -> the limits with it, from which gravity's share is taken off; at 0 they hold.
        requested: A tolerance that somebody wants, m; None: `_USUAL`.
        progress: Called now and then with the boxes examined and the share of the cube that is done; what it returns
            ends the search if it is true, with what it has reached.

    Returns:
        The largest, to 1 %.
    """
    low, high, first = 0.0, most_of(g), ()
    wanted, watch = _USUAL if requested is None else requested, _Watch(progress)
    try:
        first = _unproved(g, cube, limits(high), high, watch)
        if not first:
            return LargestTolerance(high, (), high, ())
        while high > low * CLOSE and high >= LEAST:
            tried = float(f"{(math.sqrt(low * high) if low else 0.1 * high) * MM_PER_M:.{_DIGITS}g}") / MM_PER_M
            missing = _unproved(g, cube, limits(tried), tried, watch)
            if missing:
                high, first = tried, missing
            else:
                low = tried
    except _TimeOverError:
        return LargestTolerance(low, first, wanted, (), "largest")
    limited = limits(wanted)
    try:
        missing = () if wanted <= low else _unproved(g, cube, limited, wanted, watch)
        needs = tuple(need for name in missing for need in _needs(g, cube, limited[name], wanted, watch))
    except _TimeOverError:
        return LargestTolerance(low, first, wanted, (), "needs")
    return LargestTolerance(low, first, wanted, needs)


def _unproved(g: DeltaGeometry, cube: Cube, limits: Limits, tolerance: float, watch: _Watch) -> tuple[str, ...]:
    """Names of the conditions that are not proved within a tolerance, each by itself where reach ends the proof.

    Raises:
        _TimeOverError: The time was over before, or ended the proof, and some condition is undecided.
    """
    from delta_cad.mechanism.proof.prove import prove

    def missing(requested: Limits) -> tuple[str, ...]:
        if watch.over:
            raise _TimeOverError
        proof = prove(g, cube, requested, tolerance=tolerance, max_boxes=_MOST_BOXES, progress=watch)
        if watch.over and proof.verdict == "undecided":
            raise _TimeOverError
        return tuple(f.condition for f in proof.findings if f.verdict != "proved")

    found = missing(limits)
    if Reach.name in found and not missing(Limits.of()):  # the chains close, but not as far from a fold as asked
        return tuple(name for name in found if name == Reach.name or missing(Limits.of(limits[name])))
    return found


def _needs(g: DeltaGeometry, cube: Cube, limit: PoseLimit, tolerance: float, watch: _Watch) -> list[Need]:
    """Finds relaxed thresholds of the figures that are not proved alone, such that all are proved together."""

    def proved(requested: PoseLimit) -> bool:
        return not _unproved(g, cube, Limits.of(requested), tolerance, watch)

    found = []
    for figure in limit.figures:
        if not figure.threshold:
            return [] if proved(limit) else [Need(limit.name, figure, None)]
        alone = limit.only(figure)
        if not proved(alone):
            found.append(Need(limit.name, figure, _enough(alone, figure, proved)))
    if len(limit.figures) == 1 or any(need.bound is None for need in found):
        return found
    for _ in range(_TOGETHER):  # both ends of a range, of which each may cost the other a little
        together = limit
        for need in found:
            together = together.with_bound(need.figure, need.bound or 0.0)
        if proved(together):
            return found
        found = [
            need._replace(bound=(need.bound or 0.0) + 0.1 * ((need.bound or 0.0) - limit.bound(need.figure)))
            for need in found
        ]
    return [need._replace(bound=None) for need in found]


def _enough(limit: PoseLimit, figure: FigureOfMerit, proved: Callable[[PoseLimit], bool]) -> float | None:
    """The threshold nearest to the limit's, to a tenth of the distance, with which it is proved; None if none is."""
    bound = limit.bound(figure)
    unit = (1.0 if figure.upper else -1.0) * (max(abs(bound), 1e-6) if figure.relative else 1.0)

    def holds(distance: float) -> bool:
        try:
            return proved(limit.with_bound(figure, bound + unit * distance))
        except GeometryError:  # no limit can say that
            return False

    low, high = 0.0, _NEAREST
    while not holds(high):
        low, high = high, 2.0 * high
        if not figure.range[0] <= bound + unit * high <= figure.range[1]:
            return None
    while high > max(1.1 * low, _NEAREST):
        middle = math.sqrt(low * high)
        low, high = (low, middle) if holds(middle) else (middle, high)
    return bound + unit * high
