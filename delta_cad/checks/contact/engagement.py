"""Parts that hold, guide or carry one another do so: each declared contact has its least length or area, and no gap.

Lengths and areas are read off the exact faces at the exported position; equal pairs in equal positions once.
"""

# pyright: reportAttributeAccessIssue=false
# OCP builds its modules at run time, so a type checker does not see their names

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from delta_cad.assembly.faces import SolidFace
from delta_cad.assembly.machine import Assembly
from delta_cad.checks.contact.features import Features, features
from delta_cad.checks.contact.placing import Key, relative_key
from delta_cad.checks.contact.shared_volume import area, common_size
from delta_cad.checks.report import CheckResult
from delta_cad.dimensions.cable_run import FLEET_LIMIT_RAD
from delta_cad.solids.part import Contact, location_of

_ALONG = 1e-3  # sine of the angle between axes or normals that count as one: 0.02 mm over a seat of 20 mm
_INSIDE_MM = 1e-6  # by which a shaft may be drawn larger than its bore: roundings; more is the overlap's matter
_LEAST_TURN_RAD = 3.0  # of a bore's faces together: less than half a turn holds nothing
_STEP_MM = 0.5  # between the points of a cable that are looked at
_NOISE_MM2 = 1e-3  # by which the kernel's areas of one pair of faces may disagree
_SHOWN = 8  # faults that a report names; their number is told


def check_contacts(assembly: Assembly) -> CheckResult:
    """Holds every declared contact against its least engaged length or area within its largest gap.

    Returns:
        `contacts engaged`: the smallest share of the asked length or area that any contact has; 1 is asked.
    """
    known = dict[Key, float]()
    occurrences = {o.name: o for o in assembly.occurrences}
    placed = assembly.poses(assembly.home_mm)
    shares: list[tuple[float, Contact, str]] = []
    for contact in assembly.contacts:
        missing = [name for name in (contact.a, contact.b) if name not in occurrences]
        if missing:
            shares.append((0.0, contact, f"{' and '.join(missing)} is missing: {contact.reason}"))
            continue
        a, b = occurrences[contact.a], occurrences[contact.b]
        a_in_b = np.linalg.inv(placed[b.name]) @ placed[a.name]
        key = (contact.kind, contact.gap_mm, id(a.part), id(b.part), *relative_key("", "", a_in_b))
        if key not in known:
            known[key] = _MEASURES[contact.kind](features(a.part.solid), features(b.part.solid), a_in_b, contact.gap_mm)
        unit = "mm" if contact.kind in ("cylinder", "cable", "tip") else "mm^2"
        text = (
            f"{a.name} / {b.name} {known[key]:.2f} {unit} within {contact.gap_mm:g} mm, {contact.least:.2f} required: "
            f"{contact.reason}"
        )
        shares.append((known[key] / contact.least, contact, text))
    name, counted = "contacts engaged", f"{len(shares)} contacts, {len(known)} different ones"
    if not shares:
        return CheckResult(name, False, None, 1.0, "", detail="the assembly declares no contact")
    shares.sort(key=lambda share: share[0])
    worst, contact, text = shares[0]
    bad = [text for share, _, text in shares if share < 1.0]
    detail = f"{len(bad)} fail: {'; '.join(bad[:_SHOWN])}; {counted}" if bad else f"least: {text}; {counted}"
    return CheckResult(name, not bad, worst, 1.0, "", worst_pair=(contact.a, contact.b), detail=detail)


def cylinder_length(a: Features, b: Features, a_in_b: np.ndarray, gap_mm: float) -> float:
    """Length of the longest engagement, along one axis, of outer cylinders of a in bores of b, mm.

    The gap is that of the radii, and of the axes at the ends of what is engaged.
    """
    bores = [c for c in b.cylinders if c.is_hollow]
    best = 0.0
    for shaft in (c.moved(a_in_b) for c in a.cylinders if not c.is_hollow):
        held = [(bore, span) for bore in bores if (span := _engaged(shaft, bore, gap_mm))]
        if sum(bore.turn_rad for bore, _ in held) >= _LEAST_TURN_RAD:
            best = max(best, _union(span for _, span in held))
    return best


def _engaged(shaft: SolidFace, bore: SolidFace, gap_mm: float) -> tuple[float, float] | None:
    """Where along the shaft's axis a bore holds it within a gap, mm from the shaft's point; None where it does not."""
    cosine = float(bore.direction @ shaft.direction)
    play = bore.radius_mm - shaft.radius_mm
    if not -_INSIDE_MM <= play <= gap_mm or np.linalg.norm(np.cross(bore.direction, shaft.direction)) > _ALONG:
        return None
    apart = bore.point - shaft.point
    along = float(apart @ shaft.direction)
    ends = sorted(along + np.sign(cosine) * v for v in (bore.start_mm, bore.end_mm))
    low, high = max(ends[0], shaft.start_mm), min(ends[1], shaft.end_mm)
    if high <= low:
        return None
    for at in (low, high):  # the axes' distance at either end of what is engaged
        line = apart - at * shaft.direction
        if np.linalg.norm(line - (line @ bore.direction) * bore.direction) > max(gap_mm, _INSIDE_MM):
            return None
    return low, high


def _union(spans: Iterator[tuple[float, float]]) -> float:
    """Length of a union of intervals."""
    length, reached = 0.0, -np.inf
    for low, high in sorted(spans):
        length += max(high - max(low, reached), 0.0)
        reached = max(reached, high)
    return length


def common_area(a: Features, b: Features, a_in_b: np.ndarray, gap_mm: float) -> float:
    """Area over which plane faces of two parts lie upon one another, the gap along their normal, mm^2."""
    turn, shift = a_in_b[:3, :3], a_in_b[:3, 3]
    shared = 0.0
    for one in a.planes:
        normal, point = turn @ one.direction, turn @ one.point + shift
        for other in b.planes:
            gap = float((point - other.point) @ other.direction)
            if normal @ other.direction < -np.sqrt(1.0 - _ALONG**2) and abs(gap) <= gap_mm:
                onto = a_in_b.copy()
                onto[:3, 3] -= gap * other.direction
                shared += _common_of_faces(one, other, onto)
    return shared


def _common_of_faces(one: SolidFace, other: SolidFace, onto: np.ndarray) -> float:
    """Area that two faces of one plane share, the first moved by a (4, 4) frame, mm^2; 0 where the kernel fails."""
    from OCP.Bnd import Bnd_Box
    from OCP.BRepBndLib import BRepBndLib

    a, b = one.face.wrapped.Moved(location_of(onto)), other.face.wrapped  # type: ignore[attr-defined]
    boxes = Bnd_Box(), Bnd_Box()
    for box, face in zip(boxes, (a, b), strict=True):
        BRepBndLib.Add_s(face, box)
    if boxes[0].IsOut(boxes[1]):
        return 0.0
    return common_size((a, b), (area(a), area(b)), area, _NOISE_MM2) or 0.0


def seat_area(a: Features, b: Features, a_in_b: np.ndarray, gap_mm: float) -> float:
    """Area of the spherical seats of b in which a ball of a lies, the gap of radii and of centres, mm^2."""
    seated = 0.0
    for ball in (s for s in a.spheres if not s.is_hollow):
        centre = a_in_b[:3, :3] @ ball.point + a_in_b[:3, 3]
        for seat in (s for s in b.spheres if s.is_hollow):
            fits = -_INSIDE_MM <= seat.radius_mm - ball.radius_mm <= gap_mm
            if fits and np.linalg.norm(seat.point - centre) <= gap_mm:
                seated += seat.area_mm2
    return seated


def cable_length(a: Features, b: Features, a_in_b: np.ndarray, gap_mm: float) -> float:
    """Length of a cable a, of arcs and straight pieces, that lies on round faces of b or fills bores of it, mm.

    The gap is that of the cable's surface from the face, either way.
    """
    length = 0.0
    for points, step, radius in (*map(_middle, a.tori), *(_axis(c) for c in a.cylinders if not c.is_hollow)):
        points = points @ a_in_b[:3, :3].T + a_in_b[:3, 3]
        lies = np.zeros(len(points), dtype=bool)
        for cylinder in b.cylinders:
            lies |= _along(points, cylinder, radius, gap_mm)
        length += step * lies.sum()
    return length


def _middle(arc: SolidFace) -> tuple[np.ndarray, float, float]:
    """(n, 3) points along the middle of an arc, mm, each in the middle of its step, that step and the radius, mm."""
    count = max(int(arc.ring_mm * arc.turn_rad / _STEP_MM), 1)
    angle = (np.arange(count) + 0.5) * arc.turn_rad / count
    second = np.cross(arc.direction, arc.first)
    around = np.cos(angle)[:, None] * arc.first + np.sin(angle)[:, None] * second
    return arc.point + arc.ring_mm * around, arc.ring_mm * arc.turn_rad / count, arc.radius_mm


def _axis(piece: SolidFace) -> tuple[np.ndarray, float, float]:
    """The same of a straight piece."""
    length = piece.end_mm - piece.start_mm
    count = max(int(length / _STEP_MM), 1)
    along = piece.start_mm + (np.arange(count) + 0.5) * length / count
    return piece.point + along[:, None] * piece.direction, length / count, piece.radius_mm


def _along(points: np.ndarray, face: SolidFace, radius_mm: float, gap_mm: float) -> np.ndarray:
    """(n,) whether a round cable along (n, 3) points touches a face, or fills a bore, within its ends and its turn."""
    apart = points - face.point
    along = apart @ face.direction
    across = apart - along[:, None] * face.direction
    off = np.linalg.norm(across, axis=1)
    if face.is_hollow:
        close = (off <= gap_mm) & (-_INSIDE_MM <= face.radius_mm - radius_mm <= gap_mm)
    else:
        close = np.abs(off - face.radius_mm - radius_mm) <= gap_mm
    turned = np.arctan2(across @ np.cross(face.direction, face.first), across @ face.first)
    within = np.mod(turned + _ALONG, 2.0 * np.pi) <= face.turn_rad + 2.0 * _ALONG
    return close & (along >= face.start_mm) & (along <= face.end_mm) & (within | face.is_hollow)


def tip_length(a: Features, b: Features, a_in_b: np.ndarray, gap_mm: float) -> float:
    """Length of the longest line on which a round flat end of a lies along a shaft of b, mm.

    The gap is that of the end from the shaft's surface, either way.
    """
    turn, shift = a_in_b[:3, :3], a_in_b[:3, 3]
    best = 0.0
    for end in a.planes:
        centre = turn @ end.centre + shift
        normal, radius = turn @ end.direction, np.sqrt(end.area_mm2 / np.pi)
        for shaft in (c for c in b.cylinders if not c.is_hollow):
            apart = centre - shaft.point
            along = float(apart @ shaft.direction)
            across = apart - along * shaft.direction
            off = float(-across @ normal)  # from the end to the axis
            aside = float(np.linalg.norm(across + off * normal))
            level = abs(float(normal @ shaft.direction)) <= _ALONG
            if level and abs(off - shaft.radius_mm) <= gap_mm and aside < radius:
                half = np.sqrt(radius**2 - aside**2)
                best = max(best, min(along + half, shaft.end_mm) - max(along - half, shaft.start_mm))
    return float(best)


def end_area(a: Features, b: Features, a_in_b: np.ndarray, gap_mm: float) -> float:
    """Area of the smaller flat end with which one piece of a cable goes on where another ends, mm^2.

    A straight piece meets one of a helix at the helix's lead, which is the fleet angle's matter: up to its limit. The
    gap is that of the middles of both ends.
    """
    turn, shift = a_in_b[:3, :3], a_in_b[:3, 3]
    met = 0.0
    for one in a.planes:
        for other in b.planes:
            onward = -(turn @ one.direction) @ other.direction > np.cos(FLEET_LIMIT_RAD)
            if onward and np.linalg.norm(turn @ one.centre + shift - other.centre) <= gap_mm:
                met = max(met, min(one.area_mm2, other.area_mm2))
    return met


_MEASURES: dict[str, Callable[[Features, Features, np.ndarray, float], float]] = {
    "cylinder": cylinder_length,
    "plane": common_area,
    "ball": seat_area,
    "cable": cable_length,
    "tip": tip_length,
    "end": end_area,
}
"""Kind of contact -> its measure, of faces of parts a and b, the (4, 4) frame of a in b and the largest gap, mm, as a
length, mm, or an area, mm^2; 0 where nothing is engaged."""
