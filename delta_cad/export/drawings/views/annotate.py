"""The annotations of a view, arranged around it.

Coordinates stand in bands on the left of a view and below it, counted from the datum; callouts in one on its right, or
over it, each with its leader. A band grows with what it holds and its texts are spread by their true sizes, so that
they cannot overlap.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import hypot

import numpy as np

from delta_cad.export.drawings.part.controlled import Controlled, Length
from delta_cad.export.drawings.part.faces import is_across, is_along, is_straight
from delta_cad.export.drawings.part.holes import HoleGroup
from delta_cad.export.drawings.part.record import SAME_MM, Place
from delta_cad.export.drawings.sheet_io.lettering import width_of
from delta_cad.export.drawings.sheet_io.sheet import (
    Annotation,
    Arc,
    Item,
    Measure,
    Point,
    Primitive,
    Stroke,
    Text,
    lines_of,
    scaled,
)
from delta_cad.export.drawings.views.leader_targets import FAR_MM, LeaderTargets
from delta_cad.export.drawings.views.leaders import Leader, in_turn, untangled
from delta_cad.export.drawings.views.lines import (
    BASE_MM,
    PITCH_MM,
    TRIANGLE_MM,
    Flag,
    Line,
    boxed,
    broken,
    length_of,
    lines_of_group,
    set_line,
    tolerances_of,
    triangle,
)
from delta_cad.export.drawings.views.marks import LETTER_MM, arrow, free_text, number, spread, tied

_CALLOUT_MM = 62.0  # longest line of a callout
_WIDE_MM = 70.0  # of a view from which on callouts of what lies in its left half stand over it
_WITHIN_MM = 9.0  # radius of a bore on paper from which on its tag stands in it
_NEAR_MM = 2.0  # from a view to where its extension lines bend
_THREAD = re.compile(r"^(?:\d+x )?M(\d+(?:\.\d+)?)")


@dataclass
class Tagged:
    """One row of a table of holes.

    Attributes:
        tag: Its tag.
        at: Coordinates to the right and up from the datum, mm.
        states: Keys that the tag tells.
        reported: Keys that each coordinate tells.
        exact: Whether each coordinate is theoretically exact.
    """

    tag: str
    at: tuple[float, float]
    states: tuple[str, ...]
    reported: tuple[tuple[str, ...], tuple[str, ...]]
    exact: tuple[bool, bool]


@dataclass
class _Callout:
    """What is told at the end of a leader: about where it points, where its arrow ends, coming from a point; its lines.

    `short` ones may stand over the view; of a turned part, those `at_end` are bored from an end. `measure` gives what
    is measured for the arrow's tip; `outward` is the way out of a datum's plane, whose leader ends in a triangle.
    """

    anchor: Point
    tip: Callable[[Point], Point]
    lines: list[Line]
    states: tuple[str, ...]
    short: bool = False
    at_end: bool = False
    measure: Callable[[Point], Measure | None] = lambda _: None
    outward: Point | None = None

    def drawn(self, leader: tuple[Point, ...], texts: list[Item]) -> list[Item]:
        """Gives its texts, and its leader to the tip that it ends in; as a dimension where it measures something."""
        tip, last = leader[-1], leader[-2]
        if self.outward is not None:
            tip = tip[0] + TRIANGLE_MM[1] * self.outward[0], tip[1] + TRIANGLE_MM[1] * self.outward[1]
            return [*texts, Stroke("dimension", (*leader[:-1], tip)), triangle(leader[-1], self.outward)]
        line: list[Primitive] = [Stroke("dimension", leader), arrow(tip, last)]
        own = [item for item in texts if isinstance(item, Text)]
        measure = self.measure(tip)
        if measure is None or not own:
            return [*texts, *line]
        others = [item for item in texts if not isinstance(item, Text)]
        return [Annotation("dimension", (*own, *line), measure), *others]


@dataclass
class Annotator(LeaderTargets):
    """What the texts of one view are set out with."""

    controlled: Controlled

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
            nominal = next((float(match[1]) for line in group.callout if (match := _THREAD.match(line))), None)
            for bore in group.bores if nominal is not None else ():
                if nominal is not None and self.view.end_on(bore) and self._left(bore.point) and nominal > bore.widest:
                    found.append(Arc("dimension", self.at(bore.point), nominal / 2 * self.scale, 0.0, 270.0))
        return found

    def _left(self, point: np.ndarray) -> bool:
        """Whether a point is on what is left of a part that is cut open."""
        return self.view.cut is None or float(point @ self.view.towards) < self.view.cut.depth_at(point) + SAME_MM

    def _in_cut(self, point: np.ndarray) -> bool:
        """Whether a bore's axis lies in the plane in which the view is cut open."""
        return (
            self.view.cut is not None
            and abs(float(point @ self.view.towards) - self.view.cut.depth_at(point)) < SAME_MM
        )

    def value(self, place: Place, axis: np.ndarray) -> float:
        """What a coordinate counts along an axis of the view, from the datum, mm."""
        sense = 1.0 if float(place.along @ axis) > 0.0 else -1.0
        return sense * (place.value - float(self.features.datum @ place.along))

    def ordinates(self, places: Sequence[Place]) -> list[Item]:
        """Coordinates in a band on the left for those upwards, below for those to the right."""
        found: list[Item] = []
        for k, axis in enumerate(self.view.frame.axes):
            lines: dict[tuple[float, bool], list[Place]] = {}
            for place in places:
                if is_along(place.along, axis):
                    value = round(self.value(place, axis), 3)
                    exact = place.key in self.features.exact and abs(value) > SAME_MM  # 0 is exact without a frame
                    near = (known for known in lines if known[1] == exact and abs(known[0] - value) < 2 * SAME_MM)
                    lines.setdefault(next(near, (value, exact)), []).append(place)
            if not lines:
                continue
            if not any(abs(value) < SAME_MM for value, _ in lines):
                lines[0.0, False] = []
            found += self._band(k, axis, dict(sorted(lines.items())))
        return found

    def _band(self, k: int, axis: np.ndarray, lines: dict[tuple[float, bool], list[Place]]) -> list[Item]:
        zero = float(self.features.datum @ axis) * self.scale
        wanted = [zero + value * self.scale for value, _ in lines]
        placed = spread(wanted, [PITCH_MM] * len(wanted))
        edge = self.room[1 - k]  # the view's left side for coordinates upwards, its lower side for those to the right
        found: list[Item] = []
        for ((value, exact), places), want, at in zip(lines.items(), wanted, placed, strict=True):
            text = number(value)
            if value and (held := self._held(places)):
                text += f" {held.text}"
            starts = [self.at(p)[1 - k] for place in places for p in place.points if self._level(p, axis, want)]
            start = min(starts, default=edge)
            start = start - 1.0 if start - 1.0 > edge - _NEAR_MM else edge
            bend, rest = edge - _NEAR_MM - 0.5, edge - FAR_MM
            path = [(start, want), (bend, want), (rest, at)]
            wording = tuple(place.key for place in places)
            low = rest - 1.0 - width_of(text, LETTER_MM)
            if k == 1:  # upwards: texts on the left, read from below
                letters = Text((low, at - LETTER_MM / 2), LETTER_MM, text, states=wording)
            else:
                path = [(y, x) for x, y in path]
                letters = Text((at + LETTER_MM / 2, low), LETTER_MM, text, upright=True, states=wording)
            drawn: list[Primitive] = [Stroke("dimension", tuple(path)), letters]
            if abs(value) < SAME_MM:
                drawn.append(Arc("dimension", path[1], 0.8))
            if exact:
                drawn.append(boxed(letters))
            origin = (path[0][0], zero) if k == 1 else (zero, path[0][1])
            measure = Measure("up" if k else "right", (origin, path[0], path[-1]), abs(value), text)
            found.append(Annotation("dimension", tuple(drawn), measure))
        return found

    def _level(self, point: np.ndarray, axis: np.ndarray, want: float) -> bool:
        return abs(float(point @ axis) * self.scale - want) < 0.01

    def _held(self, places: Sequence[Place]) -> Length | None:
        straight = (place for place in places if is_straight(place.along))
        found = (self.controlled.length(int(np.argmax(np.abs(place.along))), place.value) for place in straight)
        return next((length for length in found if length is not None), None)

    def callouts(self, groups: Sequence[HoleGroup]) -> list[Item]:
        """Callouts in bands, each with its leader: on the right, and of a turned part on its left and over it, too."""
        adjacent: dict[bool, list[_Callout]] = {False: [], True: []}
        over: list[_Callout] = []
        centre, wide = (self.drawn[0] + self.drawn[2]) / 2, self.drawn[2] - self.drawn[0]
        wording = self._callouts(groups)
        if self.features.turned:
            for one in wording:
                (over if one.short else adjacent[one.anchor[0] < centre - 1.0 and one.at_end]).append(one)
        else:
            over = [one for one in wording if wide > _WIDE_MM and one.anchor[0] < centre]
            if sum(length_of(one.lines[0]) for one in over) > 1.2 * wide:
                over = [one for one in over if one.short]
            adjacent[False] = [one for one in wording if one not in over]
        bands: list[Callable[[list[Leader]], list[Item]]] = [
            lambda lines: self._aside_of(adjacent[False], 1.0, lines),
            lambda lines: self._aside_of(adjacent[True], -1.0, lines),
            lambda lines: self._over(over, lines),
        ]
        return [item for items in in_turn(bands, ((2, 0, 1), (0, 1, 2))) for item in items]

    def _callouts(self, groups: Sequence[HoleGroup]) -> list[_Callout]:
        """All callouts of the view."""
        found = []
        most = _CALLOUT_MM if self.features.turned or self.drawn[2] - self.drawn[0] < _WIDE_MM else 45.0
        for group in groups:
            lines = lines_of_group(group, self.features, most)
            bore = max(group.bores, key=lambda b: self.at(b.point)[0])
            at_end = not bore.through and is_along(bore.axis, self.features.main)
            measure = self.across_bore(bore)
            found.append(_Callout(*self.to_bore(bore), lines, tuple(self.keys(group)), False, at_end, measure))
        for size in self.view.sizes:
            face = max(size.faces, key=lambda f: self.at(f.centre)[0])
            from_side = size.kind == "flat" or (size.kind != "ball" and is_across(face.axis, self.view.towards))
            short = from_side or not self.features.turned
            lines = [*broken(size.text, most), *tolerances_of(size.faces, self.features)]
            measure = self.across_face(face, size.text, size.kind)
            found.append(_Callout(*self.to_face(face, size.kind), lines, (size.key,), short, measure=measure))
        return [*found, *self._planes()]

    def _planes(self) -> list[_Callout]:
        """Datums and tolerances of planes, at the edge as which each is seen."""
        found = []
        for face in self.view.planes:
            u, v = self.view.frame.axes @ face.axis
            places = self.edge(face)
            lines: list[Line] = [
                Flag(line.datum, line.adjacent, suspended=line.adjacent is not None) if isinstance(line, Flag) else line
                for line in tolerances_of([face], self.features)
            ]
            outward = (float(u), float(v)) if any(isinstance(line, Flag) for line in lines) else None

            def tip(point: Point, places: Sequence[Point] = places) -> Point:
                return min(places, key=lambda p: hypot(p[0] - point[0], p[1] - point[1]))

            far = self.room[2] + FAR_MM, max(y for _, y in places)
            found.append(_Callout(tip(far), tip, lines, (), self.features.turned, outward=outward))
        return found

    def _edges(self) -> np.ndarray:
        """(n, 2, 2) visible edges and centre lines of the view, along which no leader should run."""
        drawn = (i for i in self.view.items if isinstance(i, Stroke | Arc) and i.layer == "visible")
        centres = (i for i in self.centre_lines() if isinstance(i, Stroke))
        return lines_of([*(scaled(item, self.scale) for item in drawn), *centres])

    def _aside_of(self, wording: list[_Callout], side: float, lines: list[Leader]) -> list[Item]:
        """Callouts one below another on the right (side 1) or the left (-1); their leaders join those that are set."""
        edge = (self.room[2] if side > 0.0 else self.room[0]) + side * (FAR_MM + 3.0)

        def heights(order: Sequence[int], places: Sequence[float]) -> list[float]:
            return spread(places, [PITCH_MM * len(wording[k].lines) + 0.8 for k in order])

        def leaders(order: Sequence[int], places: Sequence[float]) -> list[Leader]:
            levels = [(k, y) for k, y in zip(order, heights(order, places), strict=True)]
            return [((edge - side * 0.8, y), e := (edge - side * 3.0, y), wording[k].tip(e)) for k, y in levels]

        order, places = untangled([one.anchor[1] for one in wording], leaders, self._edges(), lines)
        lines += leaders(order, places)
        found: list[Item] = []
        for k, middle, leader in zip(order, heights(order, places), leaders(order, places), strict=True):
            one = wording[k]
            top = middle + PITCH_MM * len(one.lines) / 2
            texts: list[Item] = []
            for n, line in enumerate(one.lines):
                left = edge if side > 0.0 else edge - length_of(line)
                texts += set_line(line, (left, top - PITCH_MM * (n + 1) + BASE_MM), one.states if n == 0 else ())
            found += one.drawn(leader, texts)
        return found

    def _over(self, wording: list[_Callout], lines: list[Leader]) -> list[Item]:
        """Callouts side by side over the view; their leaders join those that are set."""
        base = self.room[3] + FAR_MM
        widths = [max(map(length_of, one.lines)) + 4.0 for one in wording]

        def centres(order: Sequence[int], places: Sequence[float]) -> list[float]:
            return spread(places, [widths[k] for k in order])

        def leaders(order: Sequence[int], places: Sequence[float]) -> list[Leader]:
            starts = [(k, (x, base - 1.0)) for k, x in zip(order, centres(order, places), strict=True)]
            return [(start, wording[k].tip(start)) for k, start in starts]

        order, places = untangled([one.anchor[0] for one in wording], leaders, self._edges(), lines)
        lines += leaders(order, places)
        found: list[Item] = []
        for k, centre, leader in zip(order, centres(order, places), leaders(order, places), strict=True):
            one, texts = wording[k], list[Item]()
            for n, line in enumerate(one.lines):
                at = centre - widths[k] / 2 + 2.0, base + (len(one.lines) - 1 - n) * PITCH_MM
                texts += set_line(line, at, one.states if n == 0 else ())
            found += one.drawn(leader, texts)
        return found

    def tag(self, letter: str, group: HoleGroup, items: list[Item]) -> list[Tagged]:
        """Writes a tag beside each bore of a group, where it is free."""
        rows = []
        right, up = self.view.frame.axes
        for n, (bore, key) in enumerate(zip(group.bores, self.keys(group), strict=True), 1):
            text = f"{letter}{n}"
            centre, radius = self.at(bore.point), bore.widest / 2 * self.scale
            # within a large bore: beside it, it would be taken for another's
            tag = free_text(text, centre, 0.0 if radius > _WITHIN_MM else radius, items)
            items += [tag, *tied(tag, centre, radius)]
            x, y = (float((bore.point - self.features.datum) @ axis) for axis in (right, up))
            own = [place for place in self.features.places if place.key.startswith(f"{key} ")]
            reported = [tuple(place.key for place in own if is_along(place.along, axis)) for axis in (right, up)]
            exact = [
                abs(value) > SAME_MM and any(one in self.features.exact for one in keys)
                for value, keys in zip((x, y), reported, strict=True)
            ]
            rows.append(Tagged(text, (x, y), (key,), (reported[0], reported[1]), (exact[0], exact[1])))
        return rows
