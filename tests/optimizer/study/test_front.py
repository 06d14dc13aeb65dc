"""The front: feasible and not dominated by an independent check, warm as good as cold, resumed as unbroken."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from optimizer.problem.step import step_problem
from optimizer.search import sqp
from optimizer.search.result import Result
from optimizer.study import front
from optimizer.study.front import Curve, FrontError, Tracer, at_side
from optimizer.study.trade import with_torque
from optimizer.synthesis.checkpoint import Checkpoint
from optimizer.synthesis.infeasible import InfeasibleError, explain
from tests.optimizer.front_tasks import check, joystick
from tests.optimizer.messages import refuses

WANTED = 33.3


@pytest.fixture(scope="module")
def curve() -> Curve:
    return Tracer(joystick(half_side_mm=WANTED), 12).curve()


@pytest.mark.slow
def test_front_rises_and_nothing_is_dominated(curve: Curve) -> None:
    sides, kappas = [p.half_side for p in curve.points], [p.kappa for p in curve.points]
    assert len(sides) == 12
    assert (np.diff(sides) > 0.0).all()
    assert (np.diff(kappas) > 0.0).all()
    assert curve.finished


def test_every_point_meets_the_requirements_by_an_independent_check(curve: Curve) -> None:
    for point in curve.points:
        L_A, L_B, R, r, H, L = point.result.design_mm[:6]
        found = check(point.result.design_mm, force=3.0)
        assert found.reachable
        # the check looks at a grid, the result polishes: below by the grid's error, above by rounding only
        assert 0.999 * point.kappa < found.kappa <= point.kappa * (1.0 + 1e-9)
        assert 0.999 * point.torque < found.torque <= point.torque * (1.0 + 1e-9)
        assert point.kappa <= 2.27 * (1.0 + 1e-8)  # margins are kept to 1e-9 of 1 / kappa
        assert found.torque <= 0.69
        assert found.lean_deg <= 28.0 + 1e-6  # grid and rounding of the arc sine
        assert R + L_A <= 122.0 + 1e-9
        assert math.sqrt(3.0) * r - 27.0 - 11.0 >= 2.0 - 1e-9
        assert (L_A, R) == (82.0, 40.0)
        assert 80.0 <= L_B <= 180.0
        assert 30.0 <= r <= 45.0
        assert 20.0 <= H <= 150.0
        assert 0.0 < L <= 100.0


def test_half_side_of_the_requirements_is_a_point(curve: Curve) -> None:
    assert WANTED in [p.half_side for p in curve.points]


def test_cold_starts_find_nothing_better(curve: Curve) -> None:
    for point in curve.points[1::4]:
        problem = at_side(joystick(), point.half_side)
        best = sqp.search(problem, sqp.start_points(problem, seed=77)).best
        assert best is not None
        # two runs of SQP end within its precision, 1e-8 of the level
        assert 1.0 / best.level >= point.kappa * (1.0 - 1e-7)


def test_largest_is_the_end_and_beyond_it_nothing_is_feasible(curve: Curve) -> None:
    assert curve.points[-1].half_side == curve.largest
    assert curve.points[-1].kappa == pytest.approx(2.27, rel=1e-6)
    assert set(curve.beyond) == {
        "limits.kappa_max = 2.27",
        "limits.lean_max_deg = 28.0",
        f"half side {1.01 * curve.largest:.4g} mm",
    }
    problem = at_side(joystick(), 1.002 * curve.largest)
    assert sqp.search(problem, sqp.start_points(problem, seed=5)).best is None


def test_what_is_called_active_is_what_holds_the_point(curve: Curve) -> None:
    at = [p for p in curve.points if p.active == ("outline", "platform_radius >= 30 mm")][-1]
    assert _kappa_with(at.half_side, r_min=29.0) < at.kappa * (1.0 - 1e-4)
    free = curve.points[0]
    assert free.active == ("outline",)
    assert _kappa_with(free.half_side, r_min=29.0) == pytest.approx(free.kappa, rel=1e-7)
    leaning = next(p for p in curve.points if "lean" in p.active)
    assert _kappa_with(leaning.half_side, r_min=30.0, lean_max_deg=28.5) < leaning.kappa * (1.0 - 1e-4)


def _kappa_with(side: float, r_min: float, **limits: float) -> float:
    given = joystick(clearance_min_mm=0.0, **limits)
    given = given.model_copy(
        update={"bounds_mm": given.bounds_mm.model_copy(update={"platform_radius": (r_min, 45.0)})}
    )
    problem = at_side(given, side)
    best = sqp.search(problem, sqp.start_points(problem, seed=0)).best
    assert best is not None
    return 1.0 / best.level


def test_smallest_without_a_bound_is_a_quarter(curve: Curve) -> None:
    assert curve.points[0].half_side == pytest.approx(0.25 * curve.largest)


def test_bounds_of_the_half_side_are_the_ends_and_the_upper_is_named() -> None:
    found = Tracer(joystick(half_side=(38.0, 40.0)), 4).curve()
    assert found.points[0].half_side == 38.0
    assert found.largest == 40.0
    assert found.beyond == ("half side <= 40 mm (bounds_mm.half_side)",)


@pytest.mark.slow
def test_largest_cube_holds_on_the_fine_surface_where_the_search_misses_a_point() -> None:
    found = Tracer(with_torque(joystick(), 0.269), 4).curve()
    assert found.points[-1].half_side == found.largest
    assert all(point.result.feasible for point in found.points)
    assert check(found.points[-1].result.design_mm, 3.0).kappa <= 2.27 * (1.0 + 1e-8)


def test_design_that_misses_a_constraint_is_cut_about_the_same_centre(curve: Curve) -> None:
    good = curve.points[-1].result
    *lengths, bottom, side = good.design_mm[:6]
    problem = step_problem(joystick(), 2)
    large = Result(problem, "sqp", (*lengths, bottom - 0.5, side + 0.5), "converged")
    assert not large.feasible
    cut = front._held(large)
    assert cut.feasible
    assert cut.design_mm[5] >= side - 1e-6
    assert cut.design_mm[4] + cut.design_mm[5] == pytest.approx(bottom + side)
    dominated = Result(problem, "sqp", (*lengths, bottom, 2.0 * side), "converged")
    assert front._held(dominated) is dominated


@pytest.mark.parametrize("requested", [3, 8])
def test_stopped_and_resumed_is_as_unbroken(tmp_path: Path, requested: int) -> None:
    given, path = joystick(half_side_mm=WANTED, half_side=(30.0, 38.0)), tmp_path / "kept"
    unbroken = Tracer(given, 4).curve()
    assert [p.half_side for p in unbroken.points] == pytest.approx([30.0, WANTED, 38.0 - 8.0 / 3.0, 38.0])
    count = iter(range(1000))
    store = Checkpoint(path, {}, resume=False)
    first = Tracer(given, 4, stop=lambda: next(count) >= requested, store=store).curve()
    store.close()
    assert not first.finished
    assert len(first.points) == min(requested - 1, 4)  # asked once before the largest cube, and in the sweeps
    store = Checkpoint(path, {}, resume=True)
    second = Tracer(given, 4, store=store).curve()
    store.close()
    assert [p.result.design_mm for p in second.points] == [p.result.design_mm for p in unbroken.points]
    assert (second.beyond, second.largest, second.finished) == (unbroken.beyond, unbroken.largest, True)
    kept = path.read_text()
    assert [kept.count(f"/{phase}/") for phase in ("point", "up", "down")] == [4, 3, 3]


def test_sweeps_carry_a_good_design_up_and_down(curve: Curve) -> None:
    for first in (0, -1):
        tracer = Tracer(joystick(), 12)
        for point in curve.points:  # one kappa for all: what the largest cube has
            design = (*curve.points[-1].result.design_mm[:5], point.half_side)
            tracer._found[point.half_side] = Result(point.result.problem, "sqp", design, "converged")
        tracer._found[curve.points[first].half_side] = curve.points[first].result
        assert tracer._sweeps()
        for point in curve.points:
            assert tracer._found[point.half_side].max_kappa == pytest.approx(point.kappa, rel=1e-7)


def test_what_is_dominated_or_infeasible_is_left_out(curve: Curve) -> None:
    tracer = Tracer(joystick(), 12)
    for point in curve.points:
        tracer._found[point.half_side] = point.result
    worse, refused = curve.points[2].result, curve.points[5].result
    *lengths, bottom, L = worse.design_mm[:6]
    tracer._found[L] = Result(worse.problem, "sqp", (*lengths, bottom + 30.0, L), "converged")
    assert tracer._found[L].feasible
    assert tracer._found[L].max_kappa > curve.points[3].kappa
    *lengths, bottom, side = refused.design_mm[:6]
    tracer._found[side] = Result(refused.problem, "sqp", (*lengths, bottom - 40.0, side), "converged")
    assert not tracer._found[side].feasible
    assert [r.design_mm[5] for r in tracer._front()] == [
        p.half_side for p in curve.points if p.half_side not in (L, side)
    ]


def test_stopped_before_the_first_point_is_empty() -> None:
    found = Tracer(joystick(), 5, stop=lambda: True).curve()
    assert (found.points, found.finished) == ((), False)


def test_few_points_are_refused() -> None:
    with refuses(FrontError, "3", "4"):
        Tracer(joystick(), 3).curve()


def test_one_size_is_no_range() -> None:
    with refuses(FrontError, "bounds_mm.half_side", "35", "35"):
        Tracer(joystick(half_side=(35.0, 35.0)), 5).curve()


def test_contradiction_is_raised() -> None:
    with refuses(InfeasibleError, "half_side", "60"):
        Tracer(joystick(half_side=(60.0, 100.0)), 5).curve()


@pytest.mark.slow
def test_kappa_of_1_holds_in_no_cube(monkeypatch: pytest.MonkeyPatch) -> None:
    """In a point it does, so that step 2 alone shows no contradiction. Two starts: each takes a second to find none."""
    given, starts = joystick(kappa_max=1.0), sqp.start_points
    monkeypatch.setattr(front.sqp, "start_points", lambda problem, seed, *_: starts(problem, seed, 2))
    assert explain(given, step_problem(given, 2), None, 0) is None
    with refuses(InfeasibleError, "2", "limits.kappa_max", "1.0", "0.1") as e:
        Tracer(given, 5).curve()
    assert set(e.value.conflict) == {"kappa", "half_side"}
    assert front.described_conflict(step_problem(given, 2), e.value) == (
        "limits.kappa_max = 1.0",
        "half side 0.1 mm",
    )
    assert front.no_cube(joystick(), 0) is None


def test_search_that_finds_nothing_is_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(front.sqp, "search", lambda *_, **__: sqp.Search())
    monkeypatch.setattr(front, "explain", lambda *_: None)
    with refuses(FrontError, "--seed"):
        Tracer(joystick(), 5).curve()


def test_front_of_nothing_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Tracer, "_front", lambda _: [])
    with pytest.raises(FrontError, match="--seed"):
        Tracer(joystick(half_side=(38.0, 40.0)), 4).curve()


def test_larger_cube_found_beyond_is_followed(curve: Curve, monkeypatch: pytest.MonkeyPatch) -> None:
    true, lame = front.sqp.search, []

    def search(problem, starts, *rest, **named):  # the first search of step 2 ends at a small cube
        found = true(problem, starts, *rest, **named)
        if problem.step == 2 and not lame:
            lame.append(1)
            best = found.best
            assert best is not None
            found.endings[:] = [best._replace(x=(*best.x[:-1], 0.38), level=0.38)]
        return found

    monkeypatch.setattr(front.sqp, "search", search)
    monkeypatch.setattr(front.Tracer, "_coarse", lambda *_: False)
    assert Tracer(joystick(), 5).curve().largest == pytest.approx(curve.largest, rel=1e-6)
