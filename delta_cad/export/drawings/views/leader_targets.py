"""Where the arrows of callouts point, and what a dimension with its arrow there measures."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import cos, hypot, radians, sin

import numpy as np

from delta_cad.export.drawings.part.faces import Face, is_across, is_along
from delta_cad.export.drawings.part.holes import Bore
from delta_cad.export.drawings.part.record import SAME_MM, Features
from delta_cad.export.drawings.sheet_io.sheet import Arc, Box, Measure, Point, Stroke
from delta_cad.export.drawings.views.choice import View
from delta_cad.export.drawings.views.marks import higher, towards

FAR_MM = 9.0  # from a view to where its texts begin
_SLOPE_MM = 7.0  # by which a callout stands above the wall it points at, so that its leader does not run along it
_LONG_SHARE = 0.5  # of the longest line of an edge, from which on others may have a datum's triangle


@dataclass
class LeaderTargets:
    """A view in which things are pointed at: `drawn` is the part's box, `room` is where the texts begin."""

    view: View
    scale: float
    features: Features
    drawn: Box
    room: Box

    def at(self, point: np.ndarray) -> Point:
        """Where a point of the part is on the block."""
        u, v = self.view.frame(point)
        return u * self.scale, v * self.scale

    def to_bore(self, bore: Bore) -> tuple[Point, Callable[[Point], Point]]:
        """Where a bore is, and where an arrow from a point touches it."""
        if self.view.end_on(bore):
            centre, radius = self.at(bore.point), bore.widest / 2 * self.scale
            return centre, lambda point: towards(centre, point, radius)
        spans = bore.spans[bore.widest][-1]
        middle = self.at(bore.point + (spans[0] + spans[1]) / 2 * bore.axis)
        anchor, tip = higher(middle, self._aside(bore.axis, bore.widest / 2))
        return (anchor[0], anchor[1] + _SLOPE_MM), tip

    def to_face(self, face: Face, kind: str) -> tuple[Point, Callable[[Point], Point]]:
        """Where a face of a kind of size is, and where an arrow from a point touches it."""
        if kind == "flat":
            at = self.at(face.centre if float(face.axis @ self.view.frame.axes[1]) >= 0.0 else self._mirrored(face))
            return at, lambda _: at
        if kind == "ball" or (kind == "round" and is_along(face.axis, self.view.towards)):
            return self._to_arc(face)
        if kind == "round":
            middle = face.point + float((face.middle - face.point) @ face.axis) * face.axis
            return higher(self.at(middle), self._aside(face.axis, self._radius(face, middle)))
        at = self.at(face.centre)
        return at, lambda _: at

    def _radius(self, face: Face, middle: np.ndarray) -> float:
        """Radius of a round face half way along it."""
        across = face.corners - middle
        across = across - np.outer(across @ face.axis, face.axis)
        return face.radius if face.kind == "cylinder" else float(np.linalg.norm(across, axis=1).mean())

    def _aside(self, axis: np.ndarray, radius: float) -> Point:
        """From an axis to the outline of what is round about it, in the view."""
        away = np.cross(axis, self.view.towards)
        u, v = self.view.frame.axes @ (away / max(float(np.linalg.norm(away)), SAME_MM))
        return float(u) * radius * self.scale, float(v) * radius * self.scale

    def _mirrored(self, face: Face) -> np.ndarray:
        """The middle of the flat opposite to a flat, on the other side of the part's axis."""
        return face.centre - 2.0 * float(face.centre @ face.axis) * face.axis

    def _to_arc(self, face: Face) -> tuple[Point, Callable[[Point], Point]]:
        """To the point of an arc, or of a ball's outline, that is nearest to where the leader comes from."""
        centre, radius = self.at(face.point), face.radius * self.scale
        spans = [
            (layer, item.start, item.end)
            for layer in ("visible", "hidden")
            for item in self.view.items
            if isinstance(item, Arc)
            and item.layer == layer
            and abs(item.radius * self.scale - radius) < 0.01
            and hypot(item.centre[0] * self.scale - centre[0], item.centre[1] * self.scale - centre[1]) < 0.01
        ]
        spans = [span for span in spans if span[0] == spans[0][0]]
        angles = [a + (b - a) * k / 20 for _, a, b in spans for k in range(1, 20)]
        points = [
            (centre[0] + radius * cos(radians(angle)), centre[1] + radius * sin(radians(angle))) for angle in angles
        ] or [self.at(p) for p in face.corners]

        def tip(point: Point) -> Point:
            whole = any(b - a > 360.0 - 1e-6 for _, a, b in spans)
            if whole:
                return towards(centre, point, radius)
            return min(points, key=lambda p: hypot(p[0] - point[0], p[1] - point[1]))

        far = self.room[2] + FAR_MM, max(p[1] for p in points) + _SLOPE_MM
        return tip(far), tip

    def edge(self, face: Face) -> list[Point]:
        """Points along the longest lines as which a plane is seen from its side."""
        u, v = (float(c) for c in self.view.frame.axes @ face.axis)
        corners = [self.at(corner) for corner in face.corners]
        level = u * corners[0][0] + v * corners[0][1]
        low, high = min(u * y - v * x for x, y in corners) - 0.01, max(u * y - v * x for x, y in corners) + 0.01
        lines = []
        for item in self.view.items:
            if isinstance(item, Stroke) and item.layer == "visible" and len(item.points) == 2:
                (ax, ay), (bx, by) = ends = [(x * self.scale, y * self.scale) for x, y in item.points]
                off = max(abs(u * x + v * y - level) for x, y in ends)
                if off < 0.01 and all(low < u * y - v * x < high for x, y in ends):
                    lines.append((hypot(bx - ax, by - ay), ends))
        longest = max((length for length, _ in lines), default=0.0)
        return [
            (ax + share * (bx - ax), ay + share * (by - ay))
            for length, ((ax, ay), (bx, by)) in lines
            if length > _LONG_SHARE * longest
            for share in (0.25, 0.5, 0.75)
        ] or corners

    def across_bore(self, bore: Bore) -> Callable[[Point], Measure | None]:
        """What the arrow at a bore measures: its largest diameter, where it is seen as a circle."""
        if not self.view.end_on(bore):
            return lambda _: None
        return self._diameter(self.at(bore.point), bore.widest)

    def across_face(self, face: Face, text: str, kind: str) -> Callable[[Point], Measure | None]:
        """What the arrow at a round face measures: diameter or radius of an arc, or the distance of its sides."""
        if kind not in ("round", "ball") or face.kind not in ("cylinder", "sphere") or text.startswith("M"):
            return lambda _: None
        if is_along(face.axis, self.view.towards) or kind == "ball":
            centre = self.at(face.point)
            if "Ø" in text:
                return self._diameter(centre, 2 * face.radius)
            return lambda tip: Measure("radius", (centre, tip), face.radius, text)
        if not is_across(face.axis, self.view.towards) or "Ø" not in text:
            return lambda _: None
        axis, off = self.at(face.point), self._aside(face.axis, 1.0)
        length = hypot(*off)
        way = off[0] / length, off[1] / length

        def across(tip: Point) -> Measure:
            """Between the tip and the point opposite to it."""
            aside = (tip[0] - axis[0]) * way[0] + (tip[1] - axis[1]) * way[1]
            other = tip[0] - 2 * aside * way[0], tip[1] - 2 * aside * way[1]
            return Measure("length", (tip, other), 2 * face.radius, text)

        return across

    def _diameter(self, centre: Point, diameter: float) -> Callable[[Point], Measure | None]:
        def across(tip: Point) -> Measure:
            other = 2 * centre[0] - tip[0], 2 * centre[1] - tip[1]
            return Measure("diameter", (tip, other), diameter, "")

        return across
