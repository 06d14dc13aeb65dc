"""Passivity at the handle: the known condition of a rigid axis, dense matrices, energy in time, what gives way."""

from __future__ import annotations

import numpy as np
import pytest

from delta_cad.common.jit import compiled
from haptics.control.filters import backward_difference, low_pass
from haptics.model.plant import FREE
from haptics.stability.bodies import Ports, SampledBody, attached, axis, loaded
from haptics.stability.discrete import Timing, sampled_loop
from haptics.stability.estimator_models import LinearEstimator, linear_models
from haptics.stability.passivity import required_friction
from haptics.stability.port import ALIASES, Handle, handle, impedance, strain

T = 1.25e-4
(SMOOTH,) = linear_models(low_pass(T, 300.0))
(DIFFERENCE,) = linear_models(backward_difference(T))
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
        (3.0, Timing(T), DIFFERENCE, 0.0),
        (3.0, Timing(T, T, 5.3e-5), SMOOTH, 0.0),
        (4.0, Timing(T, 0.4 * T), SMOOTH, 2.0),
        (4.0, Timing(T, 1.5 * T, 2e-4), DIFFERENCE, 0.5),
    ],
)
def test_a_rigid_axis_has_the_known_condition(
    friction: float, timing: Timing, estimator: LinearEstimator, damping: float
) -> None:
    found = largest(handle(axis(0.2, friction), ONE, np.ones(1), timing), estimator, damping)
    for share, passive in ((0.985, True), (1.015, False)):
        asked = required_friction(timing, estimator, share * found, damping).friction
        assert (asked <= friction) == passive
    if damping == 0.0 and timing.delay == 0.0:
        assert found == pytest.approx(2.0 * friction / T, rel=0.015)  # b > K T / 2


def test_mass_does_not_enter_on_a_rigid_axis() -> None:
    limits = [largest(handle(axis(m, 3.0), ONE, np.ones(1), Timing(T, T)), SMOOTH, 0.0) for m in (0.05, 0.2, 0.8)]
    assert limits == pytest.approx([limits[0]] * 3, rel=2e-3)


def test_the_closed_form_is_the_matrix() -> None:
    body, ports, place = motor_arm_knob()
    at = handle(body, ports, place, Timing(T, T, 5.3e-5))
    K, B = 9e3, 2.0
    law = K + B * SMOOTH.response(at.filter_z)
    c = law / (T * (1.0 + law * at.moved.sum(axis=1)))
    found = strain(at, SMOOTH, K, B)
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
    asked = power = seen = speed = 0.0
    waited -= waited % cycle
    for k in range(waited + cycle):
        before, seen = seen, np.dot(see, q)
        speed = pole * speed + (1.0 - pole) * (seen - before) / period
        held, asked = asked, -K * seen - B * speed
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
    B, timing = 6.0, Timing(T, T)
    at = handle(body, ports, place, timing)
    limit = largest(at, SMOOTH, B)
    above = 1.05 * limit
    assert float(sampled_loop(body, timing, SMOOTH, ports).radius(above, B)) < 1.0  # let go of it is stable
    i = int(np.argmax(strain(at, SMOOTH, above, B)))
    cycle = round(2.0 * np.pi / (at.frequency[i] * T))  # periods; a hundred or more, so that rounding does not matter
    near = slice(ALIASES - 2, ALIASES + 3)
    law = above + B * complex(SMOOTH.response(at.filter_z[i : i + 1])[0])
    c = law / (T * (1.0 + law * at.moved[i].sum()))
    asks = c * np.outer(at.pushed[i], at.seen[i])
    takes = np.diag(at.own[i].real) - (asks + asks.conj().T) / 2.0
    values, vectors = np.linalg.eigh(takes[near, near])
    assert values[0] < 0.0
    tones = 2.0 * np.pi / T * (1.0 / cycle + np.arange(-2, 3))
    shape = np.real(np.exp(1j * np.outer(np.arange(cycle * STEPS + 1) * T / STEPS, tones)) @ vectors[:, 0])
    pole = np.exp(-2.0 * np.pi * 300.0 * T)
    fixed = (np.linalg.inv(body.mass), body.damping, body.stiffness, ports.push[:, 0].copy(), ports.see[0], place)
    powers = [taken(*fixed, share * limit, B, pole, T, shape, WAITED) for share in (0.97, 1.05)]
    assert powers[0] > 0.0 > powers[1]


def test_the_averaged_impedance_is_mass_and_wall() -> None:
    """Far below the sampling the handle is a mass on a spring and a damper."""
    at = handle(axis(0.2, 1.0), ONE, np.ones(1), Timing(T, T))
    z = impedance(at, SMOOTH, 5e3, 2.0)
    low = at.frequency < 2.0 * np.pi * 20.0
    w = at.frequency[low]
    cost = 5e3 * 1.5 * T  # what half a period and the delay take off the damping
    assert z[low].real == pytest.approx(np.full(low.sum(), 1.0 + 2.0 - cost), rel=0.02)
    assert z[low].imag == pytest.approx(0.2 * w - 5e3 / w, rel=0.012, abs=0.05)
    body, ports, place = motor_arm_knob()
    stiff = handle(loaded(body, np.eye(3)[:1], stiffness=1e9), ports, place, Timing(T))
    bent = impedance(stiff, SMOOTH, 0.0, 0.0)[stiff.frequency < 20.0]
    series = 1.0 / (1.0 / 150e3 + 1.0 / 20e3)
    assert (1j * stiff.frequency[: len(bent)] * bent).real == pytest.approx(np.full(len(bent), series), rel=0.01)


def test_a_device_that_takes_nothing_is_never_passive_with_a_wall() -> None:
    at = handle(axis(0.2, 0.0), ONE, np.ones(1), Timing(T))
    assert np.isinf(strain(at, SMOOTH, 10.0, 0.0)).any() or strain(at, SMOOTH, 10.0, 0.0).max() > 1.0
    assert FREE.mass == 0.0
