"""Axes and centres read off solids: what a coordinate measuring machine would find, not what the dimensions say."""

# pyright: reportAttributeAccessIssue=false
# The stubs of the kernel's binding declare none of its classes.

from __future__ import annotations

from typing import Any

import cadquery as cq
import numpy as np
from OCP.BRepAdaptor import BRepAdaptor_Surface
from OCP.GeomAbs import GeomAbs_Cylinder, GeomAbs_Sphere
from OCP.gp import gp_Trsf
from OCP.TopAbs import TopAbs_REVERSED
from OCP.TopLoc import TopLoc_Location

from delta_cad.assembly.machine import Assembly
from delta_cad.solids.part import Occurrence, Part

UM = 1e-3  # one micrometre in mm: what issue 2 promises
EXACT_MM = 1e-9  # rounding of doubles through transforms of a few hundred mm


def part(assembly: Assembly, number: str) -> Part:
    (found,) = [p for p in assembly.parts if p.number == number]
    return found


def occurrence(assembly: Assembly, name: str) -> Occurrence:
    (found,) = [o for o in assembly.occurrences if o.name == name]
    return found


def placed(solid: cq.Shape, frame: np.ndarray) -> cq.Shape:
    """A solid moved by a (4, 4) rigid transform."""
    move = gp_Trsf()
    move.SetValues(*(float(v) for v in frame[:3].ravel()))
    return solid.moved(cq.Location(TopLoc_Location(move)))


def cylinders(shape: Any, diameter: float, *, concave: bool | None = None) -> list[tuple[np.ndarray, np.ndarray]]:
    """(point, unit direction) of each distinct axis of cylindrical faces of a diameter; the point is nearest to 0."""
    found: list[tuple[np.ndarray, np.ndarray]] = []
    for face in shape.Faces():
        surface = BRepAdaptor_Surface(face.wrapped)
        if surface.GetType() != GeomAbs_Cylinder or abs(2 * surface.Cylinder().Radius() - diameter) > 1e-6:
            continue
        cylinder = surface.Cylinder()
        hollow = cylinder.Position().Direct() == (face.wrapped.Orientation() == TopAbs_REVERSED)
        if concave is not None and hollow != concave:
            continue
        d, p = cylinder.Axis().Direction(), cylinder.Axis().Location()
        direction, point = np.array([d.X(), d.Y(), d.Z()]), np.array([p.X(), p.Y(), p.Z()])
        point = point - (point @ direction) * direction
        if not any(
            np.linalg.norm(np.cross(direction, e)) < 1e-9 and np.linalg.norm(point - q) < 1e-6 for q, e in found
        ):
            found.append((point, direction))
    return found


def spheres(shape: Any, diameter: float) -> list[np.ndarray]:
    """Centres of the distinct spheres of a diameter among a shape's faces."""
    found: list[np.ndarray] = []
    for face in shape.Faces():
        surface = BRepAdaptor_Surface(face.wrapped)
        if surface.GetType() != GeomAbs_Sphere or abs(2 * surface.Sphere().Radius() - diameter) > 1e-6:
            continue
        at = surface.Sphere().Location()
        centre = np.array([at.X(), at.Y(), at.Z()])
        if not any(np.linalg.norm(centre - other) < 1e-6 for other in found):
            found.append(centre)
    return found


def one_axis(shape: Any, diameter: float, *, concave: bool | None = None) -> tuple[np.ndarray, np.ndarray]:
    """The only axis of cylinders of a diameter."""
    (axis,) = cylinders(shape, diameter, concave=concave)
    return axis


def axis_distance(a: tuple[np.ndarray, np.ndarray], b: tuple[np.ndarray, np.ndarray]) -> tuple[float, float]:
    """Distance of two nearly parallel axes, and the sine of the angle between them."""
    (p, d), (q, e) = a, b
    return float(np.linalg.norm(np.cross(q - p, d))), float(np.linalg.norm(np.cross(d, e)))
