"""The proof of placed designs: forms of seven symbols, cuts that the feasible meets, and a bound that is proved.

25 s of processor: seven variables are searched around the placement that was found, three times.
"""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from delta_cad.mechanism.enclosure.table import EXCLUDED
from optimizer.globalopt import forms_of_seven as seven
from optimizer.globalopt.branch_and_bound import design_cuts
from optimizer.globalopt.cutting_points import MOST, ROWS, fill_lengths, numbers, point_cuts
from optimizer.globalopt.forms_of_seven import SYMBOLS, TERMS, of_seven
from optimizer.globalopt.optimum import none_feasible, prove_optimum
from optimizer.globalopt.placed_box import placed_boxes, placed_design
from optimizer.problem.evaluator import fold_points
from optimizer.problem.step import Problem, step_problem
from optimizer.problem.variables import SIDE
from optimizer.search import sqp
from tests.optimizer.placed_task import FREE, joystick_task
from tests.optimizer.problem.figures_numpy import figures_numpy

NARROW: dict[str, Any] = {
    "bounds_mm": {"side_shift": [6.8, 7.8], "centre_x": [10.7, 11.7]},
    "bounds_deg": {"azimuth": [116.0, 116.6]},
}
Form = tuple[Fraction, ...]


def _value(form: Any, u: list[Fraction]) -> tuple[Fraction, Fraction]:
    """The range of a form at a place, exact."""
    c, *slopes, e = (Fraction(float(x)) for x in form)
    middle = c + sum(s * at for s, at in zip(slopes, u, strict=True))
    return middle - e, middle + e


def test_operations_on_seven_symbols_hold_the_exact_result() -> None:
    rng = np.random.default_rng(2)
    for _ in range(300):
        a, b = (tuple(float(x) for x in rng.normal(size=TERMS) * 10.0 ** rng.uniform(-8, 1, TERMS)) for _ in range(2))
        a, b = (*a[:-1], abs(a[-1])), (*b[:-1], abs(b[-1]))
        u = [Fraction(float(x)) for x in np.sign(rng.normal(size=SYMBOLS)) * rng.choice([1.0, 0.3], SYMBOLS)]
        ends = [(x, y) for x in _value(a, u) for y in _value(b, u)]
        for operation, exact in (
            (seven.add, lambda x, y: x + y),
            (seven.subtract, lambda x, y: x - y),
            (seven.multiply, lambda x, y: x * y),
        ):
            low, high = _value(operation(a, b), u)
            assert all(low <= exact(x, y) <= high for x, y in ends)
        low, high = _value(seven.scale(b[0], a), u)
        assert all(low <= Fraction(b[0]) * x <= high for x in _value(a, u))
        positive = (abs(a[0]) + 1.1 * seven.slope(a) + 1.1 * a[-1] + 1e-9, *a[1:])
        low, high = _value(seven.inverse(positive), u)
        assert all(low <= 1 / x <= high for x in _value(positive, u))
        low, high = _value(seven.root(positive), u)
        assert all(max(low, 0) ** 2 <= x <= high**2 for x in _value(positive, u))
        assert seven.lower(a) <= min(_value(a, u))
        assert seven.upper(a) >= max(_value(a, u))


def _cuts(problem: Problem, box: np.ndarray, side: float, unit: np.ndarray, way: int) -> tuple[int, int, np.ndarray]:
    """How many cuts the closed forms make, how many with those at a point, and the cuts; either may exclude."""
    room, pose = np.empty((MOST + 20, TERMS)), np.empty((ROWS, TERMS))
    of_seven(fill_lengths)(box, pose)
    count = of_seven(design_cuts)(pose, box, placed_boxes(problem)[way].cube_limits(side), room, 0)
    if count == EXCLUDED:
        return count, count, room
    point = unit * side + np.array([0.0, 0.0, side])
    required = numbers(problem.pose_limits())
    return count, of_seven(point_cuts)(point[None], 0, required, pose, np.empty((24, TERMS)), room, count), room


def test_a_feasible_design_meets_every_cut_of_every_box_around_it() -> None:
    problem = step_problem(joystick_task(FREE), 2)
    rng, compared, points = np.random.default_rng(3), 0, 0
    best = sqp.search(problem, sqp.start_points(problem, 0, 1)).best
    assert best is not None
    while compared < 250:
        x = np.clip(np.array(best.x) + 10.0 ** rng.uniform(-3.0, -1.0) * rng.normal(size=len(best.x)), 0.0, 1.0)
        design = problem.designs(x[None])
        design[0, SIDE] = 0.001 * rng.uniform(35.0, 44.0)
        if min(float(m[0]) for m in problem.design_margins(design).values()) < 1e-9:
            continue
        unit = np.round(rng.uniform(-1.0, 1.0, 3) * 1.4).clip(-1, 1)
        margins = problem.point_margins(figures_numpy(design, unit[None]))
        folds = figures_numpy(design, fold_points(design)[0]).closure.min()  # closed forms know of the whole cube
        if min(folds, *(float(m[0, 0]) for m in margins.values())) < 1e-9:
            continue
        L_A, L_B, R, r, H, L, shift, c, centre = design[0]
        place = np.array([L_A, L_B, R - r, H, shift, c, centre])
        width = 10.0 ** rng.uniform(-4.0, -1.7, SYMBOLS) * rng.integers(0, 2, SYMBOLS) * (1.0 + 4.0 * (place == c))
        box = place + np.array([[-1.0], [1.0]]) * width * rng.random((2, SYMBOLS))
        half = (box[1] - box[0]) / 2.0
        u = np.where(half > 0.0, (place - box.mean(axis=0)) / np.where(half > 0.0, half, 1.0), 0.0)
        outline = next(limit for limit in problem.limits if limit.name == "outline")
        turned = outline.room((R + L_A) * 1000.0, shift * 1000.0, c)[1]  # type: ignore[attr-defined]
        _, count, cuts = _cuts(problem, box, L, unit, int(turned))
        assert count != EXCLUDED
        values = cuts[:count, 0] + cuts[:count, 1:-1] @ u + cuts[:count, -1]
        assert (values >= -1e-11).all()  # of cuts with a magnitude of 1, evaluated in doubles
        compared, points = compared + 1, points + count
    assert points > 500


def test_the_exact_point_of_a_box_is_a_design_within_the_bounds() -> None:
    problem, rng = step_problem(joystick_task(FREE), 2), np.random.default_rng(5)
    for space in placed_boxes(problem):
        for _ in range(50):
            place = space.box[0] + (space.box[1] - space.box[0]) * rng.random(SYMBOLS)
            design = placed_design(problem, space, place, 30.0)
            assert (design >= problem.lower).all()
            assert (design <= problem.upper).all()
            assert design[7] == np.clip(place[5], problem.lower[7], problem.upper[7])


@pytest.mark.slow
def test_the_optimum_near_the_placement_that_was_found_is_proved() -> None:
    problem = step_problem(joystick_task(NARROW), 2)
    found = prove_optimum(problem, gap=1e-2)
    assert found.status == "proved"
    assert found.certified
    assert found.bound / found.objective - 1.0 <= 1.0000001e-2
    assert not none_feasible(joystick_at(problem, found.objective * 0.9999))
    assert none_feasible(joystick_at(problem, found.bound))


def joystick_at(problem: Problem, half_side_mm: float) -> Problem:
    """The same with a half side that is at least so much."""
    bounds = problem.requirements.bounds_mm.model_copy(update={"half_side": (half_side_mm, half_side_mm + 1.0)})
    return step_problem(problem.requirements.model_copy(update={"bounds_mm": bounds}), 2)
