"""The space of designs whose placement is free, and what of a problem holds in closed form over it.

Figures depend on seven variables: L_A, L_B, a = R_0 - r, H, R_1 - R_0, the cosine c of the azimuth and x_c. R_0 and r
matter to outline and clearance alone, as for symmetric designs: r is at least what the bounds and the clearance of the
wrists want, and the rest is asked of `R_0 >= a + r`. README (13) of this package.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from delta_cad.mechanism.limits import ElbowOutside, Lean, Outline, WristClearance
from optimizer.globalopt.placed_cuts import OUTWARDS
from optimizer.problem.step import Problem
from optimizer.problem.variables import COSINE, PER_SI

_M = 1e-3  # m a mm


class PlacedBox(NamedTuple):
    """The box in which placed designs are searched, one way round of the outline.

    Attributes:
        box: (2, 7) lower and upper ends of L_A, L_B, a, H, R_1 - R_0, m, c and x_c, m, rounded outwards.
        numbers: (14,) of `placed_cuts`, m; the first is L.
    """

    box: np.ndarray
    numbers: np.ndarray

    def cube_limits(self, side: float) -> np.ndarray:
        """Gives the numbers of `placed_cuts` for a half side, m."""
        return np.array([side, *self.numbers[1:]])


def placed_boxes(problem: Problem) -> list[PlacedBox]:
    """Computes the boxes of designs of a problem, one for each way round of the outline that there is."""
    low, high = np.array(problem.lower) / PER_SI, np.array(problem.upper) / PER_SI
    wrists = [limit for limit in problem.limits if isinstance(limit, WristClearance)]
    joint = max((one.clearance_min_mm + one.joint_diameter_mm for one in wrists), default=-math.inf) * _M
    width = max((one.parallelogram_width_mm for one in wrists), default=0.0) * _M
    lean = next((limit for limit in problem.limits if isinstance(limit, Lean)), None)
    outline = next((limit for limit in problem.limits if isinstance(limit, Outline)), None)
    ways: list[tuple[float, float]] = [(math.inf, math.inf)]
    radius, bar = math.inf, 0.0
    if outline is not None and outline.radius_max_mm is not None:
        radius = outline.radius_max_mm * _M
    elif outline is not None:
        (over_w, over_d), sides = outline.overhead_mm, (outline.width_mm, outline.depth_mm)
        bar = outline.parallelogram_width_mm * _M
        ways = [((w - over_w) * _M, (d - over_d) * _M) for w, d in dict.fromkeys((sides, sides[::-1]))]
    r = (low[3], high[3])
    box = np.array(
        [
            [low[0], low[1], low[2] - r[1], low[4], low[6], low[7], low[8]],
            [high[0], high[1], high[2] - r[0], high[4], high[6], high[7], high[8]],
        ]
    )
    box += np.array([[-1.0], [1.0]]) * OUTWARDS * (np.abs(box).max(axis=0) + r[1]) * (box[0] < box[1])
    sine = 0.0 if lean is None else math.sin(lean.lean_max) * (1.0 + OUTWARDS)
    level = 0.0 if any(isinstance(limit, ElbowOutside) for limit in problem.limits) else -math.inf
    return [
        PlacedBox(
            box,
            np.array([0.0, joint, width, *way, bar, radius, r[0], r[1], low[2], high[2], sine, level, 0.0]),
        )
        for way in ways
    ]


def placed_design(problem: Problem, space: PlacedBox, point: np.ndarray, half_side_mm: float) -> np.ndarray:
    """Completes a point of the box to a design, with the smallest r and R_0 that fit.

    Args:
        problem: The step.
        space: Its box.
        point: (7,) as of `PlacedBox.box`.
        half_side_mm: L.

    Returns:
        (9,) in the order of `VARIABLES`, mm, within the bounds.
    """
    la, lb, a, height, shift, c, x = np.asarray(point)
    joint, width, least = space.numbers[1], space.numbers[2], space.numbers[7]
    s = math.sqrt((1.0 - c) * (1.0 + c))
    if joint > -math.inf:
        least = max(least, (joint + math.sqrt((1.0 + c) / 2.0) * width) / math.sqrt(2.0 - 2.0 * c))
        least = max(least, (joint + abs(c) * width) / (2.0 * s))
    R = max(space.numbers[9], least + a)
    found = np.array([la, lb, R, R - a, height, 0.0, shift, c, x]) * PER_SI
    found[5], found[COSINE] = half_side_mm, c
    return np.clip(found, problem.lower, problem.upper)
