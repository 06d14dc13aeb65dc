"""Projection of solids: the kernel's exact hidden-line removal, as lines, arcs and curves in a plane.

Edges that fall on one another are drawn once, and what is visible is not drawn as hidden once more.
"""

# pyright: reportAttributeAccessIssue=false
# OCP builds its modules at run time, so a type checker does not see their names

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from math import atan2, ceil, degrees, floor, hypot, pi
from typing import Any

import numpy as np

from delta_cad.export.drawings.sheet_io.sheet import Arc, Item, Point, Stroke

_SAME_MM = 1e-3  # coordinates that close are one; the kernel's curves of a view are true to 1e-4
_CELL_MM = 0.1  # of the grid in which what is the same is looked for
_SHORT_MM = 5e-3  # nothing shorter is drawn: no pen shows it
_FLAT_MM = 1e-3  # a curve that strays less from its chord is a line: a circle seen from its side
_CURVE_MM = 0.02  # to which a curve that is no arc is drawn by lines
HATCH_MM = 2.0  # between the lines of a section


@dataclass(frozen=True)
class Frame:
    """A view: (3,) unit vectors to its right, upwards and towards the viewer, right-handed, in the part's frame."""

    right: tuple[float, float, float]
    up: tuple[float, float, float]

    @property
    def axes(self) -> np.ndarray:
        """(2, 3) right and upwards."""
        return np.array([self.right, self.up])

    @property
    def towards(self) -> np.ndarray:
        """(3,) towards the viewer."""
        return np.cross(self.right, self.up)

    @classmethod
    def of(cls, right: np.ndarray, up: np.ndarray) -> Frame:
        """Gives the view of two unit vectors (3,)."""
        return cls(*(tuple((vector + 0.0).tolist()) for vector in (right, up)))

    @classmethod
    def seen_from(cls, eye: np.ndarray, up: np.ndarray) -> Frame:
        """Gives the view from a direction (3,) in which another points upwards."""
        eye = eye / np.linalg.norm(eye)
        right = np.cross(up, eye)
        right /= np.linalg.norm(right)
        return cls.of(right, np.cross(eye, right))

    def __call__(self, point: Any) -> Point:
        """Gives where a (3,) point is seen, mm."""
        u, v = self.axes @ np.asarray(point, dtype=float)
        return float(u), float(v)


@dataclass
class Seen:
    """What is seen of several shapes.

    Attributes:
        items: Lines, arcs and curves, mm.
        marks: Of each shape the length of its longest visible edge, mm, 0 if there is none, and that edge's middle.
    """

    items: list[Item]
    marks: list[tuple[float, Point]]


def projected(shapes: Sequence[Any], frame: Frame, hidden: bool = True) -> list[Item]:
    """Projects the kernel's shapes, `TopoDS_Shape`, all edges sharp or outlines.

    Returns:
        Items of the layers "visible" and "hidden", mm.
    """
    edges = _removed(shapes, frame)
    seen = [*_curves(edges.VCompound()), *_curves(edges.OutLineVCompound())]
    behind = [*_curves(edges.HCompound()), *_curves(edges.OutLineHCompound())] if hidden else []
    return merged(seen, behind)


def seen_of(shapes: Sequence[Any], frame: Frame) -> Seen:
    """Projects shapes as `projected` does, without what is hidden, and tells where each is seen."""
    edges = _removed(shapes, frame)
    marks, items = [], []
    for shape in shapes:
        own = [*_curves(edges.VCompound(shape)), *_curves(edges.OutLineVCompound(shape))]
        items += own
        marks.append(max((_length(item) for item in own), default=(0.0, (0.0, 0.0))))
    return Seen(merged(items, []), marks)


def _length(item: Item) -> tuple[float, Point]:
    """Length of a line or an arc, and its middle."""
    points = np.array(item.points() if isinstance(item, Arc) else item.points if isinstance(item, Stroke) else [])
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    x, y = points[len(points) // 2] if len(points) > 2 else points.mean(axis=0)
    return float(steps.sum()), (float(x), float(y))


def _removed(shapes: Sequence[Any], frame: Frame) -> Any:
    """Hidden lines of shapes removed: an `HLRBRep_HLRToShape`."""
    from OCP.gp import gp_Ax2, gp_Dir, gp_Pnt
    from OCP.HLRAlgo import HLRAlgo_Projector
    from OCP.HLRBRep import HLRBRep_Algo, HLRBRep_HLRToShape

    algorithm = HLRBRep_Algo()
    for shape in shapes:
        algorithm.Add(shape)
    axes = gp_Ax2(gp_Pnt(0.0, 0.0, 0.0), gp_Dir(*frame.towards.tolist()), gp_Dir(*frame.right))
    algorithm.Projector(HLRAlgo_Projector(axes))
    algorithm.Update()
    algorithm.Hide()
    return HLRBRep_HLRToShape(algorithm)


def cut_open(
    solid: Any, frame: Frame, steps: Sequence[tuple[float, float]], axis: int = 1
) -> tuple[Any, list[list[Point]]]:
    """Cuts a solid open across the viewer's direction.

    Args:
        solid: A `cadquery.Solid`.
        frame: The view.
        steps: Planes side by side: up to where along an axis of the view each goes, mm, rising, the last to `inf`; and
            where it lies along the direction to the viewer, mm.
        axis: That axis, 0 or 1.

    Returns:
        What is left behind the cut, and the rings around the cut faces and their holes, for `hatched`.
    """
    import cadquery as cq

    size = 4.0 * float(solid.BoundingBox().DiagonalLength)
    towards, rest = frame.towards, solid
    centre = np.array(solid.BoundingBox().center.toTuple())
    middle = [*(frame.axes @ centre), float(towards @ centre)]
    low = middle[axis] - size
    for end, depth in steps:
        high = min(end, middle[axis] + size)
        spans = [[at - size, at + size] for at in middle[:2]]
        spans[axis], low = [low, high], high
        at = [sum(span) / 2.0 for span in spans]
        origin = at[0] * frame.axes[0] + at[1] * frame.axes[1] + depth * towards
        plane = cq.Plane(cq.Vector(*origin.tolist()), cq.Vector(*frame.right), cq.Vector(*towards.tolist()))
        wide, tall = (span[1] - span[0] for span in spans)
        rest = rest.cut(cq.Workplane(plane).rect(wide, tall).extrude(size).val())
    depths = np.array([depth for _, depth in steps])
    rings = []
    for face in rest.Faces():
        if face.geomType() != "PLANE":
            continue
        normal = np.array(face.normalAt().toTuple())
        off = np.abs(depths - np.array(face.Center().toTuple()) @ towards)
        if normal @ towards > 1.0 - 1e-6 and off.min() < _SAME_MM:
            for wire in face.Wires():
                rings.append([frame(p) for edge in _ordered(wire) for p in edge])
    return rest, rings


def _ordered(wire: Any) -> Iterator[list[np.ndarray]]:
    """Points along a wire's edges, each edge's in the wire's order."""
    from OCP.BRepAdaptor import BRepAdaptor_Curve
    from OCP.BRepTools import BRepTools_WireExplorer
    from OCP.TopAbs import TopAbs_REVERSED

    walk = BRepTools_WireExplorer(wire.wrapped)
    while walk.More():
        curve = BRepAdaptor_Curve(walk.Current())
        points = _sampled(curve)
        yield points[::-1] if walk.Current().Orientation() == TopAbs_REVERSED else points
        walk.Next()


def hatched(rings: Sequence[Sequence[Point]], step: float = HATCH_MM) -> Iterator[Stroke]:
    """Hatches what closed polygons enclose by lines at 45 degrees; one inside another is a hole.

    Args:
        rings: Corners of each polygon, mm.
        step: Between two lines, mm.
    """
    turn = np.array([[1.0, 1.0], [-1.0, 1.0]]) / np.sqrt(2.0)
    loops = [np.array(ring) @ turn.T for ring in rings if len(ring) > 2]
    if not loops:
        return
    low, high = min(loop[:, 1].min() for loop in loops), max(loop[:, 1].max() for loop in loops)
    for k in range(ceil(low / step), ceil(high / step)):
        level, cuts = (k + 0.5) * step, []
        for loop in loops:
            nexts = np.roll(loop, -1, axis=0)
            for (x0, y0), (x1, y1) in zip(loop, nexts, strict=True):
                if (y0 <= level) != (y1 <= level):
                    cuts.append(x0 + (level - y0) / (y1 - y0) * (x1 - x0))
        cuts.sort()
        for start, end in zip(cuts[::2], cuts[1::2], strict=False):
            ends = np.array([[start, level], [end, level]]) @ turn
            yield Stroke("hatch", (tuple(ends[0].tolist()), tuple(ends[1].tolist())))


def _curves(compound: Any) -> Iterator[Item]:
    """Lines, arcs and polylines of a compound of edges in the plane z = 0; layer "visible"."""
    if compound is None or compound.IsNull():
        return
    from OCP.BRepAdaptor import BRepAdaptor_Curve
    from OCP.BRepLib import BRepLib
    from OCP.GeomAbs import GeomAbs_Circle, GeomAbs_Line
    from OCP.TopAbs import TopAbs_EDGE
    from OCP.TopExp import TopExp_Explorer
    from OCP.TopoDS import TopoDS

    BRepLib.BuildCurves3d_s(compound)
    walk = TopExp_Explorer(compound, TopAbs_EDGE)
    while walk.More():
        curve = BRepAdaptor_Curve(TopoDS.Edge_s(walk.Current()))
        walk.Next()
        kind = curve.GetType()
        first, last = curve.FirstParameter(), curve.LastParameter()
        if kind == GeomAbs_Circle:
            circle = curve.Circle()
            centre, around = circle.Location(), circle.Axis().Direction().Z()
            if abs(abs(around) - 1.0) < 1e-6:
                start = curve.Value(first if around > 0.0 else last)
                angle = degrees(atan2(start.Y() - centre.Y(), start.X() - centre.X())) % 360.0
                turn = degrees(last - first)
                yield Arc("visible", (centre.X(), centre.Y()), circle.Radius(), angle, angle + min(turn, 360.0))
                continue
        points = [tuple(p[:2].tolist()) for p in _sampled(curve, kind == GeomAbs_Line)]
        yield Stroke("visible", tuple(points))


def _sampled(curve: Any, straight: bool = False) -> list[np.ndarray]:
    """Points of a curve with lines between them that deviate by less than `_CURVE_MM`; 2 where it is flat."""
    first, last = curve.FirstParameter(), curve.LastParameter()

    def at(share: float) -> np.ndarray:
        point = curve.Value(first + share * (last - first))
        return np.array([point.X(), point.Y(), point.Z()])

    if straight:
        return [at(0.0), at(1.0)]
    rough = np.array([at(k / 32) for k in range(33)])
    chord = rough[-1] - rough[0]
    length = float(np.linalg.norm(chord))
    if length > _SHORT_MM:
        apart = rough - rough[0]
        along = apart @ chord / length
        if np.abs(apart - np.outer(along, chord / length)).max() < _FLAT_MM and (np.diff(along) > -_FLAT_MM).all():
            return [rough[0], rough[-1]]
    bend = np.abs(rough[:-2] - 2 * rough[1:-1] + rough[2:]).max() / 8.0
    count = 32 * max(1, ceil(np.sqrt(bend / _CURVE_MM)))
    return [at(k / count) for k in range(count + 1)]


def merged(seen: Iterable[Item], behind: Iterable[Item]) -> list[Item]:
    """Joins lines and arcs that lie on one another, and takes from what is behind what is seen.

    Returns:
        The same, layers "visible" and "hidden".
    """
    lines, arcs, paths = _Near(), _Near(), _Near()
    found: list[Item] = []
    for layer, items in (("visible", seen), ("hidden", behind)):
        for item in items:
            if isinstance(item, Arc):
                at = arcs.key((*item.centre, item.radius))
                spans = arcs[at].setdefault(layer, [])
                start = item.start % 360.0
                end = start + item.end - item.start
                spans += [(start, min(end, 360.0)), (0.0, end - 360.0)] if end > 360.0 else [(start, end)]
            elif isinstance(item, Stroke) and len(item.points) == 2:
                (x0, y0), (x1, y1) = item.points
                if hypot(x1 - x0, y1 - y0) < _SHORT_MM:
                    continue
                angle = atan2(y1 - y0, x1 - x0) % pi
                angle = 0.0 if pi - angle < 1e-6 else angle
                c, s = np.cos(angle), np.sin(angle)
                at = lines.key((100.0 * angle, float(c * y0 - s * x0)))
                ends = sorted((float(c * x0 + s * y0), float(c * x1 + s * y1)))
                lines[at].setdefault(layer, []).append((ends[0], ends[1]))
            elif isinstance(item, Stroke):
                middle = item.points[len(item.points) // 2]
                ends = sorted((item.points[0], item.points[-1]))
                paths.key((*ends[0], *ends[1], *middle), (layer, item.points))
    for (angle, offset), by_layer in lines.items():
        c, s = np.cos(angle / 100.0), np.sin(angle / 100.0)
        for layer, start, end in _layered(by_layer, _SHORT_MM):
            points = tuple((float(c * t - s * offset), float(s * t + c * offset)) for t in (start, end))
            found.append(Stroke(layer, points))
    for (x, y, radius), by_layer in arcs.items():
        for layer, start, end in _layered(by_layer, degrees(_SHORT_MM / max(radius, _SHORT_MM))):
            found.append(Arc(layer, (x, y), radius, start, end))
    return _joined_arcs(found) + [Stroke(layer, points) for layer, points in paths.values()]


class _Near(dict[tuple[float, ...], Any]):
    """Entries by tuples of numbers, of which those that differ by less than `_SAME_MM` are one."""

    def __init__(self) -> None:
        super().__init__()
        self._cells: dict[tuple[int, ...], list[tuple[float, ...]]] = {}

    def key(self, values: tuple[float, ...], entry: Any = None) -> tuple[float, ...]:
        """Gives the key that is the same as some numbers; a new one with an entry of its own, {} for None."""
        low = (floor((value - _SAME_MM) / _CELL_MM) for value in values)
        high = (floor((value + _SAME_MM) / _CELL_MM) for value in values)
        for cell in product(*({a, b} for a, b in zip(low, high, strict=True))):
            for known in self._cells.get(cell, ()):
                if all(abs(a - b) < _SAME_MM for a, b in zip(known, values, strict=True)):
                    return known
        self._cells.setdefault(tuple(floor(value / _CELL_MM) for value in values), []).append(values)
        self[values] = {} if entry is None else entry
        return values


def _layered(by_layer: dict[str, list[tuple[float, float]]], least: float) -> Iterator[tuple[str, float, float]]:
    """Visible spans, and of the hidden ones what is not visible."""
    seen = _union(by_layer.get("visible", []), least)
    yield from (("visible", start, end) for start, end in seen)
    for start, end in _union(by_layer.get("hidden", []), least):
        for low, high in seen:
            if low > start + least and start < end and min(low, end) - start > least:
                yield "hidden", start, min(low, end)
            start = max(start, high) if low <= end else start
        if end - start > least:
            yield "hidden", start, end


def _union(spans: list[tuple[float, float]], gap: float) -> list[tuple[float, float]]:
    joined: list[tuple[float, float]] = []
    for start, end in sorted(spans):
        if joined and start <= joined[-1][1] + gap:
            joined[-1] = joined[-1][0], max(joined[-1][1], end)
        else:
            joined.append((start, end))
    return joined


def _joined_arcs(items: list[Item]) -> list[Item]:
    """Joins arcs across 0 degrees."""
    begins = {(i.layer, i.centre, i.radius): i for i in items if isinstance(i, Arc) and i.start < 1e-3 and not i.whole}
    out: list[Item] = []
    for item in items:
        if isinstance(item, Arc) and not item.whole and item.end > 360.0 - 1e-3:
            first = begins.pop((item.layer, item.centre, item.radius), None)
            if first is not None and first is not item:
                out.append(Arc(item.layer, item.centre, item.radius, item.start, 360.0 + first.end))
                continue
        out.append(item)
    kept = set(map(id, begins.values()))
    return [
        i
        for i in out
        if not (isinstance(i, Arc) and i.start < 1e-3 and not i.whole and i.end <= 360.0) or id(i) in kept
    ]
