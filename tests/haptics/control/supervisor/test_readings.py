"""Readings that are not fresh, repeat, or gain speed as no joint can; and the weight after a fault of the clock."""

from __future__ import annotations

import math

import numpy as np
import pytest

from delta_cad.design import Design, design_from_dict
from delta_cad.mechanism import inverse_kinematics
from haptics.control.supervisor import memory as m
from haptics.control.supervisor.faults import FaultCode, State
from haptics.control.supervisor.supervisor import ALL_FRESH, left_out
from haptics.loop.assumptions import encoder_count
from haptics.loop.choice import BOARD, at_rate
from haptics.loop.hardware import QUIETER, ALARM_s, board_controller, sensor_errors, sensor_limits
from haptics.loop.start_up import start_up
from tests.committed import changed
from tests.haptics.control.supervisor.rig import GEOMETRY, HOME, LIMITS, Rig
from tests.haptics.scene_machine import scene_machine

PULL = np.array([0.1, -0.15, 0.2])
HOLD = np.array([0.05, 0.06, 0.04])
REST = inverse_kinematics(GEOMETRY, HOME)


def fresh_tick(rig: Rig, fresh: int, theta: np.ndarray | None = None) -> bool:
    """One tick as the controller makes it; whether it was left out."""
    out = np.full(3, np.nan)
    if left_out(rig.limits, rig.supervisor.memory, fresh, out):
        np.testing.assert_array_equal(out, rig.out)
        rig.now += rig.limits.period
        return True
    rig.tick(PULL, HOLD, theta=theta)
    return False


@pytest.mark.parametrize("fresh", [0, 3, 5, 6])
def test_two_missed_readings_are_left_out_and_the_third_stops(fresh: int) -> None:
    rig = Rig().ready()
    rig.ticks(5, PULL, HOLD)
    assert not fresh_tick(rig, ALL_FRESH)
    assert [fresh_tick(rig, fresh) for _ in range(2)] == [True, True]
    assert not fresh_tick(rig, ALL_FRESH)  # late by then, which is no fault
    assert rig.supervisor.latched == ()
    assert [fresh_tick(rig, fresh) for _ in range(3)] == [True, True, False]
    assert rig.supervisor.latched == (FaultCode.ANGLE_STALE,)
    for _ in range(60):
        fresh_tick(rig, ALL_FRESH)
    assert np.all(rig.out == 0.0)


def test_readings_missed_again_and_again_are_ticks_that_come_late() -> None:
    rig = Rig().ready()
    for k in range(100):
        fresh_tick(rig, ALL_FRESH if k % 3 == 0 else 6)
        if rig.supervisor.latched:
            break
    assert rig.supervisor.latched == (FaultCode.DEADLINE_MISSED,)
    assert k < 40


def test_nothing_is_enabled_on_readings_that_are_not_fresh() -> None:
    rig = Rig()
    for _ in range(5):
        fresh_tick(rig, 6)
    rig.supervisor.enable()
    fresh_tick(rig, 6)
    assert rig.supervisor.state is State.DISABLED
    assert FaultCode.ANGLE_STALE in rig.supervisor.present


@pytest.mark.parametrize("joints", [(0,), (2,), (0, 1), (0, 1, 2)])
def test_readings_that_repeat_are_counted_each_and_all(joints: tuple[int, ...]) -> None:
    """The limit is passed one repeat after it is reached, and one reading that differs begins anew."""
    rig = Rig(LIMITS._replace(repeats=9.0, all_repeat=4.0)).ready()
    allowed = 4 if len(joints) == 3 else 9

    def repeat(times: int) -> None:
        for _ in range(times):
            theta = REST + 1e-4 * rng.uniform(-1.0, 1.0, 3)
            theta[list(joints)] = REST[list(joints)]
            rig.tick(PULL, HOLD, theta=theta)

    rng = np.random.default_rng(3)
    repeat(1 + allowed)  # the first is new
    assert rig.supervisor.latched == ()
    rig.tick(PULL, HOLD, theta=REST + 2e-4)
    repeat(1 + allowed)
    assert rig.supervisor.latched == ()
    repeat(1)
    assert rig.supervisor.latched == (FaultCode.ANGLE_REPEATED,)


@pytest.mark.parametrize("sign", [-1.0, 1.0])
def test_a_gain_of_speed_is_a_fault_and_a_stop_is_none(sign: float) -> None:
    rig = Rig().ready()
    pace, theta = 0.4 * LIMITS.kink, REST.copy()
    for k in range(4):
        theta[1] += sign * min(k, 2) * pace
        rig.tick(theta=theta)
    theta[1] -= sign * 1.9 * pace  # the joint turns round within a tick, as at a stop
    rig.tick(theta=theta)
    assert rig.supervisor.latched == ()
    theta[1] -= sign * (1.9 * pace + 0.98 * LIMITS.kink)
    rig.tick(theta=theta)
    assert rig.supervisor.latched == ()
    theta[1] -= sign * (1.9 * pace + (0.98 + 1.02) * LIMITS.kink)
    rig.tick(theta=theta)
    assert rig.supervisor.latched == (FaultCode.ANGLE_JUMP,)


def test_after_a_fault_of_the_clock_the_weight_is_let_down_within_its_time() -> None:
    rig = Rig().ready()
    rig.ticks(60, PULL, HOLD)
    rig.tick(PULL, HOLD, now=rig.now - 1.0)
    assert rig.supervisor.latched == (FaultCode.CLOCK_INVALID,)
    begun = rig.now
    for share in (0.75, 0.5, 0.25, 0.0):
        while rig.now < begun + (1.0 - share) * LIMITS.lowering - 0.5 * LIMITS.period:
            rig.tick(PULL, HOLD)
        np.testing.assert_allclose(rig.out, share * HOLD, atol=3e-3 * HOLD.max())
    rig.supervisor.reset()
    rig.tick()
    assert rig.supervisor.memory[m.LOWERED] == 0.0


ENCODERS = ("as5048a-board", "as5047p-board", "mt6835-board", "mt6825-board")


@pytest.mark.parametrize("rate_Hz", [8000.0, 1000.0])
@pytest.mark.parametrize("encoder", ENCODERS)
def test_repeats_of_a_stated_noise_are_as_rare_as_the_limit_says(encoder: str, rate_Hz: float) -> None:
    """By drawing: no reading of half the noise is followed by its own count more often than the limit counts on."""
    machine, loop = scene_machine(design_from_dict(changed(hardware__encoder=encoder))), at_rate(rate_Hz)
    found, count = sensor_limits(machine, loop), encoder_count(machine)
    if encoder in ("as5047p-board", "mt6825-board"):  # no noise in their rows
        assert (found["repeats"], found["all_repeat"]) == (math.inf, math.inf)
        return
    errors, rng = sensor_errors(machine, loop), np.random.default_rng(5)
    noise, fresh = np.zeros((100_000, 3)), rng.standard_normal((100_000, 3))
    for k in range(1, len(noise)):
        noise[k] = errors.kept * noise[k - 1] + math.sqrt(1.0 - errors.kept**2) * fresh[k]
    read = np.floor(QUIETER * errors.noise / count * noise + rng.uniform(0.0, 1.0, 3))
    same = read[1:] == read[:-1]
    share, worst = same.mean(), same[np.abs(noise[:-1]) < 0.2].mean()  # in the middle, where long runs are
    alarms = 3.0 * ALARM_s / loop.period
    likely = alarms ** (-1.0 / (found["repeats"] - 1.0)), alarms ** (-1.0 / found["repeats"])
    assert worst < likely[1]  # the alarms of a limit are at most one in its time
    assert worst > 0.9 * likely[0]  # and the limit is no longer than need be
    runs = np.all(same, axis=1)
    assert runs.mean() == pytest.approx(share**3, rel=0.4)  # joints are independent
    assert alarms * share ** (3.0 * found["all_repeat"]) < 3.0


def test_the_default_encoder_is_seen_to_repeat_within_a_few_ticks(best: Design) -> None:
    controller = board_controller(scene_machine(best))
    assert controller.limits.all_repeat < controller.limits.repeats <= 20.0
    start = start_up(scene_machine(best), BOARD.period)
    assert (start.limits.repeats, start.limits.kink) == (controller.limits.repeats, controller.limits.kink)
    on_motor = scene_machine(
        design_from_dict(changed(hardware__encoder_at="motor", hardware__motor="maxon-re30-310009-500"))
    )
    assert sensor_limits(on_motor) == {"repeats": math.inf, "all_repeat": math.inf, "kink": 0.0}
