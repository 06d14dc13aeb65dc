"""Evaluates a published design by our equations: its faults, its figures, and what its own lengths allow."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from delta_cad.common.units import MM_PER_M
from delta_cad.mechanism import DeltaGeometry, direct_margin, inverse_jacobian, reach_excess
from delta_cad.mechanism.jacobian import velocity_map
from optimizer.globalopt.optimum import prove_optimum
from optimizer.paper.published import LETTERS, Lengths
from optimizer.problem.extremes import design_worst, worst_points
from optimizer.problem.step import Problem, step_problem
from optimizer.problem.variables import LENGTHS, PER_SI, mechanism_of
from optimizer.search.active_set import ROUNDING
from optimizer.search.result import FINE_GRID, Result, finite

GAP = 1e-5  # two-sided, of every optimum that is proved here
_ROOM_MM = (
    1e-3  # beyond the upper bound of H: table 9 row 3 lies on it and on the fold, where nothing is left to search
)


@dataclass(frozen=True)
class _Shortfall:
    """A constraint or bound that a published design does not keep.

    Attributes:
        name: The constraint, or the length that is out of its bounds.
        by: How much it lacks.
        unit: Its unit.
    """

    name: str
    by: float
    unit: str


@dataclass(frozen=True)
class Evaluation:
    """A published design by our equations, under the names that the JSON file has.

    Attributes:
        faults: What it does not keep of its own step.
        largest_half_side_mm: Largest half side that its own L_B, R, r allow in its step with the best H within the
            bounds; None in step 3.
        max_kappa: Worst condition number over its cube, 2-norm; None where it is infinite.
        max_kappa_frobenius: The same as |J| |J^-1| in Frobenius's norm.
        max_torque_N_m: Worst joint torque for the force; None where a chain is open or the cube singular.
    """

    faults: tuple[_Shortfall, ...]
    largest_half_side_mm: float | None
    max_kappa: float | None
    max_kappa_frobenius: float | None
    max_torque_N_m: float | None


def evaluate(problem: Problem, design_mm: Lengths, gap: float = GAP) -> Evaluation:
    """Evaluates a design, whether it keeps its constraints or not.

    Args:
        problem: The step that it was published for.
        design_mm: (6) lengths, mm.
        gap: Relative gap of the proof of the half side that its lengths allow.
    """
    result = Result(problem, "published", design_mm, "sampled")
    kappa = finite(result.max_kappa)
    return Evaluation(
        _shortfalls(problem, result),
        None if problem.step == 3 else largest_half_side(problem, design_mm, gap),
        kappa,
        None if kappa is None else _worst_frobenius(design_mm),
        finite(result.max_torque),
    )


def largest_half_side(problem: Problem, design_mm: Lengths, gap: float = GAP) -> float | None:
    """Computes the largest half side that a design's L_A, L_B, R, r allow with the best H within the bounds, mm.

    H is left free because step 1's optima lie on the fold, where a rounding of the printed H decides over reach.

    Args:
        problem: The step.
        design_mm: (6) lengths, mm; H and L count for nothing.
        gap: Relative gap of the proof.

    Returns:
        The half side, certified; None if no cube is allowed.
    """
    given = problem.requirements
    bounds = {name: (value, value) for name, value in zip(LENGTHS[:4], design_mm[:4], strict=True)}
    low, high = given.bounds_mm.bottom_height
    bounds |= {"bottom_height": (low, high + _ROOM_MM), "half_side": (0.0, given.bounds_mm.half_side[1])}
    free = given.model_copy(update={"bounds_mm": given.bounds_mm.model_copy(update=bounds)})
    return finite(prove_optimum(step_problem(free, problem.step), gap=gap).objective)


def _worst_frobenius(design_mm: Lengths) -> float:
    """Computes the largest |J| |J^-1| in Frobenius's norm over a cube without singularity; at least 3.

    Args:
        design_mm: (6) lengths, mm.
    """

    def values(points: np.ndarray) -> dict[str, np.ndarray]:
        at = _placed(design_mm, points)
        norms = [np.sqrt((m * m).sum(axis=(-2, -1))) for m in (velocity_map(*at), inverse_jacobian(*at))]
        return {"frobenius": -norms[0] * norms[1]}

    return -float(worst_points(values, FINE_GRID)["frobenius"].values[0])


def _placed(design_mm: Lengths, points: np.ndarray) -> tuple[DeltaGeometry, np.ndarray]:
    """Makes the mechanism of a design, mm, and positions, m, of (..., 3) points of its cube."""
    g, cube = mechanism_of(design_mm)
    return g, cube.half_side * points + cube.centre


def _shortfalls(problem: Problem, result: Result) -> tuple[_Shortfall, ...]:
    """Constraints and bounds that a result does not keep, in units that can be measured."""
    broken = {name for name, by in result.violations.items() if by > ROUNDING}
    design, faults = result.design_mm, []

    def worst(name: str) -> tuple[DeltaGeometry, np.ndarray]:
        return _placed(design, design_worst(problem, np.array(design) / PER_SI, FINE_GRID)[name].points)

    if "outline" in broken:
        limit = problem.requirements.limits.outline_radius_max_mm or math.inf
        faults.append(_Shortfall("outline", design[0] + design[2] - limit, "mm"))
    if "reach" in broken:
        faults.append(_Shortfall("reach", float(np.max(reach_excess(*worst("reach")))) * MM_PER_M, "mm"))
    if "torque" in broken and math.isfinite(result.max_torque):
        faults.append(_Shortfall("torque", result.max_torque - problem.torque_for_force, "N m"))
    elif "torque" in broken and "reach" not in broken:
        faults.append(_Shortfall("assembly_mode", -float(np.min(direct_margin(*worst("torque")))), ""))
    for letter, value, low, high in zip(LETTERS, design, problem.lower, problem.upper, strict=False):
        if not low <= value <= high:
            faults.append(_Shortfall(f"bounds of {letter}", max(low - value, value - high), "mm"))
    return tuple(faults)
