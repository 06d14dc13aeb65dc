"""Four walls: their order and meaning, the formula behind them, hands at the corners of their ranges, and the cap."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise, product

import numpy as np
import pytest

from delta_cad.design import Design
from haptics.model.hands import CORNERS, HANDS, RANGES
from haptics.model.machine import MachineModel
from haptics.model.plant import FREE
from haptics.rendering.laws.virtual_wall import AXES, axis_wall
from haptics.simulation.loops import BOARD, DAMPED, PAPER, LoopChoice, RATES_Hz, at_rate
from haptics.stability.passivity import required_friction
from haptics.stability.wall_trial import WallBench
from haptics.stability.walls import NOBODY, SHARE, WallAt, capped, computed_wall
from tests.haptics.scene_machine import scene_machine


@pytest.fixture(scope="module")
def machine(best: Design) -> MachineModel:
    return scene_machine(best)


@pytest.mark.parametrize("axis", ["x", "z"])
def test_four_walls_differ(machine: MachineModel, axis: str) -> None:
    at = WallAt(machine, DAMPED, normal=AXES[axis])
    four = at.walls()
    assert 0.0 < four.own < four.passive < four.worst < four.nominal
    assert four.worst_hand == NOBODY
    assert set(four.by_hand) == {NOBODY, *HANDS}
    assert four.formula == pytest.approx(four.worst, rel=0.1)
    assert at.stable(HANDS["medium"]) == four.nominal == four.by_hand["medium"]
    # rigid and by its own damping: the formula without B, and the known condition; with little damping, whose walls are
    # soft beside the cable that stands between rotor and arm
    little = replace(DAMPED, contact_damping=DAMPED.drive_damping)
    rigid = WallAt(machine, little, normal=AXES[axis], rigid=True)
    own = rigid.passive()
    assert own == pytest.approx(WallAt(machine, little, normal=AXES[axis]).passive(), rel=0.02)
    for share, passive in ((0.98, True), (1.02, False)):
        asked = required_friction(rigid.timing, rigid.estimator, share * own, 0.0).friction
        assert (asked <= rigid.friction) == passive


def test_a_limit_is_where_the_eigenvalues_leave_the_circle(machine: MachineModel) -> None:
    at = WallAt(machine, p=machine.centre + np.array([0.02, -0.01, 0.03]), normal=AXES["y"])
    for hand in (FREE, HANDS["light"]):
        loop = at.here.joint_loop(at.normal, hand, at.timing, at.estimator)
        limit = at.stable(hand)
        assert loop.radius(0.99 * limit, BOARD.damping) < 1.0 < loop.radius(1.01 * limit, BOARD.damping)


@pytest.mark.parametrize(("loop", "centre", "everywhere"), [(BOARD, 4500.0, 3700.0), (DAMPED, 5000.0, 2000.0)])
def test_the_loop_bears_a_good_wall(machine: MachineModel, loop: LoopChoice, centre: float, everywhere: float) -> None:
    """5 N/mm at the centre for every hand at the corners of the ranges and none; 2 N/mm everywhere after the cap."""
    for axis in AXES.values():
        four = WallAt(machine, loop, normal=axis).walls({**HANDS, **CORNERS})
        assert four.worst > 5000.0
        assert four.passive > 5000.0
        assert four.worst > 0.95 * four.by_hand[NOBODY]  # no hand is much worse than none
    assert SHARE * computed_wall(machine, machine.centre, AXES["x"], loop) > centre
    half = machine.half_side
    for signs in product((-1.0, 1.0), repeat=3):
        pose = machine.centre + half * np.array(signs)
        assert min(SHARE * computed_wall(machine, pose, axis, loop) for axis in AXES.values()) > everywhere


def test_almost_all_of_a_wall_s_passive_damping_is_the_drives(machine: MachineModel) -> None:
    """Finding T11: without it the device by itself bears 0.02 N/mm, and Colgate's bound 2 b / T not much more."""
    drives, none = WallAt(machine, DAMPED), WallAt(machine, BOARD)
    assert none.friction < 0.01 * drives.friction
    assert none.passive() == pytest.approx(20.0, rel=0.3)
    assert drives.passive() > 7000.0


def test_without_delay_lag_and_what_gives_way_the_passive_wall_is_2_b_over_T(machine: MachineModel) -> None:
    """Colgate and Schenkel 1997: b > K T / 2, by hand."""
    at = WallAt(machine, replace(DAMPED, delays=(0.0, 0.0, 0.0), current_lag=1e-9, sensing=1.0), rigid=True)
    at.timing = replace(at.timing, delay=0.0)  # no age of a reading, either
    assert at.passive() == pytest.approx(2.0 * at.friction / DAMPED.period, rel=0.01)


def test_a_faster_loop_bears_more(machine: MachineModel) -> None:
    rates = [WallAt(machine, at_rate(rate, DAMPED)) for rate in RATES_Hz]
    walls = [at.stable(FREE) for at in rates]
    for (slow, fast), (slower, faster) in zip(pairwise(walls), pairwise(rates), strict=True):
        assert 1.4 < fast / slow < 2.0  # the lags of currents and encoders do not halve
        assert fast / slow == pytest.approx(faster.formula / slower.formula, rel=0.03)
    assert WallAt(machine, PAPER).stable(FREE) < 0.1 * walls[0]  # without damping


@pytest.mark.parametrize("axis", ["x", "z"])
def test_the_wall_stands_in_the_simulation_with_every_hand(machine: MachineModel, axis: str) -> None:
    """With noise, counts, friction that sticks, cable and structure that give way: 5 N/mm stands."""
    for name, hand in HANDS.items():
        trial = WallBench(machine, axis, hand, loop=BOARD).trial(5000.0)
        assert trial.stable, name
        assert not trial.faults
        held = trial.push[-1000:].mean() / machine.design.requirements.force_N
        assert 0.4 < held < 0.7  # 0.6, less or more what friction holds


@pytest.mark.slow
def test_a_wall_far_above_the_limit_swings(machine: MachineModel) -> None:
    limit = WallAt(machine).stable(HANDS["light"])
    assert not WallBench(machine, "x", HANDS["light"], "least", loop=BOARD).stands(1.5 * limit)


def test_what_is_capped_from_is_the_worst_of_all_cases(machine: MachineModel) -> None:
    pose, least = machine.centre + np.array([0.0, 0.02, 0.03]), []
    for place, delay in product((0, 1, 2), BOARD.delays):
        at = WallAt(machine, BOARD, pose, AXES["y"], place=place, delay=delay * BOARD.period)
        least.append(at.stable(FREE))
    assert computed_wall(machine, pose, AXES["y"]) == min(least) == least[2]
    assert least[2] < 0.99 * least[5]  # more friction bears more


def test_a_wall_is_capped_by_its_pose(machine: MachineModel) -> None:
    hard = axis_wall("+x", 0.0, stiffness=50e3, damping=0.0)
    corner = machine.centre + machine.half_side
    at_centre, at_corner = (capped(machine, hard, p, DAMPED) for p in (machine.centre, corner))
    assert at_centre.stiffness == pytest.approx(SHARE * computed_wall(machine, machine.centre, AXES["x"], DAMPED))
    assert at_corner.stiffness < at_centre.stiffness
    assert at_centre.damping == DAMPED.damping
    assert at_centre.blend == DAMPED.blend
    soft = capped(machine, axis_wall("-y", 0.0, stiffness=300.0, damping=7.0), corner, DAMPED)
    assert (soft.stiffness, soft.damping) == (300.0, 7.0)


def test_corners_are_the_ends_of_the_ranges() -> None:
    assert len(CORNERS) == 32
    for k, ends in enumerate(RANGES):
        assert {hand[k] for hand in CORNERS.values()} == set(ends)
        assert all(ends[0] <= hand[k] <= ends[1] for hand in HANDS.values())
