"""One push against one wall: what is refused, what friction and a soft wall do, and against the linear loop's limit."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from delta_cad.design import Design
from delta_cad.mechanism import forward_kinematics, inverse_kinematics
from haptics.model.hands import HANDS
from haptics.model.machine import MachineModel
from haptics.model.plant import FREE
from haptics.rendering.law import LawError
from haptics.simulation.assumptions import CURRENT_LAG, default_estimator, encoder_count, joint_friction
from haptics.stability.discrete import Timing
from haptics.stability.estimator_models import linear_models
from haptics.stability.linear import linearise
from haptics.stability.wall_trial import LEVELS, WallBench, with_friction
from tests.haptics.scene_machine import scene_machine

MEDIUM = HANDS["medium"]


@pytest.fixture(scope="module")
def machine(best: Design) -> MachineModel:
    return scene_machine(best)


@pytest.mark.parametrize("met", ["x", "-x", "+y", "-z"])
def test_the_hand_leans_on_the_wall(machine: MachineModel, met: str) -> None:
    trial = WallBench(machine, met, MEDIUM).trial(2000.0)
    assert trial.stable
    assert trial.faults == 0
    start, end = trial.recording.position[0], trial.recording.position[-1]
    k, sign = "xyz".index(met[-1]), -1.0 if met[0] == "-" else 1.0
    assert trial.depth[0] == pytest.approx(-2e-3, abs=1e-12)
    assert sign * (end - start)[k] > 2e-3
    assert trial.push[-1] == pytest.approx(2000.0 * trial.depth[-1], abs=2000.0 * trial.resolution)
    assert trial.push.min() >= 0.0
    assert trial.push[trial.depth < -trial.resolution].max() == 0.0


def test_the_resolution_is_a_count_at_the_handle(machine: MachineModel) -> None:
    trial = WallBench(machine, "z", MEDIUM).trial(2000.0)
    g, p = machine.geometry, trial.recording.position[0] + [0.0, 0.0, 2e-3]
    theta, count = inverse_kinematics(g, p), encoder_count(machine)
    moved = [abs((forward_kinematics(g, theta + count * e) - p)[2]) for e in np.eye(3)]
    assert trial.resolution == pytest.approx(max(moved), rel=0.01)  # a count is small, yet finite


def test_a_wall_stands_if_its_trial_is_stable_however_often(machine: MachineModel) -> None:
    bench = WallBench(machine, "y", MEDIUM, seed=5)
    for stiffness, stands in ((1100.0, True), (30e3, False)):
        assert bench.stands(stiffness) == stands
        again = WallBench(machine, "y", MEDIUM, seed=5).trial(stiffness)
        assert again.stable == stands
        np.testing.assert_array_equal(again.depth, bench.trial(stiffness).depth)  # a trial leaves no trace


def test_a_soft_wall_is_leaned_on_with_less(machine: MachineModel) -> None:
    for stiffness in (1e-3, 50.0, 150.0):
        trial = WallBench(machine, "x", MEDIUM).trial(stiffness)
        assert trial.depth.max() < 0.014  # ten millimetres and the swing of arriving
        assert trial.stable
    assert not WallBench(machine, "x", MEDIUM).trial(0.0).stable  # there is no wall to judge


def test_friction_holds_a_wall_that_would_swing(machine: MachineModel) -> None:
    """Frictionless in the linear loop, with all of it in the simulation: the latter bears more."""
    delay, stiffness = 0.5e-3, 3000.0
    here = linearise(with_friction(machine, "least"), WallBench(machine, "x", MEDIUM).trial(0.0).recording.position[0])
    (estimator,) = linear_models(default_estimator())
    timing = Timing(1e-3, delay, CURRENT_LAG)
    assert here.joint_loop(np.eye(3)[0], HANDS["light"], timing, estimator).radius(stiffness, 0.0) > 1.0
    swings = {}
    for level in LEVELS:
        verdict = WallBench(machine, "x", HANDS["light"], level).trial(stiffness).verdict
        assert verdict is not None
        swings[level] = verdict.swing
    assert swings["least"] > swings["nominal"] > swings["largest"]


def test_friction_is_that_of_the_place_in_the_range(machine: MachineModel) -> None:
    friction = joint_friction(machine)
    for k, level in enumerate(LEVELS):
        par = with_friction(machine, level)
        assert (par.coulomb, par.viscous) == (friction.coulomb[k], friction.viscous[k])


def test_a_fault_is_no_stable_wall(machine: MachineModel, monkeypatch: pytest.MonkeyPatch) -> None:
    """A supervisor that takes every speed for too fast."""
    import haptics.stability.wall_trial as module

    def timid(*given: Any, **named: Any) -> Any:
        return default(*given, **named, speed=1e-4)

    default = module.default_controller
    monkeypatch.setattr(module, "default_controller", timid)
    trial = WallBench(machine, "x", MEDIUM).trial(1100.0)
    assert trial.faults
    assert trial.verdict is None
    assert not trial.stable


@pytest.mark.parametrize(
    ("change", "error", "message"),
    [
        ({"met": "w"}, LawError, "met is"),
        ({"met": ""}, LawError, "met is"),
        ({"damping": -1.0}, LawError, "damping is"),
        ({"friction": "some"}, ValueError, "friction is 'some'"),
        ({"hand": FREE}, ValueError, "stiffness is 0.0 N/m"),
        ({"delay": -1e-3}, ValueError, "delay is"),
        ({"period": 0.0}, ValueError, "period is"),
    ],
)
def test_trials_that_are_refused(machine: MachineModel, change: dict[str, Any], error: type, message: str) -> None:
    given: dict[str, Any] = {"met": "x", "hand": MEDIUM, **change}
    met, hand = given.pop("met"), given.pop("hand")
    with pytest.raises(error, match=message):
        WallBench(machine, met, hand, **given)


def test_a_negative_stiffness_is_refused(machine: MachineModel) -> None:
    with pytest.raises(LawError, match=r"stiffness is -1\.0"):
        WallBench(machine, "x", MEDIUM).trial(-1.0)
