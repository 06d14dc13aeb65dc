"""Milled and moulded parts against a second drawing of each: a rule that says which points are material.

The rules are written from the dimensions with distances and inequalities; no kernel, no boolean, no wire.
"""

from __future__ import annotations

from collections.abc import Callable
from math import hypot, sqrt

import numpy as np
import pytest
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


def on_circle(radius: float, degrees: list[float]) -> list[tuple[float, float]]:
    return [(radius * float(np.cos(np.radians(a))), radius * float(np.sin(np.radians(a)))) for a in degrees]


def upper_arm(d: Dimensions, _: Part, x: Points, y: Points, z: Points) -> np.ndarray:
    a, (y0, y1) = d.arm, d.layers.arm_mm
    m3, m25 = catalogue.screw("M3"), catalogue.screw("M2.5")
    length, boss = a.length_mm, a.boss_radius_mm
    plate = (y >= y0) & (y <= y1)
    end = d.layers.elbow_boss_mm[1]
    material = plate & round_cone(x, z, (0, 0), a.beam_root_radius_mm, (length, 0), boss)
    material |= plate & within(x, z, (0, 0), 2 * a.flange_radius_mm)
    bevel = np.maximum(np.abs(y) - (end - 0.4), 0)  # broken edge of the boss
    material |= (np.abs(y) <= end) & (np.hypot(x - length, z) <= boss - bevel)
    material |= (y >= d.layers.encoder_cheek_mm[1]) & (y <= y0) & within(x, z, (0, 0), a.collar_diameter_mm)
    empty = within(x, z, (0, 0), a.shaft_bore_mm) | within(x, z, (length, 0), a.bar_bore_mm)
    empty |= (np.abs(x) < a.slit_mm / 2) & (z > 0)
    clamp = np.hypot(y, z - a.shoulder_clamp_z_mm)
    empty |= (x < 0) & (clamp < m3.clearance_hole_mm / 2)
    empty |= (x < -8) & (z > a.shoulder_clamp_z_mm - m3.counterbore_diameter_mm / 2)  # milled seat, open above
    empty |= (x > 0) & (x < 10) & (clamp < m3.tap_drill_mm / 2)
    empty |= (x > a.elbow_slit_x_mm) & (np.abs(z) < a.slit_mm / 2)  # through the boss
    empty |= within(x, z, (a.elbow_slit_x_mm, 0), 2.5)
    grip = np.hypot(x - a.elbow_clamp_x_mm, y)
    empty |= (z > 0) & (grip < m25.clearance_hole_mm / 2)
    empty |= (z > 3.5) & (grip < m25.counterbore_diameter_mm / 2)
    empty |= (z < 0) & (grip < m25.tap_drill_mm / 2)
    (p0, p1), (r0, r1) = a.pocket_x_mm, a.pocket_radii_mm
    empty |= round_cone(x, z, (p0, 0), r0, (p1, 0), r1) & ((y < y0 + a.pocket_depth_mm) | (y > y1 - a.pocket_depth_mm))
    for at in on_circle(a.sector_screw_circle_mm / 2, [-150, -90, -30]):
        empty |= within(x, z, at, m3.clearance_hole_mm)
        empty |= within(x, z, at, m3.counterbore_diameter_mm) & (y < y0 + m3.counterbore_depth_mm)
    for at in on_circle(a.sector_screw_circle_mm / 2, [-120, -60]):
        empty |= within(x, z, at, 3.0)
    return material & ~empty


def sector(d: Dimensions, part: Part, x: Points, y: Points, z: Points) -> np.ndarray:
    c, a, (y0, y1) = d.capstan, d.arm, d.layers.sector_mm
    assert c is not None
    low, high = c.rim_angles_rad
    m3, tension = catalogue.screw("M3"), catalogue.screw("M2.5")
    radius, middle = np.hypot(x, z), (low + high) / 2
    angle = (np.arctan2(z, x) - middle + np.pi) % (2 * np.pi) - np.pi  # from the sector's middle
    half = (high - low) / 2
    under = c.lug_length_mm / c.rim_radius_mm
    inner = a.flange_radius_mm - 4
    flat = (radius >= inner) & (radius <= c.rim_radius_mm) & (np.abs(angle) <= half)
    flat |= (radius >= inner) & (radius <= c.lug_radii_mm[0] + 0.5) & (angle >= -half) & (angle <= half + under)
    flat |= (radius <= a.flange_radius_mm) & (z <= 0)
    flat |= radius <= a.shaft_bore_mm / 2 + 8.0
    empty = within(x, z, (0, 0), a.shaft_bore_mm)
    depth, tap = c.pitch_radius_mm - c.lug_radii_mm[0], tension.tap_drill_mm / 2
    # the upper end, seen along the radius through the nose's axis: out along it, aside from it away from the plate
    out, aside = x * np.cos(low) + z * np.sin(low), x * np.sin(low) - z * np.cos(low)
    top, cable = c.rim_radius_mm - 5.0, 5.0 + c.cable_diameter_mm / 2  # the nose's axis; the cable's line beside it
    flat |= np.hypot(out - top, aside) <= 5.0
    flat |= round_cone(out, aside, (inner, 0), cable - depth, (top, 0), cable - depth)
    beside, beyond = aside - cable, top - out
    lug = (beyond >= 0) & (beyond <= c.lug_length_mm)
    flat |= (beside >= -depth) & (beside <= c.lug_radii_mm[1] - c.pitch_radius_mm) & lug
    empty |= (np.hypot(beside, y - (y0 + y1) / 2) < tap) & (beyond > -0.5) & (beyond < c.lug_length_mm + 0.5)
    # the other end: the cable runs on along the rim's tangent
    out, along = x * np.cos(high) + z * np.sin(high), -x * np.sin(high) + z * np.cos(high)
    flat |= (out >= c.lug_radii_mm[0]) & (out <= c.lug_radii_mm[1]) & (along >= 0) & (along <= c.lug_length_mm)
    empty |= (np.hypot(out - c.pitch_radius_mm, y - (y0 + y1) / 2) < tap) & (along > -0.5)
    collar = (y >= y1) & (y <= d.layers.motor_cheek_mm[0]) & within(x, z, (0, 0), a.collar_diameter_mm)
    for at in on_circle(a.sector_screw_circle_mm / 2, [-150, -90, -30]):
        empty |= within(x, z, at, m3.tap_drill_mm)
    for at in on_circle(a.sector_screw_circle_mm / 2, [-120, -60]):
        empty |= within(x, z, at, 3.0)
    s0, s1 = c.slot_angles_rad
    slot = (np.abs(radius - c.slot_radius_mm) < c.slot_width_mm / 2) & (np.abs(angle) < (s1 - s0) / 2)
    empty |= slot
    for end in (s0, s1):
        at = (c.slot_radius_mm * float(np.cos(end)), c.slot_radius_mm * float(np.sin(end)))
        empty |= within(x, z, at, c.slot_width_mm)
    for point, _ in cylinders(part.solid, 7.0, concave=True):
        empty |= within(x, z, (point[0], point[2]), 7.0)
    return ((y >= y0) & (y <= y1) & flat | collar) & ~empty


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
        material |= plate & web
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


def rod_cup(d: Dimensions, _: Part, x: Points, y: Points, z: Points) -> np.ndarray:
    f, rod = d.forearm, d.tube.outer_mm / 2
    from_ball, seat = np.sqrt(x**2 + y**2 + z**2), d.design.hardware.ball_diameter_mm / 2 + 0.0075
    lip = seat * float(np.cos(np.radians(75.0)))
    material = (y >= lip) & (from_ball <= seat + 1.7)
    top, end = 0.8 * (seat + 1.7), f.shoulder_mm - 1.0
    gusset = (x >= 0) & (x <= end) & (y >= lip) & (y <= top + (rod - top) * x / end)
    material |= gusset & (np.abs(z) <= rod)
    material |= (x >= f.stem_mm) & (x <= f.shoulder_mm) & (np.maximum(np.abs(y), np.abs(z)) <= rod)
    tip = f.shoulder_mm + f.spigot_length_mm
    material |= (x >= f.shoulder_mm) & (x <= tip) & (np.hypot(y, z) <= (d.tube.inner_mm - 0.2) / 2)
    empty = from_ball < seat
    empty |= (np.hypot(x, z) < 0.75) & (y > 0) & (y < seat + 0.6)
    return material & ~empty


def rod_eye(d: Dimensions, _: Part, x: Points, y: Points, z: Points) -> np.ndarray:
    f, axis = d.forearm, np.hypot(y, z)
    around = f.eye_diameter_mm / 2 + 0.6
    material = (np.abs(x) <= 2.0) & (axis <= 3.7)
    material |= (np.abs(x) <= 1.0) & (np.abs(y + 0.8) <= around) & (z >= 0) & (z <= 5.5 + around)
    return material & (axis >= d.tube.outer_mm / 2 + 0.05) & (np.hypot(y + 0.8, z - 5.5) >= f.eye_diameter_mm / 2)


RULES: dict[str, Rule] = {"upper_arm": upper_arm, "sector": sector, "platform": platform}
RULES |= {"rod_cup": rod_cup, "rod_eye": rod_eye}


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
