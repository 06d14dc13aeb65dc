"""Sheets of springs, after ISO 2162: the spring drawn as it is wound or waved, and a table of what it must give.

A spring is made by its loads, not by the shape that the machine's model has for it. All figures are those of its row of
the catalogue, with which loads, stiffness and friction are computed.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import acos, degrees, pi, sin

from delta_cad import catalogue
from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.forearm import ForearmDimensions
from delta_cad.dimensions.joint import SPRING_SHARE
from delta_cad.dimensions.tolerances import WAVE_SHARE, preload_range_N, spring_height_mm
from delta_cad.dimensions.tolerances.general import general_mm
from delta_cad.export.drawings.sheet_io.lettering import LINE, wrapped
from delta_cad.export.drawings.sheet_io.sheet import (
    Annotation,
    Arc,
    Drawing,
    Item,
    Measure,
    Point,
    Stroke,
    Text,
    box_of,
    moved,
    scaled,
)
from delta_cad.export.drawings.title import Titles, framed, inner
from delta_cad.export.drawings.views.marks import LETTER_MM, arrow
from delta_cad.solids.part import Part

_SIZE = "A4"
_COLUMNS = 62.0, 84.0  # of the table: what, and its value
_PITCH_MM = LETTER_MM * LINE
_ROOM_MM = 80.0, 150.0  # of the picture on the sheet, across and up, without its dimensions
_SCALES = (10.0, 5.0, 2.0, 1.0)
_AWAY_MM = 8.0  # of a dimension's line from what it measures
_POINTS = 12  # of a wave

Row = tuple[str, str]
_MODEL: Row = "STEP file", "has the room that the spring takes, not its shape"


@dataclass(frozen=True)
class _Length:
    """A length of the picture: its ends, mm of the spring, how far its line stands off on the sheet, and its text."""

    start: Point
    end: Point
    off_mm: float
    text: str


def spring_drawing(d: Dimensions, part: Part, titles: Titles) -> Drawing | None:
    """Draws the sheet of a spring that is made to drawing; None: the part is none."""
    if part.number == "rod_spring":
        picture, lengths, rows = _tension(d.forearm)
    elif part.number == "wave_spring" and d.preload is not None:
        picture, lengths, rows = _wave(d.preload, d.bearing)
    else:
        return None
    x0, y0, x1, y1 = box_of(picture)
    scale = next((s for s in _SCALES if s * (x1 - x0) <= _ROOM_MM[0] and s * (y1 - y0) <= _ROOM_MM[1]), _SCALES[-1])
    titles = replace(titles, tolerance="as the table states", surface="as its material", kind="Spring sheet")
    sheet, area = framed(_SIZE, f"{scale:g}:1", "1 / 1", titles), inner(_SIZE)
    drawn = [scaled(item, scale) for item in picture] + [_dimension(one, scale) for one in lengths]
    box, table = box_of(drawn), _table(rows)
    drawn = [moved(item, (area[0] + 6.0 - box[0], area[3] - 8.0 - box[3])) for item in drawn]
    table = [moved(item, (area[2] - 4.0 - sum(_COLUMNS), area[3] - 6.0)) for item in table]
    sheet.add([*drawn, *table])
    sheet.frames |= {"spring": box_of(drawn), "table": box_of(table)}
    return Drawing(part.number, f"{part.number}: {titles.description}", (sheet,))


def _tension(f: ForearmDimensions) -> tuple[list[Item], list[_Length], list[Row]]:
    """A spring with full loops across a pair of rods: its picture, from loop to loop upwards, and its table."""
    row, wire, mean = f.spring, f.spring.wire_mm, f.spring.mean_diameter_mm
    outer, inside = mean + wire, mean - wire
    coils, half = int(row.active_coils) + 1, row.free_length_mm / 2
    body = coils * wire / 2
    picture: list[Item] = [
        Stroke("visible", ((-outer / 2, -body + k * wire), (outer / 2, -body + (k + 0.5) * wire)))
        for k in range(coils + 1)
    ]
    picture += [Stroke("visible", ((x, -body), (x, body + wire / 2))) for x in (-outer / 2, outer / 2)]
    for side in (-1.0, 1.0):
        centre = side * (half - inside / 2)
        picture += [_loop(centre, radius, body + wire / 2) for radius in (inside / 2, outer / 2)]
    lengths = [
        _Length((0.0, -half), (0.0, half), outer / 2, f"L0 ({row.free_length_mm:g})"),
        _Length((-outer / 2, body), (outer / 2, body), half + wire - body, f"De {outer:g}"),
    ]
    share, most = 100.0 * SPRING_SHARE, f.joint.spring_max_N
    longest = row.free_length_mm + (most - row.initial_tension_N) / row.rate_N_mm
    stress = 8.0 * row.force_max_N * mean / (pi * wire**3)
    rows = [
        ("Spring", "helical tension spring, cylindrical, coils closed"),
        ("Wire", f"EN 10270-1 DH, d = {wire:g}"),
        ("Outside diameter De", f"{outer:g} ±{general_mm(outer):g}"),
        ("Mean, inside diameter D, Di", f"({mean:g}), ({inside:g})"),
        ("Active coils n", f"{row.active_coils:g}; the maker may change n to meet the loads"),
        ("Direction of coiling", "right or left"),
        ("Ends", f"{row.loops}, both in one plane within 10°"),
        ("Free length L0 inside the loops", f"({row.free_length_mm:g})"),
        ("Initial tension F0", f"{row.initial_tension_N:g} N ±{share:g} %"),
        ("Rate R", f"{row.rate_N_mm:.3g} N/mm ±{share:g} %"),
        (f"Load F1 at L1 = {f.between_eyes_mm:.2f}", f"{f.joint.spring_N:.2f} N ±{share:g} %, arms at rest"),
        (f"Load F2 at L2 = {longest:.2f}", f"{most:.2f} N ±{share:g} %, at the largest lean"),
        (f"Largest length Ln = {row.length_max_mm:g}", f"Fn = {row.force_max_N:g} N, no set after it"),
        ("Shear stress at Ln", f"{stress:.0f} MPa, without the curvature's factor"),
        ("Lengths are between", "the insides of the loops"),
        _MODEL,
    ]
    return picture, lengths, rows


def _loop(centre_mm: float, radius: float, body: float) -> Arc:
    """The circle of a loop about a point of the axis, open where it meets the body, which reaches so far either way."""
    apart = (body - abs(centre_mm)) / radius  # cosine of the angle where the body ends, from the way outwards
    angle = degrees(acos(min(max(apart, -1.0), 1.0)))
    middle = 90.0 if centre_mm > 0.0 else 270.0
    return Arc("visible", (0.0, centre_mm), radius, middle - angle, middle + angle)


def _wave(row: catalogue.WaveSpring, bearing: catalogue.Bearing) -> tuple[list[Item], list[_Length], list[Row]]:
    """A wave washer behind a bearing: its ring, seen along its axis, beside its circumference unrolled; its table."""
    outer, thick = row.outer_mm, row.thickness_mm
    waves, rise = row.waves or 3, row.free_height_mm - row.thickness_mm
    aside, long = outer * 0.6, outer
    picture: list[Item] = [Arc("visible", (0.0, 0.0), diameter / 2) for diameter in (outer, row.inner_mm)]
    picture += [Stroke("centre", ends) for ends in (((-aside, 0.0), (aside, 0.0)), ((0.0, -aside), (0.0, aside)))]
    low = -aside - rise - 2.0
    for up in (0.0, thick):
        steps = [k / (_POINTS * waves) for k in range(_POINTS * waves + 1)]
        line = tuple((long * (s - 0.5), low + up + rise * (1.0 + sin(2 * pi * waves * s)) / 2) for s in steps)
        picture.append(Stroke("visible", line))
    picture += [Stroke("visible", ((x, low + rise / 2), (x, low + rise / 2 + thick))) for x in (-long / 2, long / 2)]
    lengths = [
        _Length((-outer / 2, 0.0), (outer / 2, 0.0), aside, f"De {outer:g}"),
        _Length((long / 2, low), (long / 2, low + row.free_height_mm), 0.0, f"L0 ({row.free_height_mm:g})"),
    ]
    rate = row.rate_N_mm or row.force_N / (row.free_height_mm - row.work_height_mm)
    (least, most), (weak, strong) = spring_height_mm(row), preload_range_N(row)
    share = f"+{100.0 * WAVE_SHARE:g}/0 %"
    width, off = (outer - row.inner_mm) / 2, general_mm(outer)
    rows = [
        ("Spring", "wave washer, one closed turn, no gap"),
        ("Strip", f"EN 10151, 1.4310 +C1500, tempered; {width:g} x {thick:g}"),
        ("Outside diameter De, unloaded", f"{outer:g} +0/-{off:g}; in a bore of {row.housing_mm:g} without binding"),
        ("Inside diameter Di", f"{row.inner_mm:g} +{off:g}/0; the ring of {bearing.inner_ring_outer_mm:g} turns in it"),
        ("Waves", f"{waves}, alike"),
        ("Free height L0", f"({row.free_height_mm:g}); the maker may change it to meet the loads"),
        ("Rate R", f"{rate:.3g} N/mm {share}, between both heights"),
        (f"Load F at L = {row.work_height_mm:g}", f"{row.force_N:g} N {share}"),
        (f"Load F1 at L1 = {most:.2f}", f"{weak:.2f} N at least: bearings run free below it"),
        (f"Load F2 at L2 = {least:.2f}", f"{(1.0 + WAVE_SHARE) * strong:.2f} N at most"),
        ("Ends", "waves stand on flat faces; edges free of burrs, corners round"),
        ("Set", "pressed flat three times before it is gauged"),
        _MODEL,
    ]
    return picture, lengths, rows


def _dimension(one: _Length, scale: float) -> Annotation:
    """A length with its lines and text, along x below or above what it measures, or along y on its right."""
    (ax, ay), (bx, by) = ((x * scale, y * scale) for x, y in (one.start, one.end))
    along_x = abs(bx - ax) > abs(by - ay)
    if along_x:
        level = ay + one.off_mm * scale + (_AWAY_MM if one.off_mm > 0.0 else -_AWAY_MM)
        a, b = (ax, level), (bx, level)
    else:
        level = ax + one.off_mm * scale + _AWAY_MM
        a, b = (level, ay), (level, by)
    measure = Measure("length", (a, b), abs(one.end[0] - one.start[0]) + abs(one.end[1] - one.start[1]), one.text)
    text = Text(((a[0] + b[0]) / 2, level + 1.0) if along_x else (level + 1.5, (a[1] + b[1]) / 2), LETTER_MM, one.text)
    if along_x:
        text = replace(text, at=(text.at[0] - text.length / 2, text.at[1]))
    ends = [Stroke("dimension", (start, end)) for start, end in (((ax, ay), a), ((bx, by), b), (a, b))]
    return Annotation("dimension", (*ends, arrow(a, b), arrow(b, a), text), measure)


def _table(rows: Sequence[Row]) -> list[Item]:
    """Sets the table from (0, 0) down."""
    items: list[Item] = [Stroke("table", ((0.0, 0.0), (sum(_COLUMNS), 0.0)))]
    y = 0.0
    for row in rows:
        cells = [wrapped(cell, LETTER_MM, width - 2.0) for cell, width in zip(row, _COLUMNS, strict=True)]
        for left, lines in zip((0.0, _COLUMNS[0]), cells, strict=True):
            places = ((left + 1.0, y - _PITCH_MM * (n + 1) + 1.1) for n in range(len(lines)))
            items += [Text(at, LETTER_MM, line) for at, line in zip(places, lines, strict=True)]
        y -= _PITCH_MM * max(map(len, cells)) + 0.6
        items.append(Stroke("table", ((0.0, y), (sum(_COLUMNS), y))))
    edges = 0.0, _COLUMNS[0], sum(_COLUMNS)
    return [*items, *(Stroke("table", ((edge, 0.0), (edge, y))) for edge in edges)]
