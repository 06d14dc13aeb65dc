"""The drives placed on their links: capstan, or motor on the shoulder's axis."""

from __future__ import annotations

from math import cos, sin

import numpy as np

from delta_cad import catalogue
from delta_cad.assembly.builder import (
    CABLE_OFF_MM,
    CHAMFERS_MM,
    DRIVEN,
    IN,
    NEXT_TO_MM,
    OUT,
    SEATED_MM,
    SHARE,
    AssemblyBuilder,
    Connection,
    InsertionPath,
    at,
    bolted,
    longest,
    longest_set_screw,
    pointing,
    pressed,
    ring,
    seated,
    wound,
)
from delta_cad.assembly.leads import lead_names
from delta_cad.assembly.machine import PathSegment
from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.arm import CLAMP_SCREW, INSIDE_RING_MM, WASHER_MM
from delta_cad.dimensions.capstan import (
    CARRIAGE_MM,
    CRIMP_MM,
    POCKET_CORNER_MM,
    POCKET_PLAY_MM,
    SET_SCREW,
    SHAFT_ENGAGEMENT_MM,
    SLEEVE_OVER_MM,
    TENSION_SCREW,
    TENSION_SCREW_LENGTH_MM,
    CapstanDimensions,
    carriage_frame,
    sleeve_frames,
)
from delta_cad.dimensions.layers import motor_screw_mm
from delta_cad.interference.ferrule_insertion import second_way_rad
from delta_cad.solids import bought_parts, capstan, upper_arm
from delta_cad.solids.bought_parts import make_bearing, make_wave_spring
from delta_cad.solids.part import Removal, ToolAccess

_THREADED_MM = 0.07  # from a cable, drawn thinner, to its sleeve's bore, at most
_ADJACENT = (  # what of an arm passes what of its own bracket at less than the clearance of others
    ("crimp_sleeve_{}_0", "motor_cheek_{}"),
    ("capstan_cable_{}_inner", "motor_cheek_{}"),
    ("capstan_cable_{}_inner_end", "motor_cheek_{}"),
    ("shoulder_washer_{}", "motor_cheek_{}"),
    ("shoulder_shaft_{}", "encoder_cheek_{}"),
    ("shoulder_shaft_{}", "wave_spring_{}"),
    *((f"sector_dowel_{{}}_{k}", "encoder_cheek_{}") for k in range(2)),
)
_LOOSE_MM = 0.5  # way of a set screw that leaves its shaft free


def _motor_screws(builder: AssemblyBuilder, i: int) -> list[str]:
    return [f"motor_screw_{i}_{k}" for k in range(len(builder.d.bracket.motor_screws_rad))]


def place_direct(builder: AssemblyBuilder, i: int) -> None:
    """Places the clamp of an arm on its motor's shaft, and notes what is close there."""
    d, m, arm, motor = builder.d, builder.d.motor, f"upper_arm_{i}", f"motor_{i}"
    builder.gap(arm, f"motor_cheek_{i}", NEXT_TO_MM, "arm turns beside the cheek, 1 mm by design")
    clamp = builder.screw(CLAMP_SCREW, upper_arm.SHOULDER_SCREW_LENGTH_MM)
    seat = pointing((-1, 0, 0), upper_arm.SHOULDER_SEAT_X_MM, 0.0, d.arm.shoulder_clamp_z_mm)
    builder.put(f"shoulder_clamp_{i}", clamp, arm, seat, path=DRIVEN)
    clamped = d.layers.arm_mm[1] - (d.layers.motor_face_mm - m.shaft_length_mm)
    least = min(clamped, m.shaft_diameter_mm / 2)
    builder.connect(motor, pressed(arm, least, "the arm is clamped on the motor's shaft"))
    if d.sensed_at_shoulder:
        builder.gap(f"shoulder_shaft_{i}", motor, 0.3, "end of the motor's shaft before the stub, 0.5 mm by design")
    for screw in _motor_screws(builder, i):
        builder.gap(arm, screw, NEXT_TO_MM, "turns beside the sunk heads, 1.4 mm by design")
    for k in range(len(d.bracket.stop_pins_mm)):
        builder.gap(arm, f"stop_pin_{i}_{k}", 0.3, "stop pin is met 3 deg outside the cube")


def place_capstan(builder: AssemblyBuilder, c: CapstanDimensions, i: int) -> None:
    """Places sector, pinion, cable and tensioner of a chain, and the bearings of its shoulder.

    The motor comes off along its axis, out of the pinion, which stays in the turns of its cable, when its leads and the
    screws of both are off; a direct drive's carries the arm, which must come off its shaft first.
    """
    d, arm, sector, pinion, motor = builder.d, f"upper_arm_{i}", f"sector_{i}", f"pinion_{i}", f"motor_{i}"
    on_arm = seated(arm, ring(2 * d.arm.flange_radius_mm, d.arm.shaft_bore_mm), "sector on the arm")
    builder.put(sector, builder.made(capstan.make_sector), arm, np.eye(4), on_arm)
    builder.put(pinion, builder.made(capstan.make_pinion), pinion, np.eye(4))
    builder.connect(motor, pressed(pinion, SHAFT_ENGAGEMENT_MM, "pinion on the motor's shaft"))
    length = longest_set_screw(SET_SCREW, c.collar_radius_mm - d.motor.shaft_diameter_mm / 2)
    grub = builder.once("set_screw", bought_parts.make_set_screw, SET_SCREW, length)
    flat = catalogue.set_screw(SET_SCREW).tap_drill_mm - bought_parts.CORE_PLAY_MM
    tip = Connection(motor, "set screw's tip on the motor's shaft", "tip", 0.9 * flat, SEATED_MM, guides=False)
    held, screws = bolted(pinion, 2.0, "set screw in the pinion's collar"), _motor_screws(builder, i)
    grubs = [
        builder.put(f"set_screw_{i}_{k}", grub, pinion, frame, held, tip, path=DRIVEN)
        for k, frame in enumerate(capstan.set_screw_frames(d, length))
    ]
    (long, sunk), (inside, face) = (
        motor_screw_mm(d.motor, d.layers),
        (d.layers.motor_cheek_mm[0], d.layers.motor_face_mm),
    )
    engaged = long - (face - inside - sunk)
    builder.reached += [ToolAccess(name, engaged, "holds the motor") for name in screws]
    builder.reached += [ToolAccess(name, _LOOSE_MM, "holds the pinion on the motor's shaft") for name in grubs]
    builder.removals.append(Removal(motor, (0.0, 1.0, 0.0), (*screws, *grubs, *lead_names(d, i)), "is exchanged"))
    _cable(builder, c, i)
    _tensioner(builder, c, i)
    first = d.layers.arm_mm[0] + 1.0
    for k, (x, z) in enumerate(upper_arm.dowel_positions(d)):
        placed = pointing((0, 1, 0), x, first, z)
        builder.pin(f"sector_dowel_{i}_{k}", c.web_y_mm[1] - first, arm, placed, sector, arm)
    _bearings(builder, i)
    builder.gap(sector, f"motor_cheek_{i}", NEXT_TO_MM, "sector turns beside the cheek, 1 mm by design")
    for moving, fixed in _ADJACENT:
        builder.gap(moving.format(i), fixed.format(i), NEXT_TO_MM, "turns beside the bracket, 1 mm or more by design")
    if d.sensed_at_shoulder:
        reason = "in the shaft's head, 1 mm or more by design"
        builder.gap(f"encoder_magnet_{i}", f"bearing_{i}_e", NEXT_TO_MM, reason)
    builder.gap(sector, motor, NEXT_TO_MM, "the motor's shaft comes out of the pinion beside the rim")
    for screw in screws:
        for moving in (sector, pinion):
            builder.gap(moving, screw, NEXT_TO_MM, "turns beside the sunk heads")
    thicker = 0.75 * (d.cable.diameter_mm - 0.54)  # between the rim and the pinion's crest; 1.4 mm for 0.54 mm
    words = "capstan gap, 1 mm between the pitch circles by design"
    builder.gap(sector, pinion, 1.2 + thicker, words, 1.65 + thicker)
    builder.gap(sector, f"stop_pin_{i}_0", 0.3, "stop pin in its slot, 0.5 mm at either side")
    if c.collar_at_motor:
        builder.gap(pinion, f"motor_cheek_{i}", 0.3, "collar in the pilot's bore, 0.5 mm or more by design")
        for name in grubs:
            builder.gap(name, f"motor_cheek_{i}", 0.25, "set screw below the collar's surface")
            for screw in screws:
                builder.gap(name, screw, 0.4, "set screw below the collar's surface")
    else:
        builder.gap(pinion, f"motor_cheek_{i}", NEXT_TO_MM, "pinion turns beside the cheek, 1 mm by design")


def _bearings(builder: AssemblyBuilder, i: int) -> None:
    """Both bearings of a shoulder in their seats, the spring behind one, washer and screw that clamp their rings."""
    d, b, a, arm, shoulder_shaft = builder.d, builder.d.bearing, builder.d.arm, f"upper_arm_{i}", f"shoulder_shaft_{i}"
    shoulder = d.stand(i) @ at(d.bracket.shoulder_u_mm)
    collar = ring(min(a.collar_diameter_mm, b.inner_ring_outer_mm), b.bore_mm)
    inner = max(d.bracket.passage_mm, b.outer_ring_inner_mm)
    (start_e, _), (start_m, end) = d.layers.bearings_mm
    for side, start, cheek, turns, way in (
        ("e", start_e, f"encoder_cheek_{i}", arm, OUT),
        ("m", start_m, f"motor_cheek_{i}", f"sector_{i}", IN),
    ):
        name, held = f"bearing_{i}_{side}", [pressed(cheek, b.width_mm - CHAMFERS_MM, "bearing in its seat")]
        if side == "m":
            held.append(seated(cheek, ring(b.outer_mm, inner), "bearing on the lip of its seat"))
        placed = shoulder @ at(0.0, start, 0.0)
        builder.put(name, builder.made(make_bearing), "base", placed, *held, path=way, frame=cheek)
        builder.connect(turns, seated(name, collar, "collar on the inner ring"))
    row = d.preload
    assert row is not None
    pressing = ring(row.outer_mm, max(row.inner_mm, inner))
    builder.put(
        f"wave_spring_{i}",
        builder.made(make_wave_spring),
        "base",
        shoulder @ at(0.0, start_e - row.work_height_mm),
        seated(f"bearing_{i}_e", pressing, "spring on the outer ring"),
        seated(f"encoder_cheek_{i}", pressing, "spring on the lip of the seat"),
        path=OUT,
        frame=f"encoder_cheek_{i}",
    )
    washer, block = f"shoulder_washer_{i}", f"foot_block_{i}"
    on_ring = seated(
        f"bearing_{i}_m", ring(b.shaft_shoulder_min_mm, b.bore_mm), "washer on the inner ring", guides=False
    )
    builder.put(washer, builder.made(upper_arm.make_shoulder_washer), arm, at(0.0, end), on_ring, path=OUT, frame=block)
    size, screw, head = d.shaft.end_screw, f"shoulder_screw_{i}", catalogue.screw(d.shaft.end_screw)
    length = longest(size, WASHER_MM + INSIDE_RING_MM + d.shaft.end_thread_mm)
    builder.put(
        screw,
        builder.screw(size, length),
        arm,
        pointing((0, 1, 0), 0.0, end + WASHER_MM),
        seated(washer, ring(head.head_diameter_mm, head.clearance_hole_mm), "screw's head on its washer"),
        bolted(shoulder_shaft, head.diameter_mm, "screw in the shaft, a diameter"),
        path=DRIVEN,
    )
    builder.gap(screw, f"bearing_{i}_m", 1.0, "screw in the shaft that the bearing is on")


def _tensioner(builder: AssemblyBuilder, c: CapstanDimensions, i: int) -> None:
    """The carriage in its pocket with the screw that pulls it, and both sleeves of the cable."""
    arm, sector, carriage = f"upper_arm_{i}", f"sector_{i}", f"tension_carriage_{i}"
    guided = 2 * (CARRIAGE_MM[0] - 2 * POCKET_CORNER_MM) * CARRIAGE_MM[1]
    held = seated(sector, guided, "carriage guided in its pocket", POCKET_PLAY_MM + SEATED_MM)
    block = builder.made(capstan.make_tension_carriage)
    builder.put(carriage, block, arm, carriage_frame(c), held, path=IN, frame=sector)
    row = catalogue.screw(TENSION_SCREW)
    tension = builder.once("tension_screw", bought_parts.make_tension_screw, TENSION_SCREW, TENSION_SCREW_LENGTH_MM)
    builder.put(
        f"tension_screw_{i}",
        tension,
        arm,
        capstan.tension_screw_frame(builder.d),
        bolted(carriage, 3.0, "tension screw in its carriage, a diameter"),
        seated(sector, ring(row.head_diameter_mm, row.clearance_hole_mm), "tension screw's head on its lug"),
        path=DRIVEN,
    )
    open_side = (CRIMP_MM[0] - c.cable_slot_mm) / 2 * c.cable_slot_mm
    area = ring(CRIMP_MM[0], c.cable_slot_mm) - open_side
    sleeve, (anchored, pulled) = builder.made(capstan.make_crimp_sleeve), sleeve_frames(c)
    behind = seated(sector, area, "sleeve behind the anchor's wall")
    inside = seated(carriage, area, "sleeve in its carriage")
    builder.put(f"crimp_sleeve_{i}_0", sleeve, arm, anchored, behind, path=IN, frame=arm)
    over = over_carriage(builder.d, c)
    builder.put(f"crimp_sleeve_{i}_1", sleeve, arm, pulled, inside, path=over, frame=carriage)


def over_carriage(d: Dimensions, c: CapstanDimensions) -> InsertionPath:
    """Gives the second sleeve's path: from outside over its carriage, beside arm and foot block, then into it."""
    aside = second_way_rad(d, c)
    return PathSegment((-cos(aside), 0.0, -sin(aside))), PathSegment((0.0, 1.0, 0.0), SLEEVE_OVER_MM)


def _cable(builder: AssemblyBuilder, c: CapstanDimensions, i: int) -> None:
    """Places the cable of a chain, in pieces: on the sector at either end, free, and on the pinion."""
    d, link, pinion, sector, run = builder.d, f"upper_arm_{i}", f"pinion_{i}", f"sector_{i}", c.run
    name, shoulder = f"capstan_cable_{i}", d.stand(i) @ at(d.bracket.shoulder_u_mm)
    u, z = d.bracket.motor_axis_mm
    turns, section = f"{name}_turns", SHARE * ring(c.cable_diameter_mm, 0.0)
    in_groove = wound(pinion, 0.97 * run.wrap_rad * run.pinion_mm, "turns in the pinion's groove", guides=False)
    builder.put(turns, builder.made(capstan.make_turns), "base", d.stand(i) @ at(u, 0.0, z), in_groove)
    builder.gap(sector, turns, 0.5, "turns beside the rim, 1 mm by design, and beside the lug")

    def onward(to: str) -> Connection:
        return Connection(to, "one cable", "end", section, CABLE_OFF_MM)

    for end, side in enumerate(("inner", "outer")):
        rim, beyond, free = f"{name}_{side}", f"{name}_{side}_end", f"{name}_strand_{side}"
        sense = 1.0 if end else -1.0
        on_rim_mm = c.pitch_radius_mm * abs(
            c.rim_angles_rad[end] - (c.direction_rad - d.home_rad + sense * run.tangent_rad)
        )
        on_rim = wound(sector, 0.97 * on_rim_mm, "cable on the rim")
        part = builder.made(capstan.make_cable, f"cable_{side}", end)
        builder.put(rim, part, link, np.eye(4), on_rim, onward(free))
        held = [wound(f"crimp_sleeve_{i}_{end}", 0.9 * CRIMP_MM[1], "cable in its sleeve, uncrimped", _THREADED_MM)]
        if not end:
            nose = (c.nose_radius_mm + c.cable_diameter_mm / 2) * c.turns_rad[0]
            held.append(wound(sector, 0.97 * nose, "cable round the nose"))
        part = builder.made(capstan.make_cable_end, f"cable_{side}_end", end)
        builder.put(beyond, part, link, np.eye(4), *held, onward(rim))
        builder.piece(rim, beyond)
        part = builder.made(capstan.make_strand, f"strand_{side}", end)
        builder.put(free, part, "base", shoulder, onward(turns))
        builder.gap(rim, turns, 0.2, "cable on the rim beside that on the pinion, 0.46 mm by design")
        builder.gap(rim, pinion, 0.6, "cable on the rim beside the pinion")
        builder.touch(free, sector, "the strand leaves the rim along its tangent", guides=False)
        builder.touch(free, pinion, "the strand reaches the groove along its tangent", guides=False)
        for other in ("inner", "outer"):
            builder.piece(rim, f"{name}_strand_{other}")
        builder.piece(free, turns)
