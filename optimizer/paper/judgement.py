"""A published design by our equations: what it keeps, what it is worth, and what its own lengths allow."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from delta_cad.mechanism import DeltaGeometry, direct_margin, inverse_jacobian, reach_excess
from delta_cad.mechanism.jacobian import velocity_map
from optimizer.globalopt.optimum import prove_optimum
from optimizer.paper.cases import LETTERS, Lengths
from optimizer.problem.evaluator import VARIABLES
from optimizer.problem.extremes import design_worst, worst_points
from optimizer.problem.step import MM_PER_M, Problem, step_problem
from optimizer.search.active_set import ROUNDING
from optimizer.search.result import FINE_GRID, Result

GAP = 1e-5
"""Two-sided, of every optimum that is proved here."""
ROOM_MM = 1e-3
"""Beyond the upper bound of H: table 9 row 3 lies on it and on the fold, where nothing is left to search."""


@dataclass(frozen=True)
class Fault:
    """A constraint or bound that a published design does not keep.

    Attributes:
        name: Of the constraint, or the letter of the length that is out of its bounds.
        by: How much it lacks.
        unit: Of that.
    """

    name: str
    by: float
    unit: str


@dataclass(frozen=True)
class Judged:
    """A published design by our equations.

    Attributes:
        design_mm: (6) as printed.
        faults: What it does not keep of its own step.
        largest_mm: Largest half side that its own L_B, R, r allow in its step with the best H within the bounds; None
            in step 3.
        kappa: Worst condition number over its cube, 2-norm; None where it is infinite.
        kappa_frobenius: The same as |J| |J^-1| in Frobenius's norm.
        torque_N_m: Worst joint torque for the force; None where a chain is open or the cube singular.
    """

    design_mm: Lengths
    faults: tuple[Fault, ...]
    largest_mm: float | None
    kappa: float | None
    kappa_frobenius: float | None
    torque_N_m: float | None


def judge(problem: Problem, design_mm: Lengths, gap: float = GAP) -> Judged:
    """A design by our equations, whether it keeps its constraints or not.

    Args:
        problem: Its step.
        design_mm: (6) lengths, mm.
        gap: Relative, of the half side that its lengths allow.

    Returns:
        The judgement.
    """
    result = Result(problem, "published", design_mm, "sampled")
    kappa = _finite(result.max_kappa)
    return Judged(
        design_mm,
        _faults(problem, result),
        None if problem.step == 3 else largest_half_side(problem, design_mm, gap),
        kappa,
        None if kappa is None else worst_frobenius(design_mm),
        _finite(result.max_torque),
    )


def largest_half_side(problem: Problem, design_mm: Lengths, gap: float = GAP) -> float | None:
    """Largest half side that a design's L_A, L_B, R, r allow with the best H within the bounds, mm.

    H is left free because step 1's optima lie on the fold, where a rounding of the printed H decides over reach.

    Args:
        problem: The step.
        design_mm: (6) lengths, mm; H and L count for nothing.
        gap: Relative, of the proof.

    Returns:
        The half side, certified; None if no cube is allowed.
    """
    given = problem.requirements
    pinned = {name: (value, value) for name, value in zip(VARIABLES[:4], design_mm[:4], strict=True)}
    low, high = given.bounds_mm.bottom_height
    free = {"bottom_height": (low, high + ROOM_MM), "half_side": (0.0, given.bounds_mm.half_side[1])}
    bounds = given.bounds_mm.model_copy(update=pinned | free)
    proven = prove_optimum(step_problem(given.model_copy(update={"bounds_mm": bounds}), problem.step), gap=gap)
    return _finite(proven.objective)


def worst_frobenius(design_mm: Lengths) -> float:
    """Largest |J| |J^-1| in Frobenius's norm over a cube without singularity; at least 3.

    Args:
        design_mm: (6) lengths, mm.

    Returns:
        The product.
    """
    g = geometry_of(design_mm)

    def values(points: np.ndarray) -> dict[str, np.ndarray]:
        p = positions_of(design_mm, points)
        norms = [np.sqrt((m * m).sum(axis=(-2, -1))) for m in (velocity_map(g, p), inverse_jacobian(g, p))]
        return {"frobenius": -norms[0] * norms[1]}

    return -float(worst_points(values, FINE_GRID)["frobenius"].values[0])


def geometry_of(design_mm: Lengths) -> DeltaGeometry:
    """The mechanism of six lengths."""
    L_A, L_B, R, r = (x / MM_PER_M for x in design_mm[:4])
    return DeltaGeometry(base_radius=R, platform_radius=r, upper_arm_length=L_A, forearm_length=L_B)


def positions_of(design_mm: Lengths, points: np.ndarray) -> np.ndarray:
    """Points in the coordinates of a cube, (..., 3), as positions in m."""
    H, L = design_mm[4] / MM_PER_M, design_mm[5] / MM_PER_M
    return L * points + np.array([0.0, 0.0, H + L])


def _faults(problem: Problem, result: Result) -> tuple[Fault, ...]:
    """Constraints and bounds that a result does not keep, in units that can be measured."""
    faults = []
    broken = {name for name, by in result.violations.items() if by > ROUNDING}
    design = result.design_mm
    row = np.array(design) / MM_PER_M
    if "outline" in broken:
        limit = problem.requirements.limits.outline_radius_max_mm or math.inf
        faults.append(Fault("outline", design[0] + design[2] - limit, "mm"))
    if "reach" in broken:
        points = design_worst(problem, row, FINE_GRID)["reach"].points
        excess = reach_excess(geometry_of(design), positions_of(design, points))
        faults.append(Fault("reach", float(np.max(excess)) * MM_PER_M, "mm"))
    if "torque" in broken:
        if math.isfinite(result.max_torque):
            faults.append(Fault("torque", result.max_torque - problem.torque_for_force, "N m"))
        elif "reach" not in broken:
            points = design_worst(problem, row, FINE_GRID)["torque"].points
            margin = float(np.min(direct_margin(geometry_of(design), positions_of(design, points))))
            faults.append(Fault("singularity", -margin, ""))
    for letter, value, low, high in zip(LETTERS, design, problem.lower, problem.upper, strict=True):
        beyond = max(low - value, value - high)
        if beyond > 0.0:
            faults.append(Fault(f"bounds of {letter}", beyond, "mm"))
    return tuple(faults)


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
