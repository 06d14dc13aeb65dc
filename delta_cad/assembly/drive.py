"""The drives placed on their links: capstan, or motor on the shoulder's axis."""

from __future__ import annotations

import numpy as np

from delta_cad.assembly.bench import BESIDE_MM, Bench, at, longest, longest_dowel, longest_set_screw, pointing
from delta_cad.dimensions.arm import CLAMP_SCREW, INSIDE_RING_MM, WASHER_MM
from delta_cad.dimensions.cable.rim_ends import carriage_frame, sleeve_frames
from delta_cad.dimensions.capstan import SET_SCREW, TENSION_SCREW, TENSION_SCREW_LENGTH_MM
from delta_cad.mechanism.placement import chain_frame
from delta_cad.solids import capstan, shaft, upper_arm
from delta_cad.solids.bought import fasteners
from delta_cad.solids.bought.bearing import make_bearing, make_wave_spring

BESIDE = (  # what of an arm passes what of its own bracket at less than the clearance of others
    ("crimp_sleeve_{}_0", "motor_cheek_{}"),
    ("capstan_cable_{}_inner", "motor_cheek_{}"),
    ("capstan_cable_{}_inner_end", "motor_cheek_{}"),
    ("shoulder_washer_{}", "motor_cheek_{}"),
    ("shoulder_shaft_{}", "encoder_cheek_{}"),
    ("shoulder_shaft_{}", "wave_spring_{}"),
    *((f"sector_dowel_{{}}_{k}", "encoder_cheek_{}") for k in range(2)),
)
BESIDE_HEADS = ("sector_{}", "pinion_{}")  # what passes the heads of the motor's screws


def place_direct(bench: Bench, i: int) -> None:
    """Notes what is close where the arm sits on the motor's shaft."""
    bench.gap(f"upper_arm_{i}", f"motor_cheek_{i}", BESIDE_MM, "arm turns beside the cheek, 1 mm by design")
    clamp = bench.screw(CLAMP_SCREW, upper_arm.SHOULDER_SCREW_LENGTH_MM)
    seat = pointing((-1, 0, 0), upper_arm.SHOULDER_SEAT_X_MM, 0.0, bench.d.arm.shoulder_clamp_z_mm)
    bench.put(f"shoulder_clamp_{i}", clamp, f"upper_arm_{i}", seat)
    bench.touch(f"upper_arm_{i}", f"motor_{i}", "the arm is clamped on the motor's shaft")
    bench.gap(f"shoulder_shaft_{i}", f"motor_{i}", 0.3, "end of the motor's shaft before the stub, 0.5 mm by design")
    for k in range(len(bench.d.bracket.motor_screws_rad)):
        bench.gap(f"upper_arm_{i}", f"motor_screw_{i}_{k}", BESIDE_MM, "turns beside the sunk heads, 1.4 mm by design")
    for k in range(len(bench.d.bracket.stop_pins_mm)):
        bench.gap(f"upper_arm_{i}", f"stop_pin_{i}_{k}", 0.3, "stop pin is met 3 deg outside the cube")


def place_capstan(bench: Bench, i: int) -> None:
    """Places sector, pinion, cable and tensioner of a chain, and the bearings of its shoulder."""
    d, link = bench.d, f"upper_arm_{i}"
    bench.put(f"sector_{i}", bench.once("sector", lambda: capstan.make_sector(d)), link, np.eye(4))
    pinion = f"pinion_{i}"
    bench.put(pinion, bench.once("pinion", lambda: capstan.make_pinion(d)), pinion, np.eye(4))
    wall = capstan.capstan_of(d).collar_radius_mm - d.motor.shaft_diameter_mm / 2
    length = longest_set_screw(SET_SCREW, wall)
    grub = bench.once("set_screw", lambda: fasteners.make_set_screw(SET_SCREW, length))
    for k, frame in enumerate(capstan.set_screw_frames(d, length)):
        bench.put(f"set_screw_{i}_{k}", grub, pinion, frame)
    _cable(bench, i)
    carriage = bench.once("tension_carriage", lambda: capstan.make_carriage(d))
    bench.put(f"tension_carriage_{i}", carriage, link, carriage_frame(capstan.capstan_of(d)))
    tension = bench.once("tension_screw", lambda: fasteners.make_tension_screw(TENSION_SCREW, TENSION_SCREW_LENGTH_MM))
    bench.put(f"tension_screw_{i}", tension, link, capstan.tension_screw_frame(d))
    sleeve = bench.once("crimp_sleeve", lambda: capstan.make_crimp_sleeve(d))
    for end, frame in enumerate(sleeve_frames(capstan.capstan_of(d))):
        bench.put(f"crimp_sleeve_{i}_{end}", sleeve, link, frame)
    first = d.layers.arm_mm[0] + 1.0
    pin = bench.dowel("3", longest_dowel("3", capstan.capstan_of(d).web_y_mm[1] - first))
    for k, (x, z) in enumerate(upper_arm.dowel_positions(d)):
        bench.put(f"sector_dowel_{i}_{k}", pin, link, pointing((0, 1, 0), x, first, z))
    bearing = bench.once("bearing", lambda: make_bearing(d))
    shoulder = chain_frame(i) @ at(d.bracket.shoulder_u_mm)
    encoder_side, motor_side = d.layers.bearings_mm
    for side, start in (("e", encoder_side[0]), ("m", motor_side[0])):
        bench.put(f"bearing_{i}_{side}", bearing, "base", shoulder @ at(0.0, start, 0.0))
        bench.touch(f"shoulder_shaft_{i}", f"bearing_{i}_{side}", "shaft in the bearing's bore")
    if d.preload is not None:
        spring = bench.once("wave_spring", lambda: make_wave_spring(d))
        bench.put(f"wave_spring_{i}", spring, "base", shoulder @ at(0.0, encoder_side[0] - d.preload.work_height_mm))
    washer = bench.once("shoulder_washer", lambda: shaft.make_shoulder_washer(d))
    bench.put(f"shoulder_washer_{i}", washer, link, at(0.0, motor_side[1]))
    length = longest(d.shaft.end_screw, WASHER_MM + INSIDE_RING_MM + d.shaft.end_thread_mm)
    seat = pointing((0, 1, 0), 0.0, motor_side[1] + WASHER_MM)
    bench.put(f"shoulder_screw_{i}", bench.screw(d.shaft.end_screw, length), link, seat)
    bench.touch(f"shoulder_washer_{i}", f"bearing_{i}_m", "washer on the inner ring", guides=False)
    bench.gap(f"shoulder_screw_{i}", f"bearing_{i}_m", 1.0, "screw in the shaft that the bearing is on")
    bench.touch(f"upper_arm_{i}", f"bearing_{i}_e", "collar on the inner ring")
    bench.touch(f"sector_{i}", f"bearing_{i}_m", "collar on the inner ring")
    bench.touch(pinion, f"motor_{i}", "pinion on the motor's shaft")
    bench.gap(f"sector_{i}", f"motor_cheek_{i}", BESIDE_MM, "sector turns beside the cheek, 1 mm by design")
    for moving, fixed in BESIDE:
        bench.gap(moving.format(i), fixed.format(i), BESIDE_MM, "turns beside the bracket, 1 mm or more by design")
    if d.sensed_at_shoulder:
        bench.gap(f"encoder_magnet_{i}", f"bearing_{i}_e", BESIDE_MM, "in the shaft's head, 1 mm or more by design")
    bench.gap(f"sector_{i}", f"motor_{i}", BESIDE_MM, "the motor's shaft comes out of the pinion beside the rim")
    for k in range(len(d.bracket.motor_screws_rad)):
        for moving in BESIDE_HEADS:
            bench.gap(moving.format(i), f"motor_screw_{i}_{k}", BESIDE_MM, "turns beside the sunk heads")
    thicker = 0.75 * (d.cable.diameter_mm - 0.54)  # between the rim and the pinion's crest; 1.4 mm for 0.54 mm
    words = "capstan gap, 1 mm between the pitch circles by design"
    bench.gap(f"sector_{i}", pinion, 1.2 + thicker, words, 1.65 + thicker)
    bench.gap(f"sector_{i}", f"stop_pin_{i}_0", 0.3, "stop pin in its slot, 0.5 mm at either side")
    bench.gap(pinion, f"motor_cheek_{i}", 0.3, "collar in the pilot's bore, 0.5 mm by design")
    for k in range(2):
        bench.touch(f"set_screw_{i}_{k}", f"motor_{i}", "set screw on the motor's shaft", guides=False)
        bench.gap(f"set_screw_{i}_{k}", f"motor_cheek_{i}", 0.25, "set screw below the collar's surface")
        for n in range(len(d.bracket.motor_screws_rad)):
            bench.gap(f"set_screw_{i}_{k}", f"motor_screw_{i}_{n}", 0.4, "set screw below the collar's surface")


def _cable(bench: Bench, i: int) -> None:
    """Places the cable of a chain, in pieces: on the sector at either end, free, and on the pinion."""
    d, link, pinion = bench.d, f"upper_arm_{i}", f"pinion_{i}"
    name, shoulder = f"capstan_cable_{i}", chain_frame(i) @ at(d.bracket.shoulder_u_mm)
    made = bench.once("turns", lambda: capstan.make_turns(d))
    u, z = d.bracket.motor_axis_mm
    turns = bench.put(f"{name}_turns", made, "base", chain_frame(i) @ at(u, 0.0, z))
    bench.touch(turns, pinion, "turns in the pinion's groove", guides=False)
    bench.gap(f"sector_{i}", turns, 0.5, "turns beside the rim, 1 mm by design, and beside the lug")
    for end, side in enumerate(("inner", "outer")):
        on_rim = bench.put(
            f"{name}_{side}", bench.once(f"cable_{side}", lambda end=end: capstan.make_cable(d, end)), link, np.eye(4)
        )
        beyond = bench.once(f"cable_{side}_end", lambda end=end: capstan.make_cable_end(d, end))
        bench.piece(on_rim, bench.put(f"{name}_{side}_end", beyond, link, np.eye(4)))
        strand = bench.once(f"strand_{side}", lambda end=end: capstan.make_strand(d, end))
        free = bench.put(f"{name}_strand_{side}", strand, "base", shoulder)
        bench.gap(on_rim, turns, 0.2, "cable on the rim beside that on the pinion, 0.46 mm by design")
        bench.gap(on_rim, pinion, 0.6, "cable on the rim beside the pinion")
        bench.touch(free, f"sector_{i}", "the strand leaves the rim along its tangent", guides=False)
        bench.touch(free, pinion, "the strand reaches the groove along its tangent", guides=False)
        for other in (f"{name}_strand_inner", f"{name}_strand_outer"):
            bench.piece(on_rim, other)
        bench.piece(free, turns)
