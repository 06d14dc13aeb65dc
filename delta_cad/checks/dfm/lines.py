"""Lines through a part and points of its faces: what is thick, and what a tool reaches."""

# pyright: reportAttributeAccessIssue=false
# OCP builds its modules at run time, so a type checker does not see their names

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from delta_cad.common.memoize import memoize

GRID = 5  # points along either parameter of a face, those outside it left out
FAR_MM = 1e3  # beyond every part
_OFF_MM = 0.01  # off a face, so that a line does not begin in it


class Lines:
    """Lines that are shot through one solid."""

    def __init__(self, solid: Any) -> None:
        """Takes a `cadquery.Shape`."""
        from OCP import gp
        from OCP.IntCurvesFace import IntCurvesFace_ShapeIntersector

        self._gp = gp
        self._lines = IntCurvesFace_ShapeIntersector()
        self._lines.Load(solid.wrapped, 1e-6)

    def is_free(self, start: np.ndarray, along: np.ndarray) -> bool:
        """Whether a line from a point (3,) along a unit vector (3,) meets nothing."""
        self._shoot(start, along)
        return self._lines.NbPnt() == 0

    def first(self, start: np.ndarray, along: np.ndarray, far_mm: float = FAR_MM) -> tuple[float, np.ndarray] | None:
        """Distance, mm, of the first face that a line meets, and (3,) that face's normal out of the material there.

        None where it meets none so near as asked.
        """
        self._shoot(start, along, far_mm)
        if not self._lines.NbPnt():
            return None
        from OCP.BRepGProp import BRepGProp_Face

        k = min(range(1, self._lines.NbPnt() + 1), key=self._lines.WParameter)
        normal = _normal(BRepGProp_Face(self._lines.Face(k)), self._lines.UParameter(k), self._lines.VParameter(k))[1]
        return float(self._lines.WParameter(k)), normal

    def _shoot(self, start: np.ndarray, along: np.ndarray, far_mm: float = FAR_MM) -> None:
        gp = self._gp
        self._lines.Perform(gp.gp_Lin(gp.gp_Pnt(*start.tolist()), gp.gp_Dir(*along.tolist())), _OFF_MM, far_mm)


@memoize
def face_points(solid: Any) -> list[tuple[Any, list[tuple[np.ndarray, np.ndarray]]]]:
    """Points of the faces of a `cadquery.Shape`.

    Returns:
        Each face and its points (3,) in a grid of its parameters, mm, each with the (3,) normal out of the part.
    """
    return [(face, list(_points(face))) for face in solid.Faces()]


def _points(face: Any) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    from OCP.BRepGProp import BRepGProp_Face
    from OCP.BRepTools import BRepTools
    from OCP.BRepTopAdaptor import BRepTopAdaptor_FClass2d
    from OCP.gp import gp_Pnt2d
    from OCP.TopAbs import TopAbs_IN

    u0, u1, v0, v1 = BRepTools.UVBounds_s(face.wrapped)
    inside = BRepTopAdaptor_FClass2d(face.wrapped, 1e-6)
    surface = BRepGProp_Face(face.wrapped)
    shares = (np.arange(GRID) + 0.5) / GRID
    for u in u0 + shares * (u1 - u0):
        for v in v0 + shares * (v1 - v0):
            if inside.Perform(gp_Pnt2d(u, v)) == TopAbs_IN:
                yield _normal(surface, u, v)


def _normal(surface: Any, u: float, v: float) -> tuple[np.ndarray, np.ndarray]:
    from OCP.gp import gp_Pnt, gp_Vec

    point, normal = gp_Pnt(), gp_Vec()
    surface.Normal(u, v, point, normal)
    way = np.array([normal.X(), normal.Y(), normal.Z()]) / max(normal.Magnitude(), 1e-300)
    return np.array([point.X(), point.Y(), point.Z()]), way
