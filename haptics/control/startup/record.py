"""The data of a start-up: records of plain floats, layout of its memory, its steps."""

from __future__ import annotations

from enum import IntEnum
from typing import NamedTuple

import numpy as np

from haptics.control.pose import Model
from haptics.control.supervisor.limits import SafetyLimits


class Step(IntEnum):
    """What a start-up is doing. Every step but the first two moves the device."""

    SETTLE = 0
    ENABLE = 1
    SIGN = 2
    RELAX = 3
    RAISE = 4
    PULSE = 5
    RETURN = 6
    GRAVITY = 7
    RANGE = 8
    LOWER = 9
    READY = 10
    REFUSED = 11


class Refusal(IntEnum):
    """Why a start-up ended; never renumbered, because boards tell it."""

    NONE = 0
    NOT_STILL = 1
    ZERO = 2
    SUPERVISOR = 3
    SIGN = 4
    NO_MOTION = 5
    SWAPPED = 6
    LOST = 7
    GAIN = 8
    GRAVITY = 9
    RANGE = 10


ABOUT: dict[Refusal, tuple[str, str, str]] = {
    Refusal.NOT_STILL: (
        "a joint moves while nothing drives it",
        "rad",
        "hold the device still; a noisy encoder or a loose magnet moves, too",
    ),
    Refusal.ZERO: ("an arm on its lower stop does not read the stop's angle", "rad", "set that encoder's zero"),
    Refusal.SUPERVISOR: ("the supervisor has found a fault; the value is its bits", "bits", "see the table of bits"),
    Refusal.SIGN: ("an arm pushed up reads downwards", "rad", "turn that encoder's sign round"),
    Refusal.NO_MOTION: (
        "an arm pushed up does not move",
        "N m",
        "turn that motor's sign round; look at its wires, the drive and the cable, and for what holds the arm",
    ),
    Refusal.SWAPPED: (
        "another joint moves than the one that is driven",
        "rad",
        "exchange encoders or motors, or that encoder is dead",
    ),
    Refusal.LOST: ("an arm does not follow", "rad", "look for friction, a weak supply, a cable that slips"),
    Refusal.GAIN: (
        "a torque turns a joint more or less than it should",
        "1",
        "correct the torque constant, the ratio or the current's scale",
    ),
    Refusal.GRAVITY: (
        "holding the device takes another torque than the design's",
        "N m",
        "correct gravity_m_s2 (how it is mounted) or the masses; take off what hangs on the handle",
    ),
    Refusal.RANGE: ("the upper stop is not where it should be", "rad", "correct counts a turn, sign or ratio"),
}
"""Refusal -> what was found, the unit of its value and bound, and what to do."""


class StartUp(NamedTuple):
    """Parameters of a start-up, constant while it runs.

    Attributes:
        model: The device as the controller knows it.
        limits: Limits of the supervisor while it runs: from stop to stop, slow and weak.
        absolute: 1 where the encoders know their zero, 0 where the lower stops give it.
        stop_low: Angle of an arm on its lower stop, rad.
        stop_high: On its upper one, rad.
        zero: Largest difference of an absolute reading from the lower stop, rad.
        turn: Turn above which a joint moves, rad.
        still: Time without it after which the device stands, s.
        patience: Time after which it should, s.
        slope: Growth of the push up, N m/s.
        push: Largest push, N m.
        centre: Angle of arm 0 in the cube's centre, rad.
        side_centre: Angle of arms 1 and 2 there, rad.
        speed: Of a joint on its way, rad/s.
        stiffness: Of the hold, N m/rad.
        damping: N m s/rad.
        lag: Time constant of its rates, s.
        lost: Largest distance from where a joint should be, rad.
        pulse: Torque of the torque constant's test, N m.
        pulse_time: s.
        inertia: Arm, rotor and rods' share of a joint, kg m^2.
        carried: Mass that moves with the handle, kg.
        gain: Largest factor by which a joint's answer to a torque is off.
        friction: Nominal friction of a joint, N m.
        stroke: Of the sweep that weighs the device, rad.
        share: Largest share of the holding torque by which it is off.
        range: Largest difference of an upper stop, rad.
    """

    model: Model
    limits: SafetyLimits
    absolute: float
    stop_low: float
    stop_high: float
    zero: float
    turn: float
    still: float
    patience: float
    slope: float
    push: float
    centre: float
    side_centre: float
    speed: float
    stiffness: float
    damping: float
    lag: float
    lost: float
    pulse: float
    pulse_time: float
    inertia: float
    carried: float
    gain: float
    friction: float
    stroke: float
    share: float
    range: float


# Places of the memory, one float each where no length is said
STEP = 0  # a `Step`
CODE = 1  # a `Refusal`
JOINT = 2  # of the refusal; before it the last that moved
VALUE = 3  # of the refusal, unit of its code
BOUND = 4  # of the refusal, unit of its code
BEGUN = 5  # 1 after the first tick
TIME = 6  # in this step, s
CALM = 7  # time without motion, s
TESTED = 8  # joint that is pushed or pulsed
PUSH = 9  # N m
REFERENCE = 10  # (3) where the arms should be, rad
SIDE = 13  # 1 or -1: of a pulse, of the sweep
COUNT = 14  # ticks that were summed
ANSWER = 15  # turn by the first pulse, rad
OFFSET = 16  # (3) what is added to a reading, rad
ANCHOR = 19  # (3) angles at which motion began to be watched, rad
BEFORE = 22  # (3) angles of the last tick, rad
RATE = 25  # (3) low-passed, rad/s
WANTED = 28  # (3) N m
FROZEN = 31  # (3) torque that is kept during a pulse, N m
SUM = 34  # (3) of the hold's torque over the sweep, N m
GAINS = 37  # (3) answer of each joint over what it should be
ANGLES = 40  # (3) reading and offset, rad
MEMORY = 43


class StartMemory(NamedTuple):
    """State of a start-up between ticks, changed in place.

    Attributes:
        start: (MEMORY,) as laid out here.
        supervisor: Of the supervisor.
        work: As the controller's.
    """

    start: np.ndarray
    supervisor: np.ndarray
    work: np.ndarray
