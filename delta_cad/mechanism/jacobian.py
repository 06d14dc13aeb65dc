"""The Jacobian of the mechanism, `v = J theta_dot` and `torque = J^T force`, README (11)-(13).

In every function `g` is the mechanism and `p` (..., 3) the platform centre in the base frame, m.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from delta_cad.mechanism.errors import SingularError
from delta_cad.mechanism.geometry import DeltaGeometry
from delta_cad.mechanism.inverse import elbow_arm, forearm_determinant, forearm_vectors, require_closed

# |det| of the unit forearm directions below which J keeps less than four of its sixteen digits.
_DETERMINANT_MIN = 1e-12


def forearm_faces(s: np.ndarray) -> np.ndarray:
    """Computes s_2 x s_3, s_3 x s_1 and s_1 x s_2 of (..., 3 chains, 3) forearm vectors, as rows, m^2."""
    return np.cross(s[..., [1, 2, 0], :], s[..., [2, 0, 1], :])


def velocity_map(g: DeltaGeometry, p: ArrayLike) -> np.ndarray:
    """Computes the Jacobian for searches: `v = J theta_dot`, without exceptions.

    Returns:
        (..., 3 axes, 3 chains) m/rad; NaN where a chain cannot be closed or where det S is zero.
    """
    s = forearm_vectors(g, p)
    arm = g.upper_arm_length * elbow_arm(g, p)
    det = forearm_determinant(s)
    det = np.where(det == 0.0, np.nan, det)
    return np.swapaxes(forearm_faces(s), -1, -2) * (arm / det[..., None])[..., None, :]


def jacobian(g: DeltaGeometry, p: ArrayLike) -> np.ndarray:
    """Computes the Jacobian J of the mechanism: `v = J theta_dot` and `torque = J^T force`.

    Returns:
        (..., 3 axes, 3 chains) m/rad.

    Raises:
        UnreachableError: A chain cannot be closed at one of the positions.
        SingularError: The three forearms lie in one plane (direct singularity).

    Source:
        [RCIM2018] eqs. (8)-(12); the paper's J maps platform velocity to joint rates and is our inverse.
    """
    require_closed(g, p)
    s = forearm_vectors(g, p)
    # not `<`, so that the undefined forearm of a wrist on its shoulder axis is refused as well
    if not (np.abs(forearm_determinant(s)) > _DETERMINANT_MIN * g.forearm_length**3).all():
        raise SingularError("the platform is not held: the three forearms lie in one plane")
    return velocity_map(g, p)


def inverse_jacobian(g: DeltaGeometry, p: ArrayLike) -> np.ndarray:
    """Computes the inverse Jacobian: `theta_dot = inverse_jacobian v`, defined at direct singularities too.

    Returns:
        (..., 3 chains, 3 axes) rad/m.

    Raises:
        UnreachableError: A chain cannot be closed at one of the positions.
        SingularError: A chain is folded or stretched (serial singularity).
    """
    require_closed(g, p)
    arm = g.upper_arm_length * elbow_arm(g, p)
    if (arm == 0.0).any():
        *_, i = np.argwhere(arm == 0.0)[0]
        raise SingularError(f"chain {i} cannot follow: its upper arm and forearm are in line")
    return forearm_vectors(g, p) / arm[..., None]
