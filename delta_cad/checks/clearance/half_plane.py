"""Profiles of bodies in the half plane through an axis: a lower bound of their distance, valid at every angle about it.

A rotation about the y axis keeps the radius `rho` and the height `y` of a point. Points at `(rho_a, phi_a, y_a)` and
`(rho_b, phi_b, y_b)` have the squared distance

    rho_a^2 + rho_b^2 - 2 rho_a rho_b cos(phi_a - phi_b) + (y_a - y_b)^2 >= (rho_a - rho_b)^2 + (y_a - y_b)^2,

so two bodies that turn about that axis in any way are never closer than their profiles, the sets of their `(rho, y)`.
The profile of a triangle lies in the rectangle of its ranges: y and the largest rho are extreme at a corner (rho is
convex), the smallest rho is 0 or on a side of the triangle projected along the axis. Planes square to the axis and
cylinders around it have rectangles without area, so the bound is the distance itself for the gaps that stay constant.
The exact surfaces are within the deviations of the meshes, so their distance is smaller by at most both deviations.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np

from delta_cad.assembly.tessellation import Mesh

CHUNK = 2_000_000  # pairs of rectangles held at once: 50 MB


class HalfPlaneProfile:
    """The profile of a placed mesh about the y axis, as rectangles.

    Args:
        mesh: The mesh.
        frame: (4, 4) frame of the mesh in a frame whose y axis is the axis, mm.
    """

    def __init__(self, mesh: Mesh, frame: np.ndarray) -> None:
        self._points = mesh.vertices @ frame[:3, :3].T + frame[:3, 3]
        self._faces = mesh.faces

    @cached_property
    def bounds(self) -> np.ndarray:
        """(4,) lowest and highest radius (0 counts as the lowest), lowest and highest y of the mesh, mm."""
        x, y, z = self._points.T
        return np.array([0.0, np.hypot(x, z).max(), y.min(), y.max()])

    @cached_property
    def rectangles(self) -> np.ndarray:
        """(n, 4) lowest and highest radius, lowest and highest y of every triangle, equal ones once, mm."""
        corners = self._points[self._faces]
        flat, y = corners[:, :, [0, 2]], corners[:, :, 1]
        side = np.roll(flat, -1, axis=1) - flat
        along = -(flat * side).sum(axis=2) / np.maximum((side**2).sum(axis=2), 1e-300)
        foot = flat + np.clip(along, 0.0, 1.0)[..., None] * side
        low = np.linalg.norm(foot, axis=2).min(axis=1)
        turn = flat[..., 0] * side[..., 1] - flat[..., 1] * side[..., 0]  # the origin seen from each side
        holds = (turn >= 0.0).all(axis=1) | (turn <= 0.0).all(axis=1)
        high = np.linalg.norm(flat, axis=2).max(axis=1)
        rectangles = np.stack([np.where(holds, 0.0, low), high, y.min(axis=1), y.max(axis=1)], axis=1)
        return np.unique(rectangles, axis=0)


def profile_gap(a: HalfPlaneProfile, b: HalfPlaneProfile) -> float:
    """Least distance of two profiles: the meshes are at least that far apart at every angle about the axis, mm."""
    one, other = a.rectangles, b.rectangles
    for _ in range(2):  # what is farther from the other's bounds than a pair that exists cannot be the closest
        far_one, far_other = rectangles_gap(one, _hull(other)), rectangles_gap(other, _hull(one))
        least = min(
            rectangles_gap(other, one[far_one.argmin()]).min(), rectangles_gap(one, other[far_other.argmin()]).min()
        )
        one, other = one[far_one <= least], other[far_other <= least]
    step = max(CHUNK // len(other), 1)
    return float(min(rectangles_gap(one[k : k + step, None], other[None]).min() for k in range(0, len(one), step)))


def rectangles_gap(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """(...) distances of rectangles (..., 4) given as lowest and highest of two coordinates; 0 where they overlap."""
    x = np.maximum(b[..., 0] - a[..., 1], a[..., 0] - b[..., 1])
    y = np.maximum(b[..., 2] - a[..., 3], a[..., 2] - b[..., 3])
    return np.hypot(np.maximum(x, 0.0), np.maximum(y, 0.0))


def _hull(rectangles: np.ndarray) -> np.ndarray:
    """(4,) the rectangle that holds all."""
    low, high = rectangles.min(axis=0), rectangles.max(axis=0)
    return np.array([low[0], high[1], low[2], high[3]])
