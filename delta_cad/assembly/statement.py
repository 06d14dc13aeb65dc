"""What every joint and drive of a design is made of: counted here from the design, held against what was placed."""

from __future__ import annotations

from delta_cad import catalogue
from delta_cad.assembly.leads import lead_statement
from delta_cad.assembly.panel import panel_needs, panel_statement
from delta_cad.assembly.supplies import BAR_ADHESIVE, keys
from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.forearm import TUBE_ADHESIVE
from delta_cad.mechanism.placement import CHAINS, SIDES
from delta_cad.solids.part import Need, Stated


def statement(d: Dimensions) -> tuple[Stated, ...]:
    """States the parts of frame, shoulders, drives, sensors, rods and handle, each with its count and its link."""
    stated = [
        Stated("frame", "base_plate", 1, "base_plate", "base"),
        Stated("handle", "platform", 1, "platform", "platform"),
        Stated("handle", "handle_stem", 1, "handle_stem", "platform"),
        Stated("handle", "knob", 1, "knob", "platform"),
    ]
    stated += panel_statement(d)
    if d.has_feet:
        stated.append(Stated("frame", "foot_?", 3, "foot", "base"))
    if d.has_feet and d.foot.stud_length_mm is None:
        stated.append(Stated("frame", "foot_screw_?", 3, f"screw_{d.foot.thread}x*", "base"))
    for i in CHAINS:
        stated.append(Stated(f"wrist_{i}", f"cross_bar_{i}_wrist", 1, "cross_bar", "platform"))
        stated += _bracket(i) + _shoulder(i) + _drive(d, i) + lead_statement(d, i) + _sensor(d, i)
        for j in SIDES:
            stated += _rod(i, j)
        stated += [Stated(f"pair_{i}", f"rod_spring_{i}_{k}", 1, "rod_spring", f"spring_{i}_{k}") for k in SIDES]
    return tuple(stated)


def needs(d: Dimensions) -> tuple[Need, ...]:
    """States what a machine needs beside its parts: cords, adhesives, grease, keys, and what holds it down."""
    tubes, bars = (catalogue.adhesive(name) for name in (TUBE_ADHESIVE, BAR_ADHESIVE))
    return (
        Need("rod_cord", len(CHAINS) * len(SIDES), "braided polyethylene cord *"),
        Need("tube_adhesive", 1, f"{tubes.maker} {tubes.order_code}"),
        Need("bar_adhesive", 1, f"{bars.maker} {bars.order_code}"),
        Need("joint_grease", 1, "silicone or PAO grease*"),
        *(Need(key.number, 1, "hexagon key *") for key in keys(d)),
        *panel_needs(d),
    )


def _bracket(i: int) -> list[Stated]:
    group = f"bracket_{i}"
    return [
        Stated(group, f"motor_cheek_{i}", 1, "motor_cheek", "base"),
        Stated(group, f"encoder_cheek_{i}", 1, "encoder_cheek", "base"),
        Stated(group, f"foot_block_{i}", 1, "foot_block", "base"),
        *(Stated(group, f"cheek_screw_{i}_{side}?", 2, "screw_M3x*", "base") for side in "me"),
        *(Stated(group, f"cheek_dowel_{i}_{side}?", 2, "dowel_3x*", "base") for side in "me"),
        Stated(group, f"base_screw_{i}_?", 2, "screw_M4x*", "base"),
        Stated(group, f"base_dowel_{i}_?", 2, "dowel_3x*", "base"),
    ]


def _shoulder(i: int) -> list[Stated]:
    group, link = f"shoulder_{i}", f"upper_arm_{i}"
    return [
        Stated(group, f"upper_arm_{i}", 1, "upper_arm", link),
        Stated(group, f"shoulder_shaft_{i}", 1, "shoulder_shaft", link),
        Stated(group, f"cross_bar_{i}_elbow", 1, "cross_bar", link),
    ]


def _drive(d: Dimensions, i: int) -> list[Stated]:
    group, link = f"drive_{i}", f"upper_arm_{i}"
    of_both = [
        Stated(group, f"motor_{i}", 1, "motor", "base"),
        Stated(group, f"motor_screw_{i}_?", len(d.bracket.motor_screws_rad), f"screw_{d.motor.mount_thread}x*", "base"),
    ]
    if d.capstan is None:  # the arm is clamped on the motor's shaft and turns in the motor's bearings
        return [
            *of_both,
            Stated(group, f"stop_pin_{i}_?", 2, "dowel_4x*", "base"),
            Stated(f"shoulder_{i}", f"shoulder_clamp_{i}", 1, "screw_M3x*", link),
        ]
    return [
        *of_both,
        Stated(group, f"stop_pin_{i}_?", 1, "dowel_4x*", "base"),
        Stated(f"shoulder_{i}", f"bearing_{i}_?", 2, "bearing", "base"),
        Stated(f"shoulder_{i}", f"wave_spring_{i}", 1, "wave_spring", "base"),
        Stated(f"shoulder_{i}", f"shoulder_washer_{i}", 1, "shoulder_washer", link),
        Stated(f"shoulder_{i}", f"shoulder_screw_{i}", 1, f"screw_{d.shaft.end_screw}x*", link),
        Stated(group, f"pinion_{i}", 1, "pinion", f"pinion_{i}"),
        Stated(group, f"sector_{i}", 1, "sector", link),
        Stated(group, f"sector_dowel_{i}_?", 2, "dowel_3x*", link),
        Stated(group, f"set_screw_{i}_?", 2, "set_screw_M3x*", f"pinion_{i}"),
        Stated(group, f"capstan_cable_{i}_outer", 1, "capstan_cable", link),
        Stated(group, f"capstan_cable_{i}_inner", 1, "capstan_cable_inner", link),
        *(
            Stated(group, f"capstan_cable_{i}_{side}_end", 1, f"capstan_cable_{side}_end", link)
            for side in ("inner", "outer")
        ),
        Stated(group, f"capstan_cable_{i}_turns", 1, "capstan_cable_turns", "base"),
        *(
            Stated(group, f"capstan_cable_{i}_strand_{side}", 1, f"capstan_cable_strand_{side}", "base")
            for side in ("inner", "outer")
        ),
        Stated(group, f"tension_carriage_{i}", 1, "tension_carriage", link),
        Stated(group, f"tension_screw_{i}", 1, "tension_screw_M3x*", link),
        Stated(group, f"crimp_sleeve_{i}_?", 2, "crimp_sleeve", link),
    ]


def _sensor(d: Dimensions, i: int) -> list[Stated]:
    if not d.sensed_at_shoulder:  # the motors have encoders of their own, on their rear ends
        return []
    group, screws = f"sensor_{i}", d.encoder.hole_count
    return [
        Stated(group, f"encoder_magnet_{i}", 1, "encoder_magnet", f"upper_arm_{i}"),
        Stated(group, f"encoder_board_{i}", 1, "encoder_board", "base"),
        Stated(group, f"board_spacer_{i}_?", screws, "board_spacer", "base"),
        Stated(group, f"board_screw_{i}_?", screws, "screw_M2.5x*", "base"),
    ]


def _rod(i: int, j: int) -> list[Stated]:
    rod = f"rod_{i}_{j}"
    return [
        Stated(f"elbow_{i}_{j}", f"joint_ball_{i}_{j}_elbow", 1, "joint_ball", f"upper_arm_{i}"),
        Stated(f"elbow_{i}_{j}", f"rod_cup_{i}_{j}_elbow", 1, "rod_cup", rod),
        Stated(f"elbow_{i}_{j}", f"cup_shell_{i}_{j}_elbow", 1, "cup_shell", rod),
        Stated(f"wrist_{i}_{j}", f"cup_shell_{i}_{j}_wrist", 1, "cup_shell", rod),
        Stated(rod, f"rod_tube_{i}_{j}", 1, "rod_tube", rod),
        Stated(f"wrist_{i}_{j}", f"rod_cup_{i}_{j}_wrist", 1, "rod_cup", rod),
        Stated(rod, f"rod_eye_{i}_{j}_?", 2, "rod_eye", rod),
        Stated(f"wrist_{i}_{j}", f"joint_ball_{i}_{j}_wrist", 1, "joint_ball", "platform"),
    ]
