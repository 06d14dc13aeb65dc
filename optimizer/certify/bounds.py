"""The tightest limits that can be proved of a cube: each figure's extreme at a point, and a proved bound beside it."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

from delta_cad.mechanism import Cube, DeltaGeometry, GeometryError
from delta_cad.mechanism.limits import FigureOfMerit, Limits, PoseLimit, Torque
from delta_cad.mechanism.proof.extremes import WorstFigure
from delta_cad.mechanism.proof.prove import Progress, prove

_NARROW = 1e-5  # first distance of a bound from the extreme found, as a share of it, or in rad: a few ms of proof
_ROUNDING = 1e-12  # added where a torque is brought from one force to another, in two roundings of 1e-16
_WIDER = 10.0
# Most boxes of one try; a bound that needs more is sought farther away, so that a tight certificate is replayed in
# seconds.
_MOST_BOXES = 20_000
_TRIES = 5  # the last distance is then 10 % or 0.1 rad


@dataclass(frozen=True)
class ProvedBound:
    """What is known of the extreme of one figure over the cube.

    Attributes:
        limit: Limit that measures the figure.
        figure: The figure.
        attained: The extreme found, SI units.
        point: Where it was found, m.
        proved: No point of the cube is beyond this; None where nothing could be proved.
    """

    limit: PoseLimit
    figure: FigureOfMerit
    attained: float
    point: tuple[float, float, float]
    proved: float | None


def bounds(
    g: DeltaGeometry, cube: Cube, worst: Sequence[WorstFigure], progress: Progress | None = None
) -> tuple[ProvedBound, ...]:
    """Proves each figure's extreme as tightly as the search for it allows.

    A point that the prover finds beyond what the search had found becomes the extreme.

    Args:
        g: The mechanism.
        cube: The cube.
        worst: What the search found, `worst_figures`.
        progress: Called now and then with the boxes examined and the share of the cube that is done.

    Returns:
        One for each figure that is finite in the whole cube; those that no threshold bounds without a proved bound.
    """
    return tuple(
        _bound(g, cube, one, progress)
        if one.figure.threshold
        else ProvedBound(one.limit, one.figure, one.value, one.position, None)
        for one in worst
        if math.isfinite(one.value)
    )


def tightened(limits: Limits, proved_bounds: tuple[ProvedBound, ...]) -> Limits:
    """Makes every limit as tight as a bound is proved, wherever that is stricter than the limit given.

    Args:
        limits: The limits given; what they leave out is added.
        proved_bounds: The bounds.
    """
    tight = limits
    for one in proved_bounds:
        if one.proved is None:
            continue
        limit = tight.get(type(one.limit))
        if limit is None:
            tight = tight.with_(one.limit.with_bound(one.figure, one.proved))
            continue
        proved = one.proved
        if isinstance(limit, Torque) and isinstance(one.limit, Torque):  # found for another force
            proved = proved / one.limit.force * limit.force * (1.0 + _ROUNDING)
        tight = tight.with_(limit.with_bound(one.figure, one.figure.stricter(limit.bound(one.figure), proved)))
    return tight


def _bound(g: DeltaGeometry, cube: Cube, worst: WorstFigure, progress: Progress | None) -> ProvedBound:
    limit, figure, value, point = worst
    distance = _NARROW
    for _ in range(_TRIES):
        away = distance * (value if figure.relative else 1.0)
        edge = value + away if figure.upper else value - away
        try:
            limits = Limits.of(limit.with_bound(figure, edge))
        except GeometryError:  # no limit can say that
            break
        proof = prove(g, cube, limits, max_boxes=_MOST_BOXES, progress=progress)
        finding = next(f for f in proof.findings if f.condition == limit.name)
        if finding.verdict == "proved":
            return ProvedBound(limit, figure, value, point, edge)
        if finding.point is not None and finding.value is not None and math.isfinite(finding.value):
            value, point = finding.value, finding.point
        else:
            distance *= _WIDER
    return ProvedBound(limit, figure, value, point, None)
