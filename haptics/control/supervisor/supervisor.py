"""The supervisor: checks every reading and limits the torque that may reach the motors; compiled.

A controller calls two functions a tick, in this order, on one array of `MEMORY` floats, laid out in `memory`:

    bits = check(limits, memory, now, theta, readings, p, reach, volume)
    bits = limit(limits, memory, rendered, gravity, out)

Before them `left_out` says whether the tick is left out for want of a fresh reading.

`rendered` is J^T of the scene's force, `gravity` what holds the moving bodies; they are limited apart, each with its
own slew limit, because only the first is held to an energy. Nothing is allocated, nothing raises; the bits are those
of `faults`, those present at this tick and those latched together. The reactions are in `faults`, the energy rule in
`energy_tank`, the motors' temperature in `motor_heat`. An encoder that has noise never repeats its reading for long:
`repeats` and `all_repeat` are how long, see `haptics.loop.hardware.sensor_limits`. What can be known of a frozen
encoder without noise, and without false alarms:

- At rest it is rightly still, so stillness alone is nothing. But a joint keeps one count only while the handle
  moves on a sphere about its elbow. A hand draws such a sphere for a while, most of all where friction holds the joint:
  in simulated drawing with trembling hands one joint stood still while another turned 1.0 rad in 3 of 27 runs of 30 s,
  1.2 rad in none. So an encoder that keeps one count while another joint gets `frozen_turn` (1.2 rad, half of its
  range) away from where it was is frozen. Not the path counts but the distance: a hand that trembles along the sphere
  adds up a long path and no distance. Until then the force is that of a wrong pose, within its limits and the tank.
- If all stand still under a rendered torque for `frozen_time`, a weight may hang on the handle, or the encoders' bus is
  dead. The supervisor probes: it takes the force away within `probe_time`. A handle in a hand, or under a weight, or
  against a spring gives way by a count long before that (0.03 N on a stiff hand), and the force comes back. If no
  count changes for another half of that time without force, the encoder is frozen, or the handle jammed: both stop.
- Not detected: all of them dead while no force is rendered; any that flickers between two counts.
"""

from __future__ import annotations

import math

from delta_cad.common.jit import compiled, inlined
from haptics.control.supervisor import memory as m
from haptics.control.supervisor.energy_tank import share_allowed, slewed
from haptics.control.supervisor.faults import ALWAYS, LATCHING, FaultCode, Reaction, State, reacting
from haptics.model.motor_heat import allowed, warmed

_DISABLED, _RAMPING, _ACTIVE = float(State.DISABLED), float(State.RAMPING), float(State.ACTIVE)
_DEGRADED, _FAULT = float(State.DEGRADED), float(State.FAULT)
_WITH_GRAVITY = reacting(Reaction.LOWER, Reaction.DAMP)
_WITH_DAMPING = reacting(Reaction.DAMP, Reaction.BRAKE)
_OFF, _BRAKE = reacting(Reaction.OFF), reacting(Reaction.BRAKE)
_LOWERING = reacting(Reaction.LOWER, Reaction.DAMP, Reaction.BRAKE)
# bits of the faults, looked up by name: compiled code knows no properties
_ANGLE_INVALID = FaultCode.ANGLE_INVALID.bit
_ANGLE_JUMP = FaultCode.ANGLE_JUMP.bit
_ANGLE_FROZEN = FaultCode.ANGLE_FROZEN.bit
_ANGLE_MISSED = FaultCode.ANGLE_MISSED.bit
_ANGLE_STALE = FaultCode.ANGLE_STALE.bit
_ANGLE_REPEATED = FaultCode.ANGLE_REPEATED.bit
_UNKNOWN = _ANGLE_INVALID | _ANGLE_STALE
ALL_FRESH = 7  # bit i: the reading of joint i was taken since the last tick, and its own check passed
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


@compiled
def left_out(lim, mem, fresh, out):
    """Whether this tick is left out because a reading is not fresh: the last torques then stand.

    The next fresh reading makes a tick that comes late, with all that follows from it. After `unread` ticks in a row
    the tick is made, and `check` finds ANGLE_STALE.

    Args:
        lim: The limits.
        mem: (MEMORY,) memory.
        fresh: Bit i is set if the reading of joint i was taken since the last tick and its own check passed.
        out: (3,) filled with the last torques, N m, if it is left out.
    """
    if fresh & ALL_FRESH == ALL_FRESH:
        mem[m.MISSED] = 0.0
        return False
    mem[m.MISSED] += 1.0
    if mem[m.MISSED] > lim.unread or mem[m.KNOWN] == 0.0:
        return False
    for i in range(3):
        out[i] = mem[m.OUT + i]
    return True


@compiled
def findings_left_out(mem):
    """Bits of a tick that is left out: the last tick's, and ANGLE_MISSED."""
    return int(mem[m.PRESENT]) | int(mem[m.LATCHED]) | _ANGLE_MISSED


@inlined
def _repeated(lim, mem, readings):
    """Bits of readings that repeat."""
    bits, together = 0, True
    for i in range(3):
        same = abs(readings[i] - mem[m.READ + i]) < 0.25 * lim.encoder_count
        mem[m.REPEATS + i] = mem[m.REPEATS + i] + 1.0 if same else 0.0
        mem[m.READ + i] = readings[i]
        if mem[m.REPEATS + i] > lim.repeats:
            bits = _ANGLE_REPEATED
        together = together and same
    mem[m.ALL_REPEAT] = mem[m.ALL_REPEAT] + 1.0 if together else 0.0
    if mem[m.ALL_REPEAT] > lim.all_repeat:
        bits = _ANGLE_REPEATED
    return bits


@inlined
def _clock(lim, mem, now):
    """Bits of the tick's time, and its interval, s."""
    bits, dt = 0, lim.period
    if not math.isfinite(now):
        return _CLOCK_INVALID, dt
    if mem[m.STARTED] == 1.0:
        dt = now - mem[m.NOW]
        if dt < m.SHORTEST * lim.period:
            bits, dt = _CLOCK_INVALID, lim.period
        mem[m.LATE] = max(mem[m.LATE] - dt / lim.late_recovery, 0.0)
        if dt > lim.late:
            mem[m.LATE] += 1.0
            bits |= _TICK_LATE
            if dt > lim.missed or mem[m.LATE] > lim.late_ticks:
                bits |= _DEADLINE_MISSED
        dt = min(dt, m.LONGEST)
    mem[m.STARTED], mem[m.NOW] = 1.0, now
    return bits, dt


@inlined
def _angles(lim, mem, dt, theta):
    """Bits of the angles; takes the tick's energy out of the tank and renews rates and speed bounds."""
    bits, given = 0, 0.0
    known = mem[m.KNOWN] == 1.0
    if mem[m.MISSED] > 0.0:
        bits |= _ANGLE_STALE
    gain = lim.joint_acceleration * lim.late
    for i in range(3):
        if not math.isfinite(theta[i]):
            bits |= _ANGLE_INVALID
        elif known and abs(theta[i] - mem[m.THETA + i]) > lim.joint_speed * dt + lim.encoder_count:
            bits |= _ANGLE_JUMP
    in_time = known and bits == 0 and 0.5 * lim.period <= dt <= lim.late
    for i in range(3):
        turn = theta[i] - mem[m.THETA + i]
        if in_time and mem[m.PACED] == 1.0 and abs(turn) > abs(mem[m.PACE + i]) * dt + lim.kink:
            bits |= _ANGLE_JUMP
        mem[m.PACE + i] = turn / dt
    mem[m.PACED] = 1.0 if in_time else 0.0
    for i in range(3):
        r = mem[m.RENDERED + i]
        if known and bits == 0:
            turn = theta[i] - mem[m.THETA + i]
            given += r * turn
            mem[m.RATE + i] += dt / (dt + lim.velocity_lag) * (turn / dt - mem[m.RATE + i])
            speed = (abs(turn) + lim.encoder_count) / dt
            if dt > lim.late:
                speed += lim.joint_acceleration * dt
            elif speed <= mem[m.FASTEST + i] + gain + 2.0 * lim.encoder_count / dt:
                speed = min(speed, mem[m.FASTEST + i] + gain)
            mem[m.FASTEST + i] = min(speed, lim.joint_speed)
        else:  # not known what the joint did: the most that it can have done
            given += abs(r) * (lim.joint_speed * dt + lim.encoder_count)
            mem[m.RATE + i], mem[m.FASTEST + i] = 0.0, lim.joint_speed
        if theta[i] < lim.theta_low or theta[i] > lim.theta_high:
            bits |= _JOINT_RANGE
    mem[m.TANK] = min(mem[m.TANK] - given, lim.energy)
    mem[m.GIVEN] += given
    mem[m.POWER] += dt / (dt + lim.ramp_fall) * (given / dt - mem[m.POWER])
    mem[m.KNOWN] = 0.0 if bits & _UNKNOWN else 1.0
    for i in range(3):
        mem[m.THETA + i] = theta[i]
    return bits


@inlined
def _frozen(lim, mem, dt, theta, fresh):
    """Bits of encoders that stand still; see the module's text."""
    bits, probing = 0, False
    for i in range(3):
        if fresh or abs(theta[i] - mem[m.ANCHOR + 3 * i + i]) > 0.5 * lim.encoder_count:
            mem[m.LOADED + i] = mem[m.STILL + i] = 0.0
            for j in range(3):
                mem[m.ANCHOR + 3 * i + j] = theta[j]
            continue
        for j in range(3):
            if abs(theta[j] - mem[m.ANCHOR + 3 * i + j]) > lim.frozen_turn:
                bits |= _ANGLE_FROZEN
        loaded = abs(mem[m.RENDERED + i]) > lim.frozen_torque
        mem[m.LOADED + i] = mem[m.LOADED + i] + dt if loaded else 0.0
        if mem[m.LOADED + i] > lim.frozen_time:
            mem[m.STILL + i] = 1.0
        probing = probing or mem[m.STILL + i] == 1.0
    if probing:
        bits |= _FROZEN_SUSPECTED
        mem[m.PROBE] = max(mem[m.PROBE] - dt / lim.probe_time, -0.5)
        if mem[m.PROBE] <= -0.5:
            bits |= _ANGLE_FROZEN
    else:
        mem[m.PROBE] = min(max(mem[m.PROBE], 0.0) + dt / lim.ramp, 1.0)
    return bits


@inlined
def _pose(lim, mem, dt, p, reach, volume, moved):
    """Bits of the handle's position; `moved` if it may be compared with the last one."""
    bits = 0
    mem[m.EDGE] = mem[m.NEAR] = 0.0
    if not (math.isfinite(p[0]) and math.isfinite(p[1]) and math.isfinite(p[2])):
        mem[m.PLACED] = 0.0
        return _NOT_CLOSED
    if not (reach >= lim.reach_min and volume >= lim.volume_min):
        bits |= _SINGULAR
    else:
        mem[m.NEAR] = min(
            (reach - lim.reach_min) / (lim.reach_low - lim.reach_min),
            (volume - lim.volume_min) / (lim.volume_low - lim.volume_min),
            1.0,
        )
        if mem[m.NEAR] < 1.0:
            bits |= _SINGULAR_NEAR
    middle = lim.cube_bottom + lim.cube_half
    x = max(abs(p[0] - lim.cube_x) - lim.cube_half, 0.0)
    y = max(abs(p[1]) - lim.cube_half, 0.0)
    z = max(abs(p[2] - middle) - lim.cube_half, 0.0)
    outside = math.sqrt(x * x + y * y + z * z)
    mem[m.EDGE] = min(max((lim.edge_far - outside) / (lim.edge_far - lim.edge_margin), 0.0), 1.0)
    if outside > lim.edge_far:
        bits |= _EDGE_FAR
    elif outside > lim.edge_margin:
        bits |= _EDGE_LEFT
    square = 0.0
    for k in range(3):
        if moved and mem[m.PLACED] == 1.0:
            mem[m.SPEED + k] += dt / (dt + lim.velocity_lag) * ((p[k] - mem[m.PLACE + k]) / dt - mem[m.SPEED + k])
        else:
            mem[m.SPEED + k] = 0.0
        mem[m.PLACE + k] = p[k]
        square += mem[m.SPEED + k] * mem[m.SPEED + k]
    mem[m.PLACED] = 1.0
    if not square <= lim.speed * lim.speed:
        bits |= _OVERSPEED
        if not math.isfinite(square):
            mem[m.PLACED] = 0.0  # the filter starts anew
    return bits


@inlined
def _motors(lim, mem, dt):
    """Bits of the motors' temperatures after what was written last."""
    bits = 0
    mem[m.ALLOWED] = lim.torque
    for i in range(3):
        winding, housing = warmed(lim.motor, mem[m.WINDING + i], mem[m.HOUSING + i], mem[m.OUT + i], dt)
        mem[m.WINDING + i], mem[m.HOUSING + i] = winding, housing
        mem[m.ALLOWED] = min(mem[m.ALLOWED], allowed(lim.motor, lim.torque, winding))
        if winding >= lim.motor.hottest:
            bits |= _MOTOR_HOT
        if winding > lim.motor.derate:
            bits |= _MOTOR_WARM
    return bits


@inlined
def _ramp(lim, mem, dt):
    """Bits of the force that comes in: it does so only while the scene does not push the handle away."""
    if mem[m.POWER] > lim.ramp_power:
        mem[m.SCALE] = max(mem[m.SCALE] - dt / lim.ramp_fall, 0.0)
        return _RAMP_HELD
    mem[m.SCALE] = min(mem[m.SCALE] + dt / lim.ramp, 1.0)
    return 0


@compiled
def check(lim, mem, now, theta, readings, p, reach, volume):
    """Checks what was read, and moves the state on. Call it once a tick, before `limit`.

    Args:
        lim: The limits, `SafetyLimits`.
        mem: (MEMORY,) memory.
        now: Time of the reading, s; any clock that only grows.
        theta: (3,) shoulder angles, rad; NaN for an encoder that knows of its own fault.
        readings: (3,) of the encoders, rad: `theta` before a calibration.
        p: (3,) position by forward kinematics of `theta`, m; NaN where there is none.
        reach: Smallest closure w of the three chains at p, m; see `pose_margins.pose_margins`.
        volume: det S / L_B^3 at p.

    Returns:
        Bits of what is present and of what is latched.
    """
    mem[m.TICKS] += 1.0
    mem[m.CHECKED] = 1.0
    fresh = mem[m.KNOWN] == 0.0
    bits, dt = _clock(lim, mem, now)
    read = _angles(lim, mem, dt, theta)
    bits |= read | int(mem[m.SIGNALS])
    good = read & (_UNKNOWN | _ANGLE_JUMP) == 0
    bits |= _repeated(lim, mem, readings)
    if good:
        bits |= _frozen(lim, mem, dt, theta, fresh)
    if read & _UNKNOWN:
        mem[m.PLACED] = mem[m.EDGE] = mem[m.NEAR] = 0.0
    else:
        bits |= _pose(lim, mem, dt, p, reach, volume, good and not fresh)
    bits |= _motors(lim, mem, dt)
    if mem[m.NOW] - mem[m.HEARD] > lim.stale:
        bits |= _COMMAND_STALE
        mem[m.STALE] = max(mem[m.STALE] - dt / lim.fade, 0.0)
    else:
        mem[m.STALE] = min(mem[m.STALE] + dt / lim.ramp, 1.0)
    if mem[m.SHORT] == 1.0:
        bits |= _ENERGY_LIMITED
        mem[m.SPENT] += dt
        if mem[m.SPENT] > lim.energy_time:
            bits |= _ENERGY_SPENT
    else:
        mem[m.SPENT] = max(mem[m.SPENT] - dt, 0.0)
    if mem[m.STATE] == _RAMPING:
        bits |= _ramp(lim, mem, dt)
    _move(lim, mem, bits)
    mem[m.PRESENT] = float(bits)
    return bits | int(mem[m.LATCHED])


@inlined
def _forget(mem):
    """Ends the search for a frozen encoder."""
    mem[m.PROBE] = 1.0
    for i in range(3):
        mem[m.LOADED + i] = mem[m.STILL + i] = 0.0


@inlined
def _move(lim, mem, bits):
    """The operator's request, the latch, and the state that follows."""
    request = int(mem[m.REQUEST])
    mem[m.REQUEST] = 0.0
    if request == m.RESET and mem[m.STATE] == _FAULT:
        mem[m.STATE], mem[m.LATCHED] = _DISABLED, 0.0
        _forget(mem)
    elif request == m.DISABLE and mem[m.STATE] != _FAULT:
        mem[m.STATE] = _DISABLED
    elif request == m.ENABLE and mem[m.STATE] == _DISABLED and bits & (LATCHING | _MOTOR_WARM) == 0:
        mem[m.STATE], mem[m.HEARD], mem[m.TANK] = _RAMPING, mem[m.NOW], lim.energy_start
        mem[m.SCALE] = mem[m.SPENT] = mem[m.SHORT] = mem[m.LATE] = mem[m.GIVEN] = 0.0
        mem[m.STALE] = 1.0
        _forget(mem)
    latching = bits & (ALWAYS if mem[m.STATE] == _DISABLED else LATCHING)
    if latching:
        mem[m.LATCHED] = float(int(mem[m.LATCHED]) | latching)
        mem[m.STATE] = _FAULT
    elif mem[m.STATE] == _RAMPING and mem[m.SCALE] >= 1.0:
        mem[m.STATE] = _ACTIVE
    if mem[m.STATE] == _ACTIVE or mem[m.STATE] == _DEGRADED:
        mem[m.STATE] = _ACTIVE if bits == 0 else _DEGRADED


@compiled
def limit(lim, mem, rendered, gravity, out):
    """Limits the wanted torques to what may go to the motors. Call it once a tick, after `check`.

    Args:
        lim: The limits.
        mem: (MEMORY,) memory.
        rendered: (3,) torque of the scene's force, N m.
        gravity: (3,) torque that holds the moving bodies, N m.
        out: (3,) filled: finite, |out| <= torque, |change| <= (slew + gravity_slew) period, whatever is demanded.

    Returns:
        Bits of what is present and of what is latched.
    """
    wrong = 0 if mem[m.CHECKED] == 1.0 else _ORDER
    mem[m.CHECKED] = 0.0
    for i in range(3):
        if not (math.isfinite(rendered[i]) and math.isfinite(gravity[i])):
            wrong |= _COMMAND_INVALID
    if wrong and mem[m.STATE] != _DISABLED:
        mem[m.LATCHED] = float(int(mem[m.LATCHED]) | wrong)
        mem[m.STATE] = _FAULT
    latched = int(mem[m.LATCHED])
    enabled = mem[m.STATE] != _DISABLED and mem[m.STATE] != _FAULT
    hold = enabled or (latched & _WITH_GRAVITY != 0 and latched & (_OFF | _BRAKE) == 0)
    mem[m.LOWERED] = mem[m.LOWERED] + lim.period if latched & _LOWERING else 0.0
    weight = max(1.0 - mem[m.LOWERED] / lim.lowering, 0.0)
    fade = mem[m.EDGE] * mem[m.NEAR]
    damping = lim.damping * (1.0 - fade) if enabled else 0.0
    if latched & _WITH_DAMPING and latched & _OFF == 0:  # which ends: the encoder that it follows may be the fault
        damping = weight * lim.damping
    factor = mem[m.SCALE] * mem[m.STALE] * max(mem[m.PROBE], 0.0) * fade if enabled else 0.0
    most = min(mem[m.ALLOWED], lim.torque)
    step, small = lim.slew * lim.period, lim.gravity_slew * lim.period
    share = 1.0
    for i in range(3):
        target = weight * min(max(gravity[i], -most), most) if hold and wrong == 0 else 0.0
        held = slewed(target, mem[m.GRAVITY + i], small)
        mem[m.GRAVITY + i] = held
        wanted = factor * rendered[i] if factor > 0.0 and wrong == 0 else 0.0
        wanted -= damping * mem[m.RATE + i]
        if not math.isfinite(wanted):  # a guard: nothing above should let it come to this
            wanted, wrong, mem[m.RATE + i] = 0.0, wrong | _COMMAND_INVALID, 0.0
        mem[m.WANTED + i] = wanted
        room = max(most - held if wanted > 0.0 else most + held, 0.0)
        if abs(wanted) > room:
            share = min(share, room / abs(wanted))
        mem[m.TURNS + i] = lim.late * (mem[m.FASTEST + i] + lim.joint_acceleration * lim.late) + lim.encoder_count
    for i in range(3):
        mem[m.WANTED + i] *= share
    growth = lim.late * lim.late * lim.joint_acceleration
    kept = share_allowed(mem[m.TANK], growth, step, mem)
    mem[m.SHORT] = 1.0 if kept < 1.0 and enabled else 0.0
    for i in range(3):
        torque = slewed(kept * mem[m.WANTED + i], mem[m.RENDERED + i], step)
        mem[m.RENDERED + i] = torque
        # slew >= gravity_slew makes room in time; this only takes a rounding off
        mem[m.OUT + i] = min(max(torque + mem[m.GRAVITY + i], -lim.torque), lim.torque)
        out[i] = mem[m.OUT + i]
    return int(mem[m.PRESENT]) | wrong | latched
