"""Triangle meshes of solids with a bound on how far they stray from the exact surface.

The bound is the largest, over the faces of a solid, of `face + edges`:
    face: distance of the triangles from the face's surface. Linear interpolation over a triangle whose parameter
        ranges are du and dv strays at most `(A du^2 + 2 B du dv + C dv^2) / 8` (Taylor's theorem at the point, and
        Popoviciu's bound on the variance of the corners), where A, B, C bound the second derivatives uu, uv, vv of the
        surface: 0 on planes; A = r on cylinders; A = r_max, B = |sin a| on cones; A = R + r, B = C = r on tori. A
        triangle from a cone's tip strays most on its opposite side, whose ranges are taken.
        On spheres it is `r - (smallest distance of a triangle from the centre)`.
    edges: distance of the face's boundary polygons from the exact edges: 0 on lines, the sagitta
        `r (1 - cos(span / 2))` on circles. A point of the face between an arc and its chord is that close to the
        chord, and the chord is on the mesh.
Other surfaces and curves have no closed form here: their deviation is measured at the middle of every triangle, of its
sides and at a quarter, half and three quarters of every boundary segment, and doubled; never below the linear setting.
"""

# pyright: reportAttributeAccessIssue=false
# OCP builds its modules at run time, so a type checker does not see their names

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from delta_cad.common.memoize import cached
from delta_cad.solids.part import Part, solid_digest

if TYPE_CHECKING:
    import cadquery as cq

MERGE_MM = 1e-6  # vertices of two faces on one edge are copies of the same point; OCC's own confusion is 1e-7 mm
_MEASURED_SAFETY = 2.0  # a parabola is halfway up at a quarter of its chord: samples miss less than half of the peak


@dataclass(frozen=True, eq=False)
class Mesh:
    """A triangle mesh of one solid in the solid's own frame.

    Attributes:
        vertices: (n, 3) points, mm, each once.
        faces: (m, 3) vertex indices, counter-clockwise seen from outside.
        deviation_mm: Bound on the Hausdorff distance between the mesh and the exact surface.
        layer_mm3: Bound on the difference of volume between mesh and exact solid, face by face; None: not known.
    """

    vertices: np.ndarray
    faces: np.ndarray
    deviation_mm: float
    layer_mm3: float | None = None

    @cached_property
    def triangles(self) -> np.ndarray:
        """(m, 3, 3) corner points of the triangles, mm."""
        return self.vertices[self.faces]

    @cached_property
    def hull_points(self) -> np.ndarray:
        """(k, 3) the vertices that span the convex hull, mm; all of them where they lie in a plane."""
        from scipy.spatial import ConvexHull, QhullError

        try:
            return self.vertices[ConvexHull(self.vertices).vertices]
        except QhullError:
            return self.vertices

    @cached_property
    def volume_mm3(self) -> float:
        """Enclosed volume by the divergence theorem, positive for outward winding, mm^3."""
        a, b, c = np.moveaxis(self.triangles - self.vertices.mean(axis=0), 1, 0)
        return float((a * np.cross(b, c)).sum() / 6.0)

    @cached_property
    def area_mm2(self) -> float:
        """Sum of the triangles' areas, mm^2."""
        a, b, c = np.moveaxis(self.triangles, 1, 0)
        return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2.0)

    @cached_property
    def is_watertight(self) -> bool:
        """Whether every directed edge occurs once and its reverse once: closed, and wound consistently."""
        if not len(self.faces):
            return False
        n = len(self.vertices)
        start, end = self.faces.ravel(), np.roll(self.faces, -1, axis=1).ravel()
        forward, backward = np.sort(start * n + end), np.sort(end * n + start)
        return bool((np.diff(forward) > 0).all() and (forward == backward).all())


class Meshes(Protocol):
    """Meshes by part number, a `MeshLibrary` or a dictionary."""

    def __getitem__(self, number: str, /) -> Mesh:
        """The mesh of a part in its own frame, mm."""
        ...


class MeshLibrary:
    """One mesh per part number, made when first asked for.

    Args:
        parts: The parts.
        linear_mm: Linear deflection of the tessellation.
        angular_rad: Angular deflection of the tessellation.

    Raises:
        ValueError: Two different parts share a number.
    """

    def __init__(self, parts: Iterable[Part], linear_mm: float = 0.05, angular_rad: float = 0.35) -> None:
        self.linear_mm, self.angular_rad = linear_mm, angular_rad
        self._parts: dict[str, Part] = {}
        self._meshes: dict[str, Mesh] = {}
        for part in parts:
            if self._parts.setdefault(part.number, part) is not part:
                raise ValueError(f"two different parts are numbered {part.number!r}")

    def __getitem__(self, number: str) -> Mesh:
        """Gives the mesh of a part in the part's frame by its number.

        Raises:
            BuildError: The kernel cannot triangulate it.
        """
        if number not in self._meshes:
            try:
                solid, fine = self._parts[number].solid, (self.linear_mm, self.angular_rad)
                made = cached("mesh", (solid_digest(solid), fine), lambda: tessellate(solid, *fine))
                self._meshes[number] = made
            except ValueError as error:
                from delta_cad.solids.primitive import BuildError  # loads the CAD kernel, which made the solid

                raise BuildError(number, "mesh", f"deflection {self.linear_mm:g} mm", error) from None
        return self._meshes[number]


def tessellate(solid: cq.Shape, linear_mm: float, angular_rad: float) -> Mesh:
    """Triangulates a solid, its own cached triangulation left alone and unused; bounds the mesh's deviation.

    Args:
        solid: The solid (or any shape with faces).
        linear_mm: Absolute linear deflection.
        angular_rad: Angular deflection.
    """
    from OCP.BRep import BRep_Tool
    from OCP.BRepBuilderAPI import BRepBuilderAPI_Copy
    from OCP.BRepMesh import BRepMesh_IncrementalMesh
    from OCP.TopAbs import TopAbs_FACE, TopAbs_REVERSED
    from OCP.TopExp import TopExp_Explorer
    from OCP.TopLoc import TopLoc_Location
    from OCP.TopoDS import TopoDS

    shape = BRepBuilderAPI_Copy(solid.wrapped, True, False).Shape()  # geometry copied, triangulation not
    BRepMesh_IncrementalMesh(shape, linear_mm, False, angular_rad, True)
    points: list[np.ndarray] = []
    corners: list[np.ndarray] = []
    deviation, layer, count = 0.0, 0.0, 0
    explorer = TopExp_Explorer(shape, TopAbs_FACE)
    while explorer.More():
        face = TopoDS.Face_s(explorer.Current())
        location = TopLoc_Location()
        triangulation = BRep_Tool.Triangulation_s(face, location)
        explorer.Next()
        if triangulation is None:
            raise ValueError("a face of the solid could not be triangulated")
        nodes, uv, triangles = _arrays(triangulation, location)
        inside, along = (
            _face_deviation(face, nodes, uv, triangles, linear_mm),
            _edges_deviation(face, triangulation, location),
        )
        deviation = max(deviation, inside + along)
        layer += _layer(nodes, triangles, inside, along)
        points.append(nodes)
        reverse = face.Orientation() == TopAbs_REVERSED
        corners.append((triangles[:, ::-1] if reverse else triangles) + count)
        count += len(nodes)
    if not points:
        raise ValueError("the shape has no faces to triangulate")
    vertices, faces = _merged(np.concatenate(points), np.concatenate(corners))
    return Mesh(vertices, faces, deviation + MERGE_MM, layer)


def _layer(nodes: np.ndarray, triangles: np.ndarray, inside_mm: float, along_mm: float) -> float:
    """Bound on the volume between a face and its triangles, mm^3.

    Moved straight onto the face's surface the triangles stay within the face's deviation d, on either side: 2 d area; a
    plane leaves none. From there to the exact edges they slide within the surface, which encloses nothing. Where two
    faces meet, what one slides and the other is moved lies within both deviations of the edges' polygons.
    """
    q = nodes[triangles]
    area = np.linalg.norm(np.cross(q[:, 1] - q[:, 0], q[:, 2] - q[:, 0]), axis=1).sum() / 2.0
    sides = np.sort(np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]), axis=1)
    sides, count = np.unique(sides, axis=0, return_counts=True)
    rim = sides[count == 1]
    length = np.linalg.norm(nodes[rim[:, 0]] - nodes[rim[:, 1]], axis=1).sum()
    d = inside_mm + along_mm
    return float(2.0 * inside_mm * area + np.pi * d**2 * length + 4.0 / 3.0 * np.pi * d**3 * len(rim))


def _arrays(triangulation: Any, location: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Nodes (n, 3) in the shape's frame, their (n, 2) surface parameters, triangles (m, 3) counted from 0."""
    n, m = triangulation.NbNodes(), triangulation.NbTriangles()
    node, parameter, triangle = triangulation.Node, triangulation.UVNode, triangulation.Triangle
    nodes = np.array([(p.X(), p.Y(), p.Z()) for p in map(node, range(1, n + 1))])
    uv = np.array([(p.X(), p.Y()) for p in map(parameter, range(1, n + 1))])
    triangles = np.array([triangle(k).Get() for k in range(1, m + 1)]).reshape(-1, 3) - 1
    if not location.IsIdentity():
        matrix = location.Transformation()
        t = np.array([[matrix.Value(i, j) for j in range(1, 5)] for i in range(1, 4)])
        nodes = nodes @ t[:, :3].T + t[:, 3]
    return nodes, uv, triangles


def _face_deviation(face: Any, nodes: np.ndarray, uv: np.ndarray, triangles: np.ndarray, linear_mm: float) -> float:
    """Bound on the distance between a face's triangles and its surface, mm; see the module."""
    from OCP.BRepAdaptor import BRepAdaptor_Surface
    from OCP.GeomAbs import GeomAbs_Cone, GeomAbs_Cylinder, GeomAbs_Plane, GeomAbs_Sphere, GeomAbs_Torus

    surface = BRepAdaptor_Surface(face)
    kind = surface.GetType()
    if kind == GeomAbs_Plane or not len(triangles):
        return 0.0
    du, dv = np.ptp(uv[triangles], axis=1).T
    if kind == GeomAbs_Cylinder:
        return float((surface.Cylinder().Radius() * du**2).max() / 8.0)
    if kind == GeomAbs_Cone:
        cone = surface.Cone()
        slope = abs(np.sin(cone.SemiAngle()))
        radii = np.abs(cone.RefRadius() + uv[:, 1] * np.sin(cone.SemiAngle()))
        tips = (radii[triangles] < MERGE_MM)[..., None]  # u is anything there, and rulings lead from it to the others
        most = np.where(tips, -np.inf, uv[triangles]).max(axis=1)
        least = np.where(tips, np.inf, uv[triangles]).min(axis=1)
        du, dv = np.maximum(most - least, 0.0).T
        return float((radii.max() * du**2 + 2.0 * slope * du * dv).max() / 8.0)
    if kind == GeomAbs_Torus:
        torus = surface.Torus()
        large, small = torus.MajorRadius(), torus.MinorRadius()
        return float(((large + small) * du**2 + small * (2.0 * du * dv + dv**2)).max() / 8.0)
    if kind == GeomAbs_Sphere:
        sphere = surface.Sphere()
        centre = sphere.Location()
        near = _distance_to_triangles(np.array([centre.X(), centre.Y(), centre.Z()]), nodes[triangles])
        return float(max(sphere.Radius() - near.min(), 0.0))
    where = np.array([[1, 1, 1], [2, 2, 0], [0, 2, 2], [2, 0, 2]]) / np.array([[3.0], [4.0], [4.0], [4.0]])
    flat = np.einsum("kc,mcx->mkx", where, nodes[triangles]).reshape(-1, 3)
    at = np.einsum("kc,mcx->mkx", where, uv[triangles]).reshape(-1, 2)
    exact = np.array([(p.X(), p.Y(), p.Z()) for p in (surface.Value(u, v) for u, v in at)])
    return max(_MEASURED_SAFETY * float(np.linalg.norm(flat - exact, axis=1).max()), linear_mm)


def _edges_deviation(face: Any, triangulation: Any, location: Any) -> float:
    """Largest distance between the boundary edges of a face and their polygons, mm."""
    from OCP.BRep import BRep_Tool
    from OCP.BRepAdaptor import BRepAdaptor_Curve
    from OCP.GeomAbs import GeomAbs_Circle, GeomAbs_Line
    from OCP.TopAbs import TopAbs_EDGE
    from OCP.TopExp import TopExp_Explorer
    from OCP.TopoDS import TopoDS

    worst = 0.0
    explorer = TopExp_Explorer(face, TopAbs_EDGE)
    while explorer.More():
        edge = TopoDS.Edge_s(explorer.Current())
        explorer.Next()
        if BRep_Tool.Degenerated_s(edge):
            continue
        curve = BRepAdaptor_Curve(edge)
        if curve.GetType() == GeomAbs_Line:
            continue
        polygon = BRep_Tool.PolygonOnTriangulation_s(edge, triangulation, location)
        if polygon is None:
            return np.inf  # nothing is known of this edge, and infinity is the sound bound
        parameters = np.array([polygon.Parameter(k) for k in range(1, polygon.NbNodes() + 1)])
        if curve.GetType() == GeomAbs_Circle:
            span = np.abs(np.diff(parameters)).max()
            worst = max(worst, curve.Circle().Radius() * (1.0 - np.cos(span / 2.0)))
            continue
        ends = _on_curve(curve, parameters)
        for part in (0.25, 0.5, 0.75):
            exact = _on_curve(curve, parameters[:-1] + part * np.diff(parameters))
            off = _distance_to_segments(exact, ends[:-1], ends[1:])
            worst = max(worst, _MEASURED_SAFETY * float(off.max()))
    return worst


def _on_curve(curve: Any, parameters: np.ndarray) -> np.ndarray:
    """(n, 3) points of a curve, mm."""
    return np.array([(p.X(), p.Y(), p.Z()) for p in map(curve.Value, parameters.tolist())])


def _distance_to_segments(points: np.ndarray, start: np.ndarray, end: np.ndarray) -> np.ndarray:
    """(n,) distance of each point from its own segment, mm."""
    along = end - start
    square = np.maximum((along**2).sum(axis=-1), np.finfo(float).tiny)
    share = np.clip(((points - start) * along).sum(axis=-1) / square, 0.0, 1.0)
    return np.linalg.norm(points - start - share[..., None] * along, axis=-1)


def _distance_to_triangles(point: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """(m,) distance of one point from each triangle (m, 3, 3), mm."""
    a, b, c = np.moveaxis(triangles, 1, 0)
    normal = np.cross(b - a, c - a)
    length = np.linalg.norm(normal, axis=1)
    unit = normal / np.maximum(length, np.finfo(float).tiny)[:, None]
    above = np.abs(((point - a) * unit).sum(axis=1))
    corners = ((a, b), (b, c), (c, a))
    inside = np.all([(np.cross(q - p, point - p) * unit).sum(axis=1) >= 0.0 for p, q in corners], axis=0)
    sides = np.min([_distance_to_segments(np.broadcast_to(point, p.shape), p, q) for p, q in corners], axis=0)
    return np.where(inside & (length > 0.0), above, sides)


def _merged(points: np.ndarray, triangles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Vertices within `MERGE_MM` made one, triangles that vanish by it dropped."""
    label, first = _same(points)
    faces = label[triangles]
    kept = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])
    return points[first], faces[kept]


def _same(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(n,) which of the distinct points each is, counted as they come, and the (k,) index of the first of each.

    Groups are split at gaps wider than `MERGE_MM` along one axis after the other, until none is left: what ends up
    apart is so along an axis, and points closer than that are together.
    """
    group = np.zeros(len(points), dtype=int)
    count = 0
    while count < (count := int(group.max()) + 1):
        for axis in points.T:
            order = np.lexsort((axis, group))
            apart = (np.diff(axis[order]) > MERGE_MM) | (np.diff(group[order]) > 0)
            group[order] = np.concatenate([[0], np.cumsum(apart)])
    _, first = np.unique(group, return_index=True)
    number = np.empty(len(first), dtype=int)
    number[np.argsort(first)] = np.arange(len(first))
    return number[group], np.sort(first)
