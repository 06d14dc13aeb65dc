"""Torque that holds the device against gravity, for any direction of gravity, by virtual work."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from delta_cad.drive.masses import Masses, PointMasses
from delta_cad.mechanism import DeltaGeometry, inverse_kinematics, jacobian
from delta_cad.mechanism.geometry import VERTICAL


def gravity_torque(
    geometry: DeltaGeometry, masses: Masses | PointMasses, p: ArrayLike, gravity_vector: ArrayLike
) -> np.ndarray:
    """Torque of each joint that holds the moving bodies: minus the torque of gravity.

    A turn d theta_i moves the platform by J d theta and the bodies of arm i by d theta_i about the shoulder; in
    equilibrium `torque . d theta + gravity's work = 0` for every d theta. So with W the mass that hangs on the
    platform, m_e what hangs on an elbow, x_i the direction of the arm and e_i that of the elbow's motion,
    `torque_i = -W (J^T g)_i - (arm_along + m_e L_A) g . e_i + arm_across g . x_i`.

    Args:
        geometry: The mechanism.
        masses: From the solids, or the paper's three.
        p: (..., 3) platform centre in the base frame, m.
        gravity_vector: (3,) acceleration of gravity in the base frame, m/s^2; tilted as the dashboard is.

    Returns:
        (..., 3 chains) N m.

    Raises:
        UnreachableError: A chain cannot be closed at one of the positions.
        SingularError: The three forearms lie in one plane.

    Source:
        [RCIM2018] eqs. (17)-(22); the paper's `tau = J^T 3 G_B + [n x A P] . G_P` is the torque of gravity, ours its
        negative. With `PointMasses` they agree; the solids add the arm's moment across its own length.
    """
    g = np.asarray(gravity_vector, dtype=float)
    known = _as_masses(geometry, masses)
    along, across = arm_directions(geometry, inverse_kinematics(geometry, p))
    platform_torque = np.swapaxes(jacobian(geometry, p), -1, -2) @ (known.at_wrists * g)
    moment = known.arm_along + known.at_elbow * geometry.upper_arm_length
    return -platform_torque - moment * (across @ g) + known.arm_across * (along @ g)


def potential_energy(
    geometry: DeltaGeometry, masses: Masses | PointMasses, p: ArrayLike, gravity_vector: ArrayLike
) -> np.ndarray:
    """Potential energy of the moving bodies, zero for each at its shoulder or at the base's centre.

    Args:
        geometry: The mechanism.
        masses: From the solids, or the paper's three.
        p: (..., 3) platform centre in the base frame, m.
        gravity_vector: (3,) acceleration of gravity, m/s^2.

    Returns:
        (...) J.

    Raises:
        UnreachableError: A chain cannot be closed at one of the positions.
    """
    g = np.asarray(gravity_vector, dtype=float)
    known = _as_masses(geometry, masses)
    along, across = arm_directions(geometry, inverse_kinematics(geometry, p))
    moment = known.arm_along + known.at_elbow * geometry.upper_arm_length
    arms = moment * (along @ g) + known.arm_across * (across @ g)
    return -known.at_wrists * (np.asarray(p, dtype=float) @ g) - arms.sum(axis=-1)


def arm_directions(geometry: DeltaGeometry, theta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Directions of the upper arms and of their elbows' motion.

    Args:
        geometry: The mechanism.
        theta: (..., 3 chains) shoulder angles, rad.

    Returns:
        Along and across: each (..., 3 chains, 3) unit vectors in the base frame.
    """
    cos, sin = np.cos(theta)[..., None], np.sin(theta)[..., None]
    return cos * geometry.radial + sin * VERTICAL, cos * VERTICAL - sin * geometry.radial


def _as_masses(geometry: DeltaGeometry, masses: Masses | PointMasses) -> Masses:
    return masses.masses(geometry.upper_arm_length) if isinstance(masses, PointMasses) else masses
