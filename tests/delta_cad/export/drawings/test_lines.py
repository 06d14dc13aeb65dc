"""Lines of callouts: symbols of surfaces, frames of tolerances, letters of datums."""

from __future__ import annotations

import pytest

from delta_cad.export.drawings.part.record import Datum, Zone
from delta_cad.export.drawings.sheet_io.lettering import SURFACE, width_of
from delta_cad.export.drawings.sheet_io.sheet import Annotation, Arc, Area, Item, Stroke, Text, box_of
from delta_cad.export.drawings.views.lines import PITCH_MM, Flag, Line, broken, length_of, set_line

ZONE = Zone("position", 0.05, True, (), ("A", "B"), "zone 1")
FLAG = Flag(Datum("C", ()), ZONE)


def marks(items: list[Item]) -> list[Annotation]:
    return [item for item in items if isinstance(item, Annotation)]


def test_a_surface_is_a_symbol_with_its_roughness_under_its_bar() -> None:
    items = set_line(f"Ø8 H7 {SURFACE}Ra 1.6", (10.0, 20.0), ("bore 0.0",))
    (text,) = (item for item in items if isinstance(item, Text))
    (mark,) = marks(items)
    assert (text.text, text.states) == ("Ø8 H7", ("bore 0.0",))
    legs, bar, letters = mark.items
    assert isinstance(legs, Stroke)
    assert isinstance(bar, Stroke)
    assert isinstance(letters, Text)
    assert (mark.name, letters.text) == ("surface Ra 1.6", "Ra 1.6")
    start, foot, top, end = legs.points
    assert foot[1] < start[1] < top[1] == end[1]  # a short leg down, a long one up, the bar over the text
    assert top[1] >= letters.box[3]
    assert end[0] == pytest.approx(letters.box[2])
    assert bar.points[0] == start
    assert bar.points[1] == pytest.approx((2 * foot[0] - start[0], start[1]))  # shut to a triangle: it is cut
    assert mark.box[0] >= text.box[2]
    (alone,) = marks(set_line(f"{SURFACE}Ra 1.6", (10.0, 20.0), ("x",)))  # its text tells then
    assert [item.states for item in alone.items if isinstance(item, Text)] == [("x",)]


@pytest.mark.parametrize("kind", ["position", "perpendicularity", "coaxiality"])
def test_a_frame_says_characteristic_zone_and_datums_in_their_order(kind: str) -> None:
    zone = Zone(kind, 0.02, kind != "perpendicularity", (), ("A", "B"), "zone 3")
    (mark,) = marks(set_line(zone, (0.0, 0.0)))
    value = "0.02" if kind == "perpendicularity" else "Ø0.02"
    texts = [item for item in mark.items if isinstance(item, Text)]
    assert [(text.text, text.states) for text in texts] == [(value, ("zone 3",)), ("A", ()), ("B", ())]
    assert mark.name == f"{kind} {value} A B"
    symbol, *cells = [box_of([item]) for item in mark.items if isinstance(item, Stroke) and item.closed]
    for (x0, y0, x1, y1), text in zip(cells, texts, strict=True):  # each text in its cell
        assert x0 < text.box[0] < text.box[2] < x1
        assert y0 < text.box[1] < text.box[3] < y1
    signs = [i for i in mark.items if isinstance(i, Arc) or (isinstance(i, Stroke) and not i.closed)]
    box = box_of(signs)
    assert symbol[0] < box[0] < box[2] < symbol[2]
    assert symbol[1] < box[1] < box[3] < symbol[3]
    assert sum(isinstance(sign, Arc) for sign in signs) == {"position": 1, "coaxiality": 2}.get(kind, 0)


@pytest.mark.parametrize(
    "line", [f"Ø8 H7 {SURFACE}Ra 1.6", ZONE, FLAG, Flag(FLAG.datum), Flag(FLAG.datum, suspended=False)]
)
def test_a_line_is_as_long_as_it_says_and_stays_in_its_height(line: Line) -> None:
    box = box_of(set_line(line, (0.0, 0.0)))
    assert box[2] == pytest.approx(length_of(line), abs=0.05)
    assert box[3] - box[1] <= PITCH_MM + 1e-9


def test_a_datum_is_tied_to_its_frame_or_to_the_line_above() -> None:
    frame, flag = marks(set_line(FLAG, (0.0, 0.0)))
    (head,) = (item for item in flag.items if isinstance(item, Area))
    assert min(x for x, _ in head.points) == pytest.approx(frame.box[2])  # its base on the frame's side
    (suspended,) = marks(set_line(Flag(FLAG.datum), (0.0, 0.0)))
    (head,) = (item for item in suspended.items if isinstance(item, Area))
    assert max(y for _, y in head.points) == pytest.approx(suspended.box[3])


def test_a_surface_s_symbol_stays_with_its_text_when_a_callout_isbroken() -> None:
    text = f"2x Ø3 H7 (+0.01/0) through, dowels of the foot block {SURFACE}Ra 1.6"
    for most in (30.0, 40.0, 50.0, 60.0, 70.0):
        lines = broken(text, most)
        assert " ".join(lines) == text
        (own,) = (line for line in lines if SURFACE in line)
        assert own.endswith(f"{SURFACE}Ra 1.6")
        assert all(width_of(line, 2.5) <= most for line in lines)
