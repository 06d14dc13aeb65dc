"""The tightest limits that can be proved of a cube: each figure's extreme at a point, and a proved bound beside it."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace

from delta_cad.mechanism import Cube, CubeExtremes, DeltaGeometry
from delta_cad.mechanism.proof.findings import Finding
from delta_cad.mechanism.proof.limits import Limits

NARROW = 1e-5
"""First distance of a bound from the extreme found, as a share of it, or in rad: a few ms of proof."""
ROUNDING = 1e-12
"""Added where a torque is brought from one force to another, in two roundings of 1e-16."""
WIDER = 10.0
MOST_BOXES = 20_000
"""Of one try; a bound that needs more is sought farther away, so that a tight certificate is replayed in seconds."""
TRIES = 5
"""The last distance is then 10 % or 0.1 rad."""
Progress = Callable[[int, float], None]


@dataclass(frozen=True)
class Bound:
    """What is known of the extreme of one figure over the cube.

    Attributes:
        figure: `reach`, `torque`, `kappa`, `shoulder_min`, `shoulder_max` or `lean`.
        attained: The extreme found, SI units.
        point: Where it was found, m.
        proved: No point of the cube is beyond this; None where nothing could be proved.
    """

    figure: str
    attained: float
    point: tuple[float, float, float]
    proved: float | None


def bounds(
    g: DeltaGeometry, cube: Cube, force: float, extremes: CubeExtremes, progress: Progress | None = None
) -> tuple[Bound, ...]:
    """Proves each figure's extreme as tightly as the search for it allows.

    A point that the prover finds beyond what the search had found becomes the extreme.

    Args:
        g: The mechanism.
        cube: The cube.
        force: That the torque is for, N.
        extremes: What the search found, `cube_extremes`.
        progress: Called now and then with the boxes examined and the share of the cube that is done.

    Returns:
        One for each figure that is finite in the whole cube.
    """
    e = extremes
    found = {
        "reach": (math.sqrt(max(0.0, e.closure_margin_min.value)), e.closure_margin_min.position),
        "torque": e.torque_max,
        "kappa": e.kappa_max,
        "shoulder_min": e.shoulder_min,
        "shoulder_max": e.shoulder_max,
        "lean": e.lean_max,
    }
    return tuple(
        _bound(g, cube, force, name, value, point, progress)
        for name, (value, point) in found.items()
        if math.isfinite(value)
    )


def tightened(asked: Limits, force: float, found: tuple[Bound, ...]) -> Limits:
    """Every limit as tight as a bound is proved, wherever that is stricter than what is asked.

    Args:
        asked: The conditions; what they leave out is added.
        force: That the bounds' torque is for, N.
        found: The bounds.

    Returns:
        The conditions.
    """
    proved = {bound.figure: bound.proved for bound in found if bound.proved is not None}
    low, high = asked.shoulder or (-math.pi, math.pi)
    least, most = max(low, proved.get("shoulder_min", low)), min(high, proved.get("shoulder_max", high))
    torque = asked.torque_max
    if "torque" in proved and asked.force is not None and torque is not None:
        torque = min(torque, proved["torque"] / force * asked.force * (1.0 + ROUNDING))
    return replace(
        asked,
        elbow_arm_min=max(asked.elbow_arm_min, proved.get("reach", 0.0)),
        torque_max=torque,
        kappa_max=_least(asked.kappa_max, proved.get("kappa")),
        shoulder=(least, most),
        lean_max=_least(asked.lean_max, proved.get("lean")),
    )


def _least(*limits: float | None) -> float | None:
    """The smallest of those that are there."""
    return min((x for x in limits if x is not None), default=None)


def _bound(
    g: DeltaGeometry,
    cube: Cube,
    force: float,
    name: str,
    value: float,
    point: tuple[float, float, float],
    progress: Progress | None,
) -> Bound:
    from delta_cad.mechanism.proof.prove import prove

    distance = NARROW
    for _ in range(TRIES):
        limits, proved = _limits(name, value, distance, force)
        if limits is None:
            break
        finding = _finding(prove(g, cube, limits, max_boxes=MOST_BOXES, progress=progress).findings, name)
        if finding.verdict == "proved":
            return Bound(name, value, point, proved)
        if finding.point is not None and finding.value is not None and math.isfinite(finding.value):
            value, point = finding.value, finding.point
        else:
            distance *= WIDER
    return Bound(name, value, point, None)


def _finding(findings: tuple[Finding, ...], name: str) -> Finding:
    return next(f for f in findings if f.condition == name.split("_")[0])


def _limits(name: str, value: float, distance: float, force: float) -> tuple[Limits | None, float]:
    """The condition that a figure stays within a distance of its extreme; None where no limit can say that."""
    only = Limits(singularity=False)
    if name == "reach":
        least = value * (1.0 - distance)
        return replace(only, elbow_arm_min=least), least
    if name == "torque":
        most = value * (1.0 + distance)
        return (replace(only, force=force, torque_max=most) if 1e-6 <= most <= 1e6 else None), most
    if name == "kappa":
        most = value * (1.0 + distance)
        return (replace(only, kappa_max=most) if most <= 1e6 else None), most
    if name == "lean":
        most = value + distance
        return (replace(only, lean_max=most) if most < math.pi / 2.0 else None), most
    if name == "shoulder_min":
        least = value - distance
        return (replace(only, shoulder=(least, math.pi)) if least >= -math.pi else None), least
    most = value + distance
    return (replace(only, shoulder=(-math.pi, most)) if most <= math.pi else None), most
