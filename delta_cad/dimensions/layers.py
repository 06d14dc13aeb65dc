"""Stack of the parts along the shoulder axis."""

from __future__ import annotations

from dataclasses import dataclass

from delta_cad import catalogue
from delta_cad.dimensions.rules import ARM_THICKNESS, PRESS_DEPTH_MM, RUNNING_GAP_MM, another, larger, require
from delta_cad.dimensions.sizes import plate_mm

ELBOW_BOSS_WIDTH_MM, ELBOW_BOSS_BESIDE_MM = 16.0, 1.0  # grips the cross-bar over 2.7 diameters; over the arm's plate
STUB_DEPTH_MM = 3.0  # the magnet stub of a direct drive in the arm; the motor's shaft has the rest of the bore
SHAFT_ENDS_GAP_MM = 0.5
PILOT_OFF_MM = 0.5  # from the pinion's end to the motor's pilot
MOTOR_THREAD_DIAMETERS = 1.3  # usable thread behind a motor's face, in thread diameters; check the datasheet
BOARD_STAND_OFF_MM = 5.0  # stock length of the spacers under the encoder board
RECESS_MM = 0.5  # of the encoder's bearing in its cheek, at least: the sector's dowels turn before it
BLOCK_MM = 10.0  # of a foot block, least: a dowel's diameter from either side, and a wall of 4 mm between them
SPAN_MM = 30.0  # of the shoulder's bearings: below, it is the softest of what holds an arm sideways


def motor_thread_mm(motor: catalogue.Motor) -> float:
    """Gives the usable depth of the mounting threads behind a motor's face, mm."""
    return MOTOR_THREAD_DIAMETERS * catalogue.screw(motor.mount_thread).diameter_mm


@dataclass(frozen=True)
class Layers:
    """Extents along the shoulder axis (t of the chain, y of the arm), each (lower, upper), mm.

    `encoder_head_mm` is the encoder cheek's head beside its leg, which holds the bearing as far out as the span asks;
    of a direct drive it is the leg itself, and there are no bearings.
    """

    arm_mm: tuple[float, float]
    sector_mm: tuple[float, float]
    elbow_boss_mm: tuple[float, float]
    encoder_cheek_mm: tuple[float, float]
    encoder_head_mm: tuple[float, float]
    bearings_mm: tuple[tuple[float, float], ...]
    motor_cheek_mm: tuple[float, float]
    encoder_board_mm: tuple[float, float]


def layers(
    arm_thickness_mm: float,
    rim_mm: tuple[float, float] | None,
    pinion_end_mm: float,
    bearing: catalogue.Bearing,
    preload_mm: float,
    encoder: catalogue.Encoder,
    motor: catalogue.Motor,
    grown: float = 1.0,
) -> Layers:
    """Stacks a chain from the encoder (negative side) to the motor (positive side).

    The arm's plate is centred on the chain's plane, because the two rods pull on it symmetrically. A capstan's sector
    lies on its motor side; a direct drive has none, so that the motor comes closer: just so far that its shaft ends in
    front of the stub that carries the magnet.

    Args:
        arm_thickness_mm: Thickness of the arm's plate.
        rim_mm: Both sides of a capstan's rim; None for a direct drive.
        pinion_end_mm: End of the pinion, which turns in the bore of the motor's pilot and ends before the pilot.
        bearing: Row of the catalogue.
        preload_mm: Working height of the spring behind the encoder's bearing.
        encoder: Row of the catalogue, at the shoulder.
        motor: At the motor cheek.
        grown: Second moment of the cheeks over that of the least, see `sizes.growth`.

    Raises:
        DimensionError: The motor has no pilot; or a direct drive's arm clamps less of the motor's shaft than half its
            diameter, for its own thickness or the cheek's, or leaves too little between the cheeks.
    """
    require(
        motor.pilot_diameter_mm > 0.0,
        "motor_cheek",
        "pilot bore",
        f"hardware.motor = {motor.id}: pilot_diameter_mm = 0: must be > 0, for it centres the motor in its cheek: "
        "another motor, or a ring on its face, turned true to the shaft and stated as the pilot",
        *another("motor"),
    )
    half = arm_thickness_mm / 2
    cheek = plate_mm(bearing.width_mm + PRESS_DEPTH_MM, grown)
    sector = rim_mm or (half, half)
    encoder_inside = -half - RUNNING_GAP_MM
    motor_inside = sector[1] + RUNNING_GAP_MM
    fixing = catalogue.screw(motor.mount_thread)  # sunk; the shortest must not bottom in the motor
    plate = max(cheek, fixing.counterbore_depth_mm + min(fixing.lengths_mm) - motor_thread_mm(motor))
    motor_face = motor_inside + plate
    if rim_mm is not None:
        motor_face = max(motor_face, pinion_end_mm + PILOT_OFF_MM + motor.pilot_height_mm)
    else:
        motor_face = max(motor_face, STUB_DEPTH_MM + SHAFT_ENDS_GAP_MM - half + motor.shaft_length_mm)
        clamped = half - (motor_face - motor.shaft_length_mm)
        lacking = motor.shaft_diameter_mm / 2 + RUNNING_GAP_MM + plate - motor.shaft_length_mm
        require(
            lacking <= 0.0,
            "upper_arm",
            "shaft bore",
            f"a motor's shaft of {motor.shaft_length_mm:g} mm lacks {lacking:g} mm past a cheek of {plate:g} mm, which "
            "grows with the forces",
            *another("motor"),
        )
        least = arm_thickness_mm + motor.shaft_diameter_mm / 2 - clamped
        require(
            arm_thickness_mm >= least or lacking > 0.0,
            "upper_arm",
            "shaft bore",
            f"{clamped:g} mm of the motor's shaft are clamped; at least {motor.shaft_diameter_mm / 2:g}",
            larger(ARM_THICKNESS),
        )
        least = BLOCK_MM - 2 * RUNNING_GAP_MM
        require(
            arm_thickness_mm >= least,
            "foot_block",
            "thickness",
            f"{arm_thickness_mm + 2 * RUNNING_GAP_MM:g} mm between the cheeks are too little for dowels from either "
            f"side; at least {BLOCK_MM:g}",
            larger(ARM_THICKNESS),
        )
    bearings: tuple[tuple[float, float], ...] = ()
    head = encoder_inside - cheek
    if rim_mm is not None:
        middle = min(encoder_inside - RECESS_MM - bearing.width_mm / 2, motor_inside + bearing.width_mm / 2 - SPAN_MM)
        outer = middle - bearing.width_mm / 2
        bearings = (outer, outer + bearing.width_mm), (motor_inside, motor_inside + bearing.width_mm)
        head = min(head, outer - preload_mm - PRESS_DEPTH_MM)
    board = head - BOARD_STAND_OFF_MM
    boss = max(ELBOW_BOSS_WIDTH_MM / 2, half + ELBOW_BOSS_BESIDE_MM)
    return Layers(
        arm_mm=(-half, half),
        sector_mm=sector,
        elbow_boss_mm=(-boss, boss),
        encoder_cheek_mm=(encoder_inside - cheek, encoder_inside),
        encoder_head_mm=(head, encoder_inside - cheek),
        bearings_mm=bearings,
        motor_cheek_mm=(motor_inside, motor_face),
        encoder_board_mm=(board - encoder.board_thickness_mm, board),
    )
