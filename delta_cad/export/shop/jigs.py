"""Jigs that the manual works with, made once for any number of machines: parts, drawings, rows of the bill.

The rod jig holds the seats of a rod apart while its tube is bonded, the seat gauge has a ball that goes in a lapped
seat and one that does not, the mandrel stands in both bearings' seats of a drive while dowel holes are reamed. Their
sizes are those of the machine, their tolerances those that its chains have for them.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from math import ceil, sqrt
from pathlib import Path

import cadquery as cq

from delta_cad.common.units import G_PER_KG, MM_PER_M
from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.forearm import EYE_WALL_MM
from delta_cad.dimensions.joint import CLEARANCE_TOLERANCE_MM
from delta_cad.dimensions.tolerances import (
    FITTED_RA_UM,
    JIG_DEPTH_MM,
    JIG_MOUTH_MM,
    LIP_ROOM_MM,
    MANDREL_FIT,
    PLACE_MM,
)
from delta_cad.export.bom import MASS_DECIMALS, BomRow
from delta_cad.export.drawings.part.controlled import Controlled, Length, Round
from delta_cad.export.drawings.title import grams
from delta_cad.export.drawings.write import Drawn, titles_of, write_part_drawing
from delta_cad.export.shop.quotation import QuotedPart, quoted
from delta_cad.export.step import write_part_step
from delta_cad.solids.boring import Boring, along_z, blind, placed, within
from delta_cad.solids.making import made_part, material, ordered, round_z
from delta_cad.solids.part import Part
from delta_cad.solids.primitive import bore_z, box, cut, feature, fuse

FOLDER = "jigs"
ROD_JIG, SEAT_GAUGE, MANDREL = "rod_jig", "seat_gauge", "seat_mandrel"
JIG = "jig"  # in the bill's column "make_or_buy": of the shop's, no part of the machine
_CONE_DEG = 90.0
_MOUTH_MM = 0.15  # radial, of a cone's wall around its ball, which ends in it
_RELIEF_MM = 2.0  # bore through a cone's tip: surplus adhesive, and a drift for the ball
_PAST_MM, _UNDER_MM, _FLOOR_MM = 6.0, 1.5, 8.0  # of the rod jig: past a cup, under an eye's ring, below that
_STEM_MM = 0.5  # from a pad to the end of a rod, which reaches down beside it
_HANDLE_MM = 60.0
_GROOVE_MM = (6.0, 1.0, 0.5)  # of the gauge's end that does not go: from the end, width, depth
_GRIP_MM = 15.0  # of the mandrel past either cheek, to turn it by
_END_MM, _GRIP_PLAY_MM = 0.5, 0.5  # of the mandrel off a seat's floor, and radial in the lip
_BALLS = {"rod_jig_ball": 2, "seat_gauge_go": 1, "seat_gauge_no_go": 1}
_GAUGE_BALL = "to size; verified: no, from memory: makers of gauge balls grind any diameter"


@dataclass(frozen=True)
class Jig:
    """A made jig: its part, and what of it is held closer than the general tolerance."""

    part: Part
    held: Controlled


def jigs_of(d: Dimensions) -> tuple[Jig, ...]:
    """Makes the jigs of a machine; a direct drive has no bearings' seats, and no mandrel.

    Raises:
        BuildError: A solid could not be built.
    """
    found = (_rod_jig(d), _seat_gauge(d))
    return found if d.preload is None else (*found, _mandrel(d))


def gauge_balls_mm(d: Dimensions) -> tuple[float, float]:
    """Gives the diameters of the ball that goes in a finished seat and of the one that does not: the seat's limits."""
    seat = d.forearm.seat_diameter_mm
    return seat - 2 * CLEARANCE_TOLERANCE_MM, seat + 2 * CLEARANCE_TOLERANCE_MM


def _cone(radius: float) -> tuple[float, float]:
    """Radius of a cone's mouth for a ball, and how far the mouth lies below the ball's centre, mm."""
    mouth = radius + _MOUTH_MM
    return mouth, sqrt(2.0) * radius - mouth


def _rod_jig(d: Dimensions) -> Jig:
    """Bar along x with two pads; its balls' centres at (0, 0, 0) and a rod's length along x."""
    f = d.forearm
    mouth, below = _cone(f.ball_diameter_mm / 2)
    top = round(f.lip_mm - LIP_ROOM_MM, 2)  # both cups' lips lie over the pads, which keep them level
    floor = -max(f.eye_ring_mm / 2, f.eye_hole_y_mm + f.eye_diameter_mm / 2 + EYE_WALL_MM) - _UNDER_MM
    bottom, wide = floor - _FLOOR_MM, float(round(f.cup_radius_mm + _PAST_MM))
    pad = f.stem_mm - _STEM_MM
    boring, ends = Boring(), ((0.0, 0.0), (f.length_mm, 0.0))
    seats = [blind(along_z(2 * mouth, at, (top, -below)), _CONE_DEG) for at in ends]
    um = 1000.0 * JIG_MOUTH_MM
    boring.add(
        f"seat {2 * mouth:g} x {top + below:.2f} +-{JIG_DEPTH_MM:g}, below it a cone of {_CONE_DEG:g} deg: ball bonded "
        "in it",
        [within(placed(seat, PLACE_MM), -um, um) for seat in seats],
    )
    boring.add(f"{_RELIEF_MM:g} through", (along_z(_RELIEF_MM, at, (top, bottom)) for at in ends))

    def body() -> cq.Shape:
        bar = box((-wide, -wide, bottom), (f.length_mm + wide, wide, top))
        way = box((pad, -wide - 1.0, floor), (f.length_mm - pad, wide + 1.0, top + 1.0))
        return cut(cut(bar, [way]), boring.tools)

    solid = feature(ROD_JIG, "pads", "forearm_length_mm", body)
    text = (
        f"rod jig, two balls {f.ball_diameter_mm:g} bonded in its cones; their centres {f.length_mm:.3f} apart, as "
        "both seats of a rod"
    )
    extent = (-wide, f.length_mm + wide), (-wide, wide), (bottom, top)
    part = made_part(ROD_JIG, text, solid, material("aluminium-6082"), extent, boring.holes)
    return Jig(part, Controlled(depths=(Length(2, top, -below, JIG_DEPTH_MM),), seat=(2, top)))


def _seat_gauge(d: Dimensions) -> Jig:
    """Round handle along z with a cone in either end, the one that does not go at z = 0, with a groove beside it."""
    goes, not_goes = gauge_balls_mm(d)
    mouth = ceil(9.2 * goes / 2) / 10.0  # so wide that the ball meets the cone alone, in tenths
    radius = float(round(mouth + 1.5))
    from_end, groove, deep = _GROOVE_MM
    boring, axis, wall = Boring(), (0.0, 0.0), 0.2
    ends = ((0.0, wall), (_HANDLE_MM, _HANDLE_MM - wall))
    boring.add(
        f"seat {2 * mouth:g} x {wall:g} in either end, below it a cone of {_CONE_DEG:g} deg: ball bonded in it",
        [blind(along_z(2 * mouth, axis, end), _CONE_DEG) for end in ends],
    )
    ring = bore_z(2 * radius + 1.0, axis, (from_end, from_end + groove))
    ring = cut(ring, [bore_z(2 * (radius - deep), axis, (from_end - 1.0, from_end + groove + 1.0))])
    body = bore_z(2 * radius, axis, (0.0, _HANDLE_MM))
    solid = feature(SEAT_GAUGE, "cones", "hardware.ball_diameter_mm", lambda: cut(body, [ring, *boring.tools]))
    text = (
        f"gauge of a joint's seat, balls bonded in its ends: {goes:.3f} goes in and turns; {not_goes:.3f}, at the "
        "groove, stands on the rim"
    )
    extent = round_z(radius, (0.0, _HANDLE_MM))
    part = made_part(SEAT_GAUGE, text, solid, material("stainless-1.4305"), extent, boring.holes)
    return Jig(part, Controlled())


def _mandrel(d: Dimensions) -> Jig:
    """Round bar along z, as the shoulder's axis runs: it fills both seats, its grips come out through both lips."""
    assert d.preload is not None
    low, high = d.layers.bearings_mm[0][0] - d.preload.work_height_mm + _END_MM, d.layers.bearings_mm[1][1] - _END_MM
    outer, grip = d.bearing.outer_mm, d.bracket.passage_mm - 2 * _GRIP_PLAY_MM
    ends = d.layers.encoder_head_mm[0] - _GRIP_MM, d.layers.motor_cheek_mm[1] + _GRIP_MM
    long, axis = high - low, (0.0, 0.0)
    grips = bore_z(grip, axis, (ends[0] - low, ends[1] - low))
    solid = feature(MANDREL, "grips", "hardware.bearing", lambda: fuse(bore_z(outer, axis, (0.0, long)), grips))
    text = (
        f"mandrel {outer:g} {MANDREL_FIT} x {long:.1f} for both bearings' seats of a drive; grips {grip:g} reach out "
        "through their lips"
    )
    extent = round_z(outer / 2, (ends[0] - low, ends[1] - low))
    part = made_part(MANDREL, text, solid, material("stainless-1.4305"), extent)
    return Jig(part, Controlled(rounds=(Round(outer, MANDREL_FIT, surface_um=FITTED_RA_UM[6]),)))


def _mass_g(part: Part) -> float:
    return part.solid.Volume() / MM_PER_M**3 * part.material.density_kg_m3 * G_PER_KG


def jig_rows(d: Dimensions, first: int) -> Iterator[BomRow]:
    """Gives the rows of a bill for a machine's jigs and their balls, of no price, from an item on."""
    item = first
    for jig in jigs_of(d):
        grams_ = round(_mass_g(jig.part), MASS_DECIMALS)
        name, description, substance = jig.part.number, jig.part.description, jig.part.material.name
        yield BomRow(item, name, description, 1, JIG, substance, grams_, grams_, "", "", "")
        item += 1
    f, (goes, not_goes) = d.forearm, gauge_balls_mm(d)
    order = ordered(f.ball)
    standard, substance = order.get("standard", ""), material(f.ball.material).name
    sizes = dict(zip(_BALLS, (f.ball_diameter_mm, goes, not_goes), strict=True))
    for number, size in sizes.items():
        gauged = number != "rod_jig_ball"
        text = f"gauge ball {size:.3f}" if gauged else f"{f.ball.description}, for the rod jig"
        code = f"gauge ball {size:.3f} +-0.0005 G10 100Cr6" if gauged else order.get("order_code", "")
        source = _GAUGE_BALL if gauged else order.get("source", "")
        mass = round(f.ball.mass_g * (size / f.ball_diameter_mm) ** 3, MASS_DECIMALS)
        count = _BALLS[number]
        total = round(count * mass, MASS_DECIMALS)
        yield BomRow(item, number, text, count, JIG, substance, mass, total, standard, code, source)
        item += 1


def write_jigs(d: Dimensions, folder: Path) -> Drawn:
    """Writes STEP file and drawing of each jig into a folder, made if it is not there.

    Returns:
        What came of the drawings.

    Raises:
        OSError: They cannot be written.
    """
    folder.mkdir(exist_ok=True)
    drawn = Drawn()
    for jig in jigs_of(d):
        write_part_step(jig.part, folder / f"{jig.part.number}.step", held=jig.held, revision=d.design.drawn_revision)
        drawn += write_part_drawing(jig.part, jig.held, titles_of(d, jig.part, 1, grams(_mass_g(jig.part))), folder)
    return drawn


def quoted_jigs(d: Dimensions) -> list[QuotedPart]:
    """Lists a machine's jigs for a quotation."""
    return [quoted(jig.part, titles_of(d, jig.part, 1, grams(_mass_g(jig.part)))) for jig in jigs_of(d)]
