"""Exact loop model against closed forms, characteristic polynomials by another library, and motion in time.

Linear models of the velocity estimators against the estimators themselves, sample by sample.
"""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import signal

from haptics.control.filters import low_pass
from haptics.loop.discrete import (
    DampingCap,
    LinearEstimator,
    SampledBody,
    Timing,
    axis,
    damping_cap,
    limits,
    linear_model,
    sampled_loop,
)
from haptics.model.plant import FREE, Hand
from tests.haptics.control.signals import backward_difference, velocities
from tests.haptics.loop.loops import monotone
from tests.haptics.one_axis import STEPS, growth, one_axis

T = 1e-3
DIFFERENCE = linear_model(backward_difference(T))
SMOOTH = linear_model(low_pass(T, 80.0))
WINDOW = LinearEstimator("line over four periods", (0.25 / T, 0.0, 0.0, 0.0, -0.25 / T))
SAME = 1e-7  # bisection is exact; GROWTH moves a limit by 1e-10 over the radius' slope, some 1e-9


@given(st.floats(0.05, 1.95), st.floats(0.05, 2.0), st.floats(2e-4, 5e-3))
@settings(max_examples=30, deadline=None)
def test_stiffness_limit_of_an_undelayed_wall(beta: float, mass: float, period: float) -> None:
    """Jury's criterion on `z^3 + (a/2 + b/2 - 2) z^2 + (1 + a/2) z - b/2`, a = K T^2 / m, b = B T / m, gives
    `a < 2 b (2 - b) / (2 + b)`: the normalised boundary of Gil (2004), Hulin (2006); `K T / 2 < B` for small gains."""
    estimator = linear_model(backward_difference(period))
    loop = sampled_loop(axis(mass), Timing(period), estimator)
    found = loop.stiffness_limit(beta * mass / period)
    assert monotone(found)
    assert found.value * period**2 / mass == pytest.approx(2 * beta * (2 - beta) / (2 + beta), rel=SAME)


@given(st.floats(0.1, 30.0), st.floats(0.05, 1.0))
@settings(max_examples=20, deadline=None)
def test_stiffness_limit_by_friction_alone(friction: float, mass: float) -> None:
    """`K < b (1 - q) / (t (1 - q) - q T)`, t = m / b, q = exp(-T / t): Jury on the held plant; 2 b / T for small b."""
    t = mass / friction
    q = math.exp(-T / t)
    falls = -math.expm1(-T / t)
    found = sampled_loop(axis(mass, friction), Timing(T), DIFFERENCE).stiffness_limit().value
    assert found == pytest.approx(friction * falls / (t * falls - q * T), rel=1e-5)  # what cancels in the closed form


def test_damping_limits_in_closed_form() -> None:
    """2 m / T without delay, whatever the corner of a low-pass (Jury: `1 - a + a b / 2 < 1`); 2 (sqrt 2 - 1) m / T with
    one sample (`z^3 - z^2 + b/2 z + b/2`), the 0.83 m / T of the notes."""
    for estimator in (DIFFERENCE, SMOOTH, linear_model(low_pass(T, 5.0))):
        assert damping_cap(0.3, T, 0.0, estimator).limit == pytest.approx(2 * 0.3 / T, rel=SAME)
    one_sample = damping_cap(0.3, T, T, DIFFERENCE).limit
    assert one_sample == pytest.approx(2 * (math.sqrt(2) - 1) * 0.3 / T, rel=SAME)


def test_dead_beat() -> None:
    """Gains that put all eigenvalues at 0: after three samples nothing moves any more."""
    mass, pole = 0.2, -0.75
    estimator = LinearEstimator("dead beat", (1.0 / T, -1.0 / T), (1.0, -pole))
    K, B = 4 / 7 * mass / T**2, 27 / 14 * mass / T
    loop = sampled_loop(axis(mass), Timing(T), estimator)
    unit = np.array([1.0, 1.0 / T, 1.0 / T])  # metres, and metres a period for the speed and the filter's state
    cube = np.linalg.matrix_power(loop.matrix(K, B) / unit[:, None] * unit, 3)
    np.testing.assert_allclose(cube, 0.0, atol=1e-12)  # rounding of entries of order 1
    x = one_axis(
        mass, 0.0, 0.0, 0.0, np.array(estimator.numerator), np.array(estimator.denominator), K, B, T, 0, 8, 1.0
    )
    assert abs(x[1]) > 1e-4
    np.testing.assert_allclose(x[3:], 0.0, atol=1e-12)


CASES = [
    # mass, friction, hand, delay in steps of T / STEPS, lag, estimator, B
    (0.2, 1.0, FREE, 0, 0.0, DIFFERENCE, 0.0),
    (0.37, 0.3, Hand(0.02, 0.8, 380.0), 20, 0.0, DIFFERENCE, 0.0),
    (0.18, 0.1, Hand(0.21, 11.3, 175.0), 40, 0.0, DIFFERENCE, 8.0),
    (0.18, 0.1, Hand(0.57, 27.6, 533.0), 52, 0.0, SMOOTH, 10.0),
    (0.3, 0.5, FREE, 10, 4e-4, SMOOTH, 20.0),
    (0.3, 0.0, Hand(0.1, 3.0, 100.0), 0, 8e-4, WINDOW, 15.0),
    (0.15, 0.2, FREE, 90, 0.0, WINDOW, 5.0),
]


def moves(case, K: float, B: float, ticks: int) -> float:
    mass, friction, hand, steps, lag, estimator, _ = case
    num, den = np.array(estimator.numerator), np.array(estimator.denominator)
    x = one_axis(mass + hand.mass, friction + hand.damping, hand.stiffness, lag, num, den, K, B, T, steps, ticks, 1.0)
    return growth(x)


def loop_of(case):
    mass, friction, hand, steps, lag, estimator, _ = case
    return sampled_loop(axis(mass, friction, hand), Timing(T, steps * T / STEPS, lag), estimator)


@pytest.mark.parametrize("case", CASES)
def test_stiffness_limit_is_where_motion_grows(case) -> None:
    """2 % below the limit a push dies away in time, 2 % above it grows, and both at the rate of the eigenvalue."""
    loop, B = loop_of(case), case[-1]
    K = loop.stiffness_limit(B).value
    assert K > 0.0
    for factor, grows in ((0.98, False), (1.02, True)):
        radius = float(loop.radius(factor * K, B))
        ticks = int(min(40.0 / abs(math.log(radius)), 4e4))  # long enough for the slowest mode to be alone
        seen = moves(case, factor * K, B, ticks)
        assert (seen > 1.0) == grows
        # the envelope is read at samples only, a few of them a swing: up to 3 % of its rate over two quarters
        assert math.log(seen) == pytest.approx(math.log(radius), rel=0.03, abs=2e-6)


@pytest.mark.parametrize("case", CASES)
def test_damping_limit_is_where_motion_grows(case) -> None:
    loop, K = loop_of(case), 500.0
    B = loop.damping_limit(K).first
    for factor, grows in ((0.98, False), (1.02, True)):
        assert (moves(case, K, factor * B, 4000) > 1.0) == grows


@given(
    mass=st.floats(0.05, 1.0),
    friction=st.floats(0.0, 5.0),
    stiffness=st.floats(0.0, 500.0),
    lag=st.sampled_from([0.0, 3e-4, 2e-3]),
    whole=st.integers(0, 3),
    estimator=st.sampled_from([DIFFERENCE, SMOOTH, WINDOW]),
    K=st.floats(1.0, 5e4),
    B=st.floats(0.0, 300.0),
)
@settings(max_examples=60, deadline=None)
def test_eigenvalues_are_roots_of_the_characteristic_polynomial(
    mass, friction, stiffness, lag, whole, estimator, K, B
) -> None:
    """Transfer function of the held plant by SciPy, delay and filter as polynomials, the roots of 1 + L(z)."""
    hand = Hand(0.0, 0.0, stiffness)
    loop = sampled_loop(axis(mass, friction, hand), Timing(T, whole * T, lag), estimator)
    bottom = [mass, friction, stiffness]
    if lag:
        bottom = np.polymul(bottom, [lag, 1.0])
    top, under, _ = signal.cont2discrete(([1.0], bottom), T, method="zoh")
    n = len(estimator.numerator)
    velocity = np.array(estimator.numerator)
    filter_under = np.zeros(n)
    filter_under[: len(estimator.denominator)] = estimator.denominator
    controller = K * filter_under + B * velocity
    delay = np.zeros(whole + 1)
    delay[0] = 1.0
    closed = np.polyadd(np.polymul(np.polymul(under, filter_under), delay), np.polymul(top[0], controller))
    expected = np.abs(np.roots(closed)).max()
    # multiple roots near 1 are known to the root of the rounding of the polynomial's coefficients
    assert float(np.abs(loop.eigenvalues(K, B)).max()) == pytest.approx(expected, rel=1e-5)


def test_fraction_of_a_delay_is_continuous_between_whole_ones() -> None:
    loops = [sampled_loop(axis(0.3, 2.0), Timing(T, d * T), DIFFERENCE) for d in (1.0 - 1e-7, 1.0, 1.0 + 1e-7)]
    limit = [loop.stiffness_limit(3.0).value for loop in loops]
    assert limit[0] == pytest.approx(limit[1], rel=1e-5)
    assert limit[2] == pytest.approx(limit[1], rel=1e-5)
    assert Timing(T, 3.0 * T).whole_periods == 3
    assert Timing(T, 3.0 * T).fraction == 0.0
    assert Timing(T, 0.3 * T).fraction == pytest.approx(0.3)


def test_two_axes_are_two_loops() -> None:
    """A diagonal body with diagonal gains has the eigenvalues of both; a turned one the same."""

    one, two = axis(0.2, 1.0, FREE), axis(0.5, 3.0, FREE)
    both = SampledBody(*(np.diag([float(a[0, 0]), float(b[0, 0])]) for a, b in zip(one, two, strict=True)))
    timing = Timing(T, 0.4 * T, 2e-4)
    expected = max(float(sampled_loop(b, timing, SMOOTH).radius(3000.0, 5.0)) for b in (one, two))
    assert float(sampled_loop(both, timing, SMOOTH).radius(3000.0, 5.0)) == pytest.approx(expected, rel=1e-9)
    c, s = math.cos(0.4), math.sin(0.4)
    turn = np.array([[c, -s], [s, c]])
    turned = SampledBody(*(turn @ part @ turn.T for part in both))
    assert float(sampled_loop(turned, timing, SMOOTH).radius(3000.0, 5.0)) == pytest.approx(expected, rel=1e-9)


def test_free_handle_may_rest_anywhere() -> None:
    """Its position's eigenvalue is 1 and does not count; that of its speed does."""
    loop = sampled_loop(axis(0.2, 4.0), Timing(T), DIFFERENCE)
    assert np.abs(loop.eigenvalues(0.0, 0.0) - 1.0).min() < 1e-12
    assert float(loop.radius(0.0, 0.0)) == pytest.approx(math.exp(-4.0 * T / 0.2))


def test_limits_find_every_interval() -> None:
    def radius(gain: np.ndarray) -> np.ndarray:
        stable = (gain < 3.0) | ((gain > 20.0) & (gain < 50.0)) | (gain > 400.0)
        return np.where(stable, 0.5, 1.5)

    found = limits(radius, 1e-3, 1e3)
    edges = [edge for interval in found.intervals for edge in interval]
    np.testing.assert_allclose(edges, [0.0, 3.0, 20.0, 50.0, 400.0, 1e3], rtol=1e-9)
    assert (found.value, monotone(found)) == (pytest.approx(3.0), False)
    none = limits(lambda gain: np.full(gain.shape, 2.0), 1e-3, 1e3)
    assert (none.intervals, none.value, none.first, monotone(none)) == ((), 0.0, 0.0, True)
    late = limits(lambda gain: np.where((gain > 2.0) & (gain < 5.0), 0.5, 1.5), 1e-3, 1e3)
    assert (late.value, late.first, monotone(late)) == (0.0, pytest.approx(5.0), False)


def test_wall_without_any_friction_needs_damping() -> None:
    """Between `B = K T / 2` and nearly `2 m / T`; below it no wall holds, so the limit from 0 is 0."""
    loop = sampled_loop(axis(0.3), Timing(T), DIFFERENCE)
    assert loop.stiffness_limit(0.0).value == 0.0
    found = loop.damping_limit(2000.0)
    assert found.intervals[0][0] == pytest.approx(2000.0 * T / 2.0, rel=0.01)  # K T / 2 is the limit of small gains
    assert found.value == 0.0 < found.first < 2 * 0.3 / T


def test_cap_is_a_share_of_the_limit_that_lag_lowers() -> None:
    cap = damping_cap(0.2, T, T, WINDOW)
    assert cap.limit < damping_cap(0.2, T, T, DIFFERENCE).limit  # a wide window is a late one
    assert cap.cap == cap.limit / 2.0
    assert (cap.applied(500.0), cap.applied(5.0)) == (cap.cap, 5.0)
    assert damping_cap(0.2, T, T, DIFFERENCE, margin=1.0).cap == damping_cap(0.2, T, T, DIFFERENCE).limit
    assert damping_cap(0.2, T, T, DIFFERENCE, current_lag=5e-4).limit < damping_cap(0.2, T, T, DIFFERENCE).limit
    assert damping_cap(0.2, T, T, DIFFERENCE, stiffness=5000.0).limit < damping_cap(0.2, T, T, DIFFERENCE).limit


@pytest.mark.parametrize("mass", [0.1, 0.2, 0.3])
def test_500_newton_seconds_a_metre_are_unstable_at_1_khz(mass: float) -> None:
    """With half a sample of delay or more for 0.1 to 0.3 kg, whatever the filter; without any delay up to 0.25 kg, so
    0.3 kg would just bear it (600)."""
    for estimator in (DIFFERENCE, SMOOTH, WINDOW):
        for delay in (0.5 * T, T):
            assert damping_cap(mass, T, delay, estimator).limit < 500.0
    assert (damping_cap(mass, T, 0.0, DIFFERENCE).limit < 500.0) == (mass < 0.25)


def test_refusals() -> None:
    for mass, friction, hand in (
        (0.0, 0.0, None),
        (math.nan, 0.0, None),
        (1.0, -1.0, None),
        (1.0, 0.0, Hand(0, -1, 0)),
    ):
        with pytest.raises(ValueError, match=r"^mass"):
            axis(mass, friction, hand)
    for timing in ((0.0, 0.0, 0.0), (T, -T, 0.0), (T, 0.0, math.inf)):
        with pytest.raises(ValueError, match="period="):
            Timing(*timing)
    for margin in (0.5, math.nan):
        with pytest.raises(ValueError, match="margin"):
            damping_cap(0.2, T, 0.0, DIFFERENCE, margin)
    assert DampingCap(10.0, 2.0).applied(7.0) == 5.0


RNG = np.random.default_rng(4)
WALK = np.cumsum(RNG.normal(size=400)) * 1e-4


def through(model: LinearEstimator, x: np.ndarray) -> np.ndarray:
    """The state space of a model, step by step, from rest at the first sample."""
    step, into, direct = model.realisation()
    w, out = np.zeros(len(step)), np.empty(len(x))
    for k, value in enumerate(x - x[0]):
        out[k] = (w[0] if len(w) else 0.0) + direct * value
        w = step @ w + into * value
    return out


@pytest.mark.parametrize("estimator", [backward_difference(T), low_pass(T, 60.0), low_pass(T, 5.0)])
def test_state_space_is_the_controllers_estimator(estimator) -> None:
    given = velocities(estimator, WALK)
    model = linear_model(estimator)
    np.testing.assert_allclose(through(model, WALK), given, atol=1e-12 / T)  # rounding of the positions over T


def test_response_follows_a_slow_motion_and_the_state_space() -> None:
    for model in (linear_model(low_pass(T, 60.0)), WINDOW):
        slow = np.exp(1j * 1e-4)
        assert abs(model.response(np.array(slow)) / (1j * 1e-4 / T) - 1.0) < 1e-3  # lag of some samples times 1e-4
        step, into, direct = model.realisation()
        z = np.exp(1j * 0.7)
        state = np.linalg.solve(z * np.eye(len(step)) - step, into)
        np.testing.assert_allclose(model.response(np.array(z)), state[0] + direct, rtol=1e-10)


@pytest.mark.parametrize(
    ("numerator", "denominator", "says"),
    [
        ((), (1.0,), "finite"),
        ((1.0, float("nan")), (1.0,), "finite"),
        ((1.0, -1.0), (2.0,), "must be 1"),
        ((1.0, -1.0), (), "must be 1"),
        ((1.0, -0.5), (1.0,), "stands still"),
    ],
)
def test_coefficients_that_cannot_be_are_refused(numerator, denominator, says) -> None:
    with pytest.raises(ValueError, match=says):
        LinearEstimator("odd", numerator, denominator)
