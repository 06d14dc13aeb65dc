"""The shoulder shaft (or a direct drive's stub) with the encoder magnet in its head, its washer; y along the axis."""

from __future__ import annotations

from typing import TYPE_CHECKING

from delta_cad import catalogue
from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.arm import FLATS_LONG_MM, WASHER_MM
from delta_cad.dimensions.tolerances import MAGNET_WIDER_UM, END_TORQUE_N_m
from delta_cad.solids.boring import Boring, along_y, blind, tapped, within
from delta_cad.solids.making import made_part, round_y
from delta_cad.solids.materials import material
from delta_cad.solids.part import Part
from delta_cad.solids.primitive import THROUGH_MM, bore_y, box, cut, feature, turned

if TYPE_CHECKING:
    import cadquery as cq

EDGE_MM = 0.3


def make_shoulder_shaft(d: Dimensions) -> Part:
    """Turned shaft; the magnet's seat is bored in the encoder's end, a capstan's has a thread in the other."""
    number, s = "shoulder_shaft", d.shaft
    (y0, y1), r, head = s.y_mm, s.diameter_mm / 2, s.head_diameter_mm / 2
    profile = [(0.0, y0), (head - EDGE_MM, y0), (head, y0 + EDGE_MM)]
    if head > r:
        profile += [(head, s.head_to_y_mm), (r, s.head_to_y_mm)]
    profile += [(r, y1 - EDGE_MM), (r - EDGE_MM, y1), (0.0, y1)]
    tools: list[cq.Shape] = []
    boring, axis = Boring(), (0.0, 0.0)
    if d.sensed_at_shoulder:
        seat = blind(along_y(s.magnet_bore_mm, axis, (y0, y0 + s.magnet_depth_mm)))
        seat = within(seat, 0.0, MAGNET_WIDER_UM)
        boring.add(f"{s.magnet_bore_mm:g} x {s.magnet_depth_mm:g}, magnet bonded flush", [seat])
    if s.end_screw:
        thread = tapped(along_y(0.0, axis, (y1, y0)), s.end_screw, s.end_thread_mm)
        deep = f"{s.end_screw} x {s.end_thread_mm:g}, drilled {thread.depth_mm:g} deep"
        boring.add(f"{deep}, clamps the inner rings", [thread])
    if s.flats_mm:
        for side in (-1.0, 1.0):
            edges = sorted((side * s.flats_mm / 2, side * (head + THROUGH_MM)))
            tools.append(box((-head, y0 - THROUGH_MM, edges[0]), (head, y0 + FLATS_LONG_MM, edges[1])))
    solid = feature(number, "bores", "hardware.magnet", lambda: cut(turned(profile), [*boring.tools, *tools]))
    description = f"shoulder shaft {s.diameter_mm:g} h6 x {round(y1 - y0, 3):g}"
    if s.end_screw:
        torque = END_TORQUE_N_m[s.end_screw]
        held = f"flats {s.flats_mm:g} across on its head" if s.flats_mm else "its head held in soft jaws"
        description += f", {held}, {s.end_screw} in its end tightened to {torque:g} N m"
    return made_part(number, description, solid, material("stainless-1.4305"), round_y(head, s.y_mm), boring.holes)


def make_shoulder_washer(d: Dimensions) -> Part:
    """Turned washer under the screw in the shaft's end, along y from 0: on the bearing's inner ring alone."""
    number, s = "shoulder_washer", d.shaft
    bore = catalogue.screw(s.end_screw).clearance_hole_mm
    body = bore_y(s.washer_diameter_mm, (0.0, 0.0), (0.0, WASHER_MM))
    boring = Boring()
    boring.add(f"{bore:g} through", [along_y(bore, (0.0, 0.0), (0.0, WASHER_MM))])
    solid = feature(number, "bore", "hardware.bearing", lambda: cut(body, boring.tools))
    extent = round_y(s.washer_diameter_mm / 2, (0.0, WASHER_MM))
    description = f"shoulder washer {s.washer_diameter_mm:g} x {WASHER_MM:g}"
    return made_part(number, description, solid, material("stainless-1.4305"), extent, boring.holes)
