"""Sections in steps, and the sheet with a drive that is cut open."""

from __future__ import annotations

import re
from itertools import combinations
from math import hypot, inf

import cadquery as cq
import numpy as np
import pytest

from delta_cad.assembly.machine import Assembly
from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.tolerances.machine import machine_chains
from delta_cad.export.drawings.checker import sheet_faults
from delta_cad.export.drawings.drive_sheet import drive_page
from delta_cad.export.drawings.part.controlled import Controlled
from delta_cad.export.drawings.part.faces import faces_of
from delta_cad.export.drawings.part.features import features_of
from delta_cad.export.drawings.sheet_io.sheet import Area, Item, Stroke, Text
from delta_cad.export.drawings.title import framed
from delta_cad.export.drawings.views.choice import adjacent
from delta_cad.export.drawings.views.leaders import lines_cross
from delta_cad.export.drawings.views.projection import Frame, cut_open
from delta_cad.export.drawings.views.section import Section, section_of
from delta_cad.solids.part import Hole, Part
from tests.delta_cad.export.drawings.sample import METAL, TITLES

TOP = Frame((1, 0, 0), (0, 1, 0))


def bored(*spots: tuple[float, float]) -> Part:
    """A plate 60 x 40 x 8 with counterbored holes at some places, a plain one of 12 in the middle."""
    body = cq.Workplane().box(60, 40, 8, centered=False).faces(">Z").workplane(origin=(0, 0, 8))
    body = body.pushPoints(spots).cboreHole(4.0, 7.0, 4.0).faces(">Z").workplane(origin=(0, 0, 8))
    (solid,) = body.pushPoints([(30, 20)]).hole(12.0).val().Solids()  # type: ignore[union-attr]
    holes = (
        Hole(4.0, len(spots), "4 through"),
        Hole(7.0, len(spots), "counterbore 4 deep"),
        Hole(12.0, 1, "12 through"),
    )
    return Part("plate", "", solid, METAL, True, holes)


def test_a_cut_in_steps_leaves_what_lies_behind_each() -> None:
    block = cq.Solid.makeBox(10, 20, 10)
    rest, rings = cut_open(block, TOP, [(6.0, 3.0), (inf, 8.0)])
    assert rest.Volume() == pytest.approx(10 * 6 * 3 + 10 * 14 * 8)
    spans = sorted((min(y for _, y in ring), max(y for _, y in ring)) for ring in rings)
    assert spans == [(pytest.approx(0), pytest.approx(6)), (pytest.approx(6), pytest.approx(20))]
    aside, _ = cut_open(block, TOP, [(4.0, 3.0), (inf, 8.0)], 0)
    assert aside.Volume() == pytest.approx(20 * 4 * 3 + 20 * 6 * 8)


def test_a_section_goes_through_the_steps_of_a_bore_and_cuts_none_off_its_axis() -> None:
    """A plane through the second hole would cut the plain bore beside its axis."""
    part = bored((10, 10), (50, 16))
    features = features_of(part, faces_of(part.solid), Controlled())
    section = section_of(adjacent(TOP, "below"), TOP, features)
    pair = next(group.bores for group in features.groups if len(group.diameters) == 2)
    (plain,) = (bore for group in features.groups if len(group.diameters) == 1 for bore in group.bores)
    assert section.steps == ((inf, 10.0),)
    assert sorted(section.meets(bore) for bore in pair) == [False, True]
    assert not section.clips(plain)
    assert Section(section.frame, section.axis, ((inf, 16.0),)).clips(plain)


@pytest.fixture(scope="module")
def page(best_dimensions: Dimensions, best_assembly: Assembly) -> tuple[str, list[Item]]:
    scale, items, frames = drive_page(best_dimensions, best_assembly)
    sheet = framed("A3", scale, "1 / 1", TITLES)
    sheet.add(items)
    sheet.frames |= frames
    assert sheet_faults(sheet) == []
    return scale, items


def words(items: list[Item]) -> str:
    return " ".join(item.text for item in items if isinstance(item, Text))


def test_fits_of_a_drive_are_those_of_its_parts(page: tuple[str, list[Item]], best_dimensions: Dimensions) -> None:
    d, said = best_dimensions, words(page[1])
    shaft, outer = f"{d.shaft.diameter_mm:g}", f"{d.bearing.outer_mm:g}"
    wanted = [f"Ø{shaft} G7/h6: sector", f"Ø{shaft} H7/h6: arm", f"Ø{outer} H6: bearing", f"Ø{outer} H7: bearing"]
    wanted += [f"Ø{d.motor.pilot_diameter_mm:g} H7: the motor's pilot", f"Ø{d.motor.shaft_diameter_mm:g} H7: pinion"]
    assert [text for text in wanted if text not in said] == []


def test_gaps_and_preload_are_what_the_lengths_come_to(
    page: tuple[str, list[Item]], best_dimensions: Dimensions
) -> None:
    """The oracle is the distance of the axes less both radii; the spring's rate over five lengths and two bearings."""
    d, said = best_dimensions, words(page[1])
    assert d.capstan is not None
    assert d.preload is not None
    c, spring, (u, z) = d.capstan, d.preload, d.bracket.motor_axis_mm
    gap = hypot(u - d.bracket.shoulder_u_mm, z) - c.rim_radius_mm - c.pinion_radius_mm
    measured = re.search(r"gap ([\d.]+), at least [\d.]+, at most [\d.]+: pinion and sector", said)
    assert measured is not None
    assert float(measured[1]) == pytest.approx(gap, abs=0.05)
    assert spring.rate_N_mm is not None
    least = spring.force_N - spring.rate_N_mm * (5 * 0.02 + 2 * 0.12)
    most = spring.force_N + spring.rate_N_mm * 5 * 0.02
    assert f"preload of the bearings {spring.force_N:g} N, {least:.1f} to {most:.1f} over all" in said


def test_leaders_of_a_drive_cross_none(page: tuple[str, list[Item]], best_dimensions: Dimensions) -> None:
    scale, items = page
    assert scale == "2:1"
    dots = [item for item in items if isinstance(item, Area)]
    leaders = [item for item in items if isinstance(item, Stroke) and item.layer == "dimension"]
    assert len(dots) == len(leaders) >= 12
    for side in (-1.0, 1.0):
        lines = [np.array(one.points) for one in leaders if side * (one.points[1][0] - one.points[0][0]) > 0.0]
        assert not any(lines_cross(a, b) for a, b in combinations(lines, 2))
    said = words(items)
    assert [chain.name for chain in machine_chains(best_dimensions) if f"{chain.name}, {chain.unit}" not in said] == []
