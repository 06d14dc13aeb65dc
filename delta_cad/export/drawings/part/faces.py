"""The faces of a solid as a draughtsman reads them: kind, axis, radius, where they reach, and what they border on."""

# pyright: reportAttributeAccessIssue=false
# OCP builds its modules at run time, so a type checker does not see their names

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from delta_cad.assembly.faces import array_of, solid_face
from delta_cad.common.vectors import cross_length

_SHARES = [k / 8 for k in range(9)]  # of an edge's length at which its points are read
_ALONG = 1e-6  # sine of an angle below which two directions are one


@dataclass(eq=False)
class Face:
    """One face.

    Attributes:
        kind: "plane", "cylinder", "cone", "sphere", "torus" or "other".
        point: (3,) a point of it, or of its axis, or its centre, mm.
        axis: (3,) unit normal out of the material, or its axis.
        radius: Radius, of a torus the small one, of a cone that at `point`; 0 of a plane, mm.
        hollow: Whether the material lies around it.
        turn: Angle that it spans about its axis, rad.
        half_angle: Of a cone, rad.
        area: Its area, mm^2.
        centre: (3,) centre of its area, mm.
        box: (2, 3) what it reaches, lowest and highest, mm.
        corners: (n, 3) ends of its edges and points between, mm.
        borders: Faces on the other side of its edges, each with (m, 3) points of the edge.
    """

    kind: str
    point: np.ndarray
    axis: np.ndarray
    radius: float
    hollow: bool
    turn: float
    half_angle: float
    area: float
    centre: np.ndarray
    box: np.ndarray
    corners: np.ndarray
    borders: list[tuple[Face, np.ndarray]] = field(default_factory=list, repr=False)

    @property
    def middle(self) -> np.ndarray:
        """(3,) middle of what it reaches."""
        return self.box.mean(axis=0)

    def reach(self, along: np.ndarray) -> tuple[float, float]:
        """Gives how far it goes along a direction, mm."""
        values = self.corners @ along
        return float(values.min()), float(values.max())

    def off_axis(self, points: np.ndarray) -> float:
        """Gives how far the farthest of (n, 3) points is off its axis, mm."""
        apart = points - self.point
        return float(np.linalg.norm(apart - np.outer(apart @ self.axis, self.axis), axis=1).max())


def is_along(a: np.ndarray, b: np.ndarray) -> bool:
    """Decides whether two unit vectors are parallel, either way."""
    return cross_length(a, b) < _ALONG


def is_across(a: np.ndarray, b: np.ndarray) -> bool:
    """Decides whether two unit vectors are perpendicular."""
    return abs(float(a @ b)) < _ALONG


def is_straight(a: np.ndarray) -> bool:
    """Decides whether a unit vector is parallel to an axis of the part's frame."""
    return float(np.linalg.norm(np.sort(np.abs(a))[:2])) < _ALONG


def faces_of(solid: Any) -> list[Face]:
    """Reads all faces of a `cadquery.Solid`."""
    read, by_edge = [], {}
    for face in solid.Faces():
        edges = [(edge.hashCode(), _along(edge)) for edge in face.Edges()]
        one = _read(face, np.concatenate([np.zeros((0, 3)), *(points for _, points in edges)]))
        read.append(one)
        for edge, points in edges:
            by_edge.setdefault(edge, []).append((one, points[::2]))
    for pairs in by_edge.values():
        for one, points in pairs:
            one.borders += [(other, points) for other, _ in pairs if other is not one]
    return read


def _along(edge: Any) -> np.ndarray:
    """(9, 3) points of an edge, evenly spread over its length, mm."""
    from OCP.BRepAdaptor import BRepAdaptor_Curve
    from OCP.GCPnts import GCPnts_AbscissaPoint
    from OCP.GeomAbs import GeomAbs_Circle, GeomAbs_Line

    curve = BRepAdaptor_Curve(edge.wrapped)
    first, last = curve.FirstParameter(), curve.LastParameter()
    if curve.GetType() in (GeomAbs_Line, GeomAbs_Circle):  # the parameter goes with the length
        at = [first + share * (last - first) for share in _SHARES]
    else:
        length = GCPnts_AbscissaPoint.Length_s(curve)
        at = [GCPnts_AbscissaPoint(curve, length * share, first).Parameter() for share in _SHARES]
    return np.array([array_of(curve.Value(u)) for u in at])


def _box(face: Any) -> np.ndarray:
    """(2, 3) lower and upper corner of a face, mm, by its surface: a mesh that it may carry reaches less far."""
    from OCP.Bnd import Bnd_Box
    from OCP.BRepBndLib import BRepBndLib

    bounds = Bnd_Box()
    BRepBndLib.AddOptimal_s(face.wrapped, bounds, False)  # useTriangulation
    return np.array(bounds.Get()).reshape(2, 3)


def _read(face: Any, corners: np.ndarray) -> Face:
    one, box = solid_face(face), _box(face)
    point = box.mean(axis=0) if one.kind == "other" else one.point
    read = one.direction, one.radius_mm, one.is_hollow, one.turn_rad, one.half_angle_rad, one.area_mm2, one.centre
    return Face(one.kind, point, *read, box, corners)
