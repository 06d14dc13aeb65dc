"""Every part of a design made and placed on its link: the only place that knows what is fixed to what.

Least lengths and areas of what is connected come from the dimensions, so that a solid that was made otherwise is
noticed.
"""

from __future__ import annotations

from math import pi, sqrt

import numpy as np

from delta_cad import catalogue
from delta_cad.assembly.builder import (
    CHAMFERS_MM,
    DRIVEN,
    GLUE_MM,
    HALF_TURN,
    IN,
    NEXT_TO_MM,
    OUT,
    SHARE,
    THREAD_MM,
    UP,
    UPRIGHT,
    AssemblyBuilder,
    Connection,
    Progress,
    at,
    bolted,
    bonded,
    longest,
    pointing,
    pressed,
    ring,
    seated,
    straight,
)
from delta_cad.assembly.drive import place_capstan, place_direct
from delta_cad.assembly.leads import place_leads
from delta_cad.assembly.machine import Assembly
from delta_cad.assembly.panel import place_panel, place_sleeves
from delta_cad.assembly.sequence import assembly_sequence
from delta_cad.assembly.supplies import supplies
from delta_cad.dimensions import Dimensions, link_placement
from delta_cad.dimensions.bracket import board_screw
from delta_cad.dimensions.forearm import BALL_GLUE_MM, BAR_GLUE_MM, LINER_GLUE_MM, RING_MM, TUBE_GLUE_MM
from delta_cad.dimensions.joint import CLEARANCE_MM, CLEARANCE_TOLERANCE_MM, POCKET_MM
from delta_cad.dimensions.layers import STUB_DEPTH_MM, motor_screw_mm
from delta_cad.mechanism.placement import CHAINS, SIDES
from delta_cad.solids import bought_parts, brackets, forearm, platform
from delta_cad.solids.base_plate import make_base_plate
from delta_cad.solids.bought_parts import (
    loop_overlap_mm3,
    make_encoder_board,
    make_encoder_magnet,
    make_foot,
    make_joint_ball,
    make_motor,
    make_rod_spring,
)
from delta_cad.solids.part import Joint, Stop
from delta_cad.solids.upper_arm import make_shoulder_shaft, make_upper_arm

_ABOUT_X, _ABOUT_Y = np.diag([1.0, -1.0, -1.0, 1.0]), np.diag([-1.0, 1.0, -1.0, 1.0])
_EYE_FRAMES = ((_ABOUT_X, HALF_TURN), (_ABOUT_Y, np.eye(4)))  # of a pair's rods: away from the arm, towards it
_NEXT_TO_STUD_MM = 0.4  # least gap of a rod's end beside its stud: 0.5 mm at the tilt that the joint is made for
_NEXT_TO_TUBE_MM = 1.5  # least gap of a spring's loop beside the tube that carries its eye: 2.7 mm as it hangs
_LOOP_SHARE = (
    1.1  # times what a loop, drawn stiff, shares with its eye at the largest lean: the sum's pieces, roundings
)
_NEXT_TO_ARM_MM = 1.0  # least gap of a spring's eye beside the arm: 2 mm where the rod has not turned about itself
_TO_THE_ELBOW = straight(-1.0, 0.0, 0.0)
_IN_BOSS = "cross-bar bonded in its boss", BAR_GLUE_MM
_ENDS = ("elbow", "wrist")


def _base(builder: AssemblyBuilder) -> None:
    d = builder.d
    builder.put("base_plate", builder.made(make_base_plate), "base", np.eye(4))
    place_sleeves(builder)
    if not d.has_feet:
        return
    low, row, stud = d.base.top_mm - d.base.thickness_mm, catalogue.screw(d.foot.thread), d.foot.stud_length_mm
    inner = d.foot.hole_diameter_mm or row.diameter_mm
    held = [seated("base_plate", ring(d.foot.diameter_mm, inner), "foot under the plate")]
    if stud is not None:
        into = min(stud, d.base.thickness_mm) - CHAMFERS_MM
        held.append(bolted("base_plate", into, "the foot's stud in its thread"))
    for i, (x, y) in enumerate(d.base.feet_mm):
        builder.put(f"foot_{i}", builder.made(make_foot), "base", at(x, y, low), *held, path=UP, frame="base_plate")
        if stud is None:
            rest = d.foot.height_mm - row.counterbore_depth_mm
            screw = builder.screw(d.foot.thread, longest(d.foot.thread, rest + d.base.thickness_mm))
            builder.put(f"foot_screw_{i}", screw, "base", pointing((0, 0, -1), x, y, low - rest), path=DRIVEN)


def _bracket(builder: AssemblyBuilder, i: int) -> None:
    d, layers, b = builder.d, builder.d.layers, builder.d.bracket
    shoulder, block, cheek = d.stand(i) @ at(b.shoulder_u_mm), f"foot_block_{i}", f"motor_cheek_{i}"
    encoder_side, motor_side = layers.encoder_cheek_mm, layers.motor_cheek_mm
    long, wide = b.foot_u_mm[1] - b.foot_u_mm[0], motor_side[0] - encoder_side[1]
    on_block = long * b.foot_height_mm
    builder.put(cheek, builder.made(brackets.make_motor_cheek), "base", shoulder)
    builder.put(f"encoder_cheek_{i}", builder.made(brackets.make_encoder_cheek), "base", shoulder)
    on = [seated("base_plate", long * wide, "foot block on the plate")]
    on += [seated(f"{side}_cheek_{i}", on_block, "cheek on the foot block") for side in ("motor", "encoder")]
    builder.put(block, builder.made(brackets.make_foot_block), "base", shoulder, *on, path=IN)

    into = brackets.cheek_dowel_depth_mm(d)
    for side, own, outwards, (inside, outside) in (
        ("m", cheek, 1.0, motor_side),
        ("e", f"encoder_cheek_{i}", -1.0, encoder_side[::-1]),
    ):
        thickness = abs(outside - inside)
        screw = builder.screw(brackets.BLOCK_SCREW, brackets.cheek_screw_length_mm(d, thickness))
        under_head = outside - outwards * brackets.cheek_screw_sink_mm(d, thickness)
        for k, (x, z) in enumerate(brackets.cheek_screw_positions(d)):
            seat = pointing((0, outwards, 0), x, under_head, z)
            builder.put(f"cheek_screw_{i}_{side}{k}", screw, "base", shoulder @ seat, path=DRIVEN)
        way = UP if side == "m" else DRIVEN  # into the cheek from inside, or into the block
        for k, (x, z) in enumerate(brackets.cheek_dowel_positions(d)):
            bottom = shoulder @ pointing((0, outwards, 0), x, inside - outwards * into, z)
            held = (own,) if brackets.is_slotted(d, side, k) else (block, own)
            builder.pin(f"cheek_dowel_{i}_{side}{k}", into + thickness, "base", bottom, *held, path=way)

    middle = (encoder_side[1] + motor_side[0]) / 2
    row = catalogue.screw(brackets.BASE_SCREW)
    low = d.base.top_mm - d.base.thickness_mm
    rest = d.base.thickness_mm - row.counterbore_depth_mm
    base_screw = builder.screw(brackets.BASE_SCREW, longest(brackets.BASE_SCREW, rest + brackets.BASE_THREAD_MM - 0.5))
    for k, u in enumerate(b.base_screw_u_mm):
        seat = pointing((0, 0, -1), u, middle, low + row.counterbore_depth_mm)
        builder.put(f"base_screw_{i}_{k}", base_screw, "base", d.stand(i) @ seat, path=DRIVEN)
    sunk, filled = brackets.base_pin_mm(d)
    for k, u in enumerate(b.base_dowel_u_mm):
        bottom = d.stand(i) @ at(u, middle, d.base.top_mm - sunk)
        held = ("base_plate",) if k else (block, "base_plate")  # the second stands in a slot of the block
        builder.pin(f"base_dowel_{i}_{k}", filled, "base", bottom, *held, path=UP)

    stop, end = builder.dowel("4", brackets.stop_pin_length_mm(d)), brackets.stop_end_mm(d)
    held = pressed(cheek, end - motor_side[0] - CHAMFERS_MM, "stop pin in the cheek")
    for k, (u, z) in enumerate(b.stop_pins_mm):
        placed = d.stand(i) @ pointing((0, -1, 0), u, end, z)
        builder.put(f"stop_pin_{i}_{k}", stop, "base", placed, held, path=DRIVEN)

    m, (u, z) = d.motor, b.motor_axis_mm
    builder.put(
        f"motor_{i}",
        builder.made(make_motor),
        "base",
        d.stand(i) @ at(u, layers.motor_face_mm, z),
        pressed(cheek, 0.8 * m.pilot_height_mm, "the motor's pilot in the cheek"),
        seated(cheek, ring(m.diameter_mm - 1.0, m.pilot_diameter_mm), "motor on the cheek"),
        path=OUT,
    )
    place_leads(builder, i)
    length, sunk = motor_screw_mm(d.motor, d.layers)
    fixing, face = builder.cap_screw(d.motor.mount_screw, length), motor_side[0] + sunk
    for k, (x, height) in enumerate(brackets.motor_screw_positions(d)):
        placed = shoulder @ pointing((0, -1, 0), x, face, height)
        builder.put(f"motor_screw_{i}_{k}", fixing, "base", placed, path=DRIVEN)
    if d.sensed_at_shoulder:
        _board(builder, i)


def _board(builder: AssemblyBuilder, i: int) -> None:
    """Places the encoder's board on the cheek's head, on its spacers."""
    d, layers, block, board = builder.d, builder.d.layers, f"foot_block_{i}", f"encoder_board_{i}"
    shoulder, (back, front) = d.stand(i) @ at(d.bracket.shoulder_u_mm), layers.encoder_board_mm
    frame = shoulder @ at(0.0, front, 0.0) @ UPRIGHT
    builder.put(board, builder.made(make_encoder_board), "base", frame, path=IN, frame=block)
    size = board_screw(d.encoder)
    row = catalogue.screw(size)
    gap, clear = layers.encoder_head_mm[0] - front, row.clearance_hole_mm
    spacer = builder.once("board_spacer", bought_parts.make_spacer, clear, gap)
    thread, drilled = brackets.board_thread_mm(d)
    into = thread if drilled else thread - 2.0
    screw = builder.screw(size, longest(size, front - back + gap + into))
    face, core = ring(clear + 2.0, clear), row.tap_drill_mm
    for k, (x, height) in enumerate(d.board_screws_mm):
        own, e = f"board_spacer_{i}_{k}", d.encoder
        on = seated(board, face, "spacer under the board"), seated(f"encoder_cheek_{i}", face, "spacer on the cheek")
        placed = shoulder @ pointing((0, 1, 0), x, front, height)
        builder.put(own, spacer, "base", placed, *on, path=IN, frame=block)
        through = (
            pressed(own, 0.9 * gap, "screw through its spacer", (clear - core) / 2 + THREAD_MM),
            pressed(
                board,
                0.9 * e.board_thickness_mm,
                "screw through the board",
                (e.hole_diameter_mm - core) / 2 + THREAD_MM,
            ),
        )
        placed = shoulder @ pointing((0, -1, 0), x, back, height)
        builder.put(f"board_screw_{i}_{k}", screw, "base", placed, *through, path=DRIVEN)


def _arm(builder: AssemblyBuilder, i: int) -> None:
    d, arm, shaft = builder.d, f"upper_arm_{i}", f"shoulder_shaft_{i}"
    builder.put(arm, builder.made(make_upper_arm), arm, np.eye(4))
    builder.gap(arm, f"encoder_cheek_{i}", NEXT_TO_MM, "arm turns beside the cheek, 1 mm by design")
    b, of = d.bearing, arm if d.capstan is None else f"foot_block_{i}"
    if d.capstan is None:
        held = [pressed(arm, STUB_DEPTH_MM - CHAMFERS_MM / 2, "stub bonded in the arm", GLUE_MM)]
    else:
        in_bore, face = b.width_mm - CHAMFERS_MM, d.layers.arm_mm[1]
        held = [pressed(f"bearing_{i}_{side}", in_bore, "shaft in the bearing's bore") for side in "em"]
        on_ring = ring(b.shaft_shoulder_min_mm, b.bore_mm)
        held.append(seated(f"bearing_{i}_e", on_ring, "shaft's head on the inner ring"))
        held.append(pressed(arm, face - d.layers.bearings_mm[0][1] - CHAMFERS_MM, "arm on the shaft"))
        held.append(pressed(f"sector_{i}", d.capstan.web_y_mm[1] - face - CHAMFERS_MM, "sector on the shaft"))
    builder.put(shaft, builder.made(make_shoulder_shaft), arm, np.eye(4), *held, path=IN, frame=of)
    if d.sensed_at_shoulder:
        magnet, board, least = f"encoder_magnet_{i}", f"encoder_board_{i}", d.encoder.air_gap_min_mm
        in_shaft = pressed(shaft, 0.9 * d.magnet.thickness_mm, "magnet bonded in the shaft", GLUE_MM)
        placed, of = at(0.0, d.shaft.y_mm[0], 0.0), arm if d.capstan is None else shaft
        builder.put(magnet, builder.made(make_encoder_magnet), arm, placed, in_shaft, path=IN, frame=of)
        builder.gap(magnet, board, least, "air gap of the encoder", d.encoder.air_gap_max_mm)
        builder.gap(shaft, board, least, "air gap of the encoder")
    boss = d.layers.elbow_boss_mm[1] - d.layers.elbow_boss_mm[0]
    _cross_bar(builder, i, "elbow", arm, at(d.arm.length_mm), bonded(arm, boss - CHAMFERS_MM, *_IN_BOSS))


def _cross_bar(builder: AssemblyBuilder, i: int, end: str, link: str, frame: np.ndarray, in_boss: Connection) -> None:
    """A cross-bar and both of its balls, each on its stud, its hole towards the bar's middle."""
    f, bar = builder.d.forearm, f"cross_bar_{i}_{end}"
    pin_mm = forearm.rim_mm(f) + f.pin_past_mm - CHAMFERS_MM / 2
    radius, inside = f.seat_diameter_mm / 2, f.seat_diameter_mm / 2 - f.lip_mm
    pole = radius - sqrt(radius**2 - (POCKET_MM / 2) ** 2)
    seat = 0.98 * 2 * pi * radius * (inside - pole)  # the zone of a sphere between lip and grease pocket
    play = 2 * (CLEARANCE_MM + CLEARANCE_TOLERANCE_MM)
    names = [f"joint_ball_{i}_{j}_{end}" for j in SIDES]
    studs = (bonded(ball, pin_mm, "stud's pin bonded in its ball", BALL_GLUE_MM) for ball in names)
    builder.put(bar, builder.made(forearm.make_cross_bar), link, frame, in_boss, *studs, path=OUT)
    for j, ball in enumerate(names):
        placed = frame @ at(y=(j - 0.5) * f.width_mm) @ (HALF_TURN if j else np.eye(4))
        held = Connection(f"cup_shell_{i}_{j}_{end}", "ball in its cup", "ball", seat, play)
        builder.put(ball, builder.made(make_joint_ball), link, placed, held, path=OUT if j else IN, frame=bar)


def _rods(builder: AssemblyBuilder, i: int) -> None:
    d, f = builder.d, builder.d.forearm
    in_boss = bonded("platform", d.platform.boss_length_mm - CHAMFERS_MM, *_IN_BOSS)
    _cross_bar(builder, i, "wrist", "platform", d.turn(i) @ at(d.platform.radius_mm), in_boss)
    for j in SIDES:
        link, tube = f"rod_{i}_{j}", f"rod_tube_{i}_{j}"
        cups, eyes = [f"rod_cup_{i}_{j}_{end}" for end in _ENDS], [f"rod_eye_{i}_{j}_{k}" for k in range(2)]
        # the poles of both cups lie outwards, towards +y of the rod on that side
        _rod_end(builder, i, j, "elbow", np.eye(4) if j else _ABOUT_X)
        held = [seated(cup, ring(f.tube_outer_mm, f.tube_bore_mm), "tube on the cup's shoulder") for cup in cups]
        held += [bonded(eye, 0.9 * RING_MM[1], "spring's eye bonded on the tube", forearm.RING_GLUE_MM) for eye in eyes]
        builder.put(tube, builder.made(forearm.make_rod_tube), link, at(f.shoulder_mm), *held, path=_TO_THE_ELBOW)
        _rod_end(builder, i, j, "wrist", at(f.length_mm) @ (_ABOUT_Y if j else HALF_TURN))
        for eye, x, frame in zip(eyes, f.eyes_x_mm, _EYE_FRAMES[j], strict=True):
            builder.put(eye, builder.made(forearm.make_rod_eye), link, at(x) @ frame, path=_TO_THE_ELBOW, frame=tube)
            if f.eye_room_mm < d.design.requirements.clearance_min_mm + _NEXT_TO_ARM_MM:
                builder.gap(eye, f"upper_arm_{i}", _NEXT_TO_ARM_MM, "folds beside the arm, held by its spring")
    shared = _LOOP_SHARE * loop_overlap_mm3(f, d.travel.lean_max.value)
    for k in SIDES:  # both springs, each on a link of its own, which follows the rods
        name = builder.put(f"rod_spring_{i}_{k}", builder.made(make_rod_spring), f"spring_{i}_{k}", np.eye(4))
        for j in SIDES:
            builder.touch(name, f"rod_eye_{i}_{j}_{k}", "loop in its eye", overlap_mm3=shared)
            builder.gap(name, f"rod_tube_{i}_{j}", _NEXT_TO_TUBE_MM, "hangs on the tube")


def _rod_end(builder: AssemblyBuilder, i: int, j: int, end: str, frame: np.ndarray) -> None:
    """A rod's cup with its shell."""
    f, link, tube = builder.d.forearm, f"rod_{i}_{j}", f"rod_tube_{i}_{j}"
    ball, cup, shell = (f"{part}_{i}_{j}_{end}" for part in ("joint_ball", "rod_cup", "cup_shell"))
    on_tube = bonded(tube, f.spigot_length_mm - CHAMFERS_MM, "spigot bonded in the tube", TUBE_GLUE_MM)
    builder.put(cup, builder.made(forearm.make_rod_cup), link, frame, on_tube, path=_TO_THE_ELBOW, frame=tube)
    back = f.liner_radius_mm
    area = 0.9 * 2 * pi * back * (sqrt(back**2 - (POCKET_MM / 2) ** 2) - f.lip_mm)
    in_cup = Connection(cup, "shell bonded in its cup", "ball", area, 2 * LINER_GLUE_MM)
    builder.put(shell, builder.made(forearm.make_cup_shell), link, frame, in_cup, path=IN if j else OUT, frame=tube)
    builder.touch(ball, cup, "the cup around its shell", guides=False)
    for part in (cup, shell):
        builder.gap(part, f"cross_bar_{i}_{end}", _NEXT_TO_STUD_MM, "the rod leans beside the stud it hangs on")


def _platform(builder: AssemblyBuilder) -> None:
    d, p = builder.d, builder.d.platform
    top, thread = p.boss_diameter_mm / 2, catalogue.screw(p.stem_thread).diameter_mm
    builder.put("platform", builder.made(platform.make_platform), "platform", np.eye(4))
    into = min(platform.STEM_CORE_DEPTH_MM, p.boss_diameter_mm - 0.5) - CHAMFERS_MM
    builder.put(
        "handle_stem",
        builder.made(platform.make_handle_stem),
        "platform",
        at(z=top),
        bolted("platform", into, "stem in the platform's thread"),
        seated("platform", ring(p.stem_diameter_mm, thread), "stem on the platform"),
        bolted("knob", d.knob.thread_depth_mm - 1.0 - CHAMFERS_MM, "stem in the knob's thread"),
        path=DRIVEN,
    )
    flat = ring(min(d.knob.foot_diameter_mm, p.stem_diameter_mm), thread)
    on = seated("handle_stem", flat, "knob on its stem")
    builder.put("knob", builder.made(platform.make_knob), "platform", at(z=top + p.stem_length_mm), on, path=DRIVEN)


def _joints(d: Dimensions) -> list[Joint]:
    joints = []
    for i in CHAINS:
        shoulder = d.stand(i) @ at(d.bracket.shoulder_u_mm)
        joints.append(Joint(f"shoulder_{i}", "revolute", "base", f"upper_arm_{i}", shoulder, np.eye(4)))
        if d.capstan is not None:
            u, z = d.bracket.motor_axis_mm
            motor = d.stand(i) @ at(u, 0.0, z)
            joints.append(Joint(f"pinion_{i}", "revolute", "base", f"pinion_{i}", motor, np.eye(4)))
        for j in SIDES:
            side = (j - 0.5) * d.forearm.width_mm
            limit = d.forearm.tilt_limit_rad
            rod = f"rod_{i}_{j}"
            elbow = at(d.arm.length_mm, side)
            joints.append(Joint(f"elbow_{i}_{j}", "ball", f"upper_arm_{i}", rod, elbow, np.eye(4), limit))
            wrist = d.turn(i) @ at(d.platform.radius_mm, side)
            joints.append(Joint(f"wrist_{i}_{j}", "ball", "platform", rod, wrist, at(d.forearm.length_mm), limit))
    return joints


def _stops(d: Dimensions) -> list[Stop]:
    """Both ends of the shoulders: one pin in the sector's slot, or one pin beside either edge of the arm."""
    least = SHARE * brackets.STOP_ENGAGEMENT_MM
    direct = d.capstan is None
    return [
        Stop(
            f"shoulder_{i}",
            f"stop_pin_{i}_{end if direct else 0}",
            f"upper_arm_{i}" if direct else f"sector_{i}",
            angle,
            sense,
            least,
        )
        for i in CHAINS
        for end, (angle, sense) in enumerate(zip(d.stops_rad, (-1, 1), strict=True))
    ]


def assemble(d: Dimensions, progress: Progress = lambda _: None) -> Assembly:
    """Assembles the machine of a design.

    Args:
        d: Dimensions of the design.
        progress: Called with the part number when a new part is about to be made.

    Raises:
        BuildError: A solid could not be built (part, feature, parameter).
        DimensionError: No stock screw or dowel is short enough, or no stop pin long enough.
    """
    builder = AssemblyBuilder(d, progress)
    _base(builder)
    for i in CHAINS:
        _bracket(builder, i)
        _arm(builder, i)
        if d.capstan is not None:
            place_capstan(builder, d.capstan, i)
        else:
            place_direct(builder, i)
        _rods(builder, i)
    _platform(builder)
    dashboard = place_panel(builder)
    bought = supplies(d)
    return Assembly(
        name=d.design.name,
        occurrences=tuple(builder.occurrences),
        joints=tuple(_joints(d)),
        fits=builder.all_fits(),
        placement=link_placement(d),
        home_mm=d.design.home_mm,
        contacts=builder.contacts(),
        stops=tuple(_stops(d)),
        supplies=bought,
        reached=tuple(builder.reached),
        removals=tuple(builder.removals),
        order=assembly_sequence(builder, bought),
        dashboard=dashboard,
    )
