"""The supervisor: every code reached by what it is for, every reaction, the states, and nothing said without cause."""

import numpy as np
import pytest

from delta_cad.mechanism import inverse_kinematics
from haptics.control.supervisor import memory as m
from haptics.control.supervisor.faults import (
    TABLE,
    FaultCode,
    Reaction,
    Severity,
    State,
)
from tests.haptics.control.supervisor.rig import GEOMETRY, HOME, LIMITS, Rig, with_limits

PULL = np.array([0.1, -0.15, 0.2])
HOLD = np.array([0.05, 0.06, 0.04])
UP = np.array([0.0, 0.0, 1.0])
FLOOR = np.array([0.0, 0.0, LIMITS.cube_bottom])
GLIDE = 60
"""Ticks in which everything has slewed away: gravity's torque needs 15."""
NAN = float("nan")


def fails(rig: Rig, code: FaultCode) -> None:
    """The fault has latched, and stays when its condition is over."""
    assert rig.supervisor.state is State.FAULT
    assert code in rig.supervisor.latched
    reaction = TABLE[code].reaction
    assert TABLE[code].severity is Severity.FAULT
    rig.glide(HOME)
    out = rig.ticks(GLIDE, PULL, HOLD)
    weight = 1.0 - rig.supervisor.memory[m.LOWERED] / LIMITS.lowering
    assert weight < 1.0 - GLIDE * LIMITS.period or reaction is Reaction.OFF
    rest = weight * HOLD if reaction in (Reaction.LOWER, Reaction.DAMP) else np.zeros(3)
    # a trembling handle (20 um at 10 Hz) under 0.02 N m s/rad: below 1e-3 N m; otherwise rounding
    np.testing.assert_allclose(out, rest, atol=1e-3 if reaction in (Reaction.DAMP, Reaction.BRAKE) else 1e-12)
    out = rig.ticks(round(LIMITS.lowering / LIMITS.period), PULL, HOLD)
    assert np.all(out == 0.0)  # nothing is commanded any more, whatever an encoder says, and the power stage goes off
    assert rig.supervisor.state is State.FAULT
    assert code in rig.supervisor.latched


def recovers(rig: Rig) -> None:
    """Reset and enabled, it works as before."""
    rig.glide(HOME)
    rig.supervisor.enable()
    rig.ticks(3)
    assert rig.supervisor.state is State.FAULT, "enabled without a reset"
    rig.supervisor.reset()
    rig.ticks(1)
    assert rig.supervisor.state is State.DISABLED
    rig.supervisor.enable()
    rig.ticks(600)
    assert rig.supervisor.state is State.ACTIVE
    np.testing.assert_allclose(rig.ticks(GLIDE, PULL, HOLD), PULL + HOLD, atol=1e-12)


def test_everything_is_off_until_enabled_and_all_of_it_comes_through_afterwards() -> None:
    rig = Rig()
    assert np.all(rig.ticks(50, PULL, HOLD) == 0.0)
    assert rig.supervisor.state is State.DISABLED
    rig.supervisor.enable()
    rig.tick(PULL, HOLD)
    assert rig.supervisor.state is State.RAMPING
    rig.ticks(600, PULL, HOLD)
    assert rig.supervisor.state is State.ACTIVE
    assert rig.supervisor.present == ()
    np.testing.assert_allclose(rig.out, PULL + HOLD, atol=1e-12)
    rig.supervisor.disable()
    assert np.all(rig.ticks(GLIDE, PULL, HOLD) == 0.0)
    assert rig.supervisor.state is State.DISABLED


def test_force_comes_in_along_the_ramp() -> None:
    rig = Rig()
    rig.tick()
    rig.supervisor.enable()
    half = rig.ticks(251, PULL)
    np.testing.assert_allclose(half, PULL / 2, rtol=0.01)  # the ramp is 500 ticks; one tick more or less


@pytest.mark.parametrize("wrong", [NAN, np.inf, -np.inf])
def test_an_encoder_without_a_number(wrong: float) -> None:
    rig = Rig().ready()
    rig.tick(PULL, HOLD, theta=inverse_kinematics(GEOMETRY, HOME) + np.array([0.0, wrong, 0.0]), p=[NAN] * 3)
    assert FaultCode.NOT_CLOSED not in rig.supervisor.latched
    fails(rig, FaultCode.ANGLE_INVALID)
    recovers(rig)


def test_an_encoder_that_jumps() -> None:
    step = LIMITS.joint_speed * LIMITS.period
    any_gain = LIMITS._replace(kink=np.inf)
    rig, theta = Rig(any_gain).ready(), inverse_kinematics(GEOMETRY, HOME)
    rig.tick(PULL, theta=theta + np.array([0.99 * step, 0.0, 0.0]))
    assert FaultCode.ANGLE_JUMP not in rig.supervisor.latched
    rig = Rig(any_gain).ready()
    rig.tick(PULL, theta=theta + np.array([0.0, 0.0, -1.02 * step]))
    fails(rig, FaultCode.ANGLE_JUMP)
    recovers(rig)


def test_an_encoder_that_keeps_a_count_while_the_others_turn() -> None:
    rig = Rig(LIMITS._replace(frozen_turn=0.2)).ready()  # within the reach of a line
    stuck = inverse_kinematics(GEOMETRY, HOME)[1]
    for k in range(200):
        rig.p = HOME + np.array([1e-4 * k, 0.0, 0.0])
        theta = inverse_kinematics(GEOMETRY, rig.p)
        theta[1] = stuck
        rig.tick(PULL, HOLD, theta=theta)
    fails(rig, FaultCode.ANGLE_FROZEN)


def test_rest_without_a_force_is_no_fault_however_long() -> None:
    rig = Rig().ready()
    for _ in range(5000):
        rig.tick(0.9 * LIMITS.frozen_torque * np.array([1.0, -1.0, 0.5]), HOLD)
    assert rig.supervisor.present == ()


def test_rest_under_a_large_force_is_questioned_and_an_encoder_that_then_moves_is_healthy() -> None:
    rig = Rig().ready()
    lowest, suspected = 1.0, 0
    for _ in range(5000):
        rig.tick(np.array([0.3, 0.0, 0.0]))
        lowest = min(lowest, rig.out[0] / 0.3)
        if FaultCode.FROZEN_SUSPECTED in rig.supervisor.present:
            suspected += 1
            assert rig.supervisor.state is State.DEGRADED
        if lowest < 0.8:  # the spring of a hand gives way as the force goes
            rig.p = HOME + np.array([0.0, 0.0, 1e-3 * (1.0 - rig.out[0] / 0.3)])
    assert 0.5 < lowest < 0.85
    assert suspected > 0
    assert rig.supervisor.latched == ()


def test_an_encoder_that_keeps_a_count_without_the_force_is_frozen() -> None:
    rig = Rig().ready()
    for _ in range(2400):
        rig.tick(np.array([0.3, 0.0, 0.0]))
    assert rig.supervisor.state is State.FAULT
    fails(rig, FaultCode.ANGLE_FROZEN)
    recovers(rig)


@pytest.mark.parametrize("wrong", [NAN, np.inf, -1.0, 0.0, 1e-320, 1e-9])
def test_a_clock_that_does_not_go_on(wrong: float) -> None:
    rig = Rig().ready()
    last = rig.now
    rig.tick(PULL, HOLD, now=last + wrong)
    rig.now = last
    fails(rig, FaultCode.CLOCK_INVALID)
    recovers(rig)


def test_one_late_tick_is_reported_many_are_a_fault() -> None:
    rig = Rig().ready()
    rig.tick(PULL, HOLD, dt=3e-3)
    assert FaultCode.TICK_LATE in rig.supervisor.present
    assert rig.supervisor.state is State.DEGRADED
    np.testing.assert_allclose(rig.ticks(GLIDE, PULL, HOLD), PULL + HOLD, atol=1e-12)
    assert rig.supervisor.state is State.ACTIVE
    for _ in range(30):  # one in 110 ms: forgotten in between
        rig.tick(dt=3e-3)
        rig.ticks(107)
    assert rig.supervisor.latched == ()
    for _ in range(12):
        rig.tick(PULL, HOLD, dt=3e-3)
    assert rig.supervisor.latched == (FaultCode.DEADLINE_MISSED,)
    fails(rig, FaultCode.DEADLINE_MISSED)
    recovers(rig)


def test_late_ticks_from_before_enabling_do_not_count_afterwards() -> None:
    rig = Rig()
    few = round(LIMITS.late_ticks) - 1
    for _ in range(few):
        rig.tick(dt=3e-3)
    rig.supervisor.enable()
    rig.tick()
    for _ in range(few):
        rig.tick(dt=3e-3)
    assert rig.supervisor.latched == ()
    assert rig.supervisor.state is State.RAMPING


def test_one_tick_that_comes_far_too_late_is_a_fault() -> None:
    rig = Rig().ready()
    rig.tick(PULL, HOLD, dt=0.025)
    fails(rig, FaultCode.DEADLINE_MISSED)


def test_outside_the_cube_the_force_fades_and_far_outside_it_is_off() -> None:
    rig = Rig().ready()
    rig.glide(FLOOR - 0.002 * UP, PULL, HOLD)
    assert rig.supervisor.present == ()
    rig.glide(FLOOR - 0.0075 * UP, PULL, HOLD)  # half-way between 3 and 12 mm outside
    assert FaultCode.EDGE_LEFT in rig.supervisor.present
    assert rig.supervisor.state is State.DEGRADED
    np.testing.assert_allclose(rig.ticks(GLIDE, PULL, HOLD), PULL / 2 + HOLD, atol=1e-3)  # 20 um of 9 mm, and the brake
    rig.glide(FLOOR - 0.0125 * UP, PULL, HOLD)
    fails(rig, FaultCode.EDGE_FAR)
    recovers(rig)


def test_the_edge_brakes_a_moving_handle() -> None:
    rig = Rig().ready()
    rig.glide(FLOOR - 0.0075 * UP)
    before = inverse_kinematics(GEOMETRY, rig.p)
    for _ in range(5):
        rig.p = rig.p + np.array([0.0, 0.0, -2e-4])
        rig.tick()
    turning = inverse_kinematics(GEOMETRY, rig.p) - before
    assert np.all(rig.out * turning < 0.0)


def test_a_joint_outside_its_range() -> None:
    rig = Rig(LIMITS._replace(theta_high=float(inverse_kinematics(GEOMETRY, HOME).max()) + 0.05)).ready()
    rig.glide(HOME + 0.012 * UP)
    fails(rig, FaultCode.JOINT_RANGE)


def test_angles_that_fit_no_position() -> None:
    rig = Rig().ready()
    rig.tick(PULL, HOLD, p=[NAN] * 3)
    fails(rig, FaultCode.NOT_CLOSED)
    recovers(rig)


@pytest.mark.parametrize("which", [0, 1])
def test_close_to_a_singularity_the_force_fades_and_at_it_there_is_none(which: int) -> None:
    low, least = ((LIMITS.reach_low, LIMITS.reach_min), (LIMITS.volume_low, LIMITS.volume_min))[which]
    margins = [1.0, 1.0]
    margins[which] = 0.75 * low + 0.25 * least
    rig = Rig().ready()
    rig.ticks(GLIDE, PULL, HOLD, margins=tuple(margins))
    assert FaultCode.SINGULAR_NEAR in rig.supervisor.present
    np.testing.assert_allclose(rig.out, 0.75 * PULL + HOLD, atol=1e-3)  # a quarter of the braking of a trembling hand
    for broken in (0.99 * least, NAN):
        margins[which] = broken
        rig = Rig().ready()
        rig.tick(PULL, HOLD, margins=(margins[0], margins[1]))
        fails(rig, FaultCode.SINGULAR)
        recovers(rig)


def test_a_handle_that_is_too_fast_is_braked() -> None:
    rig = Rig().ready()
    before = inverse_kinematics(GEOMETRY, rig.p)
    for k in range(14):
        rig.p = rig.p + np.array([min(4e-4 * (k + 1), 2.2e-3), 0.0, 0.0])
        rig.tick(PULL, 0.0 * HOLD)
    assert FaultCode.OVERSPEED in rig.supervisor.latched
    turning = inverse_kinematics(GEOMETRY, rig.p) - before
    assert np.dot(rig.out, turning) < 0.0
    fails(rig, FaultCode.OVERSPEED)
    recovers(rig)


def test_a_position_beyond_all_numbers_is_too_fast_and_forgotten() -> None:
    rig = Rig().ready()
    rig.tick(PULL, HOLD, p=[1e300, 0.0, 0.0], margins=(1.0, 1.0))
    assert FaultCode.OVERSPEED in rig.supervisor.latched
    rig.ticks(GLIDE)
    assert rig.supervisor.present == ()


def test_a_motor_gets_warm_then_hot_and_the_torque_less_before() -> None:
    cold = with_limits(ambient=90.0, heat=100.0 * LIMITS.motor.heat, continuous=0.2, derate=95.0)
    rig = Rig(cold).ready()
    seen = set()
    for _ in range(4000):
        rig.ticks(1, [0.7, 0.0, 0.0])
        seen.update(rig.supervisor.present)
        if FaultCode.MOTOR_WARM in rig.supervisor.present and rig.supervisor.state is State.DEGRADED:
            hottest = rig.supervisor.memory[m.WINDING]
            share = np.clip((hottest - 95.0) / 30.0, 0.0, 1.0)
            assert rig.out[0] <= 0.8 - 0.6 * share + 1e-12
        if rig.supervisor.state is State.FAULT:
            break
    assert seen == {FaultCode.MOTOR_WARM, FaultCode.MOTOR_HOT}
    fails(rig, FaultCode.MOTOR_HOT)
    rig.supervisor.reset()
    rig.tick()
    rig.supervisor.enable()
    rig.tick()
    assert rig.supervisor.state is State.DISABLED, "still hot"


def test_without_the_hosts_word_the_force_fades_and_comes_back_with_it() -> None:
    rig = Rig(LIMITS._replace(stale=0.1))
    rig.tick()
    rig.supervisor.enable()
    for _ in range(600):
        rig.supervisor.heard()
        rig.ticks(1)
    assert rig.supervisor.state is State.ACTIVE
    rig.ticks(98, PULL, HOLD)
    assert rig.supervisor.present == ()
    rig.ticks(103, PULL, HOLD)
    assert rig.supervisor.present == (FaultCode.COMMAND_STALE,)
    np.testing.assert_allclose(rig.out, 0.5 * PULL + HOLD, atol=4e-3)  # 100 of 200 ticks, 3 of them uncertain
    np.testing.assert_allclose(rig.ticks(150, PULL, HOLD), HOLD, atol=1e-12)
    for _ in range(510):
        rig.supervisor.heard()
        rig.ticks(1, PULL, HOLD)
    np.testing.assert_allclose(rig.out, PULL + HOLD, atol=1e-12)


@pytest.mark.parametrize("wrong", [NAN, np.inf, -np.inf])
@pytest.mark.parametrize("which", [0, 1])
def test_a_controller_that_asks_for_no_number(wrong: float, which: int) -> None:
    rig = Rig().ready()
    rig.ticks(5, PULL, HOLD)
    torques = [PULL.copy(), HOLD.copy()]
    torques[which][2] = wrong
    rig.tick(*torques)
    fails(rig, FaultCode.COMMAND_INVALID)
    recovers(rig)


def test_while_disabled_a_wrong_command_is_only_left_out() -> None:
    rig = Rig()
    assert np.all(rig.tick([NAN] * 3, [np.inf] * 3) == 0.0)
    assert rig.supervisor.state is State.DISABLED


@pytest.mark.parametrize("huge", [1e3, 1e300])
def test_a_torque_beyond_the_limit_keeps_its_direction_after_gravity(huge: float) -> None:
    rig = Rig().ready()
    out = rig.ticks(GLIDE, huge * PULL, HOLD)
    rendered = out - HOLD
    np.testing.assert_allclose(rendered / np.linalg.norm(rendered), PULL / np.linalg.norm(PULL), atol=1e-9)
    assert np.abs(out).max() == pytest.approx(LIMITS.torque, abs=1e-12)


def test_limit_without_check() -> None:
    rig = Rig().ready()
    rig.ticks(3, PULL, HOLD)
    rig.limited(PULL, HOLD)
    fails(rig, FaultCode.ORDER)
    recovers(rig)


@pytest.mark.parametrize("code", [FaultCode.WATCHDOG, FaultCode.DEVICE_LOST, FaultCode.EMERGENCY_STOP])
def test_what_comes_from_outside(code: FaultCode) -> None:
    rig = Rig().ready()
    rig.supervisor.signal(code)
    rig.tick(PULL, HOLD)
    fails(rig, code)
    rig.supervisor.reset()
    rig.ticks(2)
    rig.supervisor.enable()
    rig.ticks(2)
    assert rig.supervisor.state in (State.DISABLED, State.FAULT), "enabled although it is still there"
    rig.supervisor.signal(code, False)
    rig.tick()
    if rig.supervisor.state is State.FAULT:
        recovers(rig)


def test_the_emergency_stop_latches_while_disabled_and_nothing_else_does() -> None:
    rig = Rig()
    rig.tick()
    rig.tick(theta=[NAN] * 3)
    rig.supervisor.signal(FaultCode.WATCHDOG)
    rig.tick()
    assert rig.supervisor.state is State.DISABLED
    rig.supervisor.enable()
    rig.tick()
    assert rig.supervisor.state is State.DISABLED
    rig.supervisor.signal(FaultCode.EMERGENCY_STOP)
    rig.tick()
    assert rig.supervisor.state is State.FAULT


def test_only_outside_findings_can_be_signalled() -> None:
    with pytest.raises(ValueError, match="OVERSPEED"):
        Rig().supervisor.signal(FaultCode.OVERSPEED)


def test_while_the_scene_pushes_the_handle_away_its_force_does_not_come_in() -> None:
    rig = Rig()
    rig.tick()
    rig.supervisor.enable()
    rig.ticks(300, PULL)
    before = rig.supervisor.memory[m.SCALE]
    start = inverse_kinematics(GEOMETRY, rig.p)
    for k in range(40):  # yields at 10 rad/s
        theta = start + PULL / np.linalg.norm(PULL) * 0.01 * (k + 1)
        rig.tick(PULL, theta=theta)
        if k > 3:
            assert FaultCode.RAMP_HELD in rig.supervisor.present or rig.supervisor.memory[m.SCALE] < 0.1
    assert rig.supervisor.memory[m.SCALE] < 0.2 * before
    assert rig.supervisor.state is State.RAMPING


def test_energy_that_is_requested_again_and_again_is_a_fault() -> None:
    rig = Rig().ready()
    swing = 0.0
    seen = set()
    for k in range(8000):  # a force that always goes with the motion
        swing = 2e-4 * np.sign(np.sin(0.02 * k))
        rig.p = rig.p + np.array([0.0, 0.0, swing])
        rig.tick(0.3 * np.sign(swing) * np.ones(3), HOLD)
        seen.update(rig.supervisor.present)
        assert rig.supervisor.memory[m.TANK] >= 0.0
        if rig.supervisor.state is State.FAULT:
            break
    assert {FaultCode.ENERGY_LIMITED, FaultCode.ENERGY_SPENT} <= seen
    fails(rig, FaultCode.ENERGY_SPENT)


def test_the_strictest_of_several_reactions_counts() -> None:
    rig = Rig().ready()
    rig.tick(PULL, HOLD, dt=0.03)
    left = 1.0 - (GLIDE + 1) * LIMITS.period / LIMITS.lowering
    np.testing.assert_allclose(rig.ticks(GLIDE, PULL, HOLD), left * HOLD, atol=1e-12)
    rig.supervisor.signal(FaultCode.EMERGENCY_STOP)
    assert np.all(rig.ticks(GLIDE, PULL, HOLD) == 0.0)


def test_a_fault_that_brakes_takes_gravity_from_one_that_holds() -> None:
    """At a singularity the pose is known too badly to hold the device, whatever else has latched."""
    rig = Rig().ready()
    rig.tick(PULL, HOLD, dt=0.03)
    left = 1.0 - (GLIDE + 1) * LIMITS.period / LIMITS.lowering
    np.testing.assert_allclose(rig.ticks(GLIDE, PULL, HOLD), left * HOLD, atol=1e-12)
    rig.tick(PULL, HOLD, margins=(NAN, NAN))
    assert set(rig.supervisor.latched) == {FaultCode.DEADLINE_MISSED, FaultCode.SINGULAR}
    out = rig.ticks(GLIDE, PULL, HOLD)
    np.testing.assert_allclose(out, 0.0, atol=1e-3)  # the brake of a trembling handle, as in `fails`
