"""Bought parts as their makers draw them from outside: motor, bearing, encoder board, magnet, foot."""

from __future__ import annotations

from math import cos, sin

import cadquery as cq

from delta_cad import catalogue
from delta_cad.catalogue import Row
from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.layers import motor_thread_mm
from delta_cad.solids.fasteners import CORE_PLAY_MM
from delta_cad.solids.materials import material, provenance
from delta_cad.solids.part import Part
from delta_cad.solids.primitive import (
    THROUGH_MM,
    bore_y,
    bore_z,
    box,
    cut,
    feature,
    fuse,
    one_solid,
    turned,
)


def _bought(number: str, row: Row, shape: cq.Shape, substance: str, mass_g: float) -> Part:
    return Part(
        number,
        row.description,
        one_solid(shape, number),
        material(substance),
        False,
        mass_g=mass_g,
        standard=row.standard,
        order_code=f"{row.maker} {row.order_code}" if row.maker != "any" else row.order_code,
        source=provenance(row),
    )


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
    drill = catalogue.screw(m.mount_thread).tap_drill_mm
    tools = []
    for angle in d.bracket.motor_screw_angles_rad:
        at = (m.mount_circle_mm / 2 * cos(angle), m.mount_circle_mm / 2 * sin(angle))
        tools.append(bore_y(drill, at, (-THROUGH_MM, motor_thread_mm(m))))
    shape = feature("motor", "body", "hardware.motor", lambda: cut(fuse(body, shaft), tools))
    return _bought("motor", m, shape, "aluminium-black", m.mass_g)


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
    return _bought(
        "bearing", b, feature("bearing", "rings", "hardware.bearing", lambda: turned(ring)), "steel", b.mass_g
    )


def make_encoder_board(d: Dimensions) -> Part:
    """Encoder board: chip side towards +y, board from y = -thickness to 0, chip over the origin."""
    e = d.encoder
    half_x, half_z = e.board_length_mm / 2, e.board_width_mm / 2
    board = box((-half_x, -e.board_thickness_mm, -half_z), (half_x, 0.0, half_z))
    chip = box((-2.2, -THROUGH_MM, -2.5), (2.2, e.chip_height_mm, 2.5))
    plug = box((half_x - 5.0, -e.board_thickness_mm - 4.0, -5.0), (half_x - 1.0, -e.board_thickness_mm + 0.2, 5.0))
    holes = [
        bore_y(
            e.hole_diameter_mm,
            (sx * e.hole_spacing_length_mm / 2, sz * e.hole_spacing_width_mm / 2),
            (-e.board_thickness_mm - 1, 1),
        )
        for sx in (-1, 1)
        for sz in (-1, 1)
    ]
    shape = feature("encoder_board", "board", "hardware.encoder", lambda: cut(fuse(board, chip, plug), holes))
    return _bought("encoder_board", e, shape, "fr4", e.mass_g)


def make_magnet(d: Dimensions) -> Part:
    """Encoder magnet along y from 0 to its thickness."""
    m = d.magnet
    return _bought("encoder_magnet", m, bore_y(m.diameter_mm, (0.0, 0.0), (0.0, m.thickness_mm)), "ndfeb", m.mass_g)


def make_foot(d: Dimensions) -> Part:
    """Rubber foot hanging below z = 0, its stud above."""
    f = d.foot
    pad = bore_z(f.diameter_mm, (0.0, 0.0), (-f.height_mm, 0.0))
    if f.stud_length_mm is None:
        if f.hole_diameter_mm is None:
            raise ValueError(f"foot {f.id}: neither stud nor hole")
        row = catalogue.screw(f.thread)
        seat = row.counterbore_depth_mm - f.height_mm
        tools = [bore_z(f.hole_diameter_mm, (0.0, 0.0), (-f.height_mm - 1, 1))]
        tools.append(bore_z(row.counterbore_diameter_mm, (0.0, 0.0), (-f.height_mm - 1, seat)))
        shape = cut(pad, tools)
    else:
        core = catalogue.screw(f.thread).tap_drill_mm - CORE_PLAY_MM
        shape = fuse(pad, bore_z(core, (0.0, 0.0), (-1.0, f.stud_length_mm)))
    return _bought("foot", f, shape, "rubber", f.mass_g)
