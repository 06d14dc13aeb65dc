"""Profiles of plate parts in true size, DXF: what a laser, a waterjet or a router cuts out of a plate.

A profile is the shadow of the part along its thinnest side: the plate that the part is cut of covers just that, and an
opening of the shadow goes through. What is sunk, stepped or bevelled is milled from the blank afterwards.

A plate part is found by its solid: thin, no smaller than a cut piece that stays on the table, not round as a piece off
a bar, and its shadow's outline is walls all round, faces square to the plate, for a beam cuts nothing else.

Coordinates are the part's, as in its STEP file: x to the right and y up of a plate across z, seen from +z; x right and
z up across y, seen from -y; y right and z up across x, seen from +x.
"""

# pyright: reportAttributeAccessIssue=false
# OCP builds its modules at run time, so a type checker does not see their names

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise
from math import atan, cos, hypot, pi, sin
from pathlib import Path
from typing import Any

import numpy as np

from delta_cad.assembly.faces import SolidFace, solid_faces
from delta_cad.common.memoize import cached
from delta_cad.export.drawings.sheet_io.dxf import r2010_text
from delta_cad.export.shop.template import add_layers, add_loop
from delta_cad.solids.part import Part, part_digest

SUFFIX = ".profile.dxf"
FOLDER = "profiles"
LAYERS = {"OUTLINE": 1, "HOLES": 5, "PILOT": 3}
"""With their colours. PILOT: what is finished after the cut, threads' cores, and bores of a fit with stock."""
_STOCK_MM, _STOCK_WIDE_MM, _WIDE_MM = 0.5, 1.0, 6.0
"""Of diameter, left to finish a bore of a fit, of one wider than the last the second; from memory: a beam's taper."""
_THICKEST_MM = 30.0  # of aluminium, what a laser just cuts and a waterjet cuts square
_LEAST_MM = 12.0  # across the blank: smaller pieces fall between the bars of a cutting table
_BAR_MM, _DISC = 60.0, 5.0  # a round piece up to this diameter, or thicker than a share of it, comes off a bar
_ALONG = 1e-6  # sine of an angle below which two directions are one
_LEVEL_MM = 5e-3  # of two heights that count as one
_SAME_MM = 1e-4
_GRID = 4  # places along either parameter of a face at which it is looked whether it is a wall
_ARCS = 16  # in place of a curve that is neither straight nor round: what they leave of a fillet is below a micrometre
_DECIMALS = 6
_SHARES = (0.0, 0.5)  # of an edge at which its points are read: its ends and its middle

Vertex = tuple[float, float, float]
"""x, y and bulge of the piece that begins there: the tangent of a fourth of its angle, 0 of a straight one."""


@dataclass(frozen=True)
class Loop:
    """A closed line of arcs and straight pieces.

    Attributes:
        vertices: In order, anticlockwise; two of one circle for a whole circle.
        layer: In which it is drawn.
        stock_mm: Of diameter, by which a circle is cut smaller, to be finished to the line.
    """

    vertices: tuple[Vertex, ...]
    layer: str
    stock_mm: float = 0.0

    @cached_property
    def circle(self) -> tuple[float, float, float] | None:
        """Centre and radius of a loop that is one circle, mm."""
        arcs = [_arc(a, b) for a, b in self._pieces() if a[2]]
        first = arcs[0] if arcs else None
        if first is None or len(arcs) != len(self.vertices):
            return None
        if any(max(abs(p - q) for p, q in zip(first, one, strict=True)) > _SAME_MM for one in arcs):
            return None
        return first

    @property
    def area_mm2(self) -> float:
        """Enclosed area."""
        found = 0.0
        for (x, y, bulge), (u, v, _) in self._pieces():
            found += (x * v - u * y) / 2.0
            if bulge:
                angle = 4.0 * atan(bulge)
                radius = hypot(u - x, v - y) / 2.0 / sin(angle / 2.0)
                found += radius**2 / 2.0 * (angle - sin(angle))
        return found

    def _pieces(self) -> list[tuple[Vertex, Vertex]]:
        return list(zip(self.vertices, [*self.vertices[1:], self.vertices[0]], strict=True))


@dataclass(frozen=True)
class Profile:
    """What is cut of a plate.

    Attributes:
        axis: Of the part's frame, across the plate: 0, 1 or 2.
        thickness_mm: Of the part, from its lowest to its highest point along that axis.
        outline: The outer line.
        openings: Those that go through.
    """

    axis: int
    thickness_mm: float
    outline: Loop
    openings: tuple[Loop, ...]

    @property
    def area_mm2(self) -> float:
        """Of the blank, without its openings."""
        return self.outline.area_mm2 - sum(one.area_mm2 for one in self.openings)

    def dxf(self) -> str:
        """Gives the text of the DXF R2010, mm, the same each time."""

        def draw(document: Any) -> None:
            add_layers(document, LAYERS)
            for loop in (self.outline, *self.openings):
                circle = loop.circle and (*loop.circle[:2], loop.circle[2] - loop.stock_mm / 2.0)
                add_loop(document.modelspace(), loop.vertices, circle, loop.layer)

        return r2010_text(draw)


def write_profiles(parts: Sequence[Part], folder: Path) -> None:
    """Writes `<number>.profile.dxf` of each plate part among parts that are cut; no folder where there is none."""
    for part in parts:
        if part.make and not part.material.process and (profile := _profile_of(part)) is not None:
            folder.mkdir(exist_ok=True)
            (folder / f"{part.number}{SUFFIX}").write_text(profile.dxf(), encoding="utf-8", newline="\n")


def _profile_of(part: Part) -> Profile | None:
    return cached("profile", part_digest(part), lambda: profile_of(part))


def profile_of(part: Part) -> Profile | None:
    """Finds the profile of a part; None where it is no plate part."""
    if part.order_code:  # stock as bought
        return None
    box = part.solid.BoundingBox(_SAME_MM)
    sizes = np.array([box.xlen, box.ylen, box.zlen])
    axis = int(sizes.argmin())
    thickness, across = float(sizes[axis]), np.delete(sizes, axis)
    if thickness > _THICKEST_MM or across.min() < _LEAST_MM:
        return None
    shadow = _shadow(part.solid, axis)
    if shadow is None:
        return None
    lines = _Walls(part.solid, axis)
    outline = lines.loop(shadow.outerWire(), "OUTLINE")
    if outline is None:
        return None
    if outline.circle is not None and 2.0 * outline.circle[2] < max(_BAR_MM, _DISC * thickness):
        return None
    finished = list(_finished(part, axis))
    found = [lines.loop(wire, *_layer_of(wire, finished, axis)) for wire in shadow.innerWires()]
    openings = sorted((one for one in found if one is not None), key=lambda one: (one.layer, one.vertices))
    return Profile(axis, thickness, outline, tuple(openings))


def _shadow(solid: Any, axis: int) -> Any | None:
    """The shadow as one face at height 0; None where it is more than one, or where more than its walls throws it.

    Between the ends of walls and of cross bores a section changes by bevels and slopes alone, which lie inside it where
    the outline is walls: the sections together are the shadow, if no edge of the part lies outside.
    """
    import cadquery as cq

    ending = [
        face for face in solid_faces(solid) if _is_wall(face, axis) or (face.kind == "cylinder" and face.is_hollow)
    ]
    levels = sorted({level for face in ending for level in _reach(face.face, axis)})
    normal = cq.Vector(*np.eye(3)[axis].tolist())
    box, pieces = solid.BoundingBox(_SAME_MM), list[Any]()
    wide = 4.0 * box.DiagonalLength
    for low, high in pairwise(levels):
        if high - low > _LEVEL_MM:
            at = np.array(box.center.toTuple())
            at[axis] = (low + high) / 2.0
            cut = cq.Face.makePlane(wide, wide, cq.Vector(*at.tolist()), normal).intersect(solid)
            pieces += [face.translate(normal * (-float(at[axis]))) for face in cut.Faces()]
    found = list[Any]()
    for piece in sorted(pieces, key=lambda face: -face.Area()):
        if not any(_holds(one, piece) for one in found):
            found = found[0].fuse(*found[1:], piece).clean().Faces() if found else [piece]
    return found[0] if len(found) == 1 and _has(found[0], _edge_points(solid, axis), axis) else None


def _holds(shadow: Any, piece: Any) -> bool:
    """Whether a face holds another of the same plane: its edges lie inside, and no opening within it."""
    axis = int(np.argmax(np.abs(shadow.normalAt().toTuple())))
    inside = (point for wire in shadow.innerWires() for point in _edge_points(wire, axis))
    return _has(shadow, _edge_points(piece, axis), axis) and not any(
        _state(piece, point, axis) == "in" for point in inside
    )


def _edge_points(shape: Any, axis: int) -> set[tuple[float, ...]]:
    """Ends and middles of all edges, seen along an axis, mm."""
    return {
        tuple(round(float(v), _DECIMALS) for v in np.delete(edge.positionAt(share).toTuple(), axis))
        for edge in shape.Edges()
        for share in _SHARES
    }


def _has(shadow: Any, points: Iterable[tuple[float, ...]], axis: int) -> bool:
    """Whether no point lies outside a face at height 0."""
    return all(_state(shadow, point, axis) != "out" for point in points)


def _state(face: Any, point: tuple[float, ...], axis: int) -> str:
    """Where a point lies with respect to a face at height 0: "in", "on" its edge, or "out"."""
    from OCP.BRepClass import BRepClass_FaceClassifier
    from OCP.gp import gp_Pnt
    from OCP.TopAbs import TopAbs_IN, TopAbs_ON

    at = np.insert(np.array(point), axis, 0.0)
    state = BRepClass_FaceClassifier(face.wrapped, gp_Pnt(*at.tolist()), _SAME_MM).State()
    return "in" if state == TopAbs_IN else "on" if state == TopAbs_ON else "out"


def _is_wall(face: SolidFace, axis: int) -> bool:
    """Whether a face is square to the plate all over."""
    along = abs(float(face.direction[axis]))
    if face.kind == "other":  # such as the fillet between two walls
        u0, u1, v0, v1 = face.face.uvBounds()
        us, vs = (grid.ravel().tolist() for grid in np.meshgrid(np.linspace(u0, u1, _GRID), np.linspace(v0, v1, _GRID)))
        return bool(max(abs(normal.toTuple()[axis]) for normal in face.face.normals(us, vs)[0]) < _ALONG)
    return (face.kind == "plane" and along < _ALONG) or (face.kind == "cylinder" and along > 1.0 - _ALONG)


def _reach(face: Any, axis: int) -> tuple[float, float]:
    """Lowest and highest point of a face along an axis, mm."""
    box = face.BoundingBox(_SAME_MM)
    low, high = ((box.xmin, box.ymin, box.zmin), (box.xmax, box.ymax, box.zmax))
    return round(low[axis], 4), round(high[axis], 4)


class _Walls:
    """Lines of a shadow that are walls of the part."""

    def __init__(self, solid: Any, axis: int) -> None:
        self._axis = axis
        self._faces = [face for face in solid_faces(solid) if _is_wall(face, axis)]

    def loop(self, wire: Any, layer: str, stock_mm: float = 0.0) -> Loop | None:
        """Reads a wire; None where a piece of it is no wall."""
        from OCP.BRepTools import BRepTools_WireExplorer

        found, explorer = list[list[Vertex]](), BRepTools_WireExplorer(wire.wrapped)
        while explorer.More():
            pieces = self._pieces(explorer.Current())
            if pieces is None:
                return None
            found.append(pieces)
            explorer.Next()
        vertices = [vertex for pieces in found for vertex in pieces]
        loop = Loop(tuple(vertices), layer)
        if loop.area_mm2 < 0.0:  # the other way round: pieces begin where they ended
            turned = vertices[::-1]
            bulges = [-bulge for _, _, bulge in [*turned[1:], turned[0]]]
            vertices = [(x, y, bulge) for (x, y, _), bulge in zip(turned, bulges, strict=True)]
        vertices = [(round(x, _DECIMALS) + 0.0, round(y, _DECIMALS) + 0.0, round(b, 9) + 0.0) for x, y, b in vertices]
        first = vertices.index(min(vertices))
        return Loop(tuple(vertices[first:] + vertices[:first]), layer, stock_mm)

    def _pieces(self, edge: Any) -> list[Vertex] | None:
        """The pieces of an edge in its wire's sense, a whole circle in two; None where it is no wall."""
        from OCP.BRepAdaptor import BRepAdaptor_Curve
        from OCP.GeomAbs import GeomAbs_Circle, GeomAbs_Line
        from OCP.TopAbs import TopAbs_REVERSED

        curve = BRepAdaptor_Curve(edge)
        start, end = curve.FirstParameter(), curve.LastParameter()
        if edge.Orientation() == TopAbs_REVERSED:
            start, end = end, start
        if curve.GetType() in (GeomAbs_Line, GeomAbs_Circle):
            parts = 2 if curve.GetType() == GeomAbs_Circle and abs(end - start) > pi + _ALONG else 1
        else:
            parts = _ARCS
        ends = np.linspace(start, end, 2 * parts + 1)  # with the middles between
        points = [self._flat(curve.Value(float(at))) for at in ends]
        if not any(self._is_on(face, points) for face in self._faces):
            return None
        found = list[Vertex]()
        for a, middle, b in zip(points[0::2], points[1::2], points[2::2], strict=False):
            chord, aside = b - a, middle - (a + b) / 2.0
            right = (aside[0] * chord[1] - aside[1] * chord[0]) / max(float(chord @ chord), 1e-300)
            found.append((float(a[0]), float(a[1]), 2.0 * float(right)))
        return found

    def _flat(self, point: Any) -> np.ndarray:
        return np.delete(np.array([point.X(), point.Y(), point.Z()]), self._axis)

    def _is_on(self, face: SolidFace, points: Sequence[np.ndarray]) -> bool:
        """Whether points lie on a wall, seen along the axis."""
        if face.kind == "other":
            at = [np.insert(point, self._axis, face.centre[self._axis]) for point in points]
            return max(_distance_mm(face.face, point) for point in at) < _SAME_MM
        off = np.array(points) - np.delete(face.point, self._axis)
        if face.kind == "plane":
            away = off @ np.delete(face.direction, self._axis)
        else:
            away = np.linalg.norm(off, axis=1) - face.radius_mm
        return bool(np.abs(away).max() < _SAME_MM)


def _distance_mm(face: Any, point: np.ndarray) -> float:
    from cadquery import Vertex as Point

    return float(face.distance(Point.makeVertex(*point.tolist())))


def _arc(a: Vertex, b: Vertex) -> tuple[float, float, float]:
    """Centre and radius of the arc from a vertex to the next."""
    angle, chord = 4.0 * atan(a[2]), np.array([b[0] - a[0], b[1] - a[1]])
    radius = float(np.linalg.norm(chord)) / 2.0 / sin(angle / 2.0)
    left = np.array([-chord[1], chord[0]]) / max(float(np.linalg.norm(chord)), 1e-300)
    x, y = np.array(a[:2]) + chord / 2.0 + radius * cos(angle / 2.0) * left
    return float(x), float(y), abs(radius)


def _finished(part: Part, axis: int) -> Iterator[tuple[np.ndarray, float, float]]:
    """Axis, seen along the plate's, diameter and stock of each bore that is finished after the cut, mm."""
    for bore in (bore for hole in part.holes for bore in hole.bores):
        if abs(bore.direction[axis]) > 1.0 - _ALONG and (bore.thread or bore.deviations_um is not None):
            stock = 0.0 if bore.thread else _STOCK_MM if bore.diameter_mm <= _WIDE_MM else _STOCK_WIDE_MM
            yield np.delete(np.array(bore.start_mm), axis), bore.diameter_mm, stock


def _layer_of(wire: Any, finished: Sequence[tuple[np.ndarray, float, float]], axis: int) -> tuple[str, float]:
    """The layer of an opening and its stock: of what is finished later where such a bore has its size and place."""
    box = wire.BoundingBox(_SAME_MM)
    sizes, middle = np.delete([box.xlen, box.ylen, box.zlen], axis), np.delete(box.center.toTuple(), axis)
    for at, diameter, stock in finished:
        if np.linalg.norm(at - middle) < 10 * _SAME_MM and np.abs(sizes - diameter).max() < 20 * _SAME_MM:
            return "PILOT", stock
    return "HOLES", 0.0
