"""Sector, pinion, cable and tension carriage of the capstan (arm's frame; the pinion in its own, y along its axis)."""

from __future__ import annotations

from dataclasses import replace
from math import cos, hypot, pi, sin

import cadquery as cq
import numpy as np

from delta_cad import catalogue
from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.arm import DOWEL_MM
from delta_cad.dimensions.capstan import (
    ANCHOR_MM,
    ANCHOR_SIDE_MM,
    CARRIAGE_FROM_MM,
    CARRIAGE_MM,
    CARRIAGE_RADII_MM,
    CARRIAGE_SCREW_MM,
    CRIMP_MM,
    LUG_WALL_MM,
    PINION_TURNED_MM,
    POCKET_CORNER_MM,
    POCKET_FROM_MM,
    POCKET_PLAY_MM,
    RIM_MM,
    RIM_TURNED_MM,
    SET_SCREW,
    SHOULDER_MM,
    TENSION_SCREW,
    CapstanDimensions,
    lug_length_mm,
    rim_end,
    sleeve_bore_mm,
)
from delta_cad.dimensions.tolerances import LENGTH_MM, STOP_ZONE_MM
from delta_cad.dimensions.tolerances.machine import square_zones
from delta_cad.dimensions.tolerances.square import SECTOR
from delta_cad.mechanism.placement import frames
from delta_cad.solids.boring import Boring, along_y, along_z, between, blind, fitted, group, placed, squared, tapped
from delta_cad.solids.making import bought_part, hull_y, made_part, material, points_of_arc, round_y, round_z
from delta_cad.solids.part import Part
from delta_cad.solids.primitive import (
    THROUGH_MM,
    arcs_about_y,
    bore_y,
    box,
    cut,
    cylinder,
    feature,
    fuse,
    hull_along_y,
    one_solid,
    ring_segment,
    round_inside,
    stepped,
    swept_round,
)
from delta_cad.solids.upper_arm import PREDRILLED, dowel_positions, polar_positions, reamed_with_sector

_BARE_END_MM = 40.0  # cable to hold by while the sleeves are crimped, before the rest is cut off
_LIGHTENING_MM = 7.0
_AXIS_DIGITS = 12  # of a direction along an axis, which cosines miss by a rounding
_ROUNDING_MM = 1e-6
_DRAWN_PLAY_MM = 0.03  # of diameter, by which the cable is drawn thinner: it touches no drum in a line


def capstan_of(d: Dimensions) -> CapstanDimensions:
    """Capstan of a design that has one."""
    if d.capstan is None:
        raise ValueError("hardware.drive = direct: the design has no capstan")
    return d.capstan


def tension_screw_frame(d: Dimensions) -> np.ndarray:
    """(4, 4) frame under the head of the tension screw in the arm's frame; z points from shank to head."""
    point, tangent, normal = rim_end(capstan_of(d), 1)
    return frames(normal, np.cross(tangent, normal), point + CARRIAGE_SCREW_MM * normal + lug_length_mm() * tangent)


def set_screw_frames(d: Dimensions, length_mm: float) -> tuple[np.ndarray, np.ndarray]:
    """(4, 4) frames of the pinion's set screws in its frame: tip on the motor's shaft, z outwards."""
    c = capstan_of(d)
    middle, out = sum(c.collar_y_mm) / 2, c.pinion_bore_mm / 2 + length_mm
    found = []
    for x, z in _set_screw_ways(d):
        found.append(frames(np.array([z, 0.0, -x]), np.array([0.0, 1.0, 0.0]), np.array([out * x, middle, out * z])))
    return found[0], found[1]


def _set_screw_ways(d: Dimensions) -> list[tuple[float, float]]:
    """(x, z) unit vectors along the pinion's set screws in its frame; those along its axes without rounding."""
    return [(round(cos(a), _AXIS_DIGITS) + 0.0, round(sin(a), _AXIS_DIGITS) + 0.0) for a in d.set_screws_rad]


def _lightening(c: CapstanDimensions) -> list[tuple[float, float]]:
    """(x, z) of the lightening holes between slot and rim, as many as leave walls of 2 mm."""
    low, high = _lightening_room_mm(c)
    if high - low < _LIGHTENING_MM:
        return []
    radius = _lightening_radius_mm(c)
    first, last = (c.rim_angles_rad[0] + 6.0 / radius, c.rim_angles_rad[1] - 6.0 / radius)
    count = int((last - first) * radius / (_LIGHTENING_MM + 4.0))
    step = (last - first) / max(count, 1)
    return polar_positions(radius, tuple(first + (k + 0.5) * step for k in range(count)))


def _lightening_room_mm(c: CapstanDimensions) -> tuple[float, float]:
    """Radii between which the lightening holes lie, with walls of 2 mm to slot and rim."""
    return c.slot_radius_mm + c.slot_width_mm / 2 + 2.0, c.rim_radius_mm - 2.0


def _lightening_radius_mm(c: CapstanDimensions) -> float:
    return sum(_lightening_room_mm(c)) / 2


def _corners(
    d: Dimensions, end: int, radial: tuple[float, float], along: tuple[float, float], corner: float = 0.0
) -> list[tuple[float, float, float]]:
    """(x, z, radius) of a rectangle's corners beside a rim's end: off the cable's line, and along it from the end."""
    point, tangent, normal = rim_end(capstan_of(d), end)
    r0, r1, s0, s1 = radial[0] + corner, radial[1] - corner, along[0] + corner, along[1] - corner
    found = [point + r * normal + s * tangent for r in (r0, r1) for s in (s0, s1)]
    return [(float(p[0]), float(p[2]), corner) for p in found]


def make_sector(d: Dimensions) -> Part:
    """Sector beside the arm: rim, nose and anchor for the cable, pocket for its carriage, slot for the stop pin."""
    number, c, a, y = "sector", capstan_of(d), d.arm, d.layers.sector_mm
    arm, web = d.layers.arm_mm[1], c.web_y_mm
    inner = a.flange_radius_mm - 4.0
    low, high = c.rim_angles_rad
    length = lug_length_mm()
    under = length / c.rim_radius_mm  # the web goes on under the lug
    top = CARRIAGE_RADII_MM[1] + LUG_WALL_MM[0]
    foot = CARRIAGE_RADII_MM[0] - LUG_WALL_MM[0]
    below = c.pitch_radius_mm + foot  # the lug's foot, which the web must reach where it ends: no wedge under it
    support_radius = max(below + 1.0, below / cos(under) + 0.5)
    x, z = c.nose_centre_mm
    pocket_y = (c.end_y_mm[1] - CARRIAGE_MM[1] / 2, c.end_y_mm[1] + CARRIAGE_MM[1] / 2 + POCKET_PLAY_MM)

    def adjacent(
        end: int,
        radial: tuple[float, float],
        along: tuple[float, float],
        wide: tuple[float, float],
        corner: float = 0.0,
    ) -> cq.Shape:
        """Prism beside a rim's end: off the cable's line, along it from the end, along the shoulder's axis; corners."""
        return hull_along_y(_corners(d, end, radial, along, corner), wide)

    def under_cable(point: np.ndarray) -> bool:
        """Whether a corner lies where the cable leaves rim or nose: a rounding there would lift it."""
        nose = hypot(point[0] - c.nose_centre_mm[0], point[2] - c.nose_centre_mm[1]) - c.nose_radius_mm
        return min(abs(hypot(point[0], point[2]) - c.rim_radius_mm), abs(nose)) < _ROUNDING_MM

    def body() -> cq.Shape:
        plate = ring_segment(inner, c.rim_radius_mm, (low, high), web)
        rim = ring_segment(c.rim_radius_mm - RIM_MM, c.rim_radius_mm, (low, high), y)
        support = ring_segment(inner, support_radius, (low, high + under), web)
        share = inner / (c.rim_radius_mm - c.nose_radius_mm)
        bar = [(x, z, c.nose_bar_radius_mm), (share * x, share * z, c.nose_bar_radius_mm)]
        nose = fuse(bore_y(2 * c.nose_radius_mm, (x, z), y), hull_along_y(bar, web))
        hub = bore_y(2 * a.flange_radius_mm, (0.0, 0.0), (arm, web[1]))
        collar = bore_y(a.collar_diameter_mm, (0.0, 0.0), (web[1] - THROUGH_MM, d.layers.motor_cheek_mm[0]))
        lug = adjacent(1, (foot, top), (0.0, length), (pocket_y[0], y[1]))
        anchor = adjacent(0, (-ANCHOR_SIDE_MM, ANCHOR_SIDE_MM), (0.0, ANCHOR_MM), (web[0], y[1]))
        whole = fuse(plate, rim, support, nose, hub, collar, lug, anchor)
        return round_inside(number, whole, (0.0, 1.0, 0.0), under_cable)

    shape = feature(number, "outline", "hardware.sector_radius_mm", body)
    collar = d.layers.motor_cheek_mm[0]
    through = (arm - THROUGH_MM, collar + THROUGH_MM)
    screw, boring, tools = catalogue.screw(TENSION_SCREW), Boring(), list[cq.Shape]()
    shaft = fitted(along_y(a.shaft_bore_mm, (0.0, 0.0), (arm, collar)), "G7", 0.0)
    shaft = squared(shaft, square_zones(d)[SECTOR])
    boring.add(f"{a.shaft_bore_mm:g} G7 through, on the shoulder shaft", [shaft])
    dowels = [reamed_with_sector(along_y(DOWEL_MM, at, (arm, web[1])), "upper_arm") for at in dowel_positions(d)]
    boring.add(f"{DOWEL_MM:g} H7 through, dowels, {PREDRILLED} arm at assembly", dowels)
    half, inside = c.slot_width_mm / 2, c.rim_radius_mm - RIM_MM  # what goes into the rim goes through all its width
    deep = y if c.slot_radius_mm + half > inside else web
    ends = [along_y(c.slot_width_mm, at, deep) for at in polar_positions(c.slot_radius_mm, c.slot_angles_rad)]
    ends = [placed(end, STOP_ZONE_MM) for end in ends]
    boring.add(f"end of the arc slot {c.slot_width_mm:g} wide through, on radius {c.slot_radius_mm:g}", ends)
    tools.append(ring_segment(c.slot_radius_mm - half, c.slot_radius_mm + half, c.slot_angles_rad, through))
    deep = y if _lightening_radius_mm(c) + _LIGHTENING_MM / 2 > inside else web
    lights = [along_y(_LIGHTENING_MM, at, deep) for at in _lightening(c)]
    boring.add(f"{_LIGHTENING_MM:g} through, lightening", lights)
    free = POCKET_PLAY_MM
    pocket = (POCKET_FROM_MM, length - LUG_WALL_MM[1])
    radial = (CARRIAGE_RADII_MM[0] - free, CARRIAGE_RADII_MM[1] + free)
    tools.append(adjacent(1, radial, pocket, (pocket_y[0] - THROUGH_MM, pocket_y[1]), POCKET_CORNER_MM))
    slot = c.cable_slot_mm
    half = slot / 2
    for end, last, side, name in (
        (0, ANCHOR_MM + THROUGH_MM, y[1] + THROUGH_MM, "motor"),
        (1, POCKET_FROM_MM + THROUGH_MM, pocket_y[0] - THROUGH_MM, "arm"),
    ):
        point, tangent, _ = rim_end(c, end)
        begin, floor = (tuple((point + s * tangent).tolist()) for s in (-THROUGH_MM, last - THROUGH_MM))
        cable = f"tangential slot {slot:g} wide with a round bottom x {last:g} long, open to the {name}'s side, cable"
        boring.holes.append(group(cable, [between(slot, begin, floor)]))
        tools.append(cylinder(slot, begin, tuple((point + last * tangent).tolist())))
        open_y = min(c.end_y_mm[end], side), max(c.end_y_mm[end], side)
        tools.append(adjacent(end, (-half, half), (-THROUGH_MM, last), open_y))
    point, tangent, normal = rim_end(c, 1)
    line = point + CARRIAGE_SCREW_MM * normal
    line_ends = (tuple((line + s * tangent).tolist()) for s in (length, length - LUG_WALL_MM[1]))
    tension = between(screw.clearance_hole_mm, *line_ends)
    boring.add(f"{screw.clearance_hole_mm:g} into the pocket, tension screw", [tension])
    solid = feature(number, "slot and bores", "shoulder angle range", lambda: cut(shape, [*boring.tools, *tools]))
    lead = c.run.pitch_mm * c.ratio
    description = (
        f"capstan sector, rim radius {c.rim_radius_mm:g} +-{RIM_TURNED_MM:g} smooth, "
        f"cable climbs {lead:.2f} a turn, {c.ratio:g}:1, "
        f"{d.layers.motor_cheek_mm[0] - arm:g} +-{LENGTH_MM:g} from the arm to its collar"
    )
    outline = [(x, z, r) for r in (c.nose_radius_mm, c.nose_bar_radius_mm)]
    outline += [(0.0, 0.0, r) for r in (a.flange_radius_mm, a.collar_diameter_mm / 2)]
    outline += points_of_arc(c.rim_radius_mm, (low, high)) + points_of_arc(support_radius, (low, high + under))
    outline += _corners(d, 1, (foot, top), (0.0, length))
    outline += _corners(d, 0, (-ANCHOR_SIDE_MM, ANCHOR_SIDE_MM), (0.0, ANCHOR_MM))
    extent = hull_y(outline, (min(arm, pocket_y[0]), d.layers.motor_cheek_mm[0]))
    return made_part(number, description, solid, material("aluminium-7075"), extent, boring.holes)


def make_tension_carriage(d: Dimensions) -> Part:
    """Block in the sector's pocket that pulls the cable's sleeve by a screw and cannot turn; frame `carriage_frame`."""
    number, c = "tension_carriage", capstan_of(d)
    (low, high), (length, thick) = CARRIAGE_RADII_MM, CARRIAGE_MM
    slot = c.cable_slot_mm
    seat, into, open_y = CRIMP_MM[0] + 0.2, length - CRIMP_MM[1], -thick / 2 - THROUGH_MM
    r = POCKET_CORNER_MM
    corners = [(x, z, r) for x in (low + r, high - r) for z in (r, length - r)]
    body = hull_along_y(corners, (-thick / 2, thick / 2))
    boring, axis = Boring(), (0.0, 0.0)
    laid = f"slot {slot:g} wide with a round bottom, open to the arm's side, cable"
    boring.add(laid, [along_z(slot, axis, (0.0, into))])
    sleeve = f"slot {seat:g} wide with a round bottom, {CRIMP_MM[1]:g} from the end, open to the arm's side, sleeve"
    boring.add(sleeve, [blind(along_z(seat, axis, (length, into)))])
    boring.add(
        f"{TENSION_SCREW} through", [tapped(along_z(0.0, (CARRIAGE_SCREW_MM, 0.0), (0.0, length)), TENSION_SCREW)]
    )
    tools = [
        *boring.tools,
        box((-slot / 2, open_y, -THROUGH_MM), (slot / 2, 0.0, length)),
        box((-seat / 2, open_y, into), (seat / 2, 0.0, length + THROUGH_MM)),
    ]
    solid = feature(number, "bores", "hardware.cable", lambda: cut(body, tools))
    extent = CARRIAGE_RADII_MM, (-thick / 2, thick / 2), (0.0, length)
    description = "carriage that tensions the cable, eased until it slides in the sector's pocket by hand"
    return made_part(number, description, solid, material("brass"), extent, boring.holes)


def _step(radius: float, low: float, high: float) -> list[tuple[float, float, float]]:
    """A step of a turned part, if it has any length."""
    return [(radius, low, high)] if high > low + _ROUNDING_MM else []


def make_pinion(d: Dimensions) -> Part:
    """Pinion on the motor's shaft, its groove drawn to the bottom as threads are; set screws in its collar."""
    number, c = "pinion", capstan_of(d)
    (y0, y2), (low, high), crest = c.pinion_y_mm, c.collar_y_mm, c.pinion_radius_mm
    bottom = c.run.pinion_mm - c.cable_diameter_mm / 2
    first, last = c.groove_y_mm[0] + SHOULDER_MM, c.groove_y_mm[1] - SHOULDER_MM
    grooved = (crest, first - SHOULDER_MM, first), (bottom, first, last), (crest, last, last + SHOULDER_MM)
    far, near, neck = c.collar_radius_mm, c.pinion_bore_mm / 2, min(crest, c.collar_radius_mm)
    if c.collar_at_motor:
        begin = max(low, grooved[2][2])
        body = stepped(*grooved, *_step(neck, grooved[2][2], begin), (far, begin, high))
    else:
        end = min(high, grooved[0][1])
        body = stepped((far, low, end), *_step(neck, end, grooved[0][1]), *grooved)
    floor = y2 - c.pinion_bore_depth_mm
    middle, boring = (low + high) / 2, Boring()
    out = far + THROUGH_MM
    bore = fitted(along_y(c.pinion_bore_mm, (0.0, 0.0), (y2, floor)), "H7")
    if ends := floor > y0 + _ROUNDING_MM:
        bore = blind(bore)
    deep = f"x {c.pinion_bore_depth_mm:.1f}" if ends else "through"
    boring.holes.append(group(f"{c.pinion_bore_mm:g} H7 {deep}, on the motor's shaft", [bore]))
    bored = (floor if ends else y0 - THROUGH_MM, y2 + THROUGH_MM)  # drawn as the motor's shaft is, seam upon seam
    boring.tools.append(bore_y(c.pinion_bore_mm, (0.0, 0.0), bored))
    radial = [between(0.0, (far * x, middle, far * z), (near * x, middle, near * z)) for x, z in _set_screw_ways(d)]
    threads = [tapped(at, SET_SCREW) for at in radial]
    boring.holes.append(group(f"{SET_SCREW} radial, set screws", threads))
    boring.tools += [
        cylinder(t.diameter_mm, (0.0, middle, 0.0), (out * x, middle, out * z))
        for t, (x, z) in zip(threads, _set_screw_ways(d), strict=True)
    ]  # to the axis: the bore may be narrower than they
    solid = feature(number, "bore", "motor shaft", lambda: cut(body, boring.tools))
    run, d_c = c.run, c.cable_diameter_mm
    description = (
        f"capstan pinion, left-hand helical groove R{d_c / 2:.2f} cut from diameter {2 * crest:.3f} to "
        f"{2 * bottom:.3f} +-{PINION_TURNED_MM:g}, pitch {run.pitch_mm:g}, {last - first:g} long, begun at any "
        "angle; lands stay; hard anodised"
    )
    extent = round_y(max(crest, c.collar_radius_mm), c.pinion_y_mm)
    return made_part(number, description, solid, material("aluminium-7075"), extent, boring.holes)


def make_cable(d: Dimensions, end: int) -> Part:
    """Cable on the rim from one of its ends to where it leaves the sector in the exported position.

    The one of the outer end is the cable in the bill of materials; all others are pieces that it is drawn in.
    """
    c, run = capstan_of(d), capstan_of(d).run
    sense = 1.0 if end else -1.0
    ends = (c.rim_angles_rad[end], c.direction_rad - d.home_rad + sense * run.tangent_rad)
    rim = arcs_about_y(c.pitch_radius_mm, (0.0, 0.0), ends, c.end_y_mm[end], _climb(d, end))
    if not end:
        return _piece(d, "capstan_cable_inner", rim)
    length, tolerance = c.bench_mm
    text = (
        f"{d.cable.description}, cut {length + _BARE_END_MM:.0f} mm, sleeves crimped on the bench: "
        f"{length:.1f} +-{tolerance:.1f} mm between their backs, slack"
    )
    return replace(_piece(d, "capstan_cable", rim), description=text, piece_of="")


def make_cable_end(d: Dimensions, end: int) -> Part:
    """Cable from a rim's end to its sleeve: straight into the carriage, or round the nose and through the anchor."""
    c = capstan_of(d)
    point, tangent, _ = rim_end(c, end)
    if end:
        back = CARRIAGE_FROM_MM + CARRIAGE_MM[0]
        return _piece(d, "capstan_cable_outer_end", [[point + back * tangent, point]])
    low, y = c.rim_angles_rad[0], c.end_y_mm[0]
    nose = arcs_about_y(
        c.nose_radius_mm + c.cable_diameter_mm / 2, c.nose_centre_mm, (low - c.turns_rad[0], low), y, 0.0
    )
    return _piece(d, "capstan_cable_inner_end", [[point + (ANCHOR_MM + CRIMP_MM[1]) * tangent, point], *nose])


def make_strand(d: Dimensions, end: int) -> Part:
    """Free strand from the sector to the pinion in the exported position; frame of the shoulder, axes of the chain."""
    c, run = capstan_of(d), capstan_of(d).run
    sense = 1.0 if end else -1.0
    at = c.direction_rad + sense * run.tangent_rad
    leaves = np.array([run.sector_mm * cos(at), _leaves_y(d, end), run.sector_mm * sin(at)])
    (x, z), angle = c.pinion_axis_mm, at + pi
    arrives = np.array([x + run.pinion_mm * cos(angle), leaves[1], z + run.pinion_mm * sin(angle)])
    arrives[1] += _climb(d, end) * run.free_mm
    strand = cylinder(c.cable_diameter_mm - _DRAWN_PLAY_MM, tuple(leaves), tuple(arrives))
    return _bought(d, f"capstan_cable_strand_{'outer' if end else 'inner'}", strand, run.free_mm)


def make_turns(d: Dimensions) -> Part:
    """Turns of the cable on the pinion in the exported position; about the pinion's axis, axes of the chain.

    As the pinion turns they stay where they are but for the groove's pitch, by which they walk along it.
    """
    c, run = capstan_of(d), capstan_of(d).run
    start = c.direction_rad + pi + run.tangent_rad
    y = _leaves_y(d, 1) + _climb(d, 1) * run.free_mm
    turns = arcs_about_y(run.pinion_mm, (0.0, 0.0), (start, start + run.wrap_rad), y, run.climb)
    return _piece(d, "capstan_cable_turns", turns)


def _leaves_y(d: Dimensions, end: int) -> float:
    """Coordinate along the shoulder's axis where a strand leaves the sector in the exported position."""
    return capstan_of(d).end_y_mm[end] + _climb(d, end) * _on_rim_mm(d, end)


def _on_rim_mm(d: Dimensions, end: int) -> float:
    """Length of cable on the rim in the exported position."""
    c, sense = capstan_of(d), 1.0 if end else -1.0
    tangent = c.direction_rad - d.home_rad + sense * c.run.tangent_rad
    return c.pitch_radius_mm * abs(c.rim_angles_rad[end] - tangent)


def _climb(d: Dimensions, end: int) -> float:
    """Way along the shoulder's axis per length of a strand in the exported position, from its lug to its groove."""
    c, sense = capstan_of(d), 1.0 if end else -1.0
    return sense * (c.run.climb + (c.run.made_lug_mm - c.run.lug_mm) / (_on_rim_mm(d, end) + c.run.free_mm))


def _piece(d: Dimensions, number: str, pieces: list[list[np.ndarray]]) -> Part:
    """A piece of the cable along lines and arcs of its middle."""
    diameter = capstan_of(d).cable_diameter_mm
    shape = feature(
        number,
        "sweep",
        "hardware.cable",
        lambda: swept_round([np.array(one).tolist() for one in pieces], diameter - _DRAWN_PLAY_MM),
    )
    return _bought(d, number, shape, shape.Volume() / (pi * (diameter - _DRAWN_PLAY_MM) ** 2 / 4))


def _bought(d: Dimensions, number: str, shape: cq.Shape, length_mm: float) -> Part:
    mass_g = d.cable.mass_g_m * length_mm / 1000.0
    part = bought_part(number, d.cable, shape, "stainless-1.4305", None, mass_g)
    return replace(part, piece_of="capstan_cable", description=f"{part.description}, drawn in pieces")


def make_crimp_sleeve(d: Dimensions) -> Part:
    """Sleeve of the cable, uncrimped, behind the anchor's wall or in the carriage; along z from the cable's pull."""
    c, number = capstan_of(d), "crimp_sleeve"
    outer, length = CRIMP_MM
    boring, bore = Boring(), sleeve_bore_mm(c.cable_diameter_mm)
    boring.add(f"{bore:g} through", [along_z(bore, (0.0, 0.0), (0.0, length))])
    return Part(
        number,
        f"crimp sleeve {outer:g} x {length:g}, bore {bore:g}, for {c.cable_diameter_mm:g} mm cable",
        one_solid(cut(cylinder(outer, (0, 0, 0), (0, 0, length)), boring.tools), number),
        material("brass"),
        False,
        tuple(boring.holes),
        extent_mm=round_z(outer / 2, (0.0, length)),
        source="turned to drawing, every size is ours; no maker's sleeve of this size was found; verified: "
        "yes: 2026-11-24, its hold is proved on the bench: each is pulled by what its cable may bear (assembly manual)",
        to_drawing=True,
        notes=("Stress relieved or soft, so that it does not crack: it is crimped on a wire rope at assembly.",),
    )
