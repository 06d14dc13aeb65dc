"""A drive as it is, and what gives way: eigenvalues of the linear bodies, energy, stiff limits, stops, ripple."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from delta_cad.mechanism import inverse_kinematics, jacobian
from haptics.gravity import gravity_torque
from haptics.loop.discrete import continuous
from haptics.loop.linear import linearise
from haptics.model.drive_train import GRASP, HAND_SPEED, KNOB, KNOB_SPEED, MOTOR, PHASE, ROTOR_RATE, STATES, TWIST
from haptics.model.plant import FREE, Hand, Plant, advance, derivative, energy, plant
from tests.haptics.model.test_plant import GEOMETRY, HOME, MASSES, ZERO, acceleration, run, state_of

FLOATING = (0.0, 0.0, 0.0)
HELD = Hand(0.2, 6.0, 200.0, 600.0, 1.5)
ROTOR, KNOB_KG = MASSES.rotor_inertia, 0.03


def giving(par: Plant, cable: float = 600.0, structure: float = 2e4, **more: float) -> Plant:
    """The same machine with a cable and a structure that give way."""
    return par._replace(
        joint_inertia=par.joint_inertia - ROTOR,
        rotor_inertia=ROTOR,
        cable_stiffness=cable,
        platform=par.platform - KNOB_KG,
        knob=KNOB_KG,
        structure_stiffness=structure,
        **more,
    )


@pytest.mark.parametrize("hand", [FREE, Hand(0.1, 5.0, 300.0), HELD])
def test_small_motions_are_those_of_the_linear_bodies(hand: Hand) -> None:
    """All eigenvalues: the compiled equations by differences, beside masses, springs and dampers put together."""
    p = np.array([0.012, -0.02, 0.085])
    par = giving(plant(GEOMETRY, MASSES, FLOATING, viscous=3e-4), cable_damping=0.02, structure_damping=3.0)
    body, _ = linearise(par, p).body(hand)
    expected = np.linalg.eigvals(continuous(body, np.zeros((len(body.mass), 1)))[0])

    used = [0, 1, 2, 3, 4, 5, *range(TWIST, TWIST + 6), *range(KNOB, KNOB + 6)]
    used += [*range(GRASP, GRASP + 6)] if hand.grasp_stiffness else []
    theta, step = np.zeros(6), 1e-7
    theta[:3] = inverse_kinematics(GEOMETRY, p)

    def rate(state: np.ndarray) -> np.ndarray:
        out = np.empty(STATES)
        derivative(par, hand, p, ZERO, ZERO, state, theta, np.empty((6, 3)), out)
        return out[used]

    def moved(k: int, by: float) -> np.ndarray:
        state = state_of(p)
        state[k] += by
        return rate(state)

    found = np.linalg.eigvals(np.stack([(moved(k, step) - moved(k, -step)) / (2.0 * step) for k in used], axis=1))
    assert len(found) == len(expected)
    for root in expected:
        assert np.abs(found - root).min() < 2e-5 * np.abs(expected).max()
    fast = np.abs(expected.imag).max() / (2.0 * np.pi)
    assert 100.0 < fast < 1000.0  # Hz; what gives way rings far above the hand


@pytest.mark.parametrize("hand", [FREE, Hand(0.2, 0.0, 200.0, 600.0, 0.0)])
def test_without_damping_no_energy_is_lost(hand: Hand) -> None:
    par = giving(plant(GEOMETRY, MASSES, (2.0, -3.0, -8.0)))
    start = state_of([0.01, 0.005, 0.09], [0.2, -0.1, 0.15])
    start[KNOB_SPEED : KNOB_SPEED + 3] = start[3:6]
    start[TWIST : TWIST + 3] = [1e-4, -2e-4, 1e-4]

    def total(state: np.ndarray) -> float:
        own = sum(energy(par, 0.0, state))
        way = HOME - state[:3] - state[KNOB : KNOB + 3] - state[GRASP : GRASP + 3]
        grasp, speed = state[GRASP : GRASP + 3], state[HAND_SPEED : HAND_SPEED + 3]
        held = hand.grasp_stiffness * grasp @ grasp + hand.stiffness * way @ way + hand.mass * speed @ speed
        return float(own + (0.5 * held if hand.grasp_stiffness else 0.0))

    drift = [abs(total(run(par, start, 0.05, steps, hand=hand)) - total(start)) for steps in (1000, 2000)]
    assert drift[1] < drift[0] / 8.0  # fourth order of the step
    assert drift[1] < 1e-7
    assert np.abs(run(par, start, 0.05, 1000, hand=hand)[TWIST : TWIST + 3]).max() > 1e-5  # it did give way


def test_what_hardly_gives_way_moves_as_if_rigid() -> None:
    rigid = plant(GEOMETRY, MASSES, (0.0, 0.0, -9.81), coulomb=0.004, viscous=1e-3, current_lag=1e-4)
    stiff = giving(rigid, 3e4, 3e6, cable_damping=0.3, structure_damping=60.0)
    hand, torque, force = Hand(0.1, 5.0, 300.0), [0.05, 0.02, -0.03], [0.3, -0.2, 0.4]
    grasping = hand._replace(grasp_stiffness=3e6, grasp_damping=500.0)
    more: dict[str, Any] = {"torque": torque, "force": force}
    expected = run(rigid, state_of(HOME), 0.05, 4000, hand=hand, **more)
    for other, who in ((stiff, hand), (stiff, grasping), (rigid, grasping)):
        found = run(other, state_of(HOME), 0.05, 4000, hand=who, **more)
        assert np.abs(found[:3] - expected[:3]).max() < 2e-3 * np.abs(expected[:3] - HOME).max()


def test_a_twist_at_rest_is_the_torque_over_the_stiffness() -> None:
    par = giving(plant(GEOMETRY, MASSES, (0.0, 0.0, -9.81), viscous=0.02), cable_damping=0.05, structure_damping=20.0)
    held = gravity_torque(GEOMETRY, MASSES, HOME, (0.0, 0.0, -9.81))
    push = np.array([0.5, 0.0, -0.2])
    torque = held - jacobian(GEOMETRY, HOME).T @ push
    state = run(par, state_of(HOME), 1.0, 20000, torque=torque, force=push, hand=Hand(0.0, 2.0, 0.0))
    assert np.abs(state[3:6]).max() < 1e-3
    assert state[TWIST : TWIST + 3] == pytest.approx(torque / 600.0, rel=0.02)  # the pose has changed a little
    assert state[KNOB : KNOB + 3] == pytest.approx(push / 2e4, rel=0.02, abs=1e-8)


def test_friction_before_and_behind_the_cable() -> None:
    """A rotor held by its friction lets the arm give by the cable's stretch alone; what rubs behind holds the arm."""
    par = giving(plant(GEOMETRY, MASSES, FLOATING, coulomb=0.05, presliding=1e-6), cable_damping=0.05)
    lifted, up = [], np.array([0.0, 0.0, 0.2])
    for arm in (0.0, 0.05):
        slow = par._replace(arm_coulomb=arm, structure_damping=20.0)
        state = run(slow, state_of(HOME), 0.3, 6000, force=up, hand=Hand(0.0, 5.0, 0.0))
        lifted.append(inverse_kinematics(GEOMETRY, state[:3]) - inverse_kinematics(GEOMETRY, HOME))
    torque = jacobian(GEOMETRY, HOME).T @ up
    assert lifted[0] == pytest.approx(torque / 600.0, rel=0.05)
    assert np.abs(lifted[1]).max() < 0.02 * np.abs(lifted[0]).max()


def test_a_stop_holds_and_never_pulls() -> None:
    at = float(inverse_kinematics(GEOMETRY, HOME)[0])
    par = plant(GEOMETRY, MASSES, FLOATING, viscous=2e-3)
    stopped = par._replace(stop_high=at + 0.05, stop_low=at - 0.05, stop_stiffness=300.0, stop_damping=0.3)
    for sign, bound in ((1.0, at + 0.05), (-1.0, at - 0.05)):
        torque = np.full(3, sign * 0.2)
        state = run(stopped, state_of(HOME), 1.0, 20000, torque=torque)
        angles = inverse_kinematics(GEOMETRY, state[:3])
        assert angles == pytest.approx(np.full(3, bound + sign * 0.2 / 300.0), abs=2e-5)
        away = state.copy()
        away[3:6] = (jacobian(GEOMETRY, state[:3]) @ np.full(3, -sign * 50.0)).astype(float)  # leaving fast
        free, met = acceleration(par, away), acceleration(stopped, away)
        assert (met - free) @ away[3:6] >= -1e-9  # the stop does not hold it back
    inside = state_of(HOME, [0.1, 0.0, 0.1])
    assert np.array_equal(acceleration(stopped, inside), acceleration(par, inside))


def test_ripple_and_cogging_are_waves_over_the_rotors_angle() -> None:
    par = plant(GEOMETRY, MASSES, FLOATING)
    waves = {"ripple": 0.02, "ripple_per_rad": 125.0, "cogging": 3e-3, "cogging_per_rad": 48.0}
    required = np.array([0.1, -0.2, 0.15])
    for p in (HOME, np.array([0.01, 0.02, 0.1])):
        theta = inverse_kinematics(GEOMETRY, p) + PHASE * np.arange(3) / np.array([[125.0], [48.0]])
        given = required * (1.0 + 0.02 * np.sin(125.0 * theta[0])) + 3e-3 * np.sin(48.0 * theta[1])
        found = acceleration(par._replace(**waves), state_of(p), required)
        assert found == pytest.approx(acceleration(par, state_of(p), given), rel=1e-9)


def test_a_lagging_torque_moves_the_handle_to_the_order_of_the_step() -> None:
    """The torques within a step are those of its beginning, middle and end: the fourth order is kept."""
    par, required = plant(GEOMETRY, MASSES, FLOATING, current_lag=1e-3), np.array([0.1, 0.05, -0.1])

    def speed(steps: int) -> np.ndarray:
        state = state_of(HOME)
        advance(par, FREE, HOME, ZERO, required, 2e-3, steps, state, np.zeros((13, STATES)))
        return state[3:6]

    exact = speed(400)
    errors = [np.abs(speed(steps) - exact).max() / np.abs(exact).max() for steps in (4, 8)]
    assert errors[0] < 1e-4
    assert errors[1] < errors[0] / 12.0


def test_a_current_follows_in_closed_form_whatever_the_step() -> None:
    par, required = plant(GEOMETRY, MASSES, FLOATING, current_lag=5e-5), np.array([0.1, 0.2, -0.1])
    for steps in (1, 3, 50):  # four lags in a step: too stiff for the Runge-Kutta steps
        state = state_of(HOME)
        advance(par, FREE, HOME, ZERO, required, 2e-4, steps, state, np.zeros((13, STATES)))
        assert state[MOTOR : MOTOR + 3] == pytest.approx(required * (1.0 - np.exp(-4.0)), rel=1e-12)
    assert np.all(state[ROTOR_RATE : ROTOR_RATE + 3] == 0.0)
