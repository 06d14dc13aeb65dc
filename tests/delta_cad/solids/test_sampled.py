"""Milled and moulded parts against a second drawing of each: a rule that says which points are material.

The rules are written from the dimensions with distances and inequalities; no kernel, no boolean, no wire.
"""

from __future__ import annotations

from collections.abc import Callable
from math import hypot, sqrt

import numpy as np
import pytest
from scipy.spatial import ConvexHull
from scipy.stats import qmc

from delta_cad import catalogue
from delta_cad.assembly.machine import Assembly
from delta_cad.dimensions import Dimensions
from delta_cad.solids.part import Part
from tests.delta_cad.solids.measured import cylinders

POINTS = 2**20
RELATIVE = 1e-3
"""Scrambled Sobol points miss the volumes by at most 3.2e-4 (six seeds); one M3 thread is 2.6e-3 of the platform."""

Points = np.ndarray
Rule = Callable[[Dimensions, Part, Points, Points, Points], np.ndarray]


def round_cone(
    x: Points, z: Points, start: tuple[float, float], r0: float, end: tuple[float, float], r1: float
) -> np.ndarray:
    """Inside the hull of two circles: signed distance by the side of the common tangent's normals."""
    length = hypot(end[0] - start[0], end[1] - start[1])
    ux, uz = (end[0] - start[0]) / length, (end[1] - start[1]) / length
    along = (x - start[0]) * ux + (z - start[1]) * uz
    aside = np.abs(-(x - start[0]) * uz + (z - start[1]) * ux)
    b = (r0 - r1) / length
    a = sqrt(1 - b * b)
    k = -b * aside + a * along
    distance = np.where(
        k < 0,
        np.hypot(aside, along) - r0,
        np.where(k > a * length, np.hypot(aside, along - length) - r1, a * aside + b * along - r0),
    )
    return distance <= 0


def within(x: Points, z: Points, at: tuple[float, float], diameter: float) -> np.ndarray:
    return np.hypot(x - at[0], z - at[1]) <= diameter / 2


def upper_arm(d: Dimensions, _: Part, x: Points, y: Points, z: Points) -> np.ndarray:
    a, (y0, y1) = d.arm, d.layers.arm_mm
    length, boss = a.length_mm, a.boss_radius_mm
    plate = (y >= y0) & (y <= y1)
    end = d.layers.elbow_boss_mm[1]
    material = plate & round_cone(x, z, (0, 0), a.beam_root_radius_mm, (length, 0), boss)
    bevel = np.maximum(np.abs(y) - (end - 0.4), 0)  # broken edge of the boss
    material |= (np.abs(y) <= end) & (np.hypot(x - length, z) <= boss - bevel)
    material |= (y >= d.layers.bearings_mm[0][1]) & (y <= y0) & within(x, z, (0, 0), a.collar_diameter_mm)
    empty = within(x, z, (0, 0), a.shaft_bore_mm) | within(x, z, (length, 0), a.bar_bore_mm)
    for at in ((0.0, a.dowel_circle_mm / 2), (0.0, -a.dowel_circle_mm / 2)):
        empty |= within(x, z, at, 3.0)
    return material & ~empty


def sector(d: Dimensions, part: Part, x: Points, y: Points, z: Points) -> np.ndarray:
    c, a, (y0, y1) = d.capstan, d.arm, d.layers.sector_mm
    assert c is not None
    low, high = c.rim_angles_rad
    screw = catalogue.screw("M3")
    radius, middle = np.hypot(x, z), (low + high) / 2
    angle = (np.arctan2(z, x) - middle + np.pi) % (2 * np.pi) - np.pi  # from the sector's middle
    half, inner = (high - low) / 2, a.flange_radius_mm - 4
    web0, web1 = (y0 + y1) / 2 - 1.5, (y0 + y1) / 2 + 1.5
    web, rim = (y >= web0) & (y <= web1), (y >= y0) & (y <= y1)
    length, pitch = 13.7, c.pitch_radius_mm  # gap 1.2, carriage 6, its travel 3.5, wall 3
    under = length / c.rim_radius_mm
    solid = web & (radius >= inner) & (radius <= c.rim_radius_mm) & (np.abs(angle) <= half)
    solid |= rim & (radius >= c.rim_radius_mm - 3.5) & (radius <= c.rim_radius_mm) & (np.abs(angle) <= half)
    foot = max(pitch - 8.2, (pitch - 9.2) / float(np.cos(under)) + 0.5)  # beyond the lug's foot where it ends
    solid |= web & (radius >= inner) & (radius <= foot) & (angle >= -half) & (angle <= half + under)
    off_hub, off_end = radius - a.flange_radius_mm, radius * np.sin(angle - half - under)
    solid |= web & (angle > 0) & rounded_corner(off_hub, off_end)
    solid |= (y >= a_side(d)) & (y <= web1) & (radius <= a.flange_radius_mm)
    solid |= (y >= web1) & (y <= d.layers.motor_cheek_mm[0]) & within(x, z, (0, 0), a.collar_diameter_mm)
    empty = within(x, z, (0, 0), a.shaft_bore_mm)
    # the upper end, seen along the radius through the nose's axis: out along it, aside from it away from the plate
    out, aside = x * np.cos(low) + z * np.sin(low), x * np.sin(low) - z * np.cos(low)
    top, cable = c.rim_radius_mm - 5.0, 5.0 + c.cable_diameter_mm / 2  # the nose's axis; the cable's line beside it
    bar = cable - 3.2
    share = inner / top
    solid |= rim & (np.hypot(out - top, aside) <= 5.0)
    solid |= web & round_cone(out, aside, (share * top, 0), bar, (top, 0), bar)
    adjacent, beyond = aside - cable, top - out
    solid |= (y >= web0) & (y <= y1) & (np.abs(adjacent) <= 3.2) & (beyond >= 0) & (beyond <= 6.0)
    solid |= web & (aside > 0) & rounded_corner(off_hub, aside - bar)
    solid |= web & rounded_corner(aside - bar, beyond - 6.0)
    slit = (np.hypot(adjacent, y - c.end_y_mm[0]) < 0.5) | (np.abs(adjacent) < 0.5) & (y > c.end_y_mm[0])
    empty |= slit & (beyond > -0.5) & (beyond < 6.5)
    # the other end: the cable runs on along the rim's tangent into the carriage's pocket
    out, along = x * np.cos(high) + z * np.sin(high) - pitch, -x * np.sin(high) + z * np.cos(high)
    floor, roof = c.end_y_mm[1] - 2.5, c.end_y_mm[1] + 2.6  # the pocket is open to the arm's side
    solid |= (out >= -9.2) & (out <= 4.2) & (along >= 0) & (along <= length) & (y >= floor) & (y <= y1)
    solid |= rim & ~web & (y >= floor) & rounded_corner(c.rim_radius_mm - 3.5 - radius, -along) & (out < -3.0)
    off = (
        np.maximum(np.abs(out + 2.5) - 3.5, 0.0),
        np.maximum(np.abs(along - (length - 2.0) / 2) - (length - 7.2) / 2, 0.0),
    )
    empty |= (np.hypot(*off) < 1.6) & (y < roof)  # walls of 1 and 3 mm along the cable, corners of 1.6
    slit = (np.hypot(out, y - c.end_y_mm[1]) < 0.5) | (np.abs(out) < 0.5) & (y < c.end_y_mm[1])
    empty |= slit & (along > -0.5) & (along < 1.5)
    empty |= (np.hypot(out + 5.0, y - c.end_y_mm[1]) < screw.clearance_hole_mm / 2) & (along > length - 3.5)
    for at in ((0.0, a.dowel_circle_mm / 2), (0.0, -a.dowel_circle_mm / 2)):
        empty |= within(x, z, at, 3.0)
    s0, s1 = c.slot_angles_rad
    empty |= (np.abs(radius - c.slot_radius_mm) < c.slot_width_mm / 2) & (np.abs(angle) < (s1 - s0) / 2)
    for end in (s0, s1):
        at = (c.slot_radius_mm * float(np.cos(end)), c.slot_radius_mm * float(np.sin(end)))
        empty |= within(x, z, at, c.slot_width_mm)
    for point, _ in cylinders(part.solid, 7.0, concave=True):
        empty |= within(x, z, (point[0], point[2]), 7.0)
    return solid & ~empty


def a_side(d: Dimensions) -> float:
    """Face of the arm that the sector lies on."""
    return d.layers.arm_mm[1]


def platform(d: Dimensions, _: Part, x: Points, y: Points, z: Points) -> np.ndarray:
    p = d.platform
    r, half, boss = p.radius_mm, p.boss_length_mm / 2, p.boss_diameter_mm / 2
    plate = (z >= boss - p.plate_mm) & (z <= boss)
    material = (np.abs(z) <= boss) & (np.hypot(x, y) <= p.hub_radius_mm)
    empty = np.hypot(x, y) < catalogue.screw(p.stem_thread).tap_drill_mm / 2
    near, far = p.hub_radius_mm + 4.0, r - boss - 1.0
    reach = (half - 5.0) * far / r - 4.0
    for i in range(3):
        c, s = np.cos(2 * np.pi * i / 3), np.sin(2 * np.pi * i / 3)
        u, t = x * c + y * s, -x * s + y * c
        wide = half - 5.0
        web = round_cone(u, t, (0, 0), p.hub_radius_mm, (r, wide), 3.0)
        web |= round_cone(u, t, (0, 0), p.hub_radius_mm, (r, -wide), 3.0)
        web |= round_cone(u, t, (r, wide), 3.0, (r, -wide), 3.0)
        web |= (u >= 0) & (u <= r) & (np.abs(t) <= wide * u / r)
        material |= plate & (web | rounded_valley(u, t, r, wide, p.hub_radius_mm))
        axis = np.hypot(u - r, z)
        material |= (np.abs(t) <= half) & (axis <= boss - np.maximum(np.abs(t) - (half - 0.4), 0))
        empty |= axis < p.bar_bore_mm / 2
        if far - near >= 4.0 and reach >= 3.0:
            u0, u1, w = near + 1.5, far - 1.5, reach - 1.5
            window = round_cone(u, t, (u0, 0), 1.5, (u1, w), 1.5) | round_cone(u, t, (u0, 0), 1.5, (u1, -w), 1.5)
            window |= round_cone(u, t, (u1, w), 1.5, (u1, -w), 1.5)
            window |= (u >= u0) & (u <= u1) & (np.abs(t) <= w * (u - u0) / (u1 - u0))
            empty |= window & (z > boss - p.plate_mm - 0.5)
    return material & ~empty


def rounded_corner(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """What a cutter of radius 1.6 leaves between two walls square to one another, of distances off either."""
    near = (one >= 0) & (other >= 0) & (one < 1.6) & (other < 1.6)
    return near & (np.hypot(one - 1.6, other - 1.6) > 1.6)


def rounded_valley(u: np.ndarray, t: np.ndarray, r: float, wide: float, hub: float) -> np.ndarray:
    """What a cutter of 1.6 leaves between a web, hub to (r, wide) with radius 3, and its mirror at 60 degrees."""
    normal = np.arctan2(wide, r) + np.arccos((hub - 3.0) / np.hypot(r, wide))
    walls = np.array([[np.cos(a), np.sin(a)] for a in (normal, 2 * np.pi / 3 - normal)])
    off = np.array([walls[k, 0] * u + walls[k, 1] * t - hub for k in (0, 1)])
    centre = np.linalg.solve(walls, [hub + 1.6, hub + 1.6])
    back = np.linalg.solve(walls.T, -np.array([u - centre[0], t - centre[1]]))  # between both walls' normals
    return (off >= 0).all(axis=0) & (back >= 0).all(axis=0) & (np.hypot(u - centre[0], t - centre[1]) > 1.6)


def rod_cup(d: Dimensions, _: Part, x: Points, y: Points, z: Points) -> np.ndarray:
    f, rod = d.forearm, d.tube.outer_mm / 2
    from_ball, seat = np.sqrt(x**2 + y**2 + z**2), d.design.hardware.ball_diameter_mm / 2 + 0.0075
    lip = seat * float(np.cos(np.radians(86.0)))
    material = (y >= lip) & (from_ball <= seat + 1.7)
    top, flat, end = 0.9 * (seat + 1.7), 0.65 * (seat + 1.7), f.shoulder_mm - 1.0
    gusset = (x >= 0) & (x <= end) & (y >= lip) & (y <= top + (rod - top) * np.maximum(x - flat, 0) / (end - flat))
    material |= gusset & (np.abs(z) <= rod)
    material |= (x >= f.stem_mm) & (x <= f.shoulder_mm) & (np.maximum(np.abs(y), np.abs(z)) <= rod)
    tip = f.shoulder_mm + f.spigot_length_mm
    material |= (x >= f.shoulder_mm) & (x <= tip) & (np.hypot(y, z) <= (d.tube.inner_mm - 0.2) / 2)
    return material & (from_ball >= seat + 0.62)  # a shell of 0.6, glued


def rod_spring(d: Dimensions, _: Part, x: Points, y: Points, z: Points) -> np.ndarray:
    row, half = d.forearm.spring, d.forearm.width_mm / 2 - 0.8
    mean, wire = row.mean_diameter_mm / 2, row.wire_mm / 2
    loops = (row.free_length_mm - (row.active_coils + 1) * row.wire_mm) / 2
    material = (np.hypot(x, z) <= mean + wire) & (np.abs(y) <= half - loops)
    ring = np.hypot(x, np.abs(y) - (half - mean + wire)) - mean
    return material | (np.hypot(ring, z) <= wire)


def rod_eye(d: Dimensions, _: Part, x: Points, y: Points, z: Points) -> np.ndarray:
    f, axis = d.forearm, np.hypot(y, z)
    around = f.eye_diameter_mm / 2 + 1.4
    material = axis <= 2.55 + 1.4
    inside = (f.spring.mean_diameter_mm - f.spring.wire_mm) / 2  # of the loop, which bears on both edges of a 2 mm lug
    hole = 0.8 + inside - np.sqrt(inside**2 - 1.0) - f.eye_diameter_mm / 2
    off = np.hypot(y + hole, z - 5.5)
    material |= (np.abs(y + hole) <= around) & (z >= 0) & (z <= 5.5)
    material |= off <= around
    return material & (np.abs(x) <= 1.0) & (axis >= d.tube.outer_mm / 2 + 0.05) & (off >= f.eye_diameter_mm / 2)


def hull_depth(x: Points, z: Points, circles: list[tuple[float, float, float]]) -> np.ndarray:
    """How deep points lie inside the hull of circles (x, z, radius), polygons of 360 points; negative outside."""
    turn = np.linspace(0, 2 * np.pi, 360, endpoint=False)
    ring = np.concatenate([np.stack([u + r * np.cos(turn), v + r * np.sin(turn)], axis=1) for u, v, r in circles])
    sides = np.unique(ConvexHull(ring).equations.round(9), axis=0)
    deep = np.full(len(x), np.inf)
    for nx, nz, offset in sides:
        np.minimum(deep, -(nx * x + nz * z + offset), out=deep)
    return deep


def plate(
    x: Points, y: Points, z: Points, circles: list[tuple[float, float, float]], faces: tuple[float, float]
) -> np.ndarray:
    """Prism over the hull of circles between two faces across y, the edges of both broken by 0.5 mm."""
    from_face = np.minimum(y - faces[0], faces[1] - y)
    return (from_face >= 0) & (hull_depth(x, z, circles) >= np.maximum(0.5 - from_face, 0.0))


def foot(d: Dimensions) -> list[tuple[float, float, float]]:
    b = d.bracket
    low, high = (u - b.shoulder_u_mm for u in b.foot_u_mm)
    top = b.base_top_mm + b.foot_height_mm - 3.0
    return [(low, b.base_top_mm + 0.5, 0), (high, b.base_top_mm + 0.5, 0), (low + 3, top, 3), (high - 3, top, 3)]


def block_bores(d: Dimensions, x: Points, z: Points) -> np.ndarray:
    """Screws and dowels of a cheek on its foot block."""
    b, empty = d.bracket, np.zeros(len(x), dtype=bool)
    for ends, diameter in (
        (b.cheek_screw_u_mm, catalogue.screw("M3").clearance_hole_mm),
        (b.cheek_dowel_u_mm, 3.0),
    ):
        for u in ends:
            empty |= within(x, z, (u - b.shoulder_u_mm, b.base_top_mm + 7.0), diameter)
    return empty


def motor_cheek(d: Dimensions, _: Part, x: Points, y: Points, z: Points) -> np.ndarray:
    b, m = d.bracket, d.motor
    (y0, y1), face = d.layers.motor_cheek_mm, d.layers.motor_face_mm
    at = b.motor_axis_mm[0] - b.shoulder_u_mm, b.motor_axis_mm[1]
    head = b.head_radius_mm
    material = plate(x, y, z, [(0, 0, head), (*at, m.diameter_mm / 2 + 2.0), *foot(d)], (y0, y1))
    empty = within(x, z, at, m.pilot_diameter_mm) | block_bores(d, x, z)
    screw = catalogue.low_screw(f"low-{m.mount_thread}")
    towards = np.arctan2(-at[1], -at[0])  # the hole on the line of centres has no screw
    for a in towards + np.radians([60.0, 120.0, 180.0, 240.0, 300.0]):
        place = at[0] + m.mount_circle_mm / 2 * float(np.cos(a)), at[1] + m.mount_circle_mm / 2 * float(np.sin(a))
        reached = face - y0 - 1.5  # a screw of 5 mm has 1.5 mm under its head
        empty |= within(x, z, place, screw.clearance_hole_mm)
        room = m.mount_circle_mm - m.pilot_diameter_mm - 2 * 0.5  # a wall of 0.5 to the pilot, if there is room
        sunk = screw.counterbore_diameter_mm
        sunk = min(sunk, room) if room >= screw.head_diameter_mm + 0.3 else sunk
        empty |= within(x, z, place, sunk) & (y < y0 + reached)
    (pin,) = b.stop_pins_mm
    empty |= within(x, z, (pin[0] - b.shoulder_u_mm, pin[1]), 4.0)
    empty |= within(x, z, (0, 0), d.bearing.outer_mm) & (y < y0 + d.bearing.width_mm)
    empty |= within(x, z, (0, 0), b.passage_mm)
    empty |= within(x, z, at, m.diameter_mm + 0.5) & (y > face)  # the motor's pocket
    return material & ~empty


def encoder_cheek(d: Dimensions, _: Part, x: Points, y: Points, z: Points) -> np.ndarray:
    b, e = d.bracket, d.encoder
    (y0, y1), face = d.layers.encoder_cheek_mm, d.layers.encoder_head_mm[0]
    u, v = e.hole_spacing_width_mm / 2, e.hole_spacing_length_mm / 2  # the board stands upright
    pads = [(su * u, sv * v) for su in (-1, 1) for sv in (-1, 1)]
    radius = b.head_radius_mm
    material = plate(x, y, z, [(4.0, 0, radius - 4.0), *foot(d)], (y0, y1))
    material |= plate(x, y, z, [(0, 0, radius), *((*at, 4.0) for at in pads)], (face, y1))
    empty = block_bores(d, x, z) | within(x, z, (0, 0), b.passage_mm)
    for at in pads:
        empty |= within(x, z, at, catalogue.screw("M2.5").tap_drill_mm) & (y < face + 10.0)  # thread of 8, drill 2 on
    empty |= within(x, z, (0, 0), d.bearing.outer_mm) & (y > face + 1.0)  # lip
    return material & ~empty


def tension_carriage(_: Dimensions, __: Part, x: Points, y: Points, z: Points) -> np.ndarray:
    aside = np.where(y < 0.0, np.abs(x), np.hypot(x, y))  # slots with round bottoms, open to -y
    empty = (aside < 0.5) | (aside < 1.0) & (z > 3.0)  # cable; its sleeve
    off = np.maximum(np.abs(x + 2.5) - 3.4, 0.0), np.maximum(np.abs(z - 3.0) - 1.4, 0.0)
    empty |= np.hypot(*off) > 1.6  # its edges along y are round
    empty |= np.hypot(x + 5.0, y) < catalogue.screw("M3").tap_drill_mm / 2
    return (x >= -7.5) & (x <= 2.5) & (np.abs(y) <= 2.5) & (z >= 0) & (z <= 6.0) & ~empty


RULES: dict[str, Rule] = {"upper_arm": upper_arm, "sector": sector, "platform": platform}
RULES |= {"rod_cup": rod_cup, "rod_spring": rod_spring, "rod_eye": rod_eye, "tension_carriage": tension_carriage}
RULES |= {"motor_cheek": motor_cheek, "encoder_cheek": encoder_cheek}


def sampled_volume(number: str, d: Dimensions, part: Part, seed: int) -> float:
    box = part.solid.BoundingBox()
    low = np.array([box.xmin, box.ymin, box.zmin]) - 0.1  # room for material outside the solid, which would be a fault
    high = np.array([box.xmax, box.ymax, box.zmax]) + 0.1
    points = low + qmc.Sobol(3, rng=seed).random(POINTS) * (high - low)
    inside = RULES[number](d, part, *points.T)
    return float(np.prod(high - low) * inside.mean())


@pytest.mark.parametrize("number", RULES)
def test_volume_is_that_of_the_drawing(number: str, best_assembly: Assembly, best_dimensions: Dimensions) -> None:
    (part,) = [p for p in best_assembly.parts if p.number == number]
    assert part.solid.Volume() == pytest.approx(sampled_volume(number, best_dimensions, part, 1), rel=RELATIVE)
