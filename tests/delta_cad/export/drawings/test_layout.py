"""Views, sheets and what stands where."""

from __future__ import annotations

from dataclasses import replace

import cadquery as cq
import numpy as np
import pytest

from delta_cad.export.drawings.checker import drawing_faults
from delta_cad.export.drawings.layout import ratio
from delta_cad.export.drawings.part.controlled import Controlled
from delta_cad.export.drawings.part.faces import faces_of
from delta_cad.export.drawings.part.features import features_of
from delta_cad.export.drawings.sheet_io.sheet import Stroke
from delta_cad.export.drawings.title import Titles
from delta_cad.export.drawings.views.choice import View, ViewError, adjacent, views_of
from delta_cad.export.drawings.views.marks import LETTER_MM
from delta_cad.export.drawings.views.projection import Frame
from delta_cad.export.drawings.write import part_drawing
from delta_cad.solids.part import Hole, Part
from tests.delta_cad.export.drawings.sample import HELD, METAL, TITLES, drawn, plate, texts


def views(part: Part) -> list[View]:
    features = features_of(part, faces_of(part.solid), HELD)
    return views_of(part, features)


@pytest.mark.parametrize(
    ("slot", "viewer"), [("below", (0, 0, 1)), ("above", (0, 0, -1)), ("right", (-1, 0, 0)), ("left", (1, 0, 0))]
)
def test_first_angle(slot: str, viewer: tuple[float, float, float]) -> None:
    """The view from above stands below the front view, that from the left on its right; each is in line with it."""
    front = Frame((1, 0, 0), (0, 0, 1))
    side = adjacent(front, slot)
    assert np.allclose(side.towards, viewer)
    shared = side.right if slot in ("below", "above") else side.up
    assert np.allclose(shared, front.right if slot in ("below", "above") else front.up)


def test_a_plate_has_two_views_of_which_one_is_cut_through_its_steps() -> None:
    front, side, picture = views(plate())
    assert np.allclose(front.towards, (0, 0, 1))  # where the blind bores are open
    assert (side.slot, side.title) == ("below", "A-A")
    assert np.allclose(side.towards, (0, 1, 0))
    assert side.cut is not None
    assert side.cut.steps == ((pytest.approx(18.325), 20.0), (np.inf, 7.0))  # a blind thread, then a counterbore
    assert side.rings
    assert picture.slot == "picture"
    assert {place.key for place in front.places}.isdisjoint(place.key for place in side.places)


def test_a_floor_that_the_cut_view_hides_is_drawn_there_and_nothing_else_is() -> None:
    """A pocket beside the plane of the cut, its floor 2.5 above the bottom: where the coordinate 2.5 stands."""
    whole = plate()
    pocket = cq.Solid.makeBox(8, 3, 8, cq.Vector(12, 2, 2.5))
    (solid,) = whole.solid.cut(pocket).Solids()
    side = next(view for view in views(replace(whole, solid=solid)) if view.cut is not None)
    hidden = [item for item in side.items if isinstance(item, Stroke) and item.layer == "hidden"]
    assert hidden
    assert len(side.behind) > len(hidden)
    assert {round(abs(point[1]), 6) for item in hidden for point in item.points} == {2.5}
    assert any(place.value == pytest.approx(2.5) for place in side.places)


def test_a_slanted_pocket_is_drawn_once_more_turned() -> None:
    body = cq.Workplane().box(60, 40, 8)
    body = body.cut(cq.Workplane().box(20, 10, 20).rotate((0, 0, 0), (0, 0, 1), 30))
    (solid,) = body.val().Solids()  # type: ignore[union-attr]
    part = Part("frame", "", solid, METAL, True)
    drawing, features = part_drawing(part, Controlled(), TITLES)
    assert drawing_faults(drawing, part, features) == []
    assert any(text.startswith("View B, turned 30°") for text in texts(drawing))
    assert {"-10", "10", "-5", "5"} <= set(texts(drawing))


@pytest.mark.parametrize("off_mm", [0.02, 0.09, 0.3])
def test_a_side_that_is_almost_straight_is_reported_by_its_ends(off_mm: float) -> None:
    """Of a side of 100 mm: an encoder's cheek that leans by 0.05 degrees was taken for straight, and seen nowhere."""
    corners = [(0.0, 0.0), (100.0, 0.0), (100.0, 40.0 + off_mm), (0.0, 40.0)]
    (solid,) = cq.Workplane().polyline(corners).close().extrude(8.0).val().Solids()  # type: ignore[union-attr]
    part = Part("plate", "", solid, METAL, True)
    drawing, features = part_drawing(part, Controlled(), TITLES)
    assert drawing_faults(drawing, part, features) == []
    assert {"40", f"{40.0 + off_mm:g}"} <= set(texts(drawing))


def test_many_holes_get_a_table() -> None:
    at = [(x, y) for x in (-20.0, -7.0, 6.0, 21.0) for y in (-12.0, 0.0, 13.0)]
    body = cq.Workplane().box(60, 40, 8).faces(">Z").workplane().pushPoints(at).hole(3.0)
    (solid,) = body.val().Solids()  # type: ignore[union-attr]
    part = Part("grid", "", solid, METAL, True, (Hole(3.0, 12, "3 H7 through"),))
    drawing, features = part_drawing(part, Controlled(), TITLES)
    assert drawing_faults(drawing, part, features) == []
    reported = texts(drawing)
    tags = [text.text for sheet in drawing.sheets for text in sheet.texts if text.height == LETTER_MM]
    assert [tags.count(f"A{n}") for n in range(1, 13)] == [2] * 12  # beside its hole and in the table
    assert reported.count("12x Ø3 H7 through") == 1
    rows = {
        (reported[k + 1], reported[k + 2])
        for k, text in enumerate(reported[:-2])
        if text[0] == "A" and reported[k + 2 :]
    }
    assert {(f"{x:g}", f"{y:g}") for x, y in at} <= rows


def test_a_bore_askew_in_space_is_refused() -> None:
    drill = cq.Solid.makeCylinder(2, 80, cq.Vector(-30, -24, -20), cq.Vector(1, 0.8, 0.7))
    (solid,) = cq.Solid.makeBox(30, 30, 30, cq.Vector(-15, -15, -15)).cut(drill).Solids()
    part = Part("askew", "", solid, METAL, True, (Hole(4.0, 1, "4 through"),))
    with pytest.raises(ViewError, match="a bore of 4 mm is slanted"):
        views(part)


def test_the_title_block_says_what_is_ordered() -> None:
    titles = Titles("plate", "a plate " * 20, METAL.name, "3", "36 g", "60 x 40 x 8 mm", "sample", "B")
    drawing, _ = part_drawing(plate(), HELD, titles)
    words = " ".join(texts(drawing))
    for said in ("plate", METAL.name, "36 g", "60 x 40 x 8 mm", "ISO 2768-mK", "ISO 13715", "First angle", "A4"):
        assert said in words


def test_scales_are_written_as_usual() -> None:
    assert [ratio(scale) for scale in (10.0, 2.0, 1.0, 0.5, 0.2)] == ["10:1", "2:1", "1:1", "1:2", "1:5"]


def test_a_drawing_is_the_same_each_time() -> None:
    assert drawn()[0] == drawn(replace(plate()))[0]
