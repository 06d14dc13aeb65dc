"""Cylinders, spheres and planes of parts, read off their solids: what seats, threads and joint axes are made of."""

# pyright: reportAttributeAccessIssue=false
# OCP builds its modules at run time, so a type checker does not see their names

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from delta_cad.common.memoize import memoize
from delta_cad.solids.part import Part

if TYPE_CHECKING:
    import cadquery as cq

SAME_AXIS_MM = 1e-6  # faces of one turned or bored surface share their axis to roundings


@dataclass(frozen=True, eq=False)
class Cylinder:
    """A cylindrical face.

    Attributes:
        point: (3,) a point of the axis, mm.
        direction: (3,) unit vector along the axis.
        radius_mm: Radius.
        start_mm: Where the face begins along the direction, from the point.
        end_mm: Where it ends.
        is_bore: Whether the material is outside.
        turn_rad: Angle that the face spans about the axis.
        first: (3,) unit vector from the axis to where the face begins.
    """

    point: np.ndarray
    direction: np.ndarray
    radius_mm: float
    start_mm: float
    end_mm: float
    is_bore: bool
    turn_rad: float
    first: np.ndarray

    def moved(self, frame: np.ndarray) -> Cylinder:
        """The cylinder seen from the frame into which `frame` (4, 4) takes it."""
        turn, shift = frame[:3, :3], frame[:3, 3]
        return replace(self, point=turn @ self.point + shift, direction=turn @ self.direction, first=turn @ self.first)


@dataclass(frozen=True, eq=False)
class Sphere:
    """A spherical face: (3,) centre and radius, mm, area, mm^2, and whether the material is outside."""

    centre: np.ndarray
    radius_mm: float
    area_mm2: float
    is_seat: bool


@dataclass(frozen=True, eq=False)
class Plane:
    """A plane face: (3,) a point of it, mm, (3,) unit normal out of the material, and the kernel's face."""

    point: np.ndarray
    normal: np.ndarray
    face: cq.Face

    @property
    def centre(self) -> np.ndarray:
        """(3,) middle of the face, mm."""
        return np.array(self.face.Center().toTuple())

    @property
    def area_mm2(self) -> float:
        """Area of the face."""
        return float(self.face.Area())


@dataclass(frozen=True, eq=False)
class Arc:
    """A round face of a cable or ring, part of a torus: radii in mm, the rest as for a `Cylinder`."""

    centre: np.ndarray
    direction: np.ndarray
    ring_mm: float
    radius_mm: float
    turn_rad: float
    first: np.ndarray


@dataclass(frozen=True, eq=False)
class Features:
    """Faces of a part by which it holds or is held, in the part's frame."""

    cylinders: tuple[Cylinder, ...]
    spheres: tuple[Sphere, ...]
    planes: tuple[Plane, ...]
    arcs: tuple[Arc, ...]

    @property
    def balls(self) -> np.ndarray:
        """(n, 3) centres of the spherical faces, mm."""
        return np.array([s.centre for s in self.spheres], dtype=float).reshape(-1, 3)


class FeatureLibrary:
    """Features of parts, each read once."""

    def __init__(self) -> None:
        self._known: dict[int, tuple[Part, Features]] = {}  # the part is kept, so that its identity is

    def __getitem__(self, part: Part) -> Features:
        """The features of a part."""
        if id(part) not in self._known:
            self._known[id(part)] = (part, features(part.solid))
        return self._known[id(part)][1]


@memoize
def features(solid: cq.Shape) -> Features:
    """Reads the faces of a part by their kinds."""
    from OCP.BRepAdaptor import BRepAdaptor_Surface
    from OCP.GeomAbs import GeomAbs_Cylinder, GeomAbs_Plane, GeomAbs_Sphere, GeomAbs_Torus
    from OCP.TopAbs import TopAbs_REVERSED

    cylinders, spheres, planes, arcs = [], [], [], []
    for face in solid.Faces():
        surface = BRepAdaptor_Surface(face.wrapped)
        kind = surface.GetType()
        is_reversed = face.wrapped.Orientation() == TopAbs_REVERSED
        if kind == GeomAbs_Cylinder:
            shape = surface.Cylinder()
            # the parameter along the axis counts from the cylinder's own origin, along its own z
            ends = float(surface.FirstVParameter()), float(surface.LastVParameter())
            axis = _array(shape.Axis().Location()), _array(shape.Axis().Direction())
            is_bore = shape.Position().Direct() == is_reversed
            cylinders.append(Cylinder(*axis, float(shape.Radius()), *ends, is_bore, *_turn(surface, shape)))
        elif kind == GeomAbs_Sphere:
            shape = surface.Sphere()
            is_seat = shape.Position().Direct() == is_reversed
            spheres.append(Sphere(_array(shape.Location()), float(shape.Radius()), float(face.Area()), is_seat))
        elif kind == GeomAbs_Plane:
            shape = surface.Plane()
            sense = 1.0 if shape.Position().Direct() != is_reversed else -1.0
            planes.append(Plane(_array(shape.Location()), sense * _array(shape.Axis().Direction()), face))
        elif kind == GeomAbs_Torus:
            shape = surface.Torus()
            axis = _array(shape.Axis().Location()), _array(shape.Axis().Direction())
            radii = float(shape.MajorRadius()), float(shape.MinorRadius())
            arcs.append(Arc(*axis, *radii, *_turn(surface, shape)))
    return Features(tuple(cylinders), tuple(spheres), tuple(planes), tuple(arcs))


def _turn(surface: object, shape: object) -> tuple[float, np.ndarray]:
    """Angle that a face of revolution spans, and (3,) unit vector from the axis to where it begins."""
    first, last = surface.FirstUParameter(), surface.LastUParameter()  # type: ignore[attr-defined]
    position = shape.Position()  # type: ignore[attr-defined]
    x, y = _array(position.XDirection()), _array(position.YDirection())
    return float(last - first), np.cos(first) * x + np.sin(first) * y


def off_axis(cylinder: Cylinder, frame: np.ndarray, lever_mm: float) -> float:
    """Measures how far a cylinder's axis strays from the y axis of a frame.

    Args:
        cylinder: The cylinder, in the frame's parent.
        frame: (4, 4) frame.
        lever_mm: Length over which an angle between the two axes counts.

    Returns:
        The larger of the distance at the frame's origin and the stray over the lever, mm.
    """
    y = frame[:3, 1]
    across = float(np.linalg.norm(np.cross(cylinder.direction, y)))
    apart = frame[:3, 3] - cylinder.point
    apart = apart - (apart @ cylinder.direction) * cylinder.direction
    return max(float(np.linalg.norm(apart)), across * lever_mm)


def is_turned(part: Part, frame: np.ndarray) -> bool:
    """Decides whether a part is a body of revolution about an axis, so that a turn about it changes nothing.

    Args:
        part: The part.
        frame: (4, 4) frame in the part's frame whose y axis is meant, mm.

    Returns:
        True when every face lies on a surface of revolution about the axis, and every edge is a whole circle about it
        or a seam, along which a face meets itself.
    """
    from OCP.BRep import BRep_Tool
    from OCP.BRepAdaptor import BRepAdaptor_Curve, BRepAdaptor_Surface
    from OCP.GeomAbs import GeomAbs_Circle, GeomAbs_Cone, GeomAbs_Cylinder, GeomAbs_Plane, GeomAbs_Sphere, GeomAbs_Torus

    origin, y = frame[:3, 3], frame[:3, 1]

    def on_axis(point: np.ndarray) -> bool:
        apart = point - origin
        return float(np.linalg.norm(apart - (apart @ y) * y)) < SAME_AXIS_MM

    def along(direction: np.ndarray) -> bool:
        return float(np.linalg.norm(np.cross(direction, y))) < 1e-9  # 1e-7 mm over 100 mm

    for face in part.solid.Faces():
        surface = BRepAdaptor_Surface(face.wrapped)
        kind = surface.GetType()
        if kind == GeomAbs_Plane:
            if not along(_array(surface.Plane().Axis().Direction())):
                return False
        elif kind == GeomAbs_Sphere:
            if not on_axis(_array(surface.Sphere().Location())):
                return False
        elif kind in (GeomAbs_Cylinder, GeomAbs_Cone, GeomAbs_Torus):
            named = {GeomAbs_Cylinder: "Cylinder", GeomAbs_Cone: "Cone", GeomAbs_Torus: "Torus"}[kind]
            axis = getattr(surface, named)().Axis()
            if not (on_axis(_array(axis.Location())) and along(_array(axis.Direction()))):
                return False
        else:
            return False
        for edge in face.Edges():
            if BRep_Tool.Degenerated_s(edge.wrapped) or BRep_Tool.IsClosed_s(edge.wrapped, face.wrapped):
                continue
            curve = BRepAdaptor_Curve(edge.wrapped)
            if curve.GetType() != GeomAbs_Circle or not curve.IsClosed():
                return False
            circle = curve.Circle()
            if not (on_axis(_array(circle.Location())) and along(_array(circle.Axis().Direction()))):
                return False
    return True


def _array(triple: object) -> np.ndarray:
    """(3,) coordinates of a point or a direction of the kernel."""
    return np.array([triple.X(), triple.Y(), triple.Z()])  # type: ignore[attr-defined]
