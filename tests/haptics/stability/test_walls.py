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
from haptics.simulation.loops import BOARD, PAPER, RATES_Hz, at_rate
from haptics.stability.passivity import required_friction
from haptics.stability.wall_trial import WallBench
from haptics.stability.walls import NOBODY, SHARE, WallAt, capped, computed_wall
from tests.haptics.scene_machine import scene_machine


@pytest.fixture(scope="module")
def machine(best: Design) -> MachineModel:
    return scene_machine(best)


@pytest.mark.parametrize("axis", ["x", "z"])
def test_four_walls_are_told_apart(machine: MachineModel, axis: str) -> None:
    at = WallAt(machine, normal=AXES[axis])
    four = at.four()
    assert 0.0 < four.own < four.port < four.worst < four.nominal
    assert four.worst_hand == NOBODY
    assert set(four.by_hand) == {NOBODY, *HANDS}
    assert four.formula == pytest.approx(four.worst, rel=0.1)
    assert at.stable(HANDS["medium"]) == four.nominal == four.by_hand["medium"]
    # rigid and by its own damping: the formula without B, and the known condition; with little damping, whose walls are
    # soft beside the cable that stands between rotor and arm
    little = replace(BOARD, contact_damping=BOARD.drive_damping)
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


def test_the_loop_bears_a_good_wall(machine: MachineModel) -> None:
    """5 N/mm at the centre for every hand at the corners of the ranges and none; 2 N/mm everywhere after the cap."""
    for axis in AXES.values():
        four = WallAt(machine, normal=axis).four({**HANDS, **CORNERS})
        assert four.worst > 5000.0
        assert four.port > 5000.0
        assert four.worst > 0.95 * four.by_hand[NOBODY]  # no hand is much worse than none
    assert SHARE * computed_wall(machine, machine.centre, AXES["x"]) > 5000.0
    half = machine.half_side
    for signs in product((-1.0, 1.0), repeat=3):
        pose = machine.centre + half * np.array(signs)
        assert min(SHARE * computed_wall(machine, pose, axis) for axis in AXES.values()) > 2000.0


def test_a_faster_loop_bears_more(machine: MachineModel) -> None:
    rates = [WallAt(machine, at_rate(rate)) for rate in RATES_Hz]
    walls = [at.stable(FREE) for at in rates]
    for (slow, fast), (slower, faster) in zip(pairwise(walls), pairwise(rates), strict=True):
        assert 1.4 < fast / slow < 2.0  # the lags of currents and encoders do not halve
        assert fast / slow == pytest.approx(faster.formula / slower.formula, rel=0.03)
    assert WallAt(machine, PAPER).stable(FREE) < 0.1 * walls[0]  # without damping: what the masses lose, 0.05 N s/m


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
    at_centre, at_corner = (capped(machine, hard, p) for p in (machine.centre, corner))
    assert at_centre.stiffness == pytest.approx(SHARE * computed_wall(machine, machine.centre, AXES["x"]))
    assert at_corner.stiffness < at_centre.stiffness
    assert at_centre.damping == BOARD.damping
    assert at_centre.blend == BOARD.blend
    soft = capped(machine, axis_wall("-y", 0.0, stiffness=300.0, damping=7.0), corner)
    assert (soft.stiffness, soft.damping) == (300.0, 7.0)


def test_corners_are_the_ends_of_the_ranges() -> None:
    assert len(CORNERS) == 32
    for k, ends in enumerate(RANGES):
        assert {hand[k] for hand in CORNERS.values()} == set(ends)
        assert all(ends[0] <= hand[k] <= ends[1] for hand in HANDS.values())
