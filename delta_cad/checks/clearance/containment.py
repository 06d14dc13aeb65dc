"""Bodies wholly inside others, which a distance of surfaces does not show."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

import numpy as np

from delta_cad.assembly.tessellation import Mesh

if TYPE_CHECKING:
    from delta_cad.checks.clearance.pairing import HeldApart
    from delta_cad.checks.clearance.sampled import Sampler


def winding_number(mesh: Mesh, point: np.ndarray) -> float:
    """How often a closed mesh winds around a point: 1 inside, 0 outside.

    Args:
        mesh: A watertight mesh.
        point: (3,) a point off its surface, in the mesh's frame, mm.

    Returns:
        Sum of the signed solid angles of the triangles over 4 pi.

    Source:
        Van Oosterom and Strackee, "The solid angle of a plane triangle", IEEE Trans. Biomed. Eng. 30 (1983).
    """
    a, b, c = np.moveaxis(mesh.triangles - point, 1, 0)
    la, lb, lc = (np.linalg.norm(v, axis=1) for v in (a, b, c))
    triple = (a * np.cross(b, c)).sum(axis=1)
    below = la * lb * lc + (a * b).sum(axis=1) * lc + (b * c).sum(axis=1) * la + (c * a).sum(axis=1) * lb
    return float(np.arctan2(triple, below).sum() / (2.0 * np.pi))


def contained(pairs: Iterable[HeldApart], sampler: Sampler) -> list[HeldApart]:
    """The pairs of which one body holds the other, at the sampler's first position.

    One position is enough: a body cannot get in or out while the distance of the surfaces is proven positive.

    Args:
        pairs: The pairs.
        sampler: The placed links.

    Returns:
        The pairs with a body inside the other.
    """
    return [pair for pair in pairs if _holds(pair, sampler)]


def _holds(pair: HeldApart, sampler: Sampler) -> bool:
    if np.linalg.norm(sampler.middle(pair.a, 0) - sampler.middle(pair.b, 0)) > max(pair.a.radius, pair.b.radius):
        return False  # the smaller one's centre is outside the larger one's sphere
    frame_a, frame_b = sampler.frames[pair.a.link][0], sampler.frames[pair.b.link][0]
    return holds(pair.a.mesh, pair.b.mesh, frame_a @ pair.a.placement, frame_b @ pair.b.placement)


def holds(a: Mesh, b: Mesh, pose_a: np.ndarray, pose_b: np.ndarray) -> bool:
    """Whether one of two meshes whose surfaces do not meet lies inside the other.

    Args:
        a: One mesh, watertight.
        b: The other, watertight.
        pose_a: (4, 4) frame of a in a common frame, mm.
        pose_b: (4, 4) frame of b in the same frame, mm.

    Returns:
        True if a vertex of one is inside the other.
    """
    for outer, inner, there in (
        (a, b, np.linalg.inv(pose_a) @ pose_b),
        (b, a, np.linalg.inv(pose_b) @ pose_a),
    ):
        point = there[:3, :3] @ inner.vertices[0] + there[:3, 3]
        near = (outer.vertices.min(axis=0) <= point).all() and (point <= outer.vertices.max(axis=0)).all()
        if near and winding_number(outer, point) > 0.5:
            return True
    return False
