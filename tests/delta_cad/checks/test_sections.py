"""Solids that are thinner, or heavier, than the structure assumes are refused, however short the place."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import cadquery as cq
import numpy as np
import pytest

from delta_cad.assembly.machine import Assembly
from delta_cad.checks.report import CheckResult
from delta_cad.checks.sections import _cut, _location, _stations, check_sections
from delta_cad.design import design_from_dict
from delta_cad.dimensions import Dimensions, dimensions
from delta_cad.solids.brackets import make_encoder_cheek
from delta_cad.solids.part import Hole
from delta_cad.solids.platform import make_platform
from delta_cad.structure.beam import Beam, BeamSlice
from delta_cad.structure.section import rectangle
from delta_cad.structure.spans import Span, structure_spans
from tests.committed import changed
from tests.delta_cad.catalogue.offered import machine, offered
from tests.delta_cad.checks.machines import box, part, rod

CARRY, HEAVY = "sections carry", "sections no heavier"


def checked(a: Assembly, d: Dimensions, numbers: tuple[str, ...]) -> dict[str, CheckResult]:
    """Results of the spans of some parts, by name."""
    results = check_sections(a, [span for span in structure_spans(d) if span.part in numbers])
    for r in results:
        assert r.value is not None
        assert r.passed == (r.value >= 1.0 if r.name == CARRY else r.value <= 1.0)
    return {r.name: r for r in results}


def spoiled(a: Assembly, number: str, spoil: Callable[[cq.Shape], cq.Shape]) -> Assembly:
    """The machine with all parts of a number made wrong."""
    (sound,) = [p for p in a.parts if p.number == number]
    (solid,) = spoil(sound.solid).Solids()
    wrong = replace(sound, solid=solid)
    return replace(a, occurrences=tuple(replace(o, part=wrong) if o.part is sound else o for o in a.occurrences))


def test_the_machine_has_the_sections_that_its_structure_is_computed_with(
    best_assembly: Assembly, best_dimensions: Dimensions
) -> None:
    carry, heavy = check_sections(best_assembly, structure_spans(best_dimensions))
    assert carry.passed, carry.detail
    assert heavy.passed, heavy.detail
    assert {s.part for s in structure_spans(best_dimensions)} == {
        "upper_arm",
        "encoder_cheek",
        "motor_cheek",
        "motor",
        "shoulder_shaft",
        "rod_tube",
        "cross_bar",
        "platform",
        "handle_stem",
    }


THINNER: dict[str, tuple[str, Callable[[cq.Shape], cq.Shape]]] = {
    "half of an arm's height": ("upper_arm", lambda s: s.cut(box((40, -30, 0), (46, 30, 30)))),
    "a saw of 0.2 mm": ("upper_arm", lambda s: s.cut(box((50.0, -30, 3), (50.2, 30, 30)))),
    "a void": ("upper_arm", lambda s: s.cut(box((40, -2, -2), (42, 2, 2)))),
    "a tube sawn half through": ("rod_tube", lambda s: s.cut(box((60, -3, 0), (62, 3, 3)))),
    "a thinner wall": ("rod_tube", lambda s: s.cut(rod(2.0, (30, 0, 0), (90, 0, 0)))),
    "one web of three": ("platform", lambda s: s.cut(box((12, -3, -6), (14, 3, 6)))),
    "a waisted neck": ("cross_bar", lambda s: s.cut(box((-3, 22.0, 1.0), (3, 22.3, 3)))),
    "a cheek's leg": ("encoder_cheek", lambda s: s.cut(box((-30, -60, -60), (-5, 60, -59)))),
    # 32 mm are left of 53: (32 / 53)^3 of the plate's second moment, about half of what its bores leave
    "a motor's pad": ("motor_cheek", lambda s: s.cut(box((0, -60, -50), (90, 60, -49)))),
    "a shaft with a groove": ("shoulder_shaft", lambda s: s.cut(box((-9, 0, 3), (9, 1, 9)))),
    "a stem's stud": ("handle_stem", lambda s: s.cut(box((-9, -9, 15), (9, 0, 16)))),
}


@pytest.mark.parametrize("spoil", THINNER)
def test_what_is_thinner_is_refused(best_assembly: Assembly, best_dimensions: Dimensions, spoil: str) -> None:
    number, make = THINNER[spoil]
    result = checked(spoiled(best_assembly, number, make), best_dimensions, (number,))[CARRY]
    assert not result.passed
    assert result.worst_pair == (number,)
    assert number in result.detail


@pytest.mark.parametrize(
    ("number", "more"),
    [
        ("rod_tube", lambda s: s.fuse(rod(2.0, (30, 0, 0), (90, 0, 0)))),
        ("upper_arm", lambda s: s.fuse(box((40, -9, 0), (41, 0, 5)))),
        ("platform", lambda s: s.fuse(box((12, -9, -6), (14, 9, 6)))),
    ],
)
def test_what_is_heavier_is_refused(
    best_assembly: Assembly, best_dimensions: Dimensions, number: str, more: Callable[[cq.Shape], cq.Shape]
) -> None:
    result = checked(spoiled(best_assembly, number, more), best_dimensions, (number,))[HEAVY]
    assert not result.passed
    assert result.worst_pair == (number,)


def test_a_part_that_is_not_there_carries_nothing(best_assembly: Assembly, best_dimensions: Dimensions) -> None:
    bare = replace(
        best_assembly, occurrences=tuple(o for o in best_assembly.occurrences if o.part.number != "platform")
    )
    result = checked(bare, best_dimensions, ("platform", "rod_tube"))[CARRY]
    assert (result.passed, result.value) == (False, 0.0)


def test_sections_of_a_plate_with_filled_bores_are_those_of_the_plate() -> None:
    plain = box((0, -3, -10), (60, 3, 10))
    bored = plain.cut(
        rod(2, (20, -4, 4), (20, 4, 4)), rod(1.5, (-1, 1, 0), (61, 1, 0)), rod(3, (40, 0, -11), (40, 0, 0))
    )
    holes = (Hole(4.0, 1, ""), Hole(3.0, 1, ""), Hole(6.0, 1, ""))
    q = rectangle(6.0, 20.0)
    beam = Beam((BeamSlice(60.0, q, 7e4, 2.6e4),))
    span = Span("plate", "plate", np.eye(4), (0.0, 60.0), beam, 0.97, 1.03, filled=True)
    p = part("plate", bored, holes)
    stations = np.array([5.0, 19.0, 20.5, 30.0])  # across the first, and along the second
    cut = _cut(p, p.solid, span, stations)
    assert np.allclose(cut.filled, q.area_mm2, rtol=1e-9)
    assert np.allclose(cut.about_y, q.about_y_mm4, rtol=1e-9)
    assert np.allclose(cut.about_z, q.about_z_mm4, rtol=1e-9)
    assert np.allclose(cut.area[[0, 3]], 120.0 - np.pi * 1.5**2, rtol=1e-9)
    kept = _cut(p, p.solid, replace(span, filled=False), stations)
    assert (kept.filled[1:3] < 100.0).all()


def test_a_station_lies_in_every_cut_and_bore_however_narrow() -> None:
    solid = box((0, 0, 0), (50, 10, 10)).cut(box((20.0, 0, 5), (20.05, 10, 11))).cut(rod(0.2, (33, -1, 5), (33, 11, 5)))
    stations = _stations([solid], (0.0, 50.0))
    assert ((stations > 20.0) & (stations < 20.05)).any()
    assert (abs(stations - 33.0) < 0.2).any()
    assert len(stations) < 20


OWN_MOTOR = """\
id,diameter_mm,length_mm,shaft_diameter_mm,shaft_length_mm,pilot_diameter_mm,pilot_height_mm,mount_thread,\
mount_circle_mm,mount_count,mass_g,nominal_torque_N_m,rotor_inertia_kg_m2,torque_constant_N_m_A,resistance_ohm
servo-42,42,80,6,20,22,2,M3,30,4,480,0.14,9.5e-6,0.046,0.75
"""


def test_what_rounds_a_leg_into_its_head_is_not_the_legs(tmp_path: Path) -> None:
    """A narrow leg that runs into its head on both sides, whose corners a cutter leaves round: 5 % more."""
    (tmp_path / "motor.csv").write_text(OWN_MOTOR, encoding="utf-8")
    changes: dict[str, Any] = {
        "mechanism__base_radius_mm": 56.487,
        "mechanism__platform_radius_mm": 18.879,
        "mechanism__upper_arm_length_mm": 110.701,
        "mechanism__forearm_length_mm": 217.822,
        "mechanism__parallelogram_width_mm": 41.6,
        "cube__bottom_height_mm": 120.888,
        "cube__half_side_mm": 58.959,
        "hardware__motor": "servo-42",
        "hardware__capstan_ratio": 11.57,
        "hardware__sector_radius_mm": 70.0,
        "hardware__arm_thickness_mm": 5.0,
        "hardware__catalogue": tmp_path.name,
        "requirements__joint_torque_N_m": 1.555,
        "requirements__peak_torque_N_m": 1.555,
    }
    limits = (
        "stiffness_min_N_mm",
        "kappa_max",
        "lean_max_deg",
        "shoulder_min_deg",
        "shoulder_max_deg",
        "couple_index_min",
    )
    changes |= {f"requirements__{name}": None for name in limits}
    d = dimensions(design_from_dict(changed(**changes), folder=tmp_path.parent))
    cheek = make_encoder_cheek(d)
    (leg,) = (span for span in structure_spans(d) if (span.part, span.name) == ("encoder_cheek", "leg"))
    solid = cheek.solid.moved(_location(np.linalg.inv(leg.frame)))
    stations = _stations([solid], leg.reach_mm)
    shares = _cut(cheek, solid, leg, stations).area / [leg.assumed(x).area_mm2 for x in stations]
    assert 0.97 < shares.min() <= shares.max() < leg.most


def test_what_a_wide_neighbour_puts_next_to_a_web_is_not_the_webs() -> None:
    """Two bars that a bridge joins at their far end, 6 and 18 wide; the second lies over 60 degrees aside."""
    second, bridge = box((8, 22, -2), (30, 40, 2)), box((28, -3, -2), (30, 40, 2))
    pair = part("pair", box((0, -3, -2), (30, 3, 2)).fuse(second, bridge))
    bar = Beam((BeamSlice(30.0, rectangle(6.0, 4.0), 1.0, 1.0),))
    span = Span("pair", "web", np.eye(4), (9.0, 17.0), bar, 0.97, 1.03, own=(0.0, np.pi / 3))
    stations = _stations([pair.solid], span.reach_mm)
    assert _cut(pair, pair.solid, span, stations).area == pytest.approx(24.0)
    whole = replace(span, own=None)
    assert _cut(pair, pair.solid, whole, stations).area.max() == pytest.approx(24.0 + 18.0 * 4.0)


def test_of_a_web_that_is_one_with_its_neighbours_what_lies_in_its_sector_is_its_own() -> None:
    """A plate 60 wide with a window of 4: the middle of either side lies over 60 degrees aside."""
    plate = part("plate", box((0, -30, -2), (30, 30, 2)).cut(box((7, -2, -3), (31, 2, 3))))
    bar = Beam((BeamSlice(30.0, rectangle(6.0, 4.0), 1.0, 1.0),))
    span = Span("plate", "web", np.eye(4), (7.2, 8.8), bar, 0.7, np.inf, own=(0.0, np.pi / 3))
    stations = _stations([plate.solid], span.reach_mm)
    wide = 2.0 * (stations * np.sqrt(3.0) - 2.0)
    assert _cut(plate, plate.solid, span, stations).area == pytest.approx(4.0 * wide)


@pytest.mark.parametrize("name", ["motor faulhaber-3257g024cr", "motor maxon-re50-370354", "bearing 608"])
def test_no_section_of_a_machine_offered_is_below_nothing(name: str) -> None:
    """The key's slot of the Faulhaber's cheek is steep, and longer than the cheek is wide."""
    for span in structure_spans(dimensions(machine(offered()[name]))):
        for piece in span.bar.slices:
            one = piece.section
            assert min(one.area_mm2, one.about_y_mm4, one.about_z_mm4, one.torsion_mm4) > 0.0, span


@pytest.mark.parametrize(
    "other",
    [
        {"boss_length_mm": 18.0, "hub_radius_mm": 11.0},
        {"boss_length_mm": 77.0, "radius_mm": 41.7},
        {"boss_length_mm": 77.0, "radius_mm": 33.0},
        {"boss_length_mm": 95.0, "radius_mm": 42.34, "boss_diameter_mm": 11.5, "plate_mm": 6.5, "hub_radius_mm": 9.0},
    ],
    ids=[
        "narrower at its wrist than the hub",
        "beside wide neighbours",
        "within wide neighbours",
        "one with its neighbours on both sides of its window",
    ],
)
def test_a_web_of_any_width_is_as_it_is_counted(
    other: dict[str, float], best_dimensions: Dimensions, best_assembly: Assembly
) -> None:
    """Large machines: with narrow parallelograms under a thick stem, and with wide ones, whose webs run together."""
    d = replace(best_dimensions, platform=replace(best_dimensions.platform, **other))  # pyright: ignore[reportArgumentType]
    plate = make_platform(d)
    a = replace(
        best_assembly,
        occurrences=tuple(replace(o, part=plate) for o in best_assembly.occurrences if o.part.number == "platform"),
    )
    carry, heavy = checked(a, d, ("platform",)).values()
    assert carry.passed, carry.detail
    assert heavy.passed, heavy.detail
    half = 20.0  # all three sawn through alike, but for what is the neighbours'
    for turn in (0.0, 120.0, 240.0):
        saw = box((d.platform.hub_radius_mm + 2.0, -half, -9.0), (d.platform.hub_radius_mm + 2.2, half, 9.0))
        plate = replace(plate, solid=plate.solid.cut(saw.rotate((0, 0, 0), (0, 0, 1), turn)))
    a = replace(
        a, occurrences=tuple(replace(o, part=plate) if o.part.number == "platform" else o for o in a.occurrences)
    )
    assert not checked(a, d, ("platform",))[CARRY].passed
