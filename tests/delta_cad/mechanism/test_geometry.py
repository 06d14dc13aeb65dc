"""The record of lengths, the chain directions, and what the public edge refuses."""

import math

import numpy as np
import pytest

from delta_cad import mechanism
from delta_cad.mechanism import DeltaGeometry, GeometryError, MechanismError, SingularError, UnreachableError
from delta_cad.mechanism.geometry import THREE_FOLD, VERTICAL, directions
from tests.delta_cad.mechanism.oracles import PUBLISHED, rotation

RADIAL, TANGENTIAL = directions(THREE_FOLD)
LENGTHS = {"base_radius": 0.04, "platform_radius": 0.03, "upper_arm_length": 0.082, "forearm_length": 0.112}


@pytest.mark.parametrize("field", LENGTHS)
@pytest.mark.parametrize("value", [0.0, -0.04, math.nan, math.inf, -math.inf, 82.0])
def test_impossible_length_is_refused_with_field_value_and_bound(field, value):
    with pytest.raises(GeometryError) as caught:
        DeltaGeometry(**LENGTHS | {field: value})
    message = str(caught.value)
    assert field in message
    assert repr(value) in message
    assert "greater than 0 and at most 10 m" in message


def test_errors_are_one_family():
    for error in (GeometryError, UnreachableError, SingularError):
        assert issubclass(error, MechanismError)
        assert issubclass(error, ValueError)


def test_record_is_frozen_and_constants_are_read_only():
    with pytest.raises(AttributeError):
        PUBLISHED.__setattr__("base_radius", 1.0)
    with pytest.raises(ValueError, match="read-only"):
        RADIAL[0, 0] = 2.0


def test_chain_directions_are_the_first_one_turned_by_120_degrees():
    for i in range(3):
        turned = rotation(120.0 * i)
        # cos and sin of 120 deg carry one rounding each
        np.testing.assert_allclose(RADIAL[i], turned @ [1, 0, 0], atol=4e-16)
        np.testing.assert_allclose(TANGENTIAL[i], turned @ [0, 1, 0], atol=4e-16)
        assert np.isclose(PUBLISHED.azimuths[i], i * 2 * np.pi / 3, rtol=1e-15)
    np.testing.assert_allclose(np.cross(VERTICAL, RADIAL), TANGENTIAL, atol=0)


def test_only_the_difference_of_the_radii_matters_for_the_angles():
    p = [0.01, -0.02, 0.09]
    other = DeltaGeometry(0.060, 0.050, 0.082, 0.112079)
    theta = mechanism.inverse_kinematics(PUBLISHED, p)
    # the difference 0.06 - 0.05 is rounded differently from 0.04 - 0.03
    np.testing.assert_allclose(mechanism.inverse_kinematics(other, p), theta, rtol=1e-14)


@pytest.mark.parametrize("p", [0.1, [0.1, 0.2], np.zeros((3, 4)), []])
def test_last_axis_must_hold_three_numbers(p):
    with pytest.raises(GeometryError, match="shape"):
        mechanism.inverse_kinematics(PUBLISHED, p)
    with pytest.raises(GeometryError, match="shape"):
        mechanism.forward_kinematics(PUBLISHED, p)


BATCHED = {
    "closure_margin": (3,),
    "joint_angles": (3,),
    "inverse_kinematics": (3,),
    "reach_excess": (3,),
    "forearm_vectors": (3, 3),
    "wrist_positions": (3, 3),
    "jacobian": (3, 3),
    "inverse_jacobian": (3, 3),
    "singular_values": (3,),
    "conditioning": (),
    "serial_margin": (3,),
    "direct_margin": (),
    "rod_lean": (3,),
    "forearm_angle": (3,),
}


@pytest.mark.parametrize("name", BATCHED)
def test_a_batch_gives_what_its_poses_give_one_by_one(name):
    function, shape = getattr(mechanism, name), BATCHED[name]
    p = np.random.default_rng(1).uniform([-0.03, -0.03, 0.06], [0.03, 0.03, 0.13], (2, 4, 3))
    batch = function(PUBLISHED, p)
    assert batch.shape == (2, 4, *shape)
    assert function(PUBLISHED, np.empty((0, 3))).shape == (0, *shape)
    for index in np.ndindex(2, 4):
        # matrix products of other shapes may add in another order: a few roundings
        np.testing.assert_allclose(batch[index], function(PUBLISHED, p[index]), rtol=1e-12, atol=1e-16)


def test_forward_elbows_and_torque_are_batched_too():
    p = np.random.default_rng(2).uniform([-0.03, -0.03, 0.06], [0.03, 0.03, 0.13], (2, 4, 3))
    theta = mechanism.inverse_kinematics(PUBLISHED, p)
    assert mechanism.forward_kinematics(PUBLISHED, theta).shape == (2, 4, 3)
    assert mechanism.platform_positions(PUBLISHED, theta).shape == (2, 4, 3)
    assert mechanism.elbow_positions(PUBLISHED, theta).shape == (2, 4, 3, 3)
    assert mechanism.worst_joint_torque(PUBLISHED, p, 3.0).shape == (2, 4, 3)
