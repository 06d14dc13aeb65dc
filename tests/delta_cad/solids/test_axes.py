"""Axes and hole patterns measured on the solids: link lengths, coaxial seats, and every fastener in its bores."""

# pyright: reportAttributeAccessIssue=false
# The stubs of the kernel's binding declare none of its classes.

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest
from OCP.BRepAdaptor import BRepAdaptor_Surface
from OCP.GeomAbs import GeomAbs_Cylinder
from OCP.TopAbs import TopAbs_REVERSED

from delta_cad import catalogue
from delta_cad.assembly.machine import Assembly
from delta_cad.checks.solidity import bore_counts, compared_bores, slot_count
from delta_cad.dimensions import Dimensions, dimensions
from delta_cad.solids.brackets import make_motor_cheek
from delta_cad.solids.part import Part
from delta_cad.solids.primitive import bore_y, box, cut
from tests.delta_cad.solids.measured import (
    EXACT_MM,
    axis_distance,
    cylinders,
    occurrence,
    one_axis,
    part,
    placed,
    spheres,
)

AXIS_MM = 1e-6  # the kernel's own tolerance of coincidence is 1e-7


def test_every_part_is_one_valid_solid_with_its_declared_bores(best_assembly: Assembly) -> None:
    for p in best_assembly.parts:
        assert p.solid.ShapeType() == "Solid", p.number
        assert p.solid.isValid(), p.number
        faults, undeclared = compared_bores(p, bore_counts(p.solid))
        assert not faults, p.number
        if p.make and p.number != "sector":  # the underside of its rim is concave, too
            assert not undeclared, p.number


def test_a_wrong_hole_pattern_is_seen(best_assembly: Assembly, best_dimensions: Dimensions) -> None:
    """One bore more, one bore less (its declaration kept), one of another diameter."""
    cheek = part(best_assembly, "motor_cheek")
    x = best_dimensions.bracket.foot_u_mm[1] - best_dimensions.bracket.shoulder_u_mm - 12.0
    z = best_dimensions.bracket.cheek_screw_z_mm + 19.0  # in the middle of the plate, between foot and seat
    drilled = replace(cheek, solid=cut(cheek.solid, [bore_y(3.4, (x, z), (-50.0, 50.0))]).Solids()[0])
    assert compared_bores(drilled, bore_counts(drilled.solid))[0] == ["it has 8 bores of 3.4 mm, 7 are declared"]
    plate = part(best_assembly, "base_plate")
    for hole in plate.holes:
        fewer = tuple(replace(h, count=h.count + (h is hole)) for h in plate.holes)
        assert compared_bores(replace(plate, holes=fewer), bore_counts(plate.solid))[0]


def test_upper_arm_carries_its_axes_at_its_length(best_assembly: Assembly, best_dimensions: Dimensions) -> None:
    solid = part(best_assembly, "upper_arm").solid
    shaft = one_axis(solid, best_dimensions.arm.shaft_bore_mm, concave=True)
    bar = one_axis(solid, 8.04, concave=True)
    distance, sine = axis_distance(shaft, bar)
    assert distance == pytest.approx(best_dimensions.design.mechanism.upper_arm_length_mm, abs=AXIS_MM)
    assert sine < 1e-12
    np.testing.assert_allclose(np.abs(shaft[1]), [0, 1, 0], atol=1e-12)
    np.testing.assert_allclose(shaft[0], 0, atol=AXIS_MM)


def test_a_rod_s_tube_fills_the_room_between_the_cups(best_assembly: Assembly) -> None:
    """The tube's ends touch both cups' shoulders: what is cut by the drawing gives the seat distance in the jig."""
    tube = placed(part(best_assembly, "rod_tube").solid, occurrence(best_assembly, "rod_tube_0_0").placement)
    for end in ("elbow", "wrist"):
        o = occurrence(best_assembly, f"rod_cup_0_0_{end}")
        cup = placed(o.part.solid, o.placement)
        assert cup.distance(tube) < 1e-7
        assert cup.intersect(tube).Volume() < 1e-6


def test_platform_holds_its_wrists_at_its_radius(best_assembly: Assembly, best_dimensions: Dimensions) -> None:
    solid, m = part(best_assembly, "platform").solid, best_dimensions.design.mechanism
    bars = cylinders(solid, best_dimensions.platform.bar_bore_mm, concave=True)
    assert len(bars) == 3
    angles = []
    for point, direction in bars:
        assert np.hypot(point[0], point[1]) == pytest.approx(m.platform_radius_mm, abs=AXIS_MM)
        assert abs(point[2]) < EXACT_MM
        assert abs(direction @ point) < AXIS_MM  # tangential
        assert abs(direction[2]) < 1e-12
        angles.append(np.degrees(np.arctan2(point[1], point[0])) % 360)
    np.testing.assert_allclose(sorted(round(a, 9) % 360 for a in angles), [0, 120, 240], atol=1e-7)


@dataclass(frozen=True)
class Bore:
    """A concave cylinder: point and direction of its axis, extent along the direction from the point."""

    diameter: float
    point: np.ndarray
    direction: np.ndarray
    extent: tuple[float, float]


def bores(p: Part, frame: np.ndarray) -> list[Bore]:
    found = []
    for face in placed(p.solid, frame).Faces():
        surface = BRepAdaptor_Surface(face.wrapped)
        if surface.GetType() != GeomAbs_Cylinder:
            continue
        c = surface.Cylinder()
        if c.Position().Direct() != (face.wrapped.Orientation() == TopAbs_REVERSED):
            continue
        a, q = c.Axis().Direction(), c.Axis().Location()
        extent = (surface.FirstVParameter(), surface.LastVParameter())
        found.append(Bore(2 * c.Radius(), np.array([q.X(), q.Y(), q.Z()]), np.array([a.X(), a.Y(), a.Z()]), extent))
    return found


def engaged(bore: Bore, origin: np.ndarray, axis: np.ndarray, shank: tuple[float, float]) -> float:
    """Length of a fastener's shank inside a bore that is coaxial with it; 0 when it is not."""
    if np.linalg.norm(np.cross(bore.direction, axis)) > 1e-9:
        return 0.0
    if np.linalg.norm(np.cross(bore.point - origin, axis)) > AXIS_MM:
        return 0.0
    start, sense = float((bore.point - origin) @ axis), float(bore.direction @ axis)
    ends = sorted(start + sense * v for v in bore.extent)
    return max(0.0, min(ends[1], shank[1]) - max(ends[0], shank[0]))


M25, M3, M4 = (catalogue.screw(size) for size in ("M2.5", "M3", "M4"))
SHANKS: dict[str, list[tuple[str, float, float]]] = {
    # fastener -> part it goes through, bore, least length in it: a thread bears on most of one diameter
    "cheek_screw": [("foot_block", M3.tap_drill_mm, 3.0), ("_cheek", M3.clearance_hole_mm, 5.9)],
    "cheek_dowel": [("foot_block", 3.0, 3.0), ("_cheek", 3.0, 3.0)],
    "base_screw": [("foot_block", M4.tap_drill_mm, 4.0), ("base_plate", M4.clearance_hole_mm, 3.5)],
    "base_dowel": [("foot_block", 3.0, 3.0), ("base_plate", 3.0, 3.0)],
    "stop_pin": [("motor_cheek", 4.0, 4.0)],
    "motor_screw": [("motor", M3.tap_drill_mm, 2.5), ("motor_cheek", M3.clearance_hole_mm, 1.49)],
    "board_screw": [("encoder_cheek", M25.tap_drill_mm, 2.5), ("encoder_board", 2.9, 1.5), ("board_spacer", 2.7, 4.9)],
    "shoulder_screw": [("shoulder_shaft", M4.tap_drill_mm, 4.0), ("shoulder_washer", 4.3, 1.4)],
    "set_screw": [("pinion", M3.tap_drill_mm, 2.0)],
    "sector_dowel": [("sector", 3.0, 3.0), ("upper_arm", 3.0, 3.0)],
    "tension_screw": [("tension_carriage", M3.tap_drill_mm, 3.0), ("sector", M3.clearance_hole_mm, 2.9)],
}


SLOTTED = ("_m1", "base_dowel_0_1", "base_dowel_1_1", "base_dowel_2_1")
"""Second dowels of foot blocks, which have a slot for them."""
FASTENERS = ("screw_", "set_screw_", "tension_screw_", "dowel_")


def test_every_fastener_sits_in_the_bores_of_all_parts_it_joins(best_assembly: Assembly) -> None:
    """Mating patterns agree between parts, and each thread holds; a pattern that is wrong in one part breaks it."""
    cache = {
        o.name: bores(o.part, o.placement) for o in best_assembly.occurrences if not o.part.number.startswith(FASTENERS)
    }
    seen: dict[str, int] = {}
    for o in best_assembly.occurrences:
        kind = next((k for k in SHANKS if o.name.startswith(k + "_") and "block" not in o.name), None)
        if kind is None:
            assert not o.part.number.startswith(FASTENERS), f"{o.name} is not covered by this test"
            continue
        seen[kind] = seen.get(kind, 0) + 1
        box = o.part.solid.BoundingBox()
        dowel = o.part.number.startswith("dowel_")
        shank = (box.zmin, box.zmax if dowel else 0.0)
        for number, diameter, least in SHANKS[kind]:
            lengths = [
                engaged(bore, o.placement[:3, 3], o.placement[:3, 2], shank)
                for other in best_assembly.occurrences
                if other.link == o.link and number in other.part.number and other.name in cache
                for bore in cache[other.name]
                if abs(bore.diameter - diameter) < 1e-6
            ]
            if number == "foot_block" and dowel and o.name.endswith(SLOTTED):
                assert not any(lengths)  # it stands in a slot, see test_brackets.py
                continue
            assert max(lengths) >= least, f"{o.name} in {number}: {max(lengths):.3f} mm of {diameter:g}"
    assert seen == {
        "cheek_screw": 12,
        "cheek_dowel": 12,
        "base_screw": 6,
        "base_dowel": 6,
        "stop_pin": 3,
        "motor_screw": 15,  # one hole of six is behind the sector
        "board_screw": 12,
        "shoulder_screw": 3,
        "sector_dowel": 6,
        "set_screw": 6,
        "tension_screw": 3,
    }


@pytest.mark.parametrize("end", ["elbow", "wrist"])
def test_balls_are_bonded_on_the_studs_of_their_bar(
    best_assembly: Assembly, best_dimensions: Dimensions, end: str
) -> None:
    """Each pin reaches past the ball's centre, and the shoulder of the stud stands on the rim of the ball's hole."""
    f = best_dimensions.forearm
    for i in range(3):
        bar = occurrence(best_assembly, f"cross_bar_{i}_{end}")
        solid = placed(bar.part.solid, bar.placement)
        for j in range(2):
            o = occurrence(best_assembly, f"joint_ball_{i}_{j}_{end}")
            assert o.link == bar.link
            ball = placed(o.part.solid, o.placement)
            (centre,) = spheres(ball, f.ball_diameter_mm)
            hole = one_axis(ball, f.pin_diameter_mm + 0.05, concave=True)
            pin = one_axis(solid, f.pin_diameter_mm, concave=False)
            assert max(axis_distance(hole, pin)) < AXIS_MM
            assert solid.intersect(ball).Volume() < 1e-6
            assert solid.distance(ball) < AXIS_MM
            along = (centre - bar.placement[:3, 3]) @ bar.placement[:3, 1]
            reach = bar.part.solid.BoundingBox().ymax
            assert reach - abs(along) == pytest.approx(0.1 * f.ball_diameter_mm, abs=AXIS_MM)


def test_the_handle_stem_is_screwed_into_platform_and_knob(
    best_assembly: Assembly, best_dimensions: Dimensions
) -> None:
    drill = catalogue.screw(best_dimensions.knob.thread).tap_drill_mm
    stem = occurrence(best_assembly, "handle_stem")
    box = stem.part.solid.BoundingBox()
    for name in ("platform", "knob"):
        holder = occurrence(best_assembly, name)
        inside = [
            engaged(b, stem.placement[:3, 3], stem.placement[:3, 2], (box.zmin, box.zmax))
            for b in bores(holder.part, holder.placement)
            if abs(b.diameter - drill) < 1e-6
        ]
        assert max(inside) >= 6.0  # one diameter of the M6 thread


def test_a_slot_is_counted_by_its_two_sides(best_dimensions: Dimensions, monkeypatch: pytest.MonkeyPatch) -> None:
    """The key's slot of a motor's cheek, and one that is milled beside it; one filled up is missed.

    A motor with a shorter shaft has its pinion's collar in its cheek, so that the key needs a slot. The motor then
    stands farther along the axis; chains 2 mm farther out give the encoder's leg beside it its room.
    """
    m = best_dimensions.design.mechanism
    out = {name: getattr(m, name) + 2.0 for name in ("base_radius_mm", "platform_radius_mm")}
    design = best_dimensions.design.model_copy(update={"mechanism": m.model_copy(update=out)})
    rows, key = catalogue.motor.rows, best_dimensions.motor.id
    monkeypatch.setitem(catalogue.motor.__dict__, "rows", {**rows, key: replace(rows[key], shaft_length_mm=12.0)})
    cheek = make_motor_cheek(dimensions(design))
    (slot,) = [hole for hole in cheek.holes if hole.is_slot]
    assert compared_bores(cheek, bore_counts(cheek.solid))[0] == []
    assert slot_count(cheek.solid, slot.diameter_mm) == 1
    second = cut(cheek.solid, [box((8.0, 13.0, -70.0), (8.0 + slot.diameter_mm, 15.3, -62.0))])
    assert slot_count(second, slot.diameter_mm) == 2
    filled = replace(slot, diameter_mm=slot.diameter_mm - 0.2)
    faults = compared_bores(replace(cheek, holes=(filled,)), bore_counts(cheek.solid))[0]
    assert faults == [f"it has 0 slots {filled.diameter_mm:g} mm wide, 1 are declared"]
