"""Datums and geometric tolerances: what a part's function asks for, on parts made for it."""

from __future__ import annotations

import cadquery as cq
import numpy as np
import pytest

from delta_cad.export.drawings.checker import drawing_faults
from delta_cad.export.drawings.part.controlled import Controlled, Round
from delta_cad.export.drawings.part.faces import faces_of
from delta_cad.export.drawings.part.features import features_of
from delta_cad.export.drawings.part.record import Features
from delta_cad.export.drawings.write import part_drawing
from delta_cad.solids.boring import Boring, along_y, along_z, blind, fitted, squared
from delta_cad.solids.part import Part
from delta_cad.solids.primitive import box, cut
from tests.delta_cad.export.drawings.sample import METAL, TITLES

NONE = Controlled()
JOURNAL = Controlled(rounds=(Round(8.0, "h6"),))
TRUE = Controlled(rounds=(Round(8.0, "h6"),), coaxial=((6.0, 0.05),), shoulder=(10.0, 0.03))


def part_of(body: cq.Shape, boring: Boring) -> Part:
    return Part("sample", "", cut(body, boring.tools), METAL, True, tuple(boring.holes))


def plate(*, with_dowels: bool = True, pilot_mm: float = 0.0) -> Part:
    """60 x 40 x 10: a blind seat of 16 from above, a pilot of 12, as square as stated, two dowels of 3."""
    boring = Boring()
    boring.add("16 H7 x 5", [squared(fitted(blind(along_z(16.0, (15, 20), (10, 5))), "H7"), 0.03)])
    boring.add("12 H7 through", [squared(fitted(along_z(12.0, (40, 20), (0, 10)), "H7"), pilot_mm)])
    if with_dowels:
        boring.add("3 H7 through", [fitted(along_z(3.0, (x, 5), (0, 10)), "H7") for x in (10.0, 50.0)])
    return part_of(box((0, 0, 0), (60, 40, 10)), boring)


def shaft() -> Part:
    """Along x: a head of 12 and 10 long with a seat of 6 in it, a journal of 8."""
    body = cq.Workplane("YZ").circle(6).extrude(10).faces(">X").workplane().circle(4).extrude(30)
    boring = Boring()
    (solid,) = body.cut(cq.Workplane("YZ").circle(3).extrude(3)).val().Solids()  # type: ignore[union-attr]
    return Part("shaft", "", solid, METAL, True, tuple(boring.holes))


def found(part: Part, held: Controlled) -> Features:
    return features_of(part, faces_of(part.solid), held)


def wording(features: Features) -> list[tuple[str, float, set[float], str]]:
    """Kind, zone, diameters of what is held, datums."""
    zones = features.zones
    return [(z.kind, z.value_mm, {round(2 * f.radius, 3) for f in z.faces}, "".join(z.datums)) for z in zones]


def test_a_plate_counts_from_its_plane_its_widest_bore_and_the_next() -> None:
    features = found(plate(), NONE)
    assert wording(features) == [
        ("perpendicularity", 0.03, {16.0}, "A"),
        ("position", 0.05, {12.0}, "AB"),
        ("position", 0.05, {3.0}, "ABC"),
    ]
    assert not any(zone.combined for zone in features.zones)  # from three datums each axis has its place
    plane, seat, pilot = features.datums
    assert np.allclose(plane.faces[0].axis, (0, 0, 1))  # where the blind seat opens, although the other side is larger
    assert ([f.radius for f in seat.faces], [f.radius for f in pilot.faces]) == ([8.0], [6.0])
    assert len(features.zones[-1].faces) == 2  # the dowels are one pattern
    assert len(found(plate(with_dowels=False), NONE).datums) == 2  # nothing counts from the pilot then


def test_what_has_to_be_square_is_and_a_seat_is_the_first_datum() -> None:
    zones = [row[:3] for row in wording(found(plate(pilot_mm=0.02), NONE))]
    assert zones[:2] == [("perpendicularity", 0.03, {16.0}), ("perpendicularity", 0.02, {12.0})]
    assert zones[2] == ("position", 0.05, {12.0})
    seated = found(plate(), Controlled(seat=(2, 0.0)))
    assert np.allclose(seated.datums[0].faces[0].axis, (0, 0, -1))


def test_bores_into_the_seat_come_before_wider_ones_across() -> None:
    """They count from the sides from which their coordinates do; what is across counts from them."""
    boring = Boring()
    boring.add("8 H7 through", [fitted(along_y(8.0, (30.0, 15.0), (0.0, 20.0)), "H7")])
    boring.add("3 H7 x 6", [fitted(blind(along_z(3.0, (x, 10), (0, 6))), "H7") for x in (10.0, 50.0)])
    features = found(part_of(box((0, 0, 0), (60, 20, 30)), boring), Controlled(seat=(2, 0.0)))
    assert wording(features) == [("position", 0.05, {3.0}, "ABC"), ("position", 0.05, {8.0}, "AD")]
    bottom, long, short, _ = (datum.faces[0] for datum in features.datums)
    ways = [bottom.axis, long.axis, short.axis]
    assert np.allclose(ways, [(0, 0, -1), (0, -1, 0), (-1, 0, 0)])
    exact = sorted(place.value for place in features.places if place.key in features.exact and place.value)
    assert exact == [10.0, 10.0, 10.0, 15.0, 30.0, 50.0]


@pytest.mark.parametrize(("with_seat", "wanted"), [(True, [False, True]), (False, [True])])
def test_a_pattern_that_datums_do_not_fix_is_located_within_itself(with_seat: bool, wanted: list[bool]) -> None:
    """Dowels around the middle, with a seat there and without."""
    boring = Boring()
    if with_seat:
        boring.add("16 H7 through", [squared(fitted(along_z(16.0, (0, 0), (0, 10)), "H7"), 0.02)])
    boring.add("3 H7 through", [fitted(along_z(3.0, (x, 0), (0, 10)), "H7") for x in (-20.0, 20.0)])
    part = part_of(box((-30, -20, 0), (30, 20, 10)), boring)
    drawing, features = part_drawing(part, NONE, TITLES)
    assert [zone.combined for zone in features.zones] == wanted
    names = [symbol.name for sheet in drawing.sheets for symbol in sheet.symbols]
    assert ("position Ø0.05 CZ A B" if with_seat else "position Ø0.05 CZ A") in names
    assert drawing_faults(drawing, part, features) == []


def test_a_shaft_s_journal_is_what_its_head_is_true_to() -> None:
    features = found(shaft(), TRUE)
    assert wording(features) == [("coaxiality", 0.05, {6.0}, "A"), ("perpendicularity", 0.03, {0.0}, "A")]
    assert [zone.is_round for zone in features.zones] == [True, False]
    (journal,) = features.datums
    assert [face.radius for face in journal.faces] == [4.0]
    alone = found(shaft(), JOURNAL)
    assert (alone.zones, alone.datums) == ([], [])  # a datum of nothing is none


@pytest.mark.parametrize(("part", "held"), [(plate(pilot_mm=0.02), NONE), (shaft(), TRUE)])
def test_each_is_reported_once_on_the_drawing_and_the_checker_misses_what_is_not(part: Part, held: Controlled) -> None:
    drawing, features = part_drawing(part, held, TITLES)
    assert drawing_faults(drawing, part, features) == []
    symbols = [symbol.name.split()[0] for sheet in drawing.sheets for symbol in sheet.symbols]
    kinds = [zone.kind for zone in features.zones] + ["datum"] * len(features.datums)
    assert sorted(name for name in symbols if name != "surface") == sorted(kinds)
    for sheet in drawing.sheets:
        sheet.items[:] = [item for item in sheet.items if getattr(item, "name", "") != "datum A"]
    assert "datum A is stated 0 times" in drawing_faults(drawing, part, features)
