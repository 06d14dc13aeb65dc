"""Findings of the supervisor: code, text, severity, reaction, and how each is cleared.

A finding is a bit, `1 << code`, so that any number of them is one integer. A WARNING is present as long as its
condition is and takes force away smoothly; a FAULT latches until the operator resets it.
"""

from __future__ import annotations

from collections.abc import Iterable
from enum import IntEnum
from typing import NamedTuple


class State(IntEnum):
    """State of the supervisor. Only in the middle three does a scene's force reach the motors."""

    DISABLED = 0
    RAMPING = 1
    ACTIVE = 2
    DEGRADED = 3
    FAULT = 4


class Severity(IntEnum):
    """How grave a finding is."""

    WARNING = 1
    FAULT = 2


class Reaction(IntEnum):
    """What is done, from the mildest; of several latched faults the strictest counts.

    NONE reports. FADE takes the scene's force away as far as the finding says. All others take it away at once, within
    two periods, and differ in the weight: LOWER lets it down within `lowering`, 1 s, since a wrong clock cannot be
    trusted with more; DAMP does the same and adds `-damping theta_dot`, which fades with it: the encoder that both
    follow may be what is wrong; BRAKE damps likewise without the weight, where the pose is known too badly; OFF lets it
    go along `gravity_slew`, all of a joint's torque within 0.2 s. Without any torque a board's power stage goes off.
    """

    NONE = 0
    FADE = 1
    LOWER = 2
    DAMP = 3
    BRAKE = 4
    OFF = 5


class FaultCode(IntEnum):
    """Code of a finding; never renumbered, because logs and boards keep it."""

    ANGLE_INVALID = 1
    ANGLE_JUMP = 2
    ANGLE_FROZEN = 3
    FROZEN_SUSPECTED = 4
    CLOCK_INVALID = 5
    TICK_LATE = 6
    DEADLINE_MISSED = 7
    EDGE_LEFT = 8
    EDGE_FAR = 9
    JOINT_RANGE = 10
    NOT_CLOSED = 11
    SINGULAR = 12
    SINGULAR_NEAR = 13
    OVERSPEED = 14
    MOTOR_WARM = 15
    MOTOR_HOT = 16
    COMMAND_STALE = 17
    COMMAND_INVALID = 18
    RAMP_HELD = 19
    ENERGY_LIMITED = 20
    ENERGY_SPENT = 21
    ORDER = 22
    WATCHDOG = 23
    DEVICE_LOST = 24
    EMERGENCY_STOP = 25
    ANGLE_MISSED = 26
    ANGLE_STALE = 27
    ANGLE_REPEATED = 28

    @property
    def bit(self) -> int:
        """The finding as a mask."""
        return 1 << int(self)


class About(NamedTuple):
    """What a code means and what is done about it.

    Attributes:
        text: The finding.
        severity: WARNING or FAULT.
        reaction: What is done.
        cleared: How it goes away.
    """

    text: str
    severity: Severity
    reaction: Reaction
    cleared: str


_W, _F, _R = Severity.WARNING, Severity.FAULT, Reaction
_RESET = "operator's reset, once the condition is gone"

TABLE: dict[FaultCode, About] = {
    FaultCode.ANGLE_INVALID: About("an encoder reads no number", _F, _R.OFF, _RESET),
    FaultCode.ANGLE_JUMP: About(
        "an encoder moved faster than its joint can turn, or gained speed as no joint can", _F, _R.OFF, _RESET
    ),
    FaultCode.ANGLE_FROZEN: About(
        "an encoder keeps one count while the other joints turn, or while all force is taken away", _F, _R.OFF, _RESET
    ),
    FaultCode.FROZEN_SUSPECTED: About(
        "an encoder keeps one count under a large torque for a time", _W, _R.FADE, "the first count that changes"
    ),
    FaultCode.CLOCK_INVALID: About("the time of a tick is no number or does not grow", _F, _R.LOWER, _RESET),
    FaultCode.TICK_LATE: About("a tick came late", _W, _R.NONE, "the next tick in time"),
    FaultCode.DEADLINE_MISSED: About("ticks are late again and again, or one by far", _F, _R.LOWER, _RESET),
    FaultCode.EDGE_LEFT: About("the handle is outside the certified cube", _W, _R.FADE, "moving it back"),
    FaultCode.EDGE_FAR: About(
        "the handle is far outside the certified cube", _F, _R.DAMP, "moving it back, then reset"
    ),
    FaultCode.JOINT_RANGE: About("a joint is outside its range", _F, _R.DAMP, "moving it back, then reset"),
    FaultCode.NOT_CLOSED: About("no position of the handle fits the angles", _F, _R.OFF, _RESET),
    FaultCode.SINGULAR: About("the mechanism is at a singularity", _F, _R.BRAKE, "moving it away, then reset"),
    FaultCode.SINGULAR_NEAR: About("the mechanism is close to a singularity", _W, _R.FADE, "moving it away"),
    FaultCode.OVERSPEED: About("the handle is too fast", _F, _R.DAMP, "standing still, then reset"),
    FaultCode.MOTOR_WARM: About("a motor is warm; its torque is limited", _W, _R.FADE, "cooling down"),
    FaultCode.MOTOR_HOT: About(
        "a motor is at its largest temperature", _F, _R.OFF, "cooling down till it is not warm, then reset"
    ),
    FaultCode.COMMAND_STALE: About("the host has not spoken for too long", _W, _R.FADE, "the host's next word"),
    FaultCode.COMMAND_INVALID: About("the controller commands no number", _F, _R.OFF, _RESET),
    FaultCode.RAMP_HELD: About(
        "the scene pushes the handle away while its force is coming in", _W, _R.FADE, "the handle at rest or free"
    ),
    FaultCode.ENERGY_LIMITED: About(
        "the hand has been given the energy it may be given", _W, _R.FADE, "work of the hand against the force"
    ),
    FaultCode.ENERGY_SPENT: About("the scene goes on demanding energy that it may not give", _F, _R.DAMP, _RESET),
    FaultCode.ORDER: About("torques were commanded without a check before them", _F, _R.OFF, _RESET),
    FaultCode.WATCHDOG: About("the drive's watchdog has cut the torque", _F, _R.OFF, _RESET),
    FaultCode.DEVICE_LOST: About("the device does not answer", _F, _R.OFF, "the device's answer, then reset"),
    FaultCode.EMERGENCY_STOP: About("emergency stop", _F, _R.OFF, "its release, then reset"),
    FaultCode.ANGLE_MISSED: About(
        "a reading is not fresh; the last torques stand for this tick", _W, _R.NONE, "the next fresh reading"
    ),
    FaultCode.ANGLE_STALE: About("an encoder has given no fresh reading for too many ticks", _F, _R.OFF, _RESET),
    FaultCode.ANGLE_REPEATED: About(
        "an encoder repeats its reading more often than its noise allows", _F, _R.OFF, _RESET
    ),
}


def mask(faults: Iterable[FaultCode]) -> int:
    """The bits of several findings as one integer."""
    bits = 0
    for fault in faults:
        bits |= fault.bit
    return bits


def findings(bits: int) -> tuple[FaultCode, ...]:
    """The findings whose bits are set, by rising code."""
    return tuple(fault for fault in FaultCode if bits & fault.bit)


def described(bits: int) -> str:
    """The findings as text for a log or a message; "no findings" where there is none."""
    parts = [f"{int(f)} {f.name}: {TABLE[f].text} ({TABLE[f].severity.name.lower()})" for f in findings(bits)]
    return "; ".join(parts) or "no findings"


LATCHING = mask(f for f in FaultCode if TABLE[f].severity is Severity.FAULT)  # Bits that latch
ALWAYS = mask((FaultCode.EMERGENCY_STOP,))  # Bits that latch even while nothing is enabled
# Bits that come from outside: a button, or the device.
EXTERNAL = mask((FaultCode.WATCHDOG, FaultCode.DEVICE_LOST, FaultCode.EMERGENCY_STOP))


def reacting(*reactions: Reaction) -> int:
    """Bits of the faults with one of these reactions."""
    return mask(f for f in FaultCode if TABLE[f].severity is Severity.FAULT and TABLE[f].reaction in reactions)
