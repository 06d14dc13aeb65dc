"""Velocity estimators: exact on ramps, FOAW against brute force in fractions, linear ones against SciPy, bad input."""

import math
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import signal

from haptics.control.filters import (
    HELD,
    POSITIONS,
    VELOCITY,
    WINDOW,
    backward_difference,
    foaw,
    fresh_memory,
    low_pass,
    reset,
    transfer,
    velocity,
)
from tests.haptics.control.signals import response

T = 1e-3
QUANTUM = 2 * math.pi / 16384
LINEAR = [backward_difference(T), low_pass(T, 30.0), low_pass(T, 200.0)]
ADAPTIVE = [foaw(T, QUANTUM, 16), foaw(T, QUANTUM, 16, best_fit=True)]
ALL = LINEAR + ADAPTIVE
PROPERTY = settings(max_examples=200, deadline=None)


def run(estimator, positions, memory=None):
    """Estimates and the windows they span."""
    memory = fresh_memory(estimator, 1)[0] if memory is None else memory
    steps = [(velocity(estimator, memory, x), memory[WINDOW]) for x in positions]
    return np.array([v for v, _ in steps]), np.array([n for _, n in steps])


# ---------------------------------------------------------------- ramps


@pytest.mark.parametrize("estimator", ALL)
@pytest.mark.parametrize("speed", [0.0, 0.3, -7.0])
def test_exact_on_a_ramp(estimator, speed):
    x = 0.4 + speed * T * np.arange(400)
    found, _ = run(estimator, x)
    assert found[0] == 0.0
    settled = 1.0 - estimator.pole ** np.arange(400)  # 1 from the second sample on, where there is no pole
    settled[0] = 0.0
    # positions up to 3 are rounded to 4e-16, the difference of two over 1 ms to 1e-12
    np.testing.assert_allclose(found, speed * settled, rtol=0, atol=2e-12)


@pytest.mark.parametrize("best_fit", [False, True])
@pytest.mark.parametrize("speed", [0.003, 0.1, 0.37, 2.0, -5.0])
def test_window_of_a_steady_motion_read_in_quanta_is_the_longest(best_fit, speed):
    n = 20
    estimator = foaw(T, QUANTUM, n, best_fit=best_fit)
    x = QUANTUM * np.round((0.1 + speed * T * np.arange(3000)) / QUANTUM)
    found, windows = run(estimator, x)
    np.testing.assert_array_equal(windows, np.minimum(np.arange(3000), n))
    bound = 1.5 * QUANTUM / ((n + 1) * T) if best_fit else QUANTUM / (n * T)
    assert np.abs(found[n:] - speed).max() <= bound * (1 + 1e-9)  # rounding


# ---------------------------------------------------------------- FOAW against brute force


def brute_force(counts, band, longest, best_fit):
    """Velocity in counts a period and window, exactly, by trying each line against each sample."""
    out = []
    for k in range(len(counts)):
        y = [Fraction(counts[k - i]) for i in range(min(k, longest) + 1)]
        n = 0
        for trial in range(1, len(y)):
            slope = (y[0] - y[trial]) / trial
            if any(abs(y[0] - slope * i - y[i]) > band for i in range(1, trial)):
                break
            n = trial
        if n == 0:
            out.append((0.0, 0))
        elif best_fit:
            out.append((-np.polyfit(np.arange(n + 1), [float(q) for q in y[: n + 1]], 1)[0], n))
        else:
            out.append((float((y[0] - y[n]) / n), n))
    return np.array(out).T


def walks():
    steps = st.one_of(st.integers(-2, 2), st.integers(0, 1), st.integers(-40, 40))
    return st.lists(steps, min_size=1, max_size=60).map(lambda s: np.cumsum(s).tolist())


@PROPERTY
@given(walks(), st.integers(1, 3), st.integers(1, 20), st.booleans())
def test_foaw_is_what_brute_force_finds(counts, band, longest, best_fit):
    found, windows = run(foaw(1.0, band, longest, best_fit=best_fit), [float(c) for c in counts])
    expected, expected_windows = brute_force(counts, band, longest, best_fit)
    np.testing.assert_array_equal(windows, expected_windows)
    np.testing.assert_allclose(found, expected, rtol=1e-11, atol=1e-11)  # polyfit solves by SVD: counts up to 2400


@PROPERTY
@given(walks(), st.integers(1, 20), st.booleans(), st.integers(-8000, 8000))
def test_windows_do_not_depend_on_units_or_on_where_the_joint_is(counts, longest, best_fit, offset):
    exact, windows = run(foaw(1.0, 1.0, longest, best_fit=best_fit), [float(c) for c in counts])
    angles = (np.array(counts) + offset) * QUANTUM
    found, same = run(foaw(T, QUANTUM, longest, best_fit=best_fit), angles)
    np.testing.assert_array_equal(same, windows)
    # angles up to 4 rad are rounded to 9e-16, over 1 ms
    np.testing.assert_allclose(found, exact * QUANTUM / T, rtol=1e-12, atol=4e-12)


def test_window_shrinks_at_a_turn_and_grows_again():
    counts = np.concatenate([5.0 * np.arange(40), 5.0 * 39 - 5.0 * np.arange(1, 40)])
    found, windows = run(foaw(1.0, 1.0, 16), counts)
    assert windows[39] == 16
    assert windows[40] == 1  # the first sample after the turn: any longer line misses the top
    np.testing.assert_array_equal(found[40:], -5.0)  # at once
    np.testing.assert_array_equal(windows[40:60], np.minimum(np.arange(1, 21), 16))


def test_slower_is_smoother():
    """At rest one flickering count is 1 count a period by difference and 1/16 of it by a window of 16."""
    counts = np.tile([0.0, 1.0], 100)
    assert np.abs(run(backward_difference(1.0), counts)[0][20:]).max() == 1.0
    assert np.abs(run(foaw(1.0, 1.0, 16), counts)[0][20:]).max() <= 1 / 16
    assert np.abs(run(foaw(1.0, 1.0, 16, best_fit=True), counts)[0][20:]).max() <= 1.5 / 17


# ---------------------------------------------------------------- linear ones


@pytest.mark.parametrize("estimator", LINEAR)
def test_transfer_function_is_what_the_step_does(estimator):
    x = np.cumsum(np.random.default_rng(5).normal(size=500))
    x[0] = 0.0  # at rest before
    numerator, denominator = transfer(estimator)
    assert denominator[0] == 1.0
    # velocities of 1e3 to rounding, summed by the pole
    np.testing.assert_allclose(run(estimator, x)[0], signal.lfilter(numerator, denominator, x), rtol=0, atol=1e-10)


@pytest.mark.parametrize("best_fit", [False, True])
@pytest.mark.parametrize("n", [1, 2, 3, 16])
def test_transfer_function_of_a_window_held(best_fit, n):
    x = np.random.default_rng(6).normal(size=300)
    held = foaw(T, 1e3, n, best_fit=best_fit)  # a band that is never left
    numerator, denominator = transfer(foaw(T, 1.0, 16, best_fit=best_fit), n)
    expected = signal.lfilter(numerator, denominator, x)
    np.testing.assert_allclose(run(held, x)[0][n:], expected[n:], rtol=0, atol=1e-10)  # velocities of 1e3, to rounding


@pytest.mark.parametrize(("estimator", "window"), [(e, None) for e in LINEAR] + [(e, 9) for e in ADAPTIVE])
def test_response_is_the_answer_to_a_sine(estimator, window):
    if window is not None:
        estimator = estimator._replace(band=1e3, window=window)
    cycle, t = 50, np.arange(2000)  # 20 Hz
    w = 2 * np.pi * t / cycle
    found = run(estimator, np.sin(w))[0][-cycle:]
    answer = 2 * np.mean(found * np.exp(-1j * w[-cycle:])) * 1j
    # the start has died away: 0.83^1950; velocities of 100 to rounding
    np.testing.assert_allclose(answer, response(estimator, 1.0 / (cycle * T), window), rtol=1e-9)


@pytest.mark.parametrize(("estimator", "window"), [(e, None) for e in LINEAR] + [(e, 16) for e in ADAPTIVE])
def test_response_at_low_frequency_is_a_derivative(estimator, window):
    f = np.array([1e-3, 1e-2])
    ratio = response(estimator, f, window) / (2j * np.pi * f)
    assert response(estimator, 0.0, window) == pytest.approx(0.0, abs=1e-9)  # 1/T times rounding
    np.testing.assert_allclose(np.abs(ratio), 1.0, rtol=1e-6)  # (f / corner)^2 / 2 and (f n T)^2
    late = -np.angle(ratio) / (2 * np.pi * f)
    a, n = estimator.pole, window or 1
    np.testing.assert_allclose(late, (n / 2 + a / (1 - a)) * T, rtol=1e-5)  # likewise


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
    np.testing.assert_allclose(run(low_pass(T, corner), x)[0], continuous, rtol=0, atol=1e-10)  # matrix exponential


# ---------------------------------------------------------------- memory


@pytest.mark.parametrize("estimator", ALL)
def test_memory_is_as_documented(estimator):
    memory = fresh_memory(estimator)
    assert memory.shape == (3, POSITIONS + estimator.window + 1)
    assert not memory.any()
    x = np.cos(0.01 * np.arange(30))
    for k, sample in enumerate(x):
        found = velocity(estimator, memory[1], sample)
        held = min(k + 1, estimator.window + 1)
        assert memory[1, HELD] == held
        assert memory[1, VELOCITY] == found
        np.testing.assert_array_equal(memory[1, POSITIONS : POSITIONS + held], x[k::-1][:held])
        np.testing.assert_array_equal(memory[1, POSITIONS + held :], 0.0)
    assert not memory[[0, 2]].any()  # the other joints' memories are theirs
    reset(memory)
    assert not memory.any()


@pytest.mark.parametrize("estimator", ALL)
def test_first_sample_gives_no_velocity(estimator):
    assert velocity(estimator, fresh_memory(estimator, 1)[0], 5.0) == 0.0


@pytest.mark.parametrize("estimator", ALL)
@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
def test_bad_sample_leaves_nothing_behind(estimator, bad):
    x = np.sin(0.02 * np.arange(60))
    memory = fresh_memory(estimator, 1)[0]
    run(estimator, x[:30], memory)
    assert velocity(estimator, memory, bad) == 0.0
    assert not memory.any()
    np.testing.assert_array_equal(run(estimator, x[30:], memory)[0], run(estimator, x[30:])[0])


@pytest.mark.parametrize("estimator", ALL)
def test_jump_beyond_the_doubles_leaves_nothing_behind(estimator):
    memory = fresh_memory(estimator, 1)[0]
    run(estimator, [1e308, 1e308], memory)
    assert velocity(estimator, memory, -1e308) == 0.0
    assert not memory.any()


@PROPERTY
@given(st.sampled_from(ALL), st.lists(st.floats(), max_size=40))
def test_estimate_is_always_finite(estimator, samples):
    memory = fresh_memory(estimator, 1)[0]
    found, _ = run(estimator, samples, memory)
    assert np.isfinite(found).all()
    assert np.isfinite(memory).all()


# ---------------------------------------------------------------- refusals


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: backward_difference(0.0), "period is 0.0"),
        (lambda: backward_difference(math.nan), "period is nan"),
        (lambda: low_pass(T, -1.0), "corner is -1.0 Hz"),
        (lambda: low_pass(-T, 1.0), "period is -0.001 s"),
        (lambda: foaw(math.inf, 1.0, 3), "period is inf s"),
        (lambda: foaw(T, 0.0, 3), "band is 0.0 of a position"),
        (lambda: foaw(T, 1.0, 0), "window is 0 .*1000"),
        (lambda: foaw(T, 1.0, 1001), "window is 1001 periods"),
        (lambda: foaw(T, 1.0, 2.5), "window is 2.5 periods"),  # pyright: ignore[reportArgumentType]
        (lambda: transfer(backward_difference(T), 3), "window is 3"),
        (lambda: transfer(foaw(T, 1.0, 8)), "window is None.* 8 periods"),
        (lambda: transfer(foaw(T, 1.0, 8), 9), "window is 9"),
        (lambda: transfer(foaw(T, 1.0, 8), 0), "window is 0"),
    ],
)
def test_what_is_refused(make, says):
    with pytest.raises(ValueError, match=says):
        make()
