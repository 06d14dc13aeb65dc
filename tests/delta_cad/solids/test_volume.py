"""Volume of every turned, sawn and drilled part against its closed form, written from the drawing."""

from __future__ import annotations

from collections.abc import Callable
from math import acos, pi, sqrt

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.spatial import ConvexHull

from delta_cad import catalogue
from delta_cad.assembly.machine import Assembly
from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.layers import motor_thread_mm
from delta_cad.solids.part import Part

KERNEL = 1e-9  # relative; the kernel integrates planes, cylinders and spheres to rounding
HULL = 2e-7  # relative; outlines as polygons of 4000 points a circle: 1 - sin(x)/x of half a step, and its square


def cyl(diameter: float, length: float) -> float:
    return pi / 4 * diameter**2 * length


def broken(diameter: float, leg: float) -> float:
    """Ring that a 45 degree edge break takes off a cylinder (Pappus: leg^2 / 2 around its centroid)."""
    return pi * leg**2 * (diameter / 2 - leg / 3)


def cap(radius: float, height: float) -> float:
    return pi * height**2 * (3 * radius - height) / 3


def segment(radius: float, distance: float) -> float:
    """Area of a disc beyond a chord."""
    return radius**2 * acos(distance / radius) - distance * sqrt(radius**2 - distance**2)


def outline(circles: list[tuple[float, float, float]]) -> tuple[float, float, float]:
    """Area, perimeter and mitre sum of the hull of circles: sum of tan(half the turn) over all corners."""
    turn = np.linspace(0, 2 * pi, 4000, endpoint=False)
    points = np.concatenate(
        [
            np.array([[x, z]]) if r == 0 else np.stack([x + r * np.cos(turn), z + r * np.sin(turn)], axis=1)
            for x, z, r in circles
        ]
    )
    hull = ConvexHull(points)
    ring = points[hull.vertices]
    edges = np.roll(ring, -1, axis=0) - ring
    before = np.roll(edges, 1, axis=0)
    turns = np.arctan2(before[:, 0] * edges[:, 1] - before[:, 1] * edges[:, 0], (before * edges).sum(axis=1))
    return hull.volume, hull.area, float(np.tan(turns / 2).sum())


def plate(circles: list[tuple[float, float, float]], thickness: float, leg: float) -> float:
    """Prism over a hull with both faces' edges broken: at depth s the outline is an inner parallel curve."""
    area, length, mitre = outline(circles)
    return area * thickness - 2 * (length * leg**2 / 2 - mitre * leg**3 / 3)


def foot(d: Dimensions) -> list[tuple[float, float, float]]:
    b = d.bracket
    low, high = (u - b.shoulder_u_mm for u in b.foot_u_mm)
    top = b.base_top_mm + b.foot_height_mm - 3.0
    return [(low, b.base_top_mm, 0), (high, b.base_top_mm, 0), (low + 3, top, 3), (high - 3, top, 3)]


def seat(d: Dimensions, thickness: float) -> float:
    return cyl(d.bearing.outer_mm, d.bearing.width_mm) + cyl(d.bracket.passage_mm, thickness - d.bearing.width_mm)


def motor_cheek(d: Dimensions) -> float:
    b, m = d.bracket, d.motor
    t = d.layers.motor_cheek_mm[1] - d.layers.motor_cheek_mm[0]
    screw, block = catalogue.screw(m.mount_thread), catalogue.screw("M3")
    motor = (b.motor_axis_mm[0] - b.shoulder_u_mm, b.motor_axis_mm[1], b.motor_pad_radius_mm)
    sunk = cyl(screw.counterbore_diameter_mm, screw.counterbore_depth_mm)
    bores = (
        cyl(m.pilot_diameter_mm, t) + 2 * cyl(block.clearance_hole_mm, t) + cyl(4.0, t) + seat(d, t) + 2 * cyl(3.0, t)
    )
    bores += m.mount_count * (sunk + cyl(screw.clearance_hole_mm, t - screw.counterbore_depth_mm))
    return plate([(0, 0, b.head_radius_mm), motor, *foot(d)], t, 0.5) - bores


def encoder_cheek(d: Dimensions) -> float:
    b, e = d.bracket, d.encoder
    t = d.layers.encoder_cheek_mm[1] - d.layers.encoder_cheek_mm[0]
    x, z = e.hole_spacing_width_mm / 2, e.hole_spacing_length_mm / 2  # the board stands upright
    pads = [(sx * x, sz * z, 4.0) for sx in (-1, 1) for sz in (-1, 1)]
    bores = 4 * cyl(catalogue.screw("M2.5").tap_drill_mm, t) + 2 * cyl(catalogue.screw("M3").clearance_hole_mm, t)
    bores += seat(d, t) + 2 * cyl(3.0, t)
    return plate([(0, 0, b.head_radius_mm), *pads, *foot(d)], t, 0.5) - bores


def foot_block(d: Dimensions) -> float:
    b, m3, m4 = d.bracket, catalogue.screw("M3"), catalogue.screw("M4")
    long, wide = b.foot_u_mm[1] - b.foot_u_mm[0], d.layers.motor_cheek_mm[0] - d.layers.encoder_cheek_mm[1]
    edge = (long + wide) * 0.5**2 - 4 * 0.5**3 / 3
    depth = min(7.0, wide / 2 - 0.5)
    bores = 4 * cyl(m3.tap_drill_mm, depth) + 2 * cyl(m4.tap_drill_mm, 11.0) + 2 * cyl(3.0, 6.0)
    bores += 4 * cyl(3.0, min(5.0, wide / 2 - 2.0))
    return long * wide * b.foot_height_mm - edge - bores


def base_plate(d: Dimensions) -> float:
    b, m4, t = d.base, catalogue.screw("M4"), d.base.thickness_mm
    sunk = cyl(m4.counterbore_diameter_mm, m4.counterbore_depth_mm)
    bores = 6 * (sunk + cyl(m4.clearance_hole_mm, t - m4.counterbore_depth_mm)) + 6 * cyl(3.0, t)
    bores += cyl(b.centre_hole_mm, t) + 3 * cyl(catalogue.screw(d.foot.thread).tap_drill_mm, t)
    bores += 6 * cyl(b.mount_hole_mm, t) + 3 * cyl(34.0, t)
    return cyl(2 * b.radius_mm, t) - 2 * broken(2 * b.radius_mm, 1.0) - bores


def screw(part: Part) -> float:
    size, _, length = part.number.removeprefix("screw_").partition("x")
    row = catalogue.screw(size)
    key = hexagon(row.socket_mm, row.socket_depth_mm)
    core = cyl(row.tap_drill_mm - 0.04, float(length))
    return cyl(row.head_diameter_mm, row.head_height_mm) + core - key


def hexagon(across_flats: float, height: float) -> float:
    return sqrt(3) / 2 * across_flats**2 * height


def tension_screw(_: Dimensions) -> float:
    row = catalogue.hex_screw("M2.5")
    head = hexagon(row.across_flats_mm, row.head_height_mm)
    return head + cyl(row.tap_drill_mm - 0.04, 8.0) - cyl(0.8, 8.0 + row.head_height_mm)


def lock_nut(_: Dimensions) -> float:
    row = catalogue.hex_nut("M2.5")
    return hexagon(row.across_flats_mm, row.height_mm) - cyl(row.tap_drill_mm, row.height_mm)


def crimp_sleeve(d: Dimensions) -> float:
    return cyl(1.8, 3.0) - cyl(d.cable.diameter_mm, 3.0)


def dowel(part: Part) -> float:
    diameter, _, length = part.number.removeprefix("dowel_").partition("x")
    return cyl(float(diameter), float(length))


def shoulder_shaft(d: Dimensions) -> float:
    s = d.shaft
    bar = cyl(s.diameter_mm, s.y_mm[1] - s.y_mm[0]) - 2 * broken(s.diameter_mm, 0.3)
    return bar - cyl(d.magnet.diameter_mm + 0.1, d.magnet.thickness_mm)


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
    c = d.capstan
    assert c is not None
    length = c.pinion_y_mm[1] - c.pinion_y_mm[0]
    return (
        cyl(2 * c.pinion_radius_mm, length)
        - 2 * broken(2 * c.pinion_radius_mm, 0.3)
        - cyl(d.motor.shaft_diameter_mm, c.pinion_bore_depth_mm)
    )


def cable(d: Dimensions) -> float:
    c = d.capstan
    assert c is not None
    wound = d.design.hardware.sector_radius_mm * (c.rim_angles_rad[1] - c.rim_angles_rad[0])
    wound += (5.0 + d.cable.diameter_mm / 2) * pi / 2  # a quarter turn round the nose
    beyond = c.lug_length_mm + 2.0 + catalogue.hex_screw("M2.5").head_height_mm + 3.0  # lug, nut, head, sleeve
    return cyl(d.cable.diameter_mm, wound + 2 * beyond)


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
    bore = catalogue.screw("M2.5").clearance_hole_mm
    length = d.layers.encoder_cheek_mm[0] - d.layers.encoder_board_mm[1]
    return cyl(bore + 2.0, length) - cyl(bore, length)


def rubber_foot(d: Dimensions) -> float:
    f = d.foot
    assert f.stud_length_mm is not None
    return cyl(f.diameter_mm, f.height_mm) + cyl(catalogue.screw(f.thread).tap_drill_mm - 0.04, f.stud_length_mm)


CLOSED: dict[str, tuple[Callable[[Dimensions], float], float]] = {
    "base_plate": (base_plate, KERNEL),
    "motor_cheek": (motor_cheek, HULL),
    "encoder_cheek": (encoder_cheek, HULL),
    "foot_block": (foot_block, KERNEL),
    "foot": (rubber_foot, KERNEL),
    "motor": (motor, KERNEL),
    "bearing": (bearing, KERNEL),
    "encoder_board": (encoder_board, KERNEL),
    "encoder_magnet": (lambda d: cyl(d.magnet.diameter_mm, d.magnet.thickness_mm), KERNEL),
    "shoulder_shaft": (shoulder_shaft, KERNEL),
    "cross_bar": (cross_bar, KERNEL),
    "joint_ball": (joint_ball, KERNEL),
    "pinion": (pinion, KERNEL),
    "capstan_cable": (cable, 1e-6),  # swept surfaces are splines, integrated numerically
    "tension_screw": (tension_screw, KERNEL),
    "nut_M2.5": (lock_nut, KERNEL),
    "crimp_sleeve": (crimp_sleeve, KERNEL),
    "rod_tube": (rod_tube, KERNEL),
    "board_spacer": (spacer, KERNEL),
    "handle_stem": (handle_stem, KERNEL),
    "knob": (knob, KERNEL),
}
SAMPLED = {"upper_arm", "sector", "platform", "rod_cup", "rod_eye"}  # in test_solids_sampled


@pytest.mark.parametrize("number", CLOSED)
def test_volume_is_its_closed_form(number: str, best_assembly: Assembly, best_dimensions: Dimensions) -> None:
    (part,) = [p for p in best_assembly.parts if p.number == number]
    closed, relative = CLOSED[number]
    assert part.solid.Volume() == pytest.approx(closed(best_dimensions), rel=relative)


def test_screws_and_dowels_have_their_closed_form(best_assembly: Assembly) -> None:
    seen = 0
    for part in best_assembly.parts:
        kind = part.number.partition("_")[0]
        if kind in ("screw", "dowel"):
            expected = screw(part) if kind == "screw" else dowel(part)
            assert part.solid.Volume() == pytest.approx(expected, rel=KERNEL), part.number
            seen += 1
    assert seen >= 5


def test_every_part_is_covered_by_a_volume_test(best_assembly: Assembly) -> None:
    named = {p.number for p in best_assembly.parts if not p.number.startswith(("screw_", "dowel_"))}
    assert named == set(CLOSED) | SAMPLED
