"""The upper arm: a plain plate from its hub on the shoulder shaft to the boss around the cross-bar.

Arm's frame: origin in the shoulder, x to the elbow, y along the shoulder axis. No pockets and no slits where they are
not needed: what such a beam gives under load can be computed.
"""

from __future__ import annotations

from math import cos, sin

import cadquery as cq

from delta_cad import catalogue
from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.arm import CLAMP_SCREW, DOWEL_MM
from delta_cad.dimensions.tolerances import LENGTH_MM
from delta_cad.solids.making import cut_circle, made_part
from delta_cad.solids.materials import ORANGE, material
from delta_cad.solids.part import Hole, Part
from delta_cad.solids.primitive import (
    THROUGH_MM,
    bore_y,
    box,
    cut,
    cylinder,
    edge_break,
    feature,
    fuse,
    hull_along_y,
)

SHOULDER_SEAT_X_MM = -8.0  # seat of the clamp screw's head; its thread begins behind the slit
SHOULDER_THREAD_END_X_MM = 10.0
SHOULDER_SCREW_LENGTH_MM = 16.0


def polar_positions(radius: float, angles: tuple[float, ...]) -> list[tuple[float, float]]:
    """(x, z) of points on a circle about the shoulder."""
    return [(radius * cos(a), radius * sin(a)) for a in angles]


def dowel_positions(d: Dimensions) -> list[tuple[float, float]]:
    """(x, z) of the dowels between arm and sector."""
    return polar_positions(d.arm.dowel_circle_mm / 2, d.arm.dowel_angles_rad)


def make_upper_arm(d: Dimensions) -> Part:
    """Upper arm, milled from plate: clamped beside its sector along the shaft, or split around a motor's shaft."""
    number, a = "upper_arm", d.arm
    y, boss = d.layers.arm_mm, d.layers.elbow_boss_mm
    through = (boss[0] - THROUGH_MM, boss[1] + THROUGH_MM)
    length, bar = a.length_mm, a.bar_bore_mm

    def body() -> cq.Shape:
        beam = hull_along_y([(0.0, 0.0, a.beam_root_radius_mm), (length, 0.0, a.boss_radius_mm)], y)
        hub = bore_y(2 * a.flange_radius_mm, (0.0, 0.0), y)
        return fuse(beam, hub, bore_y(2 * a.boss_radius_mm, (length, 0.0), boss))

    shape = feature(number, "outline", "upper_arm_length_mm", body)
    shape = edge_break(number, shape, ">Y or <Y", 0.4)
    tools: list[cq.Shape] = [bore_y(bar, (length, 0.0), through)]
    fitted = "clamped along the shaft" if d.capstan is not None else f"split {a.slit_mm:g} mm"
    holes = [
        Hole(a.shaft_bore_mm, 1, f"{a.shaft_bore_mm:g} H7 through, {fitted}, shoulder"),
        Hole(bar, 1, f"{bar:g} +0.02 through, cross-bar bonded"),
    ]
    if d.capstan is not None:  # after the edges are broken: the collar's own carries the inner ring
        collar = d.layers.bearings_mm[0][1]
        shape = fuse(shape, bore_y(a.collar_diameter_mm, (0.0, 0.0), (collar, y[0] + THROUGH_MM)))
        tools.append(bore_y(a.shaft_bore_mm, (0.0, 0.0), (collar - THROUGH_MM, through[1])))
        tools += [bore_y(DOWEL_MM, at, through) for at in dowel_positions(d)]
        holes.append(Hole(DOWEL_MM, len(a.dowel_angles_rad), f"{DOWEL_MM:g} H7 through, sector dowels"))
        first, cut_off = min(collar, boss[0]), 0.0
    else:
        tools.append(bore_y(a.shaft_bore_mm, (0.0, 0.0), through))
        slit_tools, slit_holes = _clamp(d, through)
        tools += slit_tools
        holes += slit_holes
        first, cut_off = min(y[0], boss[0]), a.slit_mm / 2
    solid = feature(number, "bores", "arm_thickness_mm", lambda: cut(shape, tools))
    flange = max(a.flange_radius_mm, a.beam_root_radius_mm)
    extent = (-flange, length + a.boss_radius_mm), (first, max(y[1], boss[1])), (-flange, cut_circle(flange, cut_off))
    description = f"upper arm, {length:g} mm between axes"
    if d.capstan is not None:
        stack = y[1] - d.layers.bearings_mm[0][1]
        description += f", {stack:.3f} +-{LENGTH_MM:g} from its collar to the sector"
    return made_part(number, description, solid, material("aluminium-7075", ORANGE), extent, holes)


def _clamp(d: Dimensions, through: tuple[float, float]) -> tuple[list[cq.Shape], list[Hole]]:
    """Slit and screw that clamp the hub on a motor's shaft."""
    a, screw = d.arm, catalogue.screw(CLAMP_SCREW)
    z, outside, half = a.shoulder_clamp_z_mm, a.flange_radius_mm + THROUGH_MM, a.slit_mm / 2
    tools: list[cq.Shape] = [
        box((-half, through[0], 0.0), (half, through[1], outside)),
        cylinder(screw.clearance_hole_mm, (-outside, 0, z), (0, 0, z)),
        box((-outside, through[0], z - screw.counterbore_diameter_mm / 2), (SHOULDER_SEAT_X_MM, through[1], outside)),
        cylinder(screw.tap_drill_mm, (0, 0, z), (SHOULDER_THREAD_END_X_MM, 0, z)),
    ]
    holes = [
        Hole(
            screw.clearance_hole_mm,
            1,
            f"{screw.clearance_hole_mm:g} from the open seat at x = {SHOULDER_SEAT_X_MM:g}, shoulder clamp",
        ),
        Hole(screw.tap_drill_mm, 1, f"{CLAMP_SCREW} to x = {SHOULDER_THREAD_END_X_MM:g}"),
    ]
    return tools, holes
