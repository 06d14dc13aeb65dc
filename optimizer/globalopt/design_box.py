"""The variables that figures depend on, L_A, L_B, a = R - r and H, and what of a problem holds in closed form.

R and r matter to outline and clearance alone, which only bound them: `R + L_A <= reach`, `r >= r_min`. So a pair of
them exists exactly for `a` between `R_low - r_high` and `min(R_high, reach - L_A) - max(r_low, r_min)`.
"""

from __future__ import annotations

from functools import reduce
from typing import NamedTuple

import numpy as np

from delta_cad.common.units import MM_PER_M
from delta_cad.mechanism.limits import DesignBounds
from delta_cad.mechanism.limits.lengths.outline import OUTWARDS
from optimizer.problem.step import Problem
from optimizer.problem.variables import SIDE, completed


class DesignBox(NamedTuple):
    """The box in which designs are searched.

    Attributes:
        box: (2, 4) lower and upper ends of L_A, L_B, a, H, m, rounded outwards.
        sum_max: Largest L_A + a, m, rounded up; infinite where nothing asks for it.
        sum_min: Least L_A + a, m, rounded down; minus infinity likewise.
        forearm_per_half_side_min: L_B is at least this times L; 0 without a limit of lean. Rounded down.
        reach_max_mm: Largest R + L_A, mm; infinite likewise.
        platform_min_mm: Least r, mm.
    """

    box: np.ndarray
    sum_max: float
    sum_min: float
    forearm_per_half_side_min: float
    reach_max_mm: float
    platform_min_mm: float

    def cube_limits(self, side: float) -> np.ndarray:
        """Gives the numbers that `branch_and_bound.search` takes for a half side, m."""
        return np.array([side, self.sum_max, self.forearm_per_half_side_min * side, self.sum_min])


def design_box(problem: Problem) -> DesignBox | None:
    """Computes the box of designs of a problem; None if outline, clearance and bounds alone leave nothing."""
    (la, lb, R, r, H), high = problem.lower[:SIDE], problem.upper
    bounds = reduce(DesignBounds.both, (limit.design_bounds() for limit in problem.limits), DesignBounds())
    reach, least = bounds.reach_max_mm, max(r, bounds.platform_radius_min_mm)
    la_high = min(high[0], (reach - R) * (1.0 + OUTWARDS))
    if la_high < la * (1.0 - OUTWARDS) or least > high[3]:
        return None
    low = [la, lb, R - high[3], H]
    top = [max(la_high, la), high[1], min(high[2], reach - la) - least, high[4]]
    sizes = np.array([high[0], high[1], high[2] + high[3], high[4]]) * OUTWARDS
    box = np.array([np.array(low) - sizes, np.array(top) + sizes]) / MM_PER_M
    if (box[0] > box[1]).any():
        return None
    total = (reach - least + OUTWARDS * abs(reach)) / MM_PER_M
    level = (bounds.level_elbow_min_mm - float(sizes.sum())) / MM_PER_M
    return DesignBox(box, total, level, bounds.forearm_per_half_side_min, reach, least)


def design_of(problem: Problem, designs: DesignBox, point: np.ndarray, half_side_mm: float) -> np.ndarray:
    """Completes a point of the design box to a design, with the smallest R that fits.

    Args:
        problem: The step.
        designs: Its design box.
        point: (4,) L_A, L_B, a, H, m.
        half_side_mm: L.

    Returns:
        (9,) in the order of `VARIABLES`, mm, within the bounds.
    """
    la, lb, a, height = np.asarray(point) * MM_PER_M
    R = max(problem.lower[2], designs.platform_min_mm + a)
    return np.clip(completed([la, lb, R, R - a, height, half_side_mm]), problem.lower, problem.upper)
