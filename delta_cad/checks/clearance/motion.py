r"""Rigorous closed-form bounds on the motion of the links while the handle stays in a box.

Chain i, lengths in mm: `q, t, z` of the wrist seen from the shoulder,
`m = (q^2 + t^2 + z^2 + L_A^2 - L_B^2) / (2 L_A)`, `w = sqrt(q^2 + z^2 - m^2)`; s is the forearm from elbow to wrist,
|s| = L_B, and e the elbow's direction of motion.
From `s . dp = s . e L_A dtheta` and `w = s . e` follow, for any path inside the box,

1. `dtheta/dp = s / (L_A w)`, so `|dtheta| <= L_B |dp| / (L_A w)`.
2. `ds = (1 - e s^T / w) dp`; an oblique projector and its complement have one norm, so `|ds| <= (L_B / w) |dp|`.
3. The rod's direction a = s / L_B turns by at most `|dp| / w`. The rod's frame also spins about a, by `tan(lean)` times
   the component of da square to the shoulder axis: its whole rotation is at most `|dp| / (w cos(lean))`.
4. The angle of s in the chain's plane changes by at most `|dp| / (w cos(lean))`, the lean by `asin(t / L_B)` exactly.
5. The angle phi from the upper arm to s has `cos phi = (m - L_A) / sqrt(L_B^2 - t^2)`, so the ranges of m and t over
   the box give its range without any w; near a fold, where w is small, this is the better bound.

The smallest w of a box: `w^2` has the exact gradient `g = 2 (q, z) - 2 m grad m` at the centre and a Hessian whose norm
is at most `2 + 2 |grad m|^2 + 2 |m| / L_A`, with `|grad m| = |(q, t, z)| / L_A`, hence
`w^2 >= w_c^2 - sum |g_k| h_k - (1/2) (2 + 2 G^2 + 2 M / L_A) |h|^2`, G and M their largest values over the box.
Rounding of doubles is below 1e-10 mm here and is covered by the guard of the proof that uses these bounds.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from delta_cad.common.units import MM_PER_M
from delta_cad.mechanism.geometry import VERTICAL, DeltaGeometry


@dataclass(frozen=True)
class BoxMotion:
    """Bounds over n boxes of handle positions, per chain; distances from the box's centre, not its diameter.

    Attributes:
        theta: (n, 3) shoulder angles at the centres, rad.
        theta_change: (n, 3) bound on their change, rad; infinite where the chain might fold inside the box.
        forearm: (n, 3) bound on the change of the vector s, mm.
        turn: (n, 3) bound on the rod's change of direction, rad.
        rotation: (n, 3) bound on the rotation of the rod's whole frame and on the change of the angle of s in
            the chain's plane, rad.
        elbow_angle: (n, 3) angle from the upper arm to s in the chain's plane at the centres, in (0, pi), rad;
            with theta added it is measured from the radial direction towards +z.
        elbow_low, elbow_high: (n, 3) range of that angle from the upper arm over the box, by 4 and 5, rad.
        lean: (n, 3) signed lean at the centres, rad.
        lean_low, lean_high: (n, 3) exact range of the lean over the box, rad.
    """

    theta: np.ndarray
    theta_change: np.ndarray
    forearm: np.ndarray
    turn: np.ndarray
    rotation: np.ndarray
    elbow_angle: np.ndarray
    elbow_low: np.ndarray
    elbow_high: np.ndarray
    lean: np.ndarray
    lean_low: np.ndarray
    lean_high: np.ndarray


def box_motion(g: DeltaGeometry, centres_mm: np.ndarray, halves_mm: np.ndarray) -> BoxMotion:
    """Bounds on the motion of the links over boxes of handle positions.

    Args:
        g: The mechanism.
        centres_mm: (n, 3) centres of the boxes, base frame, mm; all reachable.
        halves_mm: (n, 3) half sides of the boxes, mm.

    Returns:
        The bounds; infinite where the box might hold an unreachable point.
    """
    arm, forearm = g.upper_arm_length * MM_PER_M, g.forearm_length * MM_PER_M
    radial, tangential = g.radial, g.tangential
    q = centres_mm @ radial.T - g.radius_differences * MM_PER_M
    t = centres_mm @ tangential.T
    z = np.broadcast_to(centres_mm[:, 2:], q.shape)
    reach = np.linalg.norm(halves_mm, axis=1)[:, None]
    wrist = np.sqrt(q**2 + t**2 + z**2)
    rho2 = q**2 + z**2
    m = (wrist**2 + arm**2 - forearm**2) / (2.0 * arm)
    w2 = rho2 - m**2
    spread_t = halves_mm @ np.abs(tangential).T
    lean = np.arcsin(np.clip(t / forearm, -1.0, 1.0))
    lean_low = np.arcsin(np.clip((t - spread_t) / forearm, -1.0, 1.0))
    lean_high = np.arcsin(np.clip((t + spread_t) / forearm, -1.0, 1.0))
    cos_lean = np.cos(np.maximum(np.abs(lean_low), np.abs(lean_high)))

    gradient = 2.0 * (q[..., None] * radial + z[..., None] * VERTICAL) - (2.0 * m / arm)[..., None] * (
        q[..., None] * radial + t[..., None] * tangential + z[..., None] * VERTICAL
    )
    slope = (wrist + reach) / arm
    curvature = 2.0 + 2.0 * slope**2 + 2.0 * (np.abs(m) + slope * reach) / arm
    w2_low = w2 - (np.abs(gradient) @ halves_mm[..., None])[..., 0] - 0.5 * curvature * reach**2
    with np.errstate(divide="ignore"):
        inverse = 1.0 / np.sqrt(np.maximum(w2_low, 0.0))  # infinite where the box might hold a fold
        turn = reach * inverse
        rotation = turn / cos_lean
    w = np.sqrt(np.maximum(w2, 0.0))
    theta = np.arctan2(z * m - q * w, q * m + z * w)
    s_radial, s_vertical = q - arm * np.cos(theta), z - arm * np.sin(theta)

    s = s_radial[..., None] * radial + t[..., None] * tangential + s_vertical[..., None] * VERTICAL
    change = forearm * turn[..., None]
    with np.errstate(invalid="ignore"):
        directed = ((np.abs(s) + change) @ halves_mm[..., None])[..., 0] * inverse / arm
    theta_change = np.minimum(forearm * turn / arm, np.where(np.isfinite(turn), directed, np.inf))
    elbow = np.arctan2(w, m - arm)
    with np.errstate(invalid="ignore"):
        elbow_low, elbow_high = elbow - rotation - theta_change, elbow + rotation + theta_change
    low, high = _elbow_range(g, (q, t, z), halves_mm)
    elbow_low, elbow_high = np.fmax(low, elbow_low), np.fmin(high, elbow_high)
    return BoxMotion(
        theta=theta,
        theta_change=theta_change,
        forearm=forearm * turn,
        turn=turn,
        rotation=rotation,
        elbow_angle=elbow,
        elbow_low=elbow_low,
        elbow_high=elbow_high,
        lean=lean,
        lean_low=lean_low,
        lean_high=lean_high,
    )


def _elbow_range(
    g: DeltaGeometry, wrist: tuple[np.ndarray, np.ndarray, np.ndarray], halves_mm: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """(n, 3) lowest and highest angle from the upper arm to s in the chain's plane, from the ranges of m and t."""
    arm, forearm = g.upper_arm_length * MM_PER_M, g.forearm_length * MM_PER_M
    lowest, highest = np.zeros_like(wrist[0]), np.zeros_like(wrist[0])
    reach: list[np.ndarray] = []
    for k, (value, direction) in enumerate(
        zip(wrist, (g.radial, g.tangential, VERTICAL * np.ones((3, 1))), strict=True)
    ):
        spread = halves_mm @ np.abs(direction).T
        near, far = np.maximum(np.abs(value) - spread, 0.0), np.abs(value) + spread
        lowest, highest = lowest + near**2, highest + far**2
        if k == 1:  # along the shoulder axis
            reach = [np.sqrt(np.maximum(forearm**2 - x**2, 1e-12)) for x in (far, near)]  # smallest, largest
    along = [(x + arm**2 - forearm**2) / (2.0 * arm) - arm for x in (lowest, highest)]
    cosines = [np.where(a < 0.0, a / reach[k], a / reach[1 - k]) for k, a in enumerate(along)]
    return np.arccos(np.clip(cosines[1], -1.0, 1.0)), np.arccos(np.clip(cosines[0], -1.0, 1.0))


def cube_boxes(centre_mm: np.ndarray, half_side_mm: float, count: int) -> tuple[np.ndarray, np.ndarray]:
    """The cube cut into equal boxes.

    Args:
        centre_mm: (3,) centre of the cube, mm.
        half_side_mm: Half its side, mm.
        count: Boxes along each edge.

    Returns:
        (count^3, 3) centres and (count^3, 3) half sides, mm.
    """
    half = half_side_mm / count
    axis = half * (2.0 * np.arange(count) + 1.0) - half_side_mm
    centres = np.stack(np.meshgrid(axis, axis, axis, indexing="ij"), axis=-1).reshape(-1, 3) + centre_mm
    return centres, np.full_like(centres, half)
