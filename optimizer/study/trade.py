"""The trades a designer may make: the front as required, and how it moves with the outline and with the joints' torque.

Each further front changes one requirement and keeps all others. A smaller or larger outline scales the bounds of L_A
and R along with it: where the requirements fix both, nothing could follow it otherwise.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from optimizer.problem.requirements import Requirements
from optimizer.problem.step import outline_of, step_problem
from optimizer.study.front import POINTS_MIN, Curve, FrontPoint, Tracer, described_conflict
from optimizer.synthesis.infeasible import InfeasibleError

OUTLINES = (0.9, 1.1)  # sizes of the outline beside the required one, as parts of its largest R + L_A
# Torques beside the required one, as parts of the range that the front as required needs.
TORQUES = (1.0 / 3.0, 2.0 / 3.0)
SHARE = 3  # the further fronts have one point for so many of the front as required
ROUND = 1000.0  # torques are given in whole mN m


@dataclass(frozen=True)
class Trade:
    """Several fronts.

    Attributes:
        main: As required.
        outlines: With another outline, ascending.
        torques: With less torque, ascending.
        finished: Whether all were traced to their end.
    """

    main: Curve
    outlines: tuple[Curve, ...] = ()
    torques: tuple[Curve, ...] = ()
    finished: bool = True

    @property
    def curves(self) -> tuple[Curve, ...]:
        """All of them, the one as required first."""
        return (self.main, *self.outlines, *self.torques)

    @property
    def torque_needed(self) -> float:
        """Largest torque for the force on the front as required, N m: a limit above it changes nothing."""
        return max((point.torque for point in self.main.points), default=math.nan)

    @property
    def knee(self) -> FrontPoint | None:
        """The point where a larger cube begins to cost more: farthest below the line from end to end in log kappa."""
        points = self.main.points
        if len(points) < 3:
            return None
        x = np.array([point.half_side for point in points])
        y = np.log([point.kappa for point in points])
        below = (x - x[0]) / (x[-1] - x[0]) - (y - y[0]) / (y[-1] - y[0])
        return points[int(np.argmax(below))] if below.max() > 0.0 else None


def trade(tracer: Tracer) -> Trade:
    """Traces the front as required and the further ones beside it.

    Returns:
        The fronts, as far as they came if the run was stopped.

    Raises:
        FrontError: As `Tracer.curve`.
        InfeasibleError: The requirements cannot be met together at any half side.
    """
    main, given = tracer.curve(), tracer.given
    outlines: list[Curve] = []
    torques: list[Curve] = []
    if main.finished:
        outlines = [further(tracer, scaled_outline(given, part), *_outline_name(given, part)) for part in OUTLINES]
    if main.finished and all(curve.finished for curve in outlines):
        for level in torque_levels(main):
            name, words = f"torque {level:g} N m", f"{level:g} N m for the force"
            torques.append(further(tracer, with_torque(given, level), name, words))
    curves = (main, *outlines, *torques)
    return Trade(main, tuple(outlines), tuple(torques), all(curve.finished for curve in curves))


def further(tracer: Tracer, given: Requirements, name: str, words: str) -> Curve:
    """Traces a front beside the one as required; where it is empty, its `beyond` names what contradicts each other."""
    other = replace(tracer, given=given, count=max(POINTS_MIN, tracer.count // SHARE), name=name, words=words)
    try:
        return other.curve()
    except InfeasibleError as error:
        return Curve(given, name, words, (), beyond=described_conflict(step_problem(given, error.step), error))


def largest_reach(given: Requirements) -> float:
    """Computes the largest R + L_A that the outline allows, mm; the rectangle either way round."""
    return outline_of(given).reach_max_mm


def scaled_outline(given: Requirements, part: float) -> Requirements:
    """Scales the outline of requirements: the largest R + L_A, and the bounds of both alike."""
    bounds = {
        name: tuple(part * value for value in getattr(given.bounds_mm, name))
        for name in ("upper_arm_length", "base_radius")
    }
    return given.model_copy(
        update={
            "bounds_mm": given.bounds_mm.model_copy(update=bounds),
            "limits": given.limits.model_copy(update={"outline_radius_max_mm": part * largest_reach(given)}),
        }
    )


def _outline_name(given: Requirements, part: float) -> tuple[str, str]:
    """Gives the name of a front with another outline, and its description."""
    return f"outline {part:g}", f"R + L_A <= {part * largest_reach(given):.4g} mm, bounds of R and L_A x {part:g}"


def with_torque(given: Requirements, level: float) -> Requirements:
    """Gives requirements so much torque, N m, for the force at each joint; gravity's share comes on top."""
    total = level + given.limits.gravity_torque_N_m
    return given.model_copy(update={"requirements": given.requirements.model_copy(update={"joint_torque_N_m": total})})


def torque_levels(main: Curve) -> list[float]:
    """Chooses torques in N m, ascending, below what the front needs and above what its smallest cube needs."""
    needed = [point.torque for point in main.points]
    if not needed:
        return []
    low, high = min(needed), max(needed)
    levels = sorted({round((low + part * (high - low)) * ROUND) / ROUND for part in TORQUES})
    return [level for level in levels if low < level < high]
