"""Screws, dowels and spacers; frame of a screw: origin under the head, z from shank to head."""

from __future__ import annotations

import cadquery as cq

from delta_cad import catalogue
from delta_cad.mechanism.geometry import SIN_60
from delta_cad.solids.materials import material, provenance
from delta_cad.solids.part import Hole, Part
from delta_cad.solids.primitive import THROUGH_MM, bore_z, cut, cylinder, one_solid

CORE_PLAY_MM = 0.04  # the shank is drawn as its thread's core, free of the tap drill by this diameter


def make_cap_screw(size: str, length_mm: float) -> Part:
    """Hexagon socket head cap screw; the thread is drawn as its core."""
    row = catalogue.screw(size)
    if length_mm not in row.lengths_mm:
        raise ValueError(
            f"screw {size} x {length_mm:g}: stock lengths are {', '.join(f'{v:g}' for v in row.lengths_mm)}"
        )
    number = f"screw_{size}x{length_mm:g}"
    head = cylinder(row.head_diameter_mm, (0, 0, 0), (0, 0, row.head_height_mm))
    shank = cylinder(row.tap_drill_mm - CORE_PLAY_MM, (0, 0, -length_mm), (0, 0, THROUGH_MM))
    socket = cq.Workplane("XY", origin=(0, 0, row.head_height_mm - row.socket_depth_mm)).polygon(
        6, row.socket_mm / SIN_60
    )
    key = socket.extrude(row.socket_depth_mm + THROUGH_MM).val()
    solid = cut(head.fuse(shank), [key])  # type: ignore[list-item]
    return Part(
        number,
        f"{row.description} x {length_mm:g}",
        one_solid(solid, number),
        material("stainless-1.4305"),
        False,
        standard=row.standard,
        order_code=f"{row.order_code} x {length_mm:g}",
        source=provenance(row),
    )


def _hexagon(across_flats_mm: float, z: tuple[float, float]) -> cq.Shape:
    """Hexagonal prism along z, corners on the x axis."""
    plane = cq.Workplane("XY", origin=(0, 0, z[0]))
    return plane.polygon(6, across_flats_mm / SIN_60).extrude(z[1] - z[0]).val()  # type: ignore[return-value]


def make_tension_screw(size: str, length_mm: float, bore_mm: float) -> Part:
    """Hexagon head screw drilled through along its axis for the capstan cable, whose sleeve bears on the head."""
    row, number = catalogue.hex_screw(size), "tension_screw"
    shank = cylinder(row.tap_drill_mm - CORE_PLAY_MM, (0, 0, -length_mm), (0, 0, THROUGH_MM))
    body = _hexagon(row.across_flats_mm, (0.0, row.head_height_mm)).fuse(shank)
    solid = cut(body, [bore_z(bore_mm, (0.0, 0.0), (-length_mm - THROUGH_MM, row.head_height_mm + THROUGH_MM))])
    return Part(
        number,
        f"cable tension screw: {row.order_code} x {length_mm:g}, drilled {bore_mm:g} through",
        one_solid(solid, number),
        material("stainless-1.4305"),
        True,
        (Hole(bore_mm, 1, f"{bore_mm:g} through along the axis"),),
        standard=row.standard,
        order_code=f"{row.order_code} x {length_mm:g}",
        source=provenance(row),
    )


def make_lock_nut(size: str) -> Part:
    """Thin hexagon nut along z from 0 to its height; its thread is drawn as the core."""
    row, number = catalogue.hex_nut(size), f"nut_{size}"
    bore = bore_z(row.tap_drill_mm, (0.0, 0.0), (-THROUGH_MM, row.height_mm + THROUGH_MM))
    return Part(
        number,
        row.description,
        one_solid(cut(_hexagon(row.across_flats_mm, (0.0, row.height_mm)), [bore]), number),
        material("stainless-1.4305"),
        False,
        standard=row.standard,
        order_code=row.order_code,
        source=provenance(row),
    )


def make_dowel(key: str, length_mm: float) -> Part:
    """Parallel pin along z from 0 to its length."""
    row = catalogue.dowel(key)
    if length_mm not in row.lengths_mm:
        raise ValueError(
            f"dowel {key} x {length_mm:g}: stock lengths are {', '.join(f'{v:g}' for v in row.lengths_mm)}"
        )
    number = f"dowel_{row.diameter_mm:g}x{length_mm:g}"
    return Part(
        number,
        f"{row.description} x {length_mm:g}",
        one_solid(cylinder(row.diameter_mm, (0, 0, 0), (0, 0, length_mm)), number),
        material("steel"),
        False,
        standard=row.standard,
        order_code=f"{row.order_code} x {length_mm:g}",
        source=provenance(row),
    )


def make_spacer(bore_mm: float, length_mm: float) -> Part:
    """Turned distance sleeve along z from 0 to its length."""
    number = "board_spacer"
    outer = bore_mm + 2.0
    solid = cut(
        cylinder(outer, (0, 0, 0), (0, 0, length_mm)),
        [bore_z(bore_mm, (0.0, 0.0), (-THROUGH_MM, length_mm + THROUGH_MM))],
    )
    return Part(
        number,
        f"spacer {outer:g}/{bore_mm:g} x {length_mm:g} under the encoder board",
        one_solid(solid, number),
        material("brass"),
        True,
        (Hole(bore_mm, 1, f"{bore_mm:g} through"),),
    )
