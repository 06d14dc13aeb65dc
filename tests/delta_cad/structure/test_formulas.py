"""Sections, bars and bearings by textbooks, every load and allowable by hand: literal figures, no code of the project.

The derivation stands at each line. The machine is the one that the tests know: 688 bearings (8 x 16 x 5, C0 592 N), a
motor RE 30 (28 N at 5 mm, 68 mm long), sector 38.7 mm, pinion 8.0625 mm, spigot 2.8 x 8 mm, ball 6 mm on a pin of
2.5 mm, tube 5 x 3 of 120 GPa, cross-bar 8 mm. A sign, a factor or a lever that is off changes its line.
"""

from __future__ import annotations

from dataclasses import fields, replace
from functools import cache
from math import asin, atan2, ceil, degrees, hypot, pi, radians, sqrt

import numpy as np
import pytest

from delta_cad import catalogue
from delta_cad.structure import section, strength
from delta_cad.structure.beam import Beam, BeamSlice, flexibility, flexibility_by_kind, tapered
from delta_cad.structure.beam_model import beam_model, outline_width_mm
from delta_cad.structure.bearing import (
    BallBearing,
    approach_mm,
    axial_stiffness_N_mm,
    ball_bearing,
    dynamic_equivalent_N,
    life_hours,
    radial_stiffness_N_mm,
    static_equivalent_N,
)
from delta_cad.structure.loads import Load, PartLoads, loads, part_loads
from delta_cad.structure.modes import Moving, MovingBody
from delta_cad.structure.strength import Allowables, allowables, clamp_N_mm, stack_N_mm, tightening_N_m
from delta_cad.structure.unit_loads import unit_loads
from tests.delta_cad.structure.machines import committed, table
from tests.delta_cad.structure.test_loads import direct

E, G = 70e3, 27e3


@pytest.mark.parametrize(
    ("sides", "share"),
    [(1.0, 0.1406), (2.0, 0.229), (5.0, 0.291), (10.0, 0.312)],  # Timoshenko and Goodier, table of k1 in J = k1 a b^3
)
def test_a_rectangles_torsion_is_the_textbooks(sides: float, share: float) -> None:
    for b, h in ((3.0, 3.0 * sides), (3.0 * sides, 3.0)):
        assert section.rectangle_torsion_mm4(b, h) == pytest.approx(share * 3.0 * sides * 27.0, rel=0.005)


def test_sections_agree_where_they_meet() -> None:
    assert section.ring(10.0, 0.0).about_y_mm4 == section.circle(10.0).about_y_mm4


def test_two_ribs_are_a_frame() -> None:
    frame, plate = section.ribs(10.0, 3.0, 6.0, 1e9), section.rectangle(10.0, 3.0)
    assert frame.about_y_mm4 == plate.about_y_mm4
    assert frame.torsion_mm4 == pytest.approx(2 * section.rectangle_torsion_mm4(5.0, 3.0))  # a window without end
    window = section.ribs(10.0, 3.0, 6.0, 12.0)
    assert window.about_z_mm4 == pytest.approx(3.0 * (16.0**3 - 6.0**3) / 12.0)
    # one end turned by phi, the ribs clamped in both ends: the torque of two beams of 12 E I / l^3 each
    young, shear, turn = 2.6, 1.0, 1e-3
    force = 12 * young * (5.0 * 27.0 / 12.0) / 12.0**3 * turn * 11.0 / 2
    saint_venant = shear * 2 * section.rectangle_torsion_mm4(5.0, 3.0) * turn / 12.0
    assert shear * window.torsion_mm4 * turn / 12.0 == pytest.approx(force * 11.0 + saint_venant)
    # both shifted aside by d, besides the plate's own shear
    alone = 1.0 / (1.0 / window.shear_y_mm2 - 1.0 / (30.0 * 5 / 6))
    shift = 2 * 12 * young * (3.0 * 125.0 / 12.0) / 12.0**3
    assert shear * alone / 12.0 == pytest.approx(shift)


def test_a_cantilever_gives_as_the_formulas_say() -> None:
    s, length = section.rectangle(6.0, 10.0), 50.0
    c = flexibility(Beam((BeamSlice(length, s, E, G),)))
    shear = length / (G * s.shear_z_mm2)
    assert c[0, 0] == pytest.approx(length / (E * s.area_mm2))
    assert c[2, 2] == pytest.approx(length**3 / (3 * E * s.about_y_mm4) + shear)
    assert c[1, 1] == pytest.approx(length**3 / (3 * E * s.about_z_mm4) + shear)
    assert c[3, 3] == pytest.approx(length / (G * s.torsion_mm4))
    # a force up turns the tip about -y, a force along +y about +z
    assert c[4, 2] == pytest.approx(-(length**2) / (2 * E * s.about_y_mm4))
    assert c[5, 1] == pytest.approx(length**2 / (2 * E * s.about_z_mm4))
    np.testing.assert_allclose(c, c.T, atol=1e-18)


def test_slices_change_nothing_and_a_taper_converges() -> None:
    s = section.circle(5.0)
    one = flexibility(Beam((BeamSlice(30.0, s, E, G),)))
    np.testing.assert_allclose(flexibility(Beam(tapered(0.0, 30.0, lambda _: s, E, G))), one, rtol=1e-12, atol=1e-18)
    # a plate b wide whose height falls linearly to nothing at a force: u = 6 F L^3 / (E b h^3), closed form
    # of a triangular profile in plan: constant thickness t, width w at the root to 0: L^3 / (2 E I_root)
    wedge = tapered(0.0, 60.0, lambda x: section.rectangle(20.0 * (1 - x / 60.0), 3.0), E, 1e12)
    expected = 60.0**3 / (2 * E * 20.0 * 27.0 / 12.0)
    assert flexibility(Beam(wedge))[2, 2] == pytest.approx(expected, rel=1e-3)


def test_kinds_add_up_and_the_factor_counts() -> None:
    bar = Beam((BeamSlice(20.0, section.rectangle(10.0, 12.0), E, G),), factor=1.4)
    kinds = flexibility_by_kind(bar)
    np.testing.assert_allclose(kinds.sum(axis=0), flexibility(bar))
    np.testing.assert_allclose(flexibility(bar), 1.4 * flexibility(Beam(bar.slices)))
    assert kinds[3, 3, 3] == flexibility(bar)[3, 3]


def test_a_hull_is_as_wide_as_its_tangents() -> None:
    circles = [(0.0, 0.0, 5.0), (0.0, -20.0, 10.0)]
    assert outline_width_mm(circles, -10.0) == pytest.approx(
        15.0 / sqrt(1 - 0.25**2), rel=1e-3
    )  # directions by 0.25 deg
    assert outline_width_mm(circles, -20.0) == pytest.approx(20.0, rel=1e-5)
    square = [(x, z, 0.0) for x in (-3.0, 3.0) for z in (-1.0, 1.0)]
    assert outline_width_mm(square, 0.2) == pytest.approx(6.0, rel=1e-5)


def test_the_balls_of_known_bearings() -> None:
    row = catalogue.bearing("688")
    assert ball_bearing(row) == BallBearing(2.0, 9, row.static_load_N, row.dynamic_load_N)
    large = ball_bearing(catalogue.bearing("608"))  # 7 balls of 3.97 mm
    assert large.balls in (6, 7)
    assert large.ball_mm == pytest.approx(3.97, rel=0.12)


def test_bearings_give_as_palmgren_says() -> None:
    bearing = BallBearing(2.0, 10, 550.0, 1330.0)
    assert approach_mm(15.0, 2.0) == pytest.approx(4.36e-4 * 112.5 ** (1 / 3))
    for load, expected in ((1.0, 7e3), (30.0, 21e3)):  # a study's 7 and 21 kN/mm
        slope = radial_stiffness_N_mm(bearing, load)
        step = 1e-4 * load
        moved = approach_mm(5 * (load + step) / 10, 2.0) - approach_mm(5 * (load - step) / 10, 2.0)
        assert slope == pytest.approx(2 * step / moved, rel=1e-6)
        assert slope == pytest.approx(expected, rel=0.03)
    assert axial_stiffness_N_mm(bearing, 10.0) == pytest.approx(2.3e3, rel=0.03)


def test_a_bearings_life_is_that_of_its_turns() -> None:
    bearing = BallBearing(2.0, 10, 550.0, 1000.0)
    # a tenth of C: 1e9 turns; a stroke of half a turn, there and back once a second: a turn a second
    assert life_hours(bearing, 100.0, pi, 1.0) == pytest.approx(1e9 / 3600.0)
    assert life_hours(bearing, 200.0, pi, 1.0) == pytest.approx(1e9 / 8 / 3600.0)
    assert life_hours(bearing, 100.0, pi / 2, 2.0) == pytest.approx(1e9 / 3600.0)
    assert static_equivalent_N(10.0, 1.0) == 10.0
    assert static_equivalent_N(10.0, 20.0) == 16.0
    assert dynamic_equivalent_N(10.0, 0.0) == 10.0
    assert dynamic_equivalent_N(10.0, 10.0) == pytest.approx(28.6)


def test_a_stepped_plate_lies_between_its_thick_and_its_thin_one() -> None:
    thick, thin = section.rectangle(7.0, 42.0), section.rectangle(3.75, 42.0)
    some = section.stepped_plate(7.0, 42.0, 3.25, 33.0)
    assert thin.about_z_mm4 < some.about_z_mm4 < thick.about_z_mm4
    assert some.about_z_mm4 == pytest.approx((9.0 * 7.0**3 + 33.0 * 3.75**3) / 12.0)
    assert some.area_mm2 == pytest.approx(9.0 * 7.0 + 33.0 * 3.75)
    assert section.stepped_plate(7.0, 42.0, 3.25, 0.0).about_z_mm4 == pytest.approx(thick.about_z_mm4)
    assert section.stepped_plate(7.0, 42.0, 3.25, 42.0).about_z_mm4 == pytest.approx(thin.about_z_mm4)


CENTRE = np.array([[0.0, 0.0, 107.535]])  # on the axis, where no rod leans along its shoulder's axis
ACROSS = radians(30.0)  # of the strands, a round figure in place of the machine's
CARRIED = {
    "rod": 6.0,
    "axial": 8.0,
    "cable": 12.0,
    "hub": 400.0,
    "elbow": 600.0,
    "elbow_along": 5.0,
    "torque": 500.0,
}
RADIAL = 30.0, 20.0
# (14 + 26) sin(psi) = 40 x 0.5 N, and with the difference 12 cos(psi) square to it
STRANDS, ON_SHAFT = 20.0, sqrt(20.0**2 + 108.0)


def bearing_share(name: str) -> float:
    """The radial load grows by the strands: 50 and 40 N beside 8 N along the axis."""
    static = max(50.0, 0.6 * 50.0 + 0.5 * 8.0)  # ISO 76
    dynamic = max(50.0, 0.56 * 50.0 + 2.3 * 8.0)  # ISO 281, its largest Y
    # two radians there and back, half a time a second: 2 x 2 / 2 pi x 0.5 turns a second
    life = 1e6 * (1252.0 / dynamic) ** 3 / (2.0 / pi * 0.5) / 3600.0
    return {"static": static, "life": life}[name]


LOADS = {
    "rod buckling": 6.0,
    # 1.05 times the load points atan(6.3 / 8.38246) off the cup's axis; half the contact of a thin layer,
    # 4 F / (pi K R^2 c), c the least clearance 0.005, which is less than Hertz's
    "ball joint": degrees(
        atan2(6.3, 8.38246) + (4.0 * hypot(6.3, 8.38246) / (pi * 14711.934156378598 * 3.0**2 * 0.005)) ** 0.25
    ),
    # Hertz, (6 P E^2 / (pi^3 R^2))^(1/3): preload at the largest lean and the rod's force, R = 3 x 3.01 / 0.01
    "cup shell": (6.0 * (8.428868977 + 6.0) * 6107.839054**2 / (pi**3 * 903.0**2)) ** (1.0 / 3.0),
    "rod end bending": 32.0 * 8.428868977 * 7.6 / (pi * 2.8**3) + 4.0 * 6.0 / (pi * 2.8**2),
    "rod bond, tilt": hypot(6.0 * 8.428868977 * 7.6 / (2.8 * 8.0**2), 6.0 / (pi * 2.8 * 8.0)),
    "rod bond": 6.0 / 50.0,
    "stud": 6.0 * 0.5,
    "shoulder seat": 400.0,
    "cross-bar bond": 600.0 * 0.01 + 5.0 / 100.0,
    "motor shaft": ON_SHAFT,
    # lever 15 over an edge 12 on two screws, and 0.25 of the strands' difference each
    "motor screw": ON_SHAFT * 15.0 / (2 * 12.0) + 12.0 * 0.25,
    "pinion's set screws": 12.0,
    "cable": 14.0 + 12.0,
    "cable's slip": 12.0 * 30.0 / 20.0,  # 20 of the 30 N that are proved are held there
    "sector dowel": 500.0 / (7.5 * 2),
    "shoulder bearing": bearing_share("static"),
    "shoulder preload": 8.0,
    "shoulder bearing life": bearing_share("life"),
    # moment of 50 N at 90 mm on two dowels 30 mm apart, and half of the 50 N itself
    "cheek dowel": 50.0 * 90.0 / 30.0 + 25.0,
    "cheek screw": 8.0 * 90.0 / (2 * 7.0),  # two screws
    "base screw": (30.0 + 20.0) * 100.0 / (2 * 20.0),  # both bearings, two screws
}


class Held:
    """A setting that leaves 14 N in every slack strand, and holds two thirds of the 30 N that are proved."""

    proven_N = 30.0

    def held_N(self, turned_rad: np.ndarray) -> np.ndarray:
        return np.full_like(turned_rad, 20.0)

    def strands_N(self, turned_rad: np.ndarray, difference_N: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return np.full_like(turned_rad, 14.0), 14.0 + difference_N


LIMITS = {
    "bond_mm2": 50.0,
    "stud_1_mm2": 0.5,
    "bar_1_mm3": 0.01,
    "bar_mm2": 100.0,
    "motor_mm": 15.0,
    "motor_edge_mm": 12.0,
    "motor_slip": 0.25,
    "motor_screws": 2,
    "setting": Held(),
    "sector_mm": 7.5,
    "sector_pins": 2,
    "stroke_rad": 2.0,
    "foot_mm": 90.0,
    "foot_pins_mm": 30.0,
    "foot_edge_mm": 7.0,
    "base_mm": 100.0,
    "base_edge_mm": 20.0,
}


def given(chain: int = 1) -> PartLoads:
    """Loads of one chain; the others bear nothing."""
    place = np.zeros((1, 3))
    place[0, chain] = 1.0
    return PartLoads(radial=place[..., None] * RADIAL, **{name: value * place for name, value in CARRIED.items()})


@cache
def found() -> dict[str, Load]:
    machine = beam_model(committed())
    assert machine.cable is not None
    machine = replace(machine, cable=replace(machine.cable, across_rad=ACROSS))
    limits = replace(allowables(committed()), **LIMITS)  # type: ignore[arg-type]
    return {load.name: load for load in loads(machine, limits, CENTRE, given())}


def test_every_load_has_its_number() -> None:
    assert found().keys() == {*LOADS, "ball joint preload"}


@pytest.mark.parametrize("name", LOADS)
def test_a_load_by_hand(name: str) -> None:
    load = found()[name]
    assert load.value == pytest.approx(LOADS[name], rel=1e-7)
    assert load.chain == 1


def test_the_preload_left_is_what_the_load_does_not_need() -> None:
    """With so much less the contact just reaches the lip, 86 deg: where the load points, and half of the contact."""
    left = found()["ball joint preload"].value
    needed = 8.38246 - left
    load = hypot(6.3, needed)
    hertz = (3.0 * load * (3.0 * 3.005 / 0.005) / (4.0 * 6107.839054)) ** (1.0 / 3.0) / 3.0
    thin = (4.0 * load / (pi * 14711.934156 * 3.0**2 * 0.005)) ** 0.25
    assert degrees(atan2(6.3, needed) + min(asin(hertz), thin)) == pytest.approx(86.0, abs=1e-3)


def test_a_motors_shaft_that_carries_the_arm_bends_by_tilt_and_load() -> None:
    """32 M / (pi d^3) of 400 N mm and 30 N at 12 mm, a shaft of 8 mm."""
    machine = replace(beam_model(committed()), cable=None)
    limits = replace(allowables(committed()), bearing=None, stub_mm=8.0, stub_lever_mm=12.0)
    (load,) = [one for one in loads(machine, limits, CENTRE, given()) if one.name == "motor shaft bending"]
    assert load.value == pytest.approx(32.0 * (400.0 + 30.0 * 12.0) / (pi * 8.0**3))
    assert load.chain == 1


SOCKET = sqrt(sqrt(3.0) / 2.0 * 2.0**2 / pi)  # radius of the circle that is as large as a socket of 2 mm, 1.05
LOW_M3 = 0.7 * 450.0 * pi * (1.5 + SOCKET) * ((1.5 - SOCKET) ** 2 + 0.25) / sqrt((1.5 - SOCKET) ** 2 + 0.75)  # its cone
SCREW_M3, SCREW_M4 = (0.7 * 450.0 * pi / 4.0 * (d - 0.9382 * p) ** 2 for d, p in ((3.0, 0.5), (4.0, 0.7)))
# The cups at the elbows reach so far behind the base's centre: R and arm at 60 deg to it, half the rods' width, a cup.
BEHIND_MM = (31.0 + 91.0) / 2.0 + sqrt(3.0) / 2.0 * 54.0 / 2.0 + 4.7075
# A motor's rear corner, 17.4 + 68 mm along a chain's side and 15 mm beyond the axis, ends there, too: the axis lies so
# far out, and so far below the shoulder, axes 47.7625 mm apart.
OUT_MM = (BEHIND_MM - sqrt(3.0) / 2.0 * (17.4 + 68.0)) * 2.0 - 15.0
BELOW_MM = sqrt((38.7 + 8.0625 + 1.0) ** 2 - (31.0 - OUT_MM) ** 2)
BASE_MM = ceil(10.0 * (BELOW_MM + 0.8 * 52.0)) / 10.0  # a key of 2 mm swings: four fifths of its leg of 52; in tenths
ALLOWED = {
    "stroke_rad": 0.9407281942551619 + 1.0471794095116191,
    "preload_N": 9.7 - 9.75 * (5 * 0.02 + 2 * 0.12),  # the highest stack takes this of the spring
    # rated at 5 mm, loaded at 17.4 - 8.9 mm, bearings 0.7 x 68 mm apart
    "motor_N": 28.0 * (47.6 + 5.0) / (47.6 + 8.5),
    "stub_lever_mm": 17.4,  # head of 2 and screw of 5 mm end 0.1 before the turns: 8.9 + 1.05 + 0.27, in tenths
    "stub_N_mm2": 370.0,
    "peak_share": (0.085 * 4.8 * 0.96 / 0.8) ** 2,  # of the losses at 0.8 N m
    "middle_rad": (0.9407281942551619 - 1.0471794095116191) / 2.0,
    "cable_N": 157.0 / 3.15,
    "stud_1_mm2": 32.0
    * sqrt(3.0**2 - 1.25**2)
    / (pi * 2.5**3),  # the pin's, 1.778; the neck's is 32 x 6.8 / (pi 3.4^3)
    "stud_N_mm2": 480.0,
    "preload_reserve_N": 0.1 * 8.38246,
    "end_N_mm2": 250.0 / 2.0,
    "plastic_N_mm2": 80.0 / 4.0,
    "tilt_N_mm2": 16.3 / 4.0,
    "bond_mm2": pi * 2.8 * 8.0,
    "bond_N_mm2": 2.0,
    "buckling_N": pi**2 * 120e3 * pi / 64.0 * (5.0**4 - 3.0**4) / 143.196**2 / 3.0,
    "hub_N_mm": SCREW_M4 * (10.0**2 + 8.0**2) / (8.0 * 10.0),  # (Ro^2 + Ri^2) / (4 Ro) of the diameters
    "bar_1_mm3": 6.0 / (8.0 * 16.0**2),  # the elbow's boss, 16 mm, is shorter than the platform's
    "bar_mm2": pi * 8.0 * 16.0,
    "bar_N_mm2": 6.0,
    "sector_mm": 7.5,
    "sector_pins": 2,
    "sector_N": 125.0 * 3.0 * 3.0,  # a pin of 3 mm in the sector's web of 3 mm
    "foot_mm": BASE_MM - 14.0 / 2.0,  # 79.7: in the middle of a block of 14 mm
    "foot_pins_mm": 60.8 - 27.8,
    "foot_pin_N": 125.0 * 3.0 * 5.0,  # 5 mm of the pin are in a cheek of 6 mm
    "foot_edge_mm": 14.0 / 2.0,
    "foot_screw_N": SCREW_M3,
    "motor_mm": 17.4 - 8.9,
    "motor_edge_mm": 15.0 - 11.0 / 5.0,  # five of six holes: their middle lies a fifth of the radius off
    "motor_slip": 8.0625 / (0.12 * 11.0 * 5),
    "motor_screws": 5,
    "motor_screw_N": LOW_M3,
    "base_mm": BASE_MM,  # 86.7
    "base_edge_mm": (65.3 - 23.3) / 2.0,
    "base_screw_N": SCREW_M4,
}
ELSEWHERE = {
    "bearing",
    "stub_mm",
    "forearm",
    "pinion_N",
    "setting",
    *("arm_1_mm3", "arm_N_mm2", "grip_N_mm", "spoke_1_mm3", "spoke_N_mm2"),
}  # not a formula, none here, or by hand in test_loads.py or test_printed.py


def test_every_allowable_has_its_number() -> None:
    assert {field.name for field in fields(Allowables)} - ELSEWHERE == ALLOWED.keys()


@pytest.mark.parametrize("name", ALLOWED)
def test_an_allowable_by_hand(name: str) -> None:
    assert getattr(allowables(committed()), name) == pytest.approx(ALLOWED[name], rel=1e-9)


def test_a_direct_drives_own_limits_by_hand() -> None:
    d, found = direct(), allowables(direct())
    assert found.stub_mm == d.motor.shaft_diameter_mm
    assert found.hub_N_mm == pytest.approx(SCREW_M3 * 10.0 / 6.0)  # an even pressure of a rectangle opens at b / 6
    assert found.preload_N == 0.0
    assert found.motor_slip == 0.0
    # RE 30's 28 N at 5 mm by the area of a shaft of 6 mm, where a motor's row states none
    unrated = replace(d, motor=replace(d.motor, max_radial_load_N=None, shaft_diameter_mm=3.0))
    span, at = 0.7 * d.motor.length_mm, d.layers.motor_face_mm
    assert allowables(unrated).motor_N == pytest.approx(28.0 / 4.0 * (span + 5.0) / (span + at))


def test_screws_and_clamps_by_hand() -> None:
    # M4 x 0.7: d2 3.5454, head 7 in a hole of 4.5: F (0.159 P + 0.14 (0.577 d2 + (7 + 4.5) / 4))
    lever = 0.159 * 0.7 + 0.14 * (0.577 * (4.0 - 0.6495 * 0.7) + (7.0 + 4.5) / 4.0)
    assert tightening_N_m(catalogue.screw("M4")) == pytest.approx(SCREW_M4 * lever / 1e3)
    assert clamp_N_mm("M3", 12.0) == pytest.approx(SCREW_M3 * 2.0)
    assert stack_N_mm("M3", 10.0, 6.0) == pytest.approx(SCREW_M3 * (25.0 + 9.0) / 20.0)
    assert pytest.approx(1584.7, abs=0.1) == SCREW_M3
    assert strength.LIFE_HOURS == 10_000.0


def test_a_weight_in_the_middle_is_shared_by_six_rods() -> None:
    """Platform 60 g and the lower halves of six rods of 6 g: each rod bears a sixth over the cosine of its slope."""
    machine = table()
    what = Moving(
        MovingBody(0.060, np.array([0.0, 0.0, 8.0]), np.eye(3)),
        MovingBody(0.0, np.zeros(3), np.eye(3)),
        (2e-3, 1e-3, 2e-3),
    )
    given = part_loads(machine, what, CENTRE, 0.0, np.array([0.0, 0.0, -9.81]))
    slope = unit_loads(machine, CENTRE).along[0, :, 2]
    np.testing.assert_allclose(given.rod[0], 9.81 * (0.060 + 3 * 0.006) / 6.0 / slope, rtol=1e-9)
    # an elbow bears a third of it and the upper halves of two rods; the rods push it outwards or inwards, too
    third, rods = 9.81 * (0.060 + 3 * 0.006) / 3.0, 9.81 * 0.006
    along, (cosine, sine) = unit_loads(machine, CENTRE).along[0, 0], unit_loads(machine, CENTRE).turned[0, 0]
    expected = (third + rods) * 91.0 * cosine - third * along[0] / along[2] * 91.0 * sine
    np.testing.assert_allclose(given.torque[0], abs(expected), rtol=1e-9)
    np.testing.assert_allclose(given.elbow_along[0], 0.0, atol=1e-9)
