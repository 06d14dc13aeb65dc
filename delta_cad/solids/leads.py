"""Leads of motors and of encoders' boards as far as they bend, and the tie that holds one."""

from __future__ import annotations

from math import cos, hypot, sin

import cadquery as cq

from delta_cad.common.units import MM_PER_M
from delta_cad.dimensions.leads import (
    CLIP_MM,
    LEAD_G_M,
    LONG_MM,
    PLUG_MM,
    PLUGGED_MM,
    SENSOR_G_M,
    SENSOR_MM,
    STRAIGHT_MM,
    TAIL_MM,
    TIE_MM,
    TIED_MM,
    LeadDimensions,
    SensorLeadDimensions,
)
from delta_cad.solids.making import material
from delta_cad.solids.part import Extent, Hole, Part
from delta_cad.solids.primitive import box, cut, cylinder, feature, fuse, one_solid, swept_round

_UNVERIFIED = "verified: no, from memory, check before ordering"
SENSOR, CLIP = "sensor_lead", "lead_clip"
CODES = {
    "motor_lead": f"silicone lead 0.5 mm2, 2.3, {LONG_MM / MM_PER_M:g} m",
    "encoder_lead": "of the motor's encoder, comes with it",
    SENSOR: f"JST SHR-06V-S-B, six wires AWG 28 in a sleeve of {SENSOR_MM:g}, {LONG_MM / MM_PER_M:g} m",
    CLIP: f"cable tie base {CLIP_MM[0]:g} x {CLIP_MM[0]:g}, glued, with a tie {TIE_MM[0]:g}",
}
_SOURCES = {
    "motor_lead": f"common stock size; {_UNVERIFIED}",
    "encoder_lead": f"an estimate; {_UNVERIFIED}",
    SENSOR: "JST series SH: header 2.95 high, wires to 0.8 (pdf.elecfans.com/p/10625074.html); verified: partly; that "
    "the board has such a header: no, measure the board in hand",
    CLIP: f"common stock size; {_UNVERIFIED}",
}
CLIP_G = 1.0  # an estimate


def make_lead(leads: LeadDimensions) -> Part:
    """A lead: from the motor's back at the origin along +y, then to -z, which is inwards in the machine."""
    bend, middle = leads.bend_mm, leads.bend_mm / 2**0.5
    start, turn = (0.0, 0.0, 0.0), (0.0, PLUG_MM, 0.0)
    top, low = (0.0, PLUG_MM + middle, middle - bend), (0.0, PLUG_MM + bend, -bend)
    pieces = ((start, turn), (turn, top, low), (low, (0.0, PLUG_MM + bend, -bend - TAIL_MM)))
    shape = feature(leads.number, "bend", "hardware.leads", lambda: swept_round(pieces, leads.diameter_mm))
    half = leads.diameter_mm / 2.0
    extent = (-half, half), (0.0, leads.behind_mm), (-bend - TAIL_MM, half)
    of = "a motor" if leads.number == "motor_lead" else "a motor's encoder"
    return _bought(leads.number, f"lead of {of}, {_drawn(leads)}", shape, _mass_g(leads), extent)


def make_sensor_lead(s: SensorLeadDimensions) -> Part:
    """A lead of a board: from the header's lower face at the origin down, aside to the leg's face, and down again."""
    aside, bend, turn = hypot(*s.way_mm), s.bend_mm, s.turn_rad
    across = tuple(part / aside for part in s.way_mm)
    top = -PLUGGED_MM[2]

    def at_way(way: float, z: float) -> tuple[float, float, float]:
        return way * across[0], way * across[1], z

    low = top - STRAIGHT_MM
    away, down = bend * (1.0 - cos(turn)), bend * sin(turn)
    middle = bend * (1.0 - cos(turn / 2.0)), bend * sin(turn / 2.0)
    first, second = at_way(away, low - down), at_way(away + s.level_mm, low - down)
    adjacent, end = at_way(aside, low - 2.0 * down), at_way(aside, low - 2.0 * down - CLIP_MM[0] - TAIL_MM)
    pieces: list[tuple[tuple[float, float, float], ...]] = [
        (at_way(0.0, top), at_way(0.0, low)),
        (at_way(0.0, low), at_way(middle[0], low - middle[1]), first),
        (second, at_way(aside - middle[0], low - 2.0 * down + middle[1]), adjacent),
        (adjacent, end),
    ]
    if s.level_mm > 0.0:
        pieces.insert(2, (first, second))
    wide, high, _ = PLUGGED_MM
    half = SENSOR_MM / 2.0
    housing = box((-wide / 2.0, -high / 2.0, top), (wide / 2.0, high / 2.0, 0.0))
    shape = feature(SENSOR, "bends", "hardware.leads", lambda: fuse(housing, swept_round(pieces, SENSOR_MM)))
    extent = (-wide / 2.0, max(wide / 2.0, s.way_mm[0] + half)), (-high / 2.0, s.way_mm[1] + half), (end[2], 0.0)
    return _bought(
        SENSOR,
        f"lead of an encoder's board, its plug as assumed, measure the board; {_drawn(s)}",
        shape,
        _mass_g(s),
        extent,
    )


def make_lead_clip() -> Part:
    """A glued base with its tie about a lead: the base's foot at y = 0, the lead along z, outwards -y."""
    half, high, off = CLIP_MM[0] / 2.0, CLIP_MM[1], TIED_MM
    wide, thick = TIE_MM[0] / 2.0, TIE_MM[1]
    band = SENSOR_MM / 2.0 + thick
    base = box((-half, -high, -half), (half, 0.0, half))
    tie = cylinder(2.0 * band, (0.0, -off, -wide), (0.0, -off, wide))
    room = cylinder(SENSOR_MM, (0.0, -off, -half - 1.0), (0.0, -off, half + 1.0))
    shape = feature(CLIP, "tie", "hardware.leads", lambda: cut(fuse(base, tie), [room]))
    extent = (-half, half), (-off - band, 0.0), (-half, half)
    holes = (Hole(SENSOR_MM, 1, "the lead in its tie"),)
    return _bought(CLIP, "base for a cable tie, glued on, with its tie", shape, CLIP_G, extent, holes)


def _bought(number: str, text: str, shape: cq.Shape, mass: float, extent: Extent, holes: tuple[Hole, ...] = ()) -> Part:
    solid, stuff, code, source = one_solid(shape, number), material(_stuff(number)), CODES[number], _SOURCES[number]
    return Part(number, text, solid, stuff, False, holes, mass, extent_mm=extent, order_code=code, source=source)


def _drawn(one: LeadDimensions | SensorLeadDimensions) -> str:
    return f"drawn for {one.length_mm:.0f} mm; bent by {one.bend_mm:g} or more"


def _stuff(number: str) -> str:
    return "pa12" if number == CLIP else "rubber"


def _mass_g(one: LeadDimensions | SensorLeadDimensions) -> float:
    of_phase = isinstance(one, LeadDimensions) and one.number == "motor_lead"
    return (LEAD_G_M if of_phase else SENSOR_G_M) * one.length_mm / MM_PER_M
