"""The two cheeks of a chain and the foot block between them.

Cheeks and block are drawn in the shoulder's frame: origin in the chain's plane on the shoulder axis, x radial, y along
the shoulder axis, z up.
"""

from __future__ import annotations

from math import cos, degrees, pi, sin

import cadquery as cq
import numpy as np

from delta_cad import catalogue
from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.bracket import KEY_SLOT_MM, key_slot_floor_mm, key_slot_rad
from delta_cad.dimensions.capstan import CapstanDimensions
from delta_cad.dimensions.keys import motor_screw_mm
from delta_cad.dimensions.neighbours import BOARD_EDGE_MM
from delta_cad.dimensions.platform import BASE_SCREW
from delta_cad.dimensions.rules import require
from delta_cad.dimensions.tolerances import LENGTH_MM, minutes, seat_tilt_rad
from delta_cad.solids.making import hull_y, made_part
from delta_cad.solids.materials import material
from delta_cad.solids.part import Hole, Part
from delta_cad.solids.primitive import (
    THROUGH_MM,
    Circle,
    bore_y,
    bore_z,
    box,
    cut,
    edge_break,
    feature,
    fuse,
    hull_along_y,
)

BLOCK_SCREW = "M3"
BLOCK_THREAD_MM, BASE_THREAD_MM, DOWEL_DEPTH_MM = 7.0, 11.0, 6.0
DOWEL_MM = 3.0
BOARD_SCREW = "M2.5"
BOARD_THREAD_MM, BOARD_DRILL_MM = 8.0, 2.0  # thread, and the drill's way beyond it
STOP_SUNK_MM, STOP_ENGAGEMENT_MM = 0.5, 3.0
BLOCK_ENGAGEMENT_DIAMETERS = 1.2
ROUNDING_MM = 1e-9
DIRECTIONS = 721  # in which the end of a slot is looked for: a quarter of a degree


def motor_screw_positions(d: Dimensions) -> list[tuple[float, float]]:
    """(x, z) of the motor's mounting screws in the shoulder's frame."""
    b, radius = d.bracket, d.motor.mount_circle_mm / 2
    x, z = b.motor_axis_mm[0] - b.shoulder_u_mm, b.motor_axis_mm[1]
    return [(x + radius * cos(a), z + radius * sin(a)) for a in b.motor_screws_rad]


def board_screw_positions(d: Dimensions) -> list[tuple[float, float]]:
    """(x, z) of the encoder board's screws in the shoulder's frame; the board stands upright, its plug down."""
    half_x, half_z = d.encoder.hole_spacing_width_mm / 2, d.encoder.hole_spacing_length_mm / 2
    return [(sx * half_x, sz * half_z) for sx in (-1, 1) for sz in (-1, 1)]


def cheek_screw_positions(d: Dimensions) -> list[tuple[float, float]]:
    """(x, z) of the screws that hold a cheek to the foot block."""
    b = d.bracket
    return [(u - b.shoulder_u_mm, b.cheek_screw_z_mm) for u in b.cheek_screw_u_mm]


def cheek_dowel_positions(d: Dimensions) -> list[tuple[float, float]]:
    """(x, z) of the dowels that locate a cheek on the foot block."""
    b = d.bracket
    return [(u - b.shoulder_u_mm, b.cheek_screw_z_mm) for u in b.cheek_dowel_u_mm]


def block_thread_mm(d: Dimensions) -> float:
    """Depth of the foot block's threads from either side: they do not meet."""
    return min(BLOCK_THREAD_MM, (d.layers.motor_cheek_mm[0] - d.layers.encoder_cheek_mm[1]) / 2 - 0.5)


def cheek_screw_length_mm(d: Dimensions, thickness_mm: float) -> float:
    """Longest stock screw through a cheek that stays in its half of the foot block."""
    lengths = catalogue.screw(BLOCK_SCREW).lengths_mm
    return max(length for length in lengths if length <= thickness_mm + block_thread_mm(d))


def cheek_screw_sink_mm(d: Dimensions, thickness_mm: float) -> float:
    """Computes how deep the heads are sunk into a cheek: not at all, unless too little thread would be left."""
    length, row = cheek_screw_length_mm(d, thickness_mm), catalogue.screw(BLOCK_SCREW)
    if length - thickness_mm >= BLOCK_ENGAGEMENT_DIAMETERS * row.diameter_mm:
        return 0.0
    return thickness_mm + block_thread_mm(d) - length


def cheek_dowel_depth_mm(d: Dimensions) -> float:
    """Computes how deep a cheek's dowel stands in the foot block: clear of the base's screws and dowels."""
    return min(5.0, (d.layers.motor_cheek_mm[0] - d.layers.encoder_cheek_mm[1]) / 2 - 2.0)


def stopped_y_mm(d: Dimensions) -> float:
    """Face of the sector's web that the stop pin reaches into, or of the arm where there is no sector."""
    return d.layers.arm_mm[1] if d.capstan is None else d.capstan.web_y_mm[1]


def stop_pin_length_mm(d: Dimensions) -> float:
    """Shortest stock length of a stop pin that reaches into what it stops (sector or arm) deep enough."""
    top = stopped_y_mm(d)
    needed = d.layers.motor_cheek_mm[1] - STOP_SUNK_MM - (top - STOP_ENGAGEMENT_MM)
    stock = catalogue.dowel(f"{d.bracket.stop_pin_mm:g}").lengths_mm
    require(
        needed <= stock[-1],
        "stop_pin",
        "length",
        f"{needed:g} mm are needed; the longest in stock has {stock[-1]:g} mm",
    )
    return min(length for length in stock if length >= needed)


def board_thread_mm(d: Dimensions) -> tuple[float, float | None]:
    """Depth of the encoder board's threads, and where their drill ends along the shoulder's axis; None: through."""
    face, inside = d.layers.encoder_head_mm[0], d.layers.encoder_cheek_mm[1]
    deep = face + BOARD_THREAD_MM + BOARD_DRILL_MM
    return (BOARD_THREAD_MM, deep) if deep < inside - BOARD_DRILL_MM else (inside - face, None)


def _to_the_block(
    d: Dimensions, through: tuple[float, float], outside: float, outwards: float
) -> tuple[list[cq.Shape], list[Hole]]:
    """Tools and holes of a cheek's screws and dowels into the foot block; `outwards` is the sense of its outer face."""
    block, screws = catalogue.screw(BLOCK_SCREW), cheek_screw_positions(d)
    tools: list[cq.Shape] = [bore_y(block.clearance_hole_mm, at, through) for at in screws]
    tools += [bore_y(DOWEL_MM, at, through) for at in cheek_dowel_positions(d)]
    holes = [
        Hole(block.clearance_hole_mm, 2, f"{block.clearance_hole_mm:g} through, to the foot block"),
        Hole(DOWEL_MM, 2, f"{DOWEL_MM:g} H7 through, dowels of the foot block"),
    ]
    inside = d.layers.motor_cheek_mm[0] if outwards > 0.0 else d.layers.encoder_cheek_mm[1]
    sink = cheek_screw_sink_mm(d, abs(outside - inside))
    if sink > 0.0:
        sunk = sorted((outside - outwards * sink, outside + outwards * THROUGH_MM))
        tools += [bore_y(block.counterbore_diameter_mm, at, (sunk[0], sunk[1])) for at in screws]
        holes.append(Hole(block.counterbore_diameter_mm, 2, f"counterbore {sink:g} deep from the outer side"))
    return tools, holes


def key_slot_length_mm(d: Dimensions) -> float:
    """How far the slot of the set screws' key reaches from the motor's axis: to the edge of its cheek."""
    circles = np.array(d.bracket.motor_cheek_circles_mm)
    angle, (x, z, _) = key_slot_rad(d.bracket, d.motor), circles[1]
    turns = angle + np.linspace(-pi / 2, pi / 2, DIRECTIONS)[1:-1]
    normals = np.stack([np.cos(turns), np.sin(turns)])
    support = (circles[:, :2] @ normals + circles[:, 2:]).max(axis=0)
    return float(((support - np.array([x, z]) @ normals) / np.cos(turns - angle)).min())


def make_motor_cheek(d: Dimensions) -> Part:
    """Cheek with the motor's seat, the stop pins and (capstan) the shoulder bearing's seat, open towards the arm."""
    number, b = "motor_cheek", d.bracket
    inside, outside = d.layers.motor_cheek_mm
    through = (inside - THROUGH_MM, outside + THROUGH_MM)
    x, z = b.motor_axis_mm[0] - b.shoulder_u_mm, b.motor_axis_mm[1]
    outline = b.motor_cheek_circles_mm
    what = "motor diameter, base_radius_mm"
    body = feature(number, "outline", what, lambda: hull_along_y(outline, (inside, outside)))
    body = edge_break(number, body, ">Y or <Y", 0.5)
    screw = catalogue.screw(d.motor.mount_thread)
    seat_depth = motor_screw_mm(d.motor, d.layers)[1]
    motor_screws = motor_screw_positions(d)
    tools: list[cq.Shape] = [bore_y(d.motor.pilot_diameter_mm, (x, z), through)]
    tools += [bore_y(screw.clearance_hole_mm, at, through) for at in motor_screws]
    tools += [bore_y(screw.counterbore_diameter_mm, at, (through[0], inside + seat_depth)) for at in motor_screws]
    screwed, screwed_holes = _to_the_block(d, through, outside, 1.0)
    tools += screwed
    pins = [(u - b.shoulder_u_mm, height) for u, height in b.stop_pins_mm]
    tools += [bore_y(b.stop_pin_mm, at, through) for at in pins]
    holes = [
        Hole(d.motor.pilot_diameter_mm, 1, f"{d.motor.pilot_diameter_mm:g} H7 through, motor pilot"),
        Hole(screw.clearance_hole_mm, len(motor_screws), f"{screw.clearance_hole_mm:g} through, motor screws"),
        Hole(screw.counterbore_diameter_mm, len(motor_screws), f"counterbore {seat_depth:g} deep from the arm's side"),
        *screwed_holes,
        Hole(b.stop_pin_mm, len(pins), f"{b.stop_pin_mm:g} H7 through, stop pin pressed in"),
    ]
    if d.capstan is not None:
        tools += [
            *_bearing_seat(d, d.layers.bearings_mm[1][1], inside, 1.0),
            _set_screw_slot(d, d.capstan, (x, z), outline),
        ]
        deep, angle = key_slot_floor_mm(d.capstan, inside), degrees(key_slot_rad(b, d.motor))
        slot = f"slot {KEY_SLOT_MM:g} wide, {deep:.2f} deep from the arm's side, from the pilot's bore out to the edge"
        holes.append(Hole(KEY_SLOT_MM, 1, f"{slot} at {angle:.1f} deg to the plate's edge of the base", is_slot=True))
        holes += _bearing_holes(d, d.bearing.width_mm, "H7", "bearing seat")
    solid = feature(number, "bores", "motor, bearing", lambda: cut(body, tools))
    description = f"motor cheek, plate {outside - inside:g}{_reamed(d)}"
    extent = hull_y(outline, (inside, outside))
    return made_part(number, description, solid, material("aluminium-6082"), extent, holes)


def _set_screw_slot(d: Dimensions, c: CapstanDimensions, at: tuple[float, float], outline: list[Circle]) -> cq.Shape:
    """Slot from the pilot's bore out to the cheek's edge, through which a straight key reaches the set screws."""
    inside, half, angle = d.layers.motor_cheek_mm[0], KEY_SLOT_MM / 2, key_slot_rad(d.bracket, d.motor)
    along, aside = (cos(angle), sin(angle)), (-sin(angle), cos(angle))
    edge = max((x - at[0]) * along[0] + (z - at[1]) * along[1] + r for x, z, r in outline) + THROUGH_MM
    corners = [
        (at[0] + s * along[0] + t * aside[0], at[1] + s * along[1] + t * aside[1], 0.0)
        for s in (0.0, edge)
        for t in (-half, half)
    ]
    return hull_along_y(corners, (inside - THROUGH_MM, inside + key_slot_floor_mm(c, inside)))


def make_encoder_cheek(d: Dimensions) -> Part:
    """Cheek with the encoder's board and (capstan) the second bearing in a head that stands out from its leg."""
    number, b = "encoder_cheek", d.bracket
    outside, inside = d.layers.encoder_cheek_mm
    face = d.layers.encoder_head_mm[0]
    through = (face - THROUGH_MM, inside + THROUGH_MM)
    board = board_screw_positions(d) if d.sensed_at_shoulder else []
    head = [(0.0, 0.0, b.head_radius_mm), *((x, z, BOARD_EDGE_MM) for x, z in board)]
    leg = [b.leg_circle_mm, *b.foot_circles_mm] if d.capstan is not None else [*head, *b.foot_circles_mm]
    body = feature(number, "outline", "base_radius_mm", lambda: hull_along_y(leg, (outside, inside)))
    body = edge_break(number, body, ">Y or <Y", 0.5)
    if d.capstan is not None:
        round_head = bore_y(2 * b.head_radius_mm, (0.0, 0.0), (face, inside))
        upper = edge_break(number, hull_along_y(head, (face, inside)) if board else round_head, "<Y or >Y", 0.5)
        body = fuse(body, upper)
    screw = catalogue.screw(BOARD_SCREW)
    thread, drilled = board_thread_mm(d)
    tools: list[cq.Shape] = [bore_y(screw.tap_drill_mm, at, (through[0], drilled or through[1])) for at in board]
    screwed, screwed_holes = _to_the_block(d, through, outside, -1.0)
    tools += screwed
    callout = f"x {thread:g}, drilled {drilled - face:g} deep" if drilled else "through"
    holes = [
        *([Hole(screw.tap_drill_mm, len(board), f"{BOARD_SCREW} {callout}, encoder board")] if board else []),
        *screwed_holes,
    ]
    if d.preload is not None:
        tools += _bearing_seat(d, d.layers.bearings_mm[0][0] - d.preload.work_height_mm, inside, -1.0)
        depth = inside - d.layers.bearings_mm[0][0] + d.preload.work_height_mm
        holes += _bearing_holes(d, depth, "H6", "bearing slides, wave spring behind it")
    else:
        tools.append(bore_y(b.passage_mm, (0.0, 0.0), through))
        holes.append(Hole(b.passage_mm, 1, f"{b.passage_mm:g} through, passage of the stub"))
    solid = feature(number, "bores", "bearing, encoder", lambda: cut(body, tools))
    extent = hull_y([*leg, *head], (face, inside))
    description = f"encoder cheek, plate {inside - outside:g}, head {inside - face:.2f}{_reamed(d)}"
    return made_part(number, description, solid, material("aluminium-6082"), extent, holes)


def _reamed(d: Dimensions) -> str:
    """How a cheek's dowel holes are made, so that both bearings' seats are in line."""
    if d.capstan is None:
        return ""
    tilt = minutes(seat_tilt_rad(d.bracket))
    return f", dowel holes reamed on the foot block with a mandrel through both seats: they tilt by {tilt:.0f}' at most"


def _bearing_seat(d: Dimensions, floor: float, inside: float, outwards: float) -> list[cq.Shape]:
    """Seat from a cheek's inner face to its floor, and the passage through the lip."""
    clear = THROUGH_MM
    ends = sorted((inside - outwards * clear, floor))
    face = d.layers.motor_cheek_mm[1] if outwards > 0.0 else d.layers.encoder_head_mm[0]
    through = max(5.0, abs(face - floor) + clear)
    rest = sorted((inside - outwards * clear, floor + outwards * through))
    return [
        bore_y(d.bearing.outer_mm, (0.0, 0.0), (ends[0], ends[1])),
        bore_y(d.bracket.passage_mm, (0.0, 0.0), (rest[0], rest[1])),
    ]


def _bearing_holes(d: Dimensions, depth: float, fit: str, what: str) -> list[Hole]:
    outer = d.bearing.outer_mm
    return [
        Hole(outer, 1, f"{outer:g} {fit} x {depth:.3f} +-{LENGTH_MM:g} from the arm's side, {what}"),
        Hole(d.bracket.passage_mm, 1, f"{d.bracket.passage_mm:g} through, shaft passage and lip"),
    ]


def make_foot_block(d: Dimensions) -> Part:
    """Block between the cheeks, screwed to the base from below and located by two dowels."""
    number, b = "foot_block", d.bracket
    low, high = (u - b.shoulder_u_mm for u in b.foot_u_mm)
    y = (d.layers.encoder_cheek_mm[1], d.layers.motor_cheek_mm[0])
    middle, z = sum(y) / 2, (b.base_top_mm, b.base_top_mm + b.foot_height_mm)
    body = box((low, y[0], z[0]), (high, y[1], z[1]))
    body = edge_break(number, body, ">Z", 0.5)
    side, base = catalogue.screw(BLOCK_SCREW), catalogue.screw(BASE_SCREW)
    depth = block_thread_mm(d)
    tools: list[cq.Shape] = []
    for at in cheek_screw_positions(d):
        tools.append(bore_y(side.tap_drill_mm, at, (y[0] - THROUGH_MM, y[0] + depth)))
        tools.append(bore_y(side.tap_drill_mm, at, (y[1] - depth, y[1] + THROUGH_MM)))
    for at in cheek_dowel_positions(d):
        into = cheek_dowel_depth_mm(d)
        tools.append(bore_y(DOWEL_MM, at, (y[0] - THROUGH_MM, y[0] + into)))
        tools.append(bore_y(DOWEL_MM, at, (y[1] - into, y[1] + THROUGH_MM)))
    for u in b.base_screw_u_mm:
        tools.append(
            bore_z(base.tap_drill_mm, (u - b.shoulder_u_mm, middle), (z[0] - THROUGH_MM, z[0] + BASE_THREAD_MM))
        )
    for u in b.base_dowel_u_mm:
        tools.append(bore_z(DOWEL_MM, (u - b.shoulder_u_mm, middle), (z[0] - THROUGH_MM, z[0] + DOWEL_DEPTH_MM)))
    solid = feature(number, "bores", "parallelogram stack", lambda: cut(body, tools))
    holes = (
        Hole(side.tap_drill_mm, 2, f"{BLOCK_SCREW} x {depth:g} from both sides"),
        Hole(base.tap_drill_mm, 2, f"{BASE_SCREW} x {BASE_THREAD_MM:g} from below"),
        Hole(
            DOWEL_MM,
            4,
            f"{DOWEL_MM:g} H7: 2 x {DOWEL_DEPTH_MM:g} deep from below, "
            f"2 x {cheek_dowel_depth_mm(d):g} deep from both sides",
        ),
    )
    extent = (low, high), y, z
    description = f"foot block between the cheeks, {y[1] - y[0]:.3f} +-{LENGTH_MM:g} wide"
    return made_part(number, description, solid, material("aluminium-6082"), extent, holes)
