"""Reachable workspace: its exact contours in a section, and its shell, README (4) of the mechanism.

A chain's limit is where its upper arm and forearm lie in one line, `h_i = 0`: with the forearm at the angle beta from
the plane of the upper arm, `rho = L_A + L_B cos beta` and `t = L_B sin beta`, where rho < 0 is the fold. So every
contour has a closed form in beta; what of it the other chains do not reach is cut away, to the last bit.
Source: [RCIM2018] eqs. (6)-(7) and figures 5 and 6.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from delta_cad.mechanism import DeltaGeometry, closure_margin

_SAMPLES = 720  # along one chain's contour: at 0.5 degrees a polyline of 200 mm radius is 2 um off the curve
_BISECTIONS = 60  # halvings to an end of a contour: more than a double can resolve
_RAYS = 241
_RADIAL_SCAN = 400  # points along a ray, from outside inwards, before its end is bisected
HEIGHTS = 49

# (K,) beta -> (K, 3) points, and (K,) margin that is negative where the contour is not there.
_Contour = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]


def contours_at_height(g: DeltaGeometry, z: float) -> list[np.ndarray]:
    """Computes the workspace's boundary in a horizontal plane.

    Args:
        g: The mechanism.
        z: Height of the plane over the base plane, m; > 0.

    Returns:
        Pieces of the boundary, each (K, 3) points of one chain's limit, m.
    """
    arcs = []
    for chain in range(3):
        for sign in (-1.0, 1.0):
            arcs += _arcs(_horizontal(g, chain, sign, z))
    return arcs


def contours_in_mirror_plane(g: DeltaGeometry) -> list[np.ndarray]:
    """Computes the workspace's boundary above the base plane in the plane y = 0, in which chain 0 moves.

    Returns:
        Pieces of the boundary, each (K, 3) points, m; chain 2's are chain 1's.
    """
    arcs = [arc for reach in _own_reaches(g) for arc in _arcs(_circle(g, reach))]
    return arcs + _arcs(_mirrored(g))


class _Shell(NamedTuple):
    """The boundary of the workspace above the base plane as two heights over a fan of rays.

    Attributes:
        x: (rays, K) m.
        y: (rays, K) m.
        top: (rays, K) largest z that all chains reach, m.
        bottom: (rays, K) the fold above which all chains come, m; 0 where there is none.
    """

    x: np.ndarray
    y: np.ndarray
    top: np.ndarray
    bottom: np.ndarray


def shell(g: DeltaGeometry, rays: int = _RAYS, heights: int = HEIGHTS) -> _Shell:
    """Computes the boundary of the workspace over the base plane.

    Args:
        g: The mechanism.
        rays: Directions from the axis.
        heights: Points along each.

    Returns:
        The shell; top and bottom meet at the ends of the rays.
    """
    azimuth = np.linspace(0.0, 2.0 * np.pi, rays)
    direction = np.stack([np.cos(azimuth), np.sin(azimuth)], axis=-1)
    farthest = g.upper_arm_length + g.forearm_length + float(np.abs(g.radius_differences).max())

    def open_at(radius: np.ndarray) -> np.ndarray:
        top2, bottom2 = _squares(g, direction * radius[:, None])
        return top2 - bottom2

    scan = np.linspace(farthest, 0.0, _RADIAL_SCAN)
    inside = np.stack([open_at(np.full(rays, radius)) > 0.0 for radius in scan])
    first = inside.argmax(axis=0)  # 0 where nothing is: outside the farthest reach
    low, high = scan[first], scan[np.maximum(first - 1, 0)]
    for _ in range(_BISECTIONS):
        middle = (low + high) / 2.0
        good = open_at(middle) > 0.0
        low, high = np.where(good, middle, low), np.where(good, high, middle)
    # denser to the rim, where top and bottom are steep
    share = np.sin(np.linspace(0.0, np.pi / 2.0, heights))
    p = direction[:, None, :] * (low[:, None] * share)[..., None]
    top2, bottom2 = _squares(g, p)
    return _Shell(p[..., 0], p[..., 1], np.sqrt(np.maximum(top2, 0.0)), np.sqrt(np.maximum(bottom2, 0.0)))


def _squares(g: DeltaGeometry, p: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Computes (...) squares of the extreme heights over (..., 2) points; the largest is negative outside."""
    q = p @ g.radial[:, :2].T - g.radius_differences
    t = p @ g.tangential[:, :2].T
    s2 = g.forearm_length**2 - t * t
    s = np.sqrt(np.maximum(s2, 0.0))
    top2 = np.where(s2 >= 0.0, (g.upper_arm_length + s) ** 2 - q * q, s2).min(axis=-1)
    bottom2 = np.maximum((g.upper_arm_length - s) ** 2 - q * q, 0.0).max(axis=-1)
    return top2, bottom2


def _horizontal(g: DeltaGeometry, chain: int, sign: float, z: float) -> _Contour:
    others = [i for i in range(3) if i != chain]

    def contour(beta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        rho, t = _limit(g, beta)
        q2 = rho * rho - z * z
        u = sign * np.sqrt(np.maximum(q2, 0.0)) + g.base_radii[chain] - g.platform_radius
        p = u[:, None] * g.radial[chain] + t[:, None] * g.tangential[chain] + [0.0, 0.0, z]
        return p, np.minimum(q2, closure_margin(g, p)[:, others].min(axis=-1))

    return contour


def _own_reaches(g: DeltaGeometry) -> tuple[float, float]:
    """Computes the radii of chain 0's circles in the mirror plane: stretched and folded."""
    return g.upper_arm_length + g.forearm_length, abs(g.forearm_length - g.upper_arm_length)


def _circle(g: DeltaGeometry, radius: float) -> _Contour:
    """Makes the contour of chain 0 in the mirror plane, about its shoulder; beta is its angle there."""

    def contour(beta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        x = radius * np.cos(beta) + g.base_radius - g.platform_radius
        p = np.stack([x, np.zeros_like(x), radius * np.sin(beta)], axis=-1)
        return p, np.minimum(p[:, 2] * radius, closure_margin(g, p)[:, 1:].min(axis=-1))

    return contour


def _mirrored(g: DeltaGeometry) -> _Contour:
    """Makes the contour of chains 1 and 2 in the mirror plane, where they are each other's image."""

    def contour(beta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        rho, t = _limit(g, beta)
        x = t / g.tangential[1, 0]
        q = x * g.radial[1, 0] - g.radius_differences[1]
        z2 = rho * rho - q * q
        p = np.stack([x, np.zeros_like(x), np.sqrt(np.maximum(z2, 0.0))], axis=-1)
        return p, np.minimum(z2, closure_margin(g, p)[:, 0])

    return contour


def _limit(g: DeltaGeometry, beta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return g.upper_arm_length + g.forearm_length * np.cos(beta), g.forearm_length * np.sin(beta)


def _arcs(contour: _Contour) -> list[np.ndarray]:
    """Finds the parts of a closed contour whose margin is not negative, their ends bisected."""
    beta = np.linspace(0.0, 2.0 * np.pi, _SAMPLES, endpoint=False)
    there = contour(beta)[1] >= 0.0
    if not there.any():
        return []
    if not there.all():  # begin where it is not, so that no piece lies across the seam
        beta = np.roll(beta, -int(np.argmin(there)))
        there = np.roll(there, -int(np.argmin(there)))
        beta = np.where(beta < beta[0], beta + 2.0 * np.pi, beta)
    beta, there = np.append(beta, beta[0] + 2.0 * np.pi), np.append(there, there[0])
    change = np.flatnonzero(np.diff(there.astype(int)))
    ends = _ends(
        contour,
        np.where(there[change], beta[change], beta[change + 1]),
        np.where(there[change], beta[change + 1], beta[change]),
    )
    if there.all():
        return [contour(beta)[0]]
    arcs = []
    for first, last, begin, end in zip(change[0::2], change[1::2], ends[0::2], ends[1::2], strict=True):
        arcs.append(contour(np.concatenate([[begin], beta[first + 1 : last + 1], [end]]))[0])
    return arcs


def _ends(contour: _Contour, inside: np.ndarray, outside: np.ndarray) -> np.ndarray:
    """Finds where a contour ends, between parameters at which it is there and at which it is not."""
    for _ in range(_BISECTIONS):
        middle = (inside + outside) / 2.0
        there = contour(middle)[1] >= 0.0 if len(middle) else np.zeros(0, dtype=bool)
        inside, outside = np.where(there, middle, inside), np.where(there, outside, middle)
    return inside
