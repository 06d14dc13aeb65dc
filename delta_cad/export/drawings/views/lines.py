"""A typeset line of a callout: text with a surface symbol, a tolerance frame or a datum letter in it.

Surfaces after ISO 21920-1, frames after ISO 1101, datums after ISO 5459. All lines are equally high.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from delta_cad.export.drawings.part.faces import Face
from delta_cad.export.drawings.part.holes import HoleGroup
from delta_cad.export.drawings.part.record import Datum, Features, Zone
from delta_cad.export.drawings.sheet_io.lettering import LINE, SURFACE, SURFACE_WIDE, width_of, wrapped
from delta_cad.export.drawings.sheet_io.sheet import Annotation, Arc, Area, Item, Point, Primitive, Stroke, Text
from delta_cad.export.drawings.views.marks import LETTER_MM, number

PITCH_MM = LETTER_MM * LINE
_SMALL_MM = 2.0  # letters in a frame, half as high as it
BASE_MM = (PITCH_MM - LETTER_MM) / 2  # of a line of text over its lower end
_STEEP = 3.0**0.5  # of the legs of a surface's symbol
TRIANGLE_MM = 1.9, 1.6  # base and height of a datum's
EXACT_MM = 0.5, 0.4  # from a number to its frame, along its line and over it
_BOX_MM = 3.2, 6.8  # sides of a datum's box from the line's left end


@dataclass(frozen=True)
class Flag:
    """A datum's letter in its box: beside a frame, hung from the line above, or at the end of a leader."""

    datum: Datum
    adjacent: Zone | None = None
    suspended: bool = True


Line = str | Zone | Flag


def length_of(line: Line) -> float:
    """Computes how long a line is, mm."""
    if isinstance(line, Zone):
        return PITCH_MM + sum(_cell(text) for text in _said(line))
    if isinstance(line, Flag):
        before = 0.0 if line.adjacent is None else length_of(line.adjacent)
        return before + (_BOX_MM[1] if line.suspended else _BOX_MM[1] - _BOX_MM[0])
    return width_of(line, LETTER_MM)


def lines_of_group(group: HoleGroup, features: Features, most_mm: float) -> list[Line]:
    """Gives the lines of a group of holes: each hole's callout, broken at a width, with what is asked of its place."""
    found: list[Line] = []
    for diameter, callout in zip(sorted(group.diameters), group.callout, strict=True):
        found += [line for one in callout.split("\n") for line in broken(one, most_mm)]
        walls = [f for bore in group.bores for f in bore.faces if abs(2 * f.radius - diameter) < 0.01]
        found += tolerances_of(walls, features)
    return found


def broken(callout: str, most_mm: float) -> list[str]:
    """Breaks a callout into lines; the symbol of a surface stays with its text."""
    before, sign, after = callout.partition(SURFACE)
    lines = wrapped(before, LETTER_MM, most_mm)
    if not sign:
        return lines
    longer = f"{lines[-1]} {sign}{after}"
    return [*lines[:-1], longer] if width_of(longer, LETTER_MM) <= most_mm else [*lines, sign + after]


def tolerances_of(faces: Sequence[Face], features: Features) -> list[Line]:
    """Gives frames and letters that belong to some faces."""
    known = {id(face) for face in faces}
    frames = [zone for zone in features.zones if id(zone.faces[0]) in known]
    datum = next((datum for datum in features.datums if id(datum.faces[0]) in known), None)
    if datum is None:
        return [*frames]
    return [*frames[:-1], Flag(datum, frames[-1] if frames else None)]


def set_line(line: Line, at: Point, wording: Iterable[str] = ()) -> list[Item]:
    """Sets a line, from the left end of its base line, mm; `wording` are the keys of what its text states."""
    if isinstance(line, Zone):
        return [_frame(line, (at[0], at[1] - BASE_MM))]
    if isinstance(line, Flag):
        corner = at[0], at[1] - BASE_MM
        if line.adjacent is None:
            return [_flag(line, corner)]
        return [_frame(line.adjacent, corner), _flag(line, (corner[0] + length_of(line.adjacent), corner[1]))]
    before, sign, after = line.partition(SURFACE)
    if not sign:
        return [Text(at, LETTER_MM, line, states=tuple(wording))]
    found: list[Item] = [Text(at, LETTER_MM, before.rstrip(), states=tuple(wording))] if before.strip() else []
    x = at[0] + width_of(before, LETTER_MM)
    return [*found, surface(after.strip(), (x, at[1]), LETTER_MM, () if found else tuple(wording))]


def surface(text: str, at: Point, height: float, wording: tuple[str, ...] = ()) -> Annotation:
    """Draws the symbol of a surface that is cut, a text such as "Ra 1.6" under its line; arguments as of a `Text`."""
    x, y, h = *at, height
    foot, low, high = (x + 0.67 * h / _STEEP, y - 0.05 * h), y + 0.62 * h, y + 1.28 * h
    top = foot[0] + 1.33 * h / _STEEP
    letters = Text((x + SURFACE_WIDE * h, y), h, text, states=wording)
    legs = Stroke("dimension", ((x, low), foot, (top, high), (letters.end[0], high)))
    bar = Stroke("dimension", ((x, low), (foot[0] + 0.67 * h / _STEEP, low)))
    return Annotation(f"surface {text}", (legs, bar, letters))


def _said(zone: Zone) -> tuple[str, ...]:
    wide = ("Ø" if zone.is_round else "") + number(zone.value_mm)
    return wide + (" CZ" if zone.combined else ""), *zone.datums


def _cell(text: str) -> float:
    return max(PITCH_MM, width_of(text, _SMALL_MM) + 2.0)


def _frame(zone: Zone, corner: Point) -> Annotation:
    """The frame of a tolerance from its lower left corner."""
    (x, y), high = corner, PITCH_MM
    items: list[Primitive] = [_box(x, y, x + high, y + high), *_characteristic(zone.kind, (x + high / 2, y + high / 2))]
    x += high
    for n, text in enumerate(_said(zone)):
        wide = _cell(text)
        base = x + (wide - width_of(text, _SMALL_MM)) / 2, y + (high - _SMALL_MM) / 2
        items += [_box(x, y, x + wide, y + high), Text(base, _SMALL_MM, text, states=(zone.key,) if n == 0 else ())]
        x += wide
    return Annotation(" ".join((zone.kind, *_said(zone))), tuple(items))


def _characteristic(kind: str, middle: Point) -> list[Primitive]:
    """The symbol of what a tolerance holds."""
    x, y = middle

    def line(*points: Point) -> Stroke:
        return Stroke("dimension", tuple((x + u, y + v) for u, v in points))

    if kind == "position":
        return [Arc("dimension", middle, 0.9), line((-1.5, 0.0), (1.5, 0.0)), line((0.0, -1.5), (0.0, 1.5))]
    if kind == "perpendicularity":
        return [line((-1.4, -1.1), (1.4, -1.1)), line((0.0, -1.1), (0.0, 1.3))]
    assert kind == "coaxiality"
    return [Arc("dimension", middle, 0.7), Arc("dimension", middle, 1.3)]


def _flag(flag: Flag, corner: Point) -> Annotation:
    """A datum's letter in its box from the line's lower left corner, tied by its triangle to what it belongs to."""
    x, y = corner
    left = x + _BOX_MM[0] if flag.suspended else x
    side, letter = _BOX_MM[1] - _BOX_MM[0], flag.datum.letter
    base = left + (side - width_of(letter, _SMALL_MM)) / 2, y + 0.15 + (side - _SMALL_MM) / 2
    items: list[Primitive] = [_box(left, y + 0.15, left + side, y + 0.15 + side)]
    items.append(Text(base, _SMALL_MM, letter, states=(flag.datum.key,)))
    if flag.adjacent is not None:
        foot = x, y + PITCH_MM / 2
        items += [triangle(foot, (1.0, 0.0)), Stroke("dimension", ((x + TRIANGLE_MM[1], foot[1]), (left, foot[1])))]
    elif flag.suspended:
        foot = x + 1.5, y + PITCH_MM
        items += [
            triangle(foot, (0.0, -1.0)),
            Stroke("dimension", ((foot[0], foot[1] - TRIANGLE_MM[1]), (foot[0], y + 1.95), (left, y + 1.95))),
        ]
    return Annotation(f"datum {letter}", tuple(items))


def triangle(foot: Point, away: Point) -> Area:
    """Draws a datum's triangle: the middle of its base, and the way to its tip, a unit vector."""
    (x, y), (u, v), (half, high) = foot, away, (TRIANGLE_MM[0] / 2, TRIANGLE_MM[1])
    return Area("dimension", ((x - half * v, y + half * u), (x + half * v, y - half * u), (x + high * u, y + high * v)))


def boxed(text: Text) -> Stroke:
    """Draws the frame of a theoretically exact dimension around its number, ISO 129-1."""
    (x0, y0, x1, y1), (along, over) = text.box, EXACT_MM
    return _box(x0 - over, y0 - along, x1, y1 + along) if text.upright else _box(x0 - along, y0, x1 + along, y1 + over)


def _box(x0: float, y0: float, x1: float, y1: float) -> Stroke:
    return Stroke("dimension", ((x0, y0), (x1, y0), (x1, y1), (x0, y1)), closed=True)
