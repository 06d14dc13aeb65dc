"""Checks a finished drawing: every dimension occurs once with the correct value, and no text overlaps anything.

It works on the sheets, after they are laid out. What has to be told it reads from the part: its declared holes, its
faces and its size; how often each was told it counts in the texts. Whether a shop can read them is checked there, too:
exact coordinates of each position, datums that fix it, requirements, sections, and the title block.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Sequence
from itertools import combinations, pairwise

import numpy as np

from delta_cad.export.drawings.notes import named
from delta_cad.export.drawings.part.faces import Face, is_along, is_straight
from delta_cad.export.drawings.part.holes import Bore
from delta_cad.export.drawings.part.record import Features
from delta_cad.export.drawings.part.shape import unit
from delta_cad.export.drawings.sheet_io.sheet import (
    EDGES,
    Area,
    Box,
    Drawing,
    Sheet,
    Stroke,
    Text,
    box_of,
    crosses,
    lines_of,
    overlap,
    primitives,
)
from delta_cad.export.drawings.title import FIELDS, inner
from delta_cad.export.drawings.views.leaders import lines_cross, runs_along
from delta_cad.solids.boring import axes
from delta_cad.solids.part import Hole, Part

_SAME_MM = 2e-3  # what is printed is rounded to a micrometre
_TOUCHING_MM = 1e-6  # frames of tolerances that stand one below another share their line
_ROUND_MM = 0.01  # boxes of round faces are wider than they are by a thousandth
_FRAME_MM = 1.0  # by which a box around a number is wider than its text, at most
_UNDER_MM = 5.0  # from a label of the title block down to its text, at most
_RANK = 1e-6  # of motions of unit size, below which one is none
_FIT = re.compile(r"(\d+(?:\.\d+)?) ([A-Za-z]{1,2}\d{1,2})\b")
_COUNTED = re.compile(r"^(?:(\d+)x )?(.*)$")
_NUMBER = re.compile(r"^-?\d+(\.\d+)?")


def drawing_faults(drawing: Drawing, part: Part, features: Features) -> list[str]:
    """Lists what is wrong with a part's drawing.

    Returns:
        One line a fault, naming sheet or key; none: the drawing is sound.
    """
    faults = [
        *_completeness_faults(drawing, features),
        *_hole_faults(drawing, part),
        *_value_faults(drawing, features),
        *extent_faults(part, features),
        *_exact_faults(drawing, features),
        *_position_faults(drawing, features),
        *_requirement_faults(drawing, part),
        *_section_faults(drawing, features),
    ]
    for number, sheet in enumerate(drawing.sheets, 1):
        faults += [f"sheet {number}: {fault}" for fault in sheet_faults(sheet)]
    return faults


def _completeness_faults(drawing: Drawing, features: Features) -> Iterable[str]:
    """Finds coordinates, sizes, bores and notes that are stated not at all, or more than once."""
    wanted = {place.key for place in features.places} | {size.key for size in features.sizes} | set(features.notes)
    wanted |= {f"bore {g}.{b}" for g, group in enumerate(features.groups) for b in range(len(group.bores))}
    wanted |= {one.key for one in (*features.datums, *features.zones)}
    wanted |= {f"slot {n}" for n in range(len(features.slots))}
    reported = Counter(key for sheet in drawing.sheets for text in sheet.texts for key in text.states)
    for key in sorted(wanted):
        if reported[key] != 1:
            yield f"{key} is stated {reported[key]} times"
    yield from (f"{key} is stated and is nothing of the part" for key in sorted(reported.keys() - wanted))


def _hole_faults(drawing: Drawing, part: Part) -> Iterable[str]:
    """Counts by their printed texts the holes that a part declares: of each diameter or thread as many as there are."""
    printed: Counter[str] = Counter()
    texts = [text.text for sheet in drawing.sheets for text in sheet.texts]
    for text in texts:
        match = _COUNTED.match(text)
        if match:
            printed[match[2]] += int(match[1] or 1)
    for hole in part.holes:
        if hole.is_slot:
            continue
        name = _named(hole.callout, hole.diameter_mm)
        same = [h for h in part.holes if not h.is_slot and _named(h.callout, h.diameter_mm) == name]
        count = sum(number for text, number in printed.items() if _begins(text, name))
        if count != sum(map(_declared, same)):
            yield f"holes {name} are stated {count} times, {sum(map(_declared, same))} are declared"


def _declared(hole: Hole) -> int:
    """How many a declared hole is stated as: those on one axis from either side once, unless they differ."""
    callouts = {bore.callout for bore in hole.bores}
    return sum(axes(b for b in hole.bores if b.callout == callout) for callout in callouts) or hole.count


def _named(callout: str, diameter: float) -> str:
    """What the callout of a declared hole begins with on paper: its thread, or its diameter and fit."""
    own = re.sub(r"^\d+x ", "", callout)
    if thread := re.match(r"M\d+(\.\d+)?", own):
        return thread[0]
    if "slot" in own:
        return f"slot {diameter:g}" if own.startswith("slot") else own.split()[0]
    fit = re.match(r"\d+(?:\.\d+)? ([A-Z]{1,2}\d{1,2})\b", own)
    return f"Ø{round(diameter, 3):g}" + (f" {fit[1]}" if fit else "")


def _begins(text: str, name: str) -> bool:
    return text == name or (text.startswith(name) and not re.match(r"[\d.]", text[len(name) :]))


def _value_faults(drawing: Drawing, features: Features) -> Iterable[str]:
    """Holds every printed coordinate against where the feature is: how far from the datum, either way."""
    shown: dict[str, list[float]] = {}
    for sheet in drawing.sheets:
        for text in sheet.texts:
            if number := _NUMBER.match(text.text):
                for key in text.states:
                    shown.setdefault(key, []).append(abs(float(number[0])))
    for place in features.places:
        off = abs(place.value - float(features.datum @ place.along))
        if any(abs(one - off) > _SAME_MM for one in shown.get(place.key, [])):
            yield f"{place.key} is printed as {shown[place.key]}, it is {off:.3f} mm from the datum"


def _exact_faults(drawing: Drawing, features: Features) -> Iterable[str]:
    """Finds zones of position without exact coordinates, and boxes around coordinates that no zone is at."""
    located = _located(features)
    walls = {id(f) for zone in features.zones if zone.kind == "position" for f in zone.faces}
    letters = {letter for zone in features.zones if zone.kind == "position" for letter in zone.datums}
    counted = [datum for datum in features.datums if datum.letter in letters]
    walls |= {id(face) for datum in counted for face in datum.faces}
    keys = [f"bore {g}.{b} " for g, b, bore in located if any(id(face) in walls for face in bore.faces)]
    planes = [datum.faces[0] for datum in counted if datum.faces[0].kind == "plane"]
    for sheet in drawing.sheets:
        boxes = [box_of([item]) for item in primitives(sheet.items) if isinstance(item, Stroke) and _is_box(item)]
        for text in sheet.texts:
            number = _NUMBER.match(text.text)
            if number is None or abs(float(number[0])) < _SAME_MM:
                continue
            exact = any(_is_around(box, text.box) for box in boxes)
            at = [p for p in features.places if p.key in text.states]
            required = [p.key for p in at if any(p.key.startswith(key) for key in keys)]
            level = any(
                is_along(plane.axis, p.along) and abs(float(plane.point @ p.along) - p.value) < _SAME_MM
                for plane in planes
                for p in at
            )
            if required and not exact:
                yield f"{required[0]} has a zone of position and its coordinate {text.text} is not boxed"
            if exact and at and not required and not level:
                yield f"{at[0].key} is boxed, {text.text}, and nothing tolerances its position"


def _located(features: Features) -> list[tuple[int, int, Bore]]:
    """Bores with the numbers of group and bore in their keys."""
    return [(g, b, bore) for g, group in enumerate(features.groups) for b, bore in enumerate(group.bores)]


def _is_box(item: Stroke) -> bool:
    return item.closed and len(item.points) == 4


def _is_around(box: Box, inside: Box) -> bool:
    """Whether a box is the frame of a text: around it, and no wider than that takes."""
    apart = [inside[0] - box[0], inside[1] - box[1], box[2] - inside[2], box[3] - inside[3]]
    return min(apart) > -_TOUCHING_MM and max(apart) < _FRAME_MM


def _position_faults(drawing: Drawing, features: Features) -> Iterable[str]:
    """Reads the frames of positions off the sheets: what their datums leave free to move must not move their zones.

    Datums leave a part some motions. In these the axis of a single bore may move one way, as about another bore; those
    of a pattern not at all, unless its frame says CZ: then only together.
    """
    known = {datum.letter: datum.faces for datum in features.datums}
    zones = {zone.key: zone for zone in features.zones}
    for sheet in drawing.sheets:
        for symbol in sheet.symbols:
            cells = [item for item in symbol.items if isinstance(item, Text)]
            zone = zones.get(cells[0].states[0]) if cells and cells[0].states else None
            if zone is None or not symbol.name.startswith("position"):
                continue
            fixed = [row for cell in cells[1:] for face in known.get(cell.text, ()) for row in _fixed(face)]
            _, size, rows = np.linalg.svd(np.array([*fixed, np.zeros(6)]))
            free = rows[int((size > _RANK).sum()) :]
            walls = {id(face) for face in zone.faces}
            bores = [bore for _, _, bore in _located(features) if any(id(face) in walls for face in bore.faces)]
            ways = [np.linalg.matrix_rank(_moved_across(bore, free), tol=_RANK) for bore in bores]
            if len(bores) > 1 and "CZ" not in cells[0].text.split() and any(ways):
                yield f"{symbol.name} holds {len(bores)} axes and neither fixes nor combines them: more datums, or CZ"
            if len(bores) == 1 and ways[0] > 1:
                yield f"{symbol.name} names too few datums to place an axis"


def _fixed(face: Face) -> np.ndarray:
    """(n, 6) rows, by which a motion, shift of the origin in cm and turn in rad, is multiplied to what a datum forbids.

    A plane may slide in itself and turn about its normal, an axis slide along itself and turn about itself.
    """
    a, (u, v) = face.axis, _sides_of(face.axis)
    turns = [np.concatenate([np.zeros(3), side]) for side in (u, v)]
    shifts = (a,) if face.kind == "plane" else (u, v)
    return np.array([*turns, *(_shift(way, face.point) for way in shifts)])


def _shift(way: np.ndarray, at: np.ndarray) -> np.ndarray:
    """(6,) the velocity of a point along a direction, as a row that a motion is multiplied by; lengths in cm."""
    return np.concatenate([way, np.cross(at / 10.0, way)])


def _sides_of(axis: np.ndarray) -> np.ndarray:
    """(2, 3) unit vectors across an axis and one another."""
    u = np.cross(axis, np.eye(3)[int(np.abs(axis).argmin())])
    u /= np.linalg.norm(u)
    return np.array([u, np.cross(axis, u)])


def _moved_across(bore: Bore, free: np.ndarray) -> np.ndarray:
    """(4, n) what n motions do to a bore's axis: shifts across it at its end, and tilts."""
    sides = _sides_of(bore.axis)
    rows = [_shift(side, bore.point) for side in sides] + [np.concatenate([np.zeros(3), side]) for side in sides]
    return np.array(rows) @ free.T


def _requirement_faults(drawing: Drawing, part: Part) -> Iterable[str]:
    """Finds what a part's description asks for that stands in no view, table or note."""
    outside = [
        t.text for s in drawing.sheets for t in s.texts if not overlap(t.box, s.frames.get("title block", t.box))
    ]
    printed = _plain(" ".join(outside))
    name, clauses = named(part.description)
    for clause in clauses:
        if _plain(clause) not in printed:
            yield f"{clause!r} stands only in the part's description"
    for size, fit in _FIT.findall(name):
        if not any(f"Ø{size} {fit}" in text for text in outside):
            yield f"{size} {fit} stands only in the title"


def _plain(text: str) -> str:
    """A text by its words: without case, brackets, full stops, and tolerances, which a view states."""
    return " ".join(re.sub(r"[().;:,]+(?=\s|$)|\(| ±\S+", "", text).casefold().split())


def _section_faults(drawing: Drawing, features: Features) -> Iterable[str]:
    """Finds sections that show nothing hidden of what the main view has end on, and such without a section."""
    bores = [bore for _, _, bore in _located(features) if features.turned or is_along(bore.axis, features.main)]
    hollow = [face for face in features.faces if face.kind == "sphere" and face.hollow]
    most = max((len(bore.diameters) - bore.through for bore in bores), default=0)
    hidden = [bore for bore in bores if len(bore.diameters) - bore.through == most]
    for section in drawing.sections:
        if not any(map(section.meets, hidden)) and not any(section.holds(face.point) for face in hollow):
            yield "a section meets no bore of those with the most steps or a floor"
        elif not features.turned and "A-A" not in {text.text for sheet in drawing.sheets for text in sheet.texts}:
            yield "a view is cut open and has no title A-A"
    if not drawing.sections and (hollow or most > 0):
        yield "nothing is cut open, and a step or a floor is hidden"


def _title_faults(sheet: Sheet) -> Iterable[str]:
    """Finds fields of the title block without a text under their label."""
    block = sheet.frames.get("title block")
    inside = [text for text in sheet.texts if block is not None and overlap(text.box, block)]
    for label in FIELDS if block is not None else ():
        at = next((text.at for text in inside if text.text == label), None)
        if at is None or not any(t.at[0] == at[0] and 0.0 < at[1] - t.at[1] < _UNDER_MM for t in inside):
            yield f"title block: {label} is missing"


def extent_faults(part: Part, features: Features) -> Iterable[str]:
    """Holds how far a part declares that it reaches against what is told: each end has a coordinate, or is none.

    Round faces end where their radius and place have them, and so do corners of slanted ones, as of a sector's lug.
    """
    for k, span in enumerate(part.extent_mm or ()):
        for end in span or ():
            there = [face for face in features.faces if min(abs(face.box[:, k] - end)) < _ROUND_MM]
            placed = any(is_along(p.along, unit(k)) and abs(p.value - end) < _SAME_MM for p in features.places)
            rounded = any(face.kind != "plane" for face in there)
            slants = [not is_straight(face.axis) for face in there if abs(face.axis[k]) > 1e-6]
            corner, flat = bool(slants) and all(slants), any(s.kind == "flat" for s in features.sizes)
            if not (placed or rounded or corner or flat):
                yield f"nothing tells its end at {end:.3f} mm along {'xyz'[k]}"


def sheet_faults(sheet: Sheet) -> list[str]:
    """Finds texts that overlap one another or a frame they do not stand in, lie over an edge, or off the sheet."""
    texts = list(sheet.texts)
    faults = [f"{text.text!r} is outside of the frame" for text in texts if not _is_inside(text.box, sheet)]
    faults += [f"{a.text!r} and {b.text!r} overlap" for a, b in _overlapping(texts)]
    frames = sheet.frames
    faults += [
        f"{a} and {b} overlap" for a, b in combinations(sorted(frames), 2) if overlap(frames[a], frames[b], -1e-6)
    ]
    edges = lines_of(item for item in primitives(sheet.items) if not isinstance(item, Text) and item.layer in EDGES)
    faults += [f"{text.text!r} lies over an edge" for text in texts if crosses(text.box, edges)]
    return [*faults, *_symbol_faults(sheet, edges), *_leader_faults(sheet, edges), *_title_faults(sheet)]


def _is_inside(box: Box, sheet: Sheet) -> bool:
    low_x, low_y, high_x, high_y = inner("A4" if sheet.width < 300.0 else "A3")
    return low_x <= box[0] and box[2] <= high_x and low_y <= box[1] and box[3] <= high_y


def _symbol_faults(sheet: Sheet, edges: np.ndarray) -> Iterable[str]:
    """Finds symbols that overlap one another or a text that is not theirs, lie over an edge, or off the sheet."""
    symbols, texts = list(sheet.symbols), list(sheet.texts)
    for k, symbol in enumerate(symbols):
        box, own = symbol.box, {id(item) for item in symbol.items}
        if not _is_inside(box, sheet):
            yield f"symbol {symbol.name} is outside of the frame"
        if crosses(box, edges):
            yield f"symbol {symbol.name} lies over an edge"
        hit = [f"symbol {other.name}" for other in symbols[k + 1 :] if overlap(box, other.box, -_TOUCHING_MM)]
        hit += [repr(t.text) for t in texts if id(t) not in own and overlap(box, t.box, -_TOUCHING_MM)]
        yield from (f"symbol {symbol.name} and {other} overlap" for other in hit)


def _leader_faults(sheet: Sheet, edges: np.ndarray) -> Iterable[str]:
    """Finds leaders that cross one another, or whose last line runs along an edge: one cannot tell what they mean."""
    items = list(primitives(sheet.items))
    found = [
        np.array(line.points)
        for line, head in pairwise(items)
        if isinstance(line, Stroke)
        and isinstance(head, Area)
        and line.layer == head.layer == "dimension"
        and line.points[-1] == head.points[0]
    ]
    parts = [np.stack([leader[:-1], leader[1:]], axis=1) for leader in found]
    for one, other in combinations(parts, 2):
        if any(lines_cross(a, b) for a in one for b in other):
            yield f"leaders to ({_at(one[-1, 1])}) and ({_at(other[-1, 1])}) cross"
    for leader in parts:
        if runs_along(leader[-1], edges):
            yield f"leader to ({_at(leader[-1, 1])}) runs along an edge"


def _at(point: np.ndarray) -> str:
    return f"{point[0]:.1f}, {point[1]:.1f}"


def _overlapping(texts: Sequence[Text]) -> Iterable[tuple[Text, Text]]:
    ordered = sorted(texts, key=lambda text: text.box[0])
    for k, one in enumerate(ordered):
        for other in ordered[k + 1 :]:
            if other.box[0] > one.box[2]:
                break
            if overlap(one.box, other.box, -1e-6):
                yield one, other
