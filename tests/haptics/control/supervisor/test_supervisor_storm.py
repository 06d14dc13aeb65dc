"""A million ticks of random faults: what NumPy finds in the log, without asking the supervisor."""

import numpy as np
import pytest

from haptics.control.supervisor.faults import FaultCode, State, findings
from haptics.control.supervisor.limits import checked
from haptics.control.supervisor.memory import DISABLE, RESET, reset_memory
from tests.haptics.control.supervisor.rig import LIMITS, PLANT, with_limits
from tests.haptics.control.supervisor.storm import LYING, Log, empty_log, storm

TICKS, SEED = 1_000_000, 7
QUICK = checked(
    with_limits(
        frozen_time=0.1,
        repeats=500.0,
        all_repeat=400.0,
        probe_time=0.1,
        stale=0.1,
        energy_time=0.1,
        ramp=0.2,
        continuous=0.2,
        derate=40.0,
        hottest=46.0,
        heat=200.0 * LIMITS.motor.heat,
        winding_time=3.0,
        housing_time=20.0,
    )
)
"""The design's limits, with times that a storm can reach, and motors that are hot in seconds."""
ROUNDING = 1e-12
"""N m and J: sums of at most a thousand numbers below 1 that count."""


@pytest.fixture(scope="module")
def log() -> Log:
    return hostile(SEED)


def hostile(seed: int) -> Log:
    """The storm of another seed."""
    filled = empty_log(TICKS)
    storm(QUICK, PLANT, reset_memory(QUICK), TICKS, seed, filled)
    return filled


@pytest.mark.slow
@pytest.mark.parametrize("seed", [7, 8, 9, 10])
def test_every_torque_is_finite_and_within_both_limits(log: Log, seed: int) -> None:
    """Four million ticks."""
    log = log if seed == SEED else hostile(seed)
    assert np.isfinite(log.out).all()
    assert np.abs(log.out).max() <= QUICK.torque
    assert np.abs(log.out).max() > 0.9 * QUICK.torque, "the storm never came near the limit"
    changes = np.abs(np.diff(log.out, axis=0, prepend=0.0)).max()
    most = (QUICK.slew + QUICK.gravity_slew) * QUICK.period
    assert changes <= most + ROUNDING
    assert changes > 0.9 * most, "the storm never came near the slew limit"


def test_every_code_is_reached(log: Log) -> None:
    said = int(np.bitwise_or.reduce(log.bits))
    assert set(findings(said)) == set(FaultCode)


def test_every_state_is_lived_in(log: Log) -> None:
    assert set(np.unique(log.state)) == {int(state) for state in State}


def test_after_a_fault_only_a_reset_leads_out_and_only_to_disabled(log: Log) -> None:
    faulted = log.state[:-1] == State.FAULT
    left = faulted & (log.state[1:] != State.FAULT)
    assert left.sum() > 100
    assert np.all(log.request[1:][left] == RESET)
    assert np.all(log.state[1:][left] == State.DISABLED)
    assert np.array_equal(log.latched != 0, log.state == State.FAULT)
    growing = log.latched[1:] & log.latched[:-1] == log.latched[:-1]
    assert np.all(growing | (log.request[1:] == RESET)), "a latched fault was forgotten without a reset"


def test_force_only_returns_through_the_ramp(log: Log) -> None:
    before, after = log.state[:-1], log.state[1:]
    working = (after == State.ACTIVE) | (after == State.DEGRADED)
    allowed = (before == State.RAMPING) | (before == State.ACTIVE) | (before == State.DEGRADED)
    assert np.all(allowed[working])
    assert np.all(before[(after == State.RAMPING) & (before != State.RAMPING)] == State.DISABLED)


def test_the_torque_goes_to_zero_after_a_fault_that_asks_for_it_and_when_disabled(log: Log) -> None:
    gone = int(np.ceil(QUICK.torque / (QUICK.gravity_slew * QUICK.period))) + 1
    strict = FaultCode.EMERGENCY_STOP.bit | FaultCode.ANGLE_INVALID.bit | FaultCode.DEVICE_LOST.bit
    for off in (log.latched & strict != 0, log.state == State.DISABLED):
        run = np.zeros(len(off), dtype=int)
        starts = np.flatnonzero(off & ~np.concatenate([[False], off[:-1]]))
        index = np.arange(len(off))
        started = np.zeros(len(off), dtype=int)
        started[starts] = starts
        run = index - np.maximum.accumulate(started)
        settled = off & (run >= gone)
        assert settled.sum() > 1000
        assert np.all(log.out[settled] == 0.0)


def test_the_hand_is_given_no_more_than_the_tank_holds(log: Log) -> None:
    given = (log.rendered[:-1] * np.diff(log.theta, axis=0)).sum(axis=1)
    # half a count for every change of torque, by parts
    change = np.abs(np.diff(log.rendered, axis=0, prepend=0.0)).sum(axis=1)[:-1]
    counted = given - 0.5 * QUICK.encoder_count * change
    # readings that lie, ticks that are late or whose time is wrong: outside the bound, so left out
    excused = np.isin(log.mode[1:], LYING) | (log.dt[1:] > QUICK.late) | np.isin(log.mode[1:], (4, 24))
    counted = np.where(excused, np.minimum(given, 0.0), counted)
    ends = QUICK.encoder_count * 3.0 * QUICK.torque
    enabled = np.flatnonzero((log.state[1:] == State.RAMPING) & (log.state[:-1] == State.DISABLED)) + 1
    worst = 0.0
    for start, end in zip(enabled, [*enabled[1:], len(counted)], strict=True):
        total = np.concatenate([[0.0], np.cumsum(counted[start:end])])
        worst = max(worst, float((total - np.minimum.accumulate(total)).max()))
    assert worst <= QUICK.energy + ends + ROUNDING
    assert worst > 0.5 * QUICK.energy, "the storm never asked for the energy"


def test_without_late_ticks_and_lies_the_tank_is_never_in_debt() -> None:
    calm = empty_log(200_000)
    harmless = QUICK._replace(joint_speed=1e3)
    storm(harmless, PLANT, reset_memory(harmless), len(calm.tank), 3, calm)
    honest = ~np.isin(calm.mode, (1, 2, 3, 4, 5, 6, 8, 15, 24)) & (calm.state != State.FAULT) & (calm.state != 0)
    since = np.zeros(len(honest), dtype=bool)
    clean = False
    for k in range(1, len(honest)):  # clean from an enabling on until something lies
        if calm.state[k] == State.RAMPING and calm.state[k - 1] == State.DISABLED:
            clean = True
        clean = clean and bool(honest[k])
        since[k] = clean
    assert since.sum() > 20_000
    assert calm.tank[since].min() >= -ROUNDING
    assert calm.tank[since].min() < 0.05 * QUICK.energy


def test_the_same_seed_gives_the_same_storm(log: Log) -> None:
    again = empty_log(20_000)
    storm(QUICK, PLANT, reset_memory(QUICK), 20_000, SEED, again)
    assert np.array_equal(again.out, log.out[:20_000])
    assert DISABLE in again.request or RESET in again.request
