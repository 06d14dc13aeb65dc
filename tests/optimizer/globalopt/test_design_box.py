"""The space of designs holds every design within the bounds, in exact fractions of what the requirements say in mm."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from optimizer.globalopt.design_box import design_box
from optimizer.problem.step import step_problem
from tests.optimizer.tasks import task

WIDE = 1e-11
"""m; more than all that is moved outwards here, 1e-14 of lengths in m and in mm, and less than anybody measures."""


def metres(mm: float) -> Fraction:
    return Fraction(mm) / 1000


@pytest.mark.parametrize("seed", range(3))
def test_the_space_is_rounded_outwards_and_hardly_wider(seed: int) -> None:
    rng, fixed = np.random.default_rng(seed), 0
    limits = {"parallelogram_width_mm": 20.0}  # no platform is too small for its balls
    for _ in range(200):
        low = rng.uniform([60, 40, 30, 15, 20], [90, 90, 45, 30, 60])
        high = low + rng.uniform(0.0, 60.0, 5) * rng.integers(0, 2, 5)
        fixed += int((low == high).sum())
        reach = float(rng.uniform(low[0] + low[2], high[0] + high[2] + 5.0))
        la, lb, R, r, H = ((float(a), float(b)) for a, b in zip(low, high, strict=True))
        space = design_box(step_problem(task(lb, r, H, (0, 50), R, la, limits | {"outline_radius_max_mm": reach}), 1))
        assert space is not None
        exact = np.array(
            [
                [metres(la[0]), metres(lb[0]), metres(R[0]) - metres(r[1]), metres(H[0])],
                [
                    min(metres(la[1]), metres(reach) - metres(R[0])),
                    metres(lb[1]),
                    min(metres(R[1]), metres(reach) - metres(la[0])) - metres(r[0]),
                    metres(H[1]),
                ],
            ]
        )
        box = np.array([[Fraction(x) for x in side] for side in space.box.tolist()])
        assert (box[0] <= exact[0]).all()
        assert (box[1] >= exact[1]).all()
        assert abs(box - exact).max() < WIDE
        # of all R + L_A <= reach, the largest L_A + R - r
        assert 0 <= Fraction(space.sum_max) - (metres(reach) - metres(r[0])) < 2e-14 * metres(reach)
    assert fixed > 100  # lengths that are given are rounded, too
