"""Every part of a design made and placed on its link: the only place that knows what is fixed to what."""

from __future__ import annotations

import numpy as np

from delta_cad import catalogue
from delta_cad.assembly.bench import (
    BESIDE_MM,
    HALF_TURN,
    UPRIGHT,
    Bench,
    Progress,
    at,
    longest,
    longest_dowel,
    pointing,
)
from delta_cad.assembly.contacts import contacts, stops
from delta_cad.assembly.drive import place_capstan, place_direct
from delta_cad.assembly.exchange import reached, removals
from delta_cad.assembly.leads import lead_contacts, place_leads
from delta_cad.assembly.machine import Assembly
from delta_cad.assembly.order.stated import order
from delta_cad.assembly.panel import panel_contacts, place_panel, place_sleeves
from delta_cad.assembly.supplies import supplies
from delta_cad.dimensions import Dimensions, link_placement
from delta_cad.dimensions.keys import motor_screw_mm
from delta_cad.mechanism.placement import CHAINS, SIDES, chain_frame
from delta_cad.solids import brackets, forearm, platform, shaft, upper_arm
from delta_cad.solids.base_plate import between_chains, make_base_plate
from delta_cad.solids.bought import fasteners
from delta_cad.solids.bought.ball import make_joint_ball
from delta_cad.solids.bought.encoder_board import make_encoder_board
from delta_cad.solids.bought.foot import make_foot
from delta_cad.solids.bought.magnet import make_magnet
from delta_cad.solids.bought.motor import make_motor
from delta_cad.solids.bought.spring import loop_overlap_mm3, make_rod_spring
from delta_cad.solids.part import Joint

ABOUT_X, ABOUT_Y = np.diag([1.0, -1.0, -1.0, 1.0]), np.diag([-1.0, 1.0, -1.0, 1.0])
EYE_FRAMES = ((ABOUT_X, HALF_TURN), (ABOUT_Y, np.eye(4)))  # of a pair's rods: away from the arm, towards it
BESIDE_STUD_MM = 0.4  # least gap of a rod's end beside its stud: 0.5 mm at the tilt that the joint is made for
BESIDE_TUBE_MM = 1.5  # least gap of a spring's loop beside the tube that carries its eye: 2.7 mm as it hangs
LOOP_SHARE = 1.1  # times what a loop, drawn stiff, shares with its eye at the largest lean: the sum's pieces, roundings
BESIDE_ARM_MM = 1.0  # least gap of a spring's eye beside the arm: 2 mm where the rod has not turned about itself


def _base(bench: Bench) -> None:
    d = bench.d
    bench.put("base_plate", bench.once("base_plate", lambda: make_base_plate(d)), "base", np.eye(4))
    place_sleeves(bench)
    if not d.has_feet:
        return
    foot = bench.once("foot", lambda: make_foot(d))
    for i, (x, y) in enumerate(between_chains(d.base.foot_circle_mm / 2)):
        low = d.base.top_mm - d.base.thickness_mm
        bench.put(f"foot_{i}", foot, "base", at(x, y, low))
        if d.foot.stud_length_mm is None:
            row = catalogue.screw(d.foot.thread)
            rest = d.foot.height_mm - row.counterbore_depth_mm
            screw = bench.screw(d.foot.thread, longest(d.foot.thread, rest + d.base.thickness_mm))
            bench.put(f"foot_screw_{i}", screw, "base", pointing((0, 0, -1), x, y, low - rest))


def _bracket(bench: Bench, i: int) -> None:
    d, layers, b = bench.d, bench.d.layers, bench.d.bracket
    shoulder = chain_frame(i) @ at(b.shoulder_u_mm)
    encoder_side, motor_side = layers.encoder_cheek_mm, layers.motor_cheek_mm
    for number, make in (
        ("motor_cheek", brackets.make_motor_cheek),
        ("encoder_cheek", brackets.make_encoder_cheek),
        ("foot_block", brackets.make_foot_block),
    ):
        bench.put(f"{number}_{i}", bench.once(number, lambda make=make: make(d)), "base", shoulder)

    into = brackets.cheek_dowel_depth_mm(d)
    for side, outwards, (inside, outside) in (("m", 1.0, motor_side), ("e", -1.0, encoder_side[::-1])):
        thickness = abs(outside - inside)
        screw = bench.screw(brackets.BLOCK_SCREW, brackets.cheek_screw_length_mm(d, thickness))
        under_head = outside - outwards * brackets.cheek_screw_sink_mm(d, thickness)
        for k, (x, z) in enumerate(brackets.cheek_screw_positions(d)):
            seat = pointing((0, outwards, 0), x, under_head, z)
            bench.put(f"cheek_screw_{i}_{side}{k}", screw, "base", shoulder @ seat)
        pin = bench.dowel("3", longest_dowel("3", into + thickness))
        for k, (x, z) in enumerate(brackets.cheek_dowel_positions(d)):
            bottom = pointing((0, outwards, 0), x, inside - outwards * into, z)
            bench.put(f"cheek_dowel_{i}_{side}{k}", pin, "base", shoulder @ bottom)

    middle = (encoder_side[1] + motor_side[0]) / 2
    row = catalogue.screw(brackets.BASE_SCREW)
    low = d.base.top_mm - d.base.thickness_mm
    rest = d.base.thickness_mm - row.counterbore_depth_mm
    base_screw = bench.screw(brackets.BASE_SCREW, longest(brackets.BASE_SCREW, rest + brackets.BASE_THREAD_MM - 0.5))
    for k, u in enumerate(b.base_screw_u_mm):
        seat = pointing((0, 0, -1), u, middle, low + row.counterbore_depth_mm)
        bench.put(f"base_screw_{i}_{k}", base_screw, "base", chain_frame(i) @ seat)
    sunk, filled = brackets.base_pin_mm(d)
    pin = bench.dowel("3", longest_dowel("3", filled))
    for k, u in enumerate(b.base_dowel_u_mm):
        bench.put(f"base_dowel_{i}_{k}", pin, "base", chain_frame(i) @ at(u, middle, d.base.top_mm - sunk))

    stop = bench.dowel("4", brackets.stop_pin_length_mm(d))
    for k, (u, z) in enumerate(b.stop_pins_mm):
        placed = chain_frame(i) @ pointing((0, -1, 0), u, motor_side[1] - brackets.STOP_SUNK_MM, z)
        bench.put(f"stop_pin_{i}_{k}", stop, "base", placed)

    motor = bench.once("motor", lambda: make_motor(d))
    u, z = b.motor_axis_mm
    bench.put(f"motor_{i}", motor, "base", chain_frame(i) @ at(u, motor_side[1], z))
    place_leads(bench, i)
    length, sunk = motor_screw_mm(d.motor, d.layers)
    fixing, face = bench.screw(d.motor.mount_thread, length), motor_side[0] + sunk
    for k, (x, height) in enumerate(brackets.motor_screw_positions(d)):
        bench.put(f"motor_screw_{i}_{k}", fixing, "base", shoulder @ pointing((0, -1, 0), x, face, height))

    if d.sensed_at_shoulder:
        _board(bench, shoulder, i)


def _board(bench: Bench, shoulder: np.ndarray, i: int) -> None:
    """Places the encoder's board on the cheek's head, on its spacers."""
    d, layers = bench.d, bench.d.layers
    board = bench.once("encoder_board", lambda: make_encoder_board(d))
    back, front = layers.encoder_board_mm
    bench.put(f"encoder_board_{i}", board, "base", shoulder @ at(0.0, front, 0.0) @ UPRIGHT)
    fixing_row = catalogue.screw(brackets.BOARD_SCREW)
    gap = layers.encoder_head_mm[0] - front
    spacer = bench.once("board_spacer", lambda: fasteners.make_spacer(fixing_row.clearance_hole_mm, gap))
    thread, drilled = brackets.board_thread_mm(d)
    into = thread if drilled else thread - 2.0
    board_screw = bench.screw(brackets.BOARD_SCREW, longest(brackets.BOARD_SCREW, front - back + gap + into))
    for k, (x, height) in enumerate(d.board_screws_mm):
        bench.put(f"board_spacer_{i}_{k}", spacer, "base", shoulder @ pointing((0, 1, 0), x, front, height))
        bench.put(f"board_screw_{i}_{k}", board_screw, "base", shoulder @ pointing((0, -1, 0), x, back, height))


def _arm(bench: Bench, i: int) -> None:
    d, a, link = bench.d, bench.d.arm, f"upper_arm_{i}"
    bench.put(f"upper_arm_{i}", bench.once("upper_arm", lambda: upper_arm.make_upper_arm(d)), link, np.eye(4))
    bench.put(
        f"shoulder_shaft_{i}", bench.once("shoulder_shaft", lambda: shaft.make_shoulder_shaft(d)), link, np.eye(4)
    )
    if d.sensed_at_shoulder:
        magnet = bench.once("encoder_magnet", lambda: make_magnet(d))
        bench.put(f"encoder_magnet_{i}", magnet, link, at(0.0, d.shaft.y_mm[0], 0.0))
    bench.put(f"cross_bar_{i}_elbow", bench.once("cross_bar", lambda: forearm.make_cross_bar(d)), link, at(a.length_mm))
    _balls(bench, i, "elbow", link, at(a.length_mm))
    bench.gap(f"upper_arm_{i}", f"encoder_cheek_{i}", BESIDE_MM, "arm turns beside the cheek, 1 mm by design")
    if not d.sensed_at_shoulder:
        return
    nearest, widest = d.encoder.air_gap_min_mm, d.encoder.air_gap_max_mm
    bench.gap(f"encoder_magnet_{i}", f"encoder_board_{i}", nearest, "air gap of the encoder", widest)
    bench.gap(f"shoulder_shaft_{i}", f"encoder_board_{i}", d.encoder.air_gap_min_mm, "air gap of the encoder")


def _balls(bench: Bench, i: int, end: str, link: str, bar: np.ndarray) -> None:
    """Both balls of a cross-bar, each on its stud, its hole towards the bar's middle."""
    ball = bench.once("joint_ball", lambda: make_joint_ball(bench.d))
    for j in SIDES:
        side = at(y=(j - 0.5) * bench.d.forearm.width_mm)
        bench.put(f"joint_ball_{i}_{j}_{end}", ball, link, bar @ side @ (HALF_TURN if j else np.eye(4)))


def _rods(bench: Bench, i: int) -> None:
    d, f = bench.d, bench.d.forearm
    cup = bench.once("rod_cup", lambda: forearm.make_rod_cup(d))
    shell = bench.once("cup_shell", lambda: forearm.make_cup_shell(d))
    eye = bench.once("rod_eye", lambda: forearm.make_rod_eye(d))
    tube = bench.once("rod_tube", lambda: forearm.make_rod_tube(d))
    bar = bench.once("cross_bar", lambda: forearm.make_cross_bar(d))
    wrist = chain_frame(i) @ at(d.platform.radius_mm)
    bench.put(f"cross_bar_{i}_wrist", bar, "platform", wrist)
    _balls(bench, i, "wrist", "platform", wrist)
    for j in SIDES:
        link = f"rod_{i}_{j}"
        # the poles of both cups lie outwards, towards +y of the rod on that side
        elbow, far = np.eye(4) if j else ABOUT_X, at(f.length_mm) @ (ABOUT_Y if j else HALF_TURN)
        bench.put(f"rod_cup_{i}_{j}_elbow", cup, link, elbow)
        bench.put(f"cup_shell_{i}_{j}_elbow", shell, link, elbow)
        bench.put(f"rod_tube_{i}_{j}", tube, link, at(f.shoulder_mm))
        bench.put(f"rod_cup_{i}_{j}_wrist", cup, link, far)
        bench.put(f"cup_shell_{i}_{j}_wrist", shell, link, far)
        for k, x in enumerate(f.eyes_x_mm):
            bench.put(f"rod_eye_{i}_{j}_{k}", eye, link, at(x) @ EYE_FRAMES[j][k])
            if f.eye_room_mm < d.design.requirements.clearance_min_mm + BESIDE_ARM_MM:
                reason = "folds beside the arm, held by its spring"
                bench.gap(f"rod_eye_{i}_{j}_{k}", f"upper_arm_{i}", BESIDE_ARM_MM, reason)
        for end in ("elbow", "wrist"):
            ball, own, lining = (f"{part}_{i}_{j}_{end}" for part in ("joint_ball", "rod_cup", "cup_shell"))
            bench.touch(ball, lining, "ball in its cup")
            bench.touch(ball, own, "the cup around its shell", guides=False)
            for part in (own, lining):
                bench.gap(part, f"cross_bar_{i}_{end}", BESIDE_STUD_MM, "the rod leans beside the stud it hangs on")
    _springs(bench, i)


def _springs(bench: Bench, i: int) -> None:
    """Both springs across a pair of rods, each on a link of its own, which follows the rods."""
    spring = bench.once("rod_spring", lambda: make_rod_spring(bench.d))
    shared = LOOP_SHARE * loop_overlap_mm3(bench.d.forearm, bench.d.travel.lean_max.value)
    for k in SIDES:
        name = bench.put(f"rod_spring_{i}_{k}", spring, f"spring_{i}_{k}", np.eye(4))
        for j in SIDES:
            bench.touch(name, f"rod_eye_{i}_{j}_{k}", "loop in its eye", overlap_mm3=shared)
            bench.gap(name, f"rod_tube_{i}_{j}", BESIDE_TUBE_MM, "hangs on the tube")


def _platform(bench: Bench) -> None:
    d, p = bench.d, bench.d.platform
    top = p.boss_diameter_mm / 2
    bench.put("platform", bench.once("platform", lambda: platform.make_platform(d)), "platform", np.eye(4))
    stem = bench.once("handle_stem", lambda: platform.make_handle_stem(d))
    bench.put("handle_stem", stem, "platform", at(z=top))
    bench.put("knob", bench.once("knob", lambda: platform.make_knob(d)), "platform", at(z=top + p.stem_length_mm))


def _joints(d: Dimensions) -> list[Joint]:
    joints = []
    for i in CHAINS:
        shoulder = chain_frame(i) @ at(d.bracket.shoulder_u_mm)
        joints.append(Joint(f"shoulder_{i}", "revolute", "base", f"upper_arm_{i}", shoulder, np.eye(4)))
        if d.capstan is not None:
            u, z = d.bracket.motor_axis_mm
            motor = chain_frame(i) @ at(u, 0.0, z)
            joints.append(Joint(f"pinion_{i}", "revolute", "base", f"pinion_{i}", motor, np.eye(4)))
        for j in SIDES:
            side = (j - 0.5) * d.forearm.width_mm
            limit = d.forearm.tilt_limit_rad
            rod = f"rod_{i}_{j}"
            elbow = at(d.arm.length_mm, side)
            joints.append(Joint(f"elbow_{i}_{j}", "ball", f"upper_arm_{i}", rod, elbow, np.eye(4), limit))
            wrist = chain_frame(i) @ at(d.platform.radius_mm, side)
            joints.append(Joint(f"wrist_{i}_{j}", "ball", "platform", rod, wrist, at(d.forearm.length_mm), limit))
    return joints


def assemble(d: Dimensions, progress: Progress = lambda _: None) -> Assembly:
    """Assembles the machine of a design.

    Args:
        d: Dimensions of the design.
        progress: Called with the part number when a new part is about to be made.

    Raises:
        BuildError: A solid could not be built (part, feature, parameter).
        DimensionError: No stock screw or dowel is short enough, or no stop pin long enough.
    """
    bench = Bench(d, progress)
    _base(bench)
    for i in CHAINS:
        _bracket(bench, i)
        _arm(bench, i)
        if d.capstan is not None:
            place_capstan(bench, i)
        else:
            place_direct(bench, i)
        _rods(bench, i)
    _platform(bench)
    dashboard = place_panel(bench)
    cube = d.design.cube
    return Assembly(
        name=d.design.name,
        occurrences=tuple(bench.occurrences),
        joints=tuple(_joints(d)),
        fits=tuple(bench.fits),
        placement=link_placement(d),
        home_mm=np.array([0.0, 0.0, cube.bottom_height_mm + cube.half_side_mm]),
        contacts=(*contacts(d), *panel_contacts(d), *lead_contacts(d)),
        stops=stops(d),
        supplies=supplies(d),
        reached=reached(d),
        removals=removals(d),
        order=order(d, bench.occurrences),
        dashboard=dashboard,
    )
