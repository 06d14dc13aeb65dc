"""The four lengths of the mechanism, the directions of its chains, and a position seen from a chain."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import ArrayLike

from delta_cad.mechanism.errors import GeometryError

LENGTH_MAX = 10.0  # m; far above any haptic device, so that millimetres given as metres are refused

_TOLERANCE_SHARE = 0.1  # largest tolerance as a share of the shorter link; parts are made to thousandths of it

AZIMUTHS = np.radians([0.0, 120.0, 240.0])  # (3,) azimuth phi_i of each chain about the base z axis, rad.

# Sine of 60 degrees; one double for all, so that chains 1 and 2 mirror each other to the last bit.
SIN_60 = float(np.sqrt(3.0) / 2.0)
# (3 chains, 3) unit vector from the base centre to each shoulder.
RADIAL = np.array([[1.0, 0.0, 0.0], [-0.5, SIN_60, 0.0], [-0.5, -SIN_60, 0.0]])
# (3 chains, 3) unit vector along each shoulder axis: z cross radial.
TANGENTIAL = np.array([[0.0, 1.0, 0.0], [-SIN_60, -0.5, 0.0], [SIN_60, -0.5, 0.0]])
VERTICAL = np.array([0.0, 0.0, 1.0])  # (3,) unit vector from the base plane to the platform.

for _constant in (AZIMUTHS, RADIAL, TANGENTIAL, VERTICAL):
    _constant.flags.writeable = False


@dataclass(frozen=True)
class DeltaGeometry:
    """The lengths that decide the kinematics.

    Attributes:
        base_radius: R, base centre to shoulder axis, m.
        platform_radius: r, platform centre to wrist, m.
        upper_arm_length: L_A, shoulder to elbow, m.
        forearm_length: L_B, elbow to wrist, m.

    Raises:
        GeometryError: A length is not a finite number in (0, 10] m.
    """

    base_radius: float
    platform_radius: float
    upper_arm_length: float
    forearm_length: float

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if not 0.0 < value <= LENGTH_MAX:  # also refuses NaN
                raise GeometryError(
                    f"{field.name} is {value!r} m; it must be greater than 0 and at most {LENGTH_MAX:g} m"
                )

    @property
    def radius_difference(self) -> float:
        """A = R - r, the only combination of the two radii that the kinematics sees, m."""
        return self.base_radius - self.platform_radius


def largest_tolerance(g: DeltaGeometry) -> float:
    """Computes the largest tolerance of the lengths that a proof takes: a tenth of the shorter link, m."""
    return _TOLERANCE_SHARE * min(g.upper_arm_length, g.forearm_length)


def require_tolerance(g: DeltaGeometry, tolerance: float) -> None:
    """Refuses a tolerance that is none.

    Args:
        g: The mechanism.
        tolerance: Of every length and offset of every chain, m.

    Raises:
        GeometryError: It is negative, not finite, or more than `largest_tolerance`.
    """
    most = largest_tolerance(g)
    if not 0.0 <= tolerance <= most:
        raise GeometryError(f"tolerance is {tolerance!r} m; it must be within 0 and {most:.6g} m, a tenth of a link")


def positions(p: ArrayLike) -> np.ndarray:
    """Gives positions as an array of doubles, their last axis checked.

    Args:
        p: (..., 3) anything NumPy reads as numbers.

    Returns:
        (..., 3) doubles.

    Raises:
        GeometryError: The last axis does not hold three numbers.
    """
    p = np.asarray(p, dtype=float)
    if p.ndim == 0 or p.shape[-1] != 3:
        raise GeometryError(f"an array of shape {p.shape} was given; its last axis must hold 3 numbers")
    return p


def chain_coordinates(g: DeltaGeometry, p: ArrayLike) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Computes the wrist of each chain as seen from its shoulder, README (1).

    Returns:
        q, t, z: each (..., 3 chains), m: radial, along the shoulder axis, and vertical.
    """
    p = positions(p)
    q = p @ RADIAL.T - g.radius_difference
    t = p @ TANGENTIAL.T
    z = np.broadcast_to(p[..., 2:], q.shape)
    return q, t, z
