"""The parts of every joint, drive and group of a design and what is bought besides: names, counts, numbers, links."""

from __future__ import annotations

from dataclasses import dataclass

from delta_cad import catalogue
from delta_cad.assembly.supplies import BAR_ADHESIVE, keys
from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.forearm import TUBE_ADHESIVE
from delta_cad.dimensions.installation.panel import SCREW
from delta_cad.mechanism.placement import CHAINS, SIDES
from delta_cad.solids.base_plate import mount_places
from delta_cad.solids.leads import CLIP, SENSOR


@dataclass(frozen=True)
class ExpectedPart:
    """A kind of part of a joint, a drive or the frame.

    Attributes:
        group: What it belongs to, such as "shoulder_0".
        names: Pattern of the occurrences' names, `*` for any text.
        count: How many of them there are.
        number: Pattern of their part number.
        link: Name of the rigid body that carries them.
    """

    group: str
    names: str
    count: int
    number: str
    link: str


@dataclass(frozen=True)
class ExpectedSupply:
    """What must be bought besides the parts that are placed.

    Attributes:
        number: As in `Supply`.
        quantity: How many.
        order_code: Pattern of what it is ordered by, as of `fnmatch`.
    """

    number: str
    quantity: int
    order_code: str


def expected_parts(d: Dimensions) -> tuple[ExpectedPart, ...]:
    """Counts the parts of frame, shoulders, drives, sensors, rods and handle."""
    stated = [
        ExpectedPart("frame", "base_plate", 1, "base_plate", "base"),
        ExpectedPart("handle", "platform", 1, "platform", "platform"),
        ExpectedPart("handle", "handle_stem", 1, "handle_stem", "platform"),
        ExpectedPart("handle", "knob", 1, "knob", "platform"),
    ]
    stated += _panel(d)
    if d.has_feet:
        stated.append(ExpectedPart("frame", "foot_?", 3, "foot", "base"))
    if d.has_feet and d.foot.stud_length_mm is None:
        stated.append(ExpectedPart("frame", "foot_screw_?", 3, f"screw_{d.foot.thread}x*", "base"))
    for i in CHAINS:
        stated.append(ExpectedPart(f"wrist_{i}", f"cross_bar_{i}_wrist", 1, "cross_bar", "platform"))
        stated += _bracket(i) + _shoulder(i) + _drive(d, i) + _leads(d, i) + _sensor(d, i)
        for j in SIDES:
            stated += _rod(i, j)
        stated += [ExpectedPart(f"pair_{i}", f"rod_spring_{i}_{k}", 1, "rod_spring", f"spring_{i}_{k}") for k in SIDES]
    return tuple(stated)


def expected_supplies(d: Dimensions) -> tuple[ExpectedSupply, ...]:
    """Counts cords, adhesives, grease, keys, and what holds the machine down."""
    tubes, bars = (catalogue.adhesive(name) for name in (TUBE_ADHESIVE, BAR_ADHESIVE))
    return (
        ExpectedSupply("rod_cord", len(CHAINS) * len(SIDES), "braided polyethylene cord *"),
        ExpectedSupply("tube_adhesive", 1, f"{tubes.maker} {tubes.order_code}"),
        ExpectedSupply("bar_adhesive", 1, f"{bars.maker} {bars.order_code}"),
        ExpectedSupply("joint_grease", 1, "silicone or PAO grease*"),
        *(ExpectedSupply(key.number, 1, "hexagon key *") for key in keys(d)),
        *_mounting(d),
    )


def _bracket(i: int) -> list[ExpectedPart]:
    group = f"bracket_{i}"
    return [
        ExpectedPart(group, f"motor_cheek_{i}", 1, "motor_cheek", "base"),
        ExpectedPart(group, f"encoder_cheek_{i}", 1, "encoder_cheek", "base"),
        ExpectedPart(group, f"foot_block_{i}", 1, "foot_block", "base"),
        *(ExpectedPart(group, f"cheek_screw_{i}_{side}?", 2, "screw_M3x*", "base") for side in "me"),
        *(ExpectedPart(group, f"cheek_dowel_{i}_{side}?", 2, "dowel_3x*", "base") for side in "me"),
        ExpectedPart(group, f"base_screw_{i}_?", 2, "screw_M4x*", "base"),
        ExpectedPart(group, f"base_dowel_{i}_?", 2, "dowel_3x*", "base"),
    ]


def _shoulder(i: int) -> list[ExpectedPart]:
    group, link = f"shoulder_{i}", f"upper_arm_{i}"
    return [
        ExpectedPart(group, f"upper_arm_{i}", 1, "upper_arm", link),
        ExpectedPart(group, f"shoulder_shaft_{i}", 1, "shoulder_shaft", link),
        ExpectedPart(group, f"cross_bar_{i}_elbow", 1, "cross_bar", link),
    ]


def _drive(d: Dimensions, i: int) -> list[ExpectedPart]:
    group, link = f"drive_{i}", f"upper_arm_{i}"
    of_both = [
        ExpectedPart(group, f"motor_{i}", 1, "motor", "base"),
        ExpectedPart(
            group, f"motor_screw_{i}_?", len(d.bracket.motor_screws_rad), f"screw_{d.motor.mount_thread}x*", "base"
        ),
    ]
    if d.capstan is None:  # the arm is clamped on the motor's shaft and turns in the motor's bearings
        return [
            *of_both,
            ExpectedPart(group, f"stop_pin_{i}_?", 2, "dowel_4x*", "base"),
            ExpectedPart(f"shoulder_{i}", f"shoulder_clamp_{i}", 1, "screw_M3x*", link),
        ]
    return [
        *of_both,
        ExpectedPart(group, f"stop_pin_{i}_?", 1, "dowel_4x*", "base"),
        ExpectedPart(f"shoulder_{i}", f"bearing_{i}_?", 2, "bearing", "base"),
        ExpectedPart(f"shoulder_{i}", f"wave_spring_{i}", 1, "wave_spring", "base"),
        ExpectedPart(f"shoulder_{i}", f"shoulder_washer_{i}", 1, "shoulder_washer", link),
        ExpectedPart(f"shoulder_{i}", f"shoulder_screw_{i}", 1, f"screw_{d.shaft.end_screw}x*", link),
        ExpectedPart(group, f"pinion_{i}", 1, "pinion", f"pinion_{i}"),
        ExpectedPart(group, f"sector_{i}", 1, "sector", link),
        ExpectedPart(group, f"sector_dowel_{i}_?", 2, "dowel_3x*", link),
        ExpectedPart(group, f"set_screw_{i}_?", 2, "set_screw_M3x*", f"pinion_{i}"),
        ExpectedPart(group, f"capstan_cable_{i}_outer", 1, "capstan_cable", link),
        ExpectedPart(group, f"capstan_cable_{i}_inner", 1, "capstan_cable_inner", link),
        *(
            ExpectedPart(group, f"capstan_cable_{i}_{side}_end", 1, f"capstan_cable_{side}_end", link)
            for side in ("inner", "outer")
        ),
        ExpectedPart(group, f"capstan_cable_{i}_turns", 1, "capstan_cable_turns", "base"),
        *(
            ExpectedPart(group, f"capstan_cable_{i}_strand_{side}", 1, f"capstan_cable_strand_{side}", "base")
            for side in ("inner", "outer")
        ),
        ExpectedPart(group, f"tension_carriage_{i}", 1, "tension_carriage", link),
        ExpectedPart(group, f"tension_screw_{i}", 1, "tension_screw_M3x*", link),
        ExpectedPart(group, f"crimp_sleeve_{i}_?", 2, "crimp_sleeve", link),
    ]


def _sensor(d: Dimensions, i: int) -> list[ExpectedPart]:
    if not d.sensed_at_shoulder:  # the motors have encoders of their own, on their rear ends
        return []
    group, screws = f"sensor_{i}", d.encoder.hole_count
    return [
        ExpectedPart(group, f"encoder_magnet_{i}", 1, "encoder_magnet", f"upper_arm_{i}"),
        ExpectedPart(group, f"encoder_board_{i}", 1, "encoder_board", "base"),
        ExpectedPart(group, f"board_spacer_{i}_?", screws, "board_spacer", "base"),
        ExpectedPart(group, f"board_screw_{i}_?", screws, "screw_M2.5x*", "base"),
    ]


def _rod(i: int, j: int) -> list[ExpectedPart]:
    rod = f"rod_{i}_{j}"
    return [
        ExpectedPart(f"elbow_{i}_{j}", f"joint_ball_{i}_{j}_elbow", 1, "joint_ball", f"upper_arm_{i}"),
        ExpectedPart(f"elbow_{i}_{j}", f"rod_cup_{i}_{j}_elbow", 1, "rod_cup", rod),
        ExpectedPart(f"elbow_{i}_{j}", f"cup_shell_{i}_{j}_elbow", 1, "cup_shell", rod),
        ExpectedPart(f"wrist_{i}_{j}", f"cup_shell_{i}_{j}_wrist", 1, "cup_shell", rod),
        ExpectedPart(rod, f"rod_tube_{i}_{j}", 1, "rod_tube", rod),
        ExpectedPart(f"wrist_{i}_{j}", f"rod_cup_{i}_{j}_wrist", 1, "rod_cup", rod),
        ExpectedPart(rod, f"rod_eye_{i}_{j}_?", 2, "rod_eye", rod),
        ExpectedPart(f"wrist_{i}_{j}", f"joint_ball_{i}_{j}_wrist", 1, "joint_ball", "platform"),
    ]


def _leads(d: Dimensions, i: int) -> list[ExpectedPart]:
    stated = [ExpectedPart(f"drive_{i}", f"{s.number}_{i}_?", len(s.across_mm), s.number, "base") for s in d.leads]
    if d.sensor_lead is not None:
        stated += [ExpectedPart(f"sensor_{i}", f"{number}_{i}", 1, number, "base") for number in (SENSOR, CLIP)]
    return stated


def _panel(d: Dimensions) -> list[ExpectedPart]:
    stated = []
    if d.sleeve_mm:
        stated.append(ExpectedPart("frame", "mount_sleeve_?", len(mount_places(d)), "mount_sleeve", "base"))
    if d.panel is not None:
        stated += [ExpectedPart("panel", name, 1, name, "base") for name in ("panel", "boot", "bezel")]
        count = len(d.panel.screw_places())
        stated.append(ExpectedPart("panel", "bezel_screw_?", count, f"screw_{SCREW}x{d.panel.screw_mm:g}", "base"))
        stated.append(ExpectedPart("panel", "boot_collar", 1, "boot_collar", "platform"))
    return stated


def _mounting(d: Dimensions) -> list[ExpectedSupply]:
    screws = len(mount_places(d)) if d.design.hardware.mounting in ("screws", "both") else 0
    found = [ExpectedSupply("mount_screw", screws, "ISO 4762 M*")] if screws else []
    return [*found, ExpectedSupply("boot_tie", 1, "cable tie *")] if d.panel is not None else found
