"""The calibration of one made device in C: readings put right before a tick, torques turned after it."""

from __future__ import annotations

from typing import Any

import numpy as np
from numba import float64, typeof

from haptics.control import correction as c
from haptics.control.correction import Correction
from haptics.firmware.literals import initialiser
from haptics.firmware.precision import Precision
from haptics.firmware.templates import rendered
from haptics.firmware.translate import Translation

SHOULDERS = """\
row read = { (delta_real *)reading, 3 }, angles = { theta, 3 };
    correction_shoulders(&delta_calibration, read, angles);"""
HOMED = "for (int k = 0; k < 3; k++) theta[k] = reading[k]; /* the stops give the zeros */"


def header() -> str:
    """What the header says of it."""
    return rendered("calibration.h", rows=c.ROWS)


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
        return rendered("as_drawn.c")
    return rendered(
        "calibration.c",
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
