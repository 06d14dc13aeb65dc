"""Errors of an angle reading in addition to its counts: noise, and a non-linearity over the angle; compiled.

A magnet off its axis, and a chip that sees its field unevenly, err by one and by two waves a turn. The noise of one
reading is normal; a filter of first order in the chip lets some of it stay until the next. That filter's lag, and a
reading's age, are part of the loop's delay. Importing this module loads numba.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from delta_cad.common.jit import inlined

PHASE = 2.1  # Between the errors of two chains, rad: magnets are not glued in step


class SensorErrors(NamedTuple):
    """Errors of a reading; angles of the arm, rad.

    Attributes:
        noise: Standard deviation of one reading.
        once: Largest error of one wave a turn of the sensor.
        twice: Largest error of two waves.
        turns: Turns of the sensor in one of the arm: 1, or the ratio where it sits on the motor.
        at_motor: 1.0 where it sits on the motor, before the cable; else 0.0.
        kept: Share of a reading's noise that is in the next one, too, `e^(-T / tau)` of the chip's filter; 0 for none.
    """

    noise: float = 0.0
    once: float = 0.0
    twice: float = 0.0
    turns: float = 1.0
    at_motor: float = 0.0
    kept: float = 0.0


EXACT = SensorErrors()


@inlined
def reading(errors, i, angle, twist, normal, count, offset):
    """What a sensor reads.

    Args:
        errors: `SensorErrors`.
        i: Chain.
        angle: Shoulder angle, rad.
        twist: Of the cable, rad.
        normal: Number of a normal distribution of mean 0 and variance 1.
        count: Count at the joint, rad; 0 for none.
        offset: Place of the counts, 0 to 1.

    Returns:
        rad; the middle of a count.
    """
    seen = angle + errors.at_motor * twist
    wave = errors.turns * seen + PHASE * i
    seen += errors.noise * normal
    if errors.once > 0.0 or errors.twice > 0.0:
        seen += errors.once * math.sin(wave) + errors.twice * math.sin(2.0 * wave)
    if count > 0.0:
        seen = (math.floor(seen / count + offset) + 0.5 - offset) * count
    return seen
