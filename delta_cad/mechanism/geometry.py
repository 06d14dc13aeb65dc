"""The lengths of the mechanism, where its chains stand about the base, and a position seen from a chain.

The placement is mirror symmetric about the plane of x and z: chain 0 stands on the positive x axis, chains 1 and 2 are
mirror images of each other. It is described by algebraic numbers alone, the cosine of the azimuth of chains 1 and 2 and
how much farther out their shoulders stand, so that no sine or cosine is evaluated in a search or in a proof.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property, lru_cache

import numpy as np
from numpy.typing import ArrayLike

from delta_cad.mechanism.errors import GeometryError

LENGTH_MAX = 10.0  # m; far above any haptic device, so that millimetres given as metres are refused

_TOLERANCE_SHARE = 0.1  # largest tolerance as a share of the shorter link; parts are made to thousandths of it

# Sine of 60 degrees; one double for all, so that chains 1 and 2 mirror each other to the last bit.
SIN_60 = float(np.sqrt(3.0) / 2.0)
THREE_FOLD = -0.5  # cosine of 120 degrees: chains 1 and 2 of a three-fold symmetric machine
AZIMUTH_MIN_DEG, AZIMUTH_MAX_DEG = 60.0, 150.0
"""Smallest and largest azimuth of chain 1: nearer to chain 0 or to chain 2 no two chains have room."""
_COSINE_MIN, _COSINE_MAX = -math.sqrt(0.75) * (1.0 + 1e-12), 0.5 * (1.0 + 1e-12)
VERTICAL = np.array([0.0, 0.0, 1.0])  # (3,) unit vector from the base plane to the platform.
VERTICAL.flags.writeable = False


@dataclass(frozen=True)
class DeltaGeometry:
    """The lengths and the placement that decide the kinematics.

    Attributes:
        base_radius: R_0, base centre to the shoulder axis of chain 0, m.
        platform_radius: r, platform centre to every wrist, m.
        upper_arm_length: L_A, shoulder to elbow, m.
        forearm_length: L_B, elbow to wrist, m.
        side_shift: R_1 - R_0: how much farther out the shoulders of chains 1 and 2 stand, m.
        side_cosine: Cosine of the azimuth phi of chain 1; that of chain 2 is -phi.

    Raises:
        GeometryError: A length is not a finite number in (0, 10] m, a shoulder of chains 1 and 2 neither, or their
            azimuth is not within 60 and 150 degrees.
    """

    base_radius: float
    platform_radius: float
    upper_arm_length: float
    forearm_length: float
    side_shift: float = 0.0
    side_cosine: float = THREE_FOLD

    def __post_init__(self) -> None:
        for name in ("base_radius", "platform_radius", "upper_arm_length", "forearm_length"):
            value = getattr(self, name)
            if not 0.0 < value <= LENGTH_MAX:  # also refuses NaN
                raise GeometryError(f"{name} is {value!r} m; it must be greater than 0 and at most {LENGTH_MAX:g} m")
        side = self.base_radius + self.side_shift
        if not 0.0 < side <= LENGTH_MAX:
            raise GeometryError(
                f"side_shift is {self.side_shift!r} m; base_radius + side_shift must be greater than 0 and at most "
                f"{LENGTH_MAX:g} m"
            )
        if not _COSINE_MIN <= self.side_cosine <= _COSINE_MAX:
            raise GeometryError(
                f"side_cosine is {self.side_cosine!r}; it must be within {_COSINE_MIN:.6f} and {_COSINE_MAX:.6f}, "
                f"azimuths of {AZIMUTH_MIN_DEG:g} to {AZIMUTH_MAX_DEG:g} degrees"
            )

    @property
    def three_fold(self) -> bool:
        """Whether the three chains are placed alike, 120 degrees apart."""
        return self.side_shift == 0.0 and self.side_cosine == THREE_FOLD

    @property
    def side_sine(self) -> float:
        """Sine of the azimuth of chain 1, positive; chains 0, 1, 2 run anticlockwise."""
        return side_sine(self.side_cosine)

    @cached_property
    def azimuths(self) -> np.ndarray:
        """(3 chains,) azimuth of each chain about the base z axis, in [0, 2 pi), rad."""
        phi = 2.0 * np.pi / 3.0 if self.side_cosine == THREE_FOLD else math.acos(self.side_cosine)
        return _fixed([0.0, phi, 2.0 * np.pi - phi])

    @cached_property
    def base_radii(self) -> np.ndarray:
        """(3 chains,) R_i, base centre to shoulder axis, m."""
        side = self.base_radius + self.side_shift
        return _fixed([self.base_radius, side, side])

    @cached_property
    def radius_differences(self) -> np.ndarray:
        """(3 chains,) A_i = R_i - r, the only combination of the radii that the kinematics sees, m."""
        return _fixed(self.base_radii - self.platform_radius)

    @property
    def radial(self) -> np.ndarray:
        """(3 chains, 3) unit vector from the base centre to each shoulder."""
        return directions(self.side_cosine)[0]

    @property
    def tangential(self) -> np.ndarray:
        """(3 chains, 3) unit vector along each shoulder axis: z cross radial."""
        return directions(self.side_cosine)[1]


def side_sine(cosine: float) -> float:
    """Computes the sine of an azimuth between 0 and 180 degrees from its cosine."""
    return math.sqrt((1.0 - cosine) * (1.0 + cosine))


@lru_cache(maxsize=256)
def directions(cosine: float) -> tuple[np.ndarray, np.ndarray]:
    """Gives the directions of the chains in the base frame.

    Args:
        cosine: Of the azimuth of chain 1; chain 0 stands on the x axis, chain 2 mirrors chain 1.

    Returns:
        Unit vectors from the base centre to each shoulder and along each shoulder axis, each (3 chains, 3).
    """
    c, s = cosine, side_sine(cosine)
    return (
        _fixed([[1.0, 0.0, 0.0], [c, s, 0.0], [c, -s, 0.0]]),
        _fixed([[0.0, 1.0, 0.0], [-s, c, 0.0], [s, c, 0.0]]),
    )


def _fixed(values: ArrayLike) -> np.ndarray:
    found = np.array(values, dtype=float)
    found.flags.writeable = False
    return found


def azimuth_cosine(azimuth_deg: float) -> float:
    """Computes the cosine of an azimuth, exact at 120 degrees, where the machine is three-fold symmetric.

    Args:
        azimuth_deg: Degrees.
    """
    return THREE_FOLD if azimuth_deg == 120.0 else math.cos(math.radians(azimuth_deg))


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
    q = p @ g.radial.T - g.radius_differences
    t = p @ g.tangential.T
    z = np.broadcast_to(p[..., 2:], q.shape)
    return q, t, z
