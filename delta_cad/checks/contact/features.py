"""Cylinders, spheres, planes, cones and tori of parts: what seats, threads and joint axes are made of."""

# pyright: reportAttributeAccessIssue=false
# OCP builds its modules at run time, so a type checker does not see their names

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from delta_cad.assembly.faces import SolidFace, array_of, solid_faces
from delta_cad.common.memoize import memoize
from delta_cad.solids.part import Part

if TYPE_CHECKING:
    import cadquery as cq

_SAME_AXIS_MM = 1e-6  # faces of one turned or bored surface share their axis to roundings


@dataclass(frozen=True, eq=False)
class Features:
    """Faces of a part by which it holds or is held, by kind, in the part's frame."""

    cylinders: tuple[SolidFace, ...]
    spheres: tuple[SolidFace, ...]
    planes: tuple[SolidFace, ...]
    cones: tuple[SolidFace, ...]
    tori: tuple[SolidFace, ...]

    @property
    def balls(self) -> np.ndarray:
        """(n, 3) centres of the spherical faces, mm."""
        return np.array([s.point for s in self.spheres], dtype=float).reshape(-1, 3)


@memoize
def features(solid: cq.Shape) -> Features:
    """Sorts the faces of a part by their kinds."""
    faces = solid_faces(solid)
    kinds = ("cylinder", "sphere", "plane", "cone", "torus")
    return Features(*(tuple(face for face in faces if face.kind == kind) for kind in kinds))


def off_axis(cylinder: SolidFace, frame: np.ndarray, lever_mm: float) -> float:
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
    from OCP.BRepAdaptor import BRepAdaptor_Curve
    from OCP.GeomAbs import GeomAbs_Circle

    origin, y = frame[:3, 3], frame[:3, 1]

    def on_axis(point: np.ndarray) -> bool:
        apart = point - origin
        return float(np.linalg.norm(apart - (apart @ y) * y)) < _SAME_AXIS_MM

    def along(direction: np.ndarray) -> bool:
        return float(np.linalg.norm(np.cross(direction, y))) < 1e-9  # 1e-7 mm over 100 mm

    for face in solid_faces(part.solid):
        if face.kind == "other" or (face.kind != "sphere" and not along(face.direction)):
            return False
        if face.kind != "plane" and not on_axis(face.point):
            return False
        for edge in face.face.Edges():
            if BRep_Tool.Degenerated_s(edge.wrapped) or BRep_Tool.IsClosed_s(edge.wrapped, face.face.wrapped):
                continue
            curve = BRepAdaptor_Curve(edge.wrapped)
            if curve.GetType() != GeomAbs_Circle or not curve.IsClosed():
                return False
            circle = curve.Circle()
            if not (on_axis(array_of(circle.Location())) and along(array_of(circle.Axis().Direction()))):
                return False
    return True
