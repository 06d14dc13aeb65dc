"""Mating patterns: whether what is drawn of two parts' holes lets their dowels, screws and pilots in at the limits.

Read off the assembly: which holes a pin or a screw goes through, and of each its zone, fit and how it is made, as its
drawing has them. A pair of parts has one pattern; the chain of `tolerances.mates` tells what play is left.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import combinations
from math import inf, sqrt

import numpy as np

from delta_cad import catalogue
from delta_cad.assembly.machine import Assembly
from delta_cad.checks.contact.features import features
from delta_cad.checks.links import carried_by_link
from delta_cad.checks.report import CheckResult
from delta_cad.dimensions.tolerances import BOARD_ZONE_MM, MOTOR_ZONE_MM, deviations_um
from delta_cad.dimensions.tolerances.general import REQUIRED, general_mm
from delta_cad.dimensions.tolerances.mates import Locators, Place, clearances_mm
from delta_cad.solids.part import Bore, Occurrence, Slot

_BOUGHT_ZONES_MM = {"motor": MOTOR_ZONE_MM, "encoder_board": BOARD_ZONE_MM}
_DOWEL, _SCREW = "dowel_", "screw_"  # part numbers of what joins
_ALONG, _AXIS_MM = 1e-6, 1e-3  # axes that count as one
_DIAMETER_MM = 1e-3
_ROUNDING_MM = 1e-9
_SHOWN = 4


@dataclass(frozen=True, eq=False)
class _Opening:
    """What of a part a pin or a screw goes through, in its link's frame.

    Attributes:
        owner: The part that has it.
        record: As it is drawn: bore or slot; None of a bought part.
        diameter_mm: Nominal, of a thread that of its screw.
        is_thread: Whether it is a thread.
        zone_mm: Zone for its axis; None: the general tolerance.
        point: (3,) where it begins.
    """

    owner: Occurrence
    record: Bore | Slot | None
    diameter_mm: float
    is_thread: bool
    zone_mm: float | None
    point: np.ndarray


@dataclass(frozen=True, eq=False)
class _Pin:
    """A dowel or a screw that joins two parts.

    Attributes:
        name: Its occurrence.
        is_dowel: Whether it is a dowel.
        point: (3,) on its axis, link's frame, mm.
        along: (3,) its axis.
        holes: What it goes through in either part.
    """

    name: str
    is_dowel: bool
    point: np.ndarray
    along: np.ndarray
    holes: tuple[_Opening, _Opening]

    @property
    def slot(self) -> Slot | None:
        """Slot that it stands in; None: both holes are round."""
        return next((one.record for one in self.holes if isinstance(one.record, Slot)), None)

    @property
    def reamed(self) -> tuple[Bore, ...]:
        """Its holes where they are made together; none where they are not."""
        (a, b), bores = self.holes, tuple(one.record for one in self.holes if isinstance(one.record, Bore))
        both = (a, b.owner.part.number), (b, a.owner.part.number)
        return bores if all(getattr(one.record, "reamed_with", "") == other for one, other in both) else ()


Pair = tuple[str, str]
"""Names of two occurrences."""


def check_mates(assembly: Assembly, general: str = REQUIRED) -> list[CheckResult]:
    """Holds every pair of parts that several pins or screws join against the limits of its holes.

    Args:
        assembly: The placed parts with their records.
        general: Class of ISO 2768-1 where a drawing states no zone.

    Returns:
        One result a kind of pair, `mates dowels of ...` or `mates screws of ...`: the play that is left in the worst
        case, mm, at the pin that has the least. Of a bought part whose maker states no zone for its holes the detail
        has the largest that the pattern bears.
    """
    patterns = dict[Pair, _Pattern]()
    for carried in carried_by_link(assembly).values():
        patterns |= {pair: _Pattern(carried, pins, general) for pair, pins in _pairs(carried).items()}
    found: dict[str, list[tuple[float, float, str]]] = defaultdict(list)
    assumed = dict[str, tuple[str, float]]()
    for pattern in patterns.values():
        located = pattern.located(patterns)
        if len(pattern.pins) < 2 and not pattern.pins[0].is_dowel:
            continue  # nothing holds where one screw goes in
        parts = " and ".join(sorted(one.owner.part.number.replace("_", " ") for one in pattern.pins[0].holes))
        if located is not None and not located.hold:
            found[f"mates dowels of {parts}"].append((-inf, -inf, located.first.name))
            continue
        for kind, name, worst, usual in pattern.clearances(located):
            found[f"mates {kind} of {parts}"].append((worst, usual, name))
            if (own := pattern.assumed) is not None:
                assumed[f"mates {kind} of {parts}"] = own
    return [_result(name, rows, assumed.get(name)) for name, rows in found.items()]


def _result(name: str, rows: Sequence[tuple[float, float, str]], assumed: tuple[str, float] | None) -> CheckResult:
    rows = sorted(rows)
    worst, usual, pin = rows[0]
    bad = [f"{own} {value:.3f}" for value, _, own in rows if value < -_ROUNDING_MM]
    failing = f"{len(bad)} of {len(rows)} do not go in at the limits: {', '.join(bad[:_SHOWN])}; " if bad else ""
    left = f"play left in the worst case, least of {len(rows)}; {usual:.3f} mm in 99.73 % of machines"
    detail = f"{failing}{left}; zones, fits and slots as drawn"
    if assumed is not None:
        part, zone = assumed
        detail += f"; holes of the {part} may lie in zones of {zone + 2.0 * worst:.3f}, {zone:g} is assumed"
    return CheckResult(name, not bad, worst, 0.0, "mm", worst_pair=(pin,), detail=detail)


class _Pattern:
    """Pins and screws that join two parts.

    Args:
        carried: All parts on their link.
        pins: Those of the pair, along one another.
        general: Class of the general tolerances.
    """

    def __init__(self, carried: Sequence[Occurrence], pins: Sequence[_Pin], general: str) -> None:
        self.pins, self._carried, self._general = pins, carried, general
        self.along = pins[0].along
        x = np.eye(3)[int(np.argmin(np.abs(self.along)))]
        x = x - (x @ self.along) * self.along
        x /= np.linalg.norm(x)
        self._plane = np.array([x, np.cross(self.along, x)])
        points = np.array([pin.point for pin in pins]) @ self._plane.T
        self._reach_mm = max((float(np.hypot(*(a - b))) for a, b in combinations(points, 2)), default=1.0)
        self._shafts = tuple(self._common())

    @property
    def assumed(self) -> tuple[str, float] | None:
        """Bought part whose holes have an assumed zone, and that zone, mm; None: neither part is one."""
        owners = (one.owner.part.number for one in self.pins[0].holes if one.record is None)
        return next(((one, _BOUGHT_ZONES_MM[one]) for one in owners if one in _BOUGHT_ZONES_MM), None)

    def located(self, others: dict[Pair, _Pattern]) -> Locators | None:
        """Gives what holds one part on the other; None: the screws alone."""
        if own := self._own():
            return own
        for pin in self.pins:
            if pin.reamed:
                return Locators(self._shafts[0]) if self._shafts else self._in_line(others)
        return Locators(self._shafts[0]) if self._shafts else None

    def _own(self) -> Locators | None:
        """Dowels that are not reamed together."""
        dowels = [pin for pin in self.pins if pin.is_dowel and not pin.reamed]
        first = next((pin for pin in dowels if pin.slot is None), None)
        if first is None:
            return None
        slotted = next((pin for pin in dowels if pin.slot is not None), None)
        return Locators(self._place(first), None if slotted is None else self._place(slotted))

    def _in_line(self, others: dict[Pair, _Pattern]) -> Locators | None:
        """The seat that is set in line with another part's, which is located on the same one, by a mandrel."""
        first, second = (one.owner for one in self.pins[0].holes)
        for own, base in ((first, second), (second, first)):
            for pair, other in others.items():
                if base.name not in pair or own.name in pair or (located := other._own()) is None or not located.hold:
                    continue
                third = next(o for o in self._carried if o.name in pair and o.name != base.name)
                for seat in _coaxial(own, third, self.along):
                    at, middle = self._flat(seat), np.mean([pin.point for pin in self.pins], axis=0)
                    way = np.subtract(self._flat(middle), at) / np.hypot(*np.subtract(self._flat(middle), at))
                    seen = other.seen_from(located, self._plane)
                    return Locators(Place("mandrel", at, seen.shift_mm(at, np.array([way, -way]))))
        return None

    def seen_from(self, located: Locators, plane: np.ndarray) -> Locators:
        """Its locators in the plane of another pattern along the same axis."""
        turn = plane @ self._plane.T

        def moved(place: Place) -> Place:
            x, y = turn @ np.array(place.at_mm)
            if place.along is None:
                return replace(place, at_mm=(x, y))
            u, v = turn @ np.array(place.along)
            return replace(place, at_mm=(x, y), along=(u, v))

        return Locators(moved(located.first), None if located.slot is None else moved(located.slot))

    def clearances(self, located: Locators | None) -> Iterator[tuple[str, str, float, float]]:
        """Gives kind, name, worst and statistical clearance of everything but what locates the first."""
        first = "" if located is None else located.first.name
        for pin in self.pins:
            if pin.name != first:
                place = self._place(pin)
                if located is not None and located.slot is not None and located.slot.name == pin.name:
                    place = located.slot
                follows = sum(bore.predrilled_mm > 0.0 for bore in pin.reamed) == 1  # drilled through the other
                kind = "dowels" if pin.is_dowel else "screws"
                yield kind, pin.name, *clearances_mm(place, None if follows else located)
        for shaft in self._shafts:
            if shaft.name != first:
                yield "pilots", shaft.name, *clearances_mm(shaft, located)

    def _place(self, pin: _Pin) -> Place:
        zones = [self._zone_mm(one) for one in pin.holes]
        place = Place(pin.name, self._flat(pin.point), sum(zones) / 2.0)
        if pin.reamed:
            drilled = [bore.predrilled_mm for bore in pin.reamed if bore.predrilled_mm]
            nominal = pin.reamed[0].diameter_mm
            play = min(
                ((nominal - one - general_mm(one, self._general)) / 2.0 for one in drilled), default=nominal / 2.0
            )
            return replace(place, play_mm=play, off_mm=place.off_mm if len(drilled) == 2 else 0.0)
        if (slot := pin.slot) is not None:
            x, y = self._plane @ _world(self._owner(pin, slot).placement, slot.along)
            thick = slot.width_mm + deviations_um("m6", slot.width_mm)[1] / 1000.0
            return replace(place, along=(float(x), float(y)), slack_mm=(slot.long_mm - thick) / 2.0)
        if pin.is_dowel:
            return place
        thread = max(one.diameter_mm for one in pin.holes if one.is_thread)
        clear = min(one.diameter_mm for one in pin.holes if not one.is_thread)
        return replace(place, play_mm=(clear - thread) / 2.0)  # ISO 273: H13, no narrower than nominal

    @staticmethod
    def _owner(pin: _Pin, slot: Slot) -> Occurrence:
        return next(one.owner for one in pin.holes if one.record is slot)

    def _zone_mm(self, one: _Opening) -> float:
        """Zone of an opening; of the general tolerance of either coordinate from the furthest of the pattern."""
        if one.zone_mm is not None:
            return one.zone_mm
        return 2.0 * sqrt(2.0) * general_mm(max(self._reach_mm, 1.0), self._general)

    def _flat(self, point: np.ndarray) -> tuple[float, float]:
        x, y = self._plane @ point
        return float(x), float(y)

    def _common(self) -> Iterator[Place]:
        """Pilots of one part in the other, and shafts through both: where, off by half of the bores' zones."""
        first, second = (one.owner for one in self.pins[0].holes)
        for inner, outer in ((first, second), (second, first)):
            for bore, point in _fits(outer, self.along):
                if _passes(inner, point, self.along, bore.diameter_mm):
                    yield Place(inner.name, self._flat(point), (_zone_mm(bore) or 0.0) / 2.0, _least_play_mm(bore))
        for bore, point in _fits(first, self.along):
            for other, at in _fits(second, self.along):
                aside = np.linalg.norm(np.cross(at - point, self.along))
                if aside > _AXIS_MM or abs(bore.diameter_mm - other.diameter_mm) > _DIAMETER_MM:
                    continue
                off = ((_zone_mm(bore) or 0.0) + (_zone_mm(other) or 0.0)) / 2.0
                play = _least_play_mm(bore) + _least_play_mm(other)
                for shaft in self._carried:
                    free = shaft.name not in (first.name, second.name)
                    free = free and not shaft.part.number.startswith((_DOWEL, _SCREW))
                    if free and _passes(shaft, point, self.along, bore.diameter_mm):
                        yield Place(shaft.name, self._flat(point), off, play)


def _pairs(carried: Sequence[Occurrence]) -> dict[Pair, list[_Pin]]:
    """Pairs of parts of a link with the pins and screws that join them."""
    pairs: dict[Pair, list[_Pin]] = defaultdict(list)
    others = [o for o in carried if not o.part.number.startswith((_DOWEL, _SCREW))]
    for o in carried:
        if not o.part.number.startswith((_DOWEL, _SCREW)):
            continue
        is_dowel, point, along = o.part.number.startswith(_DOWEL), o.placement[:3, 3], o.placement[:3, 2]
        box = o.part.solid.BoundingBox()
        shank = (box.zmin, box.zmax if is_dowel else 0.0)
        holes = [hole for other in others if (hole := _opening(o, other, point, along, shank)) is not None]
        if is_dowel:
            joined = combinations(holes, 2)
        else:
            threads = [one for one in holes if one.is_thread]
            joined = ((clear, thread) for clear in holes for thread in threads if not clear.is_thread)
        for one, other in joined:
            pairs[one.owner.name, other.owner.name].append(_Pin(o.name, is_dowel, point, along, (one, other)))
    return pairs


def _opening(
    pin: Occurrence, other: Occurrence, point: np.ndarray, along: np.ndarray, shank: tuple[float, float]
) -> _Opening | None:
    """What of a part a pin or a screw goes through; None: nothing."""
    frame, thread_mm = other.placement, _thread_mm(pin)
    for record in (record for hole in other.part.holes for record in (*hole.bores, *hole.slots)):
        start, way = frame[:3, :3] @ record.start_mm + frame[:3, 3], _world(frame, record.direction)
        if isinstance(record, Bore) and record.is_counterbore:
            continue
        begin, end = sorted(float((start + deep * way - point) @ along) for deep in (0.0, record.depth_mm))
        if np.linalg.norm(np.cross(way, along)) > _ALONG or min(end, shank[1]) - max(begin, shank[0]) < _AXIS_MM:
            continue
        off = (start - point) - ((start - point) @ along) * along
        if isinstance(record, Slot):
            lies = float(off @ _world(frame, record.along))
            across = np.linalg.norm(off - lies * _world(frame, record.along))
            if across < _AXIS_MM and abs(lies) <= (record.long_mm - record.width_mm) / 2.0 + _AXIS_MM:
                return _Opening(other, record, record.width_mm, False, record.zone_mm, start)
        elif np.linalg.norm(off) < _AXIS_MM:
            size = thread_mm if record.thread else record.diameter_mm
            return _Opening(other, record, size, bool(record.thread), _zone_mm(record), start)
    if (zone := _BOUGHT_ZONES_MM.get(other.part.number)) is None:
        return None
    for face in (face.moved(frame) for face in features(other.part.solid).cylinders if face.is_hollow):
        aside = float(np.linalg.norm(np.cross(face.point - point, along)))
        if aside < _AXIS_MM and np.linalg.norm(np.cross(face.direction, along)) < _ALONG:
            is_thread = 2.0 * face.radius_mm < thread_mm
            return _Opening(other, None, thread_mm if is_thread else 2.0 * face.radius_mm, is_thread, zone, face.point)
    return None


def _zone_mm(bore: Bore) -> float | None:
    """Zone of a bore's axis; of a datum, from which others have their places, the one in which it is square."""
    return bore.zone_mm or (bore.square_mm if bore.zone_mm == 0.0 else None)


def _thread_mm(pin: Occurrence) -> float:
    """Thread of a screw, mm; 0 of a dowel."""
    number = pin.part.number
    if not number.startswith(_SCREW):
        return 0.0
    size = number.removeprefix(_SCREW).rpartition("x")[0].removeprefix("low-")
    return catalogue.screw(size).diameter_mm


def _fits(o: Occurrence, along: np.ndarray) -> Iterator[tuple[Bore, np.ndarray]]:
    """Bores of a part to a fit, along an axis, with where they begin in the link's frame; none that is a dowel's."""
    for bore in (bore for hole in o.part.holes for bore in hole.bores):
        way = _world(o.placement, bore.direction)
        if bore.fit and not bore.reamed_with and np.linalg.norm(np.cross(way, along)) < _ALONG:
            yield bore, o.placement[:3, :3] @ bore.start_mm + o.placement[:3, 3]


def _coaxial(one: Occurrence, other: Occurrence, along: np.ndarray) -> Iterator[np.ndarray]:
    """Where seats of two parts, bored as their datums, are in line."""
    for bore, point in _fits(one, along):
        for facing, at in _fits(other, along):
            if bore.zone_mm == facing.zone_mm == 0.0 and np.linalg.norm(np.cross(at - point, along)) < _AXIS_MM:
                yield point


def _passes(inner: Occurrence, point: np.ndarray, along: np.ndarray, diameter_mm: float) -> bool:
    """Whether a part has a round face of a diameter on an axis."""
    faces = (face.moved(inner.placement) for face in features(inner.part.solid).cylinders if not face.is_hollow)
    return any(
        abs(2.0 * face.radius_mm - diameter_mm) < _DIAMETER_MM
        and np.linalg.norm(np.cross(face.point - point, along)) < _AXIS_MM
        and np.linalg.norm(np.cross(face.direction, along)) < _ALONG
        for face in faces
    )


def _least_play_mm(bore: Bore) -> float:
    """Least radial play of a shaft h in a bore."""
    return 0.0 if bore.deviations_um is None else bore.deviations_um[0] / 2000.0


def _world(frame: np.ndarray, direction: Sequence[float]) -> np.ndarray:
    return frame[:3, :3] @ np.array(direction)
