"""The two cheeks of a chain and the foot block between them.

Cheeks and block are drawn in the shoulder's frame: origin in the chain's plane on the shoulder axis, x radial, y along
the shoulder axis, z up.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from math import cos, degrees, dist, floor, pi, sin

import cadquery as cq
import numpy as np

from delta_cad import catalogue
from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.bracket import (
    BLOCK_SCREW,
    CHEEK_EDGE_MM,
    KEY_SLOT_MM,
    board_screw,
    key_rad,
    key_slot_floor_mm,
)
from delta_cad.dimensions.capstan import CapstanDimensions
from delta_cad.dimensions.layers import MOTOR_PLAY_MM, motor_screw_mm
from delta_cad.dimensions.platform import BASE_SCREW
from delta_cad.dimensions.rules import DRILL_DIAMETERS, require, tenths_above
from delta_cad.dimensions.tolerances import (
    LENGTH_MM,
    MANDREL_FIT,
    MOTOR_ZONE_MM,
    PLACE_MM,
    PREDRILLED_MM,
    SLOT_CUTTER_MM,
    SLOT_MM,
    STOP_ZONE_MM,
    TIP_DEG,
    drilled_mm,
    minutes,
    seat_tilt_rad,
    tip_mm,
)
from delta_cad.dimensions.tolerances.machine import board_zone_mm, square_zones
from delta_cad.dimensions.tolerances.mates import Locators, pair, screw_zone_mm
from delta_cad.dimensions.tolerances.square import ENCODER_SEAT, MOTOR_SEAT
from delta_cad.solids.boring import (
    Boring,
    along_y,
    along_z,
    blind,
    fitted,
    placed,
    reamed_with,
    slot,
    squared,
    sunk,
    tapped,
)
from delta_cad.solids.making import hull_y, made_part, material
from delta_cad.solids.part import Bore, Hole, Part
from delta_cad.solids.primitive import (
    THROUGH_MM,
    BuildError,
    Circle,
    bore_y,
    box,
    cut,
    edge_break,
    encloses_its_volume,
    feature,
    fuse,
    hull_along_y,
    round_inside,
)

_BLOCK_THREAD_MM, BASE_THREAD_MM, DOWEL_DEPTH_MM = 7.0, 11.0, 6.0  # usable; the block's threads go through
DOWEL_MM = 3.0
_BOARD_THREAD_MM = 8.0
_UNDER_TIP_MM = 1.4  # least metal before a blind drill's tip
_NEXT_TO_TIP_MM = 1.0  # from the tips of a foot block's cross dowels to its upright ones: else they end flat
STOP_SUNK_MM, STOP_ENGAGEMENT_MM = 0.5, 3.0
_BLOCK_ENGAGEMENT_DIAMETERS = 1.2
_PILOT_WALL_MM, _HEAD_PLAY_MM = 0.5, 0.3  # between a motor's pilot and its screws' counterbores; of diameter, in them
_ROUNDING_MM = 1e-9
# By which a leg's circle is smaller, which touches its head's from within: there the kernel may lose faces.
_OFF_TANGENT_MM = 0.0, 0.05, 0.1, 0.2
_DIRECTIONS = 721  # in which the edge of a cheek is looked for: a quarter of a degree


def base_pin_mm(d: Dimensions) -> tuple[float, float]:
    """Computes how deep a pin between base plate and foot block sits in the plate, and how much of both it may fill."""
    sunk = min(7.0, d.base.thickness_mm - 0.5)
    return sunk, sunk + DOWEL_DEPTH_MM - 0.5


def motor_screw_positions(d: Dimensions) -> list[tuple[float, float]]:
    """(x, z) of the motor's mounting screws in the shoulder's frame."""
    b, radius = d.bracket, d.motor.mount_circle_mm / 2
    x, z = b.motor_axis_mm[0] - b.shoulder_u_mm, b.motor_axis_mm[1]
    return [(x + radius * cos(a), z + radius * sin(a)) for a in b.motor_screws_rad]


def _motor_counterbore_mm(d: Dimensions) -> float:
    """Diameter of the counterbores of a motor's screws: smaller than usual where that leaves a wall to the pilot."""
    screw, m = d.motor.mount_screw, d.motor
    room = floor(10.0 * (m.mount_circle_mm - m.pilot_diameter_mm - 2 * _PILOT_WALL_MM) + _ROUNDING_MM) / 10.0
    usual = screw.counterbore_diameter_mm  # where no wall is left it opens into the pilot's bore
    return min(usual, room) if room >= screw.head_diameter_mm + _HEAD_PLAY_MM else usual


def cheek_screw_positions(d: Dimensions) -> list[tuple[float, float]]:
    """(x, z) of the screws that hold a cheek to the foot block."""
    b = d.bracket
    return [(u - b.shoulder_u_mm, b.cheek_screw_z_mm) for u in b.cheek_screw_u_mm]


def cheek_dowel_positions(d: Dimensions) -> list[tuple[float, float]]:
    """(x, z) of the dowels that locate a cheek on the foot block."""
    b = d.bracket
    return [(u - b.shoulder_u_mm, b.cheek_screw_z_mm) for u in b.cheek_dowel_u_mm]


def _block_thread_mm(d: Dimensions) -> float:
    """Depth that the foot block's threads are used to from either side: the screws do not meet."""
    return min(_BLOCK_THREAD_MM, (d.layers.motor_cheek_mm[0] - d.layers.encoder_cheek_mm[1]) / 2 - 0.5)


def cheek_screw_length_mm(d: Dimensions, thickness_mm: float) -> float:
    """Longest stock screw through a cheek that stays in its half of the foot block."""
    lengths = catalogue.screw(BLOCK_SCREW).lengths_mm
    return max(length for length in lengths if length <= thickness_mm + _block_thread_mm(d))


def cheek_screw_sink_mm(d: Dimensions, thickness_mm: float) -> float:
    """Computes how deep the heads are sunk into a cheek: not at all, unless too little thread would be left."""
    length, row = cheek_screw_length_mm(d, thickness_mm), catalogue.screw(BLOCK_SCREW)
    if length - thickness_mm >= _BLOCK_ENGAGEMENT_DIAMETERS * row.diameter_mm:
        return 0.0
    return thickness_mm + _block_thread_mm(d) - length


def is_slotted(d: Dimensions, side: str, k: int) -> bool:
    """Whether a cheek's dowel stands in a slot of the foot block: side "e" or "m", 0 or 1 along it."""
    cheek = "motor_cheek" if side == "m" else "encoder_cheek"
    return k == 1 and (side == "m" or d.capstan is None) and not _reamed_together(d, cheek, "foot_block")


def is_base_slotted(d: Dimensions) -> bool:
    """Whether the second dowel between base plate and foot block stands in a slot of the block."""
    return not _reamed_together(d, "base_plate", "foot_block")


def base_dowels(d: Dimensions, bores: Iterable[Bore]) -> list[Bore]:
    """The holes of a base plate for the dowels of the foot blocks: reamed, or reamed with the blocks at assembly."""
    reamed = [fitted(bore, "H7") for bore in bores]
    return reamed if is_base_slotted(d) else [reamed_with(one, "foot_block", PREDRILLED_MM) for one in reamed]


def cheek_dowel_depth_mm(d: Dimensions) -> float:
    """Computes how deep a cheek's dowel stands in the foot block: clear of the base's screws and dowels."""
    return min(5.0, (d.layers.motor_cheek_mm[0] - d.layers.encoder_cheek_mm[1]) / 2 - 2.0)


def _stopped_y_mm(d: Dimensions) -> float:
    """Face of the sector's web that the stop pin reaches into, or of the arm where there is no sector."""
    return d.layers.arm_mm[1] if d.capstan is None else d.capstan.web_y_mm[1]


def stop_end_mm(d: Dimensions) -> float:
    """Outer end of the stop pins: sunk in the motor's cheek, or in its pocket's floor where the motor covers one."""
    b, pocket = d.bracket, d.motor.diameter_mm / 2 + MOTOR_PLAY_MM + d.bracket.stop_pin_mm / 2
    covered = any(dist(pin, b.motor_axis_mm) < pocket for pin in b.stop_pins_mm)
    return (d.layers.motor_face_mm if covered else d.layers.motor_cheek_mm[1]) - STOP_SUNK_MM


def stop_pin_length_mm(d: Dimensions) -> float:
    """Shortest stock length of a stop pin that reaches into what it stops (sector or arm) deep enough."""
    top = _stopped_y_mm(d)
    needed = stop_end_mm(d) - (top - STOP_ENGAGEMENT_MM)
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
    face, inside, size = d.layers.encoder_head_mm[0], d.layers.encoder_cheek_mm[1], board_screw(d.encoder)
    deep = face + drilled_mm(size, _BOARD_THREAD_MM)
    tip = tip_mm(catalogue.screw(size).tap_drill_mm)
    return (_BOARD_THREAD_MM, deep) if deep + tip < inside - _UNDER_TIP_MM else (inside - face, None)


def _cheek_locators(d: Dimensions) -> Locators:
    """What holds the motor's cheek on the foot block, and of a direct drive the encoder's as well."""
    first, second = cheek_dowel_positions(d)
    return pair(first, second, PLACE_MM)


def _block_zone_mm(d: Dimensions) -> float:
    """Zone of the screws between foot block and cheeks: what both cheeks bear.

    Of a capstan's the encoder's cheek is set in line with the motor's: it is shifted up and down as that one's seat is,
    and gives way the other way by its turn about it.
    """
    row, located = catalogue.screw(BLOCK_SCREW), _cheek_locators(d)
    if _reamed_together(d, "motor_cheek", "encoder_cheek", "foot_block"):  # nothing but the screws locates them
        return screw_zone_mm(row.clearance_hole_mm, row.diameter_mm)
    taken = max(located.shift_mm(at) for at in cheek_screw_positions(d))
    if d.capstan is not None:
        taken = max(taken, located.shift_mm((0.0, 0.0), np.array([[0.0, 1.0], [0.0, -1.0]])))
    return screw_zone_mm(row.clearance_hole_mm, row.diameter_mm, taken)


def base_zone_mm(d: Dimensions) -> float:
    """Zone of the screws between base plate and foot blocks, which two pins locate."""
    row, b = catalogue.screw(BASE_SCREW), d.bracket
    if not is_base_slotted(d):
        return screw_zone_mm(row.clearance_hole_mm, row.diameter_mm)
    first, second = ((u, 0.0) for u in b.base_dowel_u_mm)
    located = pair(first, second, PLACE_MM)
    taken = max(located.shift_mm((u, 0.0)) for u in b.base_screw_u_mm)
    return screw_zone_mm(row.clearance_hole_mm, row.diameter_mm, taken)


def _reamed_together(d: Dimensions, *parts: str) -> bool:
    """Whether the dowels' holes of two parts are reamed through both at assembly: where either is printed."""
    return any(map(d.is_printed, parts))


def _to_the_block(d: Dimensions, boring: Boring, ends: tuple[float, float], number: str) -> None:
    """Adds a cheek's bores for the screws and dowels into the foot block, from its outer face to its inner one."""
    reamed = (number == "encoder_cheek" and d.capstan is not None) or _reamed_together(d, number, "foot_block")
    block, screws, (outside, inside) = catalogue.screw(BLOCK_SCREW), cheek_screw_positions(d), ends
    sink = cheek_screw_sink_mm(d, abs(outside - inside))
    seat = outside + (sink if inside > outside else -sink)
    zone = _block_zone_mm(d)
    rest = [placed(along_y(block.clearance_hole_mm, at, (seat, inside)), zone) for at in screws]
    boring.add(f"{block.clearance_hole_mm:g} through, to the foot block", rest)
    dowels = [fitted(along_y(DOWEL_MM, at, ends), "H7") for at in cheek_dowel_positions(d)]
    how = ""
    if reamed:
        dowels = [reamed_with(dowel, "foot_block", PREDRILLED_MM) for dowel in dowels]
        how = f", drilled {PREDRILLED_MM:g}, opened and reamed with the foot block at assembly"
    boring.add(f"{DOWEL_MM:g} H7 through, dowels of the foot block{how}", dowels)
    if sink > 0.0:
        heads = [sunk(along_y(block.counterbore_diameter_mm, at, (outside, seat))) for at in screws]
        boring.add(f"counterbore {sink:g} deep from the outer side", heads)


def key_way_mm(d: Dimensions, c: CapstanDimensions) -> float:
    """How far a key of the pinion's set screws reaches from the motor's axis: to the edge of the motor's cheek."""
    circles = np.array(d.bracket.motor_cheek_circles_mm)
    angle, (x, z, _) = key_rad(c, d.bracket, d.motor), circles[1]
    turns = angle + np.linspace(-pi / 2, pi / 2, _DIRECTIONS)[1:-1]
    normals = np.stack([np.cos(turns), np.sin(turns)])
    support = (circles[:, :2] @ normals + circles[:, 2:]).max(axis=0)
    return float(((support - np.array([x, z]) @ normals) / np.cos(turns - angle)).min())


def make_motor_cheek(d: Dimensions) -> Part:
    """Cheek with the motor's seat, the stop pins and (capstan) the shoulder bearing's seat, open towards the arm."""
    number, b = "motor_cheek", d.bracket
    inside, outside = d.layers.motor_cheek_mm
    x, z = b.motor_axis_mm[0] - b.shoulder_u_mm, b.motor_axis_mm[1]
    outline = b.motor_cheek_circles_mm
    what = "motor diameter, base_radius_mm"
    body = feature(number, "outline", what, lambda: hull_along_y(outline, (inside, outside)))
    body = edge_break(number, body, ">Y or <Y", CHEEK_EDGE_MM)
    screw = d.motor.mount_screw
    seat_depth = motor_screw_mm(d.motor, d.layers)[1]
    motor_screws = motor_screw_positions(d)
    boring, face, tools, slots = Boring(), d.layers.motor_face_mm, list[cq.Shape](), list[Hole]()
    if d.layers.motor_pocket_mm > 0.0:
        wide = d.motor.diameter_mm + 2 * MOTOR_PLAY_MM
        pocket = sunk(along_y(wide, (x, z), (outside, face)))
        boring.add(f"pocket {d.layers.motor_pocket_mm:.1f} deep from the outer side, motor", [pocket])
    off = PLACE_MM if d.capstan is not None else 0.0
    upright = PLACE_MM if d.capstan is None else 0.0  # else within its zone of position
    pilot = squared(fitted(along_y(d.motor.pilot_diameter_mm, (x, z), (face, inside)), "H7", off), upright)
    boring.add(f"{d.motor.pilot_diameter_mm:g} H7 through, motor pilot", [pilot])
    seat = inside + seat_depth
    zone = screw_zone_mm(screw.clearance_hole_mm, screw.diameter_mm, max(off, upright) / 2.0, MOTOR_ZONE_MM)
    rest = [placed(along_y(screw.clearance_hole_mm, at, (seat, face)), zone) for at in motor_screws]
    boring.add(f"{screw.clearance_hole_mm:g} through, motor screws", rest)
    heads = [sunk(along_y(_motor_counterbore_mm(d), at, (inside, seat))) for at in motor_screws]
    boring.add(f"counterbore {seat_depth:g} deep from the arm's side", heads)
    _to_the_block(d, boring, (outside, inside), number)
    pins = [(u - b.shoulder_u_mm, height) for u, height in b.stop_pins_mm]
    pressed = [fitted(along_y(b.stop_pin_mm, at, (inside, outside)), "H7", STOP_ZONE_MM) for at in pins]
    boring.add(f"{b.stop_pin_mm:g} H7 through, stop pin pressed in", pressed)
    if d.capstan is not None:
        if d.capstan.collar_at_motor:
            tools.append(_set_screw_slot(d, d.capstan, (x, z), outline))
            deep, angle = key_slot_floor_mm(d.capstan, inside), degrees(key_rad(d.capstan, b, d.motor))
            slot = f"slot {KEY_SLOT_MM:g} wide, {deep:g} deep from the arm's side, from the pilot's bore to the edge"
            line = f"on a line through the pilot's middle at {angle:.1f} deg to the lower edge"
            slots.append(Hole(KEY_SLOT_MM, 1, f"{slot}, {line}", is_slot=True))
        _bearing_seat(d, boring, (inside, d.layers.bearings_mm[1][1], outside), "H7", "bearing seat")
    solid = feature(number, "bores", "motor, bearing", lambda: cut(body, [*boring.tools, *tools]))
    description = f"motor cheek, plate {outside - inside:g}"
    extent = hull_y(outline, (inside, outside))
    return made_part(number, description, solid, material(d.material_of(number)), extent, [*boring.holes, *slots])


def _set_screw_slot(d: Dimensions, c: CapstanDimensions, at: tuple[float, float], outline: list[Circle]) -> cq.Shape:
    """Slot from the pilot's bore out to the cheek's edge, through which a straight key reaches the set screws."""
    inside, half, angle = d.layers.motor_cheek_mm[0], KEY_SLOT_MM / 2, key_rad(c, d.bracket, d.motor)
    along, aside = (cos(angle), sin(angle)), (-sin(angle), cos(angle))
    edge = max((x - at[0]) * along[0] + (z - at[1]) * along[1] + r for x, z, r in outline) + THROUGH_MM
    corners = [
        (at[0] + s * along[0] + t * aside[0], at[1] + s * along[1] + t * aside[1], 0.0)
        for s in (0.0, edge)
        for t in (-half, half)
    ]
    return hull_along_y(corners, (inside - THROUGH_MM, inside + key_slot_floor_mm(c, inside)))


def _encoder_leg(d: Dimensions, off_mm: float) -> list[Circle]:
    """Circles of an encoder's leg, its upper one smaller than it should be."""
    if d.capstan is None:
        return [*d.encoder_head_circles_mm, *d.bracket.foot_circles_mm]
    x, z, radius = d.bracket.leg_circle_mm
    return [(x, z, radius - off_mm), *d.bracket.foot_circles_mm]


def _encoder_body(d: Dimensions, leg: list[Circle]) -> cq.Shape:
    """An encoder's cheek before its bores, its leg the hull of circles."""
    number, (outside, inside), board = "encoder_cheek", d.layers.encoder_cheek_mm, d.board_screws_mm
    face, head = d.layers.encoder_head_mm[0], d.encoder_head_circles_mm
    body = feature(number, "outline", "base_radius_mm", lambda: hull_along_y(leg, (outside, inside)))
    if d.capstan is not None and board:
        adjacent = round_inside(number, fuse(body, hull_along_y(head, (outside, inside))), (0.0, 1.0, 0.0))
        body = edge_break(number, adjacent, ">Y or <Y", CHEEK_EDGE_MM)
    else:
        body = edge_break(number, body, ">Y or <Y", CHEEK_EDGE_MM)
    if d.capstan is None:
        return body
    round_head = bore_y(2 * d.bracket.head_radius_mm, (0.0, 0.0), (face, inside))
    upper = hull_along_y(head, (face, inside)) if board else round_head
    return fuse(body, edge_break(number, upper, "<Y or >Y", CHEEK_EDGE_MM))


def _sound_encoder_body(d: Dimensions) -> cq.Shape:
    """Sets the leg off its head until the kernel makes a whole body; raises as the last one where it makes none."""
    refused = BuildError("encoder_cheek", "leg and head", "base_radius_mm")
    for off in _OFF_TANGENT_MM:
        try:
            body = _encoder_body(d, _encoder_leg(d, off))
        except BuildError as error:  # a chamfer of a face that is lost
            refused = error
            continue
        if encloses_its_volume(body):
            return body
    raise refused


def make_encoder_cheek(d: Dimensions) -> Part:
    """Cheek with the encoder's board and (capstan) the second bearing in a head that stands out from its leg."""
    number, b = "encoder_cheek", d.bracket
    outside, inside = d.layers.encoder_cheek_mm
    face = d.layers.encoder_head_mm[0]
    board, head = d.board_screws_mm, d.encoder_head_circles_mm
    body, leg = _sound_encoder_body(d), _encoder_leg(d, 0.0)
    thread, drilled = board_thread_mm(d)
    boring = Boring()
    callout = f"x {thread:g}, drilled {drilled - face:g} deep" if drilled else "through"
    size = board_screw(d.encoder)
    threads = [tapped(along_y(0.0, at, (face, inside)), size, thread if drilled else None) for at in board]
    boring.add(f"{size} {callout}, encoder board", (placed(one, board_zone_mm(d.encoder)) for one in threads))
    _to_the_block(d, boring, (outside, inside), number)
    if d.preload is not None:
        floor = d.layers.bearings_mm[0][0] - d.preload.work_height_mm
        _bearing_seat(d, boring, (inside, floor, face), "H6", "bearing slides, wave spring behind it")
    else:
        passage = along_y(b.passage_mm, (0.0, 0.0), (face, inside))
        boring.add(f"{b.passage_mm:g} through, passage of the stub", [passage])
    solid = feature(number, "bores", "bearing, encoder", lambda: cut(body, boring.tools))
    extent = hull_y([*leg, *head], (face, inside))
    description = f"encoder cheek, plate {inside - outside:g}, head {inside - face:g}{_reamed(d)}"
    return made_part(number, description, solid, material(d.material_of(number)), extent, boring.holes)


def _reamed(d: Dimensions) -> str:
    """How the encoder's cheek gets its dowel holes, so that both bearings' seats are in line."""
    if d.capstan is None:
        return ""
    tilt = minutes(seat_tilt_rad(d.bracket))
    mandrel = f"a mandrel {d.bearing.outer_mm:g} {MANDREL_FIT} in both seats"
    return f", dowel holes reamed on the foot block with {mandrel}: the seats are in line to {tenths_above(tilt):g}'"


def _bearing_seat(d: Dimensions, boring: Boring, ends: tuple[float, float, float], fit: str, what: str) -> None:
    """Adds a seat from a cheek's inner face to its floor, and the passage through the lip to the outer face."""
    outer, passage, axis = d.bearing.outer_mm, d.bracket.passage_mm, (0.0, 0.0)
    inside, floor, face = ends
    own = MOTOR_SEAT if inside > 0.0 else ENCODER_SEAT
    seat = squared(fitted(blind(along_y(outer, axis, (inside, floor))), fit, 0.0), square_zones(d)[own])
    boring.add(f"{outer:g} {fit} x {seat.depth_mm:g} +-{LENGTH_MM:g} from the arm's side, {what}", [seat])
    boring.add(f"{passage:g} through, shaft passage and lip", [along_y(passage, axis, (floor, face))])


def _block_thread(at: tuple[float, float], ends: tuple[float, float], depth_mm: float, through: bool) -> Bore:
    """A thread for a cheek's screw at a place (x, z), from the first of the block's faces at y; or drilled through."""
    whole = along_y(0.0, at, ends)
    return replace(tapped(whole, BLOCK_SCREW), thread_mm=depth_mm) if through else tapped(whole, BLOCK_SCREW, depth_mm)


def make_foot_block(d: Dimensions) -> Part:
    """Block between the cheeks, screwed to the base from below and located by two dowels, the second in a slot."""
    number, b = "foot_block", d.bracket
    low, high = (u - b.shoulder_u_mm for u in b.foot_u_mm)
    y = (d.layers.encoder_cheek_mm[1], d.layers.motor_cheek_mm[0])
    middle, z = sum(y) / 2, (b.base_top_mm, b.base_top_mm + b.foot_height_mm)
    body = box((low, y[0], z[0]), (high, y[1], z[1]))
    body = edge_break(number, body, ">Z", CHEEK_EDGE_MM)
    depth, boring = _block_thread_mm(d), Boring()
    through, zone = y[1] - y[0] <= DRILL_DIAMETERS * catalogue.screw(BLOCK_SCREW).tap_drill_mm, _block_zone_mm(d)
    cross, back = (
        [placed(_block_thread(at, ends, depth, through), zone) for at in cheek_screw_positions(d)]
        for ends in (y, (y[1], y[0]))
    )
    sides = f"{BLOCK_SCREW} x {depth:g} from both sides"
    if through:
        boring.add(f"{sides}, drilled through", cross, back)
    else:
        boring.add(sides, [*cross, *back])
    up = [tapped(along_z(0.0, (u - b.shoulder_u_mm, middle), z), BASE_SCREW) for u in b.base_screw_u_mm]
    up = [placed(one, base_zone_mm(d)) for one in up]
    boring.add(f"{BASE_SCREW} through, screws from below reach {BASE_THREAD_MM:g} at most", up)
    _block_dowels(d, boring, y, (middle, z[0]))
    solid = feature(number, "bores", "parallelogram stack", lambda: cut(body, boring.tools))
    extent = (low, high), y, z
    tolerance = "" if d.is_printed(number) else f" +-{LENGTH_MM:g}"
    description = f"foot block between the cheeks, {y[1] - y[0]:g}{tolerance} wide"
    return made_part(number, description, solid, material(d.material_of(number)), extent, boring.holes)


def _block_dowels(d: Dimensions, boring: Boring, y: tuple[float, float], below: tuple[float, float]) -> None:
    """Adds a foot block's holes and slots for the dowels of plate and cheeks.

    Args:
        d: The dimensions.
        boring: What is bored into the block.
        y: Its faces on the encoder's and on the motor's cheek.
        below: (y, z) of its middle on the plate.
    """
    b, into, (middle, low) = d.bracket, cheek_dowel_depth_mm(d), below
    tip = TIP_DEG if middle - y[0] - into - tip_mm(DOWEL_MM) >= DOWEL_MM / 2 + _NEXT_TO_TIP_MM else 0.0
    ends = (low, low + DOWEL_DEPTH_MM)
    first, second = (along_z(DOWEL_MM, (u - b.shoulder_u_mm, middle), ends) for u in b.base_dowel_u_mm)
    x = (1.0, 0.0, 0.0)
    slots = []
    if is_base_slotted(d):
        boring.add(
            f"{DOWEL_MM:g} H7 x {DOWEL_DEPTH_MM:g} from below, dowel",
            [squared(fitted(blind(first, tip), "H7", 0.0), PLACE_MM)],
        )
        slots.append((f"{DOWEL_DEPTH_MM:g} deep from below", slot(fitted(blind(second), "H7"), x)))
    else:
        reamed = [reamed_with(fitted(blind(pin, tip), "H7"), "base_plate") for pin in (first, second)]
        how = "not before assembly, through the base plate, reamed with it"
        boring.add(f"{DOWEL_MM:g} H7 x {DOWEL_DEPTH_MM:g} from below, {how}", reamed)
    for k, (side, sense) in enumerate((("encoder", 1.0), ("motor", -1.0))):
        pins = [along_y(DOWEL_MM, at, (y[k], y[k] + sense * into)) for at in cheek_dowel_positions(d)]
        if is_slotted(d, side[0], 1):
            round_hole, far = pins
            callout = f"{DOWEL_MM:g} H7 x {into:g} from the {side}'s side, dowel"
            boring.add(callout, [fitted(blind(round_hole, tip), "H7")])
            slots.append((f"{into:g} from the {side}'s side", slot(fitted(blind(far), "H7"), x)))
        else:
            reamed = [reamed_with(fitted(blind(pin, tip), "H7"), f"{side}_cheek") for pin in pins]
            how = f"not before assembly, through the {side}'s cheek, reamed with it"
            boring.add(f"{DOWEL_MM:g} H7 x {into:g} from the {side}'s side, {how}", reamed)
    if slots:
        long = f"{DOWEL_MM + SLOT_MM:g} long, R{SLOT_CUTTER_MM / 2:g}, their long sides in the line of the dowels"
        deep = ", ".join(text for text, _ in slots)
        boring.add_slots(f"slot {DOWEL_MM:g} H7 wide, {long}: {deep}", [one for _, one in slots])
