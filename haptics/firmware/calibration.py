"""The calibration of one made device in C: readings put right before a tick, torques turned after it."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import float64, typeof

from haptics.control import correction as c
from haptics.control.correction import Correction
from haptics.firmware.numbers import initialiser
from haptics.firmware.precision import Precision
from haptics.firmware.translate import Translation

HEADER = f"""
/* A made device beside the drawn one; without a calibration both are the same and these functions only copy. */
typedef struct {{
    delta_real work[{c.ROWS * 3}];
}} delta_made;

/* What delta_startup_tick is given for the encoders' readings: with zeros and waves where zeros are kept. */
void delta_shoulders(const delta_real reading[3], delta_real theta[3]);
/* What delta_tick is given for them, the start-up's offsets added: the angles of the drawn device at the same place.
 * NaN where there is none, which is fault ANGLE_INVALID. */
void delta_drawn(delta_made *made, const delta_real reading[3], delta_real theta[3]);
/* What the motors are given for delta_tick's torques: those that do the same at the handle, within the limit. */
void delta_turned(const delta_made *made, const delta_real torque[3], delta_real turned[3]);
"""
PLAIN = """\
void delta_shoulders(const delta_real reading[3], delta_real theta[3])
{
    for (int k = 0; k < 3; k++) theta[k] = reading[k];
}

void delta_drawn(delta_made *made, const delta_real reading[3], delta_real theta[3])
{
    (void)made;
    delta_shoulders(reading, theta);
}

void delta_turned(const delta_made *made, const delta_real torque[3], delta_real turned[3])
{
    (void)made;
    delta_shoulders(torque, turned);
}
"""
CODE = """\
static const Correction delta_calibration = {known};

void delta_shoulders(const delta_real reading[3], delta_real theta[3])
{{
    {shoulders}
}}

void delta_drawn(delta_made *made, const delta_real reading[3], delta_real theta[3])
{{
    row read = {{ (delta_real *)reading, 3 }}; /* only read */
    table out = {{ made->work, {rows}, 3, 3 }};
    correction_correct(&delta_calibration, read, out);
    for (int k = 0; k < 3; k++) theta[k] = made->work[{drawn} + k];
}}

void delta_turned(const delta_made *made, const delta_real torque[3], delta_real turned[3])
{{
    row asked = {{ (delta_real *)torque, 3 }}, given = {{ turned, 3 }};
    table out = {{ (delta_real *)made->work, {rows}, 3, 3 }};
    correction_turned(out, asked, DELTA_TORQUE_N_M, given);
}}
"""
SHOULDERS = """\
row read = { (delta_real *)reading, 3 }, angles = { theta, 3 };
    correction_shoulders(&delta_calibration, read, angles);"""
HOMED = "for (int k = 0; k < 3; k++) theta[k] = reading[k]; /* the stops give the zeros */"


def arguments(known: Correction | None) -> tuple[Any, ...] | None:
    """Type of the correction, as the compiler has it; None without one."""
    return None if known is None else (typeof(known),)


def translate(translation: Translation, known: tuple[Any, ...]) -> None:
    """Adds its functions to a translation."""
    vector, out = typeof(np.zeros(3)), typeof(np.zeros((c.ROWS, 3)))
    translation.add(c.correct, (*known, vector, out))
    translation.add(c.turned, (out, vector, float64, vector))


def code(known: Correction | None, precision: Precision, absolute: bool) -> str:
    """Its functions around the translated ones.

    Args:
        known: The correction; None: the device is as drawn.
        precision: Of its real numbers.
        absolute: Whether the start-up takes the encoders' zeros as they are, and not the stops'.
    """
    if known is None:
        return PLAIN
    return CODE.format(
        known=initialiser(known, typeof(known), 0, precision),
        shoulders=SHOULDERS if absolute else HOMED,
        rows=c.ROWS,
        drawn=3 * c.DRAWN,
    )


def told(known: Correction | None) -> str:
    """What the guide says of it."""
    if known is None:
        return "The device is taken as drawn: `firmware --calibration FILE` would put right a made one."
    return (
        "It holds the calibration of one made device: `delta_drawn` puts its readings right before `delta_tick`, "
        "`delta_turned` its torques after it."
    )
