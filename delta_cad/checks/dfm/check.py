"""The manufacturing rules over all made parts, cut or printed, each with the worst part and place."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from math import cos, pi, sin

import numpy as np

from delta_cad import catalogue
from delta_cad.checks.contact.features import features
from delta_cad.checks.dfm.bores import Finding, at, bores, depths, odd_sizes, run_outs, unreached
from delta_cad.checks.dfm.lines import FAR_MM, Lines, face_points
from delta_cad.checks.dfm.printed import (
    LEAST_WALL_MM,
    insert_depths,
    insert_walls,
    no_inserts,
    overhangs,
    sizes,
    small_holes,
)
from delta_cad.checks.dfm.setups import setups
from delta_cad.checks.report import CheckResult
from delta_cad.common.memoize import cached
from delta_cad.common.vectors import cross
from delta_cad.dimensions.rules import THREAD_WALL_MM
from delta_cad.solids.part import Bore, Part, part_digest

# Walls that stand the cut, and faces that a tool sees.
_LEAST_WALL_MM = 0.5  # of metal and hard plastic: thinner ones give way before the cutter
_ACROSS = 0.9  # cosine between a wall's two sides' normals: a wedge between others ends in an edge
_SIGHT_MM = 0.1  # off a face, from where it is seen: the kernel takes lines closer to a bore's rim for hits
_INTO_MM = 1e-3  # below a face, from where a line goes through the wall


def walls(part: Part) -> Iterator[Finding]:
    """The thinnest wall of a part, square to its faces."""
    lines, thin = Lines(part.solid), (np.inf, np.zeros(3))
    for _, points in face_points(part.solid):
        for point, normal in points:
            hit = lines.first(point - _INTO_MM * normal, -normal, min(thin[0], FAR_MM))
            if hit is not None and hit[1] @ -normal > _ACROSS and hit[0] + _INTO_MM < thin[0]:
                thin = hit[0] + _INTO_MM, point
    if np.isfinite(thin[0]):
        x, y, z = thin[1]
        where = f"{part.number}: {thin[0]:.2f} mm at ({x:.1f}, {y:.1f}, {z:.1f})"
        least = LEAST_WALL_MM.get(part.material.process, _LEAST_WALL_MM)
        yield Finding(part.number, round(float(thin[0]), 3), least, where, is_least=True)


def _undercuts(part: Part) -> Iterator[Finding]:
    """Faces of which no point is seen from outside along its normal or an axis of the part or of a bore.

    A straight tool comes to a face along its normal, or beside it along another of these.
    """
    lines = Lines(part.solid)
    ways = [sign * axis for axis in np.eye(3) for sign in (1.0, -1.0)]
    for bore in (bore for hole in part.holes for bore in hole.bores):
        ways += [-np.array(bore.direction)] + ([np.array(bore.direction)] if bore.through else [])
    distinct = list({tuple(np.round(way, 6)): way for way in ways}.values())
    for face, points in face_points(part.solid):
        if points and not any(_seen(lines, point, normal, distinct) for point, normal in points):
            x, y, z = points[len(points) // 2][0]
            where = f"{part.number}: a face of {face.Area():.1f} mm^2 at ({x:.1f}, {y:.1f}, {z:.1f})"
            yield Finding(part.number, float(face.Area()), 0.0, where)


def _seen(lines: Lines, point: np.ndarray, normal: np.ndarray, ways: list[np.ndarray]) -> bool:
    start = point + _SIGHT_MM * normal
    return any(way @ normal > -1e-6 and lines.is_free(start, way) for way in (normal, *ways))


# Threads that a tap cuts without bulging or breaking the wall beside them.
_RING, _STATIONS = 24, 7  # directions about a thread's axis, places along it


def _thread_walls(part: Part) -> Iterator[Finding]:
    """The thinnest wall next to each thread: from its outer diameter straight to the face that ends the material."""
    lines = Lines(part.solid)
    for bore in (bore for bore in bores(part) if bore.thread):
        wall = min(_ends(lines, bore), default=np.inf) - catalogue.screw(bore.thread).diameter_mm / 2
        if np.isfinite(wall):
            where = f"{part.number}: {wall:.2f} mm beside {at(bore)}"
            yield Finding(part.number, round(wall, 3), THREAD_WALL_MM, where, is_least=True)


def _ends(lines: Lines, bore: Bore) -> Iterator[float]:
    """How far from a thread's axis the material around it ends in a face across the way out, mm."""
    start, along = np.array(bore.start_mm), np.array(bore.direction)
    across = cross(along, np.eye(3)[int(np.argmin(np.abs(along)))])
    across /= np.linalg.norm(across)
    aside = cross(along, across)
    begin = bore.diameter_mm / 2 + _INTO_MM
    for deep in (np.arange(_STATIONS) + 0.5) / _STATIONS * bore.thread_mm:
        for angle in 2 * pi * np.arange(_RING) / _RING:
            way = cos(angle) * across + sin(angle) * aside
            hit = lines.first(start + deep * along + begin * way, way)
            if hit is not None and hit[1] @ way > _ACROSS:
                yield begin + hit[0]


# Inner corners that a round cutter makes: none sharp along a milling axis, none too deep for its cutter.
_DEPTH_CUTTERS = 5.0  # of a corner, in diameters of the cutter that goes round it: a long end mill still cuts aluminium
_LEAST_CUTTER_MM = 1.0  # in a corner: thinner ones are an engraver's
_WHOLE_RAD = 3.0  # a wall that turns further is a bore's, or the end or the bottom of a slot


def _sharp_corners(part: Part) -> Iterator[Finding]:
    """Straight inner edges without a radius that no flat end mill makes."""
    from delta_cad.solids.primitive import closed_corners  # loads the CAD kernel

    for corner in closed_corners(part.solid):
        if corner.is_straight:
            x, y, z = corner.point
            length = float(corner.edge.Length())  # type: ignore[attr-defined]
            yield Finding(part.number, length, 0.0, f"{part.number}: {length:.1f} mm at ({x:.1f}, {y:.1f}, {z:.1f})")


def _corner_radii(part: Part) -> Iterator[Finding]:
    """Depth of each rounded inner corner in diameters of the largest cutter that goes round it."""
    for face in features(part.solid).cylinders:
        if not face.is_hollow or face.turn_rad >= _WHOLE_RAD:
            continue
        deep, cutter = abs(face.end_mm - face.start_mm), 2.0 * face.radius_mm
        x, y, z = face.point + (face.start_mm + face.end_mm) / 2 * face.direction + face.radius_mm * face.first
        where = f"{part.number}: R{face.radius_mm:g}, {deep:.1f} deep, at ({x:.1f}, {y:.1f}, {z:.1f})"
        limit = _DEPTH_CUTTERS if cutter >= _LEAST_CUTTER_MM else 0.0
        yield Finding(part.number, deep / cutter, limit, where)


_SHOWN = 8  # faults that a report names; their number is told
_ROUNDING = 1e-9


@dataclass(frozen=True)
class _Rule:
    """A rule of a shop.

    Attributes:
        name: Of its result.
        find: Findings of a part.
        unit: Of figure and limit.
        what: What is measured, a few words.
        counts: Whether the figure is the number of findings, of which none is allowed.
    """

    name: str
    find: Callable[[Part], Iterator[Finding]]
    unit: str
    what: str
    counts: bool = False


RULES = (
    _Rule("dfm corners", _sharp_corners, "", "inner corners without a radius along a milling axis", counts=True),
    _Rule("dfm corner radii", _corner_radii, "", "deepest inner corner in diameters of its cutter"),
    _Rule("dfm walls", walls, "mm", "thinnest wall"),
    _Rule("dfm thread walls", _thread_walls, "mm", "thinnest wall beside a thread"),
    _Rule("dfm bore depth", depths, "", "bore or thread deepest for its diameter"),
    _Rule("dfm run-out", run_outs, "mm", "shortest run-out of a blind thread for its pitch"),
    _Rule("dfm sizes", odd_sizes, "", "bores of a size for which there is no drill", counts=True),
    _Rule("dfm reach", unreached, "", "bores to which no straight tool comes", counts=True),
    _Rule("dfm undercuts", _undercuts, "", "faces to which no straight tool comes", counts=True),
    _Rule("dfm setups", setups, "", "clampings of a part"),
)
"""All rules for what is cut, in the order of the report."""
PRINT_RULES = (
    _Rule("dfm print walls", walls, "mm", "thinnest printed wall"),
    _Rule("dfm print insert walls", insert_walls, "mm", "thinnest plastic around an insert"),
    _Rule("dfm print insert depth", insert_depths, "mm", "shallowest hole for its insert"),
    _Rule("dfm print threads", no_inserts, "", "threads without an insert", counts=True),
    _Rule("dfm print holes", small_holes, "mm", "smallest printed hole"),
    _Rule("dfm print overhang", overhangs, "", "area to support as a share of a part's"),
    _Rule("dfm print size", sizes, "mm", "longest edge on the printer's bed"),
)
"""The same for what is printed."""


def check_dfm(parts: Iterable[Part]) -> list[CheckResult]:
    """Holds every part that is made against the rules of a shop.

    Args:
        parts: With valid solids; those that are bought are left out.

    Returns:
        One result a rule, named `dfm ...`, with the worst figure of all parts; those of prints where there are any.
    """
    made = [part for part in parts if part.make]
    found = []
    for rules, held in (
        (RULES, [part for part in made if not part.material.process]),
        (PRINT_RULES, [part for part in made if part.material.process]),
    ):
        for rule in rules if held or rules is RULES else ():
            found.append(_result(rule, [finding for part in held for finding in _found(rule, part)], len(held)))
    return found


def _found(rule: _Rule, part: Part) -> list[Finding]:
    return cached("dfm", (rule.name, part_digest(part)), lambda: list(rule.find(part)))


def _result(rule: _Rule, findings: list[Finding], parts: int) -> CheckResult:
    findings.sort(key=lambda finding: -finding.share)
    bad = [finding for finding in findings if finding.share > 1.0 + _ROUNDING]
    shown = [finding.where for finding in (bad[:_SHOWN] or findings[:1])]
    reported = f"{f'{len(bad)} fail' if bad else 'worst'}: {'; '.join(shown)}; " if shown else ""
    value, limit = (findings[0].value, findings[0].limit) if findings else (None, None)
    if rule.counts:
        value, limit = float(len(bad)), 0.0
    pair = (findings[0].part,) if findings else None
    return CheckResult(
        rule.name, not bad, value, limit, rule.unit, worst_pair=pair, detail=f"{rule.what}; {reported}{parts} parts"
    )
