"""What holds what: every seat, press, bond, thread, clamp, stop and eye of a design, with the least that does its job.

Lengths and areas come from the dimensions, so that a solid that was made otherwise is noticed. `SHARE` of what is drawn
is asked where chamfers and neighbouring bores take some of a face; a bore's length is asked but for its chamfers.
"""

from __future__ import annotations

from math import pi, sqrt

from delta_cad import catalogue
from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.capstan import (
    CARRIAGE_MM,
    CRIMP_MM,
    POCKET_CORNER_MM,
    POCKET_PLAY_MM,
    SET_SCREW,
    SHAFT_ENGAGEMENT_MM,
    TENSION_SCREW,
    CapstanDimensions,
)
from delta_cad.dimensions.forearm import (
    BALL_GLUE_MM,
    BAR_GLUE_MM,
    LINER_GLUE_MM,
    RING_MM,
    TUBE_GLUE_MM,
    ForearmDimensions,
)
from delta_cad.dimensions.joint import CLEARANCE_MM, CLEARANCE_TOLERANCE_MM, POCKET_MM
from delta_cad.dimensions.layers import STUB_DEPTH_MM
from delta_cad.mechanism.placement import CHAINS, SIDES
from delta_cad.solids import brackets, platform
from delta_cad.solids.bought import fasteners
from delta_cad.solids.bought.bearing import PRELOAD_PLAY_MM
from delta_cad.solids.forearm import RING_GLUE_MM, rim_mm
from delta_cad.solids.part import Contact, Stop

FIT_MM = 0.02  # radius: H7 and h6 up to 18 mm leave 0.015
GLUE_MM = 0.06  # radius: the widest bond, of the magnet
SEATED_MM = 0.02  # along a normal: what a shim cannot enter
THREAD_MM = fasteners.CORE_PLAY_MM  # radius, threads being drawn as their cores
CABLE_OFF_MM = 0.03  # the cable's line is drawn through points on its path
CHAMFERS_MM = 1.2  # of both ends of a bore or a shaft together
SHARE = 0.6  # of a flat face, beside edges, slits and the bores of screws


class _Contacts:
    """Collects contacts, a method for each kind."""

    def __init__(self) -> None:
        self.all: list[Contact] = []

    def cylinder(self, a: str, b: str, length_mm: float, gap_mm: float, reason: str) -> None:
        self.all.append(Contact(a, b, "cylinder", length_mm, gap_mm, reason))

    def plane(self, a: str, b: str, area_mm2: float, reason: str, gap_mm: float = SEATED_MM) -> None:
        self.all.append(Contact(a, b, "plane", area_mm2, gap_mm, reason))

    def ball(self, a: str, b: str, area_mm2: float, gap_mm: float, reason: str) -> None:
        self.all.append(Contact(a, b, "ball", area_mm2, gap_mm, reason))

    def tip(self, a: str, b: str, length_mm: float, reason: str) -> None:
        self.all.append(Contact(a, b, "tip", length_mm, SEATED_MM, reason))

    def cable(self, a: str, b: str, length_mm: float, gap_mm: float, reason: str) -> None:
        self.all.append(Contact(a, b, "cable", length_mm, gap_mm, reason))

    def end(self, a: str, b: str, area_mm2: float, reason: str) -> None:
        self.all.append(Contact(a, b, "end", area_mm2, CABLE_OFF_MM, reason))


def _ring(outer_mm: float, inner_mm: float) -> float:
    """Area between two diameters, mm^2."""
    return pi / 4 * (outer_mm**2 - inner_mm**2)


def contacts(d: Dimensions) -> tuple[Contact, ...]:
    """Declares the contacts of a design by the names of its occurrences."""
    bench = _Contacts()
    for i in CHAINS:
        if d.has_feet:
            _foot(bench, d, i)
        _bracket(bench, d, i)
        _sensor(bench, d, i)
        _elbow(bench, d, i)
        if d.capstan is not None:
            _shoulder(bench, d, i)
            _capstan(bench, d, d.capstan, i)
        else:
            _direct(bench, d, i)
        for j in SIDES:
            _rod(bench, d, i, j)
    _handle(bench, d)
    return tuple(bench.all)


def _foot(bench: _Contacts, d: Dimensions, i: int) -> None:
    inner = d.foot.hole_diameter_mm or catalogue.screw(d.foot.thread).diameter_mm
    bench.plane(f"foot_{i}", "base_plate", SHARE * _ring(d.foot.diameter_mm, inner), "foot under the plate")
    if d.foot.stud_length_mm is not None:
        held = min(d.foot.stud_length_mm, d.base.thickness_mm) - CHAMFERS_MM
        bench.cylinder(f"foot_{i}", "base_plate", held, THREAD_MM, "the foot's stud in its thread")


def _bracket(bench: _Contacts, d: Dimensions, i: int) -> None:
    b, block = d.bracket, f"foot_block_{i}"
    inside, outside = d.layers.motor_cheek_mm
    length, width = b.foot_u_mm[1] - b.foot_u_mm[0], inside - d.layers.encoder_cheek_mm[1]
    bench.plane(block, "base_plate", SHARE * length * width, "foot block on the plate")
    for k in range(2):
        _dowel(bench, f"base_dowel_{i}_{k}", block, "base_plate")
    for side, cheek in (("m", f"motor_cheek_{i}"), ("e", f"encoder_cheek_{i}")):
        bench.plane(block, cheek, SHARE * length * b.foot_height_mm, "cheek on the foot block")
        for k in range(2):
            _dowel(bench, f"cheek_dowel_{i}_{side}{k}", block, cheek)
    for k in range(len(b.stop_pins_mm)):
        held = outside - inside - brackets.STOP_SUNK_MM - CHAMFERS_MM
        bench.cylinder(f"stop_pin_{i}_{k}", f"motor_cheek_{i}", held, FIT_MM, "stop pin pressed in the cheek")
    motor, cheek, m = f"motor_{i}", f"motor_cheek_{i}", d.motor
    bench.cylinder(motor, cheek, 0.8 * m.pilot_height_mm, FIT_MM, "the motor's pilot in the cheek")
    bench.plane(motor, cheek, SHARE * _ring(m.diameter_mm - 1.0, m.pilot_diameter_mm), "motor on the cheek")


def _dowel(bench: _Contacts, pin: str, *parts: str) -> None:
    for part in parts:
        bench.cylinder(pin, part, brackets.DOWEL_MM, FIT_MM, "dowel, engaged by its diameter")


def _sensor(bench: _Contacts, d: Dimensions, i: int) -> None:
    if not d.sensed_at_shoulder:
        return
    magnet, board = f"encoder_magnet_{i}", f"encoder_board_{i}"
    bench.cylinder(magnet, f"shoulder_shaft_{i}", 0.9 * d.magnet.thickness_mm, GLUE_MM, "magnet bonded in the shaft")
    screw = catalogue.screw(brackets.BOARD_SCREW)
    face = SHARE * _ring(screw.clearance_hole_mm + 2.0, screw.clearance_hole_mm)
    play = (screw.clearance_hole_mm - screw.tap_drill_mm) / 2 + THREAD_MM
    length = d.layers.encoder_head_mm[0] - d.layers.encoder_board_mm[1]
    thick, in_board = d.encoder.board_thickness_mm, (d.encoder.hole_diameter_mm - screw.tap_drill_mm) / 2 + THREAD_MM
    for k in range(d.encoder.hole_count):
        spacer = f"board_spacer_{i}_{k}"
        bench.plane(spacer, board, face, "spacer under the board")
        bench.plane(spacer, f"encoder_cheek_{i}", face, "spacer on the cheek")
        bench.cylinder(f"board_screw_{i}_{k}", spacer, 0.9 * length, play, "screw through its spacer")
        bench.cylinder(f"board_screw_{i}_{k}", board, 0.9 * thick, in_board, "screw through the board")


def _elbow(bench: _Contacts, d: Dimensions, i: int) -> None:
    f = d.forearm
    boss = d.layers.elbow_boss_mm[1] - d.layers.elbow_boss_mm[0]
    elbow, wrist = f"cross_bar_{i}_elbow", f"cross_bar_{i}_wrist"
    bench.cylinder(
        elbow, f"upper_arm_{i}", boss - CHAMFERS_MM, 1.1 * BAR_GLUE_MM, "cross-bar bonded in the elbow's boss"
    )
    held = d.platform.boss_length_mm - CHAMFERS_MM
    bench.cylinder(wrist, "platform", held, 1.1 * BAR_GLUE_MM, "cross-bar bonded in the platform's boss")
    for j in SIDES:
        for end, bar in (("elbow", elbow), ("wrist", wrist)):
            _ball(bench, f, bar, f"{i}_{j}_{end}")


def _ball(bench: _Contacts, f: ForearmDimensions, bar: str, end: str) -> None:
    ball, shell, cup = f"joint_ball_{end}", f"cup_shell_{end}", f"rod_cup_{end}"
    radius, inside = f.seat_diameter_mm / 2, f.seat_diameter_mm / 2 - f.lip_mm
    pole = radius - sqrt(radius**2 - (POCKET_MM / 2) ** 2)
    seat = 0.98 * 2 * pi * radius * (inside - pole)  # the zone of a sphere between lip and grease pocket
    bench.ball(ball, shell, seat, 2 * (CLEARANCE_MM + CLEARANCE_TOLERANCE_MM), "ball in its cup")
    back = f.liner_radius_mm
    bonded = 0.9 * 2 * pi * back * (sqrt(back**2 - (POCKET_MM / 2) ** 2) - f.lip_mm)
    bench.ball(shell, cup, bonded, 2 * LINER_GLUE_MM, "shell bonded in its cup")
    bonded = rim_mm(f) + f.pin_past_mm - CHAMFERS_MM / 2
    bench.cylinder(bar, ball, bonded, 1.1 * BALL_GLUE_MM, "stud's pin bonded in its ball")


def _shoulder(bench: _Contacts, d: Dimensions, i: int) -> None:
    arm, shaft, b, a = f"upper_arm_{i}", f"shoulder_shaft_{i}", d.bearing, d.arm
    for side, cheek, turns in (("e", "encoder_cheek", arm), ("m", "motor_cheek", f"sector_{i}")):
        bearing = f"bearing_{i}_{side}"
        bench.cylinder(bearing, f"{cheek}_{i}", b.width_mm - CHAMFERS_MM, FIT_MM, "bearing in its seat")
        bench.cylinder(shaft, bearing, b.width_mm - CHAMFERS_MM, FIT_MM, "shaft in the bearing's bore")
        collar = _ring(min(a.collar_diameter_mm, b.inner_ring_outer_mm), b.bore_mm)
        bench.plane(turns, bearing, SHARE * collar, "collar on the inner ring")
    inner = max(d.bracket.passage_mm, b.outer_ring_inner_mm)
    bench.plane(
        f"bearing_{i}_m", f"motor_cheek_{i}", SHARE * _ring(b.outer_mm, inner), "bearing on the lip of its seat"
    )
    spring, row = f"wave_spring_{i}", d.preload
    assert row is not None
    pressed = SHARE * _ring(row.housing_mm - PRELOAD_PLAY_MM, max(row.inner_mm, inner))
    bench.plane(spring, f"bearing_{i}_e", pressed, "spring on the outer ring")
    bench.plane(spring, f"encoder_cheek_{i}", pressed, "spring on the lip of the seat")
    ring = SHARE * _ring(b.shaft_shoulder_min_mm, b.bore_mm)
    bench.plane(shaft, f"bearing_{i}_e", ring, "shaft's head on the inner ring")
    screw = catalogue.screw(d.shaft.end_screw)
    bench.plane(f"shoulder_washer_{i}", f"bearing_{i}_m", ring, "washer on the inner ring")
    head = SHARE * _ring(screw.head_diameter_mm, screw.clearance_hole_mm)
    bench.plane(f"shoulder_screw_{i}", f"shoulder_washer_{i}", head, "screw's head on its washer")
    bench.cylinder(f"shoulder_screw_{i}", shaft, screw.diameter_mm, THREAD_MM, "screw in the shaft, a diameter")
    length = d.layers.arm_mm[1] - d.layers.bearings_mm[0][1]
    bench.cylinder(shaft, arm, length - CHAMFERS_MM, FIT_MM, "arm on the shaft")


def _capstan(bench: _Contacts, d: Dimensions, c: CapstanDimensions, i: int) -> None:
    arm, sector, pinion = f"upper_arm_{i}", f"sector_{i}", f"pinion_{i}"
    web = c.web_y_mm
    bench.cylinder(
        f"shoulder_shaft_{i}", sector, web[1] - d.layers.arm_mm[1] - CHAMFERS_MM, FIT_MM, "sector on the shaft"
    )
    bench.plane(sector, arm, SHARE * _ring(2 * d.arm.flange_radius_mm, d.arm.shaft_bore_mm), "sector on the arm")
    for k in range(len(d.arm.dowel_angles_rad)):
        _dowel(bench, f"sector_dowel_{i}_{k}", sector, arm)
    bench.cylinder(f"motor_{i}", pinion, SHAFT_ENGAGEMENT_MM, FIT_MM, "pinion on the motor's shaft")
    for k in range(2):
        bench.cylinder(f"set_screw_{i}_{k}", pinion, 2.0, THREAD_MM, "set screw in the pinion's collar")
        flat = catalogue.set_screw(SET_SCREW).tap_drill_mm - fasteners.CORE_PLAY_MM
        bench.tip(f"set_screw_{i}_{k}", f"motor_{i}", 0.9 * flat, "set screw's tip on the motor's shaft")
    _cable(bench, d, c, i)
    carriage, tension = f"tension_carriage_{i}", f"tension_screw_{i}"
    bench.cylinder(tension, carriage, 3.0, THREAD_MM, "tension screw in its carriage, a diameter")
    guided = 2 * SHARE * (CARRIAGE_MM[0] - 2 * POCKET_CORNER_MM) * CARRIAGE_MM[1]
    bench.plane(carriage, sector, guided, "carriage guided in its pocket", POCKET_PLAY_MM + SEATED_MM)
    screw = catalogue.screw(TENSION_SCREW)
    seat = SHARE * _ring(screw.head_diameter_mm, screw.clearance_hole_mm)
    bench.plane(tension, sector, seat, "tension screw's head on its lug")


def _cable(bench: _Contacts, d: Dimensions, c: CapstanDimensions, i: int) -> None:
    run, name, sector = c.run, f"capstan_cable_{i}", f"sector_{i}"
    nose = (c.nose_radius_mm + c.cable_diameter_mm / 2) * c.turns_rad[0]
    for end, side in enumerate(("inner", "outer")):
        sense = 1.0 if end else -1.0
        on_rim = abs(c.rim_angles_rad[end] - (c.direction_rad - d.home_rad + sense * run.tangent_rad))
        bench.cable(f"{name}_{side}", sector, 0.97 * c.pitch_radius_mm * on_rim, CABLE_OFF_MM, "cable on the rim")
        sleeve = f"crimp_sleeve_{i}_{end}"
        bench.cable(f"{name}_{side}_end", sleeve, 0.9 * CRIMP_MM[1], FIT_MM, "cable crimped in its sleeve")
        for piece, onward in ((f"{side}_end", side), (side, f"strand_{side}"), (f"strand_{side}", "turns")):
            bench.end(f"{name}_{piece}", f"{name}_{onward}", SHARE * _ring(c.cable_diameter_mm, 0.0), "one cable")
    bench.cable(f"{name}_inner_end", sector, 0.97 * nose, CABLE_OFF_MM, "cable round the nose")
    bench.cable(
        f"{name}_turns", f"pinion_{i}", 0.97 * run.wrap_rad * run.pinion_mm, CABLE_OFF_MM, "turns in the groove"
    )
    open_side = (CRIMP_MM[0] - c.cable_slot_mm) / 2 * c.cable_slot_mm
    area = SHARE * (_ring(CRIMP_MM[0], c.cable_slot_mm) - open_side)
    bench.plane(f"crimp_sleeve_{i}_0", sector, area, "sleeve behind the anchor's wall")
    bench.plane(f"crimp_sleeve_{i}_1", f"tension_carriage_{i}", area, "sleeve in its carriage")


def _direct(bench: _Contacts, d: Dimensions, i: int) -> None:
    arm, m = f"upper_arm_{i}", d.motor
    clamped = d.layers.arm_mm[1] - (d.layers.motor_cheek_mm[1] - m.shaft_length_mm)
    bench.cylinder(f"motor_{i}", arm, min(clamped, m.shaft_diameter_mm / 2), FIT_MM, "arm clamped on the motor's shaft")
    bench.cylinder(f"shoulder_shaft_{i}", arm, STUB_DEPTH_MM - CHAMFERS_MM / 2, GLUE_MM, "stub bonded in the arm")


def _rod(bench: _Contacts, d: Dimensions, i: int, j: int) -> None:
    f, tube = d.forearm, f"rod_tube_{i}_{j}"
    for end in ("elbow", "wrist"):
        cup = f"rod_cup_{i}_{j}_{end}"
        bench.cylinder(cup, tube, f.spigot_length_mm - CHAMFERS_MM, 1.1 * TUBE_GLUE_MM, "spigot bonded in the tube")
        bench.plane(tube, cup, SHARE * _ring(f.tube_outer_mm, f.tube_bore_mm), "tube on the cup's shoulder")
    for k in range(2):
        bench.cylinder(
            tube, f"rod_eye_{i}_{j}_{k}", 0.9 * RING_MM[1], 1.1 * RING_GLUE_MM, "spring's eye bonded on the tube"
        )


def _handle(bench: _Contacts, d: Dimensions) -> None:
    p, thread = d.platform, catalogue.screw(d.platform.stem_thread)
    into = min(platform.STEM_CORE_DEPTH_MM, p.boss_diameter_mm - 0.5) - CHAMFERS_MM
    bench.cylinder("handle_stem", "platform", into, THREAD_MM, "stem in the platform's thread")
    seat = SHARE * _ring(p.stem_diameter_mm, thread.diameter_mm)
    bench.plane("handle_stem", "platform", seat, "stem on the platform")
    up = d.knob.thread_depth_mm - 1.0 - CHAMFERS_MM
    bench.cylinder("handle_stem", "knob", up, THREAD_MM, "stem in the knob's thread")
    flat = _ring(min(d.knob.foot_diameter_mm, p.stem_diameter_mm), thread.diameter_mm)
    bench.plane("knob", "handle_stem", SHARE * flat, "knob on its stem")


def stops(d: Dimensions) -> tuple[Stop, ...]:
    """Declares both ends of the shoulders: one pin in the sector's slot, or one pin beside either edge of the arm."""
    found = []
    for i in CHAINS:
        moving = f"upper_arm_{i}" if d.capstan is None else f"sector_{i}"
        for end, (angle, sense) in enumerate(zip(d.stops_rad, (-1, 1), strict=True)):
            pin = f"stop_pin_{i}_{end if d.capstan is None else 0}"
            found.append(Stop(f"shoulder_{i}", pin, moving, angle, sense, SHARE * brackets.STOP_ENGAGEMENT_MM))
    return tuple(found)
