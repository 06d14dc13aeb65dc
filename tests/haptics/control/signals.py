"""Estimators over whole signals and over frequency."""

import numpy as np

from haptics.control.filters import fresh_memory, transfer, velocity


def velocities(estimator, positions):
    """Estimates of one signal, from a fresh memory."""
    memory = fresh_memory(estimator, 1)[0]
    return np.array([velocity(estimator, memory, x) for x in positions])


def response(estimator, frequency, window=None):
    """`N / D` at `z = exp(2 pi j f T)`; an exact estimator would have `2 pi j f`."""
    numerator, denominator = transfer(estimator, window)
    delay = np.exp(-2j * np.pi * np.asarray(frequency, dtype=float) * estimator.period)
    return np.polyval(numerator[::-1], delay) / np.polyval(denominator[::-1], delay)
