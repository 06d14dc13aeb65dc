"""Error, lag and noise of the estimators on a sine read in quanta, against closed forms for a fine encoder.

The part of the estimate that has the motion's frequency says how late it is; what is left is noise. Several passes with
the encoder's steps shifted stand for all phases: no random numbers.
"""

import math
from typing import NamedTuple

import numpy as np
import pytest

from haptics.control.filters import low_pass
from tests.haptics.control.signals import backward_difference, response, velocities

T, QUANTUM = 1e-3, 1e-5
SPEED = 5.0  # 500 quanta a sample at the most: rounding errors of neighbours are independent and even
SPREAD = 0.02  # of a standard deviation: 8,000 samples, (2 * 8000)^-0.5 = 0.8 %; a little more than twice that
PASSES = 16
GOLDEN = (math.sqrt(5.0) - 1.0) / 2.0  # its multiples fill the interval evenly


class Figure(NamedTuple):
    rms_error: float
    lag: float
    noise: float


def estimator_figure(estimator, quantum, speed, frequency=2.0):
    """Root mean square error, lag (s) and noise of the velocity of a sine of this frequency (Hz) and largest speed."""
    cycle = round(1.0 / (frequency * estimator.period))
    omega = 2.0 * math.pi / (cycle * estimator.period)
    before = 2 * cycle  # the start is forgotten
    phase = 2.0 * math.pi * np.arange(before + cycle) / cycle
    cos, sin = np.cos(phase[before:]), np.sin(phase[before:])
    shifts = np.arange(PASSES) * GOLDEN % 1.0
    reads = [quantum * np.round(speed / omega / quantum * np.sin(phase) + shift) for shift in shifts]
    estimates = np.array([velocities(estimator, read)[before:] for read in reads])
    in_phase, late = (2.0 * np.mean(estimates.mean(axis=0) * wave) for wave in (cos, sin))
    return Figure(
        rms_error=float(np.sqrt(np.mean((estimates - speed * cos) ** 2))),
        lag=math.atan2(late, in_phase) / omega,
        noise=float(np.sqrt(np.mean((estimates - in_phase * cos - late * sin) ** 2))),
    )


def test_difference():
    found = estimator_figure(backward_difference(T), QUANTUM, SPEED)
    assert found.noise == pytest.approx(QUANTUM / T / math.sqrt(6), rel=SPREAD)  # two errors of variance q^2 / 12
    assert found.lag == pytest.approx(
        T / 2, abs=2e-7
    )  # exact for a sine but for the noise: 0.004 / 5 / omega / sqrt(4000)


@pytest.mark.parametrize("corner", [20.0, 100.0])
def test_low_pass(corner):
    estimator = low_pass(T, corner)
    a = estimator.pole
    found = estimator_figure(estimator, QUANTUM, SPEED)
    # squares of the impulse response (1 - a) (1, a - 1, a (a - 1), ...) sum up to 2 (1 - a)^2 / (1 + a)
    expected = QUANTUM / T * math.sqrt((1 - a) ** 2 / (6 * (1 + a)))
    assert found.noise == pytest.approx(expected, rel=5 * SPREAD)  # samples of a slow filter are not independent
    late = -np.angle(response(estimator, 2.0) / 2j) / (2 * math.pi * 2.0)
    assert found.lag == pytest.approx(late, abs=2e-7)  # noise, as above


def test_error_is_lag_and_noise_together():
    estimator = low_pass(T, 50.0)
    found = estimator_figure(estimator, QUANTUM, SPEED)
    off = abs(response(estimator, 2.0) / (2j * math.pi * 2.0) - 1.0) * SPEED / math.sqrt(2)
    assert found.rms_error == pytest.approx(math.hypot(off, found.noise), rel=1e-3)  # noise that is taken for motion


def test_frequency_is_that_of_the_motion():
    late = [estimator_figure(low_pass(T, 10.0), QUANTUM, SPEED, frequency=f).lag for f in (1.0, 10.0)]
    expected = [-np.angle(response(low_pass(T, 10.0), f) / 1j) / (2 * math.pi * f) for f in (1.0, 10.0)]
    np.testing.assert_allclose(late, expected, rtol=0, atol=1e-6)  # noise; of 10 Hz a tenth of the motion


def test_motion_that_is_never_seen_is_all_error():
    # passes shifted by multiples of the golden ratio: one of them comes within 0.05 quanta of a step, not closer
    found = estimator_figure(backward_difference(T), 1.0, 1e-3)
    assert found.noise == 0.0
    assert found.rms_error == pytest.approx(1e-3 / math.sqrt(2), rel=1e-9)  # rounding
