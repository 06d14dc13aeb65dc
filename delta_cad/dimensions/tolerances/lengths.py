"""Chains of the mechanism's own lengths: by how much a made chain differs from the drawn one, README (43)."""

from __future__ import annotations

from dataclasses import replace
from math import degrees, inf, sqrt

from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.forearm import BALL_GLUE_MM, BAR_GLUE_MM, TILT_MARGIN_RAD
from delta_cad.dimensions.joint import CLEARANCE_TOLERANCE_MM
from delta_cad.dimensions.tolerances import (
    BAR_WIDER_UM,
    DOWEL_PLAY_MM,
    EROSION_UM,
    LENGTH_MM,
    PLACE_MM,
    SEATS_MM,
    WIDTH_MM,
    deviations_um,
)
from delta_cad.dimensions.tolerances.chain import Chain, Link, either_way
from delta_cad.dimensions.tolerances.general import flat_mm
from delta_cad.dimensions.tolerances.shoulder import RING_UM

JIG_MM = 0.02  # distance of the pins of the jig that a rod is bonded in, either way: reamed in one clamping
CENTRED_MM = 0.05  # a cross-bar in its boss, along it, set by a gauge block between ball and boss, either way
WHY = "beyond, what is proved of the cube is not of every machine that is made"


def length_chains(d: Dimensions, general: str) -> list[Chain]:
    """Lists by how much each length and offset of a chain is off the drawn one, without bounds of their own.

    Args:
        d: Dimensions of the machine.
        general: Class of the general tolerances, of ISO 2768-1.
    """
    m = d.design.mechanism
    flat = either_way("base_plate", "flat under the feet", "general", flat_mm(2 * d.base.radius_mm, general) / 2.0)
    chains = {
        "base radius": (m.base_radius_mm, _shoulder(d)),
        "shoulder's height": (0.0, [*_shoulder(d), flat]),
        "shoulder along its axis": (0.0, _along(d)),
        "upper arm": (m.upper_arm_length_mm, _arm(d)),
        "forearm": (m.forearm_length_mm, _rod()),
        "platform radius": (m.platform_radius_mm, _wrist(d)),
        "wrist's height": (0.0, _wrist(d)),
        "wrist along its axis": (0.0, _beside(d)),
    }
    return [Chain(name, "mm", nominal, tuple(links), -inf, inf, WHY) for name, (nominal, links) in chains.items()]


def twist_chain(d: Dimensions) -> Chain:
    """By how much the rods of a pair, not equally long, turn the platform, deg."""
    per_mm = degrees(1.0 / d.forearm.width_mm)
    links = tuple(
        replace(link, what=f"{link.what}, rod {k}", share=sign * per_mm)
        for k, sign in ((1, 1.0), (2, -1.0))
        for link in _rod()
    )
    limit = degrees(TILT_MARGIN_RAD)
    why = "beyond, ball joints turn further than they are made for"
    return Chain("platform's twist", "deg", 0.0, links, -limit, limit, why)


def deviation_mm(chain: Chain) -> float:
    """Computes the largest deviation of a chain's length from its nominal value, either way, mm."""
    low, high = chain.worst
    return max(high - chain.nominal, chain.nominal - low)


def largest_deviation_mm(d: Dimensions, general: str) -> float:
    """Computes the largest deviation of any length of the mechanism, mm: the d of README (43)."""
    return max(map(deviation_mm, length_chains(d, general)))


def _shoulder(d: Dimensions) -> list[Link]:
    """From the base plate to the shoulder's axis, across it."""
    place = PLACE_MM / 2.0
    links = [
        either_way("base_plate", "place of a dowel", "place", place),
        either_way("foot_block", "dowels in the plate", "fit", DOWEL_PLAY_MM),
        either_way("foot_block", "cross dowels from the upright ones", "place", place),
    ]
    if d.capstan is None:
        pilot = (deviations_um("H7", d.motor.pilot_diameter_mm)[1] + 18.0) / 2000.0
        links += [
            either_way("motor_cheek", "dowels in the block", "fit", DOWEL_PLAY_MM),
            either_way("motor_cheek", "pilot from its dowels", "place", place),
            either_way("motor", "pilot in its cheek", "fit", pilot),
        ]
        return links
    seat = (SEATS_MM[0] + RING_UM / 1000.0) / 2.0
    return [
        *links,
        either_way("motor_cheek", "dowels in the block", "fit", DOWEL_PLAY_MM),
        either_way("motor_cheek", "seat from its dowels", "place", place),
        either_way("bearing", "in its seat", "fit", seat),
        either_way("shoulder_shaft", "in its bearing", "fit", -deviations_um("h6", d.shaft.diameter_mm)[0] / 2000.0),
    ]


def _along(d: Dimensions) -> list[Link]:
    """From the base plate to the arm's middle, along the shoulder's axis."""
    links = [
        either_way("base_plate", "place of a dowel", "place", PLACE_MM / 2.0),
        either_way("foot_block", "dowels in the plate", "fit", DOWEL_PLAY_MM),
        either_way("foot_block", "dowels from its middle", "place", PLACE_MM / 2.0),
        either_way("foot_block", "width", "stated", LENGTH_MM, 0.5),
    ]
    if d.capstan is None:
        return [*links, either_way("upper_arm", "clamped by a gauge", "set", 0.1)]
    return [
        *links,
        either_way("motor_cheek", "depth of the seat", "stated", LENGTH_MM),
        Link("bearing", "width, motor's side", "bought", -WIDTH_MM, 0.0, -1.0),
        either_way("sector", "from the arm to its collar", "stated", LENGTH_MM, -1.0),
    ]


def _bar_mm(d: Dimensions) -> float:
    """Radial play of a bonded cross-bar, mm: it hardens anywhere in its bore."""
    bar = -deviations_um("h6", d.forearm.bar_diameter_mm)[0]
    return BAR_GLUE_MM + (BAR_WIDER_UM + bar) / 2000.0


def _arm(d: Dimensions) -> list[Link]:
    bore, shaft = deviations_um("H7", d.arm.shaft_bore_mm)[1], -deviations_um("h6", d.arm.shaft_bore_mm)[0]
    return [
        either_way("upper_arm", "bar's bore from the shaft's", "place", PLACE_MM / 2.0),
        either_way("upper_arm", "on its shaft", "fit", (bore + shaft) / 2000.0),
        either_way("cross_bar", "in its bond", "set", _bar_mm(d)),
    ]


def _rod() -> list[Link]:
    return [
        either_way("rod_tube", "bonded in a jig", "set", JIG_MM),
        either_way("cup_shell", "both seats", "stated", 2 * CLEARANCE_TOLERANCE_MM),
    ]


def _wrist(d: Dimensions) -> list[Link]:
    return [
        either_way("platform", "place of a bar's bore", "place", PLACE_MM / 2.0),
        either_way("cross_bar", "in its bond", "set", _bar_mm(d)),
    ]


def _beside(d: Dimensions) -> list[Link]:
    """A wrist along its axis, middle of a pair."""
    hole = d.forearm.pin_diameter_mm / 2 + BALL_GLUE_MM
    rim = hole / sqrt((d.forearm.ball_diameter_mm / 2) ** 2 - hole**2) * EROSION_UM / 2000.0
    return [
        either_way("cross_bar", "set in its boss by a gauge", "set", CENTRED_MM),
        either_way("cross_bar", "distance of its shoulders", "stated", LENGTH_MM, 0.5),
        either_way("joint_ball", "rim of its hole, one end", "bought", rim, 0.5),
        either_way("joint_ball", "rim of its hole, other end", "bought", rim, 0.5),
    ]
