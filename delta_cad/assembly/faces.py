"""Faces of a solid as records: kind of surface, axis, radius, and on which side the material lies."""

# pyright: reportAttributeAccessIssue=false
# OCP builds its modules at run time, so a type checker does not see their names

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from delta_cad.common.memoize import memoize

if TYPE_CHECKING:
    import cadquery as cq


@dataclass(frozen=True, eq=False)
class SolidFace:
    """A face of a solid.

    Attributes:
        kind: "plane", "cylinder", "cone", "sphere", "torus" or "other".
        point: (3,) a point of a plane, of the axis, or the centre of a sphere, mm.
        direction: (3,) unit vector along the axis, of a plane its normal out of the material.
        first: (3,) unit vector from the axis to where the face begins.
        turn_rad: Angle that it spans about the axis.
        start_mm: Where it begins along the direction, from the point; of a cylinder.
        end_mm: Where it ends.
        radius_mm: Of a torus the small one, of a cone that at the point; 0 of a plane.
        ring_mm: Large radius of a torus.
        half_angle_rad: Of a cone.
        is_hollow: Whether the material is outside.
        face: The kernel's.
    """

    kind: str
    point: np.ndarray
    direction: np.ndarray
    first: np.ndarray
    turn_rad: float
    start_mm: float
    end_mm: float
    radius_mm: float
    ring_mm: float
    half_angle_rad: float
    is_hollow: bool
    face: cq.Face

    @property
    def centre(self) -> np.ndarray:
        """(3,) centre of the area, mm."""
        return np.array(self.face.Center().toTuple())

    @property
    def area_mm2(self) -> float:
        """Its area."""
        return float(self.face.Area())

    @property
    def apex(self) -> np.ndarray:
        """(3,) apex of a cone, mm."""
        return self.point - self.radius_mm / np.tan(self.half_angle_rad) * self.direction

    def moved(self, frame: np.ndarray) -> SolidFace:
        """The surface seen from the frame into which `frame` (4, 4) takes it; the kernel's face stays where it is."""
        turn, shift = frame[:3, :3], frame[:3, 3]
        return replace(self, point=turn @ self.point + shift, direction=turn @ self.direction, first=turn @ self.first)


@memoize
def solid_faces(solid: cq.Shape) -> tuple[SolidFace, ...]:
    """Reads all faces of a solid."""
    return tuple(map(solid_face, solid.Faces()))


def solid_face(face: cq.Face) -> SolidFace:
    """Reads one face of a solid."""
    from OCP.BRepAdaptor import BRepAdaptor_Surface
    from OCP.GeomAbs import GeomAbs_Cone, GeomAbs_Cylinder, GeomAbs_Plane, GeomAbs_Sphere, GeomAbs_Torus
    from OCP.TopAbs import TopAbs_REVERSED

    surface = BRepAdaptor_Surface(face.wrapped)
    kinds = {
        GeomAbs_Plane: "Plane",
        GeomAbs_Cylinder: "Cylinder",
        GeomAbs_Cone: "Cone",
        GeomAbs_Sphere: "Sphere",
        GeomAbs_Torus: "Torus",
    }
    kind = kinds.get(surface.GetType(), "Other")
    first, last = float(surface.FirstUParameter()), float(surface.LastUParameter())
    if kind == "Other":
        place, z = np.array(face.Center().toTuple()), np.array([0.0, 0.0, 1.0])
        return SolidFace("other", place, z, z, last - first, 0.0, 0.0, 0.0, 0.0, 0.0, False, face)
    shape = getattr(surface, kind)()
    position = shape.Position()
    is_hollow = position.Direct() == (face.wrapped.Orientation() == TopAbs_REVERSED)
    direction, x, y = (array_of(v) for v in (position.Direction(), position.XDirection(), position.YDirection()))
    radius = {"Plane": lambda: 0.0, "Cone": lambda: shape.RefRadius(), "Torus": lambda: shape.MinorRadius()}
    return SolidFace(
        kind=kind.lower(),
        point=array_of(shape.Location()),
        direction=-direction if kind == "Plane" and is_hollow else direction,
        first=np.cos(first) * x + np.sin(first) * y,
        turn_rad=last - first,
        # the parameter along the axis counts from the cylinder's own origin, along its own z
        start_mm=float(surface.FirstVParameter()),
        end_mm=float(surface.LastVParameter()),
        radius_mm=float(radius.get(kind, lambda: shape.Radius())()),
        ring_mm=float(shape.MajorRadius()) if kind == "Torus" else 0.0,
        half_angle_rad=float(shape.SemiAngle()) if kind == "Cone" else 0.0,
        is_hollow=bool(is_hollow),
        face=face,
    )


def array_of(triple: Any) -> np.ndarray:
    """(3,) coordinates of a point or a direction of the kernel."""
    return np.array([triple.X(), triple.Y(), triple.Z()])
