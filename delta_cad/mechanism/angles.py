"""Angles that the joints must allow: lean of the rods and the angle at the elbow, README (19)-(20)."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from delta_cad.mechanism.geometry import DeltaGeometry, chain_coordinates
from delta_cad.mechanism.inverse import closure_margin


def rod_lean(g: DeltaGeometry, p: ArrayLike) -> np.ndarray:
    """Signed angle of each chain's rods out of the chain's plane, asin(t / L_B).

    The distance of the two rods of a chain falls with the cosine of this angle.

    Args:
        g: The mechanism.
        p: (..., 3) platform centre in the base frame, m.

    Returns:
        (..., 3 chains) rad, positive towards +y of the chain; NaN where the chain cannot be closed.
    """
    _, t, _ = chain_coordinates(g, p)
    return np.arcsin(np.where(closure_margin(g, p) >= 0.0, t / g.forearm_length, np.nan))


def forearm_angle(g: DeltaGeometry, p: ArrayLike) -> np.ndarray:
    """Angle between each upper arm (shoulder to elbow) and its forearm (elbow to wrist).

    Args:
        g: The mechanism.
        p: (..., 3) platform centre in the base frame, m.

    Returns:
        (..., 3 chains) rad in [0, pi]: 0 stretched, pi folded back; NaN where the chain cannot be closed.
    """
    q, t, z = chain_coordinates(g, p)
    rho2 = q * q + z * z
    a, b = g.upper_arm_length, g.forearm_length
    cosine = (rho2 + t * t - a * a - b * b) / (2.0 * a * b)
    # closed chains have |cosine| <= 1; the clip only takes away the last bit
    return np.arccos(np.where(closure_margin(g, p) >= 0.0, np.clip(cosine, -1.0, 1.0), np.nan))
