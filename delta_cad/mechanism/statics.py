"""Torque, conditioning and the distance to both singularities, README (14)-(18).

In every function `g` is the mechanism and `p` (..., 3) the platform centre in the base frame, m.
Margins, not exceptions: NaN where a chain cannot be closed, infinity at a direct singularity.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from delta_cad.mechanism.geometry import DeltaGeometry
from delta_cad.mechanism.inverse import closure_margin, elbow_arm, forearm_determinant, forearm_vectors
from delta_cad.mechanism.jacobian import forearm_faces, velocity_map


def worst_joint_torque(g: DeltaGeometry, p: ArrayLike, force: float) -> np.ndarray:
    """Computes the largest torque of each shoulder over all directions of a force: row norms of J^T times the force.

    Args:
        g: The mechanism.
        p: (..., 3) platform centre in the base frame, m.
        force: Magnitude of the force on the handle, N.

    Returns:
        (..., 3 chains) N m; infinite at a direct singularity.

    Source:
        [RCIM2018] eqs. (8)-(12) with `torque = J^T force`.
    """
    s = forearm_vectors(g, p)
    arm = g.upper_arm_length * elbow_arm(g, p)
    faces = forearm_faces(s)
    moment = force * arm * np.sqrt((faces * faces).sum(axis=-1))
    det = np.abs(forearm_determinant(s))[..., None]
    return np.where(det == 0.0, np.inf, moment / np.where(det == 0.0, 1.0, det))


def singular_values(g: DeltaGeometry, p: ArrayLike) -> np.ndarray:
    """Computes the singular values of the Jacobian: the semi-axes of the velocity ellipsoid at unit joint rates.

    Returns:
        (..., 3) m/rad, descending; 0 last where a chain is folded, infinity first at a direct singularity.
    """
    s = forearm_vectors(g, p)
    arm = np.asarray(g.upper_arm_length * elbow_arm(g, p))
    closed = np.asarray(np.isfinite(s).all(axis=(-2, -1)))
    folded = np.asarray((arm == 0.0).any(axis=-1))
    # the inverse stays finite at a direct singularity, J stays finite at a fold: take the one that does
    rows = s / np.where(arm == 0.0, 1.0, arm)[..., None]
    inverse_values = np.linalg.svd(np.where(closed[..., None, None], rows, np.eye(3)), compute_uv=False)[..., ::-1]
    zero = inverse_values == 0.0
    values = np.where(zero, np.inf, 1.0 / np.where(zero, 1.0, inverse_values))
    if folded.any():
        forward = velocity_map(g, p)
        finite = np.asarray(np.isfinite(forward).all(axis=(-2, -1), keepdims=True))
        forward_values = np.linalg.svd(np.where(finite, forward, 0.0), compute_uv=False)
        forward_values = np.where(finite[..., 0], forward_values, [np.inf, np.nan, 0.0])  # both singularities at once
        values = np.where(folded[..., None], forward_values, values)
    return np.where(closed[..., None], values, np.nan)


def conditioning(g: DeltaGeometry, p: ArrayLike) -> np.ndarray:
    """Computes the condition number kappa of the Jacobian in the 2-norm.

    Returns:
        (...) kappa >= 1; infinite at both singularities.

    Source:
        [RCIM2018] eqs. (13)-(16); equal for J, J^T and their inverses.
    """
    values = singular_values(g, p)
    smallest = values[..., 2]
    return np.where(smallest == 0.0, np.inf, values[..., 0] / np.where(smallest == 0.0, 1.0, smallest))


def serial_margin(g: DeltaGeometry, p: ArrayLike) -> np.ndarray:
    """Computes each chain's distance to its fold, w / L_B: cosine between forearm and the elbow's direction of motion.

    Returns:
        (..., 3 chains) dimensionless, at most 1; 0 at the fold, and continued below 0 where the chain cannot be
        closed.
    """
    w2 = closure_margin(g, p)
    return np.sign(w2) * np.sqrt(np.abs(w2)) / g.forearm_length


def direct_margin(g: DeltaGeometry, p: ArrayLike) -> np.ndarray:
    """Computes the distance to the direct singularity: determinant of the three unit forearm directions.

    Returns:
        (...) dimensionless in [-1, 1]; 0 where the forearms lie in one plane, positive with the platform above the
        elbows.
    """
    return forearm_determinant(forearm_vectors(g, p)) / g.forearm_length**3
