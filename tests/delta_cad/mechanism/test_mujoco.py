"""Another engine: MuJoCo's constraint solver on the real closed chain against closed forms of position and Jacobian."""

# mujoco fills its namespace at run time:
# pyright: reportAttributeAccessIssue=false

import mujoco
import numpy as np
import pytest

from delta_cad.mechanism import DeltaGeometry, forward_kinematics, inverse_kinematics, jacobian
from tests.delta_cad.mechanism.oracles import BOTTOM, HALF, PUBLISHED


def mjcf(g, azimuths=(0.0, 120.0, 240.0)):
    """The mechanism: hinged arms, one bar a chain on a ball joint, a platform on three slides, three closures."""
    geom = '<geom type="sphere" size="0.004" mass="0.01" contype="0" conaffinity="0"/>'
    arms, sites, closures = "", "", ""
    for i, azimuth in enumerate(azimuths):
        c, s = float(np.cos(np.radians(azimuth))), float(np.sin(np.radians(azimuth)))
        arms += f"""
        <body name="arm{i}" pos="{g.base_radius * c!r} {g.base_radius * s!r} 0" axisangle="0 0 1 {azimuth}">
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
