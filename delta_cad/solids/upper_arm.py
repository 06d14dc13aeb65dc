"""The upper arm: split clamp on the shoulder shaft, I-section beam, split boss around the cross-bar.

Arm's frame: origin in the shoulder, x to the elbow, y along the shoulder axis.
"""

from __future__ import annotations

from math import cos, sin

import cadquery as cq

from delta_cad import catalogue
from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.arm import ELBOW_SCREW
from delta_cad.solids.making import cut_circle, made_part
from delta_cad.solids.materials import ORANGE, material
from delta_cad.solids.part import Hole, Part
from delta_cad.solids.primitive import (
    THROUGH_MM,
    bore_y,
    bore_z,
    box,
    cut,
    cylinder,
    edge_break,
    feature,
    fuse,
    hull_along_y,
)

SHOULDER_SCREW, SECTOR_SCREW = "M3", "M3"
DOWEL_MM = 3.0
SHOULDER_SEAT_X_MM = -8.0  # seat of the clamp screw's head; its thread begins behind the slit
SHOULDER_THREAD_END_X_MM = 10.0
SHOULDER_SCREW_LENGTH_MM = 16.0
ELBOW_SEAT_Z_MM = 3.5
ELBOW_SCREW_LENGTH_MM = 8.0


def polar_positions(radius: float, angles: tuple[float, ...]) -> list[tuple[float, float]]:
    """(x, z) of points on a circle about the shoulder."""
    return [(radius * cos(a), radius * sin(a)) for a in angles]


def make_upper_arm(d: Dimensions) -> Part:
    """Upper arm, milled from plate; with a capstan it carries the sector's screws and dowels."""
    number, a = "upper_arm", d.arm
    y, boss = d.layers.arm_mm, d.layers.elbow_boss_mm
    through = (boss[0] - THROUGH_MM, boss[1] + THROUGH_MM)
    length, bar = a.length_mm, a.bar_bore_mm

    def body() -> cq.Shape:
        beam = hull_along_y([(0.0, 0.0, a.beam_root_radius_mm), (length, 0.0, a.boss_radius_mm)], y)
        flange = bore_y(2 * a.flange_radius_mm, (0.0, 0.0), y)
        return fuse(beam, flange, bore_y(2 * a.boss_radius_mm, (length, 0.0), boss))

    shape = feature(number, "outline", "upper_arm_length_mm", body)
    shape = edge_break(number, shape, ">Y or <Y", 0.4)
    if d.capstan is not None:  # after the edges are broken: the collar's own carries the inner ring
        shape = fuse(shape, bore_y(a.collar_diameter_mm, (0.0, 0.0), (d.layers.encoder_cheek_mm[1], y[0] + THROUGH_MM)))
    clamp, grip = catalogue.screw(SHOULDER_SCREW), catalogue.screw(ELBOW_SCREW)
    z, x = a.shoulder_clamp_z_mm, a.elbow_clamp_x_mm
    outside, half = a.flange_radius_mm + THROUGH_MM, a.slit_mm / 2
    tools: list[cq.Shape] = [
        bore_y(a.shaft_bore_mm, (0.0, 0.0), through),
        bore_y(bar, (length, 0.0), through),
        box((-half, through[0], 0.0), (half, through[1], outside)),
        cylinder(clamp.clearance_hole_mm, (-outside, 0, z), (0, 0, z)),
        box((-outside, through[0], z - clamp.counterbore_diameter_mm / 2), (SHOULDER_SEAT_X_MM, through[1], outside)),
        cylinder(clamp.tap_drill_mm, (0, 0, z), (SHOULDER_THREAD_END_X_MM, 0, z)),
        box((a.elbow_slit_x_mm, through[0], -half), (length + a.boss_radius_mm + THROUGH_MM, through[1], half)),
        bore_y(2.5, (a.elbow_slit_x_mm, 0.0), through),
        bore_z(grip.clearance_hole_mm, (x, 0.0), (0.0, a.beam_root_radius_mm)),
        bore_z(grip.counterbore_diameter_mm, (x, 0.0), (ELBOW_SEAT_Z_MM, a.beam_root_radius_mm)),
        bore_z(grip.tap_drill_mm, (x, 0.0), (-a.beam_root_radius_mm, 0.0)),
    ]
    r0, r1 = a.pocket_radii_mm
    pocket = [(a.pocket_x_mm[0], 0.0, r0), (a.pocket_x_mm[1], 0.0, r1)]
    tools.append(hull_along_y(pocket, (y[0] - THROUGH_MM, y[0] + a.pocket_depth_mm)))
    tools.append(hull_along_y(pocket, (y[1] - a.pocket_depth_mm, y[1] + THROUGH_MM)))
    holes = [
        Hole(a.shaft_bore_mm, 1, f"{a.shaft_bore_mm:g} H7 through, split 1 mm, shoulder shaft"),
        Hole(bar, 1, f"{bar:g} H7 through, split 1 mm to the end, cross-bar"),
        Hole(
            clamp.clearance_hole_mm,
            1,
            f"{clamp.clearance_hole_mm:g} from the open seat at x = {SHOULDER_SEAT_X_MM:g}, shoulder clamp",
        ),
        Hole(clamp.tap_drill_mm, 1, f"{SHOULDER_SCREW} to x = {SHOULDER_THREAD_END_X_MM:g}"),
        Hole(grip.clearance_hole_mm, 1, f"{grip.clearance_hole_mm:g}, elbow clamp screw"),
        Hole(grip.counterbore_diameter_mm, 1, f"counterbore to z = {ELBOW_SEAT_Z_MM:g}"),
        Hole(grip.tap_drill_mm, 1, f"{ELBOW_SCREW} through the lower half"),
        Hole(2.5, 1, "2.5 through, end of the elbow slit"),
    ]
    if d.capstan is not None:
        screw = catalogue.screw(SECTOR_SCREW)
        seats = polar_positions(a.sector_screw_circle_mm / 2, a.sector_screw_angles_rad)
        pins = polar_positions(a.sector_screw_circle_mm / 2, a.sector_dowel_angles_rad)
        floor = (y[0] - THROUGH_MM, y[0] + screw.counterbore_depth_mm)
        tools += [bore_y(screw.clearance_hole_mm, at, through) for at in seats]
        tools += [bore_y(screw.counterbore_diameter_mm, at, floor) for at in seats]
        tools += [bore_y(DOWEL_MM, at, through) for at in pins]
        holes += [
            Hole(screw.clearance_hole_mm, len(seats), f"{screw.clearance_hole_mm:g} through, sector screws"),
            Hole(screw.counterbore_diameter_mm, len(seats), f"counterbore {screw.counterbore_depth_mm:g} deep"),
            Hole(DOWEL_MM, len(pins), f"{DOWEL_MM:g} H7 through, sector dowels"),
        ]
    solid = feature(number, "bores", "arm_thickness_mm", lambda: cut(shape, tools))
    description = f"upper arm, {length:g} mm between axes"
    flange = max(a.flange_radius_mm, a.beam_root_radius_mm)
    first = min(y[0], boss[0], d.layers.encoder_cheek_mm[1]) if d.capstan is not None else min(y[0], boss[0])
    across = first, max(y[1], boss[1])
    extent = (-flange, length + cut_circle(a.boss_radius_mm, half)), across, (-flange, cut_circle(flange, half))
    return made_part(number, description, solid, material("aluminium-7075", ORANGE), extent, holes)
