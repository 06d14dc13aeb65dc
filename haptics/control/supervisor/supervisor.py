"""The supervisor: whether what was read can be trusted, and what of a wanted torque may reach the motors; compiled.

A controller calls two functions a tick, in this order, on one array of `MEMORY` floats, laid out in `memory`:

    bits = check(limits, memory, now, theta, p, reach, volume)
    bits = limit(limits, memory, rendered, gravity, out)

`rendered` is J^T of the scene's force, `gravity` what holds the moving bodies; they are limited apart, each with its
own slew limit, because only the first is held to an energy. Nothing is allocated, nothing raises; the bits are those
of `faults`, those present at this tick and those latched together. The reactions are in `faults`, the energy rule in
`energy_tank`, the motors' temperature in `motor_heat`. What can be told of a frozen encoder without false alarms:

- At rest an encoder is rightly still, so stillness alone is nothing. But a joint keeps one count only while the handle
  moves on a sphere about its elbow. A hand draws such a sphere for a while, most of all where friction holds the joint:
  in simulated drawing with trembling hands one joint stood still while another turned 1.0 rad in 3 of 27 runs of 30 s,
  1.2 rad in none. So an encoder that keeps one count while another joint gets `frozen_turn` (1.2 rad, half of its
  range) away from where it was is frozen. Not the path counts but the distance: a hand that trembles along the sphere
  adds up a long path and no distance. Until then the force is that of a wrong pose, within its limits and the tank.
- If all stand still under a rendered torque for `frozen_time`, a weight may hang on the handle, or the encoders' bus is
  dead. The supervisor asks: it takes the force away within `probe_time`. A handle in a hand, or under a weight, or
  against a spring gives way by a count long before that (0.03 N on a stiff hand), and the force comes back. If no
  count changes for another half of that time without force, the encoder is frozen, or the handle jammed: both stop.
- Not found: all encoders dead while no force is asked for; one that flickers between two counts.
"""

from __future__ import annotations

import math

from delta_cad.common.jit import compiled, inlined
from haptics.control.supervisor.energy_tank import share_allowed, slewed
from haptics.control.supervisor.faults import ALWAYS, LATCHING, FaultCode, Reaction, State, reacting
from haptics.control.supervisor.memory import (
    ALLOWED,
    ANCHOR,
    CHECKED,
    DISABLE,
    EDGE,
    ENABLE,
    FASTEST,
    GIVEN,
    GRAVITY,
    HEARD,
    HOUSING,
    KNOWN,
    LATCHED,
    LATE,
    LOADED,
    LONGEST,
    NEAR,
    NOW,
    OUT,
    PLACE,
    PLACED,
    POWER,
    PRESENT,
    PROBE,
    RATE,
    RENDERED,
    REQUEST,
    RESET,
    SCALE,
    SHORT,
    SHORTEST,
    SIGNALS,
    SPEED,
    SPENT,
    STALE,
    STARTED,
    STATE,
    STILL,
    TANK,
    THETA,
    TICKS,
    TURNS,
    WANTED,
    WINDING,
)
from haptics.model.motor_heat import allowed, warmed

_DISABLED, _RAMPING, _ACTIVE = float(State.DISABLED), float(State.RAMPING), float(State.ACTIVE)
_DEGRADED, _FAULT = float(State.DEGRADED), float(State.FAULT)
_WITH_GRAVITY = reacting(Reaction.HOLD, Reaction.DAMP)
_WITH_DAMPING = reacting(Reaction.DAMP, Reaction.BRAKE)
_OFF, _BRAKE = reacting(Reaction.OFF), reacting(Reaction.BRAKE)
# bits of the faults, looked up by name: compiled code knows no properties
_ANGLE_INVALID = FaultCode.ANGLE_INVALID.bit
_ANGLE_JUMP = FaultCode.ANGLE_JUMP.bit
_ANGLE_FROZEN = FaultCode.ANGLE_FROZEN.bit
_FROZEN_SUSPECTED = FaultCode.FROZEN_SUSPECTED.bit
_CLOCK_INVALID = FaultCode.CLOCK_INVALID.bit
_TICK_LATE = FaultCode.TICK_LATE.bit
_DEADLINE_MISSED = FaultCode.DEADLINE_MISSED.bit
_EDGE_LEFT = FaultCode.EDGE_LEFT.bit
_EDGE_FAR = FaultCode.EDGE_FAR.bit
_JOINT_RANGE = FaultCode.JOINT_RANGE.bit
_NOT_CLOSED = FaultCode.NOT_CLOSED.bit
_SINGULAR = FaultCode.SINGULAR.bit
_SINGULAR_NEAR = FaultCode.SINGULAR_NEAR.bit
_OVERSPEED = FaultCode.OVERSPEED.bit
_MOTOR_WARM = FaultCode.MOTOR_WARM.bit
_MOTOR_HOT = FaultCode.MOTOR_HOT.bit
_COMMAND_STALE = FaultCode.COMMAND_STALE.bit
_COMMAND_INVALID = FaultCode.COMMAND_INVALID.bit
_RAMP_HELD = FaultCode.RAMP_HELD.bit
_ENERGY_LIMITED = FaultCode.ENERGY_LIMITED.bit
_ENERGY_SPENT = FaultCode.ENERGY_SPENT.bit
_ORDER = FaultCode.ORDER.bit


@inlined
def _clock(lim, mem, now):
    """Bits of the tick's time, and its interval, s."""
    bits, dt = 0, lim.period
    if not math.isfinite(now):
        return _CLOCK_INVALID, dt
    if mem[STARTED] == 1.0:
        dt = now - mem[NOW]
        if dt < SHORTEST * lim.period:
            bits, dt = _CLOCK_INVALID, lim.period
        mem[LATE] = max(mem[LATE] - dt / lim.late_recovery, 0.0)
        if dt > lim.late:
            mem[LATE] += 1.0
            bits |= _TICK_LATE
            if dt > lim.missed or mem[LATE] > lim.late_ticks:
                bits |= _DEADLINE_MISSED
        dt = min(dt, LONGEST)
    mem[STARTED], mem[NOW] = 1.0, now
    return bits, dt


@inlined
def _angles(lim, mem, dt, theta):
    """Bits of the angles; takes the tick's energy out of the tank and renews rates and speed bounds."""
    bits, given = 0, 0.0
    known = mem[KNOWN] == 1.0
    gain = lim.joint_acceleration * lim.late
    for i in range(3):
        if not math.isfinite(theta[i]):
            bits |= _ANGLE_INVALID
        elif known and abs(theta[i] - mem[THETA + i]) > lim.joint_speed * dt + lim.encoder_count:
            bits |= _ANGLE_JUMP
    for i in range(3):
        r = mem[RENDERED + i]
        if known and bits == 0:
            turn = theta[i] - mem[THETA + i]
            given += r * turn
            mem[RATE + i] += dt / (dt + lim.velocity_lag) * (turn / dt - mem[RATE + i])
            speed = (abs(turn) + lim.encoder_count) / dt
            if dt > lim.late:
                speed += lim.joint_acceleration * dt
            elif speed <= mem[FASTEST + i] + gain + 2.0 * lim.encoder_count / dt:
                speed = min(speed, mem[FASTEST + i] + gain)
            mem[FASTEST + i] = min(speed, lim.joint_speed)
        else:  # not known what the joint did: the most that it can have done
            given += abs(r) * (lim.joint_speed * dt + lim.encoder_count)
            mem[RATE + i], mem[FASTEST + i] = 0.0, lim.joint_speed
        if theta[i] < lim.theta_low or theta[i] > lim.theta_high:
            bits |= _JOINT_RANGE
    mem[TANK] = min(mem[TANK] - given, lim.energy)
    mem[GIVEN] += given
    mem[POWER] += dt / (dt + lim.ramp_fall) * (given / dt - mem[POWER])
    mem[KNOWN] = 0.0 if bits & _ANGLE_INVALID else 1.0
    for i in range(3):
        mem[THETA + i] = theta[i]
    return bits


@inlined
def _frozen(lim, mem, dt, theta, fresh):
    """Bits of encoders that stand still; see the module's text."""
    bits, probing = 0, False
    for i in range(3):
        row = ANCHOR + 3 * i
        if fresh or abs(theta[i] - mem[row + i]) > 0.5 * lim.encoder_count:
            mem[LOADED + i] = mem[STILL + i] = 0.0
            for j in range(3):
                mem[row + j] = theta[j]
            continue
        for j in range(3):
            if abs(theta[j] - mem[row + j]) > lim.frozen_turn:
                bits |= _ANGLE_FROZEN
        loaded = abs(mem[RENDERED + i]) > lim.frozen_torque
        mem[LOADED + i] = mem[LOADED + i] + dt if loaded else 0.0
        if mem[LOADED + i] > lim.frozen_time:
            mem[STILL + i] = 1.0
        probing = probing or mem[STILL + i] == 1.0
    if probing:
        bits |= _FROZEN_SUSPECTED
        mem[PROBE] = max(mem[PROBE] - dt / lim.probe_time, -0.5)
        if mem[PROBE] == -0.5:
            bits |= _ANGLE_FROZEN
    else:
        mem[PROBE] = min(max(mem[PROBE], 0.0) + dt / lim.ramp, 1.0)
    return bits


@inlined
def _pose(lim, mem, dt, p, reach, volume, moved):
    """Bits of the handle's position; `moved` if it may be compared with the last one."""
    bits = 0
    mem[EDGE] = mem[NEAR] = 0.0
    if not (math.isfinite(p[0]) and math.isfinite(p[1]) and math.isfinite(p[2])):
        mem[PLACED] = 0.0
        return _NOT_CLOSED
    if not (reach >= lim.reach_min and volume >= lim.volume_min):
        bits |= _SINGULAR
    else:
        mem[NEAR] = min(
            (reach - lim.reach_min) / (lim.reach_low - lim.reach_min),
            (volume - lim.volume_min) / (lim.volume_low - lim.volume_min),
            1.0,
        )
        if mem[NEAR] < 1.0:
            bits |= _SINGULAR_NEAR
    middle = lim.cube_bottom + lim.cube_half
    x = max(abs(p[0]) - lim.cube_half, 0.0)
    y = max(abs(p[1]) - lim.cube_half, 0.0)
    z = max(abs(p[2] - middle) - lim.cube_half, 0.0)
    outside = math.sqrt(x * x + y * y + z * z)
    mem[EDGE] = min(max((lim.edge_far - outside) / (lim.edge_far - lim.edge_margin), 0.0), 1.0)
    if outside > lim.edge_far:
        bits |= _EDGE_FAR
    elif outside > lim.edge_margin:
        bits |= _EDGE_LEFT
    square = 0.0
    for k in range(3):
        if moved and mem[PLACED] == 1.0:
            mem[SPEED + k] += dt / (dt + lim.velocity_lag) * ((p[k] - mem[PLACE + k]) / dt - mem[SPEED + k])
        else:
            mem[SPEED + k] = 0.0
        mem[PLACE + k] = p[k]
        square += mem[SPEED + k] * mem[SPEED + k]
    mem[PLACED] = 1.0
    if not square <= lim.speed * lim.speed:
        bits |= _OVERSPEED
        if not math.isfinite(square):
            mem[PLACED] = 0.0  # the filter starts anew
    return bits


@inlined
def _motors(lim, mem, dt):
    """Bits of the motors' temperatures after what was written last."""
    bits = 0
    mem[ALLOWED] = lim.torque
    for i in range(3):
        winding, housing = warmed(lim, mem[WINDING + i], mem[HOUSING + i], mem[OUT + i], dt)
        mem[WINDING + i], mem[HOUSING + i] = winding, housing
        mem[ALLOWED] = min(mem[ALLOWED], allowed(lim, lim.torque, winding))
        if winding >= lim.hottest:
            bits |= _MOTOR_HOT
        if winding > lim.derate:
            bits |= _MOTOR_WARM
    return bits


@inlined
def _ramp(lim, mem, dt):
    """Bits of the force that comes in: it does so only while the scene does not push the handle away."""
    if mem[POWER] > lim.ramp_power:
        mem[SCALE] = max(mem[SCALE] - dt / lim.ramp_fall, 0.0)
        return _RAMP_HELD
    mem[SCALE] = min(mem[SCALE] + dt / lim.ramp, 1.0)
    return 0


@compiled
def check(lim, mem, now, theta, p, reach, volume):
    """Judges what was read, and moves the state on. Call it once a tick, before `limit`.

    Args:
        lim: The limits, `SafetyLimits`.
        mem: (MEMORY,) memory.
        now: Time of the reading, s; any clock that only grows.
        theta: (3,) shoulder angles as read, rad; NaN for an encoder that knows of its own fault.
        p: (3,) position by forward kinematics of `theta`, m; NaN where there is none.
        reach: Smallest closure w of the three chains at p, m; see `pose_margins.pose_margins`.
        volume: det S / L_B^3 at p.

    Returns:
        Bits of what is present and of what is latched.
    """
    mem[TICKS] += 1.0
    mem[CHECKED] = 1.0
    fresh = mem[KNOWN] == 0.0
    bits, dt = _clock(lim, mem, now)
    read = _angles(lim, mem, dt, theta)
    bits |= read | int(mem[SIGNALS])
    good = read & (_ANGLE_INVALID | _ANGLE_JUMP) == 0
    if good:
        bits |= _frozen(lim, mem, dt, theta, fresh)
    if read & _ANGLE_INVALID:
        mem[PLACED] = mem[EDGE] = mem[NEAR] = 0.0
    else:
        bits |= _pose(lim, mem, dt, p, reach, volume, good and not fresh)
    bits |= _motors(lim, mem, dt)
    if mem[NOW] - mem[HEARD] > lim.stale:
        bits |= _COMMAND_STALE
        mem[STALE] = max(mem[STALE] - dt / lim.fade, 0.0)
    else:
        mem[STALE] = min(mem[STALE] + dt / lim.ramp, 1.0)
    if mem[SHORT] == 1.0:
        bits |= _ENERGY_LIMITED
        mem[SPENT] += dt
        if mem[SPENT] > lim.energy_time:
            bits |= _ENERGY_SPENT
    else:
        mem[SPENT] = max(mem[SPENT] - dt, 0.0)
    if mem[STATE] == _RAMPING:
        bits |= _ramp(lim, mem, dt)
    _move(lim, mem, bits)
    mem[PRESENT] = float(bits)
    return bits | int(mem[LATCHED])


@inlined
def _forget(mem):
    """Ends the search for a frozen encoder."""
    mem[PROBE] = 1.0
    for i in range(3):
        mem[LOADED + i] = mem[STILL + i] = 0.0


@inlined
def _move(lim, mem, bits):
    """The operator's request, the latch, and the state that follows."""
    request = mem[REQUEST]
    mem[REQUEST] = 0.0
    if request == RESET and mem[STATE] == _FAULT:
        mem[STATE], mem[LATCHED] = _DISABLED, 0.0
        _forget(mem)
    elif request == DISABLE and mem[STATE] != _FAULT:
        mem[STATE] = _DISABLED
    elif request == ENABLE and mem[STATE] == _DISABLED and bits & (LATCHING | _MOTOR_WARM) == 0:
        mem[STATE], mem[HEARD], mem[TANK] = _RAMPING, mem[NOW], lim.energy_start
        mem[SCALE] = mem[SPENT] = mem[SHORT] = mem[LATE] = mem[GIVEN] = 0.0
        mem[STALE] = 1.0
        _forget(mem)
    latching = bits & (ALWAYS if mem[STATE] == _DISABLED else LATCHING)
    if latching:
        mem[LATCHED] = float(int(mem[LATCHED]) | latching)
        mem[STATE] = _FAULT
    elif mem[STATE] == _RAMPING and mem[SCALE] == 1.0:
        mem[STATE] = _ACTIVE
    if mem[STATE] == _ACTIVE or mem[STATE] == _DEGRADED:
        mem[STATE] = _ACTIVE if bits == 0 else _DEGRADED


@compiled
def limit(lim, mem, rendered, gravity, out):
    """Limits the wanted torques to what may go to the motors. Call it once a tick, after `check`.

    Args:
        lim: The limits.
        mem: (MEMORY,) memory.
        rendered: (3,) torque of the scene's force, N m.
        gravity: (3,) torque that holds the moving bodies, N m.
        out: (3,) filled: finite, |out| <= torque, |change| <= (slew + gravity_slew) period, whatever is asked for.

    Returns:
        Bits of what is present and of what is latched.
    """
    wrong = 0 if mem[CHECKED] == 1.0 else _ORDER
    mem[CHECKED] = 0.0
    for i in range(3):
        if not (math.isfinite(rendered[i]) and math.isfinite(gravity[i])):
            wrong |= _COMMAND_INVALID
    if wrong and mem[STATE] != _DISABLED:
        mem[LATCHED] = float(int(mem[LATCHED]) | wrong)
        mem[STATE] = _FAULT
    latched = int(mem[LATCHED])
    enabled = mem[STATE] != _DISABLED and mem[STATE] != _FAULT
    hold = enabled or (latched & _WITH_GRAVITY != 0 and latched & (_OFF | _BRAKE) == 0)
    fade = mem[EDGE] * mem[NEAR]
    damping = lim.damping * (1.0 - fade) if enabled else 0.0
    if latched & _WITH_DAMPING and latched & _OFF == 0:
        damping = lim.damping
    factor = mem[SCALE] * mem[STALE] * max(mem[PROBE], 0.0) * fade if enabled else 0.0
    most = min(mem[ALLOWED], lim.torque)
    step, small = lim.slew * lim.period, lim.gravity_slew * lim.period
    share = 1.0
    for i in range(3):
        target = min(max(gravity[i], -most), most) if hold and wrong == 0 else 0.0
        held = slewed(target, mem[GRAVITY + i], small)
        mem[GRAVITY + i] = held
        wanted = factor * rendered[i] if factor > 0.0 and wrong == 0 else 0.0
        wanted -= damping * mem[RATE + i]
        if not math.isfinite(wanted):  # a guard: nothing above should let it come to this
            wanted, wrong, mem[RATE + i] = 0.0, wrong | _COMMAND_INVALID, 0.0
        mem[WANTED + i] = wanted
        room = max(most - held if wanted > 0.0 else most + held, 0.0)
        if abs(wanted) > room:
            share = min(share, room / abs(wanted))
        mem[TURNS + i] = lim.late * (mem[FASTEST + i] + lim.joint_acceleration * lim.late) + lim.encoder_count
    for i in range(3):
        mem[WANTED + i] *= share
    growth = lim.late * lim.late * lim.joint_acceleration
    kept = share_allowed(mem[TANK], growth, step, mem, TURNS, RENDERED, WANTED)
    mem[SHORT] = 1.0 if kept < 1.0 and enabled else 0.0
    for i in range(3):
        torque = slewed(kept * mem[WANTED + i], mem[RENDERED + i], step)
        mem[RENDERED + i] = torque
        # slew >= gravity_slew makes room in time; this only takes a rounding off
        mem[OUT + i] = min(max(torque + mem[GRAVITY + i], -lim.torque), lim.torque)
        out[i] = mem[OUT + i]
    return int(mem[PRESENT]) | wrong | latched
