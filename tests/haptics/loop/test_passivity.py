"""Passivity against closed forms, a hold cut into pieces, energy counted sample by sample, and hands at random.

Passivity at the handle: the known condition of a rigid axis, dense matrices, energy in time, what gives way.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from delta_cad.common.jit import compiled
from haptics.control.filters import low_pass
from haptics.loop.discrete import (
    LinearEstimator,
    Ports,
    SampledBody,
    Timing,
    attached,
    axis,
    linear_model,
    loaded,
    sampled_loop,
)
from haptics.loop.passivity import (
    ALIASES,
    Handle,
    PassivityClass,
    friction_demand,
    handle,
    impedance,
    required_friction,
    strain,
    verdict,
)
from haptics.model.hands import HANDS
from haptics.model.plant import FREE, Hand
from tests.haptics.control.signals import backward_difference

T = 1e-3
DIFFERENCE = linear_model(backward_difference(T))
SMOOTH = linear_model(low_pass(T, 80.0))
WINDOW = LinearEstimator("fit over six periods", tuple((np.linspace(3.0, -3.0, 7) / 28.0 / T).tolist()))


@given(st.floats(0.0, 2e4), st.floats(-20.0, 50.0), st.floats(1e-4, 5e-3))
@settings(max_examples=50, deadline=None)
def test_spring_and_difference_without_delay(K: float, B: float, period: float) -> None:
    """b > K T / 2 + |B|, Colgate and Schenkel."""
    estimator = linear_model(backward_difference(period))
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
    own = friction_demand(w, Timing(T, whole * T), estimator, 2500.0, 12.0)
    # at 1 rad/s rounding of 1 - cos is 1e-16 / 1e-6
    np.testing.assert_allclose(own, np.maximum(published, 0.0), rtol=1e-8, atol=1e-8)


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
        own = float(friction_demand(np.array(w), timing, estimator, 3000.0, 4.0))
        # midpoints of 200 pieces: (1/200)^2 of the fastest lag's (T / 4e-4)^2, against the wall's K T = 3 N s/m
        assert own == pytest.approx(expected, rel=2e-4, abs=1e-4)


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


T8 = 1.25e-4
SMOOTH8 = linear_model(low_pass(T8, 300.0))
ONE = Ports(np.eye(1), np.eye(1))


def motor_arm_knob() -> tuple[SampledBody, Ports, np.ndarray]:
    """Rotor 0.07 kg with 1.5 N s/m, cable, arm 0.05 kg (sensed), structure, knob 0.06 kg (held)."""
    rotor = axis(0.07, 1.5)
    body, arm = attached(rotor, np.eye(1), 0.05, 2.0, 150e3)
    body, knob = attached(body, arm, 0.06, 1.0, 20e3)
    return body, Ports(np.array([[1.0], [0.0], [0.0]]), np.array([[0.0, 1.0, 0.0]])), knob[0]


def largest(at: Handle, estimator: LinearEstimator, damping: float) -> float:
    low, high = 1.0, 1e6
    while high > 1.0005 * low:
        middle = np.sqrt(low * high)
        low, high = (middle, high) if strain(at, estimator, middle, damping).max() <= 1.0 else (low, middle)
    return low


@pytest.mark.parametrize(
    ("friction", "timing", "estimator", "damping"),
    [
        (3.0, Timing(T8), DIFFERENCE, 0.0),
        (3.0, Timing(T8, T8, 5.3e-5), SMOOTH8, 0.0),
        (4.0, Timing(T8, 0.4 * T8), SMOOTH8, 2.0),
        (4.0, Timing(T8, 1.5 * T8, 2e-4), DIFFERENCE, 0.5),
    ],
)
def test_a_rigid_axis_has_the_known_condition(
    friction: float, timing: Timing, estimator: LinearEstimator, damping: float
) -> None:
    found = largest(handle(axis(0.2, friction), ONE, np.ones(1), timing), estimator, damping)
    for share, passive in ((0.985, True), (1.015, False)):
        required = required_friction(timing, estimator, share * found, damping).friction
        assert (required <= friction) == passive
    if damping == 0.0 and timing.delay == 0.0:
        assert found == pytest.approx(2.0 * friction / T8, rel=0.015)  # b > K T / 2


def test_mass_does_not_enter_on_a_rigid_axis() -> None:
    limits = [largest(handle(axis(m, 3.0), ONE, np.ones(1), Timing(T8, T8)), SMOOTH8, 0.0) for m in (0.05, 0.2, 0.8)]
    assert limits == pytest.approx([limits[0]] * 3, rel=2e-3)


def test_the_closed_form_is_the_matrix() -> None:
    body, ports, place = motor_arm_knob()
    at = handle(body, ports, place, Timing(T8, T8, 5.3e-5))
    K, B = 9e3, 2.0
    law = K + B * SMOOTH8.response(at.filter_z)
    c = law / (T8 * (1.0 + law * at.moved.sum(axis=1)))
    found = strain(at, SMOOTH8, K, B)
    for i in (5, 200, 400, 580):
        root = np.sqrt(at.own[i].real)
        asks = c[i] * np.outer(at.pushed[i], at.seen[i])
        dense = np.linalg.eigvalsh((asks + asks.conj().T) / 2.0 / np.outer(root, root))[-1]
        assert found[i] == pytest.approx(dense, rel=1e-9)
    assert at.own.shape == (len(at.frequency), 2 * ALIASES + 1)


STEPS, WAITED = 24, 20_000
"""Steps a period, and periods in which what the beginning stirs up dies away."""


@compiled
def taken(inverse, damping, stiffness, push, see, place, K, B, pole, period, shape, waited):
    """Mean power that a force puts into the handle, in time: Heun's steps of the bodies, commands a period late.

    `shape` (n STEPS + 1,) is one cycle of the force.
    """
    n, dt = len(place), period / STEPS
    cycle = (len(shape) - 1) // STEPS
    q, v, q1, v1 = np.zeros(n), np.zeros(n), np.zeros(n), np.zeros(n)
    required = power = seen = speed = 0.0
    waited -= waited % cycle
    for k in range(waited + cycle):
        before, seen = seen, np.dot(see, q)
        speed = pole * speed + (1.0 - pole) * (seen - before) / period
        held, required = required, -K * seen - B * speed
        for s in range(STEPS):
            i = (k % cycle) * STEPS + s
            a = inverse @ (place * shape[i] + push * held - damping @ v - stiffness @ q)
            q1, v1 = q + dt * v, v + dt * a
            a1 = inverse @ (place * shape[i + 1] + push * held - damping @ v1 - stiffness @ q1)
            if k >= waited:
                power += 0.5 * (shape[i] * np.dot(place, v) + shape[i + 1] * np.dot(place, v1)) / (STEPS * cycle)
            q, v = q + 0.5 * dt * (v + v1), v + 0.5 * dt * (a + a1)
    return power


def test_the_worst_force_gets_energy_out_above_the_limit_and_none_below() -> None:
    """The worst force at the worst frequency, of low aliases alone, in time; nothing of the model is in that."""
    body, ports, place = motor_arm_knob()
    B, timing = 6.0, Timing(T8, T8)
    at = handle(body, ports, place, timing)
    limit = largest(at, SMOOTH8, B)
    above = 1.05 * limit
    assert float(sampled_loop(body, timing, SMOOTH8, ports).radius(above, B)) < 1.0  # let go of it is stable
    i = int(np.argmax(strain(at, SMOOTH8, above, B)))
    cycle = round(2.0 * np.pi / (at.frequency[i] * T8))  # periods; a hundred or more, so that rounding does not matter
    near = slice(ALIASES - 2, ALIASES + 3)
    law = above + B * complex(SMOOTH8.response(at.filter_z[i : i + 1])[0])
    c = law / (T8 * (1.0 + law * at.moved[i].sum()))
    asks = c * np.outer(at.pushed[i], at.seen[i])
    takes = np.diag(at.own[i].real) - (asks + asks.conj().T) / 2.0
    values, vectors = np.linalg.eigh(takes[near, near])
    assert values[0] < 0.0
    tones = 2.0 * np.pi / T8 * (1.0 / cycle + np.arange(-2, 3))
    shape = np.real(np.exp(1j * np.outer(np.arange(cycle * STEPS + 1) * T8 / STEPS, tones)) @ vectors[:, 0])
    pole = np.exp(-2.0 * np.pi * 300.0 * T8)
    fixed = (np.linalg.inv(body.mass), body.damping, body.stiffness, ports.push[:, 0].copy(), ports.see[0], place)
    powers = [taken(*fixed, share * limit, B, pole, T8, shape, WAITED) for share in (0.97, 1.05)]
    assert powers[0] > 0.0 > powers[1]


def test_the_averaged_impedance_is_mass_and_wall() -> None:
    """Far below the sampling the handle is a mass on a spring and a damper."""
    at = handle(axis(0.2, 1.0), ONE, np.ones(1), Timing(T8, T8))
    z = impedance(at, SMOOTH8, 5e3, 2.0)
    low = at.frequency < 2.0 * np.pi * 20.0
    w = at.frequency[low]
    cost = 5e3 * 1.5 * T8  # what half a period and the delay take off the damping
    assert z[low].real == pytest.approx(np.full(low.sum(), 1.0 + 2.0 - cost), rel=0.02)
    assert z[low].imag == pytest.approx(0.2 * w - 5e3 / w, rel=0.012, abs=0.05)
    body, ports, place = motor_arm_knob()
    stiff = handle(loaded(body, np.eye(3)[:1], stiffness=1e9), ports, place, Timing(T8))
    bent = impedance(stiff, SMOOTH8, 0.0, 0.0)[stiff.frequency < 20.0]
    series = 1.0 / (1.0 / 150e3 + 1.0 / 20e3)
    assert (1j * stiff.frequency[: len(bent)] * bent).real == pytest.approx(np.full(len(bent), series), rel=0.01)


def test_a_device_that_takes_nothing_is_never_passive_with_a_wall() -> None:
    at = handle(axis(0.2, 0.0), ONE, np.ones(1), Timing(T8))
    assert np.isinf(strain(at, SMOOTH8, 10.0, 0.0)).any() or strain(at, SMOOTH8, 10.0, 0.0).max() > 1.0
    assert FREE.mass == 0.0
