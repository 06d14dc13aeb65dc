"""Simple bodies that enclose the swept volume of a moving part, so that one test covers all positions.

A convex function of a point, such as a height along a direction or the distance from an axis, has no largest value
inside a segment. Planes, cylinders and cones are ruled, so on such a face it is largest on the boundary: on lines at
their ends, on arcs at the corners of a polygon about them, on a free curve at its poles, whose hull holds it. All
other faces count with the ball, the ring of balls or the box that holds them. So nothing here is sampled, and faces
that touch by design, a shaft in its bore or a foot on its plate, have their exact radius and height, to the kernel's
own tolerances.
"""

# pyright: reportAttributeAccessIssue=false
# OCP builds its modules at run time, so a type checker does not see their names

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import pairwise, product
from typing import Any

import numpy as np

from delta_cad.assembly.faces import array_of
from delta_cad.checks.contact.placing import located
from delta_cad.checks.contact.shared_volume import common_size, solid_volume, volume
from delta_cad.common.memoize import cached, memoize
from delta_cad.common.vectors import cross_length
from delta_cad.solids.part import solid_digest

_ARC_RAD = np.radians(15.0)  # of the polygon about an arc: its corners are 0.9 % of the radius too far out
_SAME_AXIS_MM, PARALLEL = 1e-6, 1e-9  # of an arc about an axis: 1e-7 mm over 100 mm
_ROUNDING_RAD = 1e-9
_THIN_MM = 1e-7  # discs that are thinner are left out: 3e-4 mm^3 of 30 mm radius
Span = tuple[float, float]
_Disc = tuple[float, float, float]
"""Lowest and highest place along an axis, and the radius, mm."""


@dataclass(frozen=True, eq=False)
class _HoldingArc:
    """A circular edge, or the ring of a round face: (3,) centre and axis, radius, and the polygon (n, 3) about it."""

    centre: np.ndarray
    axis: np.ndarray
    radius_mm: float
    corners: np.ndarray
    stray_mm: float = 0.0


@dataclass(eq=False)
class _Face:
    """What holds a face: points, with the radius of the ball about each, and arcs."""

    points: list[tuple[float, float, float]] = field(default_factory=list)
    strays: list[float] = field(default_factory=list)
    arcs: list[_HoldingArc] = field(default_factory=list)

    def add(self, point: Any, stray_mm: float = 0.0) -> None:
        """Adds a point of the kernel."""
        self.points.append((point.X(), point.Y(), point.Z()))
        self.strays.append(stray_mm)


class SolidExtents:
    """The points and arcs that decide how far a solid reaches in any direction.

    Args:
        solid: The `cadquery.Solid`.
    """

    def __init__(self, solid: Any) -> None:
        self._faces = [(np.array(f.points).reshape(-1, 3), np.array(f.strays), f.arcs) for f in _faces(solid)]
        of = [(points, strays) for points, strays, _ in self._faces]
        of += [(a.corners, np.full(len(a.corners), a.stray_mm)) for *_, arcs in self._faces for a in arcs]
        self._points = np.concatenate([points for points, _ in of])
        self._strays = np.concatenate([strays for _, strays in of])

    def extents(self, axes: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Bounds how far the solid reaches along unit directions (k, 3): lowest and highest place, (k,) each, mm."""
        heights = self._points @ axes.T
        return (heights - self._strays[:, None]).min(axis=0), (heights + self._strays[:, None]).max(axis=0)

    def discs(self, frame: np.ndarray, slides_mm: Span = (0.0, 0.0), within_rad: Span | None = None) -> list[_Disc]:
        """Discs about the y axis of a frame that hold the solid however it is turned about it.

        A ray from a point of the solid straight out of the axis leaves the solid through a face, which is at the
        point's place along the axis and at its angle about it: no point is farther out than the faces there.

        Args:
            frame: (4, 4) frame in the solid's own, mm.
            slides_mm: How far the solid is also moved along the axis, from where to where.
            within_rad: Angles about the axis, from where to where, from z towards x, in which it has to be held alone.

        Returns:
            The discs, ascending along the axis and side by side; those of equal radius made one.
        """
        bounds = np.array([r for face in self._faces if (r := _bounds(*face, frame, within_rad)) is not None])
        if not len(bounds):
            return []
        bounds[:, :2] += slides_mm
        levels = np.unique(np.round(bounds[:, :2], 9))
        found: list[_Disc] = []
        for low, high in zip(levels[:-1].tolist(), levels[1:].tolist(), strict=True):
            there = bounds[(bounds[:, 0] < (low + high) / 2.0) & (bounds[:, 1] > (low + high) / 2.0), 2]
            if high - low <= _THIN_MM or not len(there):
                continue
            radius = float(there.max())
            if found and abs(found[-1][2] - radius) <= _THIN_MM and low - found[-1][1] <= _THIN_MM:
                found[-1] = (found[-1][0], high, max(radius, found[-1][2]))
            else:
                found.append((low, high, radius))
        return found

    def angles(self, frame: np.ndarray) -> Span | None:
        """Angles about the y axis of a frame, from z towards x, between which the solid lies, rad; None: all round."""
        of = [_seen(*face, frame) for face in self._faces]
        return _between(*(np.concatenate([x[k] for x in of]) for k in range(3)))


def _seen(points: np.ndarray, strays: np.ndarray, arcs: list[_HoldingArc], frame: np.ndarray) -> tuple[np.ndarray, ...]:
    """Places along y, radii and angles about it, radii of the balls about the points that hold a face in a frame."""
    at = [points, *(arc.corners for arc in arcs)]
    seen = [(x - frame[:3, 3]) @ frame[:3, :3] for x in at]
    radii = [np.hypot(x[:, 0], x[:, 2]) for x in seen]
    for k, arc in enumerate(arcs, 1):
        x, _, z = (arc.centre - frame[:3, 3]) @ frame[:3, :3]
        if np.hypot(x, z) < _SAME_AXIS_MM and cross_length(arc.axis, frame[:3, 1]) < PARALLEL:
            radii[k] = np.full(len(arc.corners), arc.radius_mm)
    stray = np.concatenate([strays, *(np.full(len(arc.corners), arc.stray_mm) for arc in arcs)])
    whole = np.concatenate(seen)
    return np.concatenate(radii), np.arctan2(whole[:, 0], whole[:, 2]), stray, whole[:, 1]


def _bounds(
    points: np.ndarray, strays: np.ndarray, arcs: list[_HoldingArc], frame: np.ndarray, within_rad: Span | None
) -> tuple[float, float, float] | None:
    """Lowest and highest place of a face along y, and its largest distance from it, mm; None: not at those angles."""
    radius, angle, stray, place = _seen(points, strays, arcs, frame)
    if within_rad is not None and (there := _between(radius, angle, stray)) is not None:
        ahead = (there[0] - within_rad[0]) % (2.0 * np.pi)  # how far the face begins behind the range's beginning
        if ahead > within_rad[1] - within_rad[0] and ahead + there[1] - there[0] < 2.0 * np.pi:
            return None
    return float((place - stray).min()), float((place + stray).max()), float((radius + stray).max())


def _between(radius: np.ndarray, angle: np.ndarray, stray: np.ndarray) -> Span | None:
    """Angles between which balls lie about an axis, less than half a turn apart, rad; None where they do not.

    The room between two such half planes is convex: it holds what the balls hold.
    """
    if (radius <= stray + _SAME_AXIS_MM).any():
        return None
    order, aside = np.sort(angle), float(np.arcsin(np.max(stray / radius))) + _ROUNDING_RAD
    gaps = np.diff(order, append=order[0] + 2.0 * np.pi)
    k = int(gaps.argmax())
    start, width = float(order[(k + 1) % len(order)]) - aside, float(2.0 * np.pi - gaps[k]) + 2.0 * aside
    return (start, start + width) if width < np.pi else None


@memoize
def solid_extents(solid: Any) -> SolidExtents:
    """Extents of a solid, read once."""
    return SolidExtents(solid)


def common_with_discs(
    discs: list[_Disc], frame: np.ndarray, solid: Any, placement: np.ndarray, noise_mm3: float
) -> float | None:
    """Volume that a solid, placed by a (4, 4) frame, shares with discs about the y axis of another, mm^3.

    None where the discs are no solid, or the kernel contradicts itself.
    """

    def compute() -> float | None:
        if (holder := turned_solid(discs, frame)) is None:
            return None
        sizes = volume(holder), solid_volume(solid)
        return common_size((holder, located(solid, placement)), sizes, volume, noise_mm3)

    return cached("common with discs", (discs, frame, solid_digest(solid), placement, noise_mm3), compute)


def turned_solid(discs: list[_Disc], frame: np.ndarray) -> Any:
    """The kernel's solid of discs about the y axis of a frame; None where there is none, or they do not hang together.

    Args:
        discs: As `SolidExtents.discs` gives them.
        frame: (4, 4) frame, mm.
    """
    from OCP.BRepBuilderAPI import BRepBuilderAPI_MakeFace, BRepBuilderAPI_MakePolygon
    from OCP.BRepPrimAPI import BRepPrimAPI_MakeRevol
    from OCP.gp import gp_Ax1, gp_Dir, gp_Pnt

    if not discs or any(b[0] - a[1] > _THIN_MM for a, b in pairwise(discs)):
        return None
    aside, axis, _, origin_mm = frame[:3].T
    corners = [(discs[0][0], 0.0)]
    for low, high, radius in discs:
        corners += [(low, radius), (high, radius)]
    corners.append((discs[-1][1], 0.0))
    polygon = BRepBuilderAPI_MakePolygon()
    for along, out in corners:
        polygon.Add(gp_Pnt(*(origin_mm + along * axis + out * aside).tolist()))
    polygon.Close()
    face = BRepBuilderAPI_MakeFace(polygon.Wire())
    return BRepPrimAPI_MakeRevol(face.Face(), gp_Ax1(gp_Pnt(*origin_mm.tolist()), gp_Dir(*axis.tolist()))).Shape()


def _faces(solid: Any) -> Iterator[_Face]:
    """What holds each face of a solid."""
    from OCP.BRepAdaptor import BRepAdaptor_Surface
    from OCP.GeomAbs import GeomAbs_Cone, GeomAbs_Cylinder, GeomAbs_Plane, GeomAbs_Sphere, GeomAbs_Torus

    for one in solid.Faces():
        surface, face = BRepAdaptor_Surface(one.wrapped), _Face()
        kind = surface.GetType()
        if kind in (GeomAbs_Plane, GeomAbs_Cylinder, GeomAbs_Cone):
            _add_boundary(face, one.wrapped)
        elif kind == GeomAbs_Sphere:
            face.add(surface.Sphere().Location(), float(surface.Sphere().Radius()))
        elif kind == GeomAbs_Torus:
            torus = surface.Torus()
            ring = _polygon(torus.Position(), float(torus.MajorRadius()), 0.0, 2.0 * np.pi)
            axis, radius = array_of(torus.Axis().Direction()), float(torus.MajorRadius())
            face.arcs.append(_HoldingArc(array_of(torus.Location()), axis, radius, ring, float(torus.MinorRadius())))
        else:
            _add_box(face, one.wrapped)
        yield face


def _add_boundary(face: _Face, shape: Any) -> None:
    """Adds the corners of a ruled face and what holds its edges."""
    from OCP.BRep import BRep_Tool
    from OCP.BRepAdaptor import BRepAdaptor_Curve
    from OCP.GeomAbs import GeomAbs_BezierCurve, GeomAbs_BSplineCurve, GeomAbs_Circle, GeomAbs_Line
    from OCP.TopAbs import TopAbs_EDGE, TopAbs_VERTEX
    from OCP.TopExp import TopExp_Explorer
    from OCP.TopoDS import TopoDS

    corners = TopExp_Explorer(shape, TopAbs_VERTEX)
    while corners.More():
        face.add(BRep_Tool.Pnt_s(TopoDS.Vertex_s(corners.Current())))
        corners.Next()
    edges = TopExp_Explorer(shape, TopAbs_EDGE)
    while edges.More():
        edge = TopoDS.Edge_s(edges.Current())
        edges.Next()
        if BRep_Tool.Degenerated_s(edge):
            continue
        curve = BRepAdaptor_Curve(edge)
        kind = curve.GetType()
        if kind == GeomAbs_Circle:
            circle = curve.Circle()
            radius, ends = float(circle.Radius()), (curve.FirstParameter(), curve.LastParameter())
            corners_of = _polygon(circle.Position(), radius, *ends)
            face.arcs.append(
                _HoldingArc(array_of(circle.Location()), array_of(circle.Axis().Direction()), radius, corners_of)
            )
        elif kind in (GeomAbs_BSplineCurve, GeomAbs_BezierCurve):
            free = curve.BSpline() if kind == GeomAbs_BSplineCurve else curve.Bezier()
            for k in range(1, free.NbPoles() + 1):
                face.add(free.Pole(k))
        elif kind != GeomAbs_Line:
            _add_box(face, edge)


def _polygon(position: Any, radius_mm: float, first: float, last: float) -> np.ndarray:
    """(n, 3) corners of a polygon about an arc of a circle, between two angles in its own plane."""
    count = max(int(np.ceil((last - first) / _ARC_RAD)), 1)
    step = (last - first) / count
    angles = np.concatenate([[first, last], first + (np.arange(count) + 0.5) * step])
    out = np.concatenate([[radius_mm] * 2, np.full(count, radius_mm / np.cos(step / 2.0))])
    x, y = array_of(position.XDirection()), array_of(position.YDirection())
    return array_of(position.Location()) + (out * np.cos(angles))[:, None] * x + (out * np.sin(angles))[:, None] * y


def _add_box(face: _Face, shape: Any) -> None:
    """Adds the corners of the kernel's box about a face or an edge, which holds it."""
    from OCP.Bnd import Bnd_Box
    from OCP.BRepBndLib import BRepBndLib

    box = Bnd_Box()
    BRepBndLib.Add_s(shape, box, False)
    low, high = box.CornerMin(), box.CornerMax()
    for corner in product(*zip((low.X(), low.Y(), low.Z()), (high.X(), high.Y(), high.Z()), strict=True)):
        face.points.append(corner)
        face.strays.append(0.0)
