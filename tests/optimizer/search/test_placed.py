"""SQP with the placement free: the joystick's cube beside the symmetric one, judged without the search's formulas."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest

from optimizer.problem.evaluator import half_surface
from optimizer.problem.step import step_problem
from optimizer.problem.variables import PER_SI, SIDE, azimuth_deg
from optimizer.search import sqp
from optimizer.search.result import Result
from tests.optimizer.placed_task import FREE, joystick_task
from tests.optimizer.problem.figures_numpy import figures_numpy

DENSE = 41
HOLDS = 2e-6
"""A margin this little below 0, of a share or an angle: what a grid of 41 points and a polish differ by."""


@cache
def found(free: bool) -> Result:
    problem = step_problem(joystick_task(FREE if free else None), 2)
    best = sqp.search(problem, sqp.start_points(problem, 0, 4)).best
    assert best is not None
    return Result(problem, "sqp", problem.lengths_mm(best.x), "converged")


def shortfalls(result: Result, design_mm: np.ndarray) -> dict[str, float]:
    """The least margin of each limit over a dense surface, by trigonometry and by the corners of the machine."""
    design = design_mm / PER_SI
    f = figures_numpy(design[None], half_surface(DENSE))
    margins = {name: float(m.min()) for name, m in result.problem.point_margins(f).items()}
    L_A, _, R, r, _, _, shift, c, _ = design_mm
    phi, bar = np.arccos(c), 25.0
    ends = []  # of the shoulders' bars, turned out with level arms
    wrists = []
    for azimuth, radius in ((0.0, R), (phi, R + shift), (-phi, R + shift)):
        out, along = np.array([np.cos(azimuth), np.sin(azimuth)]), np.array([-np.sin(azimuth), np.cos(azimuth)])
        ends += [(radius + L_A) * out + side * bar * along for side in (-1.0, 1.0)]
        wrists.append([r * out + side * bar * along for side in (-1.0, 1.0)])
    depth, width = np.ptp(ends, axis=0) + np.array([13.2, 9.6])
    margins["outline"] = max(
        min((270.0 - width) / 270.0, (220.0 - depth) / 220.0), min((220.0 - width) / 220.0, (270.0 - depth) / 270.0)
    )
    apart = min(np.linalg.norm(p - q) for i, j in ((0, 1), (0, 2), (1, 2)) for p in wrists[i] for q in wrists[j])
    margins["clearance"] = (apart - 9.89 - 2.0) / r
    return margins


def test_the_placement_gives_a_larger_cube_in_the_same_rectangle() -> None:
    """The study found 4.8 mm of side, at 116 degrees, the cube 11 mm off the axis."""
    symmetric, placed = found(free=False), found(free=True)
    assert symmetric.feasible
    assert placed.feasible
    assert 2.0 * (placed.design_mm[SIDE] - symmetric.design_mm[SIDE]) > 4.5
    *_, shift, cosine, centre = placed.design_mm
    assert azimuth_deg(cosine) < 118.0
    assert shift > 5.0
    assert centre > 9.0


@pytest.mark.parametrize("free", [False, True])
def test_every_limit_holds_by_trigonometry_on_a_dense_surface(free: bool) -> None:
    result = found(free)
    margins = shortfalls(result, np.array(result.design_mm))
    assert {"outline", "clearance", "kappa", "torque", "couple_index", "friction"} <= set(margins)
    assert min(margins.values()) > -HOLDS
    assert sum(abs(value) < 1e-4 for value in margins.values()) >= 4  # what binds is used up


def test_nothing_near_it_has_a_larger_cube() -> None:
    """A thousand designs beside it, 0.05 % larger: each misses a limit by more than the search gives up."""
    result, rng = found(free=True), np.random.default_rng(4)
    problem = result.problem
    at = problem.scaled(np.array(result.design_mm))
    x = np.clip(at + 10.0 ** rng.uniform(-4.0, -1.0, (1000, 1)) * rng.normal(size=(1000, len(at))), 0.0, 1.0)
    designs = problem.designs(x)
    designs[:, SIDE] = result.design_mm[SIDE] * 1.0005 / 1000.0
    _, margins = sqp.sampled(problem, np.array([problem.scaled(d) for d in designs * PER_SI]), 9)
    assert (margins.min(axis=1) < -1e-6).all()


def test_every_start_ends_within_a_share_of_the_best() -> None:
    problem = found(free=True).problem
    endings = sqp.search(problem, sqp.start_points(problem, 1, 4)).endings
    best = max(ending.level for ending in endings)
    assert all(ending.converged and ending.level > 0.99 * best for ending in endings)
