"""Maps over slices of the cube against the evaluator of the searches."""

from __future__ import annotations

import numpy as np
import pytest

from delta_cad.mechanism import Cube, DeltaGeometry, SingularError, UnreachableError
from optimizer.problem.evaluator import figures
from optimizer.problem.step import step_problem
from optimizer.search.result import Result
from optimizer.study.maps import require_held, slices
from tests.optimizer.tasks import task

DESIGN_MM = (82.0, 112.079, 40.0, 30.0, 57.112, 37.5)
G = DeltaGeometry(base_radius=0.040, platform_radius=0.030, upper_arm_length=0.082, forearm_length=0.112079)
CUBE = Cube(0.057112, 0.0375)


def test_values_are_those_of_the_evaluator() -> None:
    for found in slices(G, CUBE, 3.0, 21):
        x, up = np.meshgrid(found.across, found.up)
        c = np.zeros((x.size, 3))
        c[:, 0] = x.ravel() / CUBE.half_side
        if found.axes == ("x", "y"):
            c[:, 1] = up.ravel() / CUBE.half_side
            c[:, 2] = {"bottom": -1.0, "middle": 0.0, "top": 1.0}[found.title.split(",")[0]]
        else:
            c[:, 2] = (up.ravel() - CUBE.bottom_height) / CUBE.half_side - 1.0
        f = figures(np.array([DESIGN_MM]) / 1000.0, c)
        # two formulas for the same numbers; kappa loses digits with its square
        assert found.kappa.ravel() == pytest.approx(1.0 / f.quality[0], rel=1e-9)
        assert found.torque.ravel() == pytest.approx(3.0 * f.moment[0] / f.determinant[0], rel=1e-11)


def test_worst_of_the_maps_is_that_of_the_result() -> None:
    result = Result(step_problem(task(), 3, 37.5), "sqp", DESIGN_MM, "converged")
    found = slices(G, CUBE, 3.0)
    worst = max(s.worst(s.kappa) for s in found)
    assert worst[0] == pytest.approx(result.max_kappa, rel=1e-12)  # in a corner, which both look at
    assert np.abs(worst[1:]) == pytest.approx([0.0375, 0.0375])
    assert max(s.worst(s.torque)[0] for s in found) == pytest.approx(result.max_torque, rel=1e-12)


def test_slices_hold_the_cube_and_a_fifth_around_it() -> None:
    for found in slices(G, CUBE, 3.0, 21):
        left, right, lower, upper = found.outline
        assert {left, right} <= set(found.across)
        assert {lower, upper} <= set(found.up)
        assert found.inside.sum() == 21 * 21
        assert found.across[0] == pytest.approx(-1.2 * CUBE.half_side)
        assert found.across[-1] == pytest.approx(1.2 * CUBE.half_side)


def test_what_is_out_of_reach_or_not_held_is_left_out() -> None:
    near = slices(G, Cube(0.026, 0.080), 3.0, 21)
    assert np.isnan(near[0].kappa).any()
    found = near[0]
    x, y = np.meshgrid(found.across, found.up)
    c = np.stack([x, y, np.full_like(x, -0.080)], axis=-1).reshape(-1, 3) / 0.080
    f = figures(np.array([(*DESIGN_MM[:4], 26.0, 80.0)]) / 1000.0, c)
    assert (np.isnan(found.kappa.ravel()) == ((f.closure[0] < 0.0) | (f.determinant[0] <= 0.0))).all()
    assert (np.isnan(found.kappa) == np.isnan(found.torque)).all()


def test_cube_that_has_no_maps_is_refused() -> None:
    require_held(G, CUBE)
    with pytest.raises(UnreachableError):
        require_held(G, Cube(0.057112, 0.080))
    hidden = DeltaGeometry(base_radius=0.056122, platform_radius=0.040, upper_arm_length=0.082, forearm_length=0.094266)
    with pytest.raises(SingularError):
        require_held(hidden, Cube(0.022648, 0.043363))
