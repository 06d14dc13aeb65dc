"""Passivity against closed forms, a hold cut into pieces, energy counted sample by sample, and hands at random."""

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from haptics.control.filters import backward_difference, foaw, low_pass
from haptics.model.hands import HANDS
from haptics.model.plant import Hand
from haptics.stability.bodies import axis
from haptics.stability.discrete import Timing, sampled_loop
from haptics.stability.estimator_models import LinearEstimator, linear_models
from haptics.stability.passivity import PassivityClass, friction_demand, required_friction, verdict

T = 1e-3
(DIFFERENCE,) = linear_models(backward_difference(T))
(SMOOTH,) = linear_models(low_pass(T, 80.0))
WINDOW = linear_models(foaw(T, 1.0, 6, best_fit=True))[-1]


@given(st.floats(0.0, 2e4), st.floats(-20.0, 50.0), st.floats(1e-4, 5e-3))
@settings(max_examples=50, deadline=None)
def test_spring_and_difference_without_delay(K: float, B: float, period: float) -> None:
    """b > K T / 2 + |B|, Colgate and Schenkel."""
    (estimator,) = linear_models(backward_difference(period))
    demand = required_friction(Timing(period), estimator, K, B)
    # rounding of 1 - cos at the foot of the grid, 1e-16 / (pi 1e-4)^2, and the foot itself, (pi 1e-4)^2
    assert demand.friction == pytest.approx(K * period / 2 + abs(B), rel=1e-6, abs=1e-12)


@pytest.mark.parametrize("estimator", [DIFFERENCE, SMOOTH, WINDOW])
@pytest.mark.parametrize("whole", [0, 1, 3])
def test_whole_delays_are_the_condition_as_published(estimator: LinearEstimator, whole: int) -> None:
    w = np.linspace(1.0, math.pi / T, 400)
    z = np.exp(1j * w * T)
    wall = (2500.0 + 12.0 * estimator.response(z)) * z**-whole
    published = T / 2 / (1 - np.cos(w * T)) * ((1 - 1 / z) * wall).real
    ours = friction_demand(w, Timing(T, whole * T), estimator, 2500.0, 12.0)
    # at 1 rad/s rounding of 1 - cos is 1e-16 / 1e-6
    np.testing.assert_allclose(ours, np.maximum(published, 0.0), rtol=1e-8, atol=1e-8)


def cut_into_pieces(w: float, timing: Timing, estimator: LinearEstimator, K: float, B: float, pieces: int) -> float:
    """The demand at a frequency from a hold cut into pieces: the hold's shape summed over 200 past commands, the
    Hermitian part of the operator as a matrix, its smallest eigenvalue."""
    z = np.exp(1j * w * timing.period)
    t = (np.arange(pieces) + 0.5) * timing.period / pieces

    def arrived(since: np.ndarray) -> np.ndarray:
        rise = 1.0 - np.exp(-np.maximum(since, 0.0) / timing.current_lag) if timing.current_lag else 1.0
        return np.where(since >= 0.0, rise, 0.0)

    shape = np.zeros(pieces, dtype=complex)
    for age in range(200):
        since = t + age * timing.period - timing.delay
        shape += z ** (-age) * (arrived(since) - arrived(since - timing.period))
    g = (K + B * complex(estimator.response(np.array(z)))) / (z - 1.0) * shape
    operator = np.outer(g, np.ones(pieces)) * timing.period / pieces
    return max(0.0, -float(np.linalg.eigvalsh((operator + operator.conj().T) / 2.0)[0]))


@pytest.mark.parametrize(
    "timing",
    [Timing(T, 0.3 * T), Timing(T, 1.5 * T), Timing(T, 0.0, 7e-4), Timing(T, 1.25 * T, 4e-4), Timing(T, 0.5 * T, 5e-3)],
)
@pytest.mark.parametrize("estimator", [DIFFERENCE, SMOOTH])
def test_fractions_and_lag_against_a_hold_cut_into_pieces(timing: Timing, estimator: LinearEstimator) -> None:
    for w in (30.0, 700.0, 1900.0, 3100.0):
        expected = cut_into_pieces(w, timing, estimator, 3000.0, 4.0, 200)
        ours = float(friction_demand(np.array(w), timing, estimator, 3000.0, 4.0))
        # midpoints of 200 pieces: (1/200)^2 of the fastest lag's (T / 4e-4)^2, against the wall's K T = 3 N s/m
        assert ours == pytest.approx(expected, rel=2e-4, abs=1e-4)


@pytest.mark.parametrize(
    ("timing", "estimator"), [(Timing(T), DIFFERENCE), (Timing(T, T), SMOOTH), (Timing(T, 2 * T), WINDOW)]
)
def test_energy_of_a_sine_of_displacements(timing: Timing, estimator: LinearEstimator) -> None:
    """At the demanding frequency friction 1 % short gives net energy to the hand, 1 % above takes it: constant speed
    within each period, which is the cheapest way from sample to sample, force by the filter's own recursion."""
    K, B = 3000.0, 6.0
    demand = required_friction(timing, estimator, K, B)
    k = np.arange(40000)
    x = 1e-3 * np.cos(demand.frequency * T * k)
    velocity, top = np.zeros(len(k)), np.array(estimator.numerator)
    for i in range(len(top), len(k)):
        velocity[i] = top @ x[i - np.arange(len(top))]
        for j in range(1, len(estimator.denominator)):
            velocity[i] -= estimator.denominator[j] * velocity[i - j]
    force = K * x + B * velocity
    late = timing.whole_periods
    span = slice(2000, 2000 + 30000)
    moved = np.diff(x, append=0.0)[span]
    given = np.roll(force, late)[span]
    taken = {factor: float((factor * demand.friction * moved**2 / T + given * moved).sum()) for factor in (0.99, 1.01)}
    assert taken[0.99] < 0.0 < taken[1.01]


def test_maximum_between_grid_points_is_refined() -> None:
    """No frequency of a grid 200 times finer asks for more."""
    for timing, estimator in (
        (Timing(T, T), DIFFERENCE),
        (Timing(T, 1.5 * T), SMOOTH),
        (Timing(T, 2 * T, 3e-4), WINDOW),
    ):
        demand = required_friction(timing, estimator, 4000.0, 9.0)
        fine = friction_demand(np.linspace(1.0, math.pi / T, 200_001), timing, estimator, 4000.0, 9.0)
        assert fine.max() <= demand.friction * (1.0 + 1e-12)
        assert fine.max() == pytest.approx(
            demand.friction, rel=1e-6
        )  # the fine grid misses the top by its step squared
        at = friction_demand(np.array(demand.frequency), timing, estimator, 4000.0, 9.0)
        assert float(at) == demand.friction


@given(
    delay=st.floats(0.0, 2.5),
    lag=st.sampled_from([0.0, 2e-4, 2e-3]),
    estimator=st.sampled_from([DIFFERENCE, SMOOTH, WINDOW]),
    K=st.floats(10.0, 1e4),
    B=st.floats(0.0, 20.0),
    mass=st.floats(0.05, 1.0),
    hand=st.tuples(st.floats(0.0, 2.0), st.floats(0.0, 50.0), st.floats(0.0, 5e3)),
)
@settings(max_examples=80, deadline=None)
def test_no_hand_makes_a_passive_wall_unstable(delay, lag, estimator, K, B, mass, hand) -> None:
    """Two independent theories: friction above the demand, and then eigenvalues with any mass, damper, spring."""
    timing = Timing(T, delay * T, lag)
    friction = 1.0001 * required_friction(timing, estimator, K, B).friction
    loop = sampled_loop(axis(mass, friction, Hand(*hand)), timing, estimator)
    assert float(loop.radius(K, B)) < 1.0


def test_verdicts_are_kept_apart() -> None:
    one = Timing(T, T)
    passive = verdict(0.3, 20.0, one, DIFFERENCE, 3000.0, 1.0, HANDS)
    assert passive.kind is PassivityClass.PASSIVE
    assert passive.missing_friction == 0.0
    held = verdict(0.3, 0.1, one, DIFFERENCE, 2000.0, 5.0, HANDS)
    assert held.kind is PassivityClass.STABLE_WITH_HAND_SET
    assert held.missing_friction == pytest.approx(held.demand.friction - 0.1)
    assert held.spectral_margin == 1.0 - max(held.radii.values()) > 0.0
    assert held.worst_hand == max(held.radii, key=lambda name: held.radii[name])
    fails = verdict(0.3, 0.1, one, DIFFERENCE, 2000.0, 0.0, HANDS)
    assert (fails.kind, fails.worst_hand) == (PassivityClass.FAILS, "light")
    assert fails.spectral_margin < 0.0
    assert len({passive.reason, held.reason, fails.reason}) == 3
    assert fails.demand.friction == pytest.approx(
        2000.0 * T * 1.5, rel=1e-6
    )  # K (T / 2 + delay), at the lowest frequency


def test_friction_just_at_the_demand_is_not_passive() -> None:
    demand = required_friction(Timing(T), DIFFERENCE, 1000.0, 0.0).friction
    assert verdict(0.3, demand, Timing(T), DIFFERENCE, 1000.0, 0.0, HANDS).kind is not PassivityClass.PASSIVE
    assert verdict(0.3, demand * 1.001, Timing(T), DIFFERENCE, 1000.0, 0.0, HANDS).kind is PassivityClass.PASSIVE


def test_empty_set_of_hands_is_refused() -> None:
    with pytest.raises(ValueError, match="hands"):
        verdict(0.3, 0.1, Timing(T), DIFFERENCE, 1000.0, 0.0, {})
