"""Chains of a shoulder: its wave spring, the encoder's gap and centring, the tilt of the shaft in its bearings."""

from __future__ import annotations

from math import hypot

from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.arm import MAGNET_GLUE_MM
from delta_cad.dimensions.layers import BOARD_STAND_OFF_MM, SPAN_MM
from delta_cad.dimensions.tolerances import (
    COAXIAL_MM,
    DOWEL_PLAY_MM,
    LENGTH_MM,
    MAGNET_WIDER_UM,
    MANDREL_MM,
    SEATS_MM,
    TILT_RAD,
    WIDTH_MM,
    deviations_um,
    minutes,
    working_mm,
)
from delta_cad.dimensions.tolerances.chain import Chain, Link, either_way
from delta_cad.dimensions.tolerances.general import general_mm

CHIP_MM = 0.25  # height of a chip on its board, either way: 0.85 to 1.2 of a TSSOP-16 (MT6835 data sheet, 13)
MAGNET_MM = 0.1  # thickness of a sintered magnet, either way, as makers state
CHIP_PLACE_MM = 0.1  # a chip's sensor from its board's holes, either way: 0.05 in its package (the same), 0.05 of it
FEELER_MM = 0.1  # what is set with a gauge, either way
RING_UM = 8.0  # by which a bearing's bore or outside may be smaller than nominal, ISO 492 normal class up to 18 mm
MINUTES_PER_RAD = minutes(1.0)


def shoulder_chains(d: Dimensions, general: str) -> list[Chain]:
    """Lists the chains of one shoulder.

    Args:
        d: Dimensions of the machine.
        general: Class of the general tolerances, of ISO 2768-1.
    """
    found = [*spring_chain(d), *tilt_chain(d)]
    return found + ([gap_chain(d, general), *centring_chain(d, general)] if d.sensed_at_shoulder else [])


def _stack(d: Dimensions) -> list[Link]:
    """Lengths between both bearings' seats, as they add to what is left behind the encoder's bearing."""
    (_, out), (seat, _) = d.layers.bearings_mm[0], d.layers.bearings_mm[1]
    motor, encoder = d.layers.motor_cheek_mm[0], d.layers.encoder_cheek_mm[1]
    arm = d.layers.arm_mm[1]
    width = d.layers.bearings_mm[1][1] - motor
    return [
        either_way("motor_cheek", "depth of the seat", "stated", LENGTH_MM, 1.0, width),
        either_way("foot_block", "width", "stated", LENGTH_MM, 1.0, motor - encoder),
        either_way("sector", "from the arm to its collar", "stated", LENGTH_MM, -1.0, seat - arm),
        either_way("upper_arm", "from its collar to the sector", "stated", LENGTH_MM, -1.0, arm - out),
        Link("bearing", "width, motor's side", "bought", -WIDTH_MM, 0.0, -1.0),
        Link("bearing", "width, encoder's side", "bought", -WIDTH_MM, 0.0, -1.0),
    ]


def spring_chain(d: Dimensions) -> list[Chain]:
    """The height left to a shoulder's wave spring; none without bearings."""
    if d.preload is None:
        return []
    floor = d.layers.bearings_mm[0][0] - d.preload.work_height_mm
    deep = either_way(
        "encoder_cheek", "depth of the seat", "stated", LENGTH_MM, 1.0, d.layers.encoder_cheek_mm[1] - floor
    )
    low, high = working_mm(d.preload)
    why = "below, the wave spring is pressed flat and the bearings bind; above, it no longer presses"
    return [Chain("wave spring's height", "mm", d.preload.work_height_mm, (*_stack(d), deep), low, high, why)]


def tilt_chain(d: Dimensions) -> list[Chain]:
    """How far the shaft tilts in its bearings, minutes of arc; none without bearings."""
    if d.preload is None:
        return []
    b = d.bracket
    apart = b.cheek_dowel_u_mm[1] - b.cheek_dowel_u_mm[0]
    per_mm = MINUTES_PER_RAD / SPAN_MM
    names = ("motor_cheek", "encoder_cheek")
    links = [
        either_way(part, "mandrel in its seat", "fit", (wide + MANDREL_MM) / 2.0, per_mm)
        for part, wide in zip(names, SEATS_MM, strict=True)
    ]
    for part in names:
        links += [
            either_way(part, "dowels lift it", "fit", DOWEL_PLAY_MM, per_mm),
            either_way(part, "dowels turn it", "fit", DOWEL_PLAY_MM, per_mm * 2 * -b.cheek_screw_z_mm / apart),
        ]
    limit = minutes(TILT_RAD)
    why = "beyond, the bearings' races run askew: take the bearings out and set a cheek by the mandrel again"
    return [Chain("shaft's tilt", "arcmin", 0.0, tuple(links), -limit, limit, why, statistical=True)]


def gap_chain(d: Dimensions, general: str) -> Chain:
    """The air gap between the encoder's chip and its magnet."""
    encoder = d.encoder
    board = [
        either_way("board_spacer", "length", "general", general_mm(BOARD_STAND_OFF_MM, general), 1.0),
        either_way("encoder_board", "height of its chip", "bought", CHIP_MM, -1.0),
        either_way("encoder_magnet", "thickness", "bought", MAGNET_MM, -1.0),
        either_way(
            "shoulder_shaft", "depth of the magnet's seat", "general", general_mm(d.shaft.magnet_depth_mm, general)
        ),
    ]
    nominal = d.shaft.y_mm[0] - d.layers.encoder_board_mm[1] - encoder.chip_height_mm
    if d.preload is None:
        links = [*board, either_way("upper_arm", "clamped by a gauge", "set", FEELER_MM)]
    else:
        head = d.layers.bearings_mm[0][0] - d.shaft.y_mm[0]
        thick = d.layers.encoder_cheek_mm[1] - d.layers.encoder_head_mm[0]
        links = [
            *_stack(d),
            either_way("shoulder_shaft", "length of its head", "general", general_mm(head, general), -1.0, head),
            either_way("encoder_cheek", "thickness of its head", "general", general_mm(thick, general), 1.0, thick),
            *board,
        ]
    why = f"beyond, {encoder.id} reads badly; a shim under its board, or a spacer ground down, mends it"
    low, high = encoder.air_gap_min_mm, encoder.air_gap_max_mm
    return Chain("encoder's air gap", "mm", nominal, tuple(links), low, high, why, statistical=True)


def centring_chain(d: Dimensions, general: str) -> list[Chain]:
    """How far the magnet's axis is off the chip's, in the direction in which it is most; none where it is not known."""
    e = d.encoder
    if e.centring_mm is None:
        return []
    far = hypot(e.hole_spacing_length_mm, e.hole_spacing_width_mm) / 2.0
    loose = (e.hole_diameter_mm - 2.5) / 2.0  # of its M2.5 screws
    links = [
        either_way("encoder_cheek", "place of the board's threads", "general", general_mm(far, general), 1.0, far),
        either_way("encoder_board", "its screws in its holes", "bought", loose),
        either_way("encoder_board", "place of the chip", "bought", CHIP_PLACE_MM),
        either_way("encoder_magnet", "in its seat's bond", "set", MAGNET_GLUE_MM + MAGNET_WIDER_UM / 2000.0),
        either_way("shoulder_shaft", "magnet's seat off its journal", "place", COAXIAL_MM / 2.0),
    ]
    if d.preload is not None:
        wide = (SEATS_MM[1] + RING_UM / 1000.0) / 2.0
        links.append(either_way("bearing", "in its seat", "fit", wide))
        shaft = -deviations_um("h6", d.shaft.diameter_mm)[0] / 2000.0
        links.append(either_way("shoulder_shaft", "in its bearing", "fit", shaft))
    why = f"beyond, {e.id} reads an angle that is off by more than its maker states, which calibration takes out"
    most = e.centring_mm
    return [Chain("encoder's centring", "mm", 0.0, tuple(links), -most, most, why, statistical=True)]
