"""Stack of the parts along the shoulder axis; hexagon keys, and how the screws lie that they turn."""

from __future__ import annotations

from dataclasses import dataclass
from math import degrees, inf, isfinite, pi, radians, tau

import numpy as np

from delta_cad import catalogue
from delta_cad.dimensions.rules import (
    ARM_THICKNESS,
    PRESS_DEPTH_MM,
    RATIO,
    RUNNING_GAP_MM,
    another,
    larger,
    require,
    tenths_above,
)
from delta_cad.dimensions.sizes import plate_mm

_ELBOW_BOSS_WIDTH_MM, _ELBOW_BOSS_OVERHANG_MM = (
    16.0,
    1.0,
)  # grips the cross-bar over 2.7 diameters; over the arm's plate
STUB_DEPTH_MM = 3.0  # the magnet stub of a direct drive in the arm; the motor's shaft has the rest of the bore
_SHAFT_ENDS_GAP_MM = 0.5
_UNDER_HEAD_MM = 1.5  # least metal of a motor's cheek under its screws' heads
_POCKET_LEAST_MM = 0.3  # depth of a pocket that is worth its milling
MOTOR_PLAY_MM = 0.25  # radius by which a motor's pocket is wider than the motor, which its pilot centres
_PILOT_OFF_MM = 0.5  # from the pinion's end to the motor's pilot
_MOTOR_THREAD_DIAMETERS = 1.3  # usable thread behind a motor's face, in thread diameters; check the datasheet
BOARD_STAND_OFF_MM = 5.0  # stock length of the spacers under the encoder board
BOARD_SPACER_WALLS_MM = 2.2  # of these, both together, at most: beside them lie the board's traces
_RECESS_MM = 0.5  # of the encoder's bearing in its cheek, at least: the sector's dowels turn before it
_BLOCK_MM = 10.0  # of a foot block, least: a dowel's diameter from either side, and a wall of 4 mm between them
SPAN_MM = 30.0  # of the shoulder's bearings: below, it is the softest of what holds an arm sideways


def motor_thread_mm(motor: catalogue.Motor) -> float:
    """Gives the usable depth of the mounting threads behind a motor's face, mm."""
    return _MOTOR_THREAD_DIAMETERS * motor.mount_screw.diameter_mm


@dataclass(frozen=True)
class Layers:
    """Extents along the shoulder axis (t of the chain, y of the arm), each (lower, upper), mm.

    `encoder_head_mm` is the encoder cheek's head beside its leg, which holds the bearing as far out as the span asks;
    of a direct drive it is the leg itself, and there are no bearings. `motor_pocket_mm` is the depth of the motor's
    pocket in the outer face of its cheek, 0 where there is none. Heads of its screws that are drawn out must end
    before `turns_end_mm`, the end of the turns on the pinion; -inf where they pass beside them.
    """

    arm_mm: tuple[float, float]
    sector_mm: tuple[float, float]
    elbow_boss_mm: tuple[float, float]
    encoder_cheek_mm: tuple[float, float]
    encoder_head_mm: tuple[float, float]
    bearings_mm: tuple[tuple[float, float], ...]
    motor_cheek_mm: tuple[float, float]
    motor_pocket_mm: float
    encoder_board_mm: tuple[float, float]
    turns_end_mm: float = -inf

    @property
    def motor_face_mm(self) -> float:
        """Where the motor's mounting face stands: on the floor of its pocket in the cheek, or on the cheek itself."""
        return self.motor_cheek_mm[1] - self.motor_pocket_mm


def layers(
    *,
    arm_thickness_mm: float,
    rim_mm: tuple[float, float] | None,
    pinion_end_mm: float,
    turns_end_mm: float = -inf,
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
        pinion_end_mm: End of the pinion, which ends before the motor's pilot.
        turns_end_mm: Where the cable's turns on the pinion end that heads of the motor's screws must not reach as they
            are drawn out; -inf where they pass beside them.
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
    fixing = motor.mount_screw  # sunk; the shortest must not bottom in the motor
    under_head = max(min(fixing.lengths_mm) - motor_thread_mm(motor), _UNDER_HEAD_MM)
    plate = max(cheek, fixing.counterbore_depth_mm + under_head)
    motor_face, pocket = motor_inside + plate, 0.0
    if rim_mm is not None:
        web = plate_mm(fixing.counterbore_depth_mm + under_head, grown)
        floor = motor_inside + web
        if isfinite(turns_end_mm):  # the shortest screws' heads, drawn out
            floor = max(floor, tenths_above(turns_end_mm + fixing.head_height_mm + min(fixing.lengths_mm)))
        floor = max(floor, pinion_end_mm + _PILOT_OFF_MM + motor.pilot_height_mm)
        pocket = motor_face - floor if motor_face - floor >= _POCKET_LEAST_MM else 0.0
        motor_face = max(motor_face, floor)
    else:
        motor_face = max(motor_face, STUB_DEPTH_MM + _SHAFT_ENDS_GAP_MM - half + motor.shaft_length_mm)
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
        least = _BLOCK_MM - 2 * RUNNING_GAP_MM
        require(
            arm_thickness_mm >= least,
            "foot_block",
            "thickness",
            f"{arm_thickness_mm + 2 * RUNNING_GAP_MM:g} mm between the cheeks are too little for dowels from either "
            f"side; at least {_BLOCK_MM:g}",
            larger(ARM_THICKNESS),
        )
    bearings: tuple[tuple[float, float], ...] = ()
    head = encoder_inside - cheek
    if rim_mm is not None:
        middle = min(encoder_inside - _RECESS_MM - bearing.width_mm / 2, motor_inside + bearing.width_mm / 2 - SPAN_MM)
        outer = middle - bearing.width_mm / 2
        bearings = (outer, outer + bearing.width_mm), (motor_inside, motor_inside + bearing.width_mm)
        head = min(head, outer - preload_mm - PRESS_DEPTH_MM)
    board = head - BOARD_STAND_OFF_MM
    boss = max(_ELBOW_BOSS_WIDTH_MM / 2, half + _ELBOW_BOSS_OVERHANG_MM)
    return Layers(
        arm_mm=(-half, half),
        sector_mm=sector,
        elbow_boss_mm=(-boss, boss),
        encoder_cheek_mm=(encoder_inside - cheek, encoder_inside),
        encoder_head_mm=(head, encoder_inside - cheek),
        bearings_mm=bearings,
        motor_cheek_mm=(motor_inside, motor_face),
        motor_pocket_mm=pocket,
        encoder_board_mm=(board - encoder.board_thickness_mm, board),
        turns_end_mm=turns_end_mm,
    )


KEYS_MM = {  # width across flats: long and short leg
    0.9: (33.0, 11.0),
    1.3: (41.0, 13.0),
    1.5: (46.5, 15.5),
    2.0: (52.0, 18.0),
    2.5: (58.5, 20.5),
    3.0: (66.0, 23.0),
    4.0: (74.0, 29.0),
    5.0: (85.0, 33.0),
    6.0: (96.0, 38.0),
}
"""Hexagon keys, standard type, mm. Source: ISO 2936, as JIS B 4648:2008 gives it (mikipulley.co.jp, tech13); likewise
FsData/iso2936def.csv of github: shaise/FreeCAD_FastenersWB."""
LONG_MM = {1.3: 81.0, 1.5: 91.5, 2.0: 102.0, 2.5: 114.5, 3.0: 129.0, 4.0: 144.0, 5.0: 165.0, 6.0: 186.0}
"""Long leg of the long type (L) by width across flats, mm; its short leg is as above. Source: the same table."""
CORNERS = 1.13  # largest width across corners by that across flats: 1.68 / 1.5, 2.82 / 2.5 in the same table
CUT, _HANDLE_CUT, _LARGER_HANDLE_CUT = 5 / 6, 0.5, 0.6
"""Shares of its short leg and of its long one, the handle, to which a key is cut that must turn between the two cheeks
of a chain, past the end of the motor's shaft, and beside its neighbours' motors: a whole handle met these where the
base would have done otherwise. What is left of it takes 50 N or less for what the screws of any motor of the catalogue
are tightened to; M4 among them, whose key is of `_LARGER_MM`, asks for the larger share."""
_LARGER_MM = 2.5
_OFF_CHEEK_MM = 0.2  # of that key's handle from the encoder's cheek
_SWUNG = 0.8  # share of a handle by which it reaches down while it swings by a sixth of a turn, somewhere in its circle
SWING_RAD = pi / 3  # of a handle, to a hexagon's next corner
SET_SCREWS_RAD = (0.0, pi / 2)  # directions of a pinion's set screws from one another
_ASKEW_RAD = radians(1.0)  # by which a key stands askew in its slot: half of what 3 mm leave a key of 1.7


def key_legs_mm(flats_mm: float) -> tuple[tuple[float, float], ...]:
    """Lists the ways to use a key: the leg in the socket and the handle, either way round, cut, and of the long type.

    Args:
        flats_mm: Width across flats, one of `KEYS_MM`.
    """
    long, short = KEYS_MM[flats_mm]
    return (short, long), (long, short), cut_key_mm(flats_mm), (LONG_MM.get(flats_mm, long), short)


def longest_run(free: np.ndarray) -> int:
    """Counts the directions of the longest run that is free, of (n,) bool round a circle."""
    if free.all():
        return len(free)
    longest = run = 0
    for one in np.roll(free, -int(free.argmin())):
        run = run + 1 if one else 0
        longest = max(longest, run)
    return longest


def cut_key_mm(flats_mm: float) -> tuple[float, float]:
    """Gives what is left of both legs of the key that turns a motor's screws: the one in the socket, and its handle.

    Args:
        flats_mm: Width across flats, one of `KEYS_MM`.
    """
    long, short = KEYS_MM[flats_mm]
    return CUT * short, (_HANDLE_CUT if flats_mm < _LARGER_MM else _LARGER_HANDLE_CUT) * long


def motor_screw_mm(motor: catalogue.Motor, layers: Layers) -> tuple[float, float]:
    """Chooses the length of the motor's screws, and how deep their heads are sunk so that they fill their threads.

    A web is left under the heads, even if the shortest screws then fill a little less of their threads. The longest
    whose head is buried and stands so far outside that a cut key's handle, just drawn off it, passes the
    encoder's cheek, and whose head does not meet the turns on the pinion as it is drawn out; else the longest that is
    buried.

    Returns:
        Length and depth, mm.
    """
    row, thread = motor.mount_screw, motor_thread_mm(motor)
    inside, face = layers.motor_cheek_mm[0], layers.motor_face_mm
    buried = [mm for mm in row.lengths_mm if mm <= face - inside - row.counterbore_depth_mm + thread + 1e-9]
    flats = row.socket_mm
    key = cut_key_mm(flats)[0] + CORNERS * flats / 2 + _OFF_CHEEK_MM if flats in KEYS_MM else 0

    def sunk(length: float) -> float:
        return min(face - inside + thread - length, face - inside - _UNDER_HEAD_MM)

    def turned(length: float) -> bool:
        head = inside + sunk(length) - row.head_height_mm
        drawn_out = head - (length - (face - inside - sunk(length)))
        return head - key >= layers.encoder_cheek_mm[1] and drawn_out >= layers.turns_end_mm - 1e-9

    length = max([mm for mm in buried if turned(mm)] or buried)
    return length, sunk(length)


def handle_room_mm(motor: catalogue.Motor) -> float:
    """Gives how far below a motor's axis the base must lie for a key to swing in the motor's screws, mm."""
    return _SWUNG * KEYS_MM.get(motor.mount_screw.socket_mm, (0.0, 0.0))[0]


def set_screws_rad(key_rad: float, turns_rad: tuple[float, float]) -> tuple[float, float]:
    """Chooses the directions of a pinion's set screws, so that each comes to face its key at some angle.

    They point along x and z of the pinion where both come there; else they come there on either side of the middle of
    the pinion's range, that of an arm while the handle goes up and down in the middle.

    Args:
        key_rad: Direction from the motor's axis in the chain's plane from which their key comes.
        turns_rad: From where to where the pinion turns from the exported position, against the arm.

    Returns:
        Directions in the pinion's frame, from x towards z.

    Raises:
        DimensionError: The pinion turns too little for both.
    """
    low, high = turns_rad
    apart = SET_SCREWS_RAD[1] - SET_SCREWS_RAD[0]
    least = apart - 2 * _ASKEW_RAD
    require(
        high - low >= least,
        "pinion",
        "set screws",
        f"while the handle goes up and down in the middle the pinion turns by {degrees(high - low):.0f} deg; its two "
        f"set screws come to face their key within {degrees(least):.0f}",
        larger(RATIO),
    )

    def comes(screw: float) -> bool:
        return low + (key_rad - screw - low) % tau <= high

    if all(map(comes, SET_SCREWS_RAD)):
        return SET_SCREWS_RAD
    middle = key_rad - (low + high) / 2
    return middle - apart / 2, middle + apart / 2
