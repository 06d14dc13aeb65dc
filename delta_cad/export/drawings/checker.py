"""Checks a finished drawing: every dimension occurs once with the correct value, and no text overlaps anything.

It works on the sheets, after they are laid out. What has to be told it reads from the part: its declared holes, its
faces and its size; how often each was told it counts in the texts.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Sequence
from itertools import combinations, pairwise

import numpy as np

from delta_cad.export.drawings.part.faces import is_along, is_straight
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
    crosses,
    lines_of,
    overlap,
    primitives,
)
from delta_cad.export.drawings.title import inner
from delta_cad.export.drawings.views.leaders import lines_cross, runs_along
from delta_cad.solids.boring import axes
from delta_cad.solids.part import Hole, Part

_SAME_MM = 2e-3  # what is printed is rounded to a micrometre
_TOUCHING_MM = 1e-6  # frames of tolerances that stand one below another share their line
_ROUND_MM = 0.01  # boxes of round faces are wider than they are by a thousandth
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
    return faults + list(_symbol_faults(sheet, edges)) + list(_leader_faults(sheet, edges))


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
