"""The linearised device against the nonlinear one: energies, and the sampled plant's own transition by differences."""

import re

import numpy as np
import pytest
from scipy.optimize import minimize

from delta_cad.drive.masses import Masses
from delta_cad.mechanism import DeltaGeometry, inverse_jacobian, inverse_kinematics, jacobian
from haptics.control.filters import low_pass
from haptics.gravity import gravity_torque
from haptics.loop.discrete import Ports, SampledBody, Timing, linear_model, sampled_loop
from haptics.loop.linear import linearise
from haptics.model.plant import FREE, STATES, Hand, advance, energy, plant
from tests.haptics.control.signals import backward_difference
from tests.haptics.loop.loops import axis_loop, monotone

GEOMETRY = DeltaGeometry(0.040, 0.030, 0.082, 0.112079)
MASSES = Masses(0.07, 0.0013, -0.0003, 1.5e-4, 0.002, 0.0008, 0.0021, 3.2e-4)
POSE = np.array([0.018, -0.011, 0.088])
NORMAL = np.array([2.0, -1.0, 2.0]) / 3.0
GRIP = Hand(0.1, 4.0, 200.0)
T = 1e-3
DIFFERENCE = linear_model(backward_difference(T))
SMOOTH = linear_model(low_pass(T, 80.0))
WEIGHTLESS = (0.0, 0.0, 0.0)


def test_jacobian_and_mass_are_the_mechanisms_and_the_energys() -> None:
    par = plant(GEOMETRY, MASSES, viscous=3e-4)
    here = linearise(par, POSE)
    np.testing.assert_allclose(here.jacobian, jacobian(GEOMETRY, POSE), rtol=1e-12)
    for v in np.random.default_rng(1).normal(size=(5, 3)):
        state = np.zeros(STATES)
        state[:3], state[3:6] = POSE, v
        assert 0.5 * v @ here.mass @ v == pytest.approx(energy(par, 0.0, state)[0], rel=1e-12)
    assert here.viscous == 3e-4


def test_effective_mass_and_friction_are_least_among_motions_of_that_speed() -> None:
    """By a search over the other two components of the velocity: kinetic energy, and power of friction."""
    par = plant(GEOMETRY, MASSES, viscous=3e-4)
    here = linearise(par, POSE)
    across = np.linalg.svd(NORMAL[None])[2][1:]
    inverse = inverse_jacobian(GEOMETRY, POSE)

    def kinetic(other: np.ndarray) -> float:
        state = np.zeros(STATES)
        state[:3], state[3:6] = POSE, NORMAL + other @ across
        return 2.0 * energy(par, 0.0, state)[0]

    def power(other: np.ndarray) -> float:
        return 3e-4 * float(np.square(inverse @ (NORMAL + other @ across)).sum())

    # minimised by differences: the figure to the square of what the search leaves
    assert here.effective_mass(NORMAL) == pytest.approx(minimize(kinetic, np.zeros(2)).fun, rel=1e-8)
    assert here.effective_friction(NORMAL) == pytest.approx(minimize(power, np.zeros(2)).fun, rel=1e-8)
    directions = np.random.default_rng(2).normal(size=(500, 3))
    some = [here.effective_mass(d / np.linalg.norm(d)) for d in directions]
    assert here.smallest_mass <= min(some) < 1.02 * here.smallest_mass  # 500 directions come within some degrees


def transition(par, hand: Hand, K: float, delay: int, static: float) -> np.ndarray:
    """One period of the true sampled loop at its equilibrium, by differences: state, last angles, commands under way.

    Wall along NORMAL with the force `static` at rest, velocity by differences of the angles, gravity compensated.
    """
    B = 6.0
    gravity = np.array([par.gravity_x, par.gravity_y, par.gravity_z])
    rest = inverse_kinematics(GEOMETRY, POSE)
    room, push = np.zeros((13, STATES)), -static * NORMAL

    def command(theta: np.ndarray, before: np.ndarray) -> np.ndarray:
        from delta_cad.mechanism import forward_kinematics

        p = forward_kinematics(GEOMETRY, theta)
        J = jacobian(GEOMETRY, p)
        along = NORMAL @ (p - POSE)
        rate = NORMAL @ (J @ (theta - before)) / T
        force = (static - K * along - B * rate) * NORMAL
        return J.T @ force + gravity_torque(GEOMETRY, MASSES, p, gravity)

    def step(full: np.ndarray) -> np.ndarray:
        state = np.zeros(STATES)
        state[:6] = full[:6]
        theta = inverse_kinematics(GEOMETRY, state[:3])
        ask = command(theta, full[6:9])
        way = [ask, *full[9:].reshape(-1, 3)]
        advance(par, hand, POSE, push, way[delay], T, 8, state, room)
        return np.concatenate([state[:6], theta, *way[:delay]])

    still = np.concatenate([POSE, np.zeros(3), rest, *[command(rest, rest)] * delay])
    np.testing.assert_allclose(step(still), still, atol=1e-12)  # an equilibrium, to rounding
    scale = np.concatenate([np.full(3, 1e-6), np.full(3, 1e-3), np.full(3, 1e-5), np.full(3 * delay, 1e-3)])
    columns = [(step(still + e) - step(still - e)) / (2.0 * s) for e, s in zip(np.diag(scale), scale, strict=True)]
    return np.array(columns).T


@pytest.mark.parametrize("delay", [0, 1])
def test_joint_loop_is_the_true_sampled_plant_at_rest(delay: int) -> None:
    par = plant(GEOMETRY, MASSES, WEIGHTLESS, viscous=3e-4)
    loop = linearise(par, POSE).joint_loop(NORMAL, GRIP, Timing(T, delay * T), DIFFERENCE)
    for K in (1500.0, 6000.0):
        expected = np.sort(np.abs(np.linalg.eigvals(transition(par, GRIP, K, delay, 0.0))))
        own = np.sort(np.abs(loop.eigenvalues(K, 6.0)))
        n = min(len(own), len(expected))
        # differences of 1e-6 m: cubic terms 1e-9, rounding 1e-10; zeros of the memory to the root of it
        np.testing.assert_allclose(own[-n:], expected[-n:], atol=2e-4)
        assert own[-1] == pytest.approx(expected[-1], abs=1e-7)


def test_what_is_left_out_moves_the_limit_little() -> None:
    """Gravity, its compensation and a standing force of 3 N against the linear loop: within 2 % of its limit."""
    par = plant(GEOMETRY, MASSES, (0.0, 0.0, -9.81), viscous=3e-4)
    limit = linearise(par, POSE).joint_loop(NORMAL, GRIP, Timing(T, T), DIFFERENCE).stiffness_limit(6.0)
    assert monotone(limit)
    for static in (-3.0, 0.0, 3.0):
        radii = [
            np.abs(np.linalg.eigvals(transition(par, GRIP, share * limit.value, 1, static))).max()
            for share in (0.98, 1.02)
        ]
        assert radii[0] < 1.0 < radii[1]


def test_joints_and_platform_coordinates_are_the_same_loop() -> None:
    here = linearise(plant(GEOMETRY, MASSES, viscous=3e-4), POSE)
    timing = Timing(T, 0.3 * T, 2e-4)
    inverse = np.linalg.inv(here.jacobian)
    body = SampledBody(
        here.mass + GRIP.mass * np.eye(3),
        3e-4 * inverse.T @ inverse + GRIP.damping * np.eye(3),
        GRIP.stiffness * np.eye(3),
    )
    platform = sampled_loop(body, timing, SMOOTH, Ports(NORMAL[:, None], NORMAL[None, :]))
    joints = here.joint_loop(NORMAL, GRIP, timing, SMOOTH)
    assert float(joints.radius(5000.0, 5.0)) == pytest.approx(float(platform.radius(5000.0, 5.0)), rel=1e-9)
    assert joints.stiffness_limit(5.0).value == pytest.approx(platform.stiffness_limit(5.0).value, rel=1e-6)


def test_on_the_axis_of_symmetry_one_axis_is_the_whole_device() -> None:
    """There no direction is coupled with another; off it the free directions make a difference."""
    par = plant(GEOMETRY, MASSES, viscous=3e-4)
    for p, same in (([0.0, 0.0, 0.09], True), (POSE, False)):
        here = linearise(par, p)
        n = [0.0, 0.0, 1.0]
        loops = (axis_loop(here, n, GRIP, Timing(T, T), DIFFERENCE), here.joint_loop(n, GRIP, Timing(T, T), DIFFERENCE))
        one, whole = (loop.stiffness_limit(6.0).value for loop in loops)
        assert (abs(one - whole) < 1e-6 * whole) == same


def test_refusals() -> None:
    par = plant(GEOMETRY, MASSES)
    for p in ([0.0, 0.0, 0.5], [np.nan, 0.0, 0.09]):
        with pytest.raises(ValueError, match=re.escape(f"{p} m")):
            linearise(par, p)
    here = linearise(par, POSE)
    for normal in ([0.0, 0.0, 1.1], [1.0, 0.0], [np.nan, 0.0, 1.0]):
        with pytest.raises(ValueError, match=r"^normal is"):
            here.effective_mass(normal)
        with pytest.raises(ValueError, match=r"^normal is"):
            here.effective_friction(normal)
        with pytest.raises(ValueError, match=r"^normal is"):
            here.joint_loop(normal, FREE, Timing(T), DIFFERENCE)
