"""Volume of every turned, sawn and drilled part against its closed form, written from the drawing."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import acos, ceil, cos, hypot, pi, radians, sin, sqrt, tan

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.spatial import ConvexHull

from delta_cad import catalogue
from delta_cad.assembly.machine import Assembly
from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.layers import motor_thread_mm
from delta_cad.dimensions.platform import base_dimensions
from delta_cad.solids.base_plate import make_base_plate
from delta_cad.solids.bought_parts import make_foot
from delta_cad.solids.part import Part

KERNEL = 1e-9  # relative; the kernel integrates planes, cylinders and spheres to rounding
CROSSED = 2e-5  # relative; the kernel draws the curves in which round bores cross as splines
ARCS = 1e-5  # relative; a helix in arcs of half a radian, each in a plane


def cyl(diameter: float, length: float) -> float:
    return pi / 4 * diameter**2 * length


def broken(diameter: float, leg: float) -> float:
    """Ring that a 45 degree edge break takes off a cylinder (Pappus: leg^2 / 2 around its centroid)."""
    return pi * leg**2 * (diameter / 2 - leg / 3)


def tip(diameter: float) -> float:
    """What a drill with a point of 118 degrees takes beyond its full diameter."""
    return pi / 12 * diameter**2 * (diameter / 2 / tan(radians(59.0)))


def cap(radius: float, height: float) -> float:
    return pi * height**2 * (3 * radius - height) / 3


def segment(radius: float, distance: float) -> float:
    """Area of a disc beyond a chord."""
    return radius**2 * acos(distance / radius) - distance * sqrt(radius**2 - distance**2)


def foot_block(d: Dimensions) -> float:
    b, m3, m4 = d.bracket, catalogue.screw("M3"), catalogue.screw("M4")
    long, wide = b.foot_u_mm[1] - b.foot_u_mm[0], d.layers.motor_cheek_mm[0] - d.layers.encoder_cheek_mm[1]
    edge = (long + wide) * 0.5**2 - 4 * 0.5**3 / 3
    bores = 2 * cyl(m3.tap_drill_mm, wide) + 2 * cyl(m4.tap_drill_mm, b.foot_height_mm)
    across = min(5.0, wide / 2 - 2.0)
    pointed = wide / 2 - across - 1.5 / tan(radians(59.0)) >= 1.5 + 1.0  # else its tip comes too near an upright dowel
    bores += cyl(3.0, 6.0) + pointed * tip(3.0) + 3 * (cyl(3.0, across) + pointed * tip(3.0))
    bores += (3.0 * 3.4 - (4.0 - pi) * 1.0**2) * (6.0 + across)  # slots of two pins, corners of a 2 mm cutter
    return long * wide * b.foot_height_mm - edge - bores


def base_plate(d: Dimensions) -> float:
    b, m4, t = d.base, catalogue.screw("M4"), d.base.thickness_mm
    sunk = cyl(m4.counterbore_diameter_mm, m4.counterbore_depth_mm)
    bores = 6 * (sunk + cyl(m4.clearance_hole_mm, t - m4.counterbore_depth_mm)) + 6 * cyl(3.0, t)
    bores += cyl(b.centre_hole_mm, t)
    bores += 6 * cyl(catalogue.screw("M5").tap_drill_mm, t) + 3 * cyl(b.window_mm, t)
    if not b.rim_mm:
        return cyl(2 * b.radius_mm, t) - 2 * broken(2 * b.radius_mm, 1.0) - bores
    turns = np.linspace(0.0, 2.0 * pi, 3601)
    hull = ConvexHull([(x + r * cos(a), y + r * sin(a)) for x, y, r in b.rim_mm for a in turns])
    return hull.volume * t - (hull.area - 2.0 * pi / 3.0) - bores  # both edges broken by 1 mm: Steiner's formula


def screw(part: Part) -> float:
    """Cap screws, also those that tension, and set screws without a head; the key's hole in either."""
    kind, _, size = part.number.partition("screw_")
    size, _, length = size.partition("x")
    if kind == "set_":
        row = catalogue.set_screw(size)
        return cyl(row.tap_drill_mm - 0.04, float(length)) - hexagon(row.socket_mm, float(length) / 2)
    row = (catalogue.low_screw if size.startswith("low-") else catalogue.screw)(size)
    key = hexagon(row.socket_mm, row.socket_depth_mm)
    core = cyl(row.tap_drill_mm - 0.04, float(length))
    return cyl(row.head_diameter_mm, row.head_height_mm) + core - key


def hexagon(across_flats: float, height: float) -> float:
    return sqrt(3) / 2 * across_flats**2 * height


def crimp_sleeve(d: Dimensions) -> float:
    """Its bore is a drill's, by 0.05 to 0.1 mm wider than the cable."""
    bore = 0.05 * (int(d.cable.diameter_mm / 0.05 + 1e-9) + 1 + (d.cable.diameter_mm % 0.05 > 1e-9))
    return cyl(1.8, 3.0) - cyl(bore, 3.0)


def dowel(part: Part) -> float:
    diameter, _, length = part.number.removeprefix("dowel_").partition("x")
    return cyl(float(diameter), float(length))


def shoulder_shaft(d: Dimensions) -> float:
    """Head with the magnet against one bearing, thread in the other end; edges of 0.3 mm at both ends."""
    s, thread = d.shaft, catalogue.screw("M4")
    head = cyl(s.head_diameter_mm, s.head_to_y_mm - s.y_mm[0]) - broken(s.head_diameter_mm, 0.3)
    bar = cyl(s.diameter_mm, s.y_mm[1] - s.head_to_y_mm) - broken(s.diameter_mm, 0.3)
    flat, reach = s.flats_mm / 2, s.head_diameter_mm / 2  # two flats of 2.5 mm, the first 0.3 mm on the broken edge
    first = float(quad(lambda y: segment(reach - 0.3 + y, flat), 0.0, 0.3)[0])
    head -= 2 * (first + 2.2 * segment(reach, flat))
    drilled = cyl(thread.tap_drill_mm, 8.0 + 2.5) + tip(thread.tap_drill_mm)
    return head + bar - cyl(d.magnet.diameter_mm + 0.1, d.magnet.thickness_mm) - drilled


def shoulder_washer(_: Dimensions) -> float:
    return cyl(10.0, 3.0) - cyl(4.3, 3.0)


def wave_spring(d: Dimensions) -> float:
    assert d.preload is not None
    height = d.preload.work_height_mm
    return cyl(d.bearing.outer_mm - 0.3, height) - cyl(d.preload.inner_mm, height)


def cross_bar(d: Dimensions) -> float:
    f = d.forearm
    ball, neck, pin = f.ball_diameter_mm / 2, f.neck_diameter_mm, f.pin_diameter_mm
    rim = sqrt(ball**2 - (pin / 2 + 0.025) ** 2)
    shoulder = neck / 2 + 0.8
    length = f.width_mm - 2 * f.stand_off_mm
    cone = pi / 3 * f.cone_mm * (16.0 + 4.0 * shoulder + shoulder**2)
    studs = cyl(neck, f.stand_off_mm - rim) + cyl(pin, rim + f.pin_past_mm)
    return cyl(8.0, length - 2 * f.cone_mm) + 2 * cone + 2 * studs


def joint_ball(d: Dimensions) -> float:
    f = d.forearm
    radius, hole = f.ball_diameter_mm / 2, f.pin_diameter_mm / 2 + 0.025
    rim = sqrt(radius**2 - hole**2)
    bored = cyl(2 * hole, rim + f.pin_past_mm + 0.3) + cap(radius, radius - rim)
    return 4 / 3 * pi * radius**3 - bored


def pinion(d: Dimensions) -> float:
    """Groove drawn to its bottom between two shoulders, neck, collar; two threads across into the bore."""
    c = d.capstan
    assert c is not None
    (y0, y2), (low, high) = c.pinion_y_mm, c.collar_y_mm
    middle = sum(d.layers.sector_mm) / 2
    half = ceil(10 * (c.run.grooved_mm / 2 + 0.5) - 1e-9) / 10 - 0.5  # in whole tenths
    assert y2 == pytest.approx(middle + half + 0.5, abs=1e-12)  # the collar lies on the arm's side
    assert low == y0
    crest, bore = c.pinion_radius_mm, d.motor.shaft_diameter_mm
    bottom = c.run.pinion_mm - c.cable_diameter_mm / 2
    begin = middle - half - 0.5
    turned = cyl(2 * bottom, 2 * half) + 2 * cyl(2 * crest, 0.5)
    turned += cyl(2 * min(crest, c.collar_radius_mm), max(begin - high, 0.0))
    turned += cyl(2 * c.collar_radius_mm, min(high, begin) - low)
    drill = catalogue.set_screw("M3").tap_drill_mm / 2

    def length(radius: float) -> float:
        """Mean length of a thread's bore from the axis to a cylinder about it, over its cross-section, times that."""

        def across(v: float) -> float:
            return 2.0 * sqrt(drill**2 - v**2) * sqrt(radius**2 - v**2)

        return float(quad(across, -drill, drill, epsabs=1e-12)[0])

    threads = 2 * (length(c.collar_radius_mm) - length(bore / 2))
    return turned - cyl(bore, c.pinion_bore_depth_mm) - threads


def wound(d: Dimensions, length: float) -> float:
    """Cable along a length of its middle, drawn 0.03 mm thinner than it is (Pappus)."""
    return cyl(d.cable.diameter_mm - 0.03, length)


def on_rim(d: Dimensions, end: int) -> float:
    """Length on the rim from one of its ends to the take-off at home; climbs as a helix."""
    c = d.capstan
    assert c is not None
    off = c.direction_rad - d.home_rad + (1.0 if end else -1.0) * c.run.tangent_rad
    return c.pitch_radius_mm * abs(c.rim_angles_rad[end] - off) * sqrt(1.0 + c.run.climb**2)


def strand(end: int) -> Callable[[Dimensions], float]:
    """From the lug as it is made straight to where the groove takes the cable up, of which a part is free."""

    def volume(d: Dimensions) -> float:
        c = d.capstan
        assert c is not None
        run, sense = c.run, -1.0 if end else 1.0
        turned = c.direction_rad - d.home_rad - sum(c.rim_angles_rad) / 2
        length = run.middle_mm + sense * run.sector_mm * turned
        climbed = c.middle_y_mm + run.take_off_mm(turned)[end] - c.end_y_mm[end]
        return wound(d, run.free_mm * hypot(1.0, climbed / length))

    return volume


def turns(d: Dimensions) -> float:
    c = d.capstan
    assert c is not None
    return wound(d, c.run.wrap_rad * c.run.pinion_mm * sqrt(1.0 + c.run.climb**2))


def inner_end(d: Dimensions) -> float:
    return wound(d, (5.0 + d.cable.diameter_mm / 2) * pi / 2 + 6.0 + 3.0)  # nose, anchor's wall, sleeve


def motor(d: Dimensions) -> float:
    m = d.motor
    tail = min(4.0, m.length_mm / 6)
    body = cyl(m.diameter_mm, m.length_mm - tail) - broken(m.diameter_mm, 0.5) + cyl(m.diameter_mm - 4.0, tail)
    pilot = cyl(m.pilot_diameter_mm, m.pilot_height_mm)
    shaft = cyl(m.shaft_diameter_mm, m.shaft_length_mm - m.pilot_height_mm)
    return body + pilot + shaft - m.mount_count * cyl(catalogue.screw(m.mount_thread).tap_drill_mm, motor_thread_mm(m))


def bearing(d: Dimensions) -> float:
    b = d.bearing
    sunk = cyl(b.outer_ring_inner_mm, 0.4) - cyl(b.inner_ring_outer_mm, 0.4)
    return cyl(b.outer_mm, b.width_mm) - cyl(b.bore_mm, b.width_mm) - 2 * sunk


def encoder_board(d: Dimensions) -> float:
    e = d.encoder
    board = e.board_length_mm * e.board_width_mm * e.board_thickness_mm
    return board - 4 * cyl(e.hole_diameter_mm, e.board_thickness_mm) + 4.4 * 5.0 * e.chip_height_mm + 4.0 * 10.0 * 4.0


def knob(d: Dimensions) -> float:
    k = d.knob
    radius, neck = k.diameter_mm / 2, k.foot_diameter_mm / 2
    centre = k.height_mm - radius

    def area(z: float) -> float:
        ball = radius**2 - (z - centre) ** 2
        return pi * max(ball, neck**2 if z < centre else 0.0)

    joint = centre - sqrt(max(radius**2 - neck**2, 0.0))
    body = sum(
        quad(area, a, b, epsabs=1e-10)[0]
        for a, b in ((0.0, max(joint, 0.0)), (max(joint, 0.0), centre), (centre, k.height_mm))
    )
    return body - cyl(catalogue.screw(k.thread).tap_drill_mm, k.thread_depth_mm)


def handle_stem(d: Dimensions) -> float:
    core = catalogue.screw(d.knob.thread).tap_drill_mm - 0.04
    flats = 2 * segment(5.0, 4.0) * 6.0  # 8 mm across, 6 mm high
    return cyl(10.0, 25.0) - flats + cyl(core, 9.0) + cyl(core, d.knob.thread_depth_mm - 1.0)


def rod_tube(d: Dimensions) -> float:
    length = d.design.mechanism.forearm_length_mm - 2 * d.forearm.shoulder_mm
    return cyl(d.tube.outer_mm, length) - cyl(d.tube.inner_mm, length)


def spacer(d: Dimensions) -> float:
    length = d.layers.encoder_head_mm[0] - d.layers.encoder_board_mm[1]
    return cyl(5.0, length) - cyl(2.7, length)


def rubber_foot(d: Dimensions) -> float:
    f = d.foot
    assert f.stud_length_mm is not None
    return cyl(f.diameter_mm, f.height_mm) + cyl(catalogue.screw(f.thread).tap_drill_mm - 0.04, f.stud_length_mm)


def cup_shell(d: Dimensions) -> float:
    """What is above the lip's plane of one ball less another, less a bore through both at the pole."""
    inner, bore = d.design.hardware.ball_diameter_mm / 2 + 0.0075, 0.3
    lip = inner * cos(radians(86.0))

    def above(r: float) -> float:
        return pi * (2 * r**3 / 3 - r**2 * lip + lip**3 / 3)

    def bored(r: float) -> float:
        return 2 * pi / 3 * (r**3 - (r**2 - bore**2) ** 1.5)

    outer = inner + 0.6
    return above(outer) - above(inner) - bored(outer) + bored(inner)


CLOSED: dict[str, tuple[Callable[[Dimensions], float], float]] = {
    "base_plate": (base_plate, KERNEL),
    "foot_block": (foot_block, KERNEL),
    "motor": (motor, KERNEL),
    "bearing": (bearing, KERNEL),
    "encoder_board": (encoder_board, KERNEL),
    "encoder_magnet": (lambda d: cyl(d.magnet.diameter_mm, d.magnet.thickness_mm), KERNEL),
    "shoulder_shaft": (shoulder_shaft, KERNEL),
    "shoulder_washer": (shoulder_washer, KERNEL),
    "wave_spring": (wave_spring, KERNEL),
    "cross_bar": (cross_bar, KERNEL),
    "joint_ball": (joint_ball, KERNEL),
    "pinion": (pinion, CROSSED),
    "capstan_cable": (lambda d: wound(d, on_rim(d, 1)), ARCS),
    "capstan_cable_inner": (lambda d: wound(d, on_rim(d, 0)), ARCS),
    "capstan_cable_outer_end": (lambda d: wound(d, 1.2 + 6.0), KERNEL),
    "capstan_cable_inner_end": (inner_end, KERNEL),
    "capstan_cable_strand_inner": (strand(0), KERNEL),
    "capstan_cable_strand_outer": (strand(1), KERNEL),
    "capstan_cable_turns": (turns, ARCS),
    "crimp_sleeve": (crimp_sleeve, KERNEL),
    "rod_tube": (rod_tube, KERNEL),
    "cup_shell": (cup_shell, KERNEL),
    "board_spacer": (spacer, KERNEL),
    "handle_stem": (handle_stem, KERNEL),
    "knob": (knob, KERNEL),
}
SAMPLED = {"upper_arm", "sector", "platform", "rod_cup", "rod_eye", "rod_spring"}  # in test_sampled, as the next
SAMPLED |= {"motor_cheek", "encoder_cheek", "tension_carriage"}


@pytest.mark.parametrize("number", CLOSED)
def test_volume_is_its_closed_form(number: str, best_assembly: Assembly, best_dimensions: Dimensions) -> None:
    (part,) = [p for p in best_assembly.parts if p.number == number]
    closed, relative = CLOSED[number]
    assert part.solid.Volume(1e-9) == pytest.approx(closed(best_dimensions), rel=relative)


BY_SIZE = ("screw_", "set_screw_", "tension_screw_", "dowel_")


def test_screws_and_dowels_have_their_closed_form(best_assembly: Assembly) -> None:
    seen = 0
    for part in best_assembly.parts:
        if part.number.startswith(BY_SIZE):
            expected = dowel(part) if part.number.startswith("dowel_") else screw(part)
            assert part.solid.Volume() == pytest.approx(expected, rel=KERNEL), part.number
            seen += 1
    assert seen >= 7


def test_every_part_is_covered_by_a_volume_test(best_assembly: Assembly) -> None:
    named = {p.number for p in best_assembly.parts if not p.number.startswith(BY_SIZE)}
    assert named == set(CLOSED) | SAMPLED


def test_a_foot_has_its_closed_form(best_dimensions: Dimensions) -> None:
    assert make_foot(best_dimensions).solid.Volume() == pytest.approx(rubber_foot(best_dimensions), rel=KERNEL)


def test_a_six_sided_base_plate(best_dimensions: Dimensions) -> None:
    """Its bores, too, are all in it: those of the blocks, farther out than the flats, between them."""
    bracket = replace(
        best_dimensions.bracket,
        foot_u_mm=(50.0, 92.0),
        base_screw_u_mm=(66.5, 75.5),
        base_dowel_u_mm=(54.5, 87.5),
    )
    half = best_dimensions.layers.motor_cheek_mm[1]
    d = replace(best_dimensions, bracket=bracket, base=base_dimensions(bracket, 8.0, half, 88.7))
    plate = make_base_plate(d)
    assert plate.solid.Volume() == pytest.approx(base_plate(d), rel=1e-6)
    box = plate.solid.BoundingBox()
    assert ((box.xmin, box.xmax), (box.ymin, box.ymax)) == (
        pytest.approx(d.base.reach_mm[0], abs=1e-6),
        pytest.approx(d.base.reach_mm[1], abs=1e-6),
    )
