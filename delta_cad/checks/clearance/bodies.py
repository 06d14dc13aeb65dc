"""Occurrences as bodies for distance queries: mesh, bounding boxes and levers, in the frame of their link."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np

from delta_cad.assembly.tessellation import Mesh, Meshes
from delta_cad.checks.links import turn_about_x
from delta_cad.mechanism.placement import SpringSway
from delta_cad.solids.part import Occurrence

_REVOLUTION_SIDES = 48  # circumscribed polygon: 0.2 % of the radius too large, never too small
_REVOLUTION_SLABS = 64  # more edges along an axis than any pinion has
_LEVEL_MM = 2e-6  # levels are rounded to 1e-6 mm
ROUND = 0.97  # least by most reach off an axis: 0.985 for the 18 facets of a tube, 0.5 for a socket's ring
_ROUND_DIRECTIONS = 36  # in which the reach off an axis is compared: every 10 degrees
_TURN_STEPS = 12  # a step of 5 degrees: 0.1 % of the radius too large
_TREES: WeakKeyDictionary[Mesh, Any] = WeakKeyDictionary()  # FCL's bounding volumes of each mesh that lives
_X_TO_Y = np.eye(4)[[2, 0, 1, 3]]  # rotation that takes the x axis to the y axis


@dataclass(frozen=True, eq=False)
class CollisionBody:
    """A placed mesh.

    Attributes:
        name: Occurrence name.
        key: What makes two bodies the same shape: part number, with a mark for a body of revolution.
        link: Link that carries it.
        mesh: The mesh in the part's frame.
        placement: (4, 4) part frame to link frame, mm.
        centre: (3,) centre of the bounding box in the link's frame, mm.
        axes: (3, 3) columns: directions of the bounding box in the link's frame.
        half: (3,) half sides of the bounding box, mm, the mesh's deviation included.
        radius: Radius about `centre` that holds the exact surface, mm.
    """

    name: str
    key: str
    link: str
    mesh: Mesh
    placement: np.ndarray
    centre: np.ndarray
    axes: np.ndarray
    half: np.ndarray
    radius: float

    @property
    def vertices(self) -> np.ndarray:
        """(n, 3) mesh vertices in the link's frame, mm."""
        return self.mesh.vertices @ self.placement[:3, :3].T + self.placement[:3, 3]

    @property
    def hull(self) -> np.ndarray:
        """(k, 3) vertices that span the mesh's convex hull in the link's frame, mm."""
        return self.mesh.hull_points @ self.placement[:3, :3].T + self.placement[:3, 3]

    def lever(self, point: np.ndarray) -> float:
        """Largest distance of the exact surface from a point of the link's frame, mm."""
        return float(np.linalg.norm(self.vertices - point, axis=1).max()) + self.mesh.deviation_mm

    def lever_about_x(self) -> float:
        """Largest distance of the exact surface from the x axis of the link's frame, mm."""
        return float(np.hypot(*self.vertices[:, 1:].T).max()) + self.mesh.deviation_mm

    def lever_about_y(self) -> float:
        """Largest distance of the exact surface from the y axis of the link's frame, mm."""
        return float(np.hypot(*self.vertices[:, [0, 2]].T).max()) + self.mesh.deviation_mm

    def reach_about_y(self, directions: np.ndarray) -> np.ndarray:
        """(n,) reach of the mesh along directions (n, 3), at whichever angle about the y axis it is farthest, mm."""
        points = self.vertices
        along, off = np.unique(np.stack([points[:, 1], np.hypot(points[:, 0], points[:, 2])]), axis=1)
        across = np.hypot(directions[:, 0], directions[:, 2])
        return (np.outer(directions[:, 1], along) + np.outer(across, off)).max(axis=1)


def body(name: str, key: str, link: str, mesh: Mesh, placement: np.ndarray) -> CollisionBody:
    """A body with its bounding box along the axes of the part's frame.

    Args:
        name: Occurrence name.
        key: Shape key.
        link: Link that carries it.
        mesh: Mesh in the part's frame.
        placement: (4, 4) part frame to link frame, mm.

    Returns:
        The body.
    """
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    middle = (low + high) / 2.0
    rotation = placement[:3, :3]
    return CollisionBody(
        name=name,
        key=key,
        link=link,
        mesh=mesh,
        placement=placement,
        centre=rotation @ middle + placement[:3, 3],
        axes=rotation,
        half=(high - low) / 2.0 + mesh.deviation_mm,
        radius=float(np.linalg.norm(mesh.vertices - middle, axis=1).max()) + mesh.deviation_mm,
    )


def bodies_of(
    occurrences: Iterable[Occurrence],
    meshes: Meshes,
    swept_links: Sequence[str] = (),
    sway: SpringSway | None = None,
) -> dict[str, CollisionBody]:
    """Bodies of occurrences by name.

    Args:
        occurrences: The occurrences.
        meshes: Their parts' meshes.
        swept_links: Links that turn about their own y axis through any angle: their occurrences become the bodies of
            revolution that they sweep, which hold the parts at every angle.
        sway: How far springs stray: their bodies hold it, on links "swaying_i_k". None: they are as they are drawn.

    Returns:
        Occurrence name -> body.
    """
    bodies = {}
    for o in occurrences:
        number, mesh = o.part.number, meshes[o.part.number]
        if o.link in swept_links:
            swept = revolved_about_y(mesh, o.placement)
            where = np.round(o.placement, 7).tolist()  # equal placements to 1e-7 mm give one shape
            bodies[o.name] = body(o.name, f"{number} revolved in {where}", o.link, swept, np.eye(4))
        elif sway is not None and o.link.startswith("spring"):
            swept = revolved_about_y(mesh, o.placement, sway)
            bodies[o.name] = body(o.name, f"{number} swaying", o.link.replace("spring", "swaying"), swept, np.eye(4))
        else:
            bodies[o.name] = body(o.name, number, o.link, mesh, o.placement)
    return bodies


def revolved_about_y(mesh: Mesh, placement: np.ndarray, sway: SpringSway | None = None) -> Mesh:
    """A solid of revolution about the y axis of the link's frame that holds a part at every angle, bores filled.

    Along the axis the part is cut into slabs, and each gets a cone that holds what of the part lies in it.

    Args:
        mesh: The part's mesh.
        placement: (4, 4) part frame to link frame, mm.
        sway: How far it strays from the axis besides: a turn by `a` about the origin brings a point at `r` from the
            axis and `y` along it to `r + |y| sin(a)` and moves it along by `r sin(a) + |y| (1 - cos(a))`, at most.

    Returns:
        The mesh in the link's frame, with the part's deviation.
    """
    points = mesh.vertices @ placement[:3, :3].T + placement[:3, 3]
    levels, radii = _cones(points[mesh.faces]) if sway is None else _cylinders(points, mesh.faces, sway)
    rings_y = np.repeat(levels, 2)[1:-1]
    rings_r = radii.ravel() / np.cos(np.pi / _REVOLUTION_SIDES)
    angle = np.arange(_REVOLUTION_SIDES) * 2.0 * np.pi / _REVOLUTION_SIDES
    n, rings = _REVOLUTION_SIDES, len(rings_y)
    ring = np.stack(
        [np.outer(rings_r, np.cos(angle)), np.repeat(rings_y[:, None], n, 1), np.outer(rings_r, np.sin(angle))]
    )
    vertices = np.concatenate([ring.transpose(1, 2, 0).reshape(-1, 3), [[0, levels[0], 0], [0, levels[-1], 0]]])
    k, following = np.arange(n), (np.arange(n) + 1) % n
    faces = [np.stack([np.full(n, rings * n), k, following], axis=1)]
    for r in range(rings - 1):
        a, b, c, d = r * n + k, r * n + following, (r + 1) * n + k, (r + 1) * n + following
        faces += [np.stack([a, c, b], axis=1), np.stack([b, c, d], axis=1)]
    last = (rings - 1) * n
    faces.append(np.stack([np.full(n, rings * n + 1), last + following, last + k], axis=1))
    return Mesh(vertices, np.concatenate(faces), mesh.deviation_mm)


def _cones(triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Levels (n + 1,) along y and (n, 2) radii at both ends of the slabs between them, that hold triangles (m, 3, 3).

    The levels are the corners', so that within a slab a triangle is cut by straight edges only. The distance from the
    axis is convex along each, and across between two of them: its largest lies under the chord of both ends' largest.
    With more corners than slabs, as on a helix, each slab gets the largest of all that lies in it.
    """
    y = triangles[..., 1]
    levels = _levels(y.ravel(), _REVOLUTION_SLABS // 2)
    low, high = y.min(axis=1)[:, None], y.max(axis=1)[:, None]
    inside = (low < levels[1:] - _LEVEL_MM) & (high > levels[:-1] + _LEVEL_MM)  # (m, n): not what lies in a level
    of, slab = np.nonzero(inside)
    bottom, top = levels[slab], levels[slab + 1]
    radii = np.zeros((2, len(of)))
    within = np.zeros(len(of))
    for k in range(3):
        start, way = triangles[of, k], triangles[of, k - 2] - triangles[of, k]
        steep = np.where(np.abs(way[:, 1]) > _LEVEL_MM, way[:, 1], np.inf)
        for end, at in enumerate((bottom, top)):
            share = (at - start[:, 1]) / steep
            there = start + np.clip(share, 0.0, 1.0)[:, None] * way
            on = np.abs(there[:, 1] - at) <= 2.0 * _LEVEL_MM
            radii[end] = np.where(on, np.maximum(radii[end], np.hypot(there[:, 0], there[:, 2])), radii[end])
        between = (start[:, 1] > bottom + _LEVEL_MM) & (start[:, 1] < top - _LEVEL_MM)
        within = np.maximum(within, np.where(between, np.hypot(start[:, 0], start[:, 2]), 0.0))
    out = np.zeros((len(levels) - 1, 2))
    for end in range(2):
        np.maximum.at(out[:, end], slab, radii[end])
    most = np.zeros(len(out))
    np.maximum.at(most, slab, within)
    whole = np.maximum(most, out.max(axis=1))[:, None]
    return levels, np.where(most[:, None] > 0.0, whole, out) + _LEVEL_MM


def _cylinders(points: np.ndarray, faces: np.ndarray, sway: SpringSway) -> tuple[np.ndarray, np.ndarray]:
    """Levels and radii as `_cones`, of triangles that sway: each slab has the largest radius of any in it."""
    radius, y = np.hypot(points[:, 0], points[:, 2]), points[:, 1]
    sine, lost = np.sin(sway.turn_rad), 1.0 - np.cos(sway.turn_rad)
    aside = sway.along_mm + radius * sine + np.abs(y) * lost
    radius = radius + np.abs(y) * sine + sway.across_mm
    levels = _levels(np.concatenate([y - aside, y + aside]))
    low, high = (y - aside)[faces].min(axis=1), (y + aside)[faces].max(axis=1)
    inside = (low[:, None] < levels[1:] - _LEVEL_MM) & (high[:, None] > levels[:-1] + _LEVEL_MM)
    largest = np.where(inside, radius[faces].max(axis=1)[:, None], 0.0).max(axis=0)
    return levels, np.repeat(largest[:, None], 2, axis=1)


def _levels(y: np.ndarray, edges: int = 0) -> np.ndarray:
    """Where slabs begin and end: at each value; of too many evenly, and at the commonest of them, which are edges."""
    levels, counts = np.unique(np.round(y, 6), return_counts=True)
    if len(levels) > _REVOLUTION_SLABS + 1:
        common = levels[np.argsort(-counts, kind="stable")[:edges]]
        levels = np.unique([*common, *np.linspace(levels[0], levels[-1], _REVOLUTION_SLABS + 1 - edges)])
    levels[0], levels[-1] = y.min(), y.max()
    return levels


def is_round(b: CollisionBody, to_axis: np.ndarray = _X_TO_Y) -> bool:
    """Whether a body reaches about as far from an axis in every direction square to it.

    Args:
        b: The body.
        to_axis: (4, 4) its link's frame to a frame whose y axis is meant; that of the link's x axis.
    """
    angle = np.arange(_ROUND_DIRECTIONS) * 2.0 * np.pi / _ROUND_DIRECTIONS
    seen = b.vertices @ to_axis[:3, :3].T + to_axis[:3, 3]
    reach = (seen[:, [0, 2]] @ np.stack([np.cos(angle), np.sin(angle)])).max(axis=0)
    return bool(reach.min() >= ROUND * reach.max())


def spun(b: CollisionBody, to_axis: np.ndarray = _X_TO_Y) -> CollisionBody:
    """The body of revolution that holds a body however it turns about an axis, given as for `is_round`."""
    mesh = revolved_about_y(b.mesh, to_axis @ b.placement)
    where = np.round(to_axis @ b.placement, 7).tolist()
    return body(b.name, f"{b.key} spun in {where}", b.link, mesh, np.linalg.inv(to_axis))


def turned_hull(b: CollisionBody, turn_rad: float) -> CollisionBody:
    """A convex body that holds a body while it turns about the x axis of its link's frame.

    Between two turns an arc lies within the chord of its ends and the chord of the points farther out by
    `1 / cos(step / 2)`, so these span a hull that holds it.

    Args:
        b: The body.
        turn_rad: Largest turn either way.

    Returns:
        The body, with the deviation of the given one.
    """
    from scipy.spatial import ConvexHull

    angles = np.linspace(-turn_rad, turn_rad, _TURN_STEPS + 1)
    outer = b.hull * [1.0, *(2 * [1.0 / np.cos(turn_rad / _TURN_STEPS)])]
    turns = turn_about_x(angles)[:, None, :3, :3]
    points = (turns @ np.concatenate([b.hull, outer])[..., None])[..., 0].reshape(-1, 3)
    used, faces = np.unique(ConvexHull(points).simplices, return_inverse=True)
    mesh = Mesh(points[used], faces.reshape(-1, 3), b.mesh.deviation_mm)
    where = np.round(b.placement, 7).tolist()
    return body(b.name, f"{b.key} turned by {turn_rad:.9f} in {where}", b.link, mesh, np.eye(4))


def tree_of(mesh: Mesh) -> Any:
    """FCL's bounding volumes of a mesh, made once for as long as it lives."""
    import fcl

    tree = _TREES.get(mesh)
    if tree is None:
        tree = _TREES[mesh] = fcl.BVHModel()
        tree.beginModel(len(mesh.vertices), len(mesh.faces))
        tree.addSubModel(mesh.vertices, mesh.faces)
        tree.endModel()
    return tree


class DistanceEngine:
    """FCL distances between bodies; one bounding volume tree per shape, and a count of the calls."""

    def __init__(self) -> None:
        self._objects: dict[str, tuple[Any, Any]] = {}
        self.calls = 0

    def _pair(self, key: str, mesh: Mesh) -> tuple[Any, Any]:
        """Two collision objects of one shape, so that a shape can be held against itself."""
        import fcl

        if key not in self._objects:
            tree = tree_of(mesh)
            self._objects[key] = (fcl.CollisionObject(tree), fcl.CollisionObject(tree))
        return self._objects[key]

    def distance(self, a: CollisionBody, b: CollisionBody, pose_a: np.ndarray, pose_b: np.ndarray) -> float:
        """Distance of two meshes.

        Args:
            a: One body.
            b: The other.
            pose_a: (4, 4) part frame of a to a common frame, mm.
            pose_b: (4, 4) part frame of b to the same frame, mm.

        Returns:
            Distance, mm; 0 where they intersect. A body wholly inside another is not noticed.
        """
        import fcl

        return max(float(fcl.distance(*self._placed(a, b, pose_a, pose_b))), 0.0)

    def closest_points(
        self, a: CollisionBody, b: CollisionBody, pose_a: np.ndarray, pose_b: np.ndarray
    ) -> tuple[float, np.ndarray, np.ndarray]:
        """Distance of two meshes as `distance`, and the (3,) closest points of a and of b in the common frame, mm."""
        import fcl

        result = fcl.DistanceResult()
        placed = self._placed(a, b, pose_a, pose_b)
        d = float(fcl.distance(*placed, fcl.DistanceRequest(enable_nearest_points=True), result))
        at_a, at_b = result.nearest_points
        return max(d, 0.0), np.asarray(at_a), np.asarray(at_b)

    def _placed(self, a: CollisionBody, b: CollisionBody, pose_a: np.ndarray, pose_b: np.ndarray) -> tuple[Any, Any]:
        """The collision objects of two bodies at their poses; each call is counted."""
        import fcl

        one, other = self._pair(a.key, a.mesh)[0], self._pair(b.key, b.mesh)[1]
        one.setTransform(fcl.Transform(pose_a[:3, :3], pose_a[:3, 3]))
        other.setTransform(fcl.Transform(pose_b[:3, :3], pose_b[:3, 3]))
        self.calls += 1
        return one, other


def boxes_gap(
    centre: np.ndarray, axes_a: np.ndarray, half_a: np.ndarray, axes_b: np.ndarray, half_b: np.ndarray
) -> np.ndarray:
    """Lower bound on the distance of two oriented boxes: the widest gap along their face normals and edge products.

    Args:
        centre: (n, 3) from the centre of a to the centre of b, in the frame of the axes.
        axes_a: (n, 3, 3) columns: directions of box a.
        half_a: (n, 3) half sides of box a.
        axes_b: (n, 3, 3) columns: directions of box b.
        half_b: (n, 3) half sides of box b.

    Returns:
        (n,) bound; negative or 0 where the boxes overlap.
    """
    local = np.swapaxes(axes_a, -1, -2) @ axes_b  # columns: b's directions seen from a
    d = (np.swapaxes(axes_a, -1, -2) @ centre[..., None])[..., 0]
    size = np.abs(local)
    face_a = np.abs(d) - half_a - (size @ half_b[..., None])[..., 0]
    d_b = (np.swapaxes(local, -1, -2) @ d[..., None])[..., 0]
    face_b = np.abs(d_b) - half_b - (np.swapaxes(size, -1, -2) @ half_a[..., None])[..., 0]
    gap = np.maximum(face_a.max(axis=-1), face_b.max(axis=-1))
    # corner region: gaps along a's three directions are square to each other, so they add as squares
    gap = np.maximum(gap, np.linalg.norm(np.maximum(face_a, 0.0), axis=-1))
    gap = np.maximum(gap, np.linalg.norm(np.maximum(face_b, 0.0), axis=-1))
    for i in range(3):
        j, k = (i + 1) % 3, (i + 2) % 3
        # e_i x b_l has components -b_kl along j and b_jl along k (up to sign), length sqrt(b_jl^2 + b_kl^2)
        length = np.hypot(local[..., j, :], local[..., k, :])
        cross = np.abs(d[..., k, None] * local[..., j, :] - d[..., j, None] * local[..., k, :])
        reach = half_a[..., j, None] * size[..., k, :] + half_a[..., k, None] * size[..., j, :]
        for el in range(3):
            f, h = (el + 1) % 3, (el + 2) % 3
            spread = half_b[..., f] * size[..., i, h] + half_b[..., h] * size[..., i, f]
            usable = length[..., el] > 1e-6  # nearly parallel edges: the face normals already decide
            along = (cross[..., el] - reach[..., el] - spread) / np.where(usable, length[..., el], 1.0)
            gap = np.maximum(gap, np.where(usable, along, -np.inf))
    return gap
