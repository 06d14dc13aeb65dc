"""Long bodies cut into segments across their length, so that what is near a joint is not taken to move like the rest.

A rotation by a small angle about a joint's centre moves a point by the angle times its distance from there. The
triangles of a tube reach over its whole length, so they are cut at planes; together the segments are the same surface,
and the distance to the body is the smallest distance to a segment. A point of the exact surface counts with the segment
that is within the mesh's deviation of it, which is what the segments keep as their own deviation.
"""

from __future__ import annotations

import numpy as np

from delta_cad.assembly.tessellation import Mesh
from delta_cad.checks.clearance.bodies import CollisionBody, body

_GROWTH = (
    1.4  # a segment ends that many times as far from the joint as it begins: the lever is at most that much too long
)


def segments_of(b: CollisionBody, centre_x_mm: float) -> list[CollisionBody]:
    """The segments of a body along the x axis of its link, seen from a joint's centre on that axis.

    Args:
        b: The body.
        centre_x_mm: x of the joint's centre in the link's frame, mm.

    Returns:
        Bodies of the same name; the body itself where it is short or thick. Nearer to the joint than its own thickness
        a body is not cut: there the thickness decides how far its points move.
    """
    points = b.vertices
    x = points[:, 0] - centre_x_mm
    thick = float(np.hypot(points[:, 1], points[:, 2]).max())
    sides = []
    for sign in (-1.0, 1.0):
        far = (sign * x).max()
        near = max((sign * x).min(), thick)
        first = [near] if (sign * x).min() < near else []
        count = int(np.ceil(np.log(far / near) / np.log(_GROWTH))) if far > near else 0
        inner = near * (far / near) ** (np.arange(1, count) / count) if count else np.zeros(0)
        sides += [sign * level for level in (*first, *inner) if level < far]
    if not sides:
        return [b]
    frame = b.placement
    plane = frame[0, :3]  # x of the link from the coordinates of the part
    levels = np.sort(sides) + centre_x_mm - frame[0, 3]
    return [
        body(b.name, f"{b.key} piece {k} of {len(levels) + 1} about {centre_x_mm:g}", b.link, mesh, frame)
        for k, mesh in enumerate(cut(b.mesh, plane, levels))
    ]


def near(
    b: CollisionBody, point_mm: np.ndarray, reach_mm: float, axes: np.ndarray | None = None
) -> CollisionBody | None:
    """What of a body can be closer than a reach to a point: all of its surface in the cube around the point.

    Args:
        b: The body.
        point_mm: (3,) the point in the link's frame, mm.
        reach_mm: Half the side of the cube, mm.
        axes: (3, 3) columns: the cube's directions in the link's frame; without them those of the part.

    Returns:
        A body of the same name; the body itself if the cube is larger, None where nothing is within reach.
    """
    if np.linalg.norm(b.centre - point_mm) > b.radius + reach_mm:
        return None
    if reach_mm >= b.radius:
        return b
    place = b.placement
    middle = place[:3, :3].T @ (point_mm - place[:3, 3])
    triangles = b.mesh.triangles - middle
    normals = np.eye(3) if axes is None else axes.T @ place[:3, :3]
    for normal in (*normals, *-normals):
        triangles = above(triangles, normal, -reach_mm)
    if not len(triangles):
        return None
    mesh = _soup(triangles + middle, b.mesh.deviation_mm)
    place_of = np.round(point_mm, 6).tolist()
    turn = np.round(place, 6).tolist()
    faces = np.round(normals, 6).tolist()
    return body(b.name, f"{b.key} at {turn} within {reach_mm:.6f} of {place_of} square to {faces}", b.link, mesh, place)


def cells_of(b: CollisionBody, halvings: int) -> list[CollisionBody]:
    """The pieces of a body that is halved again and again across the longest side of its bounding box.

    A hollow body's convex hull is full; the hulls of its pieces leave the hollow free.

    Args:
        b: The body.
        halvings: How many times.

    Returns:
        Bodies of the same name, `2^halvings` of them or fewer where a piece is empty.
    """
    cells = [b.mesh.triangles]
    for _ in range(halvings):
        halves = []
        for triangles in cells:
            low, high = triangles.min(axis=(0, 1)), triangles.max(axis=(0, 1))
            normal = np.eye(3)[np.argmax(high - low)]
            level = float(normal @ (low + high)) / 2.0
            halves += [above(triangles, -normal, -level), above(triangles, normal, level)]
        cells = [half for half in halves if len(half)]
    return [
        body(b.name, f"{b.key} cell {k} of {len(cells)}", b.link, _soup(t, b.mesh.deviation_mm), b.placement)
        for k, t in enumerate(cells)
    ]


def cut(mesh: Mesh, normal: np.ndarray, levels: np.ndarray) -> list[Mesh]:
    """A mesh's surface cut at parallel planes.

    Args:
        mesh: The mesh.
        normal: (3,) unit normal of the planes in the mesh's frame.
        levels: (k,) heights of the planes along the normal, ascending, mm.

    Returns:
        The meshes, open at the cuts, of those of the k + 1 slabs that hold any of the surface.
    """
    segments, rest = [], mesh.triangles
    for level in levels:
        segments.append(above(rest, -normal, -level))
        rest = above(rest, normal, level)
    return [_soup(t, mesh.deviation_mm) for t in (*segments, rest) if len(t)]


def above(triangles: np.ndarray, normal: np.ndarray, level: float) -> np.ndarray:
    """Triangles clipped by a plane.

    Args:
        triangles: (m, 3, 3) corner points, mm.
        normal: (3,) unit normal of the plane.
        level: Height of the plane along the normal, mm.

    Returns:
        (n, 3, 3) triangles that fill what has `normal . p >= level`; those in the plane itself are kept.
    """
    height = triangles @ normal - level
    is_above = (height >= 0.0).all(axis=1)
    if is_above.all():
        return triangles
    parts, up = [triangles[is_above]], (height > 0.0).sum(axis=1)
    for count in (1, 2):  # corners above the plane; the corner that is alone on its side comes first
        split = np.flatnonzero(~is_above & (up == count))[:, None]
        if not len(split):
            continue
        alone = ((height[split[:, 0]] > 0.0) if count == 1 else (height[split[:, 0]] <= 0.0)).argmax(axis=1)
        order = (alone[:, None] + np.arange(3)) % 3
        t, h = triangles[split, order], height[split, order]
        share = (h[:, :1] / (h[:, :1] - h[:, 1:]))[..., None]
        b, c = np.moveaxis(t[:, :1] + share * (t[:, 1:] - t[:, :1]), 1, 0)
        if count == 1:
            parts.append(np.stack([t[:, 0], b, c], axis=1))
        else:
            parts += [np.stack([b, t[:, 1], t[:, 2]], axis=1), np.stack([b, t[:, 2], c], axis=1)]
    return np.concatenate(parts)


def _soup(triangles: np.ndarray, deviation_mm: float) -> Mesh:
    """A mesh of triangles that share no vertices."""
    return Mesh(triangles.reshape(-1, 3), np.arange(3 * len(triangles)).reshape(-1, 3), deviation_mm)
