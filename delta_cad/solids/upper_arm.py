"""The upper arm, a plain plate from its hub on the shoulder shaft to the boss around the cross-bar, and that shaft.

Arm's frame: origin in the shoulder, x to the elbow, y along the shoulder axis. No pockets and no slits where they are
not needed: what such a beam gives under load can be computed.
"""

from __future__ import annotations

from math import cos, sin

import cadquery as cq

from delta_cad import catalogue
from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.arm import CLAMP_SCREW, DOWEL_MM, FLATS_LONG_MM, WASHER_MATERIAL, WASHER_MM
from delta_cad.dimensions.tolerances import (
    LENGTH_MM,
    MAGNET_WIDER_UM,
    PREDRILLED_MM,
    PREDRILLED_ZONE_MM,
    END_TORQUE_N_m,
    bar_bore,
)
from delta_cad.dimensions.tolerances.machine import square_zones
from delta_cad.dimensions.tolerances.square import ARM
from delta_cad.solids.boring import (
    Boring,
    along_y,
    between,
    blind,
    fitted,
    placed,
    reamed_with,
    squared,
    tapped,
    within,
)
from delta_cad.solids.bought_parts import make_stock_spacer
from delta_cad.solids.making import ORANGE, cut_circle, made_part, material, round_y
from delta_cad.solids.part import Bore, Part
from delta_cad.solids.primitive import (
    THROUGH_MM,
    bore_y,
    box,
    cut,
    edge_break,
    feature,
    fuse,
    hull_along_y,
    turned,
)

SHOULDER_SEAT_X_MM, _SHOULDER_THREAD_MM = -8.0, 9.0  # seat of the clamp screw's head; thread, behind the slit
SHOULDER_SCREW_LENGTH_MM = 16.0


def polar_positions(radius: float, angles: tuple[float, ...]) -> list[tuple[float, float]]:
    """(x, z) of points on a circle about the shoulder."""
    return [(radius * cos(a), radius * sin(a)) for a in angles]


def dowel_positions(d: Dimensions) -> list[tuple[float, float]]:
    """(x, z) of the dowels between arm and sector."""
    return polar_positions(d.arm.dowel_circle_mm / 2, d.arm.dowel_angles_rad)


PREDRILLED = f"drilled {PREDRILLED_MM:g}, reamed with the"


def reamed_with_sector(bore: Bore, other: str) -> Bore:
    """A dowel's hole in arm or sector, which is reamed together with the other's."""
    return reamed_with(fitted(bore, "H7"), other, PREDRILLED_MM, PREDRILLED_ZONE_MM)


def make_upper_arm(d: Dimensions) -> Part:
    """Upper arm, milled from plate: clamped beside its sector along the shaft, or split around a motor's shaft."""
    number, a = "upper_arm", d.arm
    y, boss = d.layers.arm_mm, d.layers.elbow_boss_mm
    length, bar = a.length_mm, a.bar_bore_mm

    def body() -> cq.Shape:
        beam = hull_along_y([(0.0, 0.0, a.beam_root_radius_mm), (length, 0.0, a.boss_radius_mm)], y)
        hub = bore_y(2 * a.flange_radius_mm, (0.0, 0.0), y)
        return fuse(beam, hub, bore_y(2 * a.boss_radius_mm, (length, 0.0), boss))

    shape = feature(number, "outline", "upper_arm_length_mm", body)
    shape = edge_break(number, shape, ">Y or <Y", 0.4)
    boring, tools = Boring(), list[cq.Shape]()
    held = "clamped along the shaft" if d.capstan is not None else f"split {a.slit_mm:g} mm"
    first = y[0] if d.capstan is None else d.layers.bearings_mm[0][1]  # the collar's end
    shoulder = squared(fitted(along_y(a.shaft_bore_mm, (0.0, 0.0), (first, y[1])), "H7", 0.0), square_zones(d)[ARM])
    boring.add(f"{a.shaft_bore_mm:g} H7 through, {held}, shoulder", [shoulder])
    wider_um, zone = bar_bore(d.is_printed(number))
    bonded = placed(within(along_y(bar, (length, 0.0), boss), 0.0, wider_um), zone)
    boring.add(f"{bar:g} +{wider_um / 1000:g}/0 through, cross-bar bonded", [bonded])
    if d.capstan is not None:  # after the edges are broken: the collar's own carries the inner ring
        shape = fuse(shape, bore_y(a.collar_diameter_mm, (0.0, 0.0), (first, y[0] + THROUGH_MM)))
        dowels = [reamed_with_sector(along_y(DOWEL_MM, at, y), "sector") for at in dowel_positions(d)]
        boring.add(f"{DOWEL_MM:g} H7 through, sector dowels, {PREDRILLED} sector at assembly", dowels)
        cut_off = 0.0
    else:
        tools += _clamp(d, boring)
        cut_off = a.slit_mm / 2
    solid = feature(number, "bores", "arm_thickness_mm", lambda: cut(shape, [*boring.tools, *tools]))
    flange = max(a.flange_radius_mm, a.beam_root_radius_mm)
    extent = (
        (-flange, length + a.boss_radius_mm),
        (min(first, boss[0]), max(y[1], boss[1])),
        (-flange, cut_circle(flange, cut_off)),
    )
    description = f"upper arm, {length:g} mm between axes"
    if d.capstan is not None:
        stack = y[1] - d.layers.bearings_mm[0][1]
        description += f", {stack:g} +-{LENGTH_MM:g} from its collar to the sector"
    return made_part(number, description, solid, material(d.material_of("upper_arm"), ORANGE), extent, boring.holes)


def _clamp(d: Dimensions, boring: Boring) -> list[cq.Shape]:
    """Slit, seat and bores of the screw that clamps the hub on a motor's shaft; the cutters of the former two."""
    a, screw = d.arm, catalogue.screw(CLAMP_SCREW)
    low, high = (end + sign * THROUGH_MM for end, sign in zip(d.layers.elbow_boss_mm, (-1, 1), strict=True))
    z, outside, half = a.shoulder_clamp_z_mm, a.flange_radius_mm + THROUGH_MM, a.slit_mm / 2
    seat = f"{screw.clearance_hole_mm:g} from the open seat at x = {SHOULDER_SEAT_X_MM:g}, shoulder clamp"
    boring.add(seat, [between(screw.clearance_hole_mm, (SHOULDER_SEAT_X_MM, 0.0, z), (-half, 0.0, z))])
    thread = tapped(between(0.0, (half, 0.0, z), (outside, 0.0, z)), CLAMP_SCREW, _SHOULDER_THREAD_MM)
    boring.add(f"{CLAMP_SCREW} x {_SHOULDER_THREAD_MM:g}, drilled {thread.depth_mm:g} deep", [thread])
    return [
        box((-half, low, 0.0), (half, high, outside)),
        box((-outside, low, z - screw.counterbore_diameter_mm / 2), (SHOULDER_SEAT_X_MM, high, outside)),
    ]


_EDGE_MM = 0.3


def make_shoulder_shaft(d: Dimensions) -> Part:
    """Turned shaft; the magnet's seat is bored in the encoder's end, a capstan's has a thread in the other."""
    number, s = "shoulder_shaft", d.shaft
    (y0, y1), r, head = s.y_mm, s.diameter_mm / 2, s.head_diameter_mm / 2
    profile = [(0.0, y0), (head - _EDGE_MM, y0), (head, y0 + _EDGE_MM)]
    if head > r:
        profile += [(head, s.head_to_y_mm), (r, s.head_to_y_mm)]
    profile += [(r, y1 - _EDGE_MM), (r - _EDGE_MM, y1), (0.0, y1)]
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
    """Washer under the screw in the shaft's end, along y from 0: on the bearing's inner ring alone."""
    number, s = "shoulder_washer", d.shaft
    if s.washer is not None:
        return make_stock_spacer(number, s.washer, WASHER_MM, along="y")
    bore = catalogue.screw(s.end_screw).clearance_hole_mm
    body = bore_y(s.washer_diameter_mm, (0.0, 0.0), (0.0, WASHER_MM))
    boring = Boring()
    boring.add(f"{bore:g} through", [along_y(bore, (0.0, 0.0), (0.0, WASHER_MM))])
    solid = feature(number, "bore", "hardware.bearing", lambda: cut(body, boring.tools))
    extent = round_y(s.washer_diameter_mm / 2, (0.0, WASHER_MM))
    description = f"shoulder washer {s.washer_diameter_mm:g} x {WASHER_MM:g}"
    return made_part(number, description, solid, material(WASHER_MATERIAL), extent, boring.holes)
