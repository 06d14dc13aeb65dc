"""The Jacobian against finite differences, power balance, the paper's own form and both singularities."""

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
    serial_margin,
)
from delta_cad.mechanism.jacobian import velocity_map
from tests.delta_cad.mechanism.oracles import PROPERTY, PUBLISHED, mechanisms, paper_h, points, rotation

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
    expected = differences(lambda q: inverse_kinematics(g, q), p, 0.01 * STEP)
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
    theta = inverse_kinematics(g, p)
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
    with pytest.raises(SingularError, match="not held: the three forearms lie in one plane"):
        jacobian(g, p)
    assert np.isnan(velocity_map(g, p)).all() or np.abs(velocity_map(g, p)).max() > 1e10
    # the inverse stands: a vertical velocity needs equal rates, a sideways one none
    np.testing.assert_allclose(inverse_jacobian(g, p), np.outer(np.ones(3), [0, 0, 1 / 0.08]), atol=1e-13)


def test_a_folded_chain_is_a_serial_singularity():
    g = DeltaGeometry(0.05, 0.03, 0.0625, 0.125)
    # wrist of chain 0 straight above its shoulder at L_B - L_A: x = R - r puts it there
    p = np.array([0.02, 0.0, 0.0625])
    assert serial_margin(g, p)[0] == 0.0
    with pytest.raises(SingularError, match="chain 0 cannot follow"):
        inverse_jacobian(g, p)
    np.testing.assert_array_equal(jacobian(g, p)[:, 0], 0.0)  # the joint turns, the platform stands
    assert np.isfinite(jacobian(g, p)).all()


def test_unreachable_is_refused():
    for function in (jacobian, inverse_jacobian):
        with pytest.raises(UnreachableError, match="cannot be closed"):
            function(PUBLISHED, [0, 0, 0.3])
    assert np.isnan(velocity_map(PUBLISHED, [0, 0, 0.3])).all()


def test_a_wrong_azimuth_breaks_the_power_balance_on_rods(monkeypatch):
    p = np.array([0.012, -0.02, 0.1])
    theta = inverse_kinematics(PUBLISHED, p)
    expected = differences(lambda angles: forward_kinematics(PUBLISHED, angles), theta, STEP)
    wrong = np.array([rotation(degrees) @ [1.0, 0.0, 0.0] for degrees in (0.0, 90.0, 240.0)])
    monkeypatch.setattr("delta_cad.mechanism.inverse.RADIAL", wrong)
    with pytest.raises(AssertionError):
        np.testing.assert_allclose(jacobian(PUBLISHED, p), expected, atol=1e-7)
