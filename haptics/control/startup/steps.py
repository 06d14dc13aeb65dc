"""The steps of a start-up: a compiled state machine between encoders and the supervisor; see `startup.record`.

The device lies on its lower stops, by its weight or held there. What is not known yet is not used: until the signs are
found each joint is pushed alone and open loop, up from its stop, by a torque that grows; afterwards the arms follow a
reference. In this order:

- SETTLE: nothing moves while nothing drives. The lower stop gives the zero, or an absolute zero is held against it.
- SIGN, RELAX: each joint is pushed until it turns. Up is right; down is the encoder's sign; no motion the motor's, or
  what is broken; another joint's motion two that are exchanged.
- RAISE: all arms go to the cube's centre, and follow.
- PULSE, RETURN: a torque for some milliseconds, up and down; `turn = (torque - friction) (M^-1)_jj t^2 / 2` with
  `M = I + m J^T J` tells the torque constant with ratio and scale. Up and down together take gravity out.
- GRAVITY: a sweep up and down; friction drops out of the mean of the hold's torque, what is left is an error of weight.
- RANGE, LOWER: all arms go to their upper stops, which tell counts and ratio, and back to the centre.

The supervisor bounds all of it, with limits of its own for this time; what it finds ends the start-up. Importing this
module loads numba.
"""

from __future__ import annotations

import math

from delta_cad.common.jit import compiled, inlined
from haptics.control.pose import HOLDING, POSITION, pose
from haptics.control.startup import record as r
from haptics.control.startup.record import Refusal, Step
from haptics.control.supervisor import memory as m
from haptics.control.supervisor.faults import LATCHING, State
from haptics.control.supervisor.supervisor import ALL_FRESH, check, findings_left_out, left_out, limit

_ACTIVE = float(State.ACTIVE)
_SETTLE, _ENABLE, _SIGN, _RELAX = int(Step.SETTLE), int(Step.ENABLE), int(Step.SIGN), int(Step.RELAX)
_RAISE, _PULSE, _RETURN, _GRAVITY = int(Step.RAISE), int(Step.PULSE), int(Step.RETURN), int(Step.GRAVITY)
_RANGE, _LOWER, _READY, _REFUSED = int(Step.RANGE), int(Step.LOWER), int(Step.READY), int(Step.REFUSED)
_NOT_STILL, _ZERO, _SUPERVISOR = int(Refusal.NOT_STILL), int(Refusal.ZERO), int(Refusal.SUPERVISOR)
_WRONG_SIGN, _NO_MOTION, _SWAPPED = int(Refusal.SIGN), int(Refusal.NO_MOTION), int(Refusal.SWAPPED)
_LOST, _GAIN, _WEIGHT = int(Refusal.LOST), int(Refusal.GAIN), int(Refusal.GRAVITY)
_STOP = int(Refusal.RANGE)
PRESSED = 0.06  # How far beyond the upper stop the arms are sent, rad: the hold then presses them on it
SKIPPED = 0.3  # Share of a stroke in which the friction turns round and is not summed


@compiled
def _refuse(mem, code, joint, value, bound):
    """Ends the start-up; the first refusal stays."""
    if mem[r.STEP] != _REFUSED:
        mem[r.STEP], mem[r.CODE], mem[r.JOINT] = _REFUSED, code, float(joint)
        mem[r.VALUE], mem[r.BOUND] = value, bound


@inlined
def _enter(mem, step):
    """Begins a step."""
    mem[r.STEP] = step
    mem[r.TIME] = mem[r.CALM] = mem[r.PUSH] = mem[r.COUNT] = 0.0
    for i in range(3):
        mem[r.ANCHOR + i] = mem[r.ANGLES + i]
        mem[r.SUM + i] = 0.0


@inlined
def _calm(par, mem, dt):
    """Counts the time for which no joint has moved, and keeps the joint that has moved last."""
    moved = 3
    mem[r.CALM] += dt
    for i in range(3):
        if not abs(mem[r.ANGLES + i] - mem[r.ANCHOR + i]) <= par.turn:
            moved = i
    if moved < 3:
        mem[r.CALM], mem[r.JOINT] = 0.0, float(moved)
        for i in range(3):
            mem[r.ANCHOR + i] = mem[r.ANGLES + i]


@inlined
def _settle(par, mem, supervisor, dt):
    """Stillness, and the zeros."""
    _calm(par, mem, dt)
    if mem[r.CALM] >= par.still:
        for i in range(3):
            off = mem[r.ANGLES + i] - par.stop_low
            if par.absolute < 0.5:
                mem[r.OFFSET + i] -= off
            elif abs(off) > par.zero:
                _refuse(mem, _ZERO, i, off, par.zero)
        if mem[r.STEP] == _SETTLE:
            supervisor[m.REQUEST] = m.ENABLE
            _enter(mem, _ENABLE)
    elif mem[r.TIME] > par.patience:
        _refuse(mem, _NOT_STILL, int(mem[r.JOINT]), par.turn, par.turn)


@inlined
def _sign(par, mem, dt):
    """One joint pushed up until it turns."""
    tested = int(mem[r.TESTED])
    mem[r.PUSH] = min(mem[r.PUSH] + par.slope * dt, par.push)
    turned = mem[r.ANGLES + tested] - mem[r.ANCHOR + tested]
    enough = 4.0 * par.turn
    for i in range(3):
        other = abs(mem[r.ANGLES + i] - mem[r.ANCHOR + i])
        mem[r.WANTED + i] = mem[r.PUSH] if i == tested else 0.0
        if i != tested and other > enough and other > abs(turned):
            _refuse(mem, _SWAPPED, tested, other, enough)
    if turned < -enough:
        _refuse(mem, _WRONG_SIGN, tested, turned, -enough)
    elif turned > enough and mem[r.STEP] == _SIGN:
        mem[r.WANTED + tested] = 0.0
        _enter(mem, _RELAX)
    elif mem[r.TIME] > par.push / par.slope + par.still:
        _refuse(mem, _NO_MOTION, tested, mem[r.PUSH], par.push)


@inlined
def _relax(par, mem, dt):
    """The pushed arm falls back; then the next one, or all of them rise."""
    _calm(par, mem, dt)
    if mem[r.CALM] >= par.still:
        mem[r.TESTED] += 1.0
        if mem[r.TESTED] < 3:
            _enter(mem, _SIGN)
        else:
            mem[r.TESTED] = 0.0
            middle = (mem[r.ANGLES] + mem[r.ANGLES + 1] + mem[r.ANGLES + 2]) / 3.0
            for i in range(3):
                mem[r.REFERENCE + i] = middle
            _enter(mem, _RAISE)
    elif mem[r.TIME] > par.patience:
        _refuse(mem, _NOT_STILL, int(mem[r.JOINT]), par.turn, par.turn)


@compiled
def _follow(par, mem, target, side_target, speed, dt):
    """The references of arm 0 and of arms 1, 2 move on to their targets, the hold after them; whether all are there."""
    step, there = speed * dt, True
    for i in range(3):
        goal = target if i == 0 else side_target
        mem[r.REFERENCE + i] = min(max(goal, mem[r.REFERENCE + i] - step), mem[r.REFERENCE + i] + step)
        there = there and mem[r.REFERENCE + i] == goal  # exact: the clamp above gives the goal itself
        off = mem[r.REFERENCE + i] - mem[r.ANGLES + i]
        if not abs(off) <= par.lost:
            _refuse(mem, _LOST, i, off, par.lost)
        else:
            mem[r.WANTED + i] = par.stiffness * off - par.damping * mem[r.RATE + i]
    return there


@inlined
def _mobility(par, work, j):
    """(M^-1)_jj of the joints, M = I + m J^T J, 1/(kg m^2)."""
    a, b = (j + 1) % 3, (j + 2) % 3
    ja = par.carried * (work[j, 0] * work[a, 0] + work[j, 1] * work[a, 1] + work[j, 2] * work[a, 2])
    jb = par.carried * (work[j, 0] * work[b, 0] + work[j, 1] * work[b, 1] + work[j, 2] * work[b, 2])
    ab = par.carried * (work[a, 0] * work[b, 0] + work[a, 1] * work[b, 1] + work[a, 2] * work[b, 2])
    jj = par.inertia + par.carried * (work[j, 0] * work[j, 0] + work[j, 1] * work[j, 1] + work[j, 2] * work[j, 2])
    aa = par.inertia + par.carried * (work[a, 0] * work[a, 0] + work[a, 1] * work[a, 1] + work[a, 2] * work[a, 2])
    bb = par.inertia + par.carried * (work[b, 0] * work[b, 0] + work[b, 1] * work[b, 1] + work[b, 2] * work[b, 2])
    rest = aa * bb - ab * ab
    return rest / (jj * rest - ja * (ja * bb - jb * ab) + jb * (ja * ab - jb * aa))


@inlined
def _pulse(par, mem, work):
    """One joint, up and then down: its answer to a torque."""
    tested = int(mem[r.TESTED])
    for i in range(3):
        mem[r.WANTED + i] = mem[r.FROZEN + i] + (mem[r.SIDE] * par.pulse if i == tested else 0.0)
    if mem[r.TIME] < par.pulse_time:
        return
    turned = mem[r.SIDE] * (mem[r.ANGLES + tested] - mem[r.ANCHOR + tested])
    if mem[r.SIDE] > 0.0:
        mem[r.ANSWER] = turned
    else:
        due = 0.5 * (par.pulse - par.friction) * _mobility(par, work, tested) * mem[r.TIME] * mem[r.TIME]
        gain = 0.5 * (mem[r.ANSWER] + turned) / due
        mem[r.GAINS + tested] = gain
        if not gain <= par.gain:
            _refuse(mem, _GAIN, tested, gain, par.gain)
        elif not gain >= 1.0 / par.gain:
            _refuse(mem, _GAIN, tested, gain, 1.0 / par.gain)
    if mem[r.STEP] == _PULSE:
        _enter(mem, _RETURN)


@inlined
def _return(par, mem, dt):
    """Back to the centre after a pulse, till all stand; then the next pulse, or the sweep."""
    _follow(par, mem, par.centre, par.side_centre, par.speed, dt)
    if mem[r.STEP] == _RETURN and mem[r.TIME] > par.still:
        if mem[r.SIDE] > 0.0:
            mem[r.SIDE] = -1.0
        else:
            mem[r.SIDE] = 1.0
            mem[r.TESTED] += 1.0
        if mem[r.TESTED] < 3:
            for i in range(3):
                mem[r.FROZEN + i] = mem[r.WANTED + i]
            _enter(mem, _PULSE)
        else:
            _enter(mem, _GRAVITY)


@inlined
def _gravity(par, mem, work, dt):
    """A sweep up and down; the mean of the hold's torque is an error of weight."""
    up = mem[r.SIDE] > 0.0
    stroke = par.stroke if up else 0.0
    there = _follow(par, mem, par.centre + stroke, par.side_centre + stroke, 0.5 * par.speed, dt)
    part = (mem[r.REFERENCE] - par.centre) / par.stroke
    way = part if up else 1.0 - part
    if SKIPPED < way < 1.0:
        mem[r.COUNT] += 1.0
        for i in range(3):
            mem[r.SUM + i] += mem[r.WANTED + i]
    if there and mem[r.STEP] == _GRAVITY:
        if up:
            mem[r.SIDE] = -1.0
            return
        for i in range(3):
            mean = mem[r.SUM + i] / max(mem[r.COUNT], 1.0)
            bound = par.share * abs(work[HOLDING, i]) + 0.25 * par.friction
            if not abs(mean) <= bound:
                _refuse(mem, _WEIGHT, i, mean, bound)
        if mem[r.STEP] == _GRAVITY:
            _enter(mem, _RANGE)


@inlined
def _range(par, mem, dt):
    """All arms on their upper stops."""
    there = _follow(par, mem, par.stop_high + PRESSED, par.stop_high + PRESSED, par.speed, dt)
    if not there:
        mem[r.TIME] = 0.0
    elif mem[r.TIME] > par.still and mem[r.STEP] == _RANGE:
        for i in range(3):
            off = mem[r.ANGLES + i] - par.stop_high
            if not abs(off) <= par.range:
                _refuse(mem, _STOP, i, off, par.range)
        if mem[r.STEP] == _RANGE:
            for i in range(3):
                mem[r.REFERENCE + i] = par.stop_high
            _enter(mem, _LOWER)


@inlined
def _act(par, mem, supervisor, work, dt):
    """What the step does in this tick."""
    step = int(mem[r.STEP])
    mem[r.TIME] += dt
    if step == _SETTLE:
        _settle(par, mem, supervisor, dt)
    elif step == _ENABLE:
        if supervisor[m.STATE] == _ACTIVE:
            _enter(mem, _SIGN)
        elif mem[r.TIME] > par.patience:
            _refuse(mem, _SUPERVISOR, 3, float(int(supervisor[m.PRESENT])), 0.0)
    elif step == _SIGN:
        _sign(par, mem, dt)
    elif step == _RELAX:
        _relax(par, mem, dt)
    elif step == _RAISE:
        if _follow(par, mem, par.centre, par.side_centre, par.speed, dt) and mem[r.STEP] == _RAISE:
            mem[r.SIDE] = -1.0
            mem[r.TESTED] = -1.0
            _enter(mem, _RETURN)
    elif step == _PULSE:
        _pulse(par, mem, work)
    elif step == _RETURN:
        _return(par, mem, dt)
    elif step == _GRAVITY:
        _gravity(par, mem, work, dt)
    elif step == _RANGE:
        _range(par, mem, dt)
    elif step == _LOWER:
        if _follow(par, mem, par.centre, par.side_centre, par.speed, dt) and mem[r.STEP] == _LOWER:
            _enter(mem, _READY)
    elif step == _READY:
        _follow(par, mem, par.centre, par.side_centre, par.speed, dt)


@compiled
def start(par, memory, now, theta, fresh, out):
    """One period of a start-up: readings in, torques out.

    Args:
        par: `StartUp`.
        memory: `StartMemory`, moved on in place.
        now: Time of the reading, s.
        theta: (3,) angles as read, rad; of any zero where that is not absolute.
        fresh: Bit i is set if the reading of joint i was taken since the last tick and its own check passed.
        out: (3,) filled with the torques, N m.

    Returns:
        Bits of what the supervisor found.
    """
    mem, supervisor, work = memory.start, memory.supervisor, memory.work
    if left_out(par.limits, supervisor, fresh, out):
        return findings_left_out(supervisor)
    if mem[r.BEGUN] == 0.0 and fresh == ALL_FRESH:
        mem[r.BEGUN] = mem[r.SIDE] = 1.0
        for i in range(3):
            if par.absolute < 0.5:
                mem[r.OFFSET + i] = par.stop_low - theta[i]
            mem[r.ANCHOR + i] = mem[r.BEFORE + i] = theta[i] + mem[r.OFFSET + i]
    dt = min(max(now - supervisor[m.NOW], 0.0), 2.0 * par.limits.period)
    for i in range(3):
        mem[r.ANGLES + i] = theta[i] + mem[r.OFFSET + i]
        rate = (mem[r.ANGLES + i] - mem[r.BEFORE + i]) / par.limits.period
        mem[r.RATE + i] += par.limits.period / (par.limits.period + par.lag) * (rate - mem[r.RATE + i])
        mem[r.BEFORE + i] = mem[r.ANGLES + i]
    angles, wanted = mem[r.ANGLES : r.ANGLES + 3], mem[r.WANTED : r.WANTED + 3]
    reach, volume = pose(par.model, angles, work)
    bits = check(par.limits, supervisor, now, angles, theta, work[POSITION], reach, volume)
    if bits & LATCHING and mem[r.STEP] != _READY:
        _refuse(mem, _SUPERVISOR, 3, float(bits & LATCHING), 0.0)
    _act(par, mem, supervisor, work, dt)
    held = mem[r.STEP] >= _RAISE and mem[r.STEP] <= _READY
    for i in range(3):
        if not math.isfinite(mem[r.RATE + i]):
            mem[r.RATE + i] = 0.0
        if not (held and math.isfinite(work[HOLDING, i])):
            work[HOLDING, i] = 0.0
    if mem[r.STEP] == _REFUSED:
        supervisor[m.REQUEST] = m.DISABLE
        wanted[...] = 0.0
    return limit(par.limits, supervisor, wanted, work[HOLDING], out)
