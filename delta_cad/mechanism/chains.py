"""A delta as it came out of the shop: every chain with its own lengths and offsets, README (60)-(62).

The parallelograms still keep the platform from turning. What may differ by chain are the two radii, the two links, and
where the chain's plane lies: beside its place along the shoulder axis, and above it. The nominal mechanism is
`DeltaGeometry`; here the arrays of three say which chain is meant.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from delta_cad.mechanism import kernel
from delta_cad.mechanism.geometry import THREE_FOLD, VERTICAL, DeltaGeometry, directions, positions

PARAMETERS = (
    "base_radius",
    "platform_radius",
    "upper_arm_length",
    "forearm_length",
    "side_offset",
    "height_offset",
)
"""What a chain has of its own, in the order of the derivatives."""


@dataclass(frozen=True)
class UnequalDelta:
    """Lengths and offsets of each chain, m.

    Attributes:
        base_radius: (3,) R_i, base centre to shoulder axis.
        platform_radius: (3,) r_i, platform centre to wrist.
        upper_arm_length: (3,) L_A,i.
        forearm_length: (3,) L_B,i.
        side_offset: (3,) of the shoulder along its axis, less that of the wrist.
        height_offset: (3,) of the shoulder along z, less that of the wrist.
        side_cosine: Cosine of the azimuth of chain 1, as drawn; an error of it is a part of the side offsets.
    """

    base_radius: np.ndarray
    platform_radius: np.ndarray
    upper_arm_length: np.ndarray
    forearm_length: np.ndarray
    side_offset: np.ndarray
    height_offset: np.ndarray
    side_cosine: float = THREE_FOLD

    @property
    def radius_difference(self) -> np.ndarray:
        """(3,) R_i - r_i, the only combination of the radii that the kinematics sees, m."""
        return self.base_radius - self.platform_radius


def unequal(table: ArrayLike, side_cosine: float = THREE_FOLD) -> UnequalDelta:
    """Makes the record of a table.

    Args:
        table: (3 chains, 6) in the order of `PARAMETERS`, m.
        side_cosine: Cosine of the azimuth of chain 1.
    """
    return UnequalDelta(*np.asarray(table, dtype=float).T, side_cosine=side_cosine)


def equal_chains(g: DeltaGeometry) -> np.ndarray:
    """Gives the table of the nominal mechanism, (3 chains, 6) in the order of `PARAMETERS`, m."""
    one = [g.platform_radius, g.upper_arm_length, g.forearm_length, 0.0, 0.0]
    return np.column_stack([g.base_radii, np.tile(one, (3, 1))])


def chain_angles(u: UnequalDelta, p: ArrayLike) -> np.ndarray:
    """Computes the shoulder angles that hold the platform at a position, elbows outwards.

    Args:
        u: The mechanism.
        p: (..., 3) platform centre in the base frame, m.

    Returns:
        (..., 3 chains) rad; NaN where a chain cannot be closed.
    """
    p = positions(p)
    radial, tangential = directions(u.side_cosine)
    q = p @ radial.T - u.radius_difference
    t = p @ tangential.T - u.side_offset
    z = p[..., 2:] - u.height_offset
    rho2, m, w2 = kernel.chain_closure.py_func(q, t, z, u.upper_arm_length, u.forearm_length)
    cos, sin = kernel.arm.py_func(q, z, rho2, m, np.sqrt(np.where(w2 >= 0.0, w2, np.nan)))
    return np.arctan2(sin, cos)


def chain_positions(u: UnequalDelta, theta: ArrayLike) -> np.ndarray:
    """Computes the position of the platform for given shoulder angles, README (60)-(61).

    Args:
        u: The mechanism.
        theta: (..., 3 chains) shoulder angles, rad.

    Returns:
        (..., 3) platform centre, det S > 0, m; NaN where the forearms do not meet.
    """
    centres = _centres(u, positions(theta))
    first, l0, l1, l2 = centres[..., 0, :], *u.forearm_length
    b, c = centres[..., 1, :] - first, centres[..., 2, :] - first
    n = np.cross(b, c)
    n2 = _dot(n, n)
    n2 = np.where(n2 > 0.0, n2, np.nan)
    beta, gamma = (l0**2 - l1**2 + _dot(b, b)) / 2.0, (l0**2 - l2**2 + _dot(c, c)) / 2.0
    foot = (beta[..., None] * np.cross(c, n) + gamma[..., None] * np.cross(n, b)) / n2[..., None]
    square = l0**2 - _dot(foot, foot)
    height = np.sqrt(np.where(square >= 0.0, square, np.nan) / n2)
    return first + foot + height[..., None] * n


def chain_derivatives(u: UnequalDelta, theta: ArrayLike, p: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    """Computes how the position follows angles and lengths, README (62).

    Args:
        u: The mechanism.
        theta: (..., 3 chains) shoulder angles, rad.
        p: (..., 3) what `chain_positions` gives for them, m.

    Returns:
        The Jacobian (..., 3, 3 chains), m/rad, and the derivatives by the table (..., 3, 3 chains, 6); NaN or infinite
        at a direct singularity.
    """
    theta, p = positions(theta), positions(p)
    cos, sin = np.cos(theta)[..., None], np.sin(theta)[..., None]
    forearms = p[..., None, :] - _centres(u, theta)
    inverse = np.linalg.inv(forearms)
    radial, tangential = directions(u.side_cosine)
    along, moving = cos * radial + sin * VERTICAL, cos * VERTICAL - sin * radial
    outward = _dot(forearms, np.broadcast_to(radial, forearms.shape))
    rows = np.stack(
        [
            outward,
            -outward,
            _dot(forearms, along),
            np.broadcast_to(u.forearm_length, outward.shape),
            _dot(forearms, np.broadcast_to(tangential, forearms.shape)),
            forearms[..., 2],
        ],
        axis=-1,
    )
    turn = u.upper_arm_length * _dot(forearms, moving)
    return inverse * turn[..., None, :], inverse[..., None] * rows[..., None, :, :]


def _centres(u: UnequalDelta, theta: np.ndarray) -> np.ndarray:
    """(..., 3 chains, 3) elbows, moved in by the platform, m."""
    radial, tangential = directions(u.side_cosine)
    out = u.radius_difference + u.upper_arm_length * np.cos(theta)
    height = u.height_offset + u.upper_arm_length * np.sin(theta)
    return out[..., None] * radial + u.side_offset[:, None] * tangential + height[..., None] * VERTICAL


def _dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return (a * b).sum(axis=-1)
