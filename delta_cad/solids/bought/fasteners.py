"""Screws, dowels and spacers; frame of a screw: origin under the head, z from shank to head."""

from __future__ import annotations

from dataclasses import replace

import cadquery as cq

from delta_cad import catalogue
from delta_cad.mechanism.geometry import SIN_60
from delta_cad.solids.boring import Boring, along_z
from delta_cad.solids.making import bought_part, made_part, round_z
from delta_cad.solids.materials import material
from delta_cad.solids.part import Part
from delta_cad.solids.primitive import THROUGH_MM, cut, cylinder

CORE_PLAY_MM = 0.04  # the shank is drawn as its thread's core, free of the tap drill by this diameter


def make_cap_screw(size: str, length_mm: float) -> Part:
    """Hexagon socket head cap screw; the thread is drawn as its core."""
    row = catalogue.screw(size)
    _require_stock(f"screw {size}", length_mm, row.lengths_mm)
    head = cylinder(row.head_diameter_mm, (0, 0, 0), (0, 0, row.head_height_mm))
    shank = cylinder(row.tap_drill_mm - CORE_PLAY_MM, (0, 0, -length_mm), (0, 0, THROUGH_MM))
    key = _hexagon(row.socket_mm, (row.head_height_mm - row.socket_depth_mm, row.head_height_mm + THROUGH_MM))
    solid = cut(head.fuse(shank), [key])
    extent, x = round_z(row.head_diameter_mm / 2, (-length_mm, row.head_height_mm)), f"x{length_mm:g}"
    return bought_part(f"screw_{size}{x}", row, solid, "stainless-1.4305", extent, size=f" x {length_mm:g}")


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
    return replace(make_cap_screw(size, length_mm), number=f"tension_screw_{size}x{length_mm:g}")


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
