"""The cable capstan: sector on the arm, pinion on the motor, the cable between, what holds its ends (arm's frame)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import acos, ceil, cos, floor, hypot, inf, pi, radians, sin, sqrt

import numpy as np

from delta_cad import catalogue
from delta_cad.design.stands import EVEN, Gap
from delta_cad.dimensions.cable_run import CableRun, groove_pitch_mm
from delta_cad.dimensions.layers import Layers
from delta_cad.dimensions.rules import (
    RATIO,
    RUNNING_GAP_MM,
    SECTOR,
    STOP_MARGIN_RAD,
    SWINGS_LESS,
    THREAD_WALL_MM,
    another,
    ceil_sig,
    larger,
    require,
    smaller,
    tenths_above,
)
from delta_cad.drive.laid_cable import Arc, LaidCable
from delta_cad.mechanism.placement import frames

_SECTOR_OFF_MM = 2.2  # from the arm's plate to the sector's rim: the tension screw's head lies beside the arm
_GAP_MM = 1.0  # of the pitch circles; the strands cross between them
_PINION_TURNS = 3  # hold 9 times the slack side's tension at a friction of 0.12
_GROOVE_FRACTION = 0.25  # depth of the pinion's groove per cable diameter
_PINION_WALL_MM = 0.75  # least metal between the groove and the motor's shaft
SHOULDER_MM = 0.5  # of the pinion at either end of its groove
SHAFT_ENGAGEMENT_MM = 6.0  # length of the motor's shaft in the pinion, at least
_PAST_HEADS_MM = 0.2  # from the pinion to the heads of the motor's screws, which are drawn out past it
SET_SCREW = "M3"
SET_TORQUE_N_m = 0.4
"""Of a stainless M3 set screw with a cup point. One of class 45H bears 0.9 (proof torque, ISO 898-5; monsterbolts.com,
metric socket screw torque specs), one of class 21H is taken to bear 21/45 of that, as it is as much softer: 0.42."""
_PAST_TURNS_MM = 0.1  # of them from the cable on it, with what meshes are off
_COLLAR_PLAY_MM = 0.5  # radius by which the collar is free in the motor's pilot bore
_COLLAR_OFF_HEADS_MM = 1.1  # and from it to the heads of the motor's screws
_SET_TIP_MM = 1.5  # diameter of the cup of a set screw, all of which bears on the shaft
_COLLAR_MM = 3.0 + 2 * THREAD_WALL_MM  # length of the collar: its set screws in the middle
_NOSE_RADIUS_MM = 5.0  # under the cable at the rim's inner end, where it lies still and is bent once
_NOSE_TURN_RAD = radians(90.0)  # the cable then runs inwards along the sector's end
_RIM_BEYOND_MM = 4.0  # rim between the pinion at the stop and the nose: keeps a wall of 2 mm beside the stop's slot
WEB_MM = 3.0  # of the sector below its rim
_RIM_SIDE_MM = 0.8  # rim beside the cable where it is nearest to the rim's edge
_SLOT_WALL_MM = 1.0  # least metal from the stop pin's slot to the rim and from the pin to the motor's pilot bore
ANCHOR_MM, ANCHOR_SIDE_MM = 6.0, 3.2  # wall at the inner end that the cable's sleeve bears on: along it, and inside
CRIMP_MM = (1.8, 3.0)  # diameter and length of the sleeves crimped on the cable
_THREADED_MM = 0.05  # by which their bore is wider than the cable, at least, and in steps of which it is drilled
ROPE_FACTOR = 3.15  # breaking load over tension, ISO 4308-1 of the lightest class; bending is the ratio's affair
_COLLAR_OFF_MM = (
    -0.6
)  # along the axis from the sector's rim to the collar, at least: the groove's shoulder is its wall, too
_COLLAR_ASIDE_MM = THREAD_WALL_MM + 0.25  # by which the set screws, as drawn, lie farther from the rim than its end
_NEXT_TO_RIM_MM = 1.35, 2.1  # of the collar and of its set screws from the rim, with what meshes are off
_NEXT_TO_RIM_SHARE = 0.75  # by which the former grows with a cable over `_USUAL_CABLE_MM`
_USUAL_CABLE_MM = 0.54
TENSION_SCREW, TENSION_SCREW_LENGTH_MM = "M3", 10.0
CARRIAGE_MM = (6.0, 5.0)  # length and thickness of the block that pulls the cable's outer end
CARRIAGE_RADII_MM = (-7.5, 2.5)  # its inner and outer face from the cable's line
CARRIAGE_SCREW_MM = -5.0  # line of its screw from the cable's line
CARRIAGE_FROM_MM, TENSION_TRAVEL_MM = 1.2, 3.5  # where it stands when the cable is put on, and how far it goes
LUG_WALL_MM = (1.7, 3.0)  # beside the carriage's pocket, and under its screw's head
POCKET_FROM_MM = 1.0  # wall between the rim's end and the pocket
POCKET_CORNER_MM = 1.6  # radius of the pocket's corners and the carriage's: a cutter of 3 mm goes round them
POCKET_PLAY_MM = 0.1  # of the carriage in its pocket, either side
_CABLE_SLOT_MM, _CABLE_PLAY_MM = 1.0, 0.3  # slots that the cable is laid into: least width, and width over the cable
PINION_TURNED_MM, RIM_TURNED_MM = 0.02, 0.05  # of the pinion's diameters and the rim's radius, either way
_TURNED_MM, _AXES_MM = 0.25, 0.055  # pinion and nose in the cable's way; axes and rim: roots of sums of squares
STRETCH = 0.004  # of the cable's length: its pretension's, and a settling of a thousandth
_BENCH_STEP_MM = 0.1  # to which a length of the cable is measured


@dataclass(frozen=True)
class CapstanDimensions:
    """Sector, pinion and cable; angles are polar angles about the shoulder in the arm's frame.

    At the larger angle the cable leaves the rim along its tangent, into a carriage that a screw pulls. At the smaller
    one, which passes under the platform, the rim ends in a nose round which the cable turns inwards to its anchor, so
    that nothing stands above the rim there. The outer end lies towards the arm, the inner one towards the motor.
    """

    run: CableRun
    cable_diameter_mm: float
    rim_radius_mm: float
    middle_y_mm: float
    pinion_radius_mm: float
    pinion_bore_mm: float
    pinion_bore_depth_mm: float
    pinion_y_mm: tuple[float, float]
    collar_radius_mm: float
    collar_y_mm: tuple[float, float]
    direction_rad: float
    ratio: float
    rim_angles_rad: tuple[float, float]
    nose_radius_mm: float
    turns_rad: tuple[float, float]
    slot_radius_mm: float
    slot_width_mm: float
    slot_angles_rad: tuple[float, float]
    keep_out_radius_mm: float

    @property
    def pitch_radius_mm(self) -> float:
        """Radius of the cable's middle on the sector."""
        return self.run.sector_mm

    @property
    def collar_at_motor(self) -> bool:
        """Whether the pinion's collar turns in the bore of the motor's pilot; else it lies on the arm's side."""
        return self.collar_y_mm[0] > self.middle_y_mm

    @property
    def groove_y_mm(self) -> tuple[float, float]:
        """Ends of the pinion's groove with its shoulders, along the shoulder's axis."""
        low, high = self.pinion_y_mm
        half = self.middle_y_mm - low if self.collar_at_motor else high - self.middle_y_mm
        return self.middle_y_mm - half, self.middle_y_mm + half

    @property
    def pinion_axis_mm(self) -> tuple[float, float]:
        """(u, z) of the pinion's axis from the shoulder."""
        distance = self.run.centre_distance_mm
        return distance * cos(self.direction_rad), distance * sin(self.direction_rad)

    @property
    def nose_centre_mm(self) -> tuple[float, float]:
        """(x, z) of the nose's axis from the shoulder."""
        radius = self.rim_radius_mm - self.nose_radius_mm
        return radius * cos(self.rim_angles_rad[0]), radius * sin(self.rim_angles_rad[0])

    @property
    def nose_bar_radius_mm(self) -> float:
        """Half width of the sector's end below the nose: as far below the cable as the anchor's wall goes."""
        return self.nose_radius_mm + self.cable_diameter_mm / 2 - ANCHOR_SIDE_MM

    @property
    def web_y_mm(self) -> tuple[float, float]:
        """Both sides of the sector's web along the shoulder's axis."""
        return self.middle_y_mm - WEB_MM / 2, self.middle_y_mm + WEB_MM / 2

    @property
    def end_y_mm(self) -> tuple[float, float]:
        """Coordinate along the shoulder's axis of the cable at the rim's ends, of the smaller angle first."""
        return self.middle_y_mm + self.run.made_lug_mm, self.middle_y_mm - self.run.made_lug_mm

    @property
    def cable_length_mm(self) -> float:
        """Length of the cable between the backs of its two sleeves, where the carriage stands first."""
        nose = (self.nose_radius_mm + self.cable_diameter_mm / 2) * self.turns_rad[0]
        carriage = CARRIAGE_FROM_MM + CARRIAGE_MM[0]
        return self.run.length_mm() + nose + ANCHOR_MM + CRIMP_MM[1] + carriage

    def laid(self, turned_rad: np.ndarray) -> LaidCable:
        """Gives the cable as it lies on its drums.

        Args:
            turned_rad: Angle of the arm from the middle of its stroke.
        """
        run, turned = self.run, np.atleast_1d(np.asarray(turned_rad, dtype=float))
        middle, straight = run.stroke_rad / 2 + run.beyond_rad, np.ones_like(turned)
        nose = self.nose_radius_mm + self.cable_diameter_mm / 2
        return LaidCable(
            outer=(
                Arc(run.sector_mm * (middle + turned), run.sector_mm),
                Arc((CARRIAGE_FROM_MM + CARRIAGE_MM[0]) * straight),
            ),
            pinion=Arc(run.wrap_rad * run.pinion_mm * straight, run.pinion_mm),
            inner=(
                Arc(run.sector_mm * (middle - turned), run.sector_mm),
                Arc(nose * self.turns_rad[0] * straight, nose),
                Arc(ANCHOR_MM * straight),
            ),
            free_mm=run.free_mm,
        )

    @property
    def cable_slot_mm(self) -> float:
        """Width of the slots that the cable is laid into with its sleeves crimped."""
        return max(_CABLE_SLOT_MM, self.cable_diameter_mm + _CABLE_PLAY_MM)

    @property
    def bench_mm(self) -> tuple[float, float]:
        """Length of the slack cable between the backs of its crimped sleeves, and its tolerance, either way.

        The shortest goes on where the carriage stands first; the longest is tight, stretched and settled, where the
        carriage's travel ends. Sector, pinion and their axes take their share of the travel; this is its middle.
        """
        half = (TENSION_TRAVEL_MM - STRETCH * self.cable_length_mm) / 2
        made = hypot(_TURNED_MM, _AXES_MM * 2 * self.run.centre_distance_mm / self.run.free_mm)
        tolerance = floor(sqrt(max(half**2 - made**2, 0.0)) / _BENCH_STEP_MM) * _BENCH_STEP_MM
        return round((self.cable_length_mm + half) / _BENCH_STEP_MM) * _BENCH_STEP_MM, tolerance


def cable_run(
    pitch_radius_mm: float, ratio: float, shoulder_rad: tuple[float, float], cable: catalogue.Cable
) -> CableRun:
    """Lays a cable over the range of shoulder angles with the stops' margin, the outer lug clear of the pinion.

    Args:
        pitch_radius_mm: Radius of the cable's middle on the sector.
        ratio: Turns of the pinion per turn of the arm.
        shoulder_rad: Smallest and largest shoulder angle over the cube.
        cable: Row of the catalogue.
    """
    pinion, d = pitch_radius_mm / ratio, cable.diameter_mm
    distance = pitch_radius_mm + pinion + _GAP_MM
    lug = pitch_radius_mm + CARRIAGE_RADII_MM[1] + LUG_WALL_MM[0]
    near = _crest_mm(pinion, d) + RUNNING_GAP_MM  # closest that the lug may come to the pinion's axis
    cosine = (distance**2 + lug**2 - near**2) / (2 * distance * lug)
    aside = acos(cosine) - acos((pitch_radius_mm + pinion) / distance) if cosine < 1.0 else 0.0
    return CableRun(
        sector_mm=pitch_radius_mm,
        pinion_mm=pinion,
        gap_mm=_GAP_MM,
        pitch_mm=groove_pitch_mm(d),
        turns=_PINION_TURNS,
        stroke_rad=shoulder_rad[1] - shoulder_rad[0] + 2 * STOP_MARGIN_RAD,
        beyond_rad=max(aside, _RIM_BEYOND_MM / pitch_radius_mm),
    )


def _crest_mm(pinion_pitch_mm: float, cable_mm: float) -> float:
    """Gives the outer radius of a pinion between the turns of its groove, mm."""
    return pinion_pitch_mm - cable_mm / 2 + _GROOVE_FRACTION * cable_mm


def _sector_width_mm(run: CableRun, cable_mm: float) -> float:
    """Gives the width of the rim that both ends of the cable need, mm."""
    return tenths_above(2 * run.made_lug_mm + cable_mm + 2 * _RIM_SIDE_MM)


def rim_y_mm(
    run: CableRun,
    cable_mm: float,
    arm_thickness_mm: float,
    base_radius_mm: float,
    clearance_mm: float,
    gaps: Sequence[Gap] = EVEN,
) -> tuple[float, float]:
    """Places the rim along the shoulder's axis: beside the arm, and as far out as a neighbour's sector asks for.

    Two sectors that swing inwards under the platform meet at the angle between their chains, twice h: the tip of one,
    at its rim's height, passes the other's inner side when `2 sin(h)^2 y >= 2 sin(h) cos(h) (tip - R) + clearance`, R
    being that of the first one. Where they meet at less than 90 degrees, the tip's outer side is nearer.

    Args:
        run: The cable.
        cable_mm: Its diameter.
        arm_thickness_mm: Thickness of the arm's plate.
        base_radius_mm: Base centre to shoulder axis of chain 0, R.
        clearance_mm: Between links.
        gaps: Of the chains.

    Returns:
        Both sides of the rim.
    """
    tip, width = run.sector_mm + cable_mm / 2, _sector_width_mm(run, cable_mm)

    def neighbour(gap: Gap) -> float:
        inwards = 2 * gap.half_cosine * (tip - (base_radius_mm + gap.out_mm))
        wider = max(gap.cosine, 0.0) * width / gap.half_sine
        return (inwards + clearance_mm / gap.half_sine + wider) / (2 * gap.half_sine)

    low = tenths_above(max(arm_thickness_mm / 2 + _SECTOR_OFF_MM, *map(neighbour, gaps)))
    return low, low + width


def base_radius_min_mm(
    run: CableRun,
    cable_mm: float,
    arm_thickness_mm: float,
    flange_radius_mm: float,
    clearance_mm: float,
    gaps: Sequence[Gap] = EVEN,
) -> float:
    """Computes the smallest base radius of chain 0 at which sectors pass their neighbours' sectors and upper arms.

    The tip of a sector that swings inwards lies `R' - (R - tip) cos(a) - y sin(a)` from the neighbour's shoulder axis,
    a being the angle between both chains, R and R' their radii and y the outer side of its rim, see `rim_y_mm`: there
    the neighbour's flange and the clearance must have room.

    Args:
        run: The cable.
        cable_mm: Its diameter.
        arm_thickness_mm: Thickness of the arm's plate.
        flange_radius_mm: Of the upper arm about the shoulder.
        clearance_mm: Between links.
        gaps: Of the chains, their radii as much larger than that of chain 0 as they state.

    Returns:
        R, mm, of a rim a whole tenth farther out by rounding; arms whose sectors stay outside may stand closer.
    """
    tip, width = run.sector_mm + cable_mm / 2, _sector_width_mm(run, cable_mm)
    next_to_arm = tenths_above(arm_thickness_mm / 2 + _SECTOR_OFF_MM) + width
    found = []
    for gap in gaps:
        off = gap.out_mm * gap.cosine - gap.next_out_mm
        adjacent = flange_radius_mm - gap.cosine * tip + gap.sine * next_to_arm + clearance_mm + off
        found.append(adjacent / (1.0 - gap.cosine))
        for at in gaps:  # whose sectors decide where the rim is
            share = gap.sine / at.half_sine
            wide = width + 0.1 + max(at.cosine, 0.0) * width / (2 * at.half_sine**2)
            clear = clearance_mm * (1.0 + share * 0.5 / at.half_sine)
            inwards = share * at.half_cosine
            reached = flange_radius_mm + (inwards - gap.cosine) * tip + clear + gap.sine * wide
            found.append((reached + off - inwards * at.out_mm) / (1.0 - gap.cosine + inwards))
    return max(found)


def collar_mm(motor: catalogue.Motor) -> float:
    """Gives the outer radius of a pinion's collar: its set screws are the shortest and end flush with it, mm."""
    return motor.shaft_diameter_mm / 2 + min(catalogue.set_screw(SET_SCREW).lengths_mm)


def collar_off_mm(run: CableRun, cable_mm: float, motor: catalogue.Motor, apart_mm: float = 0.0) -> float:
    """Gives how far from the sector's rim the pinion's collar stands along the axis, its set screws `apart_mm`, mm.

    It stands close where it is that much smaller than the pinion, farther off where it is as wide.
    """
    adjacent = run.centre_distance_mm - collar_mm(motor) - (run.sector_mm - cable_mm / 4)
    adjacent = max(adjacent, 0.0)
    collar = _NEXT_TO_RIM_MM[0] + _NEXT_TO_RIM_SHARE * (cable_mm - _USUAL_CABLE_MM)
    # of the collar's end, and of its set screws
    required = (collar, 0.0), (max(_NEXT_TO_RIM_MM[1], apart_mm), _COLLAR_ASIDE_MM)
    off = [sqrt(apart**2 - adjacent**2) - aside for apart, aside in required if apart > adjacent]
    return tenths_above(max([_COLLAR_OFF_MM, *off]))


@dataclass(frozen=True)
class PinionPlace:
    """Where a pinion lies along the shoulder's axis, mm: it and its collar, (lower, upper)."""

    pinion_mm: tuple[float, float]
    collar_mm: tuple[float, float]

    @property
    def tips_mm(self) -> float:
        """Where the tips of its set screws begin, which the motor's shaft must reach."""
        return (sum(self.collar_mm) - _SET_TIP_MM) / 2


def pinion_places(
    run: CableRun, rim_y: tuple[float, float], cable_mm: float, motor: catalogue.Motor, apart_mm: float
) -> tuple[PinionPlace, PinionPlace]:
    """Locates a pinion whose collar lies on the arm's side, and one whose collar lies on the motor's.

    With the former the motor comes as near as the groove lets it, and a key reaches the set screws between arm and
    sector; the motor's shaft must be so long. The latter's collar turns in the bore of the motor's pilot.

    Args:
        run: The cable.
        rim_y: Both sides of the sector's rim.
        cable_mm: Diameter of the cable.
        motor: Row of the catalogue.
        apart_mm: See `collar_off_mm`.
    """
    middle, half = sum(rim_y) / 2, tenths_above(run.grooved_mm / 2 + SHOULDER_MM)
    off = collar_off_mm(run, cable_mm, motor, apart_mm)
    below, above = rim_y[0] - off, rim_y[1] + off
    end, far = below - _COLLAR_MM, above + _COLLAR_MM
    return PinionPlace((end, middle + half), (end, below)), PinionPlace((middle - half, far), (above, far))


def turns_end_mm(run: CableRun, rim_y: tuple[float, float], cable_mm: float, motor: catalogue.Motor) -> float:
    """Gives where the turns on a pinion end before the motor's screws, along its axis, mm; -inf: these are beside them.

    Args:
        run: The cable.
        rim_y: Both sides of the sector's rim.
        cable_mm: Diameter of the cable.
        motor: Row of the catalogue; the heads of its screws are drawn out past the pinion.
    """
    heads = (motor.mount_circle_mm - motor.mount_screw.head_diameter_mm) / 2
    if run.pinion_mm + cable_mm / 2 + _PAST_TURNS_MM <= heads:
        return -inf
    return (sum(rim_y) + run.turns * run.pitch_mm + cable_mm) / 2 + _PAST_TURNS_MM


def rim_reach_rad(
    run: CableRun, shoulder_rad: tuple[float, float], direction_rad: float
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Gives where the pinion comes to stand in the arm's frame, stop margins included, and the rim's ends, rad."""
    side = run.tangent_rad + run.beyond_rad
    reach = (direction_rad - shoulder_rad[1] - STOP_MARGIN_RAD, direction_rad - shoulder_rad[0] + STOP_MARGIN_RAD)
    return reach, (reach[0] - side, reach[1] + side)


def capstan_dimensions(
    *,
    run: CableRun,
    ratio: float,
    shoulder_rad: tuple[float, float],
    layers: Layers,
    cable: catalogue.Cable,
    motor: catalogue.Motor,
    stop_pin_mm: float,
    slot_radius_mm: float,
    direction_rad: float,
    place: PinionPlace,
) -> CapstanDimensions:
    """Dimensions a capstan around its cable.

    The arc slot around the stop pin ends exactly the stop margin outside the range of shoulder angles.

    Args:
        run: The cable.
        ratio: Turns of the pinion per turn of the arm.
        shoulder_rad: Smallest and largest shoulder angle over the cube.
        layers: Stack along the shoulder axis.
        cable: Row of the catalogue.
        motor: Row of the catalogue.
        stop_pin_mm: Diameter of the stop pin.
        slot_radius_mm: Distance of the stop pin from the shoulder axis.
        direction_rad: From the shoulder to the pinion, see `direction.pinion_direction_rad`.
        place: Of the pinion along the shoulder's axis.

    Raises:
        DimensionError: The pinion gets too thin for the motor's shaft, the shaft is too short, the sector is too small
            for the stop pin's slot or would have to go round more than 250 degrees.
    """
    d, pitch = cable.diameter_mm, run.sector_mm
    bore = motor.shaft_diameter_mm
    wall = run.pinion_mm - d / 2 - bore / 2
    require(
        wall >= _PINION_WALL_MM,
        "pinion",
        "wall",
        f"{wall:.2f} mm over the shaft of {bore:g} mm; at least {_PINION_WALL_MM:g} mm",
        smaller(RATIO),
        larger(SECTOR),
    )
    crest, collar, most = _crest_mm(run.pinion_mm, d), collar_mm(motor), _collar_radius_mm(motor)
    require(
        collar <= most or place.collar_mm[0] < layers.sector_mm[0] or motor.pilot_diameter_mm == 0.0,  # refused there
        "pinion",
        "collar",
        f"{collar:.2f} mm for the shortest set screws; the motor's pilot of {motor.pilot_diameter_mm:g} mm and its "
        f"screws leave {most:.2f} mm",
        *another("motor"),
    )
    widest = _widest_pinion_mm(motor, d)
    require(
        run.pinion_mm <= widest,
        "pinion",
        "beside the motor's screws",
        f"a pitch radius of {run.pinion_mm:.2f} mm; {motor.id}'s screws are drawn out past at most {widest:.2f}",
        smaller(SECTOR),
        larger(RATIO),
    )
    low, high = place.pinion_mm
    shaft_end = layers.motor_face_mm - motor.shaft_length_mm
    floor = shaft_end - 0.5 if shaft_end - 0.5 > low + 0.5 else low  # a longer shaft comes out of the pinion
    engaged = high - max(floor, shaft_end)
    require(
        engaged >= SHAFT_ENGAGEMENT_MM,
        "pinion",
        "bore",
        f"the motor's shaft of {motor.shaft_length_mm:g} mm engages {engaged:.1f} mm; at least {SHAFT_ENGAGEMENT_MM:g}",
        *another("motor"),
    )
    slot_width = stop_pin_mm + 1.0
    to_pilot = slot_radius_mm + (stop_pin_mm + motor.pilot_diameter_mm) / 2 + _SLOT_WALL_MM
    least = max(
        slot_radius_mm + slot_width / 2 + _SLOT_WALL_MM + d / 2,
        (to_pilot - run.gap_mm) / (1.0 + 1.0 / ratio),  # distance of the axes >= to_pilot
    )
    require(
        pitch >= least,
        "sector",
        "slot",
        f"the stop pin's slot on radius {slot_radius_mm:g} cuts the rim, or the pin the motor's pilot bore, at a pitch "
        f"radius of {pitch:g} mm; at least {ceil_sig(least)} mm",
        larger(SECTOR),
    )
    reach, rim = rim_reach_rad(run, shoulder_rad, direction_rad)
    require(
        rim[1] - rim[0] <= radians(250.0),
        "sector",
        "angle",
        f"the shoulder turns {(shoulder_rad[1] - shoulder_rad[0]) * 180 / pi:.1f} deg; the sector would span "
        f"{(rim[1] - rim[0]) * 180 / pi:.0f} deg, at most 250",
        *SWINGS_LESS,
    )
    play = (slot_width - stop_pin_mm) / 2 / slot_radius_mm
    head = catalogue.screw(TENSION_SCREW).head_height_mm
    lug = (pitch + CARRIAGE_RADII_MM[1] + LUG_WALL_MM[0], lug_length_mm() + head)
    return CapstanDimensions(
        run=run,
        cable_diameter_mm=d,
        rim_radius_mm=pitch - d / 2,
        middle_y_mm=sum(layers.sector_mm) / 2,
        pinion_radius_mm=crest,
        pinion_bore_mm=bore,
        pinion_bore_depth_mm=high - floor,
        pinion_y_mm=place.pinion_mm,
        collar_radius_mm=collar,
        collar_y_mm=place.collar_mm,
        direction_rad=direction_rad,
        ratio=ratio,
        rim_angles_rad=rim,
        nose_radius_mm=_NOSE_RADIUS_MM,
        turns_rad=(_NOSE_TURN_RAD, 0.0),
        slot_radius_mm=slot_radius_mm,
        slot_width_mm=slot_width,
        slot_angles_rad=(reach[0] + play, reach[1] - play),
        keep_out_radius_mm=hypot(*lug),
    )


def _widest_pinion_mm(motor: catalogue.Motor, cable_mm: float) -> float:
    """Gives the largest pitch radius of a pinion, past which the motor's screws are drawn out, mm."""
    head = motor.mount_screw.head_diameter_mm
    return (motor.mount_circle_mm - head) / 2 - _PAST_HEADS_MM - _crest_mm(0.0, cable_mm)


def _collar_radius_mm(motor: catalogue.Motor) -> float:
    """Gives the radius of the pinion's collar, which turns in the bore of the motor's pilot, between the screws, mm."""
    heads = (motor.mount_circle_mm - motor.mount_screw.head_diameter_mm) / 2
    return min(motor.pilot_diameter_mm / 2 - _COLLAR_PLAY_MM, heads - _COLLAR_OFF_HEADS_MM)


def lug_length_mm() -> float:
    """Gives the length of the outer lug: carriage, its travel and the wall under the screw's head, mm."""
    return CARRIAGE_FROM_MM + CARRIAGE_MM[0] + TENSION_TRAVEL_MM + LUG_WALL_MM[1]


RIM_MM = 3.5  # height of the rim's full width under the cable
SLEEVE_OVER_MM = (CARRIAGE_MM[1] + CRIMP_MM[0]) / 2 + 0.6  # aside of its seat, so far a sleeve passes over its carriage


def sleeve_bore_mm(cable_mm: float) -> float:
    """Gives the bore of a cable's sleeve as it is turned, before it is crimped: the rope goes through it."""
    return round(ceil(cable_mm / _THREADED_MM + 1.0 - 1e-9) * _THREADED_MM, 3)


def rim_end(c: CapstanDimensions, end: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Locates where the cable leaves the sector: point, tangent and normal away from it, each (3,) in the arm's frame.

    Args:
        c: The capstan.
        end: 0 for the smaller polar angle, where the cable has turned inwards round the nose; 1 for the larger.
    """
    sense = 1.0 if end else -1.0
    angle = c.rim_angles_rad[end] + sense * c.turns_rad[end]
    normal = np.array([cos(angle), 0.0, sin(angle)])
    tangent = sense * np.array([-sin(angle), 0.0, cos(angle)])
    adjacent = np.array([0.0, c.end_y_mm[end], 0.0])
    if end:
        return adjacent + c.pitch_radius_mm * normal, tangent, normal
    x, z = c.nose_centre_mm
    nose = np.array([x, 0.0, z]) + (c.nose_radius_mm + c.cable_diameter_mm / 2) * normal
    return adjacent + nose, tangent, normal


def carriage_frame(c: CapstanDimensions) -> np.ndarray:
    """(4, 4) frame of the tension carriage in the arm's frame: x outwards, y along the shoulder's axis, z off the rim.

    The origin lies on the cable's line where the carriage begins.
    """
    point, tangent, normal = rim_end(c, 1)
    frame = frames(normal, np.cross(tangent, normal), point + CARRIAGE_FROM_MM * tangent)
    assert np.allclose(frame[:3, 2], tangent)
    return frame


def sleeve_frames(c: CapstanDimensions) -> tuple[np.ndarray, np.ndarray]:
    """(4, 4) frames of both crimp sleeves in the arm's frame, behind the anchor's wall and in the carriage."""
    found = []
    for end, back in enumerate((ANCHOR_MM, CARRIAGE_FROM_MM + CARRIAGE_MM[0] - CRIMP_MM[1])):
        point, tangent, normal = rim_end(c, end)
        found.append(frames(normal, np.cross(tangent, normal), point + back * tangent))
    return found[0], found[1]
