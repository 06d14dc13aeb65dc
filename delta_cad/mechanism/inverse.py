"""Position to shoulder angles, vectors and angles of each chain, README (1)-(7), (19)-(20).

In every function `g` is the mechanism and `p` (..., 3) the platform centre in the base frame, m.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from delta_cad.common.units import MM_PER_M
from delta_cad.mechanism import kernel
from delta_cad.mechanism.errors import BranchError, GeometryError, UnreachableError
from delta_cad.mechanism.geometry import VERTICAL, DeltaGeometry, chain_coordinates, positions

OffBranch = Literal["raise", "nan"]
_DOWNWARDS = "z must be > 0: z points from the base to the platform; many public codes have z downwards: negate z"
_FOLDED = "a chain is folded, its elbow neither outwards nor inwards; stay within the edge of reach"
_OTHER_ASSEMBLY = "det S must be > 0: it belongs to another assembly; stay where the platform is above the elbows"


def closure_margin(g: DeltaGeometry, p: ArrayLike) -> np.ndarray:
    """Computes the closure margin w^2 of each chain: the chain closes exactly where it is not negative.

    It is also the serial singularity: the torque arm of the chain is L_A w. Continuous everywhere.

    Returns:
        (..., 3 chains) w^2 in m^2; NaN where the position is NaN.

    Source:
        [RCIM2018] eqs. (6)-(7): h_i = -4 L_A^2 w_i^2. README (3).
    """
    return _closure(g, *chain_coordinates(g, p))[2]


def elbow_arm(g: DeltaGeometry, p: ArrayLike) -> np.ndarray:
    """Computes the forearm's component w along the elbow's direction of motion, the root of the closure margin.

    Returns:
        (..., 3 chains) w in m, elbows outwards so never negative; NaN where the chain cannot be closed.
    """
    w2 = closure_margin(g, p)
    return np.sqrt(np.where(w2 >= 0.0, w2, np.nan))


def arm_direction(g: DeltaGeometry, p: ArrayLike) -> tuple[np.ndarray, np.ndarray]:
    """Computes cosine and sine of the shoulder angles without trigonometry, elbows outwards, README (5).

    Returns:
        cos theta, sin theta: each (..., 3 chains); NaN where the chain cannot be closed.
    """
    q, t, z = chain_coordinates(g, p)
    rho2, m, w2 = _closure(g, q, t, z)
    w = np.sqrt(np.where(w2 >= 0.0, w2, np.nan))
    rho2 = np.where(rho2 > 0.0, rho2, np.nan)  # wrist on the shoulder axis: every angle closes, or none
    return kernel.arm.py_func(q, z, rho2, m, w)


def joint_angles(g: DeltaGeometry, p: ArrayLike) -> np.ndarray:
    """Computes the shoulder angles for searches: NaN instead of an exception where a chain cannot be closed.

    Returns:
        (..., 3 chains) theta in rad, elbows outwards.
    """
    cos, sin = arm_direction(g, p)
    return np.arctan2(sin, cos)


def inverse_kinematics(g: DeltaGeometry, p: ArrayLike, off_branch: OffBranch = "raise") -> np.ndarray:
    """Computes the shoulder angles that hold the platform at a position, in the machine's own assembly.

    That is the branch on which `forward_kinematics` leads back to the position: z > 0, elbows outwards and not folded,
    platform above the elbows (det S > 0). `joint_angles` asks none of this.

    Args:
        g: The mechanism.
        p: (..., 3) platform centre in the base frame, m; z points from the base to the platform.
        off_branch: What becomes of positions off the branch or out of reach: "raise" refuses all positions, "nan"
            makes their angles NaN.

    Returns:
        (..., 3 chains) theta in rad, 0 level, positive towards +z.

    Raises:
        UnreachableError: A chain cannot be closed at one of the positions, or a position is not finite.
        BranchError: One is off the branch; the message says which, and why.
        GeometryError: `off_branch` is neither "raise" nor "nan".

    Source:
        [RCIM2018] eqs. (1)-(5); solved without the half-angle tangent, README (5).
    """
    given = positions(p)
    p = np.where(np.isfinite(given).all(axis=-1, keepdims=True), given, np.nan)
    theta, w2, det = joint_angles(g, p), closure_margin(g, p), forearm_determinant(forearm_vectors(g, p))
    above, outwards, held = p[..., 2] > 0.0, (w2 > 0.0).all(axis=-1), det > 0.0
    on = above & outwards & held
    if masked(off_branch):
        return np.where(on[..., None], theta, np.nan)
    if on.all():
        return theta
    require_branch("position p", _mm, given, ~(p[..., 2] <= 0.0), _DOWNWARDS)
    require_closed(g, given)
    require_branch("position p", _mm, given, outwards, _FOLDED)
    require_branch("position p", _mm, given, held, _OTHER_ASSEMBLY)
    return theta


def masked(off_branch: OffBranch) -> bool:
    """Tells whether results off the branch become NaN, or are refused.

    Raises:
        GeometryError: It is neither "nan" nor "raise".
    """
    if off_branch not in ("raise", "nan"):
        raise GeometryError(f'off_branch is {off_branch!r}; it must be "raise" or "nan"')
    return off_branch == "nan"


def require_branch(
    name: str, shown: Callable[[np.ndarray], str], given: np.ndarray, holds: ArrayLike, rule: str
) -> None:
    """Refuses positions or angles off the branch, by the first of them.

    Args:
        name: What they are.
        shown: Three numbers -> text with unit.
        given: (..., 3) numbers.
        holds: (...) whether each is on the branch.
        rule: What holds on the branch, and what to do.

    Raises:
        BranchError: One is off.
    """
    for index in np.argwhere(~np.asarray(holds)):
        at = f"[{', '.join(map(str, index))}]" if len(index) else ""
        raise BranchError(f"{name}{at} = {shown(given[tuple(index)])}: {rule}")


def require_closed(g: DeltaGeometry, p: ArrayLike) -> None:
    """Refuses positions at which a chain cannot be closed.

    Raises:
        UnreachableError: A chain cannot be closed at one of the positions, or a position is not finite.
    """
    p = positions(p)
    if not np.isfinite(p).all():
        raise UnreachableError(f"position {_mm(p[~np.isfinite(p).all(axis=-1)][0])} is not finite")
    w2 = closure_margin(g, p)
    if (w2 >= 0.0).all():
        return
    *pose, i = np.unravel_index(np.nanargmin(w2), w2.shape)
    excess = reach_excess(g, p)[(*pose, i)] * MM_PER_M
    where = f" at p[{', '.join(map(str, pose))}] = {_mm(p[tuple(pose)])}" if pose else ""
    raise UnreachableError(
        f"chain {i} cannot be closed{where}: its wrist is {excess:.3f} mm out of the forearm's reach"
    )


def reach_excess(g: DeltaGeometry, p: ArrayLike) -> np.ndarray:
    """Computes how far each wrist is out of the forearm's reach from the circle of its elbow, README (4).

    Returns:
        (..., 3 chains) m, positive where the chain cannot be closed (too far or too near), else negative.
    """
    q, t, z = chain_coordinates(g, p)
    rho = np.hypot(q, z)
    near = np.hypot(rho - g.upper_arm_length, t)
    far = np.hypot(rho + g.upper_arm_length, t)
    return np.maximum(near - g.forearm_length, g.forearm_length - far)


def forearm_vectors(g: DeltaGeometry, p: ArrayLike) -> np.ndarray:
    """Computes the vectors s_i from elbow to wrist.

    Returns:
        (..., 3 chains, 3) in the base frame, m, each of length L_B; NaN where the chain cannot be closed.
    """
    q, t, z = chain_coordinates(g, p)
    cos, sin = arm_direction(g, p)
    radial = q - g.upper_arm_length * cos
    vertical = z - g.upper_arm_length * sin
    return radial[..., None] * g.radial + t[..., None] * g.tangential + vertical[..., None] * VERTICAL


def forearm_determinant(s: np.ndarray) -> np.ndarray:
    """Computes the determinant of the three forearm vectors.

    Args:
        s: (..., 3 chains, 3) forearm vectors, m.

    Returns:
        (...) det, m^3; positive with the platform above the elbows.
    """
    (ax, ay, az), (bx, by, bz), (cx, cy, cz) = np.moveaxis(s, (-2, -1), (0, 1))
    return ax * (by * cz - bz * cy) + ay * (bz * cx - bx * cz) + az * (bx * cy - by * cx)


def elbow_positions(g: DeltaGeometry, theta: ArrayLike) -> np.ndarray:
    """Computes the elbows P_i for given shoulder angles.

    Args:
        g: The mechanism.
        theta: (..., 3 chains) shoulder angles, rad.

    Returns:
        (..., 3 chains, 3) in the base frame, m.
    """
    theta = positions(theta)
    radial = g.base_radii + g.upper_arm_length * np.cos(theta)
    vertical = g.upper_arm_length * np.sin(theta)
    return radial[..., None] * g.radial + vertical[..., None] * VERTICAL


def wrist_positions(g: DeltaGeometry, p: ArrayLike) -> np.ndarray:
    """Computes the wrists B_i on the platform.

    Returns:
        (..., 3 chains, 3) in the base frame, m.
    """
    return positions(p)[..., None, :] + g.platform_radius * g.radial


def rod_lean(g: DeltaGeometry, p: ArrayLike) -> np.ndarray:
    """Computes the signed angle of each chain's rods out of the chain's plane, asin(t / L_B).

    The distance of the two rods of a chain falls with the cosine of this angle.

    Returns:
        (..., 3 chains) rad, positive towards +y of the chain; NaN where the chain cannot be closed.
    """
    _, t, _ = chain_coordinates(g, p)
    return np.arcsin(np.where(closure_margin(g, p) >= 0.0, t / g.forearm_length, np.nan))


def forearm_angle(g: DeltaGeometry, p: ArrayLike) -> np.ndarray:
    """Computes the angle between each upper arm (shoulder to elbow) and its forearm (elbow to wrist).

    Returns:
        (..., 3 chains) rad in [0, pi]: 0 stretched, pi folded back; NaN where the chain cannot be closed.
    """
    q, t, z = chain_coordinates(g, p)
    rho2 = q * q + z * z
    a, b = g.upper_arm_length, g.forearm_length
    cosine = (rho2 + t * t - a * a - b * b) / (2.0 * a * b)
    # closed chains have |cosine| <= 1; the clip only takes away the last bit
    return np.arccos(np.where(closure_margin(g, p) >= 0.0, np.clip(cosine, -1.0, 1.0), np.nan))


def _closure(g: DeltaGeometry, q: np.ndarray, t: np.ndarray, z: np.ndarray) -> tuple[np.ndarray, ...]:
    return kernel.chain_closure.py_func(q, t, z, g.upper_arm_length, g.forearm_length)


def _mm(p: np.ndarray) -> str:
    return "(" + ", ".join(f"{x * MM_PER_M:.3f}" for x in p) + ") mm"
