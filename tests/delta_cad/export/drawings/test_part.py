"""What has to be told of a part, held against parts that are dimensioned by hand."""

from __future__ import annotations

import re
from dataclasses import replace

import cadquery as cq
import numpy as np
import pytest

from delta_cad.assembly.machine import Assembly
from delta_cad.dimensions import Dimensions
from delta_cad.export.drawings.notes import named, notes_of, ordered_as, side_of
from delta_cad.export.drawings.part.controlled import Controlled, Length, Round, controlled
from delta_cad.export.drawings.part.faces import faces_of
from delta_cad.export.drawings.part.features import features_of
from delta_cad.export.drawings.part.holes import HoleError, hole_groups, lettered
from delta_cad.export.drawings.part.record import Features
from delta_cad.export.drawings.sheet_io.lettering import SURFACE
from delta_cad.export.drawings.sheet_io.sheet import Stroke
from delta_cad.export.drawings.title import UNDATED, grams
from delta_cad.export.drawings.views.choice import views_of
from delta_cad.export.drawings.views.projection import Frame
from delta_cad.export.drawings.write import titles_of
from delta_cad.export.shop.jigs import jigs_of
from delta_cad.solids.forearm import make_cross_bar, make_rod_tube
from delta_cad.solids.making import material
from delta_cad.solids.part import Hole, Part
from delta_cad.solids.platform import make_handle_stem
from tests.delta_cad.export.drawings.sample import HELD, METAL, drawn, plate, texts


def features(part: Part, held: Controlled = HELD) -> Features:
    return features_of(part, faces_of(part.solid), held)


def test_points_of_edges_are_spread_over_their_length() -> None:
    """Lines, circles, an ellipse where a bore is cut askew, and the curve in which two bores meet."""
    solid = (
        cq.Workplane()
        .box(30, 20, 12)
        .faces(">Z")
        .hole(6)
        .cut(cq.Workplane("YZ").cylinder(40, 3.5).rotate((0, 0, 0), (0, 1, 0), 20))
    )
    (whole,) = solid.solids().vals()
    assert isinstance(whole, cq.Solid)
    assert {"LINE", "CIRCLE"} < {edge.geomType() for edge in whole.Edges()}
    for face, read in zip(whole.Faces(), faces_of(whole), strict=True):
        required = [edge.positionAt(k / 8).toTuple() for edge in face.Edges() for k in range(9)]  # pyright: ignore[reportAttributeAccessIssue]
        np.testing.assert_allclose(read.corners, required, atol=1e-6)
        ends = {tuple(np.round(points[[0, 2, 4]].ravel(), 6)) for _, points in read.borders}
        assert ends <= {
            tuple(np.round(read.corners[k : k + 9][[0, 4, 8]].ravel(), 6)) for k in range(0, len(required), 9)
        }


def along(found: Features, axis: int) -> set[float]:
    """Coordinates told along an axis of the part, from the datum."""
    places = [p for p in found.places if abs(p.along[axis]) > 1 - 1e-6]
    return {round(p.value - found.datum[axis], 3) + 0.0 for p in places}


def test_a_plate_is_placed_by_its_sides_and_its_bores() -> None:
    found = features(plate())
    assert np.allclose(found.main, (0, 0, 1))
    assert not found.turned
    assert along(found, 0) == {0, 10, 30, 50, 60}
    assert along(found, 1) == {0, 7, 20, 33, 40}
    assert along(found, 2) == {0, 8}  # the floors are the callouts' own
    assert found.sizes == []


def test_holes_are_ordered_together_where_they_share_their_axes() -> None:
    groups = features(plate()).groups
    assert [group.callout for group in groups] == [
        ("2x Ø5.5 through, screws", "2x Ø10 counterbore 5 deep"),
        ("Ø8 H7 through, shaft",),
        ("2x M4 x 6, drilled 6 deep",),
    ]
    assert [[bore.through for bore in group.bores] for group in groups] == [[True, True], [True], [False, False]]
    assert all(np.allclose(bore.axis, (0, 0, 1)) for bore in groups[2].bores)


def test_equal_diameters_are_distinguished_by_what_is_bored() -> None:
    body = cq.Workplane().box(30, 30, 20)
    body = body.faces(">Z").workplane().pushPoints([(8, 8)]).hole(4.0, 5.0)
    body = body.faces(">Z").workplane().pushPoints([(-8, -8)]).hole(4.0)
    for side in (">Z", "<Z"):
        at = (8, -8) if side == ">Z" else (8, 8)
        body = body.faces(side).workplane().pushPoints([at]).hole(4.0, 6.0)
    (solid,) = body.val().Solids()  # type: ignore[union-attr]
    part = Part("block", "", solid, METAL, True, (Hole(4.0, 3, "4 H7: of three kinds"),))
    reported = {line for group in hole_groups(part, faces_of(solid)) for line in group.callout}
    assert reported == {"Ø4 H7 x 5 deep", "Ø4 H7 x 20 deep", "Ø4 H7 x 6 deep from both sides"}
    shared = replace(part, holes=(Hole(4.0, 3, "2x 4 through; 1x 4 H7 x 5"),))
    assert any("x 6 deep from both sides" in line for g in hole_groups(shared, faces_of(solid)) for line in g.callout)


def test_equal_bores_of_two_uses_are_reported_in_one() -> None:
    """As in a base plate whose passage for cables is as wide as its lightening."""
    body = cq.Workplane().box(60, 40, 8).faces(">Z").workplane()
    (solid,) = body.pushPoints([(-20, 0), (0, 5), (20, 0)]).hole(8.0).val().Solids()  # type: ignore[union-attr]
    part = Part("block", "", solid, METAL, True, (Hole(8.0, 3, "1x 8 through, cables; 2x 8 through, lightening"),))
    (group,) = hole_groups(part, faces_of(solid))
    assert group.callout == ("3x Ø8 through, 1x cables, 2x lightening",)


def test_a_bore_that_is_declared_and_not_there_is_refused() -> None:
    part = replace(plate(), holes=(Hole(8.0, 2, "8 H7 through"),))
    with pytest.raises(HoleError, match="plate: 1 bores of 8 mm, 2 are declared"):
        hole_groups(part, faces_of(part.solid))


def test_a_stepped_shaft_is_a_turned_part_reported_by_its_steps() -> None:
    shaft = cq.Workplane("YZ").circle(5).extrude(12).faces(">X").workplane().circle(4).extrude(20)
    shaft = shaft.faces(">X").chamfer(0.5)
    (solid,) = shaft.val().Solids()  # type: ignore[union-attr]
    found = features(Part("shaft", "", solid, METAL, True), Controlled(rounds=(Round(8.0, "h6", surface_um=0.8),)))
    assert found.turned
    assert np.allclose(found.main, (1, 0, 0))
    assert along(found, 0) == {0, 12, 32}
    assert {size.text for size in found.sizes} == {"Ø10", f"Ø8 h6 (0/-0.009) {SURFACE}Ra 0.8"}
    assert found.notes == {"chamfer 0.5": "0.5 x 45°"}


def test_a_bored_ball_turns_about_its_bore() -> None:
    bored = cq.Workplane().sphere(6).cut(cq.Workplane("XZ").circle(2).extrude(8, both=True).translate((0, 6, 0)))
    (solid,) = bored.val().Solids()  # type: ignore[union-attr]
    found = features(Part("ball", "", solid, METAL, True, (Hole(4.0, 1, "4 x 8"),)), Controlled())
    assert np.allclose(found.main, (0, 1, 0))
    assert along(found, 1) == {0, round((36 - 4) ** 0.5, 3)}  # the middle of the ball and the bore's rim


def test_the_tangents_of_two_bosses_have_no_coordinates() -> None:
    ends = cq.Workplane().circle(10).extrude(6).union(cq.Workplane().center(40, 0).circle(5).extrude(6))
    hull = cq.Sketch().push([(0, 0)]).circle(10).reset().push([(40, 0)]).circle(5).reset().hull()
    (solid,) = ends.union(cq.Workplane().placeSketch(hull).extrude(6)).clean().val().Solids()  # type: ignore[union-attr]
    found = features(Part("link", "", solid, METAL, True), Controlled())
    assert along(found, 0) == {0, 40}
    assert along(found, 1) == {0}
    assert along(found, 2) == {0, 6}
    assert {size.text for size in found.sizes} == {"R10", "R5"}
    assert all(np.abs(place.along).max() > 1 - 1e-6 for place in found.places)


def test_of_three_equal_arms_one_is_reported() -> None:
    star = cq.Workplane().circle(8).extrude(5)
    for k in range(3):
        arm = cq.Workplane().box(30, 6, 5, centered=(False, True, False)).rotate((0, 0, 0), (0, 0, 1), 120 * k)
        star = star.union(arm)
    (solid,) = star.val().Solids()  # type: ignore[union-attr]
    found = features(Part("star", "", solid, METAL, True), Controlled())
    assert "pattern" in found.notes
    assert along(found, 0) == {0, 30}  # the hub and the end of the arm along x
    assert along(found, 1) == {-3, 0, 3}


def test_controlled_lengths_are_the_machine_s_own(best_dimensions: Dimensions) -> None:
    held, layers = controlled(best_dimensions), best_dimensions.layers
    assert [one.fit for one in held["shoulder_shaft"].rounds if one.is_of(8.0)] == ["h6"]
    assert held["shoulder_shaft"].round_of(8.002) is None
    wide = held["foot_block"].length(1, layers.motor_cheek_mm[0])
    assert wide is not None
    assert (wide.text, wide.deviations_mm) == ("±0.02", (-0.02, 0.02))
    assert held["foot_block"].length(0, layers.motor_cheek_mm[0]) is None
    (length,) = held["cross_bar"].lengths
    assert length.end_mm - length.start_mm == pytest.approx(48.569, abs=5e-4)  # as its description says


def test_signs_of_a_drawing() -> None:
    assert lettered("5 +-0.02 at 8.6 deg to the degree") == "5 ±0.02 at 8.6° to the degree"


def test_diameters_are_ordered_to_a_micrometre_and_with_their_tolerance() -> None:
    """A radius is not rounded before it is doubled: 2 x 3.0074 is 6.015 to a micrometre, not 6.014."""
    solid = cq.Solid.makeCylinder(3.0074, 9, cq.Vector(0, 0, 0), cq.Vector(1, 0, 0))
    found = features(Part("pin", "", solid, METAL, True), Controlled(rounds=(Round(6.0148, either_mm=0.01),)))
    assert [size.text for size in found.sizes] == ["Ø6.015 ±0.01"]
    rim = cq.Workplane().circle(10).extrude(4).cut(cq.Workplane().box(40, 20, 40).translate((0, -10, 0)))
    (solid,) = rim.val().Solids()  # type: ignore[union-attr]
    found = features(Part("rim", "", solid, METAL, True), Controlled(rounds=(Round(20.0, either_mm=0.1),)))
    assert "R10 ±0.05" in [size.text for size in found.sizes]  # half of what the diameter may be off


def pin(bore: float = 0.0, thin: float = 4.0) -> Part:
    """A turned part with a stud at its end, bored through where that is asked."""
    body = cq.Workplane("YZ").circle(5).extrude(20).faces(">X").workplane().circle(thin / 2).extrude(6)
    hole = Hole(bore, 1, f"{bore:g} through")
    (solid,) = (body.faces(">X").workplane().hole(bore) if bore else body).val().Solids()  # type: ignore[union-attr]
    return Part("pin", "hard anodised", solid, METAL, True, holes=(hole,) if bore else ())


@pytest.mark.parametrize(
    ("part", "allowed"), [(pin(), True), (pin(bore=3.0), False), (pin(thin=1.5), False), (plate(), False)]
)
def test_a_turned_part_s_note_tells_whether_centre_holes_may_stay(part: Part, allowed: bool) -> None:
    notes = [
        text for _, text in notes_of(part, features(part, Controlled()), Frame((1, 0, 0), (0, 1, 0)), Controlled())
    ]
    assert ("Centre holes ISO 6411-A1/2.12 may stay in solid ends." in notes) == allowed
    assert any("anodised ISO 10074, 0.025 mm" in text for text in notes) == (part.number == "pin")


def test_a_mass_is_written_without_a_power_of_ten() -> None:
    assert [grams(mass) for mass in (1100.4, 999.7, 63.27, 0.05551, 0.0)] == ["1100", "1000", "63.3", "0.0555", "-"]


def test_equal_fits_are_counted_and_pieces_of_one_arc_are_not() -> None:
    """A bar with an equal pin at each end; a plate, a groove across one of its corners' tops: that arc is in pieces."""
    bar = cq.Workplane().circle(4).extrude(20).faces(">Z").workplane().circle(2).extrude(5)
    bar = bar.faces("<Z").workplane().circle(2).extrude(5)
    (solid,) = bar.val().Solids()  # type: ignore[union-attr]
    pins = Controlled(rounds=(Round(4.0, "h7"), Round(8.0, "h6")))
    found = features_of(Part("bar", "", solid, METAL, True), faces_of(solid), pins)
    assert {size.text.split(" (")[0] for size in found.sizes} == {"2x Ø4 h7", "Ø8 h6"}
    block = cq.Workplane().box(40, 30, 8).edges("|Z").fillet(3.0)
    ridge = cq.Workplane("XZ").center(17.0, 4.0).circle(1.0).extrude(60, both=True)
    (solid,) = block.cut(ridge).val().Solids()  # type: ignore[union-attr]
    arcs = [face for face in faces_of(solid) if face.kind == "cylinder" and not face.hollow]
    found = features_of(Part("block", "", solid, METAL, True), faces_of(solid), Controlled())
    assert len(arcs) >= 4
    assert [size.text for size in found.sizes if "R3" in size.text] == ["4x R3"]


def test_a_description_s_name_is_for_the_title_and_the_rest_for_the_notes() -> None:
    name, clauses = named("rod's end, cup milled round 7.255; spigot 2.8 sanded. bonded +-0.02 deep")
    assert (name, clauses) == ("rod's end", ["Cup milled round 7.255", "Spigot 2.8 sanded", "Bonded ±0.02 deep"])
    assert named("foot block") == ("foot block", [])


def test_a_note_has_in_brackets_what_a_view_states_with_its_tolerance() -> None:
    part = replace(plate(), description="plate, 8 +-0.02 thick, 60 +-0.05 long, M4 in it")
    held = Controlled((Length(2, 0.0, 8.0, 0.02),))
    notes = [text for _, text in notes_of(part, features(part, held), Frame((1, 0, 0), (0, 1, 0)), held)]
    assert notes[0] == "(8) thick, 60 ±0.05 long, (M4) in it."


def test_a_note_says_where_the_sides_are_that_callouts_name(best_assembly: Assembly) -> None:
    """Each bore that is made "from" a side enters there, and the note places that side as the main view shows it."""
    looked = set[str]()
    for part in (part for part in best_assembly.parts if part.make):
        for bore in (bore for hole in part.holes for bore in hole.bores):
            for side in re.findall(r"from (the \w+'s side|the outer side|below)", bore.callout):
                assert np.allclose(side_of(part.number, side), -np.array(bore.direction)), (part.number, bore.callout)
                looked.add(side)
    assert looked == {"the arm's side", "the motor's side", "the encoder's side", "the outer side", "below"}
    block = next(part for part in best_assembly.parts if part.number == "foot_block")
    front = Frame((1, 0, 0), (0, 0, 1))  # seen from -y
    notes = [text for _, text in notes_of(block, features(block, Controlled()), front, Controlled())]
    sides = "the motor's side is behind, the encoder's side is in front, the lower side is at the bottom"
    assert f"In the main view {sides}." in notes


def test_a_centre_hole_stays_where_a_wall_is_left_around_it_and_an_end_is_solid(best_dimensions: Dimensions) -> None:
    def allowed(part: Part) -> bool:
        texts = [t for _, t in notes_of(part, features(part, Controlled()), Frame((1, 0, 0), (0, 1, 0)), Controlled())]
        return any("Centre holes" in text for text in texts)

    assert allowed(make_handle_stem(best_dimensions))
    assert not allowed(make_cross_bar(best_dimensions))  # its studs are 2.5 wide, a centre hole's mouth 2.12
    gauge = next(jig.part for jig in jigs_of(best_dimensions) if jig.part.number == "seat_gauge")
    assert not allowed(gauge)  # a cone in either end


def test_a_rod_s_tube_is_never_longer_than_what_its_jig_leaves(best_dimensions: Dimensions) -> None:
    f = best_dimensions.forearm
    (length,) = controlled(best_dimensions)["rod_tube"].lengths
    assert length.end_mm + 2 * f.shoulder_mm + length.deviations_mm[1] == pytest.approx(f.length_mm, abs=1e-9)
    assert length.text == "0/-0.3"
    drawing, _ = drawn(make_rod_tube(best_dimensions), controlled(best_dimensions)["rod_tube"])
    assert f"{f.tube_length_mm:.6g} 0/-0.3" in texts(drawing)


def test_a_spigot_leaves_its_bond_at_all_limits(best_dimensions: Dimensions) -> None:
    f = best_dimensions.forearm
    spigot = controlled(best_dimensions)["rod_cup"].round_of(f.spigot_diameter_mm)
    assert spigot is not None
    assert spigot.either_mm / 2 <= (f.tube_bore_mm - f.spigot_diameter_mm) / 2 / 4


def test_a_length_states_both_of_its_deviations() -> None:
    assert Length(0, 0.0, 5.0, 0.02).text == "±0.02"
    assert Length(0, 0.0, 5.0, 0.1, 0.05).text == "+0.05/-0.1"


@pytest.mark.parametrize(
    ("part", "ordered"),
    [
        (replace(plate(), material=material("aluminium-6082")), "Aluminium EN AW-6082 T6, EN 485-2 or EN 755-2"),
        (replace(plate(), material=material("stainless-1.4305")), "Stainless steel 1.4305 (+A), EN 10088-3"),
        (replace(plate(), material=material("brass")), "Brass CuZn39Pb3 (CW614N R430), EN 12164"),
        (replace(plate(), order_code="ball 6 G10 100Cr6", standard="ISO 3290-1"), "ball 6 G10 100Cr6, ISO 3290-1"),
        (replace(plate(), material=replace(METAL, name="unobtainium")), "unobtainium"),
    ],
)
def test_a_material_is_named_as_it_is_ordered(part: Part, ordered: str) -> None:
    assert ordered_as(part) == ordered


def test_a_groove_is_drawn_as_a_thread_is() -> None:
    """Along x: lands of 10 at both ends and a bottom of 9 between, 6 long."""
    body = cq.Workplane("YZ").circle(5).extrude(8).cut(cq.Workplane("YZ", (1, 0, 0)).circle(9).circle(4.5).extrude(6))
    (solid,) = body.val().Solids()  # type: ignore[union-attr]
    part = Part("drum", "", solid, METAL, True)
    front = views_of(part, features(part, Controlled()), (9.0, 10.0))[0]
    level = {
        layer: {round(abs(i.points[0][1]), 3) for i in front.items if isinstance(i, Stroke) and i.layer == layer}
        for layer in ("visible", "dimension")
    }
    assert level["dimension"] == {4.5}
    assert 4.5 not in level["visible"]
    assert 5.0 in level["visible"]


def test_a_face_reaches_as_far_when_it_carries_a_mesh() -> None:
    """A coarse mesh of a cylinder lies within it: its end would be nowhere near where the part declares it."""
    solid = cq.Solid.makeCylinder(5.0, 8.0)
    before = [face.box for face in faces_of(solid)]
    solid.tessellate(1.0, 1.0)
    assert np.array_equal([face.box for face in faces_of(solid)], before)
    assert max(box[1, 0] for box in before) >= 5.0


@pytest.mark.parametrize(
    ("provenance", "date"), [({"date": "2026-11-28"}, "2026-11-28"), ({"date": 7}, UNDATED), ({}, UNDATED)]
)
def test_a_drawing_has_the_date_that_its_design_states(
    provenance: dict[str, str | int], date: str, best_dimensions: Dimensions
) -> None:
    """The clock has no part in it: the same design gives the same bytes."""
    design = best_dimensions.design.model_copy(update={"provenance": provenance})
    assert titles_of(replace(best_dimensions, design=design), plate(), 1, "2").date == date
