"""Velocity estimators: exact on ramps, against SciPy, bad input."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import signal

from haptics.control.filters import (
    HELD,
    POSITION,
    VELOCITY,
    fresh_memory,
    low_pass,
    reset,
    transfer,
    velocity,
)
from tests.haptics.control.signals import backward_difference, response, velocities

T = 1e-3
ALL = [backward_difference(T), low_pass(T, 30.0), low_pass(T, 200.0)]
PROPERTY = settings(max_examples=200, deadline=None)


# ---------------------------------------------------------------- ramps


@pytest.mark.parametrize("estimator", ALL)
@pytest.mark.parametrize("speed", [0.0, 0.3, -7.0])
def test_exact_on_a_ramp(estimator, speed):
    x = 0.4 + speed * T * np.arange(400)
    found = velocities(estimator, x)
    assert found[0] == 0.0
    settled = 1.0 - estimator.pole ** np.arange(400)  # 1 from the second sample on, where there is no pole
    settled[0] = 0.0
    # positions up to 3 are rounded to 4e-16, the difference of two over 1 ms to 1e-12
    np.testing.assert_allclose(found, speed * settled, rtol=0, atol=2e-12)


# ---------------------------------------------------------------- as filters


@pytest.mark.parametrize("estimator", ALL)
def test_transfer_function_is_what_the_step_does(estimator):
    x = np.cumsum(np.random.default_rng(5).normal(size=500))
    x[0] = 0.0  # at rest before
    numerator, denominator = transfer(estimator)
    assert denominator[0] == 1.0
    # velocities of 1e3 to rounding, summed by the pole
    np.testing.assert_allclose(velocities(estimator, x), signal.lfilter(numerator, denominator, x), rtol=0, atol=1e-10)


@pytest.mark.parametrize("estimator", ALL)
def test_response_is_the_answer_to_a_sine(estimator):
    cycle, t = 50, np.arange(2000)  # 20 Hz
    w = 2 * np.pi * t / cycle
    found = velocities(estimator, np.sin(w))[-cycle:]
    answer = 2 * np.mean(found * np.exp(-1j * w[-cycle:])) * 1j
    # the start has died away: 0.83^1950; velocities of 100 to rounding
    np.testing.assert_allclose(answer, response(estimator, 1.0 / (cycle * T)), rtol=1e-9)


@pytest.mark.parametrize("estimator", ALL)
def test_response_at_low_frequency_is_a_derivative(estimator):
    f = np.array([1e-3, 1e-2])
    ratio = response(estimator, f) / (2j * np.pi * f)
    assert response(estimator, 0.0) == pytest.approx(0.0, abs=1e-9)  # 1/T times rounding
    np.testing.assert_allclose(np.abs(ratio), 1.0, rtol=1e-6)  # (f / corner)^2 / 2 and (f T)^2
    late = -np.angle(ratio) / (2 * np.pi * f)
    a = estimator.pole
    np.testing.assert_allclose(late, (0.5 + a / (1 - a)) * T, rtol=1e-5)  # likewise


@pytest.mark.parametrize("corner", [0.5, 2.0])
def test_corner_lets_through_one_over_root_two(corner):
    ratio = response(low_pass(T, corner), corner) / response(backward_difference(T), corner)
    # the sampled filter differs from the continuous by (f T)^2
    assert abs(ratio) == pytest.approx(math.sqrt(0.5), rel=20 * (corner * T) ** 2 + 1e-9)


def test_low_pass_is_the_exact_solution_for_piecewise_linear_motion():
    corner, x = 40.0, np.cumsum(np.random.default_rng(7).normal(size=200)) * 1e-3
    x -= x[0]
    tau = 1 / (2 * math.pi * corner)
    t = T * np.arange(200)
    _, continuous, _ = signal.lsim(([1.0, 0.0], [tau, 1.0]), x, t, interp=True)
    np.testing.assert_allclose(velocities(low_pass(T, corner), x), continuous, rtol=0, atol=1e-10)  # matrix exponential


# ---------------------------------------------------------------- memory


@pytest.mark.parametrize("estimator", ALL)
def test_memory_is_as_documented(estimator):
    memory = fresh_memory()
    assert memory.shape == (3, 3)
    assert not memory.any()
    for sample in np.cos(0.01 * np.arange(30)):
        found = velocity(estimator, memory[1], sample)
        assert (memory[1, HELD], memory[1, VELOCITY], memory[1, POSITION]) == (1.0, found, sample)
    assert not memory[[0, 2]].any()  # the other joints' memories are theirs
    reset(memory)
    assert not memory.any()


@pytest.mark.parametrize("estimator", ALL)
def test_first_sample_gives_no_velocity(estimator):
    assert velocity(estimator, fresh_memory(1)[0], 5.0) == 0.0


@pytest.mark.parametrize("estimator", ALL)
@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_bad_sample_leaves_nothing_behind(estimator, bad):
    x = np.sin(0.02 * np.arange(60))
    memory = fresh_memory(1)[0]
    for sample in x[:30]:
        velocity(estimator, memory, sample)
    assert velocity(estimator, memory, bad) == 0.0
    assert not memory.any()
    after = [velocity(estimator, memory, sample) for sample in x[30:]]
    np.testing.assert_array_equal(after, velocities(estimator, x[30:]))


@pytest.mark.parametrize("estimator", ALL)
def test_jump_beyond_the_doubles_leaves_nothing_behind(estimator):
    memory = fresh_memory(1)[0]
    for sample in (1e308, 1e308):
        velocity(estimator, memory, sample)
    assert velocity(estimator, memory, -1e308) == 0.0
    assert not memory.any()


@PROPERTY
@given(st.sampled_from(ALL), st.lists(st.floats(), max_size=40))
def test_estimate_is_always_finite(estimator, samples):
    memory = fresh_memory(1)[0]
    assert all(math.isfinite(velocity(estimator, memory, sample)) for sample in samples)
    assert np.isfinite(memory).all()


# ---------------------------------------------------------------- refusals


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: low_pass(T, -1.0), "corner is -1.0 Hz"),
        (lambda: low_pass(-T, 1.0), "period is -0.001 s"),
        (lambda: low_pass(0.0, 1.0), "period is 0.0"),
        (lambda: low_pass(math.nan, 1.0), "period is nan"),
        (lambda: low_pass(math.inf, 1.0), "period is inf s"),
    ],
)
def test_what_is_refused(make, says):
    with pytest.raises(ValueError, match=says):
        make()
