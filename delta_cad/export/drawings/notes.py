"""Notes of a part's drawing: what no view and no table tells, each once; its name and the material as ordered."""

from __future__ import annotations

import re

import numpy as np

from delta_cad import catalogue
from delta_cad.assembly.printing import SHRINK_MM, bed_mm2, inserts_of, print_high_mm, print_up
from delta_cad.export.drawings.part.controlled import Controlled
from delta_cad.export.drawings.part.faces import is_along
from delta_cad.export.drawings.part.holes import lettered
from delta_cad.export.drawings.part.record import Features, bores_of
from delta_cad.export.drawings.part.shape import is_hull_line, is_slant
from delta_cad.export.drawings.views.projection import Frame
from delta_cad.solids.part import Part

_CENTRE_MM = 1.0, 2.12  # smallest centre hole of ISO 6411 that is in common use, and its mouth
_CENTRE_WALL_MM = 0.5  # around its mouth, at least
_BRIM_SHARE = 0.05  # of the square of its height: what stands on less tips off the bed without a brim
_SIDES = ("the arm's side", "the motor's side", "the encoder's side", "the outer side", "below")
"""Names by which texts of a drawing refer to a side of a part; see `side_of`."""
_SAME = 0.9  # cosine of an angle between ways that are one
_CLAUSE = re.compile(r"[;.] (?=\D)")
_NAME = re.compile(r"[,;:.] ")
_THREAD = re.compile(r"\bM\d+(\.\d+)?\b")
_TOLERANCED = re.compile(r"(\d+(?:\.\d+)?) ±(\d+(?:\.\d+)?)")


def named(description: str) -> tuple[str, list[str]]:
    """Splits a description into the part's name, for the title block, and what else it says, for the notes."""
    name, *rest = _NAME.split(lettered(description), maxsplit=1)
    return name, [f"{one[0].upper()}{one[1:]}" for text in rest for one in _CLAUSE.split(text) if one]


def ordered_as(part: Part) -> str:
    """Gives a part's material as it is ordered: designation, temper and standard of the product."""
    if part.order_code and not part.to_drawing:  # stock, or a bought part that is worked on
        return ", ".join(filter(None, (part.order_code, part.standard)))
    name = part.material.name
    row = next((row for row in catalogue.material.rows.values() if row.description == name), None)
    if row is None:
        return name
    known = name.replace(",", "").split()
    more = " ".join(word for word in row.order_code.split() if word not in known)
    return ", ".join(filter(None, (f"{name} ({more})" if more else name, row.standard)))


def notes_of(part: Part, features: Features, front: Frame, held: Controlled) -> list[tuple[str, str]]:
    """Gives the notes of a part's drawing, each with the key that it tells; `front` is the frame of its main view."""
    zero = ", ".join(f"{round(float(value), 3) + 0.0:g}" for value in features.datum)
    right, up = (_axis(axis) for axis in front.axes)
    notes = [
        *(("", f"{_auxiliary(text, features, held)}.") for text in named(part.description)[1]),
        *(("", text) for text in part.notes),
        ("", f"Coordinates count from 0, which is ({zero}) in the STEP file and in holes.csv."),
        ("", f"The main view's right is {right} there, its up {up}."),
        *_side_notes(part, front),
        ("", "The STEP file has the nominal sizes. Where it says something else, the drawing holds."),
        *_exact_notes(features),
        ("", f"Finish: {finish_of(part)}."),
    ]
    bores = [bore for hole in part.holes for bore in hole.bores]
    if any(b.zone_mm and not (b.deviations_um or b.thread or "slot" in b.callout) for b in bores):
        notes.append(("", "Screws' clearance holes H13 (ISO 273): no narrower than stated."))
    if part.material.process:
        notes += [("", text) for text in print_notes(part)]
    outside = any(size.tolerance is not None and size.tolerance.thread for size in features.sizes)
    if outside or any(bore.thread for bore in bores):
        notes.append(("", "Threads ISO 965-1: 6H inside, 6g outside."))
    fits = any(size.tolerance is not None and size.tolerance.fit for size in features.sizes)
    if fits or any(bore.fit for bore in bores):  # ISO 8015 takes sizes point by point
        notes.append(("", "Sizes with a fit have an envelope, ISO 14405-1 (E)."))
    if outside:  # no die cuts to a shoulder, on which this part stands
        notes.append(("", "An outer thread ends in an undercut DIN 76-1, short, at its shoulder; not drawn."))
    if held.groove_mm is not None:
        notes.append(("", "The helical groove is drawn as a thread is: its lands bold, its bottom thin."))
    if _between_centres(part, features):
        notes.append(("", f"Centre holes ISO 6411-A{_CENTRE_MM[0]:g}/{_CENTRE_MM[1]:g} may stay in solid ends."))
    if any(is_hull_line(face, features) for face in features.faces):
        notes.append(("", "A line between two arcs is tangent to both."))
    if any(is_slant(face, features) for face in features.faces):
        notes.append(("", "A slanting line from an arc to a corner is tangent to the arc."))
    for key, text in features.notes.items():
        words = f"Chamfers {text} where they are drawn" if key.startswith("chamfer") else text
        notes.append((key, f"{words}."))
    for n, slot in enumerate(features.slots):
        notes.append((f"slot {n}", f"{slot.callout[0].upper()}{slot.callout[1:]}."))
    return notes


def print_notes(part: Part) -> list[str]:
    """What a printer needs beside the file to print: orientation, infill, inserts, what is done after it."""
    up = print_up(part)
    axis = f"{'-' if up.min() < -0.5 else '+'}{'XYZ'[int(np.abs(up).argmax())]}"
    bed, high, shrink = bed_mm2(part, up), print_high_mm(part, up), SHRINK_MM[part.material.process]
    notes = [
        f"Print {part.number}.3mf as it stands, {axis} of the STEP file up; solid, layers of 0.2. The STEP file is the "
        "finished part.",
        f"Holes are {shrink:g} wider in the 3MF file, as they shrink.",
    ]
    if part.material.process == "fdm" and bed < _BRIM_SHARE * high**2:
        notes.append(f"Print it with a brim and supports: it is {high:.0f} high and stands on {bed:.0f} mm² only.")
    if any(bore.fit for hole in part.holes for bore in hole.bores):
        notes.append("Bores with a fit come out narrower and are reamed.")
    for row in {row.id: row for _, row in inserts_of(part)}.values():
        notes.append(
            f"Each thread {row.thread} is a heat-set insert {row.order_code}, melted in flush where its screw enters; "
            f"the 3MF file has its hole, {row.hole_mm:g} wide after shrinking: nothing is drilled or tapped."
        )
    return notes


def side_of(number: str, side: str) -> np.ndarray:
    """Gives the (3,) way out of a part on a side, one of `_SIDES`, in the part's frame.

    Drives are drawn with the shoulder's axis along y, the encoder at its lower end, the arm between the cheeks.
    """
    arm = 1.0 if number == "encoder_cheek" else -1.0
    if side == "below":
        return np.array([0.0, 0.0, -1.0])
    senses = {"the arm's side": arm, "the outer side": -arm, "the motor's side": 1.0, "the encoder's side": -1.0}
    return np.array([0.0, senses[side], 0.0])


def _side_notes(part: Part, front: Frame) -> list[tuple[str, str]]:
    """Where the sides are in the main view that the texts of a part's holes name."""
    texts = " ".join(hole.callout for hole in part.holes)
    (right, up), towards = front.axes, front.towards
    found = []
    for side in (side for side in _SIDES if side in texts):
        way = side_of(part.number, side)
        places = {"in front": towards, "behind": -towards, "right": right, "left": -right, "at the top": up}
        place = next((place for place, axis in places.items() if float(way @ axis) > _SAME), "at the bottom")
        found.append(f"{side.replace('below', 'the lower side')} is {place}")
    return [("", f"In the main view {', '.join(found)}.")] if found else []


def _auxiliary(text: str, features: Features, held: Controlled) -> str:
    """Sets threads, and what a view states with its tolerance, in brackets, without it: a second one is ambiguous."""
    lengths = (*held.lengths, *held.depths)
    drawn = {(f"{round(n.end_mm - n.start_mm, 3):g}", n.text.removeprefix("±")) for n in lengths}
    drawn |= {match.groups() for size in features.sizes if (match := _TOLERANCED.search(size.text))}
    text = _TOLERANCED.sub(lambda match: f"({match[1]})" if match.groups() in drawn else match[0], text)
    return _THREAD.sub(r"(\g<0>)", text)


def _exact_notes(features: Features) -> list[tuple[str, str]]:
    """What boxed coordinates are, and what fixes where they count from: datums, and a pattern located in itself."""
    if not features.exact:
        return []
    fixing = [datum.letter for datum in features.datums]
    alone = [z for z in features.zones if z.combined and not any(d.faces == z.faces for d in features.datums)]
    fixing += [f"the {bores_of(zone, features)}x Ø{2 * zone.faces[0].radius:g} with CZ" for zone in alone[:1]]
    fixed = " and ".join(filter(None, (", ".join(fixing[:-1]), fixing[-1])))
    boxed = "Boxed coordinates are theoretically exact, ISO 1101, so are 0 and right angles"
    return [("", f"{boxed}. 0 and the axes are as {fixed} fix{'es' * (len(fixing) == 1)} them.")]


def _between_centres(part: Part, features: Features) -> bool:
    """Whether a part is turned, has an end without a bore, and no end too thin for a centre hole."""
    bored = [bore for group in features.groups for bore in group.bores if is_along(bore.axis, features.main)]
    ends = sum(max(map(len, bore.spans.values())) for bore in bored)
    outer = [2.0 * f.radius for f in features.faces if f.kind == "cylinder" and not f.hollow]
    if not features.turned or part.order_code or not outer or min(outer) < _CENTRE_MM[1] + 2 * _CENTRE_WALL_MM:
        return False
    return ends < 2 and not any(bore.through for bore in bored)


def _axis(along: np.ndarray) -> str:
    """Names the axis of the model that a view's axis lies along, such as "-X"."""
    k = int(np.abs(along).argmax())
    return f"{'-' if along[k] < 0.0 else ''}{'XYZ'[k]}"


def finish_of(part: Part) -> str:
    """What is done to a part's surface after it is cut or printed."""
    if "anodised" in part.description:
        layer = "ISO 10074, 0.025 mm" if "hard anodised" in part.description else "ISO 7599-AA10"
        return f"anodised {layer}; sizes hold with the coating, fits and threads stay bare"
    if part.to_drawing:
        return "as its maker delivers it, clean and free of burrs"
    if part.material.process:
        return "as printed, supports and strings removed"
    return "as bought where nothing is cut" if part.order_code else "as cut, no coating"
