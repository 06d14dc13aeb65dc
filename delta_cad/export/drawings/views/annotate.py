"""What is told in a view, set out around it.

Coordinates stand in bands on the left of a view and below it, counted from the datum; callouts in one on its right, or
over it, each with its leader. A band grows with what it holds and its texts are spread by their true sizes, so that
they cannot overlap.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import cos, hypot, radians, sin

import numpy as np

from delta_cad.export.drawings.paper.lettering import LINE, width_of, wrapped
from delta_cad.export.drawings.paper.sheet import Arc, Box, Item, Point, Stroke, Text
from delta_cad.export.drawings.part.controlled import Controlled
from delta_cad.export.drawings.part.faces import Face, is_across, is_along
from delta_cad.export.drawings.part.holes import Bore, HoleGroup
from delta_cad.export.drawings.part.record import SAME_MM, Features, Place
from delta_cad.export.drawings.views.choice import View
from delta_cad.export.drawings.views.marks import LETTER_MM, arrow, free_text, higher, number, spread, tied, towards

PITCH_MM = LETTER_MM * LINE
CALLOUT_MM = 62.0  # longest line of a callout
WIDE_MM = 70.0  # of a view from which on callouts of what lies in its left half stand over it
NEAR_MM, FAR_MM = 2.0, 9.0  # from a view to where its extension lines bend, and to where the texts begin
SLOPE_MM = 7.0  # by which a callout stands above the wall it points at, so that its leader does not run along it
THREAD = re.compile(r"^(?:\d+x )?M(\d+(?:\.\d+)?)")


@dataclass
class Tagged:
    """One row of a table of holes: tag, coordinates to the right and up from the datum, mm, and what each tells."""

    tag: str
    x: float
    y: float
    told: tuple[str, ...]
    told_x: tuple[str, ...]
    told_y: tuple[str, ...]


@dataclass
class Callout:
    """What is told at the end of a leader: about where it points, where its arrow ends, coming from a point; its lines.

    `short` ones may stand over the view; of a turned part, those `at_end` are bored from an end.
    """

    anchor: Point
    tip: Callable[[Point], Point]
    lines: list[str]
    told: tuple[str, ...]
    short: bool = False
    at_end: bool = False


@dataclass
class Setting:
    """What the texts of one view are set out with: `drawn` is the part's box, `room` is where the bands begin."""

    view: View
    scale: float
    features: Features
    controlled: Controlled
    drawn: Box
    room: Box

    def at(self, point: np.ndarray) -> Point:
        """Where a point of the part is on the block."""
        u, v = self.view.frame(point)
        return u * self.scale, v * self.scale

    def keys(self, group: HoleGroup) -> list[str]:
        """Names of a group's bores."""
        g = self.features.groups.index(group)
        return [f"bore {g}.{b}" for b in range(len(group.bores))]

    def centre_lines(self) -> list[Stroke | Arc]:
        """Crosses on bores and arcs seen as circles, lines on axes seen from their side."""
        found: list[Stroke | Arc] = []
        seen: set[tuple[float, ...]] = set()
        rounds = [(b.faces[0].axis, b.point, b.widest / 2, b) for g in self.features.groups for b in g.bores]
        for axis, point, radius, bore in sorted(rounds, key=lambda one: -one[2]):
            if is_along(axis, self.view.towards):
                if not self._left(point):
                    continue
                x, y = self.at(point)
                if (key := (round(x, 2), round(y, 2))) in seen:
                    continue
                seen.add(key)
                reach = radius * self.scale + 1.5
                found += [
                    Stroke("centre", ((x - reach, y), (x + reach, y))),
                    Stroke("centre", ((x, y - reach), (x, y + reach))),
                ]
            elif is_across(axis, self.view.towards):
                ends = [point + t * bore.axis for spans in bore.spans.values() for span in spans for t in span]
                along = [float(e @ bore.axis) for e in ends]
                low, high = min(along) - 1.5 / self.scale, max(along) + 1.5 / self.scale
                base = point - (point @ bore.axis) * bore.axis
                start, end = self.at(base + low * bore.axis), self.at(base + high * bore.axis)
                key = tuple(round(v, 1) for v in (*start, *end))
                if key not in seen and (self.view.cut is None or self._in_cut(point)):
                    seen.add(key)
                    found.append(Stroke("centre", (start, end)))
        found += self._threads()
        if self.features.turned:
            y = self.at(np.zeros(3))[1]
            found = [
                i
                for i in found
                if not (isinstance(i, Stroke) and abs(i.points[0][1] - y) + abs(i.points[1][1] - y) < 0.1)
            ]
            found.append(Stroke("centre", ((self.drawn[0] - 2.0, y), (self.drawn[2] + 2.0, y))))
        return found

    def _threads(self) -> list[Arc]:
        """Three quarters of a thread's circle round its core, seen end on, ISO 6410."""
        found: list[Arc] = []
        for group in self.features.groups:
            nominal = next((float(match[1]) for line in group.callout if (match := THREAD.match(line))), None)
            for bore in group.bores if nominal is not None else ():
                if nominal is not None and self.view.end_on(bore) and self._left(bore.point) and nominal > bore.widest:
                    found.append(Arc("dimension", self.at(bore.point), nominal / 2 * self.scale, 0.0, 270.0))
        return found

    def _left(self, point: np.ndarray) -> bool:
        """Whether a point is on what is left of a part that is cut open."""
        return self.view.cut is None or float(point @ self.view.towards) < self.view.cut + SAME_MM

    def _in_cut(self, point: np.ndarray) -> bool:
        """Whether a bore's axis lies in the plane in which the view is cut open."""
        return self.view.cut is not None and abs(float(point @ self.view.towards) - self.view.cut) < SAME_MM

    def value(self, place: Place, axis: np.ndarray) -> float:
        """What a coordinate counts along an axis of the view, from the datum, mm."""
        sense = 1.0 if float(place.along @ axis) > 0.0 else -1.0
        return sense * (place.value - float(self.features.datum @ place.along))

    def ordinates(self, places: Sequence[Place]) -> list[Item]:
        """Coordinates in a band on the left for those upwards, below for those to the right."""
        found: list[Item] = []
        for k, axis in enumerate(self.view.frame.axes):
            lines: dict[float, list[Place]] = {}
            for place in places:
                if is_along(place.along, axis):
                    value = round(self.value(place, axis), 3)
                    same = next((known for known in lines if abs(known - value) < 2 * SAME_MM), value)
                    lines.setdefault(same, []).append(place)
            if not lines:
                continue
            if not any(abs(value) < SAME_MM for value in lines):
                lines[0.0] = []
            found += self._band(k, axis, dict(sorted(lines.items())))
        return found

    def _band(self, k: int, axis: np.ndarray, lines: dict[float, list[Place]]) -> list[Item]:
        zero = float(self.features.datum @ axis) * self.scale
        wanted = [zero + value * self.scale for value in lines]
        placed = spread(wanted, [PITCH_MM] * len(wanted))
        edge = self.room[1 - k]  # the view's left side for coordinates upwards, its lower side for those to the right
        found: list[Item] = []
        for (value, places), want, at in zip(lines.items(), wanted, placed, strict=True):
            text = number(value)
            if value and (tolerance := self._tolerance(places)):
                text += f" ±{number(tolerance)}"
            starts = [self.at(p)[1 - k] for place in places for p in place.points if self._level(p, axis, want)]
            start = min(starts, default=edge)
            start = start - 1.0 if start - 1.0 > edge - NEAR_MM else edge
            bend, rest = edge - NEAR_MM - 0.5, edge - FAR_MM
            path = [(start, want), (bend, want), (rest, at)]
            told = tuple(place.key for place in places)
            if k == 1:  # upwards: texts on the left, read from below
                found.append(Stroke("dimension", tuple(path)))
                left = rest - 1.0 - width_of(text, LETTER_MM)
                found.append(Text((left, at - LETTER_MM / 2), LETTER_MM, text, told=told))
            else:
                found.append(Stroke("dimension", tuple((y, x) for x, y in path)))
                low = rest - 1.0 - width_of(text, LETTER_MM)
                found.append(Text((at + LETTER_MM / 2, low), LETTER_MM, text, upright=True, told=told))
            if abs(value) < SAME_MM:
                centre = (bend, want) if k == 1 else (want, bend)
                found.append(Arc("dimension", centre, 0.8))
        return found

    def _level(self, point: np.ndarray, axis: np.ndarray, want: float) -> bool:
        return abs(float(point @ axis) * self.scale - want) < 0.01

    def _tolerance(self, places: Sequence[Place]) -> float | None:
        for place in places:
            k = int(np.argmax(np.abs(place.along)))
            found = self.controlled.tolerance(k, place.value)
            if found is not None and abs(place.along[k]) > 1.0 - 1e-6:
                return found
        return None

    def callouts(self, groups: Sequence[HoleGroup]) -> list[Item]:
        """Callouts in bands, each with its leader: on the right, and of a turned part on its left and over it, too."""
        beside: dict[bool, list[Callout]] = {False: [], True: []}
        over: list[Callout] = []
        centre, wide = (self.drawn[0] + self.drawn[2]) / 2, self.drawn[2] - self.drawn[0]
        told = self._told(groups)
        if self.features.turned:
            for one in told:
                (over if one.short else beside[one.anchor[0] < centre - 1.0 and one.at_end]).append(one)
        else:
            over = [one for one in told if wide > WIDE_MM and one.anchor[0] < centre]
            if sum(width_of(one.lines[0], LETTER_MM) for one in over) > 1.2 * wide:
                over = [one for one in over if one.short]
            beside[False] = [one for one in told if one not in over]
        return [*self._aside_of(beside[False], 1.0), *self._aside_of(beside[True], -1.0), *self._over(over)]

    def _told(self, groups: Sequence[HoleGroup]) -> list[Callout]:
        """All callouts of the view."""
        found = []
        most = CALLOUT_MM if self.features.turned or self.drawn[2] - self.drawn[0] < WIDE_MM else 45.0
        for group in groups:
            lines = [part for line in group.callout for part in wrapped(line, LETTER_MM, most)]
            bore = max(group.bores, key=lambda b: self.at(b.point)[0])
            at_end = not bore.through and is_along(bore.axis, self.features.main)
            found.append(Callout(*self._to_bore(bore), lines, tuple(self.keys(group)), False, at_end))
        for size in self.view.sizes:
            face = max(size.faces, key=lambda f: self.at(f.centre)[0])
            from_side = size.kind == "flat" or (size.kind != "ball" and is_across(face.axis, self.view.towards))
            short = from_side or not self.features.turned
            found.append(Callout(*self._to_face(face, size.kind), [size.text], (size.key,), short))
        return found

    def _aside_of(self, told: list[Callout], side: float) -> list[Item]:
        """Callouts one below another on the right (side 1) or the left (-1)."""
        told = sorted(told, key=lambda one: one.anchor[1])
        heights = spread([one.anchor[1] for one in told], [PITCH_MM * len(one.lines) + 0.8 for one in told])
        found: list[Item] = []
        edge = (self.room[2] if side > 0.0 else self.room[0]) + side * (FAR_MM + 3.0)
        for one, middle in zip(told, heights, strict=True):
            top = middle + PITCH_MM * len(one.lines) / 2
            for n, line in enumerate(one.lines):
                base = top - PITCH_MM * (n + 1) + (PITCH_MM - LETTER_MM) / 2
                left = edge if side > 0.0 else edge - width_of(line, LETTER_MM)
                found.append(Text((left, base), LETTER_MM, line, told=one.told if n == 0 else ()))
            elbow, start = (edge - side * 3.0, middle), (edge - side * 0.8, middle)
            tip = one.tip(elbow)
            found += [Stroke("dimension", (start, elbow, tip)), arrow(tip, elbow)]
        return found

    def _over(self, told: list[Callout]) -> list[Item]:
        """Callouts side by side over the view."""
        told = sorted(told, key=lambda one: one.anchor[0])
        widths = [max(width_of(line, LETTER_MM) for line in one.lines) + 4.0 for one in told]
        centres = spread([one.anchor[0] for one in told], widths)
        found: list[Item] = []
        for one, centre, width in zip(told, centres, widths, strict=True):
            base = self.room[3] + FAR_MM
            for n, line in enumerate(reversed(one.lines)):
                at = centre - width / 2 + 2.0, base + n * PITCH_MM
                found.append(Text(at, LETTER_MM, line, told=one.told if n == len(one.lines) - 1 else ()))
            start = centre, base - 1.0
            tip = one.tip(start)
            found += [Stroke("dimension", (start, tip)), arrow(tip, start)]
        return found

    def _to_bore(self, bore: Bore) -> tuple[Point, Callable[[Point], Point]]:
        """Where a bore is, and where an arrow from a point touches it."""
        if self.view.end_on(bore):
            centre, radius = self.at(bore.point), bore.widest / 2 * self.scale
            return centre, lambda point: towards(centre, point, radius)
        spans = bore.spans[bore.widest][-1]
        middle = self.at(bore.point + (spans[0] + spans[1]) / 2 * bore.axis)
        anchor, tip = higher(middle, self._aside(bore.axis, bore.widest / 2))
        return (anchor[0], anchor[1] + SLOPE_MM), tip

    def _to_face(self, face: Face, kind: str) -> tuple[Point, Callable[[Point], Point]]:
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

        far = self.room[2] + FAR_MM, max(p[1] for p in points) + SLOPE_MM
        return tip(far), tip

    def tag(self, letter: str, group: HoleGroup, items: list[Item]) -> list[Tagged]:
        """Writes a tag beside each bore of a group, where it is free."""
        rows = []
        right, up = self.view.frame.axes
        for n, (bore, key) in enumerate(zip(group.bores, self.keys(group), strict=True), 1):
            text = f"{letter}{n}"
            centre, radius = self.at(bore.point), bore.widest / 2 * self.scale
            tag = free_text(text, centre, radius, items)
            items += [tag, *tied(tag, centre, radius)]
            x, y = (float((bore.point - self.features.datum) @ axis) for axis in (right, up))
            own = [place for place in self.features.places if place.key.startswith(f"{key} ")]
            told = [tuple(place.key for place in own if is_along(place.along, axis)) for axis in (right, up)]
            rows.append(Tagged(text, x, y, (key,), *told))
        return rows
