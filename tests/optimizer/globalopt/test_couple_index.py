"""The limit of the couple index up to the proven optimum: certified, monotone, never beaten, named where impossible."""

from __future__ import annotations

from functools import cache
from itertools import pairwise

import numpy as np
import pytest

from delta_cad.common.units import MM_PER_M
from delta_cad.mechanism import Cube, DeltaGeometry, cube_grid, elbow_positions, inverse_kinematics, wrist_positions
from delta_cad.mechanism.geometry import TANGENTIAL
from delta_cad.mechanism.inverse import closure_margin
from delta_cad.mechanism.limits import CoupleIndex
from delta_cad.mechanism.proof.prove import prove
from optimizer.globalopt.optimum import Proven, prove_optimum
from optimizer.problem.evaluator import fold_points, half_surface
from optimizer.problem.requirements import Requirements
from optimizer.problem.step import SIDE, Problem, step_problem
from optimizer.synthesis.infeasible import InfeasibleError
from optimizer.synthesis.three_step import Run
from tests.optimizer.globalopt.wide import LIMITS, NARROW, ROUNDING, WIDE, mechanism, random_designs
from tests.optimizer.messages import refuses
from tests.optimizer.problem.figures_numpy import figures_numpy
from tests.optimizer.tasks import task

WITHOUT = frozenset({"couple_index"})


def given(index_min: float, half_side_mm: float | None = None) -> Requirements:
    """The former task (references/joystick.toml) with a couple index."""
    return task(*WIDE, limits=LIMITS | {"couple_index_min": index_min}, half_side_mm=half_side_mm)


@cache
def solved(index_min: float) -> Proven:
    return prove_optimum(step_problem(given(index_min), 2), gap=1e-4)


def least(g: DeltaGeometry, cube: Cube, n: int) -> float:
    """The smallest singular value of the couples on n^3 points of the cube, inside too; -1 where a chain is open."""
    p = cube_grid(cube, n).reshape(-1, 3)
    if not (closure_margin(g, p) >= 0.0).all():
        return -1.0
    rods = (wrist_positions(g, p) - elbow_positions(g, inverse_kinematics(g, p))) / g.forearm_length
    couples = np.cross(np.broadcast_to(TANGENTIAL, rods.shape), rods)
    return float(np.linalg.svd(couples, compute_uv=False)[:, 2].min())


@pytest.mark.parametrize("index_min", [0.2, 0.4, 0.5])
def test_the_incumbent_keeps_the_index_on_a_fine_grid_and_is_certified(index_min: float) -> None:
    found, problem = solved(index_min), step_problem(given(index_min), 2)
    assert found.status == "proved"
    assert found.certified
    g, cube = mechanism(np.array(found.design_mm) / MM_PER_M)
    # what binds is a corner, which the grid has; what certifying gives up is 1e-5 of the side at most
    assert index_min * (1.0 - ROUNDING) <= least(g, cube, 41) < index_min * (1.0 + 1e-4)
    limits = problem.pose_limits()
    assert "couple_index" in limits.asked
    assert prove(g, cube, limits).verdict == "proved"


def test_more_hold_makes_a_smaller_cube_and_what_is_there_already_costs_nothing() -> None:
    free = prove_optimum(step_problem(given(0.4), 2, without=WITHOUT), gap=1e-4)
    for larger, smaller in pairwise([free, solved(0.2), solved(0.4), solved(0.5)]):
        assert smaller.bound < larger.objective
    there = least(*mechanism(np.array(free.design_mm) / MM_PER_M), 21)
    assert there == pytest.approx(0.1153, abs=1e-3)
    assert solved(0.1).objective == pytest.approx(free.objective, rel=1e-4)


def beaten(problem: Problem, designs: np.ndarray) -> bool:
    """Whether one of the designs meets everything: all else on grids and at the folds, the index by singular values."""
    others = step_problem(problem.requirements, problem.step, without=WITHOUT)
    kept = np.ones(len(designs), dtype=bool)
    for margin in others.design_margins(designs).values():
        kept &= margin >= 0.0
    designs = designs[kept]
    for points in (half_surface(2), half_surface(5), half_surface(17), None):
        f = figures_numpy(designs, fold_points(designs) if points is None else points)
        designs = designs[np.min(list(others.point_margins(f).values()), axis=0).min(axis=1) >= 0.0]
    limit = problem.requirements.values["couple_index_min"]
    return any(least(*mechanism(one), 2) >= limit and least(*mechanism(one), 21) >= limit for one in designs)


@pytest.mark.slow
def test_no_random_design_beats_the_bound_and_some_beat_one_that_is_wrong() -> None:
    """A cube that is feasible contains every smaller one on its bottom: that of the bound is enough."""
    problem, found = step_problem(given(0.4), 2), solved(0.4)
    designs = random_designs(problem, found)
    for share, wrong in ((1.0, False), (0.997, True)):
        designs[:, SIDE] = share * found.bound / MM_PER_M
        assert beaten(problem, designs) == wrong


@pytest.mark.slow
def test_step_3_with_a_couple_index() -> None:
    """At a half side at which the index decides how small kappa can be."""
    problem = step_problem(given(0.5, 38.0), 3)
    found = prove_optimum(problem, gap=1e-3)
    free = prove_optimum(step_problem(given(0.5, 38.0), 3, without=WITHOUT), gap=1e-3)
    assert found.status == free.status == "proved"
    assert found.bound > free.objective  # the hold costs kappa
    assert least(*mechanism(np.array(found.design_mm) / MM_PER_M), 41) >= 0.5 * (1.0 - ROUNDING)


@pytest.mark.parametrize("method", ["proven", "ga+sqp"])
def test_synthesis_finds_the_same_optimum(method: str) -> None:
    sizes = {"population": 24, "generations": 8, "prove": True}
    result = Run(given(0.4), method, 1, steps=(2,), **sizes).results()[0]
    assert result.feasible
    assert result.proof is not None
    assert result.proof.bound is not None
    assert result.objective <= result.proof.bound <= result.objective * (1.0 + 1.1e-5)
    assert result.objective == pytest.approx(solved(0.4).objective, rel=1e-4)
    assert result.violations["couple_index"] <= ROUNDING
    assert result.worst(CoupleIndex) == pytest.approx(0.4, rel=1e-6)


@pytest.mark.parametrize("method", ["proven", "sqp"])
def test_a_hold_that_no_cube_of_a_size_has_is_named_as_impossible(method: str) -> None:
    asked = task(*NARROW, limits={"couple_index_min": 0.8}, half_side=(20, 100))
    with refuses(InfeasibleError, "limits.couple_index_min", "0.8", "20") as caught:
        Run(asked, method, 1, steps=(2,), prove=True).results()
    assert set(caught.value.conflict) == {"couple_index", "half_side"}
    assert caught.value.proved
