"""The Jacobian against differences, power balance, the paper's form, both singularities, and MuJoCo."""

import mujoco
import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from delta_cad.mechanism import (
    DeltaGeometry,
    SingularError,
    UnreachableError,
    direct_margin,
    forearm_vectors,
    forward_kinematics,
    inverse_jacobian,
    inverse_kinematics,
    jacobian,
    joint_angles,
    serial_margin,
)
from delta_cad.mechanism.jacobian import velocity_map
from tests.delta_cad.mechanism.oracles import BOTTOM, HALF, PROPERTY, PUBLISHED, mechanisms, paper_h, points, rotation

STEP = 1e-4  # rad or relative to L_A; the five-point formula's error is the fourth power of it


def differences(function, at, step):
    """(..., 3, 3) five-point central differences, one column for each variable."""
    columns = []
    for k in range(3):
        e = step * np.eye(3)[k]
        columns.append((8 * (function(at + e) - function(at - e)) - function(at + 2 * e) + function(at - 2 * e)) / 12)
    return np.stack(columns, axis=-1) / step


def well_inside(g, p, limit=0.05):
    assume((paper_h(g, p) < 0).all())
    assume(serial_margin(g, p).min() > limit)
    assume(abs(direct_margin(g, p)) > limit)


@PROPERTY
@given(mechanisms(), points())
def test_jacobian_is_the_derivative_of_forward_kinematics(g, p):
    well_inside(g, p)
    assume(direct_margin(g, p) > 0)
    theta = inverse_kinematics(g, p)
    expected = differences(lambda angles: forward_kinematics(g, angles), theta, STEP)
    # fifth derivatives grow like det^-9 at worst; measured 1e-8 over the determinants allowed here, times ten
    np.testing.assert_allclose(jacobian(g, p), expected, atol=1e-7 * np.abs(expected).max() / direct_margin(g, p) ** 2)


@PROPERTY
@given(mechanisms(), points())
def test_inverse_jacobian_is_the_derivative_of_inverse_kinematics(g, p):
    well_inside(g, p)
    expected = differences(lambda q: joint_angles(g, q), p, 0.01 * STEP)
    # steps of 1 um: rounding 1e-15 rad / 1e-6 m = 1e-9 per m, and the root's curvature near the fold
    np.testing.assert_allclose(inverse_jacobian(g, p), expected, rtol=0, atol=1e-6 * np.abs(expected).max())


@PROPERTY
@given(mechanisms(), points(), st.tuples(*[st.floats(-5, 5)] * 6))
def test_power_at_the_handle_is_power_at_the_joints(g, p, numbers):
    well_inside(g, p, limit=0.01)
    force, rates = np.array(numbers[:3]), np.array(numbers[3:])
    j = jacobian(g, p)
    torque, velocity = j.T @ force, np.linalg.solve(inverse_jacobian(g, p), rates)
    # the velocity comes from the other matrix, so this is no identity; det 0.01 costs two digits of sixteen
    np.testing.assert_allclose(force @ velocity, torque @ rates, atol=1e-11)


@PROPERTY
@given(mechanisms(), points())
def test_rods_keep_their_length_at_that_velocity(g, p):
    well_inside(g, p, limit=0.01)
    theta = joint_angles(g, p)
    s, j = forearm_vectors(g, p), jacobian(g, p)
    for i in range(3):  # turning joint i alone: elbow i moves along its circle, the two others stand
        for k in range(3):
            direction = rotation(120.0 * k) @ [-np.sin(theta[k]), 0.0, np.cos(theta[k])]
            elbow_velocity = g.upper_arm_length * direction if k == i else np.zeros(3)
            # m^2/rad; J itself loses two digits at det 0.01
            assert s[k] @ (j[:, i] - elbow_velocity) == pytest.approx(0.0, abs=1e-12)


@PROPERTY
@given(mechanisms(), points())
def test_turning_the_position_turns_the_velocities(g, p):
    well_inside(g, p, limit=0.01)
    turn, mirror = rotation(120.0), np.diag([1.0, -1.0, 1.0])
    scale = np.abs(jacobian(g, p)).max() * 1e-10  # det and w of 0.01 cost some digits each
    np.testing.assert_allclose(jacobian(g, turn @ p), np.roll(turn @ jacobian(g, p), 1, axis=1), atol=scale)
    np.testing.assert_allclose(jacobian(g, mirror @ p), (mirror @ jacobian(g, p))[:, [0, 2, 1]], atol=scale)


def test_on_the_axis_by_hand():
    # level arms, forearms s = (-92, 0, z): all joints at rate 1 lift the platform; power on one forearm:
    # z v = z L_A, so v = L_A
    z = np.sqrt(0.112079**2 - 0.092**2)
    lift = jacobian(PUBLISHED, [0, 0, z]) @ np.ones(3)
    np.testing.assert_allclose(lift, [0, 0, 0.082], atol=1e-15)
    # sideways along x: joint 0 against the two others; s_0 = (-92, 0, z): -92 v = z L_A rate_0
    rates = inverse_jacobian(PUBLISHED, [0, 0, z]) @ [1.0, 0.0, 0.0]
    np.testing.assert_allclose(rates, -0.092 / (z * 0.082) * np.array([1.0, -0.5, -0.5]), rtol=1e-12)


def test_forearms_in_one_plane_are_a_direct_singularity():
    g = DeltaGeometry(0.03, 0.03 + 0.08, 0.08, 0.12)  # level arms under their wrists: all forearms vertical
    p = np.array([0.0, 0.0, 0.12])
    with pytest.raises(SingularError):
        jacobian(g, p)
    assert np.isnan(velocity_map(g, p)).all() or np.abs(velocity_map(g, p)).max() > 1e10
    # the inverse stands: a vertical velocity needs equal rates, a sideways one none
    np.testing.assert_allclose(inverse_jacobian(g, p), np.outer(np.ones(3), [0, 0, 1 / 0.08]), atol=1e-13)


def test_a_folded_chain_is_a_serial_singularity():
    g = DeltaGeometry(0.05, 0.03, 0.0625, 0.125)
    # wrist of chain 0 straight above its shoulder at L_B - L_A: x = R - r puts it there
    p = np.array([0.02, 0.0, 0.0625])
    assert serial_margin(g, p)[0] == 0.0
    with pytest.raises(SingularError, match="chain 0"):
        inverse_jacobian(g, p)
    np.testing.assert_array_equal(jacobian(g, p)[:, 0], 0.0)  # the joint turns, the platform stands
    assert np.isfinite(jacobian(g, p)).all()


def test_unreachable_is_refused():
    for function in (jacobian, inverse_jacobian):
        with pytest.raises(UnreachableError):
            function(PUBLISHED, [0, 0, 0.3])
    assert np.isnan(velocity_map(PUBLISHED, [0, 0, 0.3])).all()


def test_a_wrong_azimuth_breaks_the_power_balance_on_rods(monkeypatch):
    p = np.array([0.012, -0.02, 0.1])
    theta = inverse_kinematics(PUBLISHED, p)
    expected = differences(lambda angles: forward_kinematics(PUBLISHED, angles), theta, STEP)
    axes = [np.array([rotation(degrees)[:, k] for degrees in (0.0, 90.0, 240.0)]) for k in range(2)]
    monkeypatch.setattr("delta_cad.mechanism.geometry.directions", lambda _: axes)
    with pytest.raises(AssertionError):
        np.testing.assert_allclose(jacobian(PUBLISHED, p), expected, atol=1e-7)


def mjcf(g, azimuths=(0.0, 120.0, 240.0), radii=None):
    """The mechanism: hinged arms, one bar a chain on a ball joint, a platform on three slides, three closures."""
    geom = '<geom type="sphere" size="0.004" mass="0.01" contype="0" conaffinity="0"/>'
    arms, sites, closures = "", "", ""
    for i, (azimuth, radius) in enumerate(zip(azimuths, radii or [g.base_radius] * 3, strict=True)):
        c, s = float(np.cos(np.radians(azimuth))), float(np.sin(np.radians(azimuth)))
        arms += f"""
        <body name="arm{i}" pos="{radius * c!r} {radius * s!r} 0" axisangle="0 0 1 {azimuth}">
          <joint name="shoulder{i}" type="hinge" axis="0 -1 0"/>{geom}
          <body name="forearm{i}" pos="{g.upper_arm_length!r} 0 0">
            <joint name="elbow{i}" type="ball"/>{geom}
            <site name="end{i}" pos="{g.forearm_length!r} 0 0"/>
          </body>
        </body>"""
        sites += f'<site name="wrist{i}" pos="{g.platform_radius * c!r} {g.platform_radius * s!r} 0"/>'
        closures += f'<connect site1="end{i}" site2="wrist{i}"/>'
    slides = "".join(
        f'<joint name="slide{k}" type="slide" axis="{a}"/>' for k, a in enumerate(("1 0 0", "0 1 0", "0 0 1"))
    )
    text = f"""<mujoco><compiler angle="degree"/><option jacobian="dense"/>
      <worldbody>{arms}<body name="platform">{slides}{geom}{sites}</body></worldbody>
      <equality>{closures}</equality></mujoco>"""
    return mujoco.MjModel.from_xml_string(text)


def degrees_of_freedom(model):
    """Indices into the velocities: shoulders, elbows, slides."""
    address = {model.joint(k).name: int(model.joint(k).dofadr[0]) for k in range(model.njnt)}
    hinges = [address[f"shoulder{i}"] for i in range(3)]
    balls = [address[f"elbow{i}"] + k for i in range(3) for k in range(3)]
    return hinges, balls, [address[f"slide{k}"] for k in range(3)]


def closed(model, theta, start):
    """Data with the shoulders at theta and all closures met, by Newton on MuJoCo's own constraint Jacobian."""
    data = mujoco.MjData(model)
    _, balls, slides = degrees_of_freedom(model)
    for i in range(3):
        data.joint(f"shoulder{i}").qpos[:] = theta[i]
        # the bar's x axis turned up, and in by the arm's angle: roughly towards the platform
        half = -np.radians(100.0) / 2
        data.joint(f"elbow{i}").qpos[:] = [np.cos(half), 0.0, np.sin(half), 0.0]
        data.joint(f"slide{i}").qpos[:] = start[i]
    free = balls + slides
    for _ in range(100):
        mujoco.mj_fwdPosition(model, data)
        error = np.array(data.efc_pos)
        assert error.shape == (9,)
        if np.abs(error).max() < 1e-14:
            break
        constraint = np.array(data.efc_J).reshape(9, model.nv)
        step = np.zeros(model.nv)
        step[free] = -np.linalg.pinv(constraint[:, free], rcond=1e-10) @ error
        step *= min(1.0, 0.5 / np.abs(step).max())  # at most half a radian a step
        mujoco.mj_integratePos(model, data.qpos, step, 1.0)
    assert np.abs(data.efc_pos).max() < 1e-13  # m; rounding of some ten products
    return data


def engine_position(data):
    return np.array([data.joint(f"slide{k}").qpos[0] for k in range(3)])


def engine_jacobian(model, data):
    hinges, balls, slides = degrees_of_freedom(model)
    constraint = np.array(data.efc_J).reshape(9, model.nv)
    # the spin of each bar about itself is free: the least-squares solution leaves it at rest
    rates = -np.linalg.pinv(constraint[:, balls + slides], rcond=1e-10) @ constraint[:, hinges]
    return rates[-3:]


def positions():
    rng = np.random.default_rng(11)
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (0, 2)]) * HALF
    inside = rng.uniform([-HALF, -HALF, 0], [HALF, HALF, 2 * HALF], (12, 3))
    return np.concatenate([corners, inside]) + np.array([0, 0, BOTTOM])


def check_engine(model, g, p):
    theta = inverse_kinematics(g, p)
    data = closed(model, theta, p + np.array([0.002, -0.001, 0.003]))
    # m: closures to 1e-13 over a determinant above 0.7
    np.testing.assert_allclose(engine_position(data), p, atol=1e-12)
    np.testing.assert_allclose(forward_kinematics(g, theta), engine_position(data), atol=1e-12)
    np.testing.assert_allclose(jacobian(g, p), engine_jacobian(model, data), atol=1e-11)


@pytest.mark.parametrize(
    "g", [PUBLISHED, DeltaGeometry(0.045, 0.025, 0.075, 0.130), DeltaGeometry(0.035, 0.040, 0.085, 0.120)]
)
def test_the_engine_agrees_in_position_and_jacobian(g):
    model = mjcf(g)
    for p in positions():
        check_engine(model, g, p)


@pytest.mark.parametrize(("phi", "side"), [(116.3, 0.03845), (124.0, 0.026), (102.0, 0.044), (138.0, 0.031)])
def test_the_engine_agrees_where_chains_stand_elsewhere(phi, side):
    lengths, placement = (0.03119, 0.02255, 0.0944, 0.1484), (side - 0.03119, np.cos(np.radians(phi)))
    model = mjcf(DeltaGeometry(*lengths), (0.0, phi, -phi), [0.03119, side, side])
    for p in np.add(positions()[::3], [0.0111, 0.0, 0.0187]):
        check_engine(model, DeltaGeometry(*lengths, *placement), p)
    with pytest.raises(AssertionError):
        check_engine(model, DeltaGeometry(*lengths, placement[0]), p)
    with pytest.raises(AssertionError):
        check_engine(model, DeltaGeometry(*lengths, side_cosine=placement[1]), p)


def test_a_wrong_azimuth_is_caught_by_the_engine():
    p = np.array([0.01, 0.02, 0.1])
    with pytest.raises(AssertionError):
        check_engine(mjcf(PUBLISHED, azimuths=(0.0, 90.0, 240.0)), PUBLISHED, p)


def test_statics_of_the_engine_balance_a_force_at_the_handle():
    # the engine's own virtual power: torques that hold a force are those of J^T
    model, force = mjcf(PUBLISHED), np.array([1.0, -2.0, 0.5])
    p = np.array([0.02, -0.015, 0.09])
    data = closed(model, inverse_kinematics(PUBLISHED, p), p)
    constraint = np.array(data.efc_J).reshape(9, model.nv)
    hinges, balls, slides = degrees_of_freedom(model)
    applied = np.zeros(model.nv)
    applied[slides] = force
    # closure forces that carry the load on the passive joints; what reaches the hinges must be held there
    passive = balls + slides
    carried = np.linalg.lstsq(constraint[:, passive].T, -applied[passive], rcond=None)[0]
    np.testing.assert_allclose((constraint.T @ carried)[hinges], jacobian(PUBLISHED, p).T @ force, atol=1e-11)
