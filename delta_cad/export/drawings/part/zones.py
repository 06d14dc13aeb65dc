"""Datums and geometric tolerances of a part, as its function requires.

Each bore states its own zone. A plate: its seat, or its largest plane across the widest fitted bore, is A, that bore is
square to it and B; of the others a slot along it, or the widest fitted, has its place from both and is C, the rest,
screws' holes among them, have theirs from all. Where the widest are a pattern, it has its place from A and the two
sides that coordinates count from, or within itself, ISO 5458; the others have theirs from A and that pattern. A turned
part: the axis of what is fitted is A, what has to be on that axis or square to it has its zone. Where a zone of
position lies is told by exact coordinates.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf

import numpy as np

from delta_cad.common.vectors import cross, cross_length
from delta_cad.export.drawings.part.controlled import Controlled
from delta_cad.export.drawings.part.faces import Face, is_across, is_along
from delta_cad.export.drawings.part.holes import HoleGroup
from delta_cad.export.drawings.part.record import SAME_MM, Datum, Features, Zone
from delta_cad.export.drawings.part.shape import unit
from delta_cad.solids.boring import axes
from delta_cad.solids.part import Bore, Part, Slot

_DATUM_SHARE = 0.5  # of the largest plane's area, from which on one that a bore opens in is the datum


@dataclass(frozen=True)
class _Fitted:
    """Bores of one group, diameter and zone, `Bore.zone_mm`."""

    record: Bore
    faces: tuple[Face, ...]
    count: int

    @property
    def zone_mm(self) -> float:
        """Diameter of the zone for their axes."""
        return self.record.zone_mm or 0.0


def add_zones(found: Features, part: Part, held: Controlled) -> None:
    """Adds datums and geometric tolerances to what a part's drawing has to tell."""
    fitted = _fitted(found, part)
    if found.turned:
        _turned(found, fitted, held)
    elif fitted:
        _plate(found, fitted, [slot for hole in part.holes for slot in hole.slots], held)


def _plate(found: Features, fitted: Sequence[_Fitted], slots: Sequence[Slot], held: Controlled) -> None:
    if held.seat is not None:  # what is bored into the seat comes first
        across = held.seat[0]
        fitted = sorted(fitted, key=lambda one: abs(one.record.direction[across]) < 1.0 - 1e-9)
    first, *others = fitted
    base = _plane(found, first, held.seat)
    if base is None:
        return
    found.datums.append(Datum("A", (base,)))
    if first.count == 1:
        _add_square(found, first)
        letters = "A" + _datum(found, first.faces)
    else:
        sides = "".join(_datum(found, (face,)) for face in _sides(found, base))
        _add(found, "position", first.zone_mm, first.faces, "A" + sides, combined=not sides)
        letters = "A" + (_datum(found, first.faces) if others else "")
    fixed = first.count > 1  # whether what counts from the letters cannot turn about the first
    for one in sorted(slots, key=lambda one: one.direction != first.record.direction):  # its own holds the turn
        walls = tuple(face for face in found.faces if is_wall(face, one))
        _add(found, "position", one.zone_mm, walls, letters, is_round=False)
        if not fixed:
            letters, fixed = letters + _datum(found, walls), True
    for one in others:
        _add_square(found, one)
        _add(found, "position", one.zone_mm, one.faces, letters, combined=one.count > 1 and not fixed)
        if not fixed and one.record.deviations_um is not None and one is not others[-1]:
            letters, fixed = letters + _datum(found, one.faces), True
    found.exact = _exact(found)


def _add_square(found: Features, one: _Fitted) -> None:
    """Adds how square a bore is to A, where that is stated."""
    if one.record.square_mm:
        _add(found, "perpendicularity", one.record.square_mm, one.faces, "A")


def _datum(found: Features, faces: Sequence[Face]) -> str:
    """Adds the next datum and gives its letter."""
    letter = chr(ord("A") + len(found.datums))
    found.datums.append(Datum(letter, tuple(faces)))
    return letter


def _sides(found: Features, base: Face) -> list[Face]:
    """Planes across a base that coordinates count from both ways, the larger first; none where one counts otherwise."""
    sides = []
    for k, at in enumerate(found.datum):
        if is_along(unit(k), base.axis):
            continue
        planes = [f for f in found.faces if f.kind == "plane" and is_along(f.axis, unit(k))]
        planes = [face for face in planes if abs(float(face.point[k] - at)) < SAME_MM]
        if not planes:
            return []
        sides.append(max(planes, key=lambda face: round(face.area, 6)))
    return sorted(sides, key=lambda face: -round(face.area, 6))


def _exact(found: Features) -> set[str]:
    """Coordinates of the bores that have a zone of position, or that it counts from, and of planes along their ways."""
    zones = [zone for zone in found.zones if zone.kind == "position"]
    letters = {letter for zone in zones for letter in zone.datums}
    datums = [datum.faces for datum in found.datums if datum.letter in letters]
    walls = {id(face) for faces in (*(zone.faces for zone in zones), *datums) for face in faces}
    keys = []
    for g, group in enumerate(found.groups):
        keys += [f"bore {g}.{b} " for b, bore in enumerate(group.bores) if any(id(f) in walls for f in bore.faces)]
    exact = {place.key for place in found.places if any(place.key.startswith(key) for key in keys)}
    planes = [faces[0] for faces in datums if faces[0].kind == "plane"]
    for plane in planes:
        level = [p for p in found.places if p.end_on is None and is_along(p.along, plane.axis)]
        level = [place for place in level if abs(place.value - float(plane.point @ place.along)) < SAME_MM]
        if any(is_across(face.axis, plane.axis) for zone in zones for face in zone.faces):
            exact |= {place.key for place in level}
    return exact


def is_wall(face: Face, slot: Slot) -> bool:
    """Whether a plane is a long side of a slot."""
    across = cross(np.array(slot.direction), np.array(slot.along))
    apart = face.middle - np.array(slot.start_mm)
    return (
        face.kind == "plane"
        and is_along(face.axis, across)
        and abs(abs(float(apart @ across)) - slot.width_mm / 2.0) < SAME_MM
        and abs(float(apart @ np.array(slot.along))) < slot.long_mm / 2.0
        and 0.0 < float(apart @ np.array(slot.direction)) < slot.depth_mm
    )


def _turned(found: Features, fitted: Sequence[_Fitted], held: Controlled) -> None:
    faces = next((one.faces for one in fitted if one.record.fit), ())
    if not faces:
        own = (size for size in found.sizes if size.tolerance is not None and size.tolerance.fit)
        faces = next((tuple(size.faces) for size in own), ())
    if not faces or not (held.coaxial or held.shoulder is not None):
        return
    found.datums.append(Datum("A", faces))
    for diameter, wide in held.coaxial:
        round_ = [f for f in found.faces if f.kind == "cylinder" and is_along(f.axis, found.main)]
        same = tuple(f for f in round_ if abs(2 * f.radius - diameter) < SAME_MM)
        if same:
            _add(found, "coaxiality", wide, same, "A")
    for face in found.faces:
        at, zone = held.shoulder or (inf, 0.0)
        if face.kind == "plane" and abs(float(face.point @ found.main) - at) < SAME_MM:
            _add(found, "perpendicularity", zone, (face,), "A", is_round=False)
            return


def _add(
    found: Features,
    kind: str,
    value: float,
    faces: Sequence[Face],
    letters: str,
    *,
    is_round: bool = True,
    combined: bool = False,
) -> None:
    key = f"zone {len(found.zones) + 1}"
    found.zones.append(Zone(kind, value, is_round, tuple(faces), tuple(letters), key, combined))


def _fitted(found: Features, part: Part) -> list[_Fitted]:
    """Bores with a zone, by group, diameter and zone: datums, those of a class, of own deviations; the widest first."""
    records = [bore for hole in part.holes for bore in hole.bores if bore.zone_mm is not None]
    fitted: list[_Fitted] = []
    for group in found.groups:
        for diameter in group.diameters:
            own = [record for record in records if _is_of(record, group, diameter)]
            for zone in sorted({record.zone_mm or 0.0 for record in own}):
                same = [record for record in own if record.zone_mm == zone]
                walls = [face for bore in group.bores for face in bore.faces if _is_in(face, same)]
                fitted.append(_Fitted(same[0], tuple(walls), axes(same)))

    def order(one: _Fitted) -> tuple[bool, bool, bool, float, int]:
        bore = one.record
        return bool(bore.zone_mm), bore.deviations_um is None, not bore.fit, -bore.diameter_mm, one.count

    return sorted(fitted, key=order)


def _is_in(face: Face, records: Sequence[Bore]) -> bool:
    """Whether a wall is that of one of some bores."""

    def is_of(record: Bore) -> bool:
        start, way = np.array(record.start_mm), np.array(record.direction)
        same = is_along(face.axis, way) and cross_length(face.point - start, way) < SAME_MM
        along = 0.0 < float((face.middle - start) @ way) < record.depth_mm
        return same and along and abs(2 * face.radius - record.diameter_mm) < SAME_MM

    return any(map(is_of, records))


def _is_of(record: Bore, group: HoleGroup, diameter: float) -> bool:
    if abs(record.diameter_mm - diameter) > SAME_MM:
        return False
    start, way = np.array(record.start_mm), np.array(record.direction)
    return any(is_along(bore.axis, way) and cross_length(start - bore.point, way) < SAME_MM for bore in group.bores)


def _plane(found: Features, first: _Fitted, seat: tuple[int, float] | None) -> Face | None:
    """The seat, or the largest plane across a bore, that it opens in where this is large, too.

    Of bores that are not along one another it is the largest across the way that most of the part is seen from.
    """
    way = np.array(first.record.direction)
    if not all(is_along(face.axis, way) for face in first.faces):
        way = found.main
    square = [face for face in found.faces if face.kind == "plane" and is_along(face.axis, way)]
    if seat is not None:
        square = [face for face in square if abs(float(face.point[seat[0]]) - seat[1]) < SAME_MM]
    if not square:
        return None
    largest = max(square, key=lambda face: round(face.area, 6))
    opens = [face for face in square if float(face.axis @ way) < 0.0 and face.area > _DATUM_SHARE * largest.area]
    return largest if first.record.through or not opens else max(opens, key=lambda face: round(face.area, 6))
