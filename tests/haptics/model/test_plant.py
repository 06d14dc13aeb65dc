"""The plant: Lagrange's equations by differences, energy, friction that sticks, motors that lag, a hand."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from delta_cad.drive.masses import Masses
from delta_cad.mechanism import DeltaGeometry, inverse_jacobian, inverse_kinematics, jacobian
from haptics.gravity import arm_directions, gravity_torque, potential_energy
from haptics.model.plant import FREE, STATES, Hand, Plant, advance, bristle, derivative, energy, motion, plant

GEOMETRY = DeltaGeometry(0.040, 0.030, 0.082, 0.112079)
MASSES = Masses(0.07, 0.0013, -0.0003, 1.5e-4, 0.002, 0.0008, 0.0021, 3.2e-4)
TILTED = (2.0, -3.0, -8.0)
ZERO = np.zeros(3)
HOME = np.array([0.0, 0.0, 0.0946])

inside = st.tuples(st.floats(-0.03, 0.03), st.floats(-0.03, 0.03), st.floats(0.06, 0.13))
speed = st.tuples(*[st.floats(-1.0, 1.0)] * 3)


def state_of(p: Any, v: Any = ZERO) -> np.ndarray:
    state = np.zeros(STATES)
    state[:3], state[3:6] = p, v
    return state


def acceleration(par: Plant, state: np.ndarray, torque: Any = ZERO, hand: Hand = FREE, force: Any = ZERO) -> np.ndarray:
    out, work = np.empty(STATES), np.empty((6, 3))
    theta = inverse_kinematics(GEOMETRY, state[:3])
    derivative(par, hand, HOME, np.array(force), np.array(torque), state, theta, work, out)
    return out[3:6]


def run(par: Plant, state: np.ndarray, seconds: float, steps: int, **more: Any) -> np.ndarray:
    moved, room = state.copy(), np.zeros((13, STATES))
    hand, anchor = more.get("hand", FREE), np.array(more.get("anchor", HOME))
    force, torque = np.array(more.get("force", ZERO)), np.array(more.get("torque", ZERO))
    advance(par, hand, anchor, force, torque, seconds, steps, moved, room)
    return moved


def kinetic_energy(p: np.ndarray, v: np.ndarray) -> float:
    """From the bodies' velocities: no Jacobian of ours in closed form, no mass matrix."""
    theta = inverse_kinematics(GEOMETRY, p)
    rate = inverse_jacobian(GEOMETRY, p) @ v
    elbows = GEOMETRY.upper_arm_length * rate[:, None] * arm_directions(GEOMETRY, theta)[1]
    total = 0.5 * MASSES.platform * v @ v + 0.5 * (MASSES.arm_inertia + MASSES.rotor_inertia) * rate @ rate
    for u in elbows:
        total += 0.5 * (MASSES.rod_elbow * u @ u + 2.0 * MASSES.rod_cross * u @ v + MASSES.rod_wrist * v @ v)
    return float(total)


@given(inside, speed, speed)
@settings(max_examples=40, deadline=None)
def test_lagranges_equations_hold(p: Any, v: Any, torque: Any) -> None:
    """d/dt dT/dv - dT/dp + dU/dp = G^T torque, every derivative by central differences of the energies."""
    p, v = np.array(p), np.array(v)
    a = acceleration(plant(GEOMETRY, MASSES, TILTED), state_of(p, v), torque)
    step, axes = 1e-4, np.eye(3)

    def momentum(at: np.ndarray, along: np.ndarray) -> np.ndarray:  # T is quadratic in v: exact differences
        return np.array([(kinetic_energy(at, along + e) - kinetic_energy(at, along - e)) / 2.0 for e in axes])

    ahead, behind = momentum(p + step * v, v + step * a), momentum(p - step * v, v - step * a)
    rate_of_momentum = (ahead - behind) / (2.0 * step)
    forces = []
    for e in axes * step:
        kinetic = kinetic_energy(p + e, v) - kinetic_energy(p - e, v)
        potential = potential_energy(GEOMETRY, MASSES, p + e, TILTED) - potential_energy(
            GEOMETRY, MASSES, p - e, TILTED
        )
        forces.append((kinetic - potential) / (2.0 * step))
    applied = inverse_jacobian(GEOMETRY, p).T @ np.array(torque)
    # differences over 0.1 mm: (step / 0.05 m)^2 of terms of up to some 20 N
    assert rate_of_momentum == pytest.approx(np.array(forces) + applied, abs=2e-3)


@given(inside, speed)
@settings(deadline=None)  # the first call compiles
def test_the_mass_matrix_gives_the_bodies_energy(p: Any, v: Any) -> None:
    m11, m22, m33, m12, m13, m23 = motion(plant(GEOMETRY, MASSES), 0.0, state_of(p, v), np.empty((6, 3)))
    M = np.array([[m11, m12, m13], [m12, m22, m23], [m13, m23, m33]])
    known = kinetic_energy(np.array(p), np.array(v))
    assert 0.5 * np.array(v) @ M @ v == pytest.approx(known, rel=1e-9, abs=1e-15)
    kinetic, potential = energy(plant(GEOMETRY, MASSES, TILTED), 0.0, state_of(p, v))
    assert kinetic == pytest.approx(known, rel=1e-9, abs=1e-15)
    assert potential == pytest.approx(potential_energy(GEOMETRY, MASSES, p, TILTED), rel=1e-9, abs=1e-12)


@given(inside)
@settings(deadline=None)
def test_the_holding_torque_holds(p: Any) -> None:
    held = gravity_torque(GEOMETRY, MASSES, p, TILTED)
    assert np.abs(acceleration(plant(GEOMETRY, MASSES, TILTED), state_of(p), held)).max() < 1e-9


def test_energy_is_kept_to_the_fourth_order_of_the_step() -> None:
    par, start = plant(GEOMETRY, MASSES, TILTED), state_of([0.01, 0.005, 0.09], [0.2, -0.1, 0.15])
    before, drift = sum(energy(par, 0.0, start)), []
    for steps in (50, 100, 200):
        drift.append(abs(sum(energy(par, 0.0, run(par, start, 0.12, steps))) - before))
    assert np.diff(np.log2(drift)) == pytest.approx([-4.0, -4.0], abs=0.5)
    assert drift[-1] < 1e-8


def test_time_runs_backwards_too() -> None:
    par, start = plant(GEOMETRY, MASSES, TILTED), state_of([0.01, 0.005, 0.09], [0.2, -0.1, 0.15])
    there = run(par, start, 0.1, 1000)
    there[3:6] *= -1.0
    back = run(par, there, 0.1, 1000)
    assert back[:3] == pytest.approx(start[:3], abs=1e-11)


def test_friction_holds_what_is_below_it_and_slips_above() -> None:
    par = plant(GEOMETRY, MASSES, coulomb=0.08, presliding=1e-3)
    start = state_of(HOME)
    start[6:9] = -gravity_torque(GEOMETRY, MASSES, HOME, (0.0, 0.0, -9.81)) / 0.08  # bent as far as gravity asks
    assert np.abs(run(par, start, 1.0, 10000)[:3] - HOME).max() < 1e-12
    # lifted slowly for its viscosity: the bristle alone gives way, by the torque over its stiffness
    slow, up = plant(GEOMETRY, MASSES, coulomb=0.08, viscous=1.0, presliding=1e-3), np.array([0.0, 0.0, 0.3])
    lifted = run(slow, start, 2.0, 20000, force=up)
    turn = inverse_kinematics(GEOMETRY, lifted[:3]) - inverse_kinematics(GEOMETRY, HOME)
    more = (jacobian(GEOMETRY, HOME).T @ up)[0]
    assert turn == pytest.approx(np.full(3, 1e-3 * more / 0.08), rel=1e-2)  # what gravity asks varies with p
    heavy = plant(GEOMETRY, MASSES, coulomb=0.02, presliding=1e-3)
    assert run(heavy, state_of(HOME), 0.1, 1000)[2] < HOME[2] - 5e-3


def test_friction_only_takes_energy() -> None:
    par, state = plant(GEOMETRY, MASSES, coulomb=0.01, viscous=1e-3), state_of(HOME, [0.3, 0.2, 0.4])
    before = sum(energy(par, 0.0, state))
    for _ in range(20):
        state = run(par, state, 0.005, 50)
        after = sum(energy(par, 0.0, state))
        # a bristle that springs back gives at most coulomb x presliding a joint
        assert after < before + 3 * 0.01 * 1e-3
        before = after


@settings(deadline=None)
@given(st.floats(-1.0, 1.0), st.floats(-0.01, 0.01), st.floats(0.0, 1.0))
def test_a_turn_in_two_parts_bends_the_bristle_as_in_one(before: float, turn: float, part: float) -> None:
    whole = bristle(before, turn, 1e-3)
    assert bristle(bristle(before, part * turn, 1e-3), (1.0 - part) * turn, 1e-3) == pytest.approx(whole, abs=1e-12)
    assert abs(whole) <= 1.0
    # the work done against it is at least what it stores: b^2 presliding / 2 per coulomb
    steps = np.linspace(0.0, turn, 201)
    torque = np.array([bristle(before, step, 1e-3) for step in steps])
    work = np.trapezoid(torque, steps)
    assert work >= 0.5e-3 * (whole**2 - before**2) - 1e-9


def test_friction_does_not_creep_under_vibration() -> None:
    par = plant(GEOMETRY, MASSES, coulomb=0.08, viscous=0.01, presliding=1e-3)
    state = state_of(HOME)
    state[6:9] = -gravity_torque(GEOMETRY, MASSES, HOME, (0.0, 0.0, -9.81)) / 0.08
    for k in range(400):
        state = run(par, state, 1e-3, 10, force=[0.1 * (-1.0) ** k, 0.0, 0.05 * (-1.0) ** (k // 2)])
    assert np.abs(state[:3] - HOME).max() < 20e-6


def test_the_motors_follow_with_their_lag() -> None:
    par = plant(GEOMETRY, MASSES, current_lag=1e-3)
    required = np.array([0.1, 0.2, -0.1])
    state = run(par, state_of(HOME), 2e-3, 40, torque=required)
    assert state[9:12] == pytest.approx(required * (1.0 - np.exp(-2.0)), rel=1e-6)


def test_a_hand_is_a_mass_a_spring_and_a_damper() -> None:
    hand, state = Hand(0.1, 5.0, 300.0), state_of([0.005, 0.0, HOME[2]], [0.1, 0.0, 0.0])
    par = plant(GEOMETRY, MASSES, (0.0, 0.0, 0.0))
    felt = acceleration(par, state, hand=hand)
    heavier = plant(GEOMETRY, Masses(0.17, *list(vars(MASSES).values())[1:]), (0.0, 0.0, 0.0))
    by_force = acceleration(heavier, state, force=[-300.0 * 0.005 - 5.0 * 0.1, 0.0, 0.0])
    assert felt == pytest.approx(by_force, rel=1e-12)
    assert np.isnan(acceleration(par, state_of(HOME))).sum() == 0


def test_a_hand_weighs_nothing() -> None:
    """A person carries the own hand: it moves with the handle but does not pull it down."""
    held = gravity_torque(GEOMETRY, MASSES, HOME, TILTED)
    par = plant(GEOMETRY, MASSES, TILTED)
    assert np.abs(acceleration(par, state_of(HOME), held, Hand(0.2, 0.0, 0.0))).max() < 1e-9


@pytest.mark.parametrize(
    ("name", "value"),
    [("coulomb", -1.0), ("viscous", float("nan")), ("current_lag", float("inf")), ("presliding", 0.0)],
)
def test_parameters_that_are_refused(name: str, value: float) -> None:
    with pytest.raises(ValueError, match=f"{name} is"):
        plant(GEOMETRY, MASSES, **{name: value})
