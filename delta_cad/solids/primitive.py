"""Simple solids and the guard that every part is one valid solid.

Planes: chain and arm parts are drawn in their (first, third) axes and extruded along the second, the shoulder axis.
"""

# pyright: reportAttributeAccessIssue=false
# OCP builds its modules at run time, so a type checker does not see their names

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from math import acos, atan2, ceil, cos, hypot, pi, sin, tau
from typing import cast

import cadquery as cq
import numpy as np

from delta_cad.common.memoize import memoize
from delta_cad.common.vectors import cross
from delta_cad.dimensions.rules import CORNERS_MM

Point = tuple[float, float]
Circle = tuple[float, float, float]  # centre and radius; radius 0 is a corner

_SHORT_MM = 1e-9  # two circles of a hull that touch inside have no line between them
_NEXT_TO_MM = 0.3  # of a wall, where it is looked whether a cutter reaches a floor
_FAR_MM = 1e3  # beyond every part
_SHIFT_MM = 0.01  # off a floor, so that a line does not begin in it
_LEFT_MM = 0.05  # that a cutter may leave in a corner without a rounding: half of what ISO 2768-m allows a size
_LEAST_SINE = 0.02  # of the angle between two faces that meet at an inner corner; what is smoother is none
_NEAR_MM = 1e-5  # of faces that nearly meet: a hundredth of what is measured
_ARC_RAD = 1.0  # longest arc of a cable drawn on a drum: off its helix by micrometres
_STEEP = 0.014  # climb above which arcs are shorter
_KINK = 0.0115  # climb times arc, there: with more no torus is swept round a kink
THROUGH_MM = 0.5  # a tool that goes through a face sticks out by this, so that no faces coincide
_MESHED_MM, _MESHED_RAD, _ENCLOSED = 0.02, 0.1, 2e-3  # of a mesh that tells a volume, and the share to which it does
_EDGE_SHARES = 1.0, 0.8, 0.6  # of a chamfer that is asked, the first that the kernel makes


class BuildError(RuntimeError):
    """A solid could not be built; says which part, feature and parameter.

    Attributes:
        part: Part number.
        feature: What of the part failed.
        parameter: The parameter that decides it.
    """

    def __init__(self, part: str, feature: str, parameter: str, cause: object = "") -> None:
        self.part, self.feature, self.parameter = part, feature, parameter
        super().__init__(f"{part}: {feature} cannot be built ({parameter}){f': {cause}' if cause else ''}")


def one_solid(shape: cq.Shape, part: str) -> cq.Solid:
    """The only solid of a shape; BuildError if there are none or several, or if it is not valid."""
    solids = shape.Solids()
    if len(solids) != 1:
        raise BuildError(part, "body", f"{len(solids)} solids instead of 1")
    solid = solids[0]
    if not solid.isValid() or solid.Volume() <= 0:
        raise BuildError(part, "body", "the solid is not valid")
    return solid


def encloses_its_volume(shape: cq.Shape) -> bool:
    """Decides whether a shape is valid and its faces enclose the volume that it has: the kernel can lose a face."""
    if not shape.isValid():
        return False
    vertices, triangles = shape.copy().tessellate(_MESHED_MM, _MESHED_RAD)
    corners = np.array([vertex.toTuple() for vertex in vertices])[np.array(triangles)]
    meshed = float(np.linalg.det(corners).sum() / 6.0)
    return abs(meshed - shape.Volume()) <= _ENCLOSED * shape.Volume()


def feature(part: str, name: str, parameter: str, build: Callable[[], cq.Shape]) -> cq.Shape:
    """Run one modelling step; a failure of the kernel becomes a BuildError that names the feature."""
    try:
        return build()
    except BuildError:
        raise
    except Exception as error:
        raise BuildError(part, name, parameter, error) from error


def cylinder(diameter: float, start: Sequence[float], end: Sequence[float]) -> cq.Solid:
    """Cylinder between two points."""
    a, b = cq.Vector(*start), cq.Vector(*end)
    along = b - a
    return cq.Solid.makeCylinder(diameter / 2, along.Length, a, along)


def ball(
    diameter: float, centre: Sequence[float] = (0.0, 0.0, 0.0), axis: Sequence[float] = (0.0, 0.0, 1.0)
) -> cq.Solid:
    """Full sphere; `axis` says where its poles lie."""
    sphere = cq.Solid.makeSphere(diameter / 2, cq.Vector(*centre), cq.Vector(*axis), -90, 90, 360)
    return cast(cq.Solid, sphere)


def box(low: Sequence[float], high: Sequence[float]) -> cq.Solid:
    """Axis-aligned box between two corners."""
    return cq.Solid.makeBox(high[0] - low[0], high[1] - low[1], high[2] - low[2], cq.Vector(*low))


def turned(profile: Sequence[Point], origin: Sequence[float] = (0.0, 0.0, 0.0)) -> cq.Solid:
    """Solid of revolution about the y axis through `origin`; profile points are (radius, y), from and to the axis."""
    ox, oy, oz = origin
    wire = cq.Wire.makePolygon([cq.Vector(ox + r, oy + y, oz) for r, y in profile], close=True)
    return cq.Solid.revolve(wire, [], 360.0, cq.Vector(ox, oy, oz), cq.Vector(ox, oy + 1.0, oz))


def stepped(*steps: tuple[float, float, float]) -> cq.Solid:
    """Cylinders (radius, from, to) one after the other along y."""
    outline = [(radius, y) for radius, *ends in steps for y in ends]
    return turned([(0.0, outline[0][1]), *outline, (0.0, outline[-1][1])])


def bevelled(radius: float, y: Point, bevel: float, origin: Sequence[float] = (0.0, 0.0, 0.0)) -> cq.Solid:
    """Cylinder along y about an axis through `origin`, both of its edges bevelled."""
    a, b = y
    return turned(
        [(0.0, a), (radius - bevel, a), (radius, a + bevel), (radius, b - bevel), (radius - bevel, b), (0.0, b)], origin
    )


def _hull(circles: Sequence[Circle]) -> list[tuple[Circle, float, float]]:
    """Convex hull of circles as arcs (circle, start angle, end angle), counter-clockwise; lines join them.

    The hull's support in direction n is max over circles of c . n + r; it changes owner where two supports are equal,
    which has a closed form: |c_j - c_i| cos(phi - beta) = r_i - r_j.
    """
    steps = 3600
    phi = tau * (np.arange(steps) + 0.5) / steps
    x, y, r = np.array(circles).T[:, :, None]
    owners = np.argmax(x * np.cos(phi) + y * np.sin(phi) + r, axis=0).tolist()
    changes = []
    for k in range(steps):
        i, j = owners[k - 1], owners[k]
        if i == j:
            continue
        dx, dy = circles[j][0] - circles[i][0], circles[j][1] - circles[i][1]
        beta, spread = atan2(dy, dx), acos((circles[i][2] - circles[j][2]) / hypot(dx, dy))
        near = tau * k / steps
        exact = min((beta + spread, beta - spread), key=lambda a: abs((a - near + pi) % tau - pi))
        changes.append((near + (exact - near + pi) % tau - pi, j))
    if not changes:
        return [(circles[owners[0]], 0.0, tau)]
    return [
        (circles[index], start, changes[(k + 1) % len(changes)][0] + (tau if k + 1 == len(changes) else 0.0))
        for k, (start, index) in enumerate(changes)
    ]


def _hull_wire(circles: Sequence[Circle], to_space: Callable[[Point], cq.Vector]) -> cq.Wire:
    """Closed wire of the convex hull of circles, mapped from its plane to space."""
    arcs = _hull(circles)

    def on(circle: Circle, angle: float) -> cq.Vector:
        return to_space((circle[0] + circle[2] * cos(angle), circle[1] + circle[2] * sin(angle)))

    edges: list[cq.Edge] = []
    for k, (circle, start, end) in enumerate(arcs):
        if circle[2] > 0:
            edges.append(cq.Edge.makeThreePointArc(on(circle, start), on(circle, (start + end) / 2), on(circle, end)))
        following = arcs[(k + 1) % len(arcs)]
        straight = on(circle, end), on(following[0], following[1])
        if (straight[1] - straight[0]).Length > _SHORT_MM:
            edges.append(cq.Edge.makeLine(*straight))
    return cq.Wire.assembleEdges(edges)


def hull_along_y(circles: Sequence[Circle], y: Point) -> cq.Solid:
    """Prism over the hull of circles given in (first, third) coordinates, between two values of the second."""
    wire = _hull_wire(circles, lambda p: cq.Vector(p[0], y[0], p[1]))
    return cq.Solid.extrudeLinear(wire, [], cq.Vector(0, y[1] - y[0], 0))


def hull_along_z(circles: Sequence[Circle], z: Point) -> cq.Solid:
    """Prism over the hull of circles given in (first, second) coordinates, between two heights."""
    wire = _hull_wire(circles, lambda p: cq.Vector(p[0], p[1], z[0]))
    return cq.Solid.extrudeLinear(wire, [], cq.Vector(0, 0, z[1] - z[0]))


def ring_segment(inner: float, outer: float, angles: Point, y: Point) -> cq.Solid:
    """Part of a flat ring about the y axis: radii, polar angles in (first, third) coordinates, extent in y."""

    def at(radius: float, angle: float) -> cq.Vector:
        return cq.Vector(radius * cos(angle), y[0], radius * sin(angle))

    middle = sum(angles) / 2
    wire = cq.Wire.assembleEdges(
        [
            cq.Edge.makeThreePointArc(at(outer, angles[0]), at(outer, middle), at(outer, angles[1])),
            cq.Edge.makeLine(at(outer, angles[1]), at(inner, angles[1])),
            cq.Edge.makeThreePointArc(at(inner, angles[1]), at(inner, middle), at(inner, angles[0])),
            cq.Edge.makeLine(at(inner, angles[0]), at(outer, angles[0])),
        ]
    )
    return cq.Solid.extrudeLinear(wire, [], cq.Vector(0, y[1] - y[0], 0))


def bore_y(diameter: float, at: Point, y: Point) -> cq.Solid:
    """Tool for a bore along y at (first, third) coordinates."""
    return cylinder(diameter, (at[0], y[0], at[1]), (at[0], y[1], at[1]))


def bore_z(diameter: float, at: Point, z: Point) -> cq.Solid:
    """Tool for a bore along z at (first, second) coordinates."""
    return cylinder(diameter, (at[0], at[1], z[0]), (at[0], at[1], z[1]))


def cut(solid: cq.Shape, tools: Iterable[cq.Shape]) -> cq.Shape:
    """Solid less all tools, in one boolean."""
    return solid.cut(*tools)


def swept_round(pieces: Sequence[Sequence[Sequence[float]]], diameter: float) -> cq.Solid:
    """Round rod along a line of straight pieces (two points) and arcs (three): cylinders and tori, no splines.

    Args:
        pieces: Each begins where the one before ends, within 0.02 rad in the same direction.
        diameter: Of the rod.
    """
    edges = []
    for piece in pieces:
        points = [cq.Vector(*point) for point in piece]
        edges.append(cq.Edge.makeThreePointArc(*points) if len(points) == 3 else cq.Edge.makeLine(*points))
    path = cq.Wire.assembleEdges(edges)
    profile = cq.Wire.makeCircle(diameter / 2, path.startPoint(), path.tangentAt(0.0))  # type: ignore[attr-defined]
    return cast(cq.Solid, cq.Solid.sweep(profile, [], path, True, False))


def fuse(solid: cq.Shape, *others: cq.Shape) -> cq.Shape:
    """Union with coplanar faces merged; what is within 10 nm counts as one where the kernel comes to nothing else."""
    try:
        return solid.fuse(*others).clean()
    except ValueError:  # a null shape
        return solid.fuse(*others, tol=_NEAR_MM).clean()


def edge_break(part: str, solid: cq.Shape, faces: str, size: float) -> cq.Shape:
    """Chamfer of the outer edges of the faces (or the edges) that a selector names; last, as kernels like it.

    Smaller where the kernel makes nonsense of it, as beside an arc that is much shorter than the chamfer is wide.

    Args:
        part: Part number, for the error.
        solid: Body before its bores are cut, so that only outer edges are broken.
        faces: CadQuery selector of faces whose edges are broken.
        size: Leg of the chamfer, mm.
    """

    def build() -> cq.Shape:
        edges = cq.Workplane(obj=solid).faces(faces).edges().vals()
        whole, most = solid.Volume(), size**2 * sum(edge.Length() for edge in edges)  # type: ignore[operator]
        for share in _EDGE_SHARES:
            broken = solid.chamfer(share * size, None, edges)  # type: ignore[attr-defined]
            broken = broken if broken.isValid() else broken.fix()  # beside an arc of hundredths a face crosses itself
            if 0.0 < whole - broken.Volume() <= most:
                return broken
        raise ValueError(f"a chamfer of {size:g} mm, or {_EDGE_SHARES[-1]:g} of it, is not less than the body")

    return feature(part, f"edge break {size:g}", faces, build)


@dataclass(frozen=True, eq=False)
class _InnerEdge:
    """An edge in which two faces meet with the material outside, seen in its middle.

    Attributes:
        edge: The kernel's.
        point: (3,) its middle, mm.
        tangent: (3,) unit vector along it there.
        normals: (2, 3) unit normals of the faces out of the material.
        planes: Whether either face is plane.
    """

    edge: cq.Edge
    point: np.ndarray
    tangent: np.ndarray
    normals: np.ndarray
    planes: tuple[bool, bool]

    @property
    def is_straight(self) -> bool:
        """Whether it is a straight line."""
        return self.edge.geomType() == "LINE"


def _inner_edges(shape: cq.Shape) -> list[_InnerEdge]:
    """Finds the edges of a solid in which faces meet at an inner corner."""
    from OCP.BRep import BRep_Tool
    from OCP.gp import gp_Pnt, gp_Vec
    from OCP.TopAbs import TopAbs_EDGE, TopAbs_REVERSED
    from OCP.TopExp import TopExp, TopExp_Explorer
    from OCP.TopTools import TopTools_IndexedMapOfShape

    known, faces = TopTools_IndexedMapOfShape(), shape.Faces()
    TopExp.MapShapes_s(shape.wrapped, TopAbs_EDGE, known)
    uses: dict[int, list[tuple[cq.Face, cq.Edge]]] = {}
    for face in faces:
        explorer = TopExp_Explorer(face.wrapped, TopAbs_EDGE)  # gives edges as they go round this face
        while explorer.More():
            uses.setdefault(known.FindIndex(explorer.Current()), []).append((face, cq.Edge(explorer.Current())))
            explorer.Next()
    found = []
    for (one, edge), *others in uses.values():
        if len(others) != 1 or others[0][0] is one or BRep_Tool.Degenerated_s(edge.wrapped):
            continue
        curve, point, along = edge._geomAdaptor(), gp_Pnt(), gp_Vec()
        curve.D1((curve.FirstParameter() + curve.LastParameter()) / 2.0, point, along)
        tangent = np.array([along.X(), along.Y(), along.Z()]) / along.Magnitude()
        if edge.wrapped.Orientation() == TopAbs_REVERSED:
            tangent = -tangent
        middle = cq.Vector(point)
        normals = np.array([face.normalAt(middle).toTuple() for face in (one, others[0][0])])
        across = cross(normals[0], normals[1])
        # the first face lies to the left of its edge, seen along it from outside
        if np.linalg.norm(across) >= _LEAST_SINE and cross(normals[0], tangent) @ normals[1] > 0.0:
            planes = one.geomType() == "PLANE", others[0][0].geomType() == "PLANE"
            found.append(_InnerEdge(edge, np.array(middle.toTuple()), tangent, normals, planes))
    return found


def round_inside(
    part: str, solid: cq.Shape, along: Sequence[float], kept: Callable[[np.ndarray], bool] = lambda _: True
) -> cq.Shape:
    """Rounds the inner corners that lie along a milling axis, as a cutter leaves them: the widest that the kernel can.

    Args:
        part: Part number, for the error.
        solid: Body before its bores are cut.
        along: Unit vector of the axis.
        kept: Whether a corner there, its middle (3,), stays sharp if a cutter makes it so from a side.

    Returns:
        The body; a corner that no radius goes into stays sharp.
    """
    axis = np.array(along, dtype=float)

    def sharp(shape: cq.Shape) -> list[_InnerEdge]:
        found = [corner for corner, ways in corner_ways(shape) if not (ways and kept(corner.point))]
        return [e for e in found if e.is_straight and abs(e.tangent @ axis) > 1.0 - _SHORT_MM]

    def rounded(shape: cq.Shape, corners: list[_InnerEdge], radius: float) -> cq.Shape | None:
        try:
            found = shape.fillet(radius, [corner.edge for corner in corners])  # type: ignore[attr-defined]
        except Exception:  # the kernel's own: it says no more than that it did not do it
            return None
        return found if found.isValid() else None

    def build() -> cq.Shape:
        corners, shape = sharp(solid), solid
        whole = rounded(solid, corners, CORNERS_MM[0]) if corners else solid
        if whole is not None:
            return whole
        for point in [corner.point for corner in corners]:
            left = [corner for corner in sharp(shape) if np.linalg.norm(corner.point - point) < THROUGH_MM]
            tried = (rounded(shape, left, radius) for radius in CORNERS_MM if left)
            shape = next((found for found in tried if found is not None), shape)
        return shape

    return feature(part, "inner corners", "outline", build)


def _left_mm(corner: _InnerEdge) -> float:
    """What the roundest cutter leaves in a corner between two walls, from the corner to the rounding, mm."""
    between = acos(min(max(float(corner.normals[0] @ corner.normals[1]), -1.0), 1.0))
    return CORNERS_MM[0] * (1.0 / max(cos(between / 2.0), _SHORT_MM) - 1.0)


@memoize
def corner_ways(shape: cq.Shape) -> list[tuple[_InnerEdge, list[np.ndarray]]]:
    """Finds the inner edges of a solid, each with the (3,) directions from which a flat end mill makes it sharp.

    One of its faces is then a floor, which is plane, the other a wall upright on it or leaning outwards; a cutter comes
    there where a line off the floor, beside the wall, leaves the part. Corners so open, or so short, that a cutter
    leaves next to nothing in them are left out.
    """
    from OCP.gp import gp_Dir, gp_Lin, gp_Pnt
    from OCP.IntCurvesFace import IntCurvesFace_ShapeIntersector

    lines = IntCurvesFace_ShapeIntersector()
    lines.Load(shape.wrapped, 1e-6)

    def reached(corner: _InnerEdge, floor: int) -> bool:
        up, wall = corner.normals[floor], corner.normals[1 - floor]
        if not corner.planes[floor] or up @ wall < -_SHORT_MM:
            return False
        off = wall - (wall @ up) * up
        start = corner.point + _NEXT_TO_MM * off / np.linalg.norm(off) + _SHIFT_MM * up
        lines.Perform(gp_Lin(gp_Pnt(*start.tolist()), gp_Dir(*up.tolist())), 0.0, _FAR_MM)
        return lines.NbPnt() == 0

    sharp = (e for e in _inner_edges(shape) if _left_mm(e) > _LEFT_MM and e.edge.Length() > _LEFT_MM)  # type: ignore[attr-defined]
    return [(corner, [corner.normals[k] for k in (0, 1) if reached(corner, k)]) for corner in sharp]


def closed_corners(shape: cq.Shape) -> list[_InnerEdge]:
    """Finds the inner edges that no flat end mill makes, from wherever it comes."""
    return [corner for corner, ways in corner_ways(shape) if not ways]


def arcs_about_y(
    radius: float, middle: tuple[float, float], ends: tuple[float, float], y: float, climb: float
) -> list[list[np.ndarray]]:
    """Arcs of a cable's middle round an axis along y through (x, z), along a helix, as `swept_round` takes them.

    Args:
        radius: From the axis to the cable's middle.
        middle: (x, z) of the axis.
        ends: First and last polar angle.
        y: Coordinate at the first.
        climb: Way along y per length of cable.
    """
    first, last = ends
    longest = _ARC_RAD if abs(climb) <= _STEEP else _KINK / abs(climb)
    angles = np.linspace(first, last, 2 * ceil(abs(last - first) / longest) + 1)
    along = y + climb * radius * np.abs(angles - first)
    points = np.column_stack([middle[0] + radius * np.cos(angles), along, middle[1] + radius * np.sin(angles)])
    return [list(points[k : k + 3]) for k in range(0, len(points) - 1, 2)]
