"""How the front moves with outline and torque."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from delta_cad.mechanism.geometry import THREE_FOLD
from optimizer.problem.step import outline_of
from optimizer.search import sqp
from optimizer.study.front import Curve, Tracer, at_side
from optimizer.study.trade import Trade, further, largest_reach, scaled_outline, torque_levels, with_torque
from optimizer.study.trade import trade as traced
from tests.optimizer.front_tasks import check, joystick, kappa_at

pytestmark = pytest.mark.slow  # the fixture draws five fronts


@pytest.fixture(scope="module")
def trade() -> Trade:
    return traced(Tracer(joystick(half_side=(30.0, 100.0)), 4))


def test_there_are_two_more_of_each_kind(trade: Trade) -> None:
    assert [curve.name.split()[0] for curve in trade.curves] == ["as", "outline", "outline", "torque", "torque"]
    assert trade.finished
    assert len({curve.name for curve in trade.curves}) == 5


def test_larger_outline_has_a_better_front_and_a_smaller_one_a_worse(trade: Trade) -> None:
    small, large = trade.outlines
    assert small.largest < trade.main.largest < large.largest
    for curve, sign in ((small, 1.0), (large, -1.0)):
        for point in curve.points:
            own = kappa_at(trade.main, point.half_side)
            if own is not None:
                assert sign * (point.kappa - own) > 0.02


def test_points_keep_all_requirements_but_the_one_that_is_changed(trade: Trade) -> None:
    for curve, reach in zip(trade.outlines, (0.9 * 122.0, 1.1 * 122.0), strict=True):
        for point in curve.points:
            L_A, _, R, r, _, _, *placement = point.result.design_mm
            assert placement == [0.0, THREE_FOLD, 0.0]  # the joystick's chains stand at 120 degrees
            assert pytest.approx(reach) == R + L_A
            assert pytest.approx(40.0 / 82.0) == R / L_A
            assert r >= 30.0
            found = check(point.result.design_mm, 3.0)
            assert found.kappa <= 2.27 * (1 + 1e-8)
            assert found.lean_deg <= 28.0 + 1e-6
    for curve in trade.torques:
        level = float(curve.words.split()[0])
        for point in curve.points:
            assert check(point.result.design_mm, 3.0).torque <= level * (1.0 + 1e-9)
            assert point.reach == pytest.approx(122.0)


def test_torque_limit_binds_where_the_front_as_required_needs_more(trade: Trade) -> None:
    given = joystick()
    for curve in trade.torques:
        level = float(curve.words.split()[0])
        assert min(p.torque for p in trade.main.points) < level < trade.torque_needed
        for point in curve.points:
            best = sqp.search(
                at_side(given, point.half_side), sqp.start_points(at_side(given, point.half_side), 3)
            ).best
            assert best is not None
            if "torque" in point.active:
                assert point.kappa > (1.0 + 1e-4) / best.level
                assert point.torque == pytest.approx(level, rel=1e-6)
            else:
                assert point.kappa == pytest.approx(1.0 / best.level, rel=1e-7)


def test_more_torque_than_the_front_needs_changes_nothing(trade: Trade) -> None:
    last = trade.main.points[-1]
    ample = at_side(with_torque(joystick(), 1.001 * trade.torque_needed), last.half_side - 0.1)
    best = sqp.search(ample, ample.scaled(np.array(last.result.design_mm))[None]).best
    assert best is not None
    required = at_side(joystick(), last.half_side - 0.1)
    same = sqp.search(required, required.scaled(np.array(last.result.design_mm))[None]).best
    assert same is not None
    assert best.level == pytest.approx(same.level, rel=1e-9)


def test_outline_that_leaves_no_design_is_an_empty_front_with_its_contradiction() -> None:
    given = joystick(half_side=(38.0, 100.0))
    found = further(Tracer(given, 4), scaled_outline(given, 0.9), "small", "smaller")
    assert found.points == ()
    assert "half side 38 mm" in found.beyond
    assert found.finished


def test_largest_reach_uses_the_outline_up() -> None:
    for limits in (
        {"outline_radius_max_mm": 122.0},
        {"outline_radius_max_mm": None},
        {"outline_radius_max_mm": None, "outline_overhead_mm": (30.0, 4.0)},
    ):
        given = joystick(**limits)
        assert outline_of(given).room(np.array(largest_reach(given)))[0] == pytest.approx(0.0, abs=1e-15)
    assert scaled_outline(given, 0.9).limits.outline_radius_max_mm == pytest.approx(0.9 * largest_reach(given))


def test_knee_is_farthest_below_the_line(trade: Trade) -> None:
    knee = trade.knee
    assert knee is not None
    assert knee not in (trade.main.points[0], trade.main.points[-1])
    low, high = trade.main.points[0], trade.main.points[-1]

    def below(point):
        share = (point.half_side - low.half_side) / (high.half_side - low.half_side)
        return low.kappa ** (1.0 - share) * high.kappa**share / point.kappa

    assert below(knee) == max(below(point) for point in trade.main.points) > 1.0
    assert Trade(Curve(joystick(), "a", "a", trade.main.points[:2])).knee is None
    # of these the second is farthest below the line in log kappa, the third in kappa itself
    points: Any = [SimpleNamespace(half_side=k, kappa=kappa) for k, kappa in enumerate((1.0, 1.1, 4.0, 20.0))]
    assert Trade(Curve(joystick(), "a", "a", tuple(points))).knee is points[1]
    bulging: Any = [SimpleNamespace(half_side=k, kappa=kappa) for k, kappa in enumerate((1.0, 1.5, 1.6))]
    assert Trade(Curve(joystick(), "a", "a", tuple(bulging))).knee is None


def test_no_points_no_torques() -> None:
    empty = Curve(joystick(), "a", "a", ())
    assert torque_levels(empty) == []
    assert np.isnan(Trade(empty).torque_needed)


def test_stopped_in_the_first_front_there_are_no_others() -> None:
    seen = []
    tracer = Tracer(joystick(half_side=(36.0, 40.0)), 5, report=lambda *_: seen.append(1), stop=lambda: len(seen) > 2)
    found = traced(tracer)
    assert not found.finished
    assert found.curves == (found.main,)
    assert len(found.main.points) == 3
