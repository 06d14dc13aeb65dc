"""The twin in MuJoCo: it loads, closes, weighs and resists as the solids do, and moves as our equations say."""

# pyright: reportAttributeAccessIssue=false
# The engine's binding declares its functions at run time.

from __future__ import annotations

from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
from scipy.linalg import null_space
from scipy.spatial.transform import Rotation

from delta_cad.assembly.machine import Assembly
from delta_cad.design import Design
from delta_cad.dimensions import Dimensions
from delta_cad.drive import drive_torque
from delta_cad.drive.friction import joint_friction
from delta_cad.drive.masses import masses_from_dict
from delta_cad.export.mass_properties import mass_report
from delta_cad.export.robot import Robot, mjcf
from delta_cad.mechanism import DeltaGeometry, inverse_kinematics
from delta_cad.mechanism.placement import LINKS
from haptics.gravity import gravity_torque
from haptics.model.plant import FREE, STATES, Plant, advance, motion, plant

GRAVITY = (1.0, -2.0, -9.0)  # tilted, so that no symmetry hides an error
ZERO = np.zeros(3)
DOF = 3 + 6 * 2 + 3  # shoulders, rods that swing and lean, slides


@pytest.fixture(scope="module")
def masses(best_assembly: Assembly) -> dict[str, Any]:
    return mass_report(best_assembly)


@pytest.fixture(scope="module")
def text(best: Design, best_dimensions: Dimensions, best_assembly: Assembly, masses: dict[str, Any]) -> str:
    return mjcf(Robot(best_assembly, masses["bodies"], drive_torque(best), best_dimensions.stops_rad), GRAVITY)


@pytest.fixture(scope="module")
def model(text: str, tmp_path_factory: pytest.TempPathFactory) -> Any:
    file = tmp_path_factory.mktemp("twin") / "twin.xml"
    file.write_text(text)
    return mujoco.MjModel.from_xml_path(str(file))


@pytest.fixture(scope="module")
def ours(best: Design, masses: dict[str, Any]) -> tuple[DeltaGeometry, Any, Plant]:
    drive = drive_torque(best)
    known = masses_from_dict(masses, best.geometry.forearm_length, drive)
    return best.geometry, known, plant(best.geometry, known, GRAVITY)


def posed(model: Any, assembly: Assembly, p_mm: np.ndarray) -> Any:
    """The engine's data with every body where our closed form has it."""
    data = mujoco.MjData(model)
    at, home = assembly.placement(p_mm), assembly.placement(np.asarray(assembly.home_mm))
    theta, theta_home = (
        inverse_kinematics(assembly.placement.geometry, np.asarray(p) / 1000.0) for p in (p_mm, assembly.home_mm)
    )
    for i in range(3):
        data.joint(f"shoulder_{i}").qpos = theta[i] - theta_home[i]
        for j in range(2):
            now, before = (
                f[f"upper_arm_{i}"][:3, :3].T @ f[f"rod_{i}_{j}"][:3, :3] for f in (at, home)
            )  # in the arm's frame
            swing, lean, turn = Rotation.from_matrix(before.T @ now).as_euler("YZX")
            assert abs(turn) < 1e-12  # in the plane of its pair, where the springs hold it
            data.joint(f"elbow_{i}_{j}_swing").qpos, data.joint(f"elbow_{i}_{j}_lean").qpos = swing, lean
    for k, axis in enumerate("xyz"):
        data.joint(f"platform_{axis}").qpos = (p_mm[k] - assembly.home_mm[k]) / 1000.0
    mujoco.mj_forward(model, data)
    return data


def poses(assembly: Assembly, count: int) -> np.ndarray:
    return np.asarray(assembly.home_mm) + np.random.default_rng(8).uniform(-35.0, 35.0, (count, 3))


def closures(model: Any, data: Any) -> np.ndarray:
    """(18, DOF) Jacobian of the closures as the engine has it."""
    jacobian = np.zeros((data.nefc, model.nv))
    jacobian[:] = data.efc_J.reshape(data.nefc, model.nv)
    return jacobian[np.asarray(data.efc_type) == mujoco.mjtConstraint.mjCNSTR_EQUALITY]


def test_every_link_is_there_with_its_mass(model: Any, masses: dict[str, Any]) -> None:
    names = [model.body(k).name for k in range(1, model.nbody)]
    assert set(names) == {link for link in LINKS if not link.startswith(("pinion", "spring"))}
    assert (model.nv, model.nu, model.neq) == (DOF, 3, 6)
    for name in names:
        body, known = model.body(name), masses["bodies"][name]
        assert body.mass[0] == pytest.approx(known["mass_kg"], rel=1e-12)
        rotated = Rotation.from_quat(np.roll(body.iquat, -1)).as_matrix()
        inertia = rotated @ np.diag(body.inertia) @ rotated.T
        assert inertia == pytest.approx(np.array(known["inertia_kg_m2"]), abs=1e-9 * np.abs(inertia).max())


def test_every_pose_is_closed(model: Any, best_assembly: Assembly) -> None:
    data = mujoco.MjData(model)
    mujoco.mj_forward(model, data)
    assert np.abs(data.efc_pos).max() < 1e-12
    for p in poses(best_assembly, 5):
        data = posed(model, best_assembly, p)
        assert np.abs(np.asarray(data.efc_pos)[: 6 * 3]).max() < 1e-12
        frames = best_assembly.placement(p)
        for name in ("upper_arm_1", "rod_2_0", "platform"):
            assert data.body(name).xpos == pytest.approx(frames[name][:3, 3] / 1000.0, abs=1e-12)


def test_the_engine_holds_the_same_against_gravity(model: Any, best_assembly: Assembly, ours: Any) -> None:
    geometry, masses, _ = ours
    shoulders = [model.joint(f"shoulder_{i}").dofadr[0] for i in range(3)]
    for p in poses(best_assembly, 10):
        data = posed(model, best_assembly, p)
        admissible = null_space(closures(model, data), rcond=1e-9)
        assert admissible.shape[1] == 3  # ways to move
        torque = np.linalg.solve(admissible[shoulders].T, admissible.T @ data.qfrc_bias)
        held = gravity_torque(geometry, masses, p / 1000.0, GRAVITY)
        assert torque == pytest.approx(held, rel=1e-9)  # centres beside the axes cancel in a pair


def test_the_engine_resists_the_same(model: Any, best_assembly: Assembly, ours: Any) -> None:
    *_, par = ours
    slides = [model.joint(f"platform_{axis}").dofadr[0] for axis in "xyz"]
    for p in poses(best_assembly, 5):
        data = posed(model, best_assembly, p)
        full = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, data, full)
        admissible = null_space(closures(model, data), rcond=1e-9)
        reduced = admissible.T @ full @ admissible
        compliance = admissible[slides] @ np.linalg.solve(reduced, admissible[slides].T)
        state = np.zeros(STATES)
        state[:3] = p / 1000.0
        m11, m22, m33, m12, m13, m23 = motion(par, 0.0, state, np.empty((6, 3)))
        expected = np.array([[m11, m12, m13], [m12, m22, m23], [m13, m23, m33]])
        # left out in ours: 0.01 % of difference between a rod's two transverse inertias and its turn with the pair's
        # plane, 2e-8 kg m^2 over L_B^2 for each, 1e-6 kg of 0.2 kg
        assert np.linalg.inv(compliance) == pytest.approx(expected, rel=0.0, abs=2e-6)


def test_the_engine_converges_to_our_motion_at_first_order(model: Any, best_assembly: Assembly, ours: Any) -> None:
    *_, par = ours
    torque, seconds, home = np.array([0.02, -0.05, 0.06]), 0.06, np.asarray(best_assembly.home_mm) / 1000.0
    exact = np.zeros(STATES)
    exact[:3] = home
    advance(par, FREE, ZERO, ZERO, torque, seconds, 2000, exact, np.zeros((13, STATES)))
    assert np.linalg.norm(exact[:3] - home) > 5e-3
    errors = []
    for step in (2e-4, 1e-4, 5e-5):
        model.opt.timestep = step
        model.eq_solref[:] = [2.0 * step, 1.0]  # the stiffest that the engine takes at this step
        data = mujoco.MjData(model)
        data.ctrl[:] = torque
        for _ in range(round(seconds / step)):
            mujoco.mj_step(model, data)
        errors.append(np.linalg.norm(data.qpos[-3:] + home - exact[:3]))
    assert np.diff(np.log2(errors)) == pytest.approx([-1.0, -1.0], abs=0.1)
    assert errors[-1] < 1e-3 * np.linalg.norm(exact[:3] - home)


def test_a_direct_drive_has_no_pinion(best: Design, best_assembly: Assembly, masses: dict[str, Any]) -> None:
    bare = {name: body for name, body in masses["bodies"].items() if "pinion" not in name}
    drive = drive_torque(best)
    light = mujoco.MjModel.from_xml_string(mjcf(Robot(best_assembly, bare, drive, (-1.0, 1.0)), GRAVITY))
    assert light.dof_armature[:1] == pytest.approx(drive.reflected_inertia_kg_m2, rel=1e-12)


def test_motors_give_what_the_controller_lets_them_and_joints_rub(
    best: Design, best_assembly: Assembly, masses: dict[str, Any], model: Any
) -> None:
    drive = drive_torque(best)
    assert drive.controlled_torque_N_m < drive.peak_torque_N_m
    coulomb, viscous = joint_friction(best)
    robot = Robot(best_assembly, masses["bodies"], drive, (-1.0, 1.0), (coulomb, viscous))
    rubs = mujoco.MjModel.from_xml_string(mjcf(robot, (0.0, 0.0, 0.0)))
    np.testing.assert_array_equal(rubs.actuator_ctrlrange, [[-0.8, 0.8]] * 3)
    shoulders = [rubs.joint(f"shoulder_{i}").dofadr[0] for i in range(3)]
    np.testing.assert_array_equal(rubs.dof_frictionloss[shoulders], [coulomb] * 3)
    np.testing.assert_array_equal(rubs.dof_damping[shoulders], [viscous] * 3)
    assert not model.dof_frictionloss.any()
    # without gravity a torque below the friction holds the arms where they are, one above turns them; the engine's
    # friction creeps, for it is as soft as a closure
    moved = []
    for torque in (0.5 * coulomb, 2.0 * coulomb):
        data = mujoco.MjData(rubs)
        data.ctrl[:] = torque
        for _ in range(500):
            mujoco.mj_step(rubs, data)
        moved.append(float(np.abs(data.qpos[shoulders]).max()))
    assert moved[0] < 0.05 * moved[1]


def test_the_build_writes_it(built: Any) -> None:
    file: Path = built.folder / "twin.xml"
    read = mujoco.MjModel.from_xml_path(str(file))
    assert read.nu == 3
    assert read.dof_frictionloss.max() > 0.0
