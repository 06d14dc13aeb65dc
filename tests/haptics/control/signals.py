"""Estimators over whole signals and over frequency."""

import numpy as np

from haptics.control.filters import Estimator, fresh_memory, transfer, velocity


def backward_difference(period: float) -> Estimator:
    """The difference of the last two samples, without a low-pass."""
    return Estimator(period, 0.0)


def velocities(estimator, positions):
    """Estimates of one signal, from a fresh memory."""
    memory = fresh_memory(1)[0]
    return np.array([velocity(estimator, memory, x) for x in positions])


def response(estimator, frequency):
    """`N / D` at `z = exp(2 pi j f T)`; an exact estimator would have `2 pi j f`."""
    numerator, denominator = transfer(estimator)
    delay = np.exp(-2j * np.pi * np.asarray(frequency, dtype=float) * estimator.period)
    return np.polyval(numerator[::-1], delay) / np.polyval(denominator[::-1], delay)
