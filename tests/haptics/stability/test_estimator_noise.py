"""Error, lag and noise of the estimators against closed forms for a fine encoder."""

import math

import numpy as np
import pytest

from haptics.control.filters import backward_difference, foaw, low_pass, response
from haptics.stability.estimator_noise import compare_estimators, estimator_figure, estimator_table

T, QUANTUM = 1e-3, 1e-5
SPEED = 5.0  # 500 quanta a sample at the most: rounding errors of neighbours are independent and even
SPREAD = 0.02  # of a standard deviation: 8,000 samples, (2 * 8000)^-0.5 = 0.8 %; a little more than twice that


def test_difference():
    found = estimator_figure("difference", backward_difference(T), QUANTUM, SPEED)
    assert found.noise == pytest.approx(QUANTUM / T / math.sqrt(6), rel=SPREAD)  # two errors of variance q^2 / 12
    assert found.lag == pytest.approx(
        T / 2, abs=2e-7
    )  # exact for a sine but for the noise: 0.004 / 5 / omega / sqrt(4000)
    assert (found.name, found.speed) == ("difference", SPEED)


@pytest.mark.parametrize("corner", [20.0, 100.0])
def test_low_pass(corner):
    estimator = low_pass(T, corner)
    a = estimator.pole
    found = estimator_figure("low-pass", estimator, QUANTUM, SPEED)
    # squares of the impulse response (1 - a) (1, a - 1, a (a - 1), ...) sum up to 2 (1 - a)^2 / (1 + a)
    expected = QUANTUM / T * math.sqrt((1 - a) ** 2 / (6 * (1 + a)))
    assert found.noise == pytest.approx(expected, rel=5 * SPREAD)  # samples of a slow filter are not independent
    late = -np.angle(response(estimator, 2.0) / 2j) / (2 * math.pi * 2.0)
    assert found.lag == pytest.approx(late, abs=2e-7)  # noise, as above


@pytest.mark.parametrize("best_fit", [False, True])
def test_held_window(best_fit):
    n = 8
    estimator = foaw(T, 1.0, n, best_fit=best_fit)  # the band is the whole motion: the window is always n
    found = estimator_figure("FOAW", estimator, QUANTUM, SPEED)
    assert found.lag == pytest.approx(n * T / 2, abs=2e-7)  # noise, as above
    # of the end-fit line q / (n T sqrt(6)); of the fit q / (T sqrt(n (n + 1)(n + 2)))
    expected = 1 / math.sqrt(n * (n + 1) * (n + 2)) if best_fit else 1 / (n * math.sqrt(6))
    assert found.noise == pytest.approx(QUANTUM / T * expected, rel=5 * SPREAD)  # windows overlap: not independent


def test_error_is_lag_and_noise_together():
    estimator = low_pass(T, 50.0)
    found = estimator_figure("low-pass", estimator, QUANTUM, SPEED)
    off = abs(response(estimator, 2.0) / (2j * math.pi * 2.0) - 1.0) * SPEED / math.sqrt(2)
    assert found.rms_error == pytest.approx(math.hypot(off, found.noise), rel=1e-3)  # noise that is taken for motion


def test_adaptive_window_is_late_when_slow_and_quick_when_fast():
    quantum = 2 * math.pi / 16384
    slow, fast = (estimator_figure("FOAW", foaw(T, quantum, 32), quantum, speed) for speed in (0.02, 5.0))
    plain = estimator_figure("difference", backward_difference(T), quantum, 0.02)
    assert slow.noise < plain.noise / 8
    assert fast.lag < slow.lag / 3


def test_frequency_is_that_of_the_motion():
    late = [estimator_figure("", low_pass(T, 10.0), QUANTUM, SPEED, frequency=f).lag for f in (1.0, 10.0)]
    expected = [-np.angle(response(low_pass(T, 10.0), f) / 1j) / (2 * math.pi * f) for f in (1.0, 10.0)]
    np.testing.assert_allclose(late, expected, rtol=0, atol=1e-6)  # noise; of 10 Hz a tenth of the motion


def test_figures_are_the_same_each_time():
    one, two = (estimator_figure("", foaw(T, QUANTUM, 8), QUANTUM, 0.1) for _ in range(2))
    assert one == two


def test_motion_that_is_never_seen_has_no_lag():
    # passes shifted by multiples of the golden ratio: one of them comes within 0.05 quanta of a step, not closer
    found = estimator_figure("", backward_difference(T), 1.0, 1e-3)
    assert math.isnan(found.lag)
    assert found.noise == 0.0
    assert found.rms_error == pytest.approx(1e-3 / math.sqrt(2), rel=1e-9)  # rounding


def test_table_has_a_line_for_each_pair():
    estimators = {"difference": backward_difference(T), "FOAW end-fit, 16": foaw(T, QUANTUM, 16)}
    figures = compare_estimators(estimators, QUANTUM, (0.1, 1.0))
    assert [(f.name, f.speed) for f in figures] == [(name, v) for v in (0.1, 1.0) for name in estimators]
    lines = estimator_table(figures).splitlines()
    assert len(lines) == 6
    assert lines[0].split() == ["estimator", "speed", "rms", "error", "lag", "noise"]
    assert lines[1].split() == ["rad/s", "rad/s", "ms", "rad/s"]
    for line, f in zip(lines[2:], figures, strict=True):
        assert line.startswith(f.name)
        speed, rms, lag, noise = map(float, line[24:].split())
        # four digits, three decimals
        assert (speed, rms, noise) == pytest.approx((f.speed, f.rms_error, f.noise), rel=1e-3)
        assert lag == pytest.approx(1e3 * f.lag, abs=1e-3)
    assert len({len(line) for line in lines}) == 1
    assert "m/s" in estimator_table(figures, unit="m/s")


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"quantum": 0.0}, "quantum is 0.0; it must be finite and positive"),
        ({"speed": math.nan}, "speed is nan"),
        ({"frequency": -1.0}, "frequency is -1.0"),
        ({"frequency": 200.0}, "frequency is 200.0 Hz; it must leave at least 8 samples a cycle"),
    ],
)
def test_what_is_refused(change, says):
    with pytest.raises(ValueError, match=says):
        estimator_figure("", backward_difference(T), **{"quantum": QUANTUM, "speed": 1.0} | change)
