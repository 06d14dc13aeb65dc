"""One push against one wall: what is refused, what friction and a soft wall do, and against the linear loop's limit.

The criterion on series whose answer is known.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from delta_cad.mechanism import forward_kinematics, inverse_kinematics
from haptics.loop.assumptions import CURRENT_LAG, default_estimator, encoder_count, joint_friction
from haptics.loop.discrete import Timing, linear_model
from haptics.loop.linear import linearise
from haptics.loop.wall_trial import LEVELS, WallBench, oscillation, with_friction
from haptics.model.hands import HANDS
from haptics.model.machine import MachineModel
from haptics.model.plant import FREE
from haptics.rendering.law import LawError

MEDIUM = HANDS["medium"]


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
    estimator = linear_model(default_estimator())
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
    import haptics.loop.wall_trial as module

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


T, COUNT, WALL = 1e-3, 3e-5, 3000.0
TIME = np.arange(2000) * T


def judge(x: np.ndarray, **more):
    return oscillation(x, -WALL * np.maximum(x, 0.0), T, COUNT, **more)


def swing(amplitude: float, rate: float = 0.0, frequency: float = 20.0, phase: float = 0.0) -> np.ndarray:
    """Around 1 mm in the wall; `rate` in 1/s."""
    return 1e-3 + amplitude * np.exp(rate * TIME) * np.sin(2 * np.pi * frequency * TIME + phase)


def test_steady_cycle() -> None:
    found = judge(swing(2e-4))
    assert (found.kind, found.oscillates) == ("sustained", True)
    assert found.swing == pytest.approx(4e-4, rel=0.02)  # the line takes a little
    assert found.force_swing == pytest.approx(WALL * 4e-4, rel=0.02)
    assert found.frequency == pytest.approx(20.0, abs=1.0)  # one reversal in 0.5 s
    assert found.contact == 1.0


def test_growth_and_decay() -> None:
    assert judge(swing(2e-5, 2.0)).kind == "grows"
    assert judge(swing(2e-4, -2.0)).kind == "settles"  # falls to 0.37 a window
    assert judge(swing(2e-3, -0.7)).kind == "sustained"  # to 0.70: dies too slowly to be called settled
    assert judge(swing(2e-3, -0.7), decay=0.75).kind == "settles"


@pytest.mark.parametrize("frequency", [5.4, 50.0, 333.0])
def test_any_frequency_of_a_wall_is_seen_at_any_phase(frequency: float) -> None:
    for phase in np.linspace(0.0, 2 * np.pi, 24):
        found = judge(swing(2e-4, frequency=frequency, phase=phase))
        assert found.kind == "sustained"
        assert found.ratio == pytest.approx(1.0, abs=0.05)  # half of what growth begins at
        assert found.frequency == pytest.approx(frequency, abs=1.0)


def test_a_count_to_and_fro_is_quantisation() -> None:
    steps = 1e-3 + COUNT * (np.sin(2 * np.pi * 30.0 * TIME) > 0.0)
    found = judge(steps)
    assert found.kind == "settles"
    assert found.swing == pytest.approx(COUNT, rel=0.1)
    assert judge(steps, counts=0.5).kind == "sustained"


def test_creep_and_bends_are_no_oscillation() -> None:
    assert judge(1e-3 + 5e-4 * TIME).kind == "settles"
    assert judge(2e-3 - 1e-3 * np.exp(-TIME / 0.4)).kind == "settles"
    bend = judge(1e-3 + 2e-3 * (TIME - 1.0) ** 2)  # as much in both windows, and three counts and more
    assert (bend.kind, bend.swing > 3.0 * COUNT) == ("settles", True)
    assert bend.ratio == pytest.approx(1.0, abs=0.01)
    # a cycle on top of creep is one all the same
    assert judge(swing(2e-4) + 5e-4 * TIME).kind == "sustained"


def test_bounce_is_seen_with_its_contact() -> None:
    found = judge(swing(2e-3) - 1e-3)
    assert found.oscillates
    assert found.contact == pytest.approx(0.5, abs=0.02)


def test_handle_at_rest_settles_and_one_that_starts_grows() -> None:
    assert judge(np.full(len(TIME), 1e-3)).kind == "settles"
    x, push = np.zeros(len(TIME)), np.ones(len(TIME))
    still = oscillation(x, push, T, COUNT)
    assert (still.kind, still.swing, still.ratio) == ("settles", 0.0, 0.0)
    x[1500:] = swing(2e-4)[1500:]
    starts = oscillation(x, push, T, COUNT)
    assert (starts.kind, starts.ratio) == ("grows", np.inf)


def test_divergence() -> None:
    x = swing(2e-4)
    x[-3:] = np.nan
    found = oscillation(x, np.zeros(len(x)) + 1.0, T, COUNT)
    assert (found.kind, found.oscillates, found.contact) == ("diverged", True, 1.0)


def test_only_the_last_two_windows_count() -> None:
    x = swing(1e-2)
    x[1000:] = 1e-3
    assert judge(x).kind == "settles"


def test_refusals() -> None:
    x = swing(2e-4)
    with pytest.raises(ValueError, match=" 1 s"):
        oscillation(x, np.zeros(len(x)), T, COUNT)
    for short in (x[:999], x[:0]):
        with pytest.raises(ValueError, match="500 samples"):
            oscillation(short, short, T, COUNT)
    with pytest.raises(ValueError, match="500 samples"):
        oscillation(x, x[:-1], T, COUNT)
    for name in ("period", "resolution", "window"):
        with pytest.raises(ValueError, match=name):
            oscillation(x, x, **{"period": T, "resolution": COUNT, "window": 0.5, name: 0.0})
