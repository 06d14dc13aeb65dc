"""Velocity from sampled positions by difference and low-pass; pure compiled steps on a memory array.

One signal (one joint) has one memory, a row of doubles:

| place | holds |
|---|---|
| HELD = 0 | 1: a position is held; 0: fresh, the next sample gives velocity 0 |
| VELOCITY = 1 | the last estimate |
| POSITION = 2 | the last position |

All zeros is a fresh memory. A sample that is not finite, or so far off that the estimate is not, is not taken: it makes
the memory fresh and gives velocity 0, and nothing of it is left.

With T the period and y_i the position i samples ago the backward difference `d = (y_0 - y_1) / T` goes through
`v := a v + (1 - a) d`, `a = exp(-2 pi f T)`: the lag of corner f solved exactly for motion that is linear from sample
to sample. The difference alone, a = 0, is half a sample late; an error of one quantum q is an error q / T of it.

Positions may be of any unit; the velocity is in that unit a second. Importing this module loads numba.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from delta_cad.common.jit import compiled

HELD, VELOCITY, POSITION = range(3)
_PLACES = 3


class Estimator(NamedTuple):
    """A velocity estimator; numbers only, so that compiled code takes it as it is.

    Attributes:
        period: T, s.
        pole: a of the low-pass.
    """

    period: float
    pole: float


def low_pass(period: float, corner: float) -> Estimator:
    """Backward difference behind a first-order low-pass, discretised exactly.

    Args:
        period: T, s.
        corner: Frequency at which the continuous filter lets 1/sqrt(2) through, Hz.

    Raises:
        ValueError: A figure is not finite and positive.
    """
    pole = math.exp(-2.0 * math.pi * _positive("corner", corner, "Hz") * _positive("period", period, "s"))
    return Estimator(float(period), pole)


def fresh_memory(signals: int = 3) -> np.ndarray:
    """Memory for several signals.

    Args:
        signals: Number of joints.

    Returns:
        (signals, 3) zeros.
    """
    return np.zeros((signals, _PLACES))


@compiled
def reset(memory):
    """Makes a memory of any shape fresh, in place."""
    memory[...] = 0.0


@compiled
def velocity(estimator, memory, position):
    """One sample of one signal.

    Args:
        estimator: The estimator.
        memory: (3,) memory of the signal, moved on in place.
        position: The new sample.

    Returns:
        Velocity, units a second; always finite.
    """
    estimate = 0.0
    if memory[HELD] > 0.0:
        difference = (position - memory[POSITION]) / estimator.period
        estimate = estimator.pole * memory[VELOCITY] + (1.0 - estimator.pole) * difference
    if not (math.isfinite(position) and math.isfinite(estimate)):
        reset(memory)
        return 0.0
    memory[HELD], memory[VELOCITY], memory[POSITION] = 1.0, estimate, position
    return estimate


def transfer(estimator: Estimator) -> tuple[np.ndarray, np.ndarray]:
    """Transfer function from position to velocity in powers of 1/z: `N(1/z) / D(1/z)`.

    Args:
        estimator: The estimator.

    Returns:
        N and D, coefficients of z^0 and z^-1; D starts with 1.
    """
    a = estimator.pole
    return (1.0 - a) / estimator.period * np.array([1.0, -1.0]), np.array([1.0, -a])


def _positive(field: str, value: float, unit: str) -> float:
    if not (math.isfinite(value) and value > 0.0):
        raise ValueError(f"{field} is {value!r} {unit}; it must be finite and positive")
    return float(value)
