"""The two cheeks of a chain, the foot block between them, the stop pins and the motor's seat (chain's frame).

And what runs or stands beside a motor, in closed form: the next chain's encoder board, the own arm's end.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations, pairwise
from math import acos, asin, atan2, cos, degrees, hypot, inf, pi, remainder, sin, sqrt, tau

import numpy as np

from delta_cad import catalogue
from delta_cad.design.stands import EVEN, Gap, other_stands
from delta_cad.dimensions.arm import ArmDimensions
from delta_cad.dimensions.capstan import CapstanDimensions
from delta_cad.dimensions.layers import Layers, handle_room_mm
from delta_cad.dimensions.rules import (
    ARM,
    BOTTOM,
    FARTHER_OUT,
    RUNNING_GAP_MM,
    STOP_MARGIN_RAD,
    another,
    larger,
    require,
    tenths_below,
)

STOP_PIN_MM = 4.0
_FOOT_HEIGHT_MM = 14.0
_HEAD_WALL_MM = 5.0  # around the bearing seat
_PAD_MARGIN_MM = 2.0  # cheek beyond the motor's body
_CLEAR_MM = 2.0  # between parts that nothing brings closer
MESHES_MM = (
    0.13  # beyond the clearance: what is proved is proved of meshes, which are up to 0.065 mm off on either side
)
_FOOT_MM = (-17.0, 25.0)  # inner and outer end of the foot from the shoulder, where the arm leaves it room
_LEG_ASIDE_MM = 4.0  # by which a capstan's encoder leg begins further out than its head: the neighbour's motor is there
_FOOT_EDGE_MM = 4.5  # of a foot's dowels: as far apart as a wall of a diameter leaves them
_FOOT_SCREWS_MM = 12.0, 16.5  # of a foot's screws to the cheeks, and to the base, from either of its ends
_PRINTED_FOOT_MM = 4.3, 9.45, 16.38
"""The same of a printed foot or plate, its dowels first: around inserts M3 and M4 is the plastic that their maker asks
(4.0 and 5.6 mm of hole, 1.6 and 2.1 of wall), and 1.2 mm are left between counterbores of 8."""
_FOOT_INSIDE_MM = 12.0  # least distance of its inner end from the base's centre: room for the neighbours' and a hole
PLATE_RIM_MM = 4.0  # base plate beyond the feet
HEIGHTS = 33  # of a motor at which the room beside it is looked at
_ROUND = np.array([(cos(pi * k / (HEIGHTS - 1)), sin(pi * k / (HEIGHTS - 1))) for k in range(HEIGHTS)]).T[..., None]
HALVINGS = 50  # of the range in which the base lies: to rounding
_ROUNDING_MM = 1e-9
KEY_SLOT_MM, _KEY_SLOT_WALL_MM = 3.0, 1.0  # for the key of the pinion's set screws; to the motor screws' counterbores
_EYE_WALL_MM = 2.0  # around a stop pin that is pressed in
_PIN_WALL_MM = 1.0  # between a stop pin and the counterbore of a motor's screw
_FOOT_CORNER_MM = 3.0
FOOT_OFF_MM = 0.5  # of a cheek from the plate, on which its block alone stands
CHEEK_EDGE_MM = 0.5  # by which edges of cheeks and of the foot block on top are broken
BLOCK_SCREW = "M3"  # of a cheek in its foot block
_LEAST_MOTOR_SCREWS = 3  # that hold a motor wherever one of its holes is left empty

Circle = tuple[float, float, float]
"""(x, z, radius) in the shoulder's frame, mm."""


@dataclass(frozen=True)
class BracketDimensions:
    """Positions in the chain's (u, z) plane from the base centre, heights from the shoulder plane, mm."""

    shoulder_u_mm: float
    head_radius_mm: float
    passage_mm: float
    motor_axis_mm: tuple[float, float]
    motor_pad_radius_mm: float
    motor_holes_rad: tuple[float, ...]
    motor_screws_rad: tuple[float, ...]
    foot_u_mm: tuple[float, float]
    foot_height_mm: float
    base_top_mm: float
    cheek_screw_u_mm: tuple[float, float]
    cheek_dowel_u_mm: tuple[float, float]
    cheek_screw_z_mm: float
    base_screw_u_mm: tuple[float, float]
    base_dowel_u_mm: tuple[float, float]
    stop_pin_mm: float
    stop_pins_mm: tuple[tuple[float, float], ...]

    @property
    def foot_circles_mm(self) -> list[Circle]:
        """Circles of a cheek's foot, round above, off the plate."""
        low, high = (u - self.shoulder_u_mm for u in self.foot_u_mm)
        top = self.base_top_mm + self.foot_height_mm - _FOOT_CORNER_MM
        corners = (low + _FOOT_CORNER_MM, top, _FOOT_CORNER_MM), (high - _FOOT_CORNER_MM, top, _FOOT_CORNER_MM)
        bottom = self.base_top_mm + FOOT_OFF_MM
        return [(low, bottom, 0.0), (high, bottom, 0.0), *corners]

    @property
    def motor_cheek_circles_mm(self) -> list[Circle]:
        """Circles whose hull a motor's cheek is: head, pad, foot, and what is around its stop pins."""
        x, z = self.motor_axis_mm[0] - self.shoulder_u_mm, self.motor_axis_mm[1]
        eye = self.stop_pin_mm / 2 + _EYE_WALL_MM
        pins = [(u - self.shoulder_u_mm, height, eye) for u, height in self.stop_pins_mm]
        return [(0.0, 0.0, self.head_radius_mm), (x, z, self.motor_pad_radius_mm), *self.foot_circles_mm, *pins]

    @property
    def leg_circle_mm(self) -> tuple[float, float, float]:
        """(x, z, radius) in the shoulder's frame of the circle at which a capstan's encoder leg hangs on its head."""
        return _LEG_ASIDE_MM, 0.0, self.head_radius_mm - _LEG_ASIDE_MM


def beam_stop_angle_rad(arm: ArmDimensions, pin_mm: float, distance_mm: float) -> float:
    """Computes the angle from the arm's axis at which a pin at a distance from the shoulder touches the beam's edge.

    The edge is the common tangent of the root circle and the boss circle; its normal leans acos((r1 - r2) / L).
    """
    normal = acos((arm.beam_root_radius_mm - arm.boss_radius_mm) / arm.length_mm)
    return normal - acos((arm.beam_root_radius_mm + pin_mm / 2) / distance_mm)


def _foot_outer_end_mm(arm: ArmDimensions, stop_rad: float, top_mm: float, clear_mm: float) -> float:
    """Gives how far a foot may reach out from the shoulder below an arm at its lower stop, mm; inf above its edge.

    The foot's upper outer corner, at `top_mm` over the shoulder plane (negative), keeps clear of the beam's lower edge,
    the tangent of root circle and boss circle, at the shoulder angle `stop_rad`.
    """
    normal = stop_rad - acos((arm.beam_root_radius_mm - arm.boss_radius_mm) / arm.length_mm)
    away = arm.beam_root_radius_mm + clear_mm
    if not -pi < normal < -pi / 2:  # the edge does not lean over the foot
        return inf
    return (away - top_mm * sin(normal)) / cos(normal)


def _under_arm_mm(arm: ArmDimensions, stop_rad: float, end_mm: float, clear_mm: float) -> float:
    """Gives the height below the shoulder plane at which a foot that ends there keeps clear of the arm; else inf.

    The arm's lower edge is the tangent of root circle and boss circle; beyond it the boss itself is what is nearest.
    """
    normal = stop_rad - acos((arm.beam_root_radius_mm - arm.boss_radius_mm) / arm.length_mm)
    if not -pi < normal < -pi / 2 or end_mm <= 0.0:
        return inf
    edge = (arm.beam_root_radius_mm + clear_mm - end_mm * cos(normal)) / sin(normal)
    elbow = arm.length_mm * cos(stop_rad), arm.length_mm * sin(stop_rad)
    along = -sin(normal), cos(normal)  # of the edge, outwards
    if end_mm * along[0] + edge * along[1] <= elbow[0] * along[0] + elbow[1] * along[1]:
        return edge
    radius, aside = arm.boss_radius_mm + clear_mm, end_mm - elbow[0]
    return elbow[1] - sqrt(radius**2 - aside**2) if abs(aside) < radius else inf


def _next_to_mm(
    inner_mm: float,
    base_top_mm: float,
    axis_mm: tuple[float, float],
    radius_mm: float,
    leg_mm: float,
    gaps: Sequence[Gap],
) -> float:
    """Gives how far out a foot must begin for the encoder's leg above it to pass the neighbour's motor.

    The leg's inner edge runs from `inner_mm` at the shoulder's height to the foot's inner end; the motor that lies
    across it, of the chain before it, is round about `axis_mm`, (u, z) of its own chain. A chain less than 90 degrees
    farther on has its leg beside that motor, whose way out this foot does not decide.

    Args:
        inner_mm: Leg's inner edge at the shoulder's height, from the base's centre.
        base_top_mm: Height of the foot's underside, negative.
        axis_mm: The motors' axis in their chains' planes.
        radius_mm: Of the motors.
        leg_mm: How far the leg reaches aside.
        gaps: Of the chains.
    """
    across = [(gap.sine, gap.cosine, gap.out_mm, gap.next_out_mm) for gap in gaps if gap.cosine < 0.0]
    if not across:
        return -inf
    (sine, cosine, out, next_out), (up, wide) = np.array(across).T, radius_mm * _ROUND
    height = np.minimum(axis_mm[1] + up, -_CLEAR_MM)
    off = sine * leg_mm + _CLEAR_MM / 2 - axis_mm[0] + wide - out
    edge = off / -cosine - next_out
    return float((inner_mm + (edge - inner_mm) * base_top_mm / height).max())


def _leg_room_mm(arm: ArmDimensions, stop_rad: float, head_mm: float, foot_mm: float, base_top_mm: float) -> float:
    """Computes how far the elbow's boss at its lower stop stays off the outer edge of a capstan's encoder leg, mm.

    The edge is the tangent from the circle at which the leg hangs on its head to the upper outer corner of the foot.
    """
    radius, corner = head_mm - _LEG_ASIDE_MM, (foot_mm - _LEG_ASIDE_MM, base_top_mm + _FOOT_HEIGHT_MM)
    far = hypot(*corner)
    normal = atan2(corner[1], corner[0]) + acos(min(radius / far, 1.0))
    elbow = arm.length_mm * cos(stop_rad) - _LEG_ASIDE_MM, arm.length_mm * sin(stop_rad)
    return elbow[0] * cos(normal) + elbow[1] * sin(normal) - radius - arm.boss_radius_mm


def motor_pattern_rad(
    count: int, direction_rad: float | None, pins_rad: tuple[float, ...] = (), off_rad: float = 0.0
) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """Turns a motor's mounting holes so that a key reaches its screws past a sector, or that stop pins pass them.

    Of four holes or more one lies towards the shoulder, on the line of centres, where the sector's rim is in front of
    it at every angle of the arm: it gets no screw. Of three one lies away from the shoulder, of two both lie
    aside, and all get theirs. Without a sector they lie square to the chain, or else as far off the pins as they can.

    Args:
        count: Number of the motor's holes, equally spaced.
        direction_rad: From the shoulder to the motor's axis in the chain's plane; None where there is no sector.
        pins_rad: Angles about the motor's axis of stop pins, where there is no sector.
        off_rad: Least angle between one of them and a screw.

    Returns:
        Angles about the motor's axis of all holes, and of those that get a screw.
    """
    step = tau / count
    if direction_rad is None:
        first = pi / 2 + step / 2
        if any(abs(remainder(pin - first, step)) < off_rad for pin in pins_rad):
            ways = sorted((pin - first) % step for pin in pins_rad)
            gaps = [(after - way, way) for way, after in pairwise([*ways, ways[0] + step])]
            widest, way = max(gaps)
            first += way + widest / 2
        holes = tuple(first + step * k for k in range(count))
        return holes, holes
    hidden = count > _LEAST_MOTOR_SCREWS
    first = pi if hidden else pi / 2 if count == 2 else 0.0
    holes = tuple(direction_rad + first + step * k for k in range(count))
    return holes, holes[1:] if hidden else holes


def _pin_off_rad(pin_circle_mm: float, motor: catalogue.Motor) -> float:
    """Gives the least angle about the motor's axis between a stop pin and a screw in its counterbore; 0: any."""
    a, b = motor.mount_circle_mm / 2, pin_circle_mm
    apart = (STOP_PIN_MM + motor.mount_screw.counterbore_diameter_mm) / 2 + _PIN_WALL_MM
    share = (a**2 + b**2 - apart**2) / (2 * a * b)
    return acos(max(share, -1.0)) if share < 1.0 else 0.0


def key_slot_floor_mm(c: CapstanDimensions, inside_mm: float) -> float:
    """Computes the depth of the key's slot from a motor cheek's inner face, mm.

    Its floor passes the middle of the set screws, which stand in the pinion's collar, by half its width.
    """
    return sum(c.collar_y_mm) / 2 + KEY_SLOT_MM / 2 - inside_mm


def key_rad(c: CapstanDimensions, b: BracketDimensions, motor: catalogue.Motor) -> float:
    """Chooses from where the key of the set screws comes to the motor's axis, in the chain's plane: from outside.

    In a slot of the cheek it is as nearly so as the motor's screws leave it room.
    """
    if not c.collar_at_motor:
        return 0.0
    radius = motor.mount_circle_mm / 2
    aside = (KEY_SLOT_MM + motor.mount_screw.counterbore_diameter_mm) / 2 + _KEY_SLOT_WALL_MM
    off = asin(min(aside / radius, 1.0))
    ways = [0.0, *(angle + side * off for angle in b.motor_screws_rad for side in (-1.0, 1.0))]
    nearest = [min(abs(remainder(way - angle, tau)) for angle in b.motor_screws_rad) for way in ways]
    free = [remainder(way, tau) for way, near in zip(ways, nearest, strict=True) if near >= off - _ROUNDING_MM]
    require(
        bool(free),
        "motor_cheek",
        "slot of the key",
        f"between {len(b.motor_screws_rad)} screws on a circle of {motor.mount_circle_mm:g} mm no key reaches the "
        "pinion",
        *another("motor"),
    )
    return min(free, key=abs)


def bracket_dimensions(
    *,
    base_radius_mm: float,
    shoulder_rad: tuple[float, float],
    lowest_elbow_mm: float,
    base_thickness_mm: float,
    half_width_mm: float,
    leg_mm: float,
    arm: ArmDimensions,
    capstan: CapstanDimensions | None,
    bearing: catalogue.Bearing,
    motor: catalogue.Motor,
    clearance_mm: float,
    leg_least_mm: float = 0.0,
    gaps: Sequence[Gap] = EVEN,
    printed: bool = False,
) -> BracketDimensions:
    """Dimensions the bracket of a chain; the base lies as low as motor, sector, elbows and the leg ask for.

    Elbows that stay outside the base plate may pass beside it; those that swing in over it pass above it, up to the
    stop, and the feet then stand as far inside as the arm's beam asks for.

    Args:
        base_radius_mm: Base centre to shoulder axis of chain 0; the others are made like it.
        shoulder_rad: Smallest and largest shoulder angle over the cube.
        lowest_elbow_mm: Lowest height of an elbow axis over the cube.
        base_thickness_mm: Thickness of the base plate, whose underside stays below the elbows.
        half_width_mm: How far the bracket reaches aside of its chain's plane.
        leg_mm: How far the encoder's leg reaches aside.
        arm: Upper arm, as the others already dimensioned or a row of the catalogue.
        capstan: None for a direct drive.
        bearing: At the shoulder.
        motor: Whose body must stay over the base.
        clearance_mm: That is asked between what moves and what stands.
        leg_least_mm: How far below the shoulder the encoder's leg must end on its foot, at least.
        gaps: Of the chains.
        printed: Whether the foot blocks or the base plate are printed.

    Raises:
        DimensionError: The arms swing in so far that no room is left for the feet.
    """
    u = base_radius_mm
    if capstan is not None:
        du, dz = capstan.pinion_axis_mm
        swept = capstan.keep_out_radius_mm
        direction = capstan.direction_rad
        pins: tuple[tuple[float, float], ...] = (
            (u + capstan.slot_radius_mm * cos(direction), capstan.slot_radius_mm * sin(direction)),
        )
    else:
        du, dz = 0.0, 0.0
        swept = arm.flange_radius_mm
        distance = arm.flange_radius_mm + STOP_PIN_MM + _CLEAR_MM
        beyond = beam_stop_angle_rad(arm, STOP_PIN_MM, distance) + STOP_MARGIN_RAD
        angles = (shoulder_rad[0] - beyond, shoulder_rad[1] + beyond)
        pins = tuple((u + distance * cos(a), distance * sin(a)) for a in angles)
    body = motor.diameter_mm / 2
    stop = shoulder_rad[0] - STOP_MARGIN_RAD
    off = max(_CLEAR_MM, clearance_mm + MESHES_MM)
    boss = arm.boss_radius_mm + off
    head = bearing.outer_mm / 2 + _HEAD_WALL_MM
    under = _FOOT_HEIGHT_MM  # a wide motor hangs over the foot and its screws
    if capstan is None:  # and stands beside them: their heads are outside its cheek
        under = _FOOT_HEIGHT_MM / 2 + catalogue.screw(BLOCK_SCREW).head_diameter_mm / 2
    key = 0.0 if capstan is None else handle_room_mm(motor) - dz
    base_top = -max(
        body - dz + _CLEAR_MM + under,
        swept + off + _FOOT_HEIGHT_MM,
        boss - lowest_elbow_mm - base_thickness_mm,
        key,
        leg_least_mm + _FOOT_HEIGHT_MM,
    )
    long = _FOOT_MM[1] - _FOOT_MM[0]
    nearer = max(0.0, *(-gap.out_mm for gap in gaps))  # than chain 0 another chain stands
    inside = _FOOT_INSIDE_MM + nearer

    def foot_on(top: float) -> tuple[float, float]:
        """Both ends of a foot on a base there: where the arm leaves it room, and beside the neighbour's motor."""
        end = min(u + _FOOT_MM[1], u + _foot_outer_end_mm(arm, stop, top + _FOOT_HEIGHT_MM, off))
        inner = u + 2 * _LEG_ASIDE_MM - head  # the leg's inner edge at the shoulder's height
        adjacent = -inf if capstan is None else _next_to_mm(inner, top, (u + du, dz), body, leg_mm, gaps)
        low = tenths_below(end - long)
        if low < adjacent:
            low = -tenths_below(-adjacent)
        return low, low + long

    def clear(top: float) -> bool:
        """Whether the arm at its stop passes foot and plate on a base there."""
        low, end = foot_on(top)
        if low < inside or top + _FOOT_HEIGHT_MM > _under_arm_mm(arm, stop, end - u, off) + _ROUNDING_MM:
            return False
        over = u + arm.length_mm * cos(stop) - boss < hypot(end, half_width_mm) + PLATE_RIM_MM
        return not over or top <= -boss - arm.length_mm * abs(sin(stop))

    if not clear(base_top):  # the highest that is clear
        low_top = base_top - boss - arm.length_mm
        for _ in range(HALVINGS):
            middle = (low_top + base_top) / 2
            low_top, base_top = (middle, base_top) if clear(middle) else (low_top, middle)
        base_top = low_top
    base_top = tenths_below(base_top)
    foot = foot_on(base_top)
    require(
        foot[0] >= inside,
        "foot_block",
        "place",
        f"arms that swing to {shoulder_rad[0] * 180 / pi:.1f} deg push the foot to {foot[0] - nearer:.2f} mm from the "
        f"centre; it must stay at least {_FOOT_INSIDE_MM:g} mm away",
        *FARTHER_OUT,
        larger(BOTTOM),
    )
    if capstan is not None:
        room = _leg_room_mm(arm, stop, head, foot[1] - u, base_top)
        require(
            room >= RUNNING_GAP_MM,
            "encoder_cheek",
            "leg",
            f"the elbow at its stop is {room:.2f} mm off the leg, which the neighbour's motor pushes out; at least "
            f"{RUNNING_GAP_MM:g}",
            *FARTHER_OUT,
            larger(ARM),
            *another("motor", "bearing"),
        )
    off_rad = _pin_off_rad(hypot(pins[0][0] - u, pins[0][1]), motor) if capstan is None else 0.0
    pins_rad = tuple(atan2(z, x - u) for x, z in pins) if capstan is None else ()
    direction_rad = None if capstan is None else capstan.direction_rad
    holes, screws = motor_pattern_rad(motor.mount_count, direction_rad, pins_rad, off_rad)
    nearest = min((abs(remainder(a - pin, tau)) for a in screws for pin in pins_rad), default=pi)
    require(
        nearest >= off_rad,
        "motor_cheek",
        "stop pins",
        f"a screw of the motor is {degrees(nearest):.1f} deg from a stop pin about the shoulder, at least "
        f"{degrees(off_rad):.1f}",
        *another("motor"),
    )
    dowel, to_cheek, to_base = _PRINTED_FOOT_MM if printed else (_FOOT_EDGE_MM, *_FOOT_SCREWS_MM)
    return BracketDimensions(
        shoulder_u_mm=u,
        head_radius_mm=head,
        passage_mm=bearing.housing_shoulder_max_mm - 0.6,
        motor_axis_mm=(u + du, dz),
        motor_pad_radius_mm=body + _PAD_MARGIN_MM,
        motor_holes_rad=holes,
        motor_screws_rad=screws,
        foot_u_mm=foot,
        foot_height_mm=_FOOT_HEIGHT_MM,
        base_top_mm=base_top,
        cheek_screw_u_mm=(foot[0] + to_cheek, foot[1] - to_cheek),
        cheek_dowel_u_mm=(foot[0] + dowel, foot[1] - dowel),
        cheek_screw_z_mm=base_top + _FOOT_HEIGHT_MM / 2,
        base_screw_u_mm=(foot[0] + to_base, foot[1] - to_base),
        base_dowel_u_mm=(foot[0] + dowel, foot[1] - dowel),
        stop_pin_mm=STOP_PIN_MM,
        stop_pins_mm=pins,
    )


_NEXT_TO_MM = 0.5  # of the board's screws, its plug and edges from the neighbour's motor, which is drawn off past them
_BOARD_SCREWS = "M2.5", "M2"  # the largest first


def board_screw(encoder: catalogue.Encoder) -> str:
    """Gives the size of the screws of an encoder's board: the largest that has the usual play in the board's holes."""
    fitting = (size for size in _BOARD_SCREWS if catalogue.screw(size).clearance_hole_mm <= encoder.hole_diameter_mm)
    return next(fitting, _BOARD_SCREWS[-1])


PLUG_MM = (5.0, 4.0, 5.0)  # half width, height over the board and length of the plug at its lower end
BOARD_EDGE_MM = 4.0  # of a direct drive's leg around its board's screws
_DIRECTIONS, _ANGLES = 1440, 181  # in which a hull is looked at, to 1e-4 mm; of an arm between its stops


def require_room_for_board(
    base_radius_mm: float,
    motor_axis_mm: tuple[float, float],
    stack: Layers,
    motor: catalogue.Motor,
    encoder: catalogue.Encoder,
    gaps: Sequence[Gap] = EVEN,
) -> None:
    """Refuses a base on which a motor, or its way off its cheek, runs into the next chain's encoder board.

    Args:
        base_radius_mm: Base centre to shoulder axis of chain 0.
        motor_axis_mm: (u, z) of the motor's axis in its chain's stand.
        stack: Stack of a chain along the shoulder axis.
        motor: Row of the catalogue.
        encoder: Row of the catalogue; its board stands upright.
        gaps: Of the chains.

    Raises:
        DimensionError: It does.
    """
    u, face, radius = motor_axis_mm[0], stack.motor_face_mm, motor.diameter_mm / 2
    found = np.inf
    for wide, y, z in _board_boxes(stack, encoder):
        off = max(z[0] - motor_axis_mm[1], motor_axis_mm[1] - z[1], 0.0)  # where in its height the motor is widest
        if off < radius:
            half = sqrt(radius**2 - off**2)
            body = (u - half, u + half), (face, face + 2 * motor.length_mm)  # and its way off
            found = min(found, _apart_mm(body, ((base_radius_mm - wide, base_radius_mm + wide), y), gaps))
    require(
        found >= _NEXT_TO_MM,
        "encoder_board",
        "beside the neighbour's motor",
        f"the motors come within {found:.2f} mm of the encoders' boards of the chains beside them; at least "
        f"{_NEXT_TO_MM:g}",
        *FARTHER_OUT,
    )


def require_room_for_boss(
    arm: ArmDimensions, bracket: BracketDimensions, shoulder_rad: tuple[float, float], stack: Layers, board_mm: Circle
) -> None:
    """Refuses a direct drive whose arm's end, wider than the way between the cheeks, runs into one between its stops.

    Args:
        arm: Upper arm.
        bracket: Its chain's.
        shoulder_rad: Smallest and largest shoulder angle over the cube.
        stack: Stack of a chain along the shoulder axis.
        board_mm: Half distances (x, z) of the encoder board's screws, and their radius; 0 where there is no board.

    Raises:
        DimensionError: It does.
    """
    x, z, edge = board_mm
    corners = [(sx * x, sz * z, edge) for sx in (-1, 1) for sz in (-1, 1)]
    encoder_cheek = [(0.0, 0.0, bracket.head_radius_mm), *corners, *bracket.foot_circles_mm]
    cheeks = []
    if stack.elbow_boss_mm[1] > stack.motor_cheek_mm[0] - RUNNING_GAP_MM:
        cheeks.append(bracket.motor_cheek_circles_mm)
    if stack.elbow_boss_mm[0] < stack.encoder_cheek_mm[1] + RUNNING_GAP_MM:
        cheeks.append(encoder_cheek)
    angles = np.linspace(shoulder_rad[0] - STOP_MARGIN_RAD, shoulder_rad[1] + STOP_MARGIN_RAD, _ANGLES)

    off = np.full(_ANGLES, np.inf)
    for normals, supports in map(_hull, cheeks):
        outward = np.stack([np.cos(angles), np.sin(angles)], axis=-1) @ normals  # of an elbow, per mm of arm
        off = np.minimum(off, (arm.length_mm * outward - supports).max(axis=1) - arm.boss_radius_mm)
    found = off.min()
    require(
        found >= RUNNING_GAP_MM,
        "upper_arm",
        "beside its cheeks",
        f"the elbow's boss comes within {found:.2f} mm of a cheek; at least {RUNNING_GAP_MM:g}",
        larger(ARM),
        larger(BOTTOM),
        *another("motor"),
    )


def _hull(circles: list[Circle]) -> tuple[np.ndarray, np.ndarray]:
    """Directions (2, n) square to the sides of the hull of circles, and how far it reaches along each, (n,) mm."""
    turns = [*np.linspace(0.0, 2.0 * np.pi, _DIRECTIONS, endpoint=False)]
    for (ax, az, a), (bx, bz, b) in combinations(circles, 2):  # and square to every edge
        apart = hypot(bx - ax, bz - az)
        if apart > abs(a - b):
            lean, along = acos((a - b) / apart), atan2(bz - az, bx - ax)
            turns += [along - lean, along + lean]
    normals, known = np.stack([np.cos(turns), np.sin(turns)]), np.array(circles)
    return normals, (known[:, :2] @ normals + known[:, 2:]).max(axis=0)


def _board_boxes(
    stack: Layers, encoder: catalogue.Encoder
) -> list[tuple[float, tuple[float, float], tuple[float, float]]]:
    """Half width, extents along the shoulder's axis and up, of the upright board, its two rows of screws, its plug."""
    screw, (back, front) = catalogue.screw(board_screw(encoder)), stack.encoder_board_mm
    half, head = encoder.board_length_mm / 2, screw.head_diameter_mm / 2
    along = back - screw.head_height_mm, stack.encoder_head_mm[0]
    wide, row = encoder.hole_spacing_width_mm / 2 + head, encoder.hole_spacing_length_mm / 2
    return [
        (encoder.board_width_mm / 2, (back, front), (-half, half)),
        (wide, along, (row - head, row + head)),
        (wide, along, (-row - head, head - row)),
        (PLUG_MM[0], (back - PLUG_MM[1], back), (-half, PLUG_MM[2] - half)),
    ]


def _apart_mm(
    one: tuple[tuple[float, float], ...], other: tuple[tuple[float, float], ...], gaps: Sequence[Gap]
) -> float:
    """Largest distance of two rectangles (u, t) of neighbouring chains along any of their sides; negative: they meet.

    Either chain may be the first's neighbour; of all pairs the smallest.
    """
    found = []
    for stand in other_stands(gaps):
        frames = np.eye(4), stand
        corners = [
            np.array([[u, t] for u in box[0] for t in box[1]]) @ frame[:2, :2].T + frame[:2, 3]
            for box, frame in zip((one, other), frames, strict=True)
        ]
        sides = np.concatenate([frame[:2, :2].T for frame in frames])
        first, second = (points @ sides.T for points in corners)
        found.append(
            max((second.min(axis=0) - first.max(axis=0)).max(), (first.min(axis=0) - second.max(axis=0)).max())
        )
    return float(min(found))
