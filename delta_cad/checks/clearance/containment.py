"""Bodies completely inside others, which a distance between surfaces does not detect."""

from __future__ import annotations

import numpy as np

from delta_cad.assembly.tessellation import Mesh


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
