"""Rules of printing on blocks whose overhangs, walls and volumes are known in closed form."""

from __future__ import annotations

from math import pi

import cadquery as cq
import numpy as np
import pytest

from delta_cad import catalogue
from delta_cad.assembly.printing import inserts_of, overhang_mm2, print_body, print_mesh, print_up, printed_bores
from delta_cad.checks.dfm.check import PRINT_RULES, RULES, check_dfm
from delta_cad.checks.dfm.printed import insert_depths, insert_walls, overhangs, small_holes
from delta_cad.dimensions.tolerances import PREDRILLED_MM
from delta_cad.export.drawings.notes import print_notes
from delta_cad.solids.boring import Boring, along_z, fitted, reamed_with, tapped
from delta_cad.solids.making import made_part, material
from delta_cad.solids.part import Part
from delta_cad.solids.primitive import box, cut, fuse, one_solid

EDGE_MM = 20.0
UP = np.array([0.0, 0.0, 1.0])


def block(boring: Boring | None = None, high_mm: float = 10.0, key: str = "petg-fdm") -> Part:
    body = box((0.0, 0.0, 0.0), (EDGE_MM, EDGE_MM, high_mm))
    tools = boring or Boring()
    solid = cut(body, tools.tools) if tools.tools else body
    extent = ((0.0, EDGE_MM), (0.0, EDGE_MM), (0.0, high_mm))
    return made_part("block", "block", solid, material(key), extent, tools.holes)


def threaded(at_mm: float, high_mm: float = 10.0) -> Part:
    boring = Boring()
    thread = tapped(along_z(0.0, (at_mm, EDGE_MM / 2), (high_mm, 0.0)), "M3")
    boring.add("M3 through", [thread])
    return block(boring, high_mm)


def table() -> Part:
    """A plate of 20 x 20 on a foot of 10 x 10: 300 mm^2 hang over nothing."""
    solid = fuse(box((0.0, 0.0, 10.0), (20.0, 20.0, 14.0)), box((5.0, 5.0, 0.0), (15.0, 15.0, 10.0)))
    return made_part("table", "table", solid, material("petg-fdm"), ((0.0, 20.0), (0.0, 20.0), (0.0, 14.0)))


def test_what_hangs_over_nothing_is_the_plate_less_its_foot() -> None:
    assert overhang_mm2(table(), UP) == pytest.approx(300.0, rel=1e-9)
    assert overhang_mm2(table(), -UP) == pytest.approx(0.0, abs=1e-9)


def test_a_part_is_printed_with_its_plate_on_the_bed() -> None:
    assert print_up(table()).tolist() == [0.0, 0.0, -1.0]
    assert next(overhangs(table())).value == pytest.approx(0.0, abs=1e-12)


def test_powder_supports_everything() -> None:
    part = made_part("table", "table", table().solid, material("pa12-sls"), table().extent_mm or (None, None, None))
    assert overhang_mm2(part, UP) == 0.0


def test_a_level_hole_bridges_itself_and_a_wide_one_does_not() -> None:
    def tunnel(diameter: float) -> float:
        boring = Boring()
        boring.add("hole", [along_z(diameter, (EDGE_MM / 2, 10.0), (0.0, 20.0))])
        return overhang_mm2(block(boring, 20.0), np.array([1.0, 0.0, 0.0]))

    assert tunnel(6.0) == 0.0
    assert tunnel(12.0) == pytest.approx(
        pi / 4.0 * 12.0 * 20.0, rel=0.05
    )  # a quarter of its wall is flatter than 45 deg


def test_the_body_to_print_has_the_inserts_hole_and_wider_clearance_holes() -> None:
    boring = Boring()
    boring.add("M3 through", [tapped(along_z(0.0, (6.0, 10.0), (10.0, 0.0)), "M3")])
    boring.add("3.4 through", [along_z(3.4, (14.0, 10.0), (0.0, 10.0))])
    part, row = block(boring), catalogue.insert("M3x5.7")
    drill, deep = catalogue.screw("M3").tap_drill_mm, row.length_mm + 1.0
    by_hand = EDGE_MM**2 * 10.0 - pi / 4 * (
        (row.hole_mm + 0.2) ** 2 * deep + drill**2 * (10.0 - deep) + (3.4 + 0.2) ** 2 * 10.0
    )
    assert float(print_body(part).Volume()) == pytest.approx(by_hand, rel=1e-6)


def test_dowels_holes_have_a_pilot_hole_or_none_until_they_are_reamed_together() -> None:
    def body(pilot_mm: float) -> float:
        boring = Boring()
        hole = reamed_with(fitted(along_z(3.0, (10.0, 10.0), (0.0, 10.0)), "H7"), "other", pilot_mm)
        boring.add("3 H7 through", [hole])
        return float(print_body(block(boring)).Volume())

    assert body(0.0) == pytest.approx(4000.0, rel=1e-9)
    assert body(PREDRILLED_MM) == pytest.approx(4000.0 - pi / 4 * (PREDRILLED_MM + 0.2) ** 2 * 10.0, rel=1e-6)


def test_a_bore_with_a_fit_is_printed_as_it_is_drawn_and_comes_out_narrower() -> None:
    boring = Boring()
    boring.add("8 H7 through", [fitted(along_z(8.0, (10.0, 10.0), (0.0, 10.0)), "H7")])
    assert list(printed_bores(block(boring))) == []


def test_the_mesh_to_print_stands_on_the_bed() -> None:
    mesh = print_mesh(table())
    low, high = mesh.vertices.min(axis=0), mesh.vertices.max(axis=0)
    assert low[2] == 0.0
    assert high[2] - low[2] == pytest.approx(14.0)
    assert mesh.volume_mm3 == pytest.approx(2600.0)  # positive: turned, not mirrored


def test_what_stands_on_too_little_is_printed_with_a_brim() -> None:
    def notes(shape: cq.Shape) -> str:
        solid = one_solid(shape, "post")
        return " ".join(print_notes(made_part("post", "post", solid, material("petg-fdm"), (None, None, None))))

    assert "Print it with a brim and supports: it is 20 high" in notes(
        cq.Solid.makeSphere(10.0, cq.Vector(), cq.Vector(0, 0, 1), -90, 90, 360)
    )
    assert "brim" not in notes(box((0.0, 0.0, 0.0), (10.0, 10.0, 20.0)))


def test_a_print_s_notes_name_its_inserts_and_what_is_reamed() -> None:
    notes = " ".join(print_notes(threaded(10.0)))
    row = catalogue.insert("M3x5.7")
    assert f"Each thread M3 is a heat-set insert {row.order_code}" in notes
    assert "nothing is drilled or tapped" in notes
    assert "reamed" not in notes
    boring = Boring()
    boring.add("8 H7 through", [fitted(along_z(8.0, (10.0, 10.0), (0.0, 10.0)), "H7")])
    assert "Bores with a fit come out narrower and are reamed" in " ".join(print_notes(block(boring)))


def test_an_insert_near_an_edge_has_too_little_plastic() -> None:
    row = catalogue.insert("M3x5.7")
    for at_mm in (3.0, 8.0):
        found = next(insert_walls(threaded(at_mm)))
        assert found.value == pytest.approx(at_mm - row.hole_mm / 2, abs=0.02)
        assert (found.share > 1.0) == (at_mm - row.hole_mm / 2 < row.wall_mm)


def test_a_plate_thinner_than_its_insert_is_found() -> None:
    assert next(insert_depths(threaded(10.0, 4.0))).share > 1.0
    assert next(insert_depths(threaded(10.0, 8.0))).share < 1.0
    assert len(inserts_of(threaded(10.0))) == 1


def test_a_hole_below_two_millimetres_closes() -> None:
    boring = Boring()
    boring.add("1.6 through", [along_z(1.6, (10.0, 10.0), (0.0, 10.0))])
    assert next(small_holes(block(boring))).share > 1.0
    assert next(small_holes(block(boring, key="pa12-sls"))).share < 1.0


def test_prints_are_held_against_their_own_rules_alone() -> None:
    names = {result.name for result in check_dfm([block()])}
    assert names == {rule.name for rule in (*RULES, *PRINT_RULES)}
    cut_alone = {result.name for result in check_dfm([block(key="aluminium-6082")])}
    assert cut_alone == {rule.name for rule in RULES}
