"""Cross-bar, ball stud, socket and tube of the parallelogram."""

from __future__ import annotations

from math import sqrt

import cadquery as cq

from delta_cad import catalogue
from delta_cad.dimensions import Dimensions
from delta_cad.solids.fasteners import CORE_PLAY_MM
from delta_cad.solids.making import cut_circle, made_part, ordered, round_y
from delta_cad.solids.materials import BLUE, material
from delta_cad.solids.part import Hole, Part
from delta_cad.solids.primitive import THROUGH_MM, ball, bevelled, bore_y, box, cut, cylinder, feature, fuse, stepped

STUD_THREAD = "M3"
EDGE_MM = 0.3


def make_cross_bar(d: Dimensions) -> Part:
    """Bar through the elbow boss, tapped at both ends; centred, along y."""
    number, f = "cross_bar", d.forearm
    r, half = f.bar_diameter_mm / 2, f.bar_length_mm / 2
    drill = catalogue.screw(STUD_THREAD).tap_drill_mm
    bar = bevelled(r, (-half, half), EDGE_MM)
    depth = f.bar_thread_depth_mm
    tools = [
        bore_y(drill, (0.0, 0.0), (-half - THROUGH_MM, -half + depth)),
        bore_y(drill, (0.0, 0.0), (half - depth, half + THROUGH_MM)),
    ]
    hole = Hole(drill, 1, f"{STUD_THREAD} x {depth:g} in both ends, on one axis")
    solid = feature(number, "threads", "parallelogram_width_mm", lambda: cut(bar, tools))
    description = f"cross-bar {f.bar_diameter_mm:g} h6 x {f.bar_length_mm:g}"
    return made_part(number, description, solid, material("aluminium-7075"), round_y(r, (-half, half)), [hole])


def make_ball_stud(d: Dimensions) -> Part:
    """Ball stud: ball centre at the origin, thread along +y."""
    number, f = "ball_stud", d.forearm
    radius, neck, collar = f.ball_diameter_mm / 2, f.neck_diameter_mm / 2, f.collar_diameter_mm / 2
    core = (catalogue.screw(STUD_THREAD).tap_drill_mm - CORE_PLAY_MM) / 2
    seat, end = f.stand_off_mm, f.stand_off_mm + f.stud_thread_length_mm
    inside = sqrt(radius**2 - neck**2) - 0.5
    below = seat - f.collar_length_mm
    shank = stepped((neck, inside, below), (collar, below, seat), (core, seat, end))
    sphere = ball(f.ball_diameter_mm, (0.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    solid = feature(number, "ball", "hardware.ball_diameter_mm", lambda: sphere.fuse(shank))
    flats = [box((-10.0, below - 0.01, z), (10.0, seat + 0.01, z + 5.0)) for z in (2.25, -7.25)]
    solid = feature(number, "spanner flats", "collar", lambda: cut(solid, flats))
    description = (
        f"ball stud {f.ball_diameter_mm:g} h6 polished, {STUD_THREAD} x {f.stud_thread_length_mm:g}, flats 4.5"
    )
    wide = max(radius, collar)
    extent = (-wide, wide), (-radius, end), (-radius, radius)
    return made_part(number, description, solid, material("stainless-1.4305"), extent)


def make_socket(d: Dimensions) -> Part:
    """Ring socket of a rod: seat centre at the origin, ring axis y, spigot along +x; slit so that the ball snaps in."""
    number, f = "ball_socket", d.forearm
    half, outer = f.socket_width_mm / 2, f.socket_outer_mm / 2
    neck = f.tube_outer_mm

    def body() -> cq.Shape:
        ring = bevelled(outer, (-half, half), 0.6)
        stem = cylinder(min(neck, f.socket_width_mm), (outer - 2.0, 0, 0), (f.shoulder_mm - 1.0, 0, 0))
        collar = cylinder(neck, (f.shoulder_mm - 1.0, 0, 0), (f.shoulder_mm, 0, 0))
        spigot = cylinder(f.spigot_diameter_mm, (f.shoulder_mm, 0, 0), (f.shoulder_mm + f.spigot_length_mm, 0, 0))
        return fuse(ring, stem, collar, spigot)

    shape = feature(number, "body", "hardware.ball_diameter_mm", body)
    tools = [
        ball(f.seat_diameter_mm, (0.0, 0.0, 0.0), (0.0, 1.0, 0.0)),
        box((-outer - 1.0, -half - 1.0, -f.socket_slit_mm / 2), (0.0, half + 1.0, f.socket_slit_mm / 2)),
    ]
    solid = feature(number, "seat", "hardware.ball_diameter_mm", lambda: cut(shape, tools))
    description = f"ball socket, spherical seat {f.seat_diameter_mm:.2f}, spigot {f.spigot_diameter_mm:g}"
    x = (-cut_circle(outer, f.socket_slit_mm / 2), f.shoulder_mm + f.spigot_length_mm)
    wide, high = max(half, neck / 2), max(outer, neck / 2)
    extent = x, (-wide, wide), (-high, high)
    return made_part(number, description, solid, material("pom-c", BLUE), extent)


def make_rod_tube(d: Dimensions) -> Part:
    """Tube of a rod, cut to length; along x from the origin."""
    number, f = "rod_tube", d.forearm
    tube = cylinder(f.tube_outer_mm, (0, 0, 0), (f.tube_length_mm, 0, 0))
    bore = cylinder(f.tube_bore_mm, (-THROUGH_MM, 0, 0), (f.tube_length_mm + THROUGH_MM, 0, 0))
    row, hole = d.tube, Hole(f.tube_bore_mm, 1, f"{f.tube_bore_mm:g} through, as bought")
    length = f"cut {f.tube_length_mm:.2f}; bond in a jig to {f.length_mm:.3f} between seat centres"
    description = f"{row.description}, {length}"
    across = (-f.tube_outer_mm / 2, f.tube_outer_mm / 2)
    extent = (0.0, f.tube_length_mm), across, across
    return made_part(number, description, cut(tube, [bore]), material(row.material), extent, [hole], **ordered(row))
