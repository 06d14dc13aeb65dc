"""Figures of the feel sheet against independent ways: a linear program, sampling, energy, the plant, symmetry."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import linprog

from delta_cad.design import Design
from delta_cad.mechanism import (
    DeltaGeometry,
    forward_kinematics,
    inverse_jacobian,
    inverse_kinematics,
    jacobian,
)
from delta_cad.mechanism.limits.effective_mass import handle_inertia
from haptics.feel.field import Drive, feel_at, inscribed_ball, worst_friction
from haptics.gravity import gravity_torque
from haptics.loop.linear import linearise
from haptics.model.ball_joints import ball_friction_N
from haptics.model.machine import MachineModel
from haptics.model.plant import energy, plant
from tests.haptics.scene_machine import MASSES

DRIVE = Drive(continuous=0.8, peak=1.6, motor=2.4, coulomb=0.025, count=3.8e-4, step=1.2e-3, ripple=0.02, cogging=0.001)
GRAVITY = (0.0, 0.0, -9.81)
Figures = dict[str, np.ndarray]


@pytest.fixture(scope="module")
def positions(best: Design) -> np.ndarray:
    half = best.cube.half_side_mm / 1000.0
    low = np.array([-half, -half, best.cube.bottom_height_mm / 1000.0])
    corners = low + 2.0 * half * np.array(np.meshgrid([0, 1], [0, 1], [0, 1])).reshape(3, -1).T
    return np.vstack([corners, low + 2.0 * half * np.random.default_rng(3).uniform(size=(8, 3))])


@pytest.fixture(scope="module")
def field(machine: MachineModel, positions: np.ndarray) -> Figures:
    return feel_at(machine, DRIVE, positions)


def directions(count: int = 4000) -> np.ndarray:
    n = np.random.default_rng(5).normal(size=(count, 3))
    return n / np.linalg.norm(n, axis=1, keepdims=True)


def test_force_along_directions_by_a_linear_program(
    machine: MachineModel, positions: np.ndarray, field: Figures
) -> None:
    """`max t` with `-l - h <= J^T (t n) <= l - h`: never below the ball, and the ball is reached along J_i."""
    for k, p in enumerate(positions):
        j = jacobian(machine.geometry, p)
        held = gravity_torque(machine.geometry, MASSES, p, GRAVITY)
        # along J_i and against it, the faces' normals, and a few of any kind
        normals = np.vstack([j.T, -j.T])
        normals /= np.linalg.norm(normals, axis=1, keepdims=True)
        balls = (field["force_continuous"][k], field["force_peak"][k], field["force_motor"][k])
        for limit, ball in zip((DRIVE.continuous, DRIVE.peak, DRIVE.motor), balls, strict=True):
            reached = []
            for n in (*normals, *directions(6)):
                torque = (j.T @ n)[:, None]
                bounds = np.concatenate([limit - held, limit + held])
                found = linprog([-1.0], np.vstack([torque, -torque]), bounds, bounds=[(0.0, None)])
                assert found.success
                reached.append(-found.fun)
            assert min(reached) == pytest.approx(ball, rel=1e-7)
            assert min(reached) == min(reached[:6])


def test_acceleration_along_directions_by_a_linear_program(
    machine: MachineModel, positions: np.ndarray, field: Figures
) -> None:
    """`max t` with torques within their limits, gravity held, that accelerate the free handle by `t n`."""
    for k, p in enumerate(positions[::3]):
        j, mass = jacobian(machine.geometry, p), handle_inertia(machine.geometry, p, MASSES.handle_inertia)
        held = gravity_torque(machine.geometry, MASSES, p, GRAVITY)
        faces = (mass @ j).T
        reached = []
        normals = faces / np.linalg.norm(faces, axis=1, keepdims=True)
        for n in (*normals, *-normals, *directions(20)):
            # unknowns: torques and t; mass (t n) = J^-T (torque - held)
            motion = np.hstack([np.linalg.inv(j).T, -(mass @ n)[:, None]])
            bounds = [(-DRIVE.peak, DRIVE.peak)] * 3 + [(0.0, None)]
            found = linprog([0.0, 0.0, 0.0, -1.0], A_eq=motion, b_eq=np.linalg.inv(j).T @ held, bounds=bounds)
            assert found.success
            reached.append(-found.fun)
        assert min(reached) == pytest.approx(field["acceleration"][3 * k], rel=1e-7)
        assert min(reached) == min(reached[:6])
    assert field["dynamic_range"] == pytest.approx(field["force_continuous"] / field["friction_max"])
    assert field["isotropy"] == pytest.approx(field["mass_min"] / field["mass_max"])


def test_best_force_by_linear_programs(machine: MachineModel, positions: np.ndarray, field: Figures) -> None:
    """The farthest corner, from supporting planes: no direction's support is beyond it, some come near."""
    k = 9
    j = jacobian(machine.geometry, positions[k])
    held = gravity_torque(machine.geometry, MASSES, positions[k], GRAVITY)
    bounds = np.concatenate([DRIVE.peak - held, DRIVE.peak + held])
    support = [-linprog(-n, np.vstack([j.T, -j.T]), bounds, bounds=[(None, None)] * 3).fun for n in directions(400)]
    best = field["force_peak_best"][k]
    assert max(support) <= best * (1.0 + 1e-9)
    assert max(support) == pytest.approx(best, rel=0.02)  # 400 directions lie within 0.2 rad of any: cos 0.2 = 0.98


def test_a_joint_that_cannot_hold_the_weight_leaves_nothing() -> None:
    columns = np.eye(3) * 0.08
    assert inscribed_ball(columns, np.array([0.1, -0.3, 0.0]), 0.2) == pytest.approx(-0.1 / 0.08)
    assert inscribed_ball(columns, np.array([0.1, -0.15, 0.0]), 0.2) == pytest.approx(0.05 / 0.08)


def test_mass_is_that_of_the_plant_and_of_its_energy(
    machine: MachineModel, positions: np.ndarray, field: Figures
) -> None:
    par = plant(machine.geometry, MASSES, GRAVITY)
    for k, p in enumerate(positions):
        here = linearise(par, p)
        assert handle_inertia(machine.geometry, p, MASSES.handle_inertia) == pytest.approx(
            here.mass, rel=1e-9, abs=1e-12
        )
        assert field["mass_min"][k] == pytest.approx(here.smallest_mass, rel=1e-9)
        for axis, n in enumerate(np.eye(3)):
            assert field[f"mass_{'xyz'[axis]}"][k] == pytest.approx(here.effective_mass(n), rel=1e-9)
        # kinetic energy, summed body by body, of unit speeds lies between the eigenvalues and comes near them
        twice = []
        for n in directions(300):
            state = np.zeros(12)
            state[:3], state[3:6] = p, n
            twice.append(2.0 * energy(par, 0.0, state)[0])
        assert field["mass_min"][k] <= min(twice) * (1.0 + 1e-12)
        assert max(twice) <= field["mass_max"][k] * (1.0 + 1e-12)
        assert max(twice) == pytest.approx(field["mass_max"][k], rel=0.03)
        assert min(twice) == pytest.approx(field["mass_min"][k], rel=0.1)


def test_friction_is_what_a_motion_dissipates(machine: MachineModel, positions: np.ndarray, field: Figures) -> None:
    """Power over speed, with joint rates by finite differences of the joint angles."""
    g, step = machine.geometry, 1e-7
    for k, p in enumerate(positions):
        n = directions()
        turn = (inverse_kinematics(g, p + step * n) - inverse_kinematics(g, p - step * n)) / (2.0 * step)
        friction = DRIVE.coulomb * np.abs(turn).sum(axis=1) + ball_friction_N(
            machine.design, np.tile(p, (len(n), 1)), n
        )
        assert friction.min() == pytest.approx(field["friction_min"][k], rel=0.08)  # a sharp cusp: 4000 directions
        assert friction.max() == pytest.approx(field["friction_max"][k], rel=0.02)


@pytest.fixture
def no_balls(monkeypatch: pytest.MonkeyPatch) -> None:
    """Ball joints without friction: what is left is the drives'."""
    monkeypatch.setattr(
        "haptics.feel.field.ball_friction_N", lambda _design, _p, direction: np.zeros(direction.shape[:-1])
    )


@pytest.mark.usefixtures("no_balls")
def test_worst_friction_of_a_flat_device_is_not_upwards(machine: MachineModel) -> None:
    """In the cube of the committed design the joints always add up; here two of them work against the third."""
    at = np.array([[0.0, 0.01, 0.06], [0.02, 0.01, 0.06]])
    rows = inverse_jacobian(DeltaGeometry(0.12, 0.02, 0.06, 0.15), at)
    sampled = np.abs(rows @ directions().T).sum(axis=1).max(axis=1)
    worst = worst_friction(machine, at, rows, 1.0)
    assert (np.linalg.norm(rows.sum(axis=1), axis=1) < 0.5 * worst).all()
    assert (sampled <= worst).all()
    assert sampled == pytest.approx(worst, rel=0.01)


@pytest.mark.usefixtures("no_balls")
def test_no_smaller_force_moves_a_resting_handle(machine: MachineModel, positions: np.ndarray) -> None:
    field = feel_at(machine, DRIVE, positions)
    for k, p in enumerate(positions):
        torque = np.abs(directions() @ jacobian(machine.geometry, p)).max(axis=1)
        assert (field["friction_min"][k] * torque <= DRIVE.coulomb * (1.0 + 1e-12)).all()
        assert (1.01 * field["friction_min"][k] * torque > DRIVE.coulomb).any()


def test_steps_of_count_and_command(machine: MachineModel, positions: np.ndarray, field: Figures) -> None:
    g = machine.geometry
    for k, p in enumerate(positions):
        theta = inverse_kinematics(g, p)
        moved = [np.linalg.norm(forward_kinematics(g, theta + DRIVE.count * n) - p) for n in np.eye(3)]
        assert max(moved) == pytest.approx(field["position_step"][k], rel=5e-3)  # of second order in the count
        changed = np.linalg.solve(jacobian(g, p).T, DRIVE.step * np.eye(3))
        assert np.linalg.norm(changed, axis=0).max() == pytest.approx(field["force_step"][k], rel=1e-9)


def test_gravity_is_the_largest_of_the_joints(machine: MachineModel, positions: np.ndarray, field: Figures) -> None:
    for k, p in enumerate(positions):
        held = gravity_torque(machine.geometry, MASSES, p, machine.design.requirements.gravity_m_s2)
        assert field["gravity"][k] == pytest.approx(np.abs(held).max(), rel=1e-12)


def test_a_third_of_a_turn_changes_nothing(machine: MachineModel, positions: np.ndarray, field: Figures) -> None:
    third = 2.0 * np.pi / 3.0
    turn = np.array([[np.cos(third), -np.sin(third), 0.0], [np.sin(third), np.cos(third), 0.0], [0.0, 0.0, 1.0]])
    turned = feel_at(machine, DRIVE, positions @ turn.T)
    for name, values in field.items():
        if name not in ("mass_x", "mass_y"):
            assert turned[name] == pytest.approx(values, rel=1e-9), name


def test_no_ripple_of_joints_is_felt_as_more(machine: MachineModel, positions: np.ndarray, field: Figures) -> None:
    """Torque errors drawn within ripple and cogging, as forces by `torque = J^T force`: one corner reaches the most."""
    rng = np.random.default_rng(7)
    for k, p in enumerate(positions):
        held = gravity_torque(machine.geometry, MASSES, p, GRAVITY)
        for reported, torque in (
            (field["ripple_still"][k], held),
            (field["ripple_force"][k], np.full(3, DRIVE.continuous)),
        ):
            within = DRIVE.ripple * np.abs(torque) + DRIVE.cogging
            drawn = within * np.vstack([rng.uniform(-1.0, 1.0, (500, 3)), rng.choice([-1.0, 1.0], (100, 3))])
            force = np.linalg.norm(np.linalg.solve(jacobian(machine.geometry, p).T, drawn.T), axis=0)
            assert force.max() == pytest.approx(reported)
