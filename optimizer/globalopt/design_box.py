"""The variables that figures depend on, L_A, L_B, a = R - r and H, and what of a problem holds in closed form.

R and r matter to outline and clearance alone, which only bound them: `R + L_A <= reach`, `r >= r_min`. So a pair of
them exists exactly for `a` between `R_low - r_high` and `min(R_high, reach - L_A) - max(r_low, r_min)`.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from optimizer.problem.step import LEAN_SHARE, MM_PER_M, SIDE, Problem

OUTWARDS = 1e-14
"""Share by which what is rounded is moved outwards; some ten roundings of 1e-16, among them that of mm to m."""


class Space(NamedTuple):
    """Where designs are looked for.

    Attributes:
        box: (2, 4) lower and upper ends of L_A, L_B, a, H, m, rounded outwards.
        sum_max: Largest L_A + a, m, rounded up; infinite where nothing asks for it.
        lean_share: L_B is at least this times L; 0 where no lean is asked. Rounded down.
        reach_max_mm: Largest R + L_A, mm; infinite likewise.
        platform_min_mm: Least r, mm.
    """

    box: np.ndarray
    sum_max: float
    lean_share: float
    reach_max_mm: float
    platform_min_mm: float


def space_of(problem: Problem) -> Space | None:
    """The space of a problem; None if outline, clearance and bounds alone leave nothing.

    Args:
        problem: The step.
    """
    limits = problem.requirements.limits
    (la, lb, R, r, H), high = problem.lower[:SIDE], problem.upper
    reach = _reach_max(problem) if "outline" in problem.constraints else math.inf
    least = r
    if "clearance" in problem.constraints and limits.clearance_min_mm is not None:
        room = limits.parallelogram_width_mm / 2.0 + limits.joint_diameter_mm + limits.clearance_min_mm
        least = max(r, room / math.sqrt(3.0) * (1.0 - OUTWARDS))
    la_high = min(high[0], (reach - R) * (1.0 + OUTWARDS))
    if la_high < la * (1.0 - OUTWARDS) or least > high[3]:
        return None
    low = [la, lb, R - high[3], H]
    top = [max(la_high, la), high[1], min(high[2], reach - la) - least, high[4]]
    sizes = np.array([high[0], high[1], high[2] + high[3], high[4]]) * OUTWARDS
    box = np.array([np.array(low) - sizes, np.array(top) + sizes]) / MM_PER_M
    if (box[0] > box[1]).any():
        return None
    total = (reach - least) / MM_PER_M
    lean = 0.0
    if "lean" in problem.constraints and limits.lean_max_deg is not None:
        lean = LEAN_SHARE / math.sin(math.radians(limits.lean_max_deg)) * (1.0 - OUTWARDS)
    return Space(box, total + OUTWARDS * abs(reach), lean, reach, least)


def design_of(problem: Problem, space: Space, point: np.ndarray, half_side_mm: float) -> np.ndarray:
    """A whole design for a point of the space: of the R that fit, the smallest.

    Args:
        problem: The step.
        space: Its space.
        point: (4,) L_A, L_B, a, H, m.
        half_side_mm: L.

    Returns:
        (6,) lengths in the order of `VARIABLES`, mm, within the bounds.
    """
    la, lb, a, height = np.asarray(point) * MM_PER_M
    R = max(problem.lower[2], space.platform_min_mm + a)
    return np.clip([la, lb, R, R - a, height, half_side_mm], problem.lower, problem.upper)


def _reach_max(problem: Problem) -> float:
    """Largest R + L_A that the outline allows either way round, mm, [RCIM2018] eq. (1)."""
    limits, task = problem.requirements.limits, problem.requirements.requirements
    if limits.outline_radius_max_mm is not None:
        return limits.outline_radius_max_mm
    width = limits.parallelogram_width_mm * 0.5 + limits.outline_overhead_mm[0]
    depth = limits.parallelogram_width_mm * math.sqrt(3.0) / 4.0 + limits.outline_overhead_mm[1]
    W, D = task.envelope_width_mm, task.envelope_depth_mm
    found = max(min((w - width) / math.sqrt(3.0), (d - depth) / 1.5) for w, d in ((W, D), (D, W)))
    return found + OUTWARDS * (W + D)
