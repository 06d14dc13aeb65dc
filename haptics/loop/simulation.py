"""The sampled loop: plant, encoders, controller, delay, hold, motors and a hand, one tick after the other; compiled.

At each tick the encoders are read (the middle of the angle's count), the controller turns them into torques, and these
arrive `delay` later and are held until the next ones arrive. With them comes how much the drives damp: more while a
wall is touched. The age of a reading is part of that delay. Between ticks the plant moves on by equal Runge-Kutta
steps. Nothing is random but the place of the encoders' counts and their noise, which a seed gives: the same seed, the
same doubles. A fault of readings or amplifiers (`LoopFault`) begins at a tick and stays, in one joint or in all.
Importing this module loads numba.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import IntEnum
from typing import NamedTuple

import numpy as np

from delta_cad.common.jit import compiled
from haptics.control.controller import FORCE, TOUCHED, VELOCITY, Controller, Memory, fresh, tick
from haptics.control.pose import POSITION
from haptics.control.supervisor.faults import FaultCode, State
from haptics.control.supervisor.memory import ENABLE, RENDERED, REQUEST, SIGNALS, STATE
from haptics.control.supervisor.supervisor import ALL_FRESH
from haptics.model.drive_train import GRASP, HAND_SPEED, KNOB, KNOB_SPEED, MOTOR, SPEED, STATES, TWIST
from haptics.model.plant import FREE, Hand, Plant, angles, energy, moved_on
from haptics.model.sensor import EXACT, SensorErrors, reading

_PAST = 128  # Ticks of readings that are kept for those that come late


class Wrong(IntEnum):
    """What is wrong.

    Of readings all but UNREAD are passed on as fresh: the chip's or the wire's own check saw nothing.
    """

    NOTHING = 0
    FROZEN = 1  # the last reading before the fault again and again
    UNREAD = 2  # the same, and the hardware layer says so
    LATE = 3  # readings of `size` ticks ago
    BIT = 4  # bit `size` of the count turned round, and stuck there
    OFFSET = 5  # `size` rad too much
    DRIFT = 6  # `size` rad/s more and more too much
    SWAPPED = 7  # with that of the next joint
    UNPLUGGED = 8  # all bits up: a turn less a count
    WEAK = 9  # the amplifier gives no torque
    FULL = 10  # the amplifier gives `size` N m, whatever is commanded


class LoopFault(NamedTuple):
    """A fault of a loop; plain numbers, so that compiled code takes it as it is.

    Attributes:
        wrong: A `Wrong`.
        begin: Tick at which it begins.
        joint: 0 to 2; 3 for all.
        size: As `Wrong` says.
        noticed: Ticks after its begin at which the drive signals WATCHDOG; 0 for never.
    """

    wrong: int = 0
    begin: int = 0
    joint: int = 3
    size: float = 0.0
    noticed: int = 0


HEALTHY = LoopFault()
_FROZEN, _UNREAD, _LATE, _BIT = int(Wrong.FROZEN), int(Wrong.UNREAD), int(Wrong.LATE), int(Wrong.BIT)
_OFFSET, _DRIFT, _SWAPPED = int(Wrong.OFFSET), int(Wrong.DRIFT), int(Wrong.SWAPPED)
_UNPLUGGED, _WEAK, _FULL = int(Wrong.UNPLUGGED), int(Wrong.WEAK), int(Wrong.FULL)


@compiled
def _read_wrong(fault, k, period, count, past, read):
    """Spoils the readings of a tick.

    Args:
        fault: `LoopFault`.
        k: Tick.
        period: Of the tick, s.
        count: Of an encoder at the joint, rad; 0 for none.
        past: (PAST + 1, 3) true readings by tick, rad, and in the last row what a reading or a bit is stuck at.
        read: (3,) true readings, spoiled in place, rad.

    Returns:
        Bits of the joints whose readings are said to be fresh.
    """
    for i in range(3):
        past[k % _PAST, i] = read[i]
    if fault.wrong == 0 or k < fault.begin:
        return ALL_FRESH
    fresh = ALL_FRESH
    for i in range(3):
        if fault.joint != 3 and fault.joint != i:
            continue
        if fault.wrong == _FROZEN or fault.wrong == _UNREAD:
            if k == fault.begin:
                past[_PAST, i] = past[(k - 1) % _PAST, i]
            read[i] = past[_PAST, i]
            if fault.wrong == _UNREAD:
                fresh &= ~(1 << i)
        elif fault.wrong == _LATE:
            read[i] = past[(k - int(fault.size)) % _PAST, i]
        elif fault.wrong == _BIT:
            bit = 2.0**fault.size
            digit = math.floor(read[i] / (bit * count)) % 2.0
            if k == fault.begin:
                past[_PAST, i] = 1.0 - digit
            read[i] += (past[_PAST, i] - digit) * bit * count
        elif fault.wrong == _OFFSET:
            read[i] += fault.size
        elif fault.wrong == _DRIFT:
            read[i] += fault.size * (k - fault.begin + 1) * period
        elif fault.wrong == _SWAPPED:
            read[i] = past[k % _PAST, (i + 1) % 3]
            read[(i + 1) % 3] = past[k % _PAST, i]
        elif fault.wrong == _UNPLUGGED:
            read[i] = 2.0 * math.pi - count
    return fresh


@compiled
def _drive_wrong(fault, k, torque):
    """Spoils the torques that motors give at a tick, (3,) N m, in place."""
    if k < fault.begin:
        return
    for i in range(3):
        if fault.joint == 3 or fault.joint == i:
            if fault.wrong == _WEAK:
                torque[i] = 0.0
            elif fault.wrong == _FULL:
                torque[i] = fault.size


SUBSTEPS = 10
_FAULT, _WATCHDOG = float(State.FAULT), float(FaultCode.WATCHDOG.bit)
_SAME = 1e-9  # Share of a period by which a delay of whole periods may be off by rounding


class _LoopTiming(NamedTuple):
    """Clock of the loop.

    Attributes:
        period: T, s.
        ticks: Whole periods from reading to torque.
        late: What the delay has beyond these, s.
        before: Runge-Kutta steps of the plant in a period before the new torque arrives, none where it is not late.
        after: From then on.
    """

    period: float
    ticks: int
    late: float
    before: int
    after: int


@dataclass(frozen=True)
class SimulatedRun:
    """Record of a simulated run, one row a tick, taken when the encoders are read.

    Attributes:
        time: (n,) s.
        position: (n, 3) true position of the handle, m; of the platform where the structure gives way.
        velocity: (n, 3) true velocity, m/s.
        measured: (n, 3) position by the encoders, m.
        estimated: (n, 3) velocity that the controller believes, m/s.
        force: (n, 3) force that the laws render, N.
        torque: (n, 3) torque commanded of the motors, N m.
        applied: (n, 3) torque of the motors at the joints, N m.
        hand: (n, 3) force of the hand on the handle, N.
        energy: (n,) kinetic and potential energy of the device, J.
        bits: (n,) the supervisor's findings.
        state: (n,) the supervisor's state.
        angles: (n, 3) angles as read, rad.
        fresh: (n,) bits of the joints whose readings are said to be fresh.
        rendered: (n, 3) torque commanded for the laws' force, N m.
        shoulders: (n, 3) true angles, rad.
        knob: (n, 3) true position of what the hand holds, m.
    """

    time: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    measured: np.ndarray
    estimated: np.ndarray
    force: np.ndarray
    torque: np.ndarray
    applied: np.ndarray
    hand: np.ndarray
    energy: np.ndarray
    bits: np.ndarray
    state: np.ndarray
    angles: np.ndarray
    fresh: np.ndarray
    rendered: np.ndarray
    shoulders: np.ndarray
    knob: np.ndarray


def timing(period: float = 1e-3, delay: float = 0.0, substeps: int = SUBSTEPS) -> _LoopTiming:
    """A clock.

    Args:
        period: T, s.
        delay: s.
        substeps: Runge-Kutta steps of the plant in a period; at least one before and one after a late torque.

    Raises:
        ValueError: The period is not positive, the delay not within 0 to 100 periods, or the substeps not 1 to 10000.
    """
    if not (math.isfinite(period) and period > 0.0):
        raise ValueError(f"period is {period!r} s; it must be finite and positive")
    if not 1 <= substeps <= 10_000:
        raise ValueError(f"substeps is {substeps!r}; it must be 1 to 10000")
    if not 0.0 <= delay <= 100.0 * period:
        raise ValueError(f"delay is {delay!r} s; it must be 0 to 100 periods")
    ticks = math.floor(delay / period + _SAME)
    late = delay - ticks * period
    if late < _SAME * period:
        return _LoopTiming(float(period), ticks, 0.0, 0, int(substeps))
    before = max(1, round(late / period * substeps))
    return _LoopTiming(float(period), ticks, late, before, max(1, int(substeps) - before))


def simulate(
    machine: Plant,
    controller: Controller,
    laws: np.ndarray,
    clock: _LoopTiming,
    start: np.ndarray,
    *,
    hand: Hand,
    anchor: np.ndarray,
    push: np.ndarray,
    count: float,
    errors: SensorErrors = EXACT,
    seed: int = 0,
    held: np.ndarray | None = None,
    memory: Memory | None = None,
    fault: LoopFault = HEALTHY,
) -> SimulatedRun:
    """Runs the loop.

    Args:
        machine: The true device.
        controller: The controller, whose model of the device may differ.
        laws: (m, COLUMNS) force laws.
        clock: The clock.
        start: (3,) position of the handle at rest, or a (STATES,) state, SI.
        hand: The hand.
        anchor: (n, 3) where the person wants the handle at each tick, m.
        push: (n, 3) further force on the handle, N.
        count: Count of the encoders at the joint, rad; 0 for none.
        errors: What readings have beyond that.
        seed: Seed of the place of the counts, and of the noise.
        held: (n,) whether the hand holds the handle at each tick; None for always.
        memory: Memory of the controller, changed in place; None for a fresh one, enabled at once.
        fault: What goes wrong. Once a fault is latched and no torque is commanded the power stage is off.

    Raises:
        ValueError: Shapes that do not fit, or a count that is negative or not finite.
    """
    ticks = len(anchor)
    held = np.ones(ticks, dtype=bool) if held is None else np.asarray(held, dtype=bool)
    if anchor.shape != (ticks, 3) or push.shape != (ticks, 3) or held.shape != (ticks,):
        raise ValueError(
            f"anchor {anchor.shape} and push {push.shape} must both be (ticks, 3), held {held.shape} (ticks)"
        )
    if not (math.isfinite(count) and count >= 0.0):
        raise ValueError(f"count is {count!r} rad; it must be finite and not negative")
    state = np.zeros(STATES)
    state[: len(start)] = start
    if memory is None:
        memory = fresh(controller)
        memory.supervisor[REQUEST] = ENABLE
    if hand.grasp_stiffness > 0.0 and not hand.mass > 0.0:
        raise ValueError(f"the hand's mass is {hand.mass!r} kg; behind a grasp it must be positive")
    random = np.random.default_rng(seed)
    offset = random.uniform(0.0, 1.0, 3)
    noise = _drawn(random, ticks, errors.kept) if errors.noise > 0.0 else np.zeros((1, 3))
    out = np.empty((ticks, 39))
    bits = np.zeros((ticks, 2), dtype=np.int64)
    pending = np.zeros((clock.ticks + 2, 4))
    anchor, push = np.ascontiguousarray(anchor, dtype=float), np.ascontiguousarray(push, dtype=float)
    hands = (Hand(*map(float, hand)), FREE)
    sensor = (SensorErrors(*map(float, errors)), float(count), offset, noise)
    machines = (machine, machine.in_contact)
    wrong = LoopFault(int(fault.wrong), int(fault.begin), int(fault.joint), float(fault.size), int(fault.noticed))
    _run(machines, controller, memory, laws, clock, hands, held, anchor, push, sensor, wrong, state, pending, out, bits)
    return SimulatedRun(
        time=np.arange(ticks) * clock.period,
        position=out[:, 0:3],
        velocity=out[:, 3:6],
        measured=out[:, 6:9],
        estimated=out[:, 9:12],
        force=out[:, 12:15],
        torque=out[:, 15:18],
        applied=out[:, 18:21],
        hand=out[:, 21:24],
        energy=out[:, 24] + out[:, 25],
        bits=bits[:, 0],
        state=out[:, 29],
        angles=out[:, 30:33],
        fresh=bits[:, 1],
        rendered=out[:, 33:36],
        shoulders=out[:, 36:39],
        knob=out[:, 26:29],
    )


def _drawn(random: np.random.Generator, ticks: int, kept: float) -> np.ndarray:
    """(ticks, 3) normal numbers of variance 1, each with a share of the last."""
    fresh = random.standard_normal((ticks, 3))
    if kept == 0.0:
        return fresh
    from scipy.signal import lfilter

    fresh[1:] *= math.sqrt(1.0 - kept * kept)
    return np.ascontiguousarray(lfilter([1.0], [1.0, -kept], fresh, axis=0))


@compiled
def _run(
    machines, controller, memory, laws, clock, hands, held, anchor, push, sensor, fault, state, pending, out, bits
):
    """Fills out (ticks, 39) and bits (ticks, 2); state and pending are changed. Machines: free, and in contact."""
    machine = machines[0]
    room, past, powered = np.zeros((13, STATES)), np.zeros((_PAST + 1, 3)), True
    theta, torque, read = np.zeros(6), np.zeros(3), np.zeros(3)
    slots = pending.shape[0]
    errors, count, offset, noise = sensor
    angles(machine, state, theta)
    for i in range(3):
        theta[3 + i] = state[TWIST + i]
    for k in range(anchor.shape[0]):
        hand = hands[0] if held[k] else hands[1]
        drawn = noise[k % noise.shape[0]]
        for i in range(3):
            read[i] = reading(errors, i, theta[i], theta[3 + i], drawn[i], count, offset[i])
        for i in range(3):
            out[k, 36 + i] = theta[i]
        bits[k, 1] = _read_wrong(fault, k, clock.period, count, past, read)
        if fault.noticed > 0 and k >= fault.begin + fault.noticed:
            memory.supervisor[SIGNALS] = _WATCHDOG
        bits[k, 0] = tick(controller, memory, laws, k * clock.period, read, read, bits[k, 1], torque)
        out[k, 29] = memory.supervisor[STATE]
        for i in range(3):
            out[k, 15 + i], out[k, 30 + i] = torque[i], read[i]
            out[k, 33 + i] = memory.supervisor[RENDERED + i]
        if out[k, 29] == _FAULT and torque[0] == 0.0 and torque[1] == 0.0 and torque[2] == 0.0:
            powered = False
        if powered:
            _drive_wrong(fault, k, torque)
        pending[k % slots, 3] = memory.work[TOUCHED]
        for i in range(3):
            pending[k % slots, i] = torque[i]
            out[k, i] = state[i]
            out[k, 3 + i] = state[SPEED + i]
            out[k, 6 + i] = memory.work[POSITION, i]
            out[k, 9 + i] = memory.work[VELOCITY, i]
            out[k, 12 + i] = memory.work[FORCE, i]
            out[k, 18 + i] = state[MOTOR + i]
            bends = machine.structure_stiffness > 0.0
            place, speed = state[i] + state[KNOB + i], state[KNOB_SPEED + i] if bends else state[SPEED + i]
            if hand.grasp_stiffness > 0.0:
                moves = hand.grasp_damping * (state[HAND_SPEED + i] - speed)
                out[k, 21 + i] = hand.grasp_stiffness * state[GRASP + i] + moves
            else:
                out[k, 21 + i] = hand.stiffness * (anchor[k, i] - place) - hand.damping * speed
            out[k, 26 + i] = place
        out[k, 24], out[k, 25] = energy(machine, 0.0, state)
        before, after = pending[(k - clock.ticks - 1) % slots], pending[(k - clock.ticks) % slots]
        for part in range(2):  # before a late torque, and from then on
            steps = clock.after if part else clock.before
            if steps > 0:
                command = after if part else before
                seconds = clock.period - clock.late if part else clock.late
                damped = machines[1] if command[3] > 0.0 else machine
                moved_on(damped, hand, anchor[k], push[k], command, seconds, steps, state, theta, room)
