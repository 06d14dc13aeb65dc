"""Sector, pinion, cable and tension screw of the capstan (arm's frame; the pinion in its own, y along its axis)."""

from __future__ import annotations

from dataclasses import replace
from math import cos, pi, sin

import cadquery as cq
import numpy as np

from delta_cad import catalogue
from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.capstan import CapstanDimensions
from delta_cad.mechanism.placement import frames
from delta_cad.solids.making import bought_part, made_part, round_y, round_z
from delta_cad.solids.materials import material
from delta_cad.solids.part import Hole, Part
from delta_cad.solids.primitive import (
    THROUGH_MM,
    bevelled,
    bore_y,
    cut,
    cylinder,
    feature,
    fuse,
    hull_along_y,
    one_solid,
    ring_segment,
)
from delta_cad.solids.upper_arm import DOWEL_MM, SECTOR_SCREW, polar_positions

TENSION_SCREW = "M2.5"
TENSION_SCREW_LENGTH_MM = 8.0
TENSION_TRAVEL_MM = 3.0  # by which a screw can be turned out: stretch and settling of the cable
TENSION_SCREW_OUT_MM = 2.0  # room for the lock nut; drawn with the screw as far in as it goes
CABLE_BORE_MM = 0.8
CRIMP_MM = (1.8, 3.0)  # diameter and length of the sleeve crimped on the cable
BARE_END_MM = 40.0  # cable to pull by before the sleeve is crimped and the rest cut off
LIGHTENING_MM = 7.0


def capstan_of(d: Dimensions) -> CapstanDimensions:
    """Capstan of a design that has one."""
    if d.capstan is None:
        raise ValueError("hardware.drive = direct: the design has no capstan")
    return d.capstan


def rim_end(d: Dimensions, end: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Locates where the cable leaves the sector: point, tangent and normal away from it, each (3,) in the arm's frame.

    Args:
        d: Dimensions with a capstan.
        end: 0 for the smaller polar angle, where the cable has turned inwards round the nose; 1 for the larger.
    """
    c = capstan_of(d)
    sense = 1.0 if end else -1.0
    angle = c.rim_angles_rad[end] + sense * c.turns_rad[end]
    normal = np.array([cos(angle), 0.0, sin(angle)])
    tangent = sense * np.array([-sin(angle), 0.0, cos(angle)])
    middle = np.array([0.0, sum(d.layers.sector_mm) / 2, 0.0])
    if end:
        return middle + c.pitch_radius_mm * normal, tangent, normal
    x, z = c.nose_centre_mm
    nose = np.array([x, 0.0, z]) + (c.nose_radius_mm + c.cable_diameter_mm / 2) * normal
    return middle + nose, tangent, normal


def tension_screw_frame(d: Dimensions, end: int) -> np.ndarray:
    """(4, 4) frame under the head of a tension screw in the arm's frame; z points from shank to head."""
    point, tangent, radial = rim_end(d, end)
    seat = point + (capstan_of(d).lug_length_mm + TENSION_SCREW_OUT_MM) * tangent
    return frames(radial, np.cross(tangent, radial), seat)


def lightening(c: CapstanDimensions) -> list[tuple[float, float]]:
    """(x, z) of the lightening holes between slot and rim, as many as leave walls of 2 mm."""
    low = c.slot_radius_mm + c.slot_width_mm / 2 + 2.0
    high = c.rim_radius_mm - 2.0
    if high - low < LIGHTENING_MM:
        return []
    radius = (low + high) / 2
    first, last = (c.rim_angles_rad[0] + 6.0 / radius, c.rim_angles_rad[1] - 6.0 / radius)
    count = int((last - first) * radius / (LIGHTENING_MM + 4.0))
    step = (last - first) / max(count, 1)
    return polar_positions(radius, tuple(first + (k + 0.5) * step for k in range(count)))


def make_sector(d: Dimensions) -> Part:
    """Sector bolted to the arm: rim and nose for the cable, lugs for the tension screws, slot around the stop pin."""
    number, c, a, y = "sector", capstan_of(d), d.arm, d.layers.sector_mm
    inner = a.flange_radius_mm - 4.0
    low, high = c.rim_angles_rad
    under = c.lug_length_mm / c.rim_radius_mm  # the plate goes on under the lug
    screw = catalogue.hex_screw(TENSION_SCREW)

    def body() -> cq.Shape:
        plate = ring_segment(inner, c.rim_radius_mm, (low, high), y)
        support = ring_segment(inner, c.lug_radii_mm[0] + 0.5, (low, high + under), y)
        x, z = c.nose_centre_mm
        share = inner / (c.rim_radius_mm - c.nose_radius_mm)
        bar = [(x, z, c.nose_bar_radius_mm), (share * x, share * z, c.nose_bar_radius_mm)]
        nose = fuse(bore_y(2 * c.nose_radius_mm, (x, z), y), hull_along_y(bar, y))
        hub = bore_y(2 * c.hub_radius_mm, (0.0, 0.0), y)
        seat = ring_segment(c.hub_radius_mm - 1.0, a.flange_radius_mm, (-pi, 0.0), y)
        collar = bore_y(a.collar_diameter_mm, (0.0, 0.0), (y[1] - THROUGH_MM, d.layers.motor_cheek_mm[0]))
        lugs = []
        for end in range(2):
            point, tangent, radial = rim_end(d, end)
            foot = point - c.pitch_radius_mm * radial
            corners = [
                foot + r * radial + s * tangent
                for r, s in (
                    (c.lug_radii_mm[0], 0.0),
                    (c.lug_radii_mm[1], 0.0),
                    (c.lug_radii_mm[1], c.lug_length_mm),
                    (c.lug_radii_mm[0], c.lug_length_mm),
                )
            ]
            lugs.append(hull_along_y([(float(p[0]), float(p[2]), 0.0) for p in corners], y))
        return fuse(plate, support, nose, hub, seat, collar, *lugs)

    shape = feature(number, "outline", "hardware.sector_radius_mm", body)
    through = (y[0] - THROUGH_MM, d.layers.motor_cheek_mm[0] + THROUGH_MM)
    thread = catalogue.screw(SECTOR_SCREW)
    seats = polar_positions(a.sector_screw_circle_mm / 2, a.sector_screw_angles_rad)
    pins = polar_positions(a.sector_screw_circle_mm / 2, a.sector_dowel_angles_rad)
    tools: list[cq.Shape] = [bore_y(a.shaft_bore_mm, (0.0, 0.0), through)]
    tools += [bore_y(thread.tap_drill_mm, at, through) for at in seats]
    tools += [bore_y(DOWEL_MM, at, through) for at in pins]
    half = c.slot_width_mm / 2
    tools.append(ring_segment(c.slot_radius_mm - half, c.slot_radius_mm + half, c.slot_angles_rad, through))
    tools += [bore_y(c.slot_width_mm, at, through) for at in polar_positions(c.slot_radius_mm, c.slot_angles_rad)]
    lights = lightening(c)
    tools += [bore_y(LIGHTENING_MM, at, through) for at in lights]
    for end in range(2):
        point, tangent, _ = rim_end(d, end)
        outer = point + (c.lug_length_mm + THROUGH_MM) * tangent
        tools.append(cylinder(screw.tap_drill_mm, tuple(point - THROUGH_MM * tangent), tuple(outer)))
    solid = feature(number, "slot and bores", "shoulder angle range", lambda: cut(shape, tools))
    holes = (
        Hole(a.shaft_bore_mm, 1, f"{a.shaft_bore_mm:g} G7 through, on the shoulder shaft"),
        Hole(thread.tap_drill_mm, len(seats), f"{SECTOR_SCREW} through, to the arm"),
        Hole(DOWEL_MM, len(pins), f"{DOWEL_MM:g} H7 through, dowels"),
        Hole(c.slot_width_mm, 2, f"arc slot {c.slot_width_mm:g} wide on radius {c.slot_radius_mm:g}, both ends"),
        Hole(screw.tap_drill_mm, 2, f"{TENSION_SCREW} through the lugs, tangential"),
        *([Hole(LIGHTENING_MM, len(lights), f"{LIGHTENING_MM:g} through, lightening")] if lights else []),
    )
    description = f"capstan sector, rim radius {c.rim_radius_mm:g}, ratio {c.ratio:g}:1"
    extent = None, (y[0], d.layers.motor_cheek_mm[0]), None
    return made_part(number, description, solid, material("aluminium-7075"), extent, holes)


def make_pinion(d: Dimensions) -> Part:
    """Steel sleeve bonded on the motor's shaft; the helical groove is a callout, as threads are."""
    number, c = "pinion", capstan_of(d)
    y0, y1 = c.pinion_y_mm
    sleeve = bevelled(c.pinion_radius_mm, (y0, y1), 0.3)
    floor = y1 - c.pinion_bore_depth_mm
    bore = bore_y(c.pinion_bore_mm, (0.0, 0.0), (floor if floor > y0 else y0 - THROUGH_MM, y1 + THROUGH_MM))
    solid = feature(number, "bore", "motor shaft", lambda: cut(sleeve, [bore]))
    d_c = c.cable_diameter_mm
    depth = c.pinion_radius_mm - c.pinion_pitch_radius_mm + d_c / 2
    description = f"capstan pinion, helical groove R{d_c / 2:.2f} x {depth:.2f} deep, pitch {1.4 * d_c:.2f}"
    callout = f"{c.pinion_bore_mm:g} H7 x {c.pinion_bore_depth_mm:.1f}, bonded on the motor's shaft"
    hole, extent = Hole(c.pinion_bore_mm, 1, callout), round_y(c.pinion_radius_mm, c.pinion_y_mm)
    return made_part(number, description, solid, material("stainless-1.4305"), extent, [hole])


def make_cable(d: Dimensions) -> Part:
    """The cable where it lies on the rim and in the lugs; its turns on the pinion are in the cut length only."""
    number, c = "capstan_cable", capstan_of(d)
    (p0, t0, _), (p1, t1, _) = rim_end(d, 0), rim_end(d, 1)
    beyond = c.lug_length_mm + TENSION_SCREW_OUT_MM + catalogue.hex_screw(TENSION_SCREW).head_height_mm + CRIMP_MM[1]
    y = sum(d.layers.sector_mm) / 2
    middle = sum(c.rim_angles_rad) / 2
    top = cq.Vector(c.pitch_radius_mm * cos(middle), y, c.pitch_radius_mm * sin(middle))

    def on_nose(turned_by: float) -> cq.Vector:
        (x, z), angle = c.nose_centre_mm, c.rim_angles_rad[0] - turned_by
        radius = c.nose_radius_mm + c.cable_diameter_mm / 2
        return cq.Vector(x + radius * cos(angle), y, z + radius * sin(angle))

    def body() -> cq.Shape:
        start = cq.Vector(*(p0 + beyond * t0))
        path = cq.Wire.assembleEdges(
            [
                cq.Edge.makeLine(start, cq.Vector(*p0)),
                cq.Edge.makeThreePointArc(cq.Vector(*p0), on_nose(c.turns_rad[0] / 2), on_nose(0.0)),
                cq.Edge.makeThreePointArc(on_nose(0.0), top, cq.Vector(*p1)),
                cq.Edge.makeLine(cq.Vector(*p1), cq.Vector(*(p1 + beyond * t1))),
            ]
        )
        profile = cq.Wire.makeCircle(c.cable_diameter_mm / 2, start, cq.Vector(*(-t0)))
        return cq.Solid.sweep(profile, [], path, True, True)

    solid, mass_g = feature(number, "sweep", "hardware.cable", body), d.cable.mass_g_m * c.cable_length_mm / 1000.0
    ends = f"{d.cable.description}, cut {c.cable_length_mm + BARE_END_MM:.0f} mm, bare ends; crimp on the machine"
    extent = None, (y - c.cable_diameter_mm / 2, y + c.cable_diameter_mm / 2), None
    return replace(bought_part(number, d.cable, solid, "stainless-1.4305", extent, mass_g), description=ends)


def make_crimp_sleeve(d: Dimensions) -> Part:
    """Sleeve crimped on the cable behind a tension screw's head; along z from the head."""
    c, number = capstan_of(d), "crimp_sleeve"
    outer, length = CRIMP_MM
    sleeve = cylinder(outer, (0, 0, 0), (0, 0, length))
    bore = cylinder(c.cable_diameter_mm, (0, 0, -THROUGH_MM), (0, 0, length + THROUGH_MM))
    return Part(
        number,
        f"crimp sleeve {outer:g} x {length:g} for {c.cable_diameter_mm:g} mm cable",
        one_solid(cut(sleeve, [bore]), number),
        material("brass"),
        False,
        (Hole(c.cable_diameter_mm, 1, f"{c.cable_diameter_mm:g} through, crimped"),),
        extent_mm=round_z(outer / 2, (0.0, length)),
        order_code=f"crimp sleeve for {c.cable_diameter_mm:g} mm wire rope",
        source="usual size for wire rope as thin; verified: no, from memory, check before ordering",
    )
