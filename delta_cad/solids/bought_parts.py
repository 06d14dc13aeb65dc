"""Bought parts as their makers draw them from outside; a screw's origin lies under its head, z from shank to head."""

from __future__ import annotations

from dataclasses import replace
from math import cos, hypot, pi, sin
from typing import Literal, cast

import cadquery as cq
import numpy as np

from delta_cad import catalogue
from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.forearm import BALL_GLUE_MM, EYE_WALL_MM, ForearmDimensions
from delta_cad.dimensions.layers import motor_thread_mm
from delta_cad.dimensions.tolerances import (
    BALL_CENTRE_MM,
    BOARD_ZONE_MM,
    CHIP_PLACE_MM,
    EROSION_UM,
    preload_range_N,
    spring_height_mm,
)
from delta_cad.mechanism.geometry import SIN_60
from delta_cad.solids.boring import Boring, along_y, along_z, blind, placed, within
from delta_cad.solids.making import bought_part, made_part, material, ordered, round_y, round_z
from delta_cad.solids.part import Hole, Part
from delta_cad.solids.primitive import THROUGH_MM, ball, bore_y, bore_z, box, cut, cylinder, feature, fuse, turned

CORE_PLAY_MM = 0.04  # the shank is drawn as its thread's core, free of the tap drill by this diameter


def make_cap_screw(row: catalogue.Screw, length_mm: float) -> Part:
    """Hexagon socket head cap screw; the thread is drawn as its core."""
    _require_stock(f"screw {row.id}", length_mm, row.lengths_mm)
    head = cylinder(row.head_diameter_mm, (0, 0, 0), (0, 0, row.head_height_mm))
    shank = cylinder(row.tap_drill_mm - CORE_PLAY_MM, (0, 0, -length_mm), (0, 0, THROUGH_MM))
    key = _hexagon(row.socket_mm, (row.head_height_mm - row.socket_depth_mm, row.head_height_mm + THROUGH_MM))
    solid = cut(head.fuse(shank), [key])
    extent, x = round_z(row.head_diameter_mm / 2, (-length_mm, row.head_height_mm)), f"x{length_mm:g}"
    return bought_part(f"screw_{row.id}{x}", row, solid, "stainless-1.4305", extent, size=f" x {length_mm:g}")


def _require_stock(name: str, length_mm: float, lengths_mm: tuple[float, ...]) -> None:
    if length_mm not in lengths_mm:
        stock = ", ".join(f"{v:g}" for v in lengths_mm)
        raise ValueError(f"{name} x {length_mm:g}: stock lengths are {stock}")


def _hexagon(across_flats_mm: float, z: tuple[float, float]) -> cq.Shape:
    """Hexagonal prism along z, corners on the x axis."""
    plane = cq.Workplane("XY", origin=(0, 0, z[0]))
    return plane.polygon(6, across_flats_mm / SIN_60).extrude(z[1] - z[0]).val()  # type: ignore[return-value]


def make_tension_screw(size: str, length_mm: float) -> Part:
    """Cap screw that pulls the cable's carriage: nothing lies between its head's seat and its thread."""
    return replace(make_cap_screw(catalogue.screw(size), length_mm), number=f"tension_screw_{size}x{length_mm:g}")


def make_set_screw(size: str, length_mm: float) -> Part:
    """Hexagon socket set screw along z, its socket's end at the origin; the thread is drawn as its core."""
    row = catalogue.set_screw(size)
    _require_stock(f"set screw {size}", length_mm, row.lengths_mm)
    core = row.tap_drill_mm - CORE_PLAY_MM
    key = _hexagon(row.socket_mm, (-length_mm / 2, THROUGH_MM))
    solid = cut(cylinder(core, (0, 0, -length_mm), (0, 0, 0)), [key])
    number, extent = f"set_screw_{size}x{length_mm:g}", round_z(core / 2, (-length_mm, 0.0))
    return bought_part(number, row, solid, "stainless-1.4305", extent, size=f" x {length_mm:g}")


def make_dowel(key: str, length_mm: float) -> Part:
    """Parallel pin along z from 0 to its length."""
    row = catalogue.dowel(key)
    _require_stock(f"dowel {key}", length_mm, row.lengths_mm)
    pin = cylinder(row.diameter_mm, (0, 0, 0), (0, 0, length_mm))
    number, extent = f"dowel_{row.diameter_mm:g}x{length_mm:g}", round_z(row.diameter_mm / 2, (0.0, length_mm))
    return bought_part(number, row, pin, "steel", extent, size=f" x {length_mm:g}")


def make_spacer(
    bore_mm: float,
    length_mm: float,
    number: str = "board_spacer",
    substance: str = "brass",
    wider_mm: float = 2.0,
    where: str = "under the encoder board",
) -> Part:
    """Turned distance sleeve along z from 0 to its length, wider than its bore by `wider_mm`."""
    outer = bore_mm + wider_mm
    boring = Boring()
    boring.add(f"{bore_mm:g} through", [along_z(bore_mm, (0.0, 0.0), (0.0, length_mm))])
    solid = cut(cylinder(outer, (0, 0, 0), (0, 0, length_mm)), boring.tools)
    description = f"spacer {outer:g}/{bore_mm:g} x {length_mm:g} {where}"
    extent = round_z(outer / 2, (0.0, length_mm))
    return made_part(number, description, solid, material(substance), extent, boring.holes)


def make_board_spacer(d: Dimensions) -> Part:
    """Spacer under the encoder's board, along z from 0."""
    length = d.layers.encoder_head_mm[0] - d.layers.encoder_board_mm[1]
    if (row := d.board_spacer) is not None:
        return make_stock_spacer("board_spacer", row, length)
    return make_spacer(d.board_spacer_mm[1], length)


def make_stock_spacer(number: str, row: catalogue.Spacer, length_mm: float, along: Literal["y", "z"] = "z") -> Part:
    """Spacer of the catalogue along an axis, from 0 to its length."""
    _require_stock(f"spacer {row.id}", length_mm, row.lengths_mm)
    tube, reach = (bore_y, round_y) if along == "y" else (bore_z, round_z)
    sleeve, out = (0.0, length_mm), (-THROUGH_MM, length_mm + THROUGH_MM)
    solid = cut(tube(row.outer_mm, (0.0, 0.0), sleeve), [tube(row.inner_mm, (0.0, 0.0), out)])
    extent, holes = reach(row.outer_mm / 2, sleeve), (Hole(row.inner_mm, 1, "bore"),)
    return bought_part(number, row, solid, row.material, extent, size=f" x {length_mm:g}", holes=holes)


_STEEL_G_MM3 = 7.9e-3


def make_bearing(d: Dimensions) -> Part:
    """Bearing along y from 0 to its width: both rings and the shields between them, drawn as one body."""
    b = d.bearing
    bore, outer = b.bore_mm / 2, b.outer_mm / 2
    inner_edge, outer_edge = b.inner_ring_outer_mm / 2, b.outer_ring_inner_mm / 2
    w, sunk = b.width_mm, 0.4
    ring = [
        (bore, 0.0),
        (inner_edge, 0.0),
        (inner_edge, sunk),
        (outer_edge, sunk),
        (outer_edge, 0.0),
        (outer, 0.0),
        (outer, w),
        (outer_edge, w),
        (outer_edge, w - sunk),
        (inner_edge, w - sunk),
        (inner_edge, w),
        (bore, w),
    ]
    shape = feature("bearing", "rings", "hardware.bearing", lambda: turned(ring))
    holes = Hole(b.bore_mm, 1, "bore"), Hole(b.outer_ring_inner_mm, 1, "inside of the outer ring")
    return bought_part("bearing", b, shape, "steel", round_y(outer, (0.0, w)), b.mass_g, holes=holes)


def make_wave_spring(d: Dimensions) -> Part:
    """Wave spring along y from 0 to its working height, drawn as the ring between which it waves."""
    row = d.preload
    assert row is not None
    height, outer = row.work_height_mm, row.outer_mm

    def ring() -> cq.Shape:
        inside = bore_y(row.inner_mm, (0.0, 0.0), (-THROUGH_MM, height + THROUGH_MM))
        return cut(bore_y(outer, (0.0, 0.0), (0.0, height)), [inside])

    shape = feature("wave_spring", "ring", "hardware.bearing", ring)
    mass = pi / 4 * (outer**2 - row.inner_mm**2) * row.thickness_mm * _STEEL_G_MM3
    holes = (Hole(row.inner_mm, 1, "inside"),)
    extent = round_y(outer / 2, (0.0, height))
    (low, high), (least, most) = spring_height_mm(row), preload_range_N(row)
    at = f", {least:.1f} to {most:.1f} N at {high:.2f} to {low:.2f} mm in its seat"
    part = bought_part("wave_spring", row, shape, "spring-strip", extent, mass, holes=holes)
    return replace(part, description=part.description + at)


def make_motor(d: Dimensions) -> Part:
    """Motor: mounting face at the origin, body along +y, shaft along -y."""
    m = d.motor
    r, tail = m.diameter_mm / 2, min(4.0, m.length_mm / 6)
    body = turned(
        [
            (0.0, -m.pilot_height_mm),
            (m.pilot_diameter_mm / 2, -m.pilot_height_mm),
            (m.pilot_diameter_mm / 2, 0.0),
            (r - 0.5, 0.0),
            (r, 0.5),
            (r, m.length_mm - tail),
            (r - 2.0, m.length_mm - tail),
            (r - 2.0, m.length_mm),
            (0.0, m.length_mm),
        ]
    )
    shaft = bore_y(m.shaft_diameter_mm, (0.0, 0.0), (-m.shaft_length_mm, 0.0))
    drill = m.mount_screw.tap_drill_mm
    tools = []
    for angle in d.bracket.motor_holes_rad:
        at = (m.mount_circle_mm / 2 * cos(angle), m.mount_circle_mm / 2 * sin(angle))
        tools.append(bore_y(drill, at, (-THROUGH_MM, motor_thread_mm(m))))
    shape = feature("motor", "body", "hardware.motor", lambda: cut(fuse(body, shaft), tools))
    extent = round_y(r, (-m.shaft_length_mm, m.length_mm))
    screwed, thread = len(d.bracket.motor_screws_rad), f"{m.mount_thread} x {motor_thread_mm(m):g}, mounting"
    empty = m.mount_count - screwed
    callout = f"{screwed}x {thread}; {empty}x without a screw, {thread}" if empty else thread
    threads = Hole(drill, m.mount_count, callout)
    return bought_part("motor", m, shape, "aluminium-black", extent, m.mass_g, holes=(threads,))


def make_encoder_board(d: Dimensions) -> Part:
    """Encoder board: chip side towards +y, board from y = -thickness to 0, chip over the origin."""
    e = d.encoder
    half_x, half_z = e.board_length_mm / 2, e.board_width_mm / 2
    board = box((-half_x, -e.board_thickness_mm, -half_z), (half_x, 0.0, half_z))
    chip = box((-2.2, -THROUGH_MM, -2.5), (2.2, e.chip_height_mm, 2.5))
    plug = box((half_x - 5.0, -e.board_thickness_mm - 4.0, -5.0), (half_x - 1.0, -e.board_thickness_mm + 0.2, 5.0))
    way = (0.0, -e.board_thickness_mm)
    places = [(sx * e.hole_spacing_length_mm / 2, sz * e.hole_spacing_width_mm / 2) for sx in (-1, 1) for sz in (-1, 1)]
    boring = Boring()
    bores = (placed(along_y(e.hole_diameter_mm, at, way), BOARD_ZONE_MM) for at in places)
    boring.add(f"{e.hole_diameter_mm:g} through, screws", bores)
    shape = feature("encoder_board", "board", "hardware.encoder", lambda: cut(fuse(board, chip, plug), boring.tools))
    extent = (-half_x, half_x), (-e.board_thickness_mm - 4.0, e.chip_height_mm), (-half_z, half_z)
    part = bought_part("encoder_board", e, shape, "fr4", extent, e.mass_g, holes=tuple(boring.holes))
    if part.to_drawing:
        return replace(part, notes=_board_notes(e))
    return replace(part, holes=tuple(replace(hole, bores=()) for hole in part.holes))  # its maker states no zone


def _board_notes(e: catalogue.Encoder) -> tuple[str, ...]:
    """What a board's drawing says beside its shape: copper, parts and nets, in the names of the chip's data sheet."""
    return (
        "Two copper layers of 0.035, solder mask on both sides. The box of 4.4 x 5 is U1; that of 4 x 10 is J1.",
        f"U1 is {e.maker} {e.order_code}: its sensor is within {CHIP_PLACE_MM:g} of the middle of the four holes.",
        "J1 is JST SM06B-SRSS-TB, its plug goes in from the short edge beside it.",
        "Nets from J1 to the pins of U1 with these functions: 1 VDD, 2 GND, 3 SCK, 4 MOSI, 5 MISO, 6 CSN. C1, 100 nF, "
        "from VDD to GND beside U1. All other pins as the data sheet of U1 has them for SPI.",
        "Nothing magnetic on the board, no other part on the side of U1 but C1.",
    )


def make_encoder_magnet(d: Dimensions) -> Part:
    """Encoder magnet along y from 0 to its thickness."""
    m = d.magnet
    y = (0.0, m.thickness_mm)
    extent = round_y(m.diameter_mm / 2, y)
    return bought_part("encoder_magnet", m, bore_y(m.diameter_mm, (0.0, 0.0), y), "ndfeb", extent, m.mass_g)


_HOLE_ROOM_MM = 0.3  # between the pin's end and the floor of the hole: adhesive


def make_joint_ball(d: Dimensions) -> Part:
    """Ball about the origin, its hole open towards +y; bought, and eroded because it is hardened through."""
    number, f, row = "joint_ball", d.forearm, d.forearm.ball
    hole, radius = f.pin_diameter_mm + 2 * BALL_GLUE_MM, f.ball_diameter_mm / 2
    floor = -f.pin_past_mm - _HOLE_ROOM_MM
    sphere = ball(f.ball_diameter_mm, (0.0, 0.0, 0.0), (0.0, 1.0, 0.0))
    boring = Boring()
    eroded = within(blind(along_y(hole, (0.0, 0.0), (radius, floor))), -EROSION_UM, EROSION_UM)
    centred = f"eroded, its axis within {BALL_CENTRE_MM:g} of that centre"
    boring.add(f"{hole:.2f}, floor {-floor:g} past the ball's centre, {centred}", [eroded])
    solid = feature(number, "hole", "hardware.ball_diameter_mm", lambda: cut(sphere, boring.tools))
    rim = (radius**2 - (hole / 2) ** 2) ** 0.5
    extent = (-radius, radius), (-radius, rim), (-radius, radius)
    description = f"{row.description}, eroded {hole:.2f} to {-floor:g} past its centre; bonded on its stud at assembly"
    return made_part(number, description, solid, material(row.material), extent, boring.holes, **ordered(row))


def make_foot(d: Dimensions) -> Part:
    """Rubber foot hanging below z = 0, its stud above."""
    f = d.foot
    holes: tuple[Hole, ...] = ()
    pad = bore_z(f.diameter_mm, (0.0, 0.0), (-f.height_mm, 0.0))
    if f.stud_length_mm is not None:
        core = catalogue.screw(f.thread).tap_drill_mm - CORE_PLAY_MM
        shape = fuse(pad, bore_z(core, (0.0, 0.0), (-1.0, f.stud_length_mm)))
    else:
        hole = cast(float, f.hole_diameter_mm)  # the catalogue refuses feet with neither
        row = catalogue.screw(f.thread)
        seat = row.counterbore_depth_mm - f.height_mm
        tools = [bore_z(hole, (0.0, 0.0), (-f.height_mm - 1, 1))]
        tools.append(bore_z(row.counterbore_diameter_mm, (0.0, 0.0), (-f.height_mm - 1, seat)))
        shape = cut(pad, tools)
        sunk = f"counterbore {row.counterbore_diameter_mm:g} x {row.counterbore_depth_mm:g}"
        holes = Hole(hole, 1, f"{hole:g} through"), Hole(row.counterbore_diameter_mm, 1, sunk)
    extent = round_z(f.diameter_mm / 2, (-f.height_mm, f.stud_length_mm or 0.0))
    return bought_part("foot", f, shape, "rubber", extent, f.mass_g, holes=holes)


CORD_MM = 0.5
CORD_SLACK_MM = 1.0  # a ball leaves its cup at more than 2 mm: the cord keeps it in when a spring breaks, or at a blow
_CORD_KNOTS_MM = 30.0
_CORD_DENSITY_G_MM3 = 0.97e-3  # polyethylene
_WIRE_DENSITY_G_MM3 = 7.85e-3
_LOOPS = 2.0  # coils' worth of wire in both loops together
_PIECES = 160, 12, 24  # of half a loop: around it, out from the middle of its wire, around that


def cord_mm(f: ForearmDimensions) -> tuple[float, float]:
    """Gives the length of a cord between the eyes and as it is cut, mm."""
    between = f.between_eyes_mm + CORD_SLACK_MM
    return between, between + _CORD_KNOTS_MM


def spring_mass_g(f: ForearmDimensions) -> float:
    """Computes the mass of a spring with its cord, g; of the spring as its row gives it, else of its wire."""
    row = f.spring
    wire = pi**2 / 4 * row.wire_mm**2 * row.mean_diameter_mm * (row.active_coils + _LOOPS) * _WIRE_DENSITY_G_MM3
    return (wire if row.mass_g is None else row.mass_g) + pi / 4 * CORD_MM**2 * cord_mm(f)[1] * _CORD_DENSITY_G_MM3


def loop_overlap_mm3(f: ForearmDimensions, lean_rad: float) -> float:
    """Computes what a loop, drawn stiff, shares with its eye's lug where the rods lean: sums of small pieces, mm^3.

    The spring turns on the way to level and is drawn as long as at no lean; the edges of the eye are rounded in truth.
    """
    across, along = f.width_mm * sin(lean_rad), f.width_mm * cos(lean_rad) - 2 * f.eye_y_mm
    apart = hypot(across, along)
    mean, wire, hole = f.spring.mean_diameter_mm / 2, f.spring.wire_mm / 2, f.eye_diameter_mm / 2
    turn, out, around = np.meshgrid(*((np.arange(n) + 0.5) / n for n in _PIECES), indexing="ij")
    turn, out, around = pi * (turn - 0.5), wire * out, 2 * pi * around
    radius = mean + out * np.cos(around)
    u = (f.between_eyes_mm - apart) / 2 - (mean - wire) + radius * np.cos(turn)  # along the spring, beyond its eye
    v = radius * np.sin(turn)
    x, y = (across * u + along * v) / apart, (along * u - across * v) / apart + f.eye_hole_y_mm - f.eye_y_mm
    off = np.hypot(y, out * np.sin(around))
    shared = (np.abs(x) < f.eye_mm / 2) & (np.abs(y) < hole + EYE_WALL_MM) & (off > hole)
    return float((radius * out)[shared].sum()) * 2 * pi**2 * wire / turn.size


def make_rod_spring(d: Dimensions) -> Part:
    """Spring along y about the origin, as long as at no lean: its coils drawn as one cylinder, a ring for each loop.

    The rings lie in the plane of x and y: x runs through the eyes.
    """
    number, f = "rod_spring", d.forearm
    row, half = f.spring, f.between_eyes_mm / 2
    wire, mean = row.wire_mm / 2, row.mean_diameter_mm / 2
    body = (row.active_coils + 1.0) * row.wire_mm  # unloaded: the loops are what is left of the free length
    coils = half - min((row.free_length_mm - body) / 2, 2 * mean - wire)  # which the loops reach in any case

    def drawn() -> cq.Shape:
        centre = half - (mean - wire)
        loops = [
            cq.Solid.makeTorus(mean, wire, cq.Vector(0.0, side * centre, 0.0), cq.Vector(0.0, 0.0, 1.0))
            for side in (-1.0, 1.0)
        ]
        return fuse(bore_y(2 * (mean + wire), (0.0, 0.0), (-coils, coils)), *loops)

    solid = feature(number, "coils", "mechanism.parallelogram_width_mm", drawn)
    extent = round_y(mean + wire, (-half - 2 * wire, half + 2 * wire))
    made = bought_part(number, row, solid, "spring-wire", extent, spring_mass_g(f))
    drawing = f"{f.joint.spring_N:.1f} N at {f.between_eyes_mm:g} mm between the eyes of two rods; mass with its cord"
    return replace(made, description=f"{row.description}: {drawing}")
