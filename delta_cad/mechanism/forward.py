"""Shoulder angles to position: the meeting point of three spheres, README (8)-(10)."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from delta_cad.common.units import MM_PER_M
from delta_cad.mechanism.errors import SingularError, UnreachableError
from delta_cad.mechanism.geometry import VERTICAL, DeltaGeometry, chain_coordinates, positions
from delta_cad.mechanism.inverse import OffBranch, masked, require_branch

# Sine between two sides of the centres' triangle below which it is a line: the circumcentre loses its last seven
# digits of sixteen there.
_COLLINEAR = 1e-9
_FLAT = "the forearms lie in one plane with the platform, det S = 0; keep away from there"
_PAST_FOLD = "a chain is past its fold, its elbow inwards: other angles lead to the same position; turn it back"
_BELOW = "the platform would be at z <= 0, at or below the base plane; turn the arms up"


def forward_kinematics(g: DeltaGeometry, theta: ArrayLike, off_branch: OffBranch = "raise") -> np.ndarray:
    """Computes the position of the platform for given shoulder angles, in the machine's own assembly.

    The platform is above the elbows: on the side of their plane from which chains 0, 1, 2 run anticlockwise, so that
    the forearms' determinant is positive. `inverse_kinematics` of the position gives the angles again: elbows outwards
    and not folded, z > 0. `platform_positions` asks none of this.

    Args:
        g: The mechanism.
        theta: (..., 3 chains) shoulder angles, rad.
        off_branch: What becomes of angles off the branch: "raise" refuses all, "nan" makes their positions NaN.

    Returns:
        (..., 3) platform centre in the base frame, m.

    Raises:
        SingularError: The three sphere centres lie on a line, so the position is not determined.
        UnreachableError: The three spheres do not meet.
        BranchError: Some angles are off the branch; the message says which, and why.
        GeometryError: `off_branch` is neither "raise" nor "nan".
    """
    given = positions(theta)
    theta = np.where(np.isfinite(given).all(axis=-1, keepdims=True), given, np.nan)
    p, sine, square = _three_spheres(g, theta)
    q, _, z = chain_coordinates(g, p)
    outwards = (z * np.cos(theta) > q * np.sin(theta)).all(axis=-1)  # w > 0, README (5)
    above, held = p[..., 2] > 0.0, square > 0.0
    on = (sine > _COLLINEAR) & held & outwards & above
    if masked(off_branch):
        return np.where(on[..., None], p, np.nan)
    if on.all():
        return p
    if not (sine > _COLLINEAR).all():
        raise SingularError("the position is not determined: the three elbows, moved in by the platform, are on a line")
    if not (square >= 0.0).all():
        short = g.forearm_length - np.sqrt(g.forearm_length**2 - np.nanmin(square))
        raise UnreachableError(f"the forearms do not meet: they are {-short * MM_PER_M:.3f} mm too short")
    require_branch("shoulder angles theta", _degrees, given, held, _FLAT)
    require_branch("shoulder angles theta", _degrees, given, outwards, _PAST_FOLD)
    require_branch("shoulder angles theta", _degrees, given, above, _BELOW)
    return p


def platform_positions(g: DeltaGeometry, theta: ArrayLike) -> np.ndarray:
    """Computes the forward kinematics for searches: NaN instead of an exception.

    Args:
        g: The mechanism.
        theta: (..., 3 chains) shoulder angles, rad.

    Returns:
        (..., 3) platform centre in the base frame, m, above the elbows; NaN where the spheres do not meet in a point.
    """
    p, sine, _ = _three_spheres(g, positions(theta))
    return np.where((sine > _COLLINEAR)[..., None], p, np.nan)


def _three_spheres(g: DeltaGeometry, theta: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Meeting point (..., 3), sine of the centres' triangle (...), squared height above its plane (...) in m^2."""
    radial = g.radius_differences + g.upper_arm_length * np.cos(theta)
    centres = radial[..., None] * g.radial + (g.upper_arm_length * np.sin(theta))[..., None] * VERTICAL
    b = centres[..., 1, :] - centres[..., 0, :]
    c = centres[..., 2, :] - centres[..., 0, :]
    n = np.cross(b, c)
    b2, c2, n2 = _dot(b, b), _dot(c, c), _dot(n, n)
    sides = b2 * c2
    sine = np.sqrt(n2 / np.where(sides > 0.0, sides, 1.0))
    n2 = np.where(n2 > 0.0, n2, np.nan)
    to_centre = (c2[..., None] * np.cross(n, b) + b2[..., None] * np.cross(c, n)) / (2.0 * n2[..., None])
    square = g.forearm_length**2 - _dot(to_centre, to_centre)
    height = np.sqrt(np.where(square >= 0.0, square, np.nan) / n2)
    return centres[..., 0, :] + to_centre + height[..., None] * n, sine, square


def _dot(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return (a * b).sum(axis=-1)


def _degrees(theta: np.ndarray) -> str:
    return "(" + ", ".join(f"{x:.3f}" for x in np.degrees(theta)) + ") deg"
