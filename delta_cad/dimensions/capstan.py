"""The cable capstan: a sector on the arm, a pinion on the motor, the cable between them (arm's frame)."""

from __future__ import annotations

from dataclasses import dataclass
from math import acos, cos, hypot, pi, radians, sin, tau

from delta_cad import catalogue
from delta_cad.dimensions.layers import Layers
from delta_cad.dimensions.rules import RUNNING_GAP_MM, STOP_MARGIN_RAD, require

PINION_DIRECTION_RAD = radians(-125.0)  # from the shoulder down and inwards: keeps the motor inside the outline
GAP_MM = 0.8  # pinion to sector; the cable runs between them
PINION_WRAPS = 3.0  # friction of three turns holds e^(0.15 * 6 pi) = 17 times the slack side's tension
PINION_WALL_MM = 0.75  # steel sleeve bonded on the motor shaft
GROOVE_FRACTION = 0.25  # depth of the pinion's groove per cable diameter
SHAFT_ENGAGEMENT_MM = 6.0  # bonded length at least one shaft diameter
NOSE_RADIUS_MM = 5.0  # under the cable at the rim's upper end: it bends no tighter there than on the pinion
NOSE_TURN_RAD = radians(90.0)  # the cable then runs inwards along the sector's end
RIM_BEYOND_MM = 4.0  # rim between the pinion at the stop and the nose: keeps a wall of 2 mm beside the stop's slot
HUB_WALL_MM = 8.0  # sector around the shaft in its upper half, where no screws are and the rods pass beside it
SLOT_WALL_MM = 1.0  # least metal from the stop pin's slot to the rim and from the pin to the motor's pilot bore


@dataclass(frozen=True)
class CapstanDimensions:
    """Sector, pinion and cable; angles are polar angles about the shoulder in the arm's frame.

    At the larger angle the cable leaves the rim along its tangent. At the smaller one, which passes under the platform,
    the rim ends in a nose round which the cable turns inwards, so that nothing stands above the rim there.
    """

    rim_radius_mm: float
    cable_diameter_mm: float
    pitch_radius_mm: float
    pinion_pitch_radius_mm: float
    pinion_radius_mm: float
    pinion_bore_mm: float
    pinion_bore_depth_mm: float
    pinion_y_mm: tuple[float, float]
    centre_distance_mm: float
    direction_rad: float
    ratio: float
    rim_angles_rad: tuple[float, float]
    hub_radius_mm: float
    nose_radius_mm: float
    turns_rad: tuple[float, float]
    lug_length_mm: float
    lug_radii_mm: tuple[float, float]
    slot_radius_mm: float
    slot_width_mm: float
    slot_angles_rad: tuple[float, float]
    cable_length_mm: float
    keep_out_radius_mm: float

    @property
    def pinion_axis_mm(self) -> tuple[float, float]:
        """(u, z) of the pinion's axis from the shoulder."""
        return self.centre_distance_mm * cos(self.direction_rad), self.centre_distance_mm * sin(self.direction_rad)

    @property
    def nose_centre_mm(self) -> tuple[float, float]:
        """(x, z) of the nose's axis from the shoulder."""
        radius = self.rim_radius_mm - self.nose_radius_mm
        return radius * cos(self.rim_angles_rad[0]), radius * sin(self.rim_angles_rad[0])

    @property
    def nose_bar_radius_mm(self) -> float:
        """Half width of the sector's end below the nose: as far below the cable as the plate lies under a lug."""
        return self.nose_radius_mm + self.cable_diameter_mm / 2 - (self.pitch_radius_mm - self.lug_radii_mm[0])


def capstan_dimensions(
    pitch_radius_mm: float,
    ratio: float,
    shoulder_rad: tuple[float, float],
    layers: Layers,
    cable: catalogue.Cable,
    motor: catalogue.Motor,
    stop_pin_mm: float,
    slot_radius_mm: float,
    shaft_mm: float,
) -> CapstanDimensions:
    """Dimensions a capstan for a range of shoulder angles.

    The sector covers the pinion at every shoulder angle in the range, with the stop margin and room for the lugs of
    the tension screws at both ends; the arc slot around the stop pin ends exactly the stop margin outside the range.

    Args:
        pitch_radius_mm: Radius of the cable's middle on the sector.
        ratio: Turns of the pinion per turn of the arm.
        shoulder_rad: Smallest and largest shoulder angle over the cube.
        layers: Stack along the shoulder axis.
        cable: Row of the catalogue.
        motor: Row of the catalogue.
        stop_pin_mm: Diameter of the stop pin.
        slot_radius_mm: Distance of the stop pin from the shoulder axis.
        shaft_mm: Diameter of the shoulder shaft.

    Raises:
        DimensionError: The pinion gets too thin for the motor's shaft, the shaft is too short, the sector is too small
            for the stop pin's slot or would have to go round more than 250 degrees.
    """
    d = cable.diameter_mm
    rim_radius_mm = pitch_radius_mm - d / 2
    pinion_pitch = pitch_radius_mm / ratio
    crest = pinion_pitch - d / 2 + GROOVE_FRACTION * d
    bore = motor.shaft_diameter_mm
    wall = pinion_pitch - d / 2 - bore / 2
    require(
        wall >= PINION_WALL_MM,
        "pinion",
        "wall",
        f"{wall:.2f} mm over the shaft of {bore:g} mm; at least {PINION_WALL_MM:g} mm: "
        f"hardware.capstan_ratio must be <= {pitch_radius_mm / (bore / 2 + PINION_WALL_MM + d / 2):.2f}",
    )
    face = layers.motor_cheek_mm[1]
    y = (layers.sector_mm[0] - 0.5, face - motor.pilot_height_mm - 0.5)
    shaft_end = face - motor.shaft_length_mm
    floor = shaft_end - 0.5 if shaft_end - 0.5 > y[0] + 0.5 else y[0]  # a longer shaft comes out of the sleeve
    engaged = y[1] - max(floor, shaft_end)
    require(
        engaged >= SHAFT_ENGAGEMENT_MM,
        "pinion",
        "bore",
        f"the motor's shaft of {motor.shaft_length_mm:g} mm engages {engaged:.1f} mm; at least {SHAFT_ENGAGEMENT_MM:g}",
    )
    distance = rim_radius_mm + crest + GAP_MM
    slot_width = stop_pin_mm + 1.0
    to_pilot = slot_radius_mm + (stop_pin_mm + motor.pilot_diameter_mm) / 2 + SLOT_WALL_MM
    least = max(
        slot_radius_mm + slot_width / 2 + SLOT_WALL_MM + d / 2,
        (to_pilot - GAP_MM + (1.0 - GROOVE_FRACTION) * d) / (1.0 + 1.0 / ratio),  # distance >= to_pilot
    )
    require(
        pitch_radius_mm >= least,
        "sector",
        "slot",
        f"hardware.sector_radius_mm = {pitch_radius_mm:g} must be at least {least:.1f} mm, or the stop pin's slot on "
        f"radius {slot_radius_mm:g} cuts the rim, or the pin the motor's pilot bore",
    )
    lug = (rim_radius_mm - 3.2, rim_radius_mm + 3.6)
    near = crest + RUNNING_GAP_MM  # closest that a lug may come to the pinion's axis
    aside = acos((distance**2 + lug[1] ** 2 - near**2) / (2 * distance * lug[1]))
    direction = PINION_DIRECTION_RAD
    reach = (direction - shoulder_rad[1] - STOP_MARGIN_RAD, direction - shoulder_rad[0] + STOP_MARGIN_RAD)
    rim = (reach[0] - RIM_BEYOND_MM / pitch_radius_mm, reach[1] + aside)
    require(
        rim[1] - rim[0] <= radians(250.0),
        "sector",
        "angle",
        f"the shoulder turns {(shoulder_rad[1] - shoulder_rad[0]) * 180 / pi:.1f} deg; the sector would span "
        f"{(rim[1] - rim[0]) * 180 / pi:.0f} deg, at most 250",
    )
    play = (slot_width - stop_pin_mm) / 2 / slot_radius_mm
    lug_length = 6.0
    head = 2.0 + 1.7 + 3.0  # lock nut, screw head and crimp sleeve
    return CapstanDimensions(
        rim_radius_mm=rim_radius_mm,
        cable_diameter_mm=d,
        pitch_radius_mm=pitch_radius_mm,
        pinion_pitch_radius_mm=pinion_pitch,
        pinion_radius_mm=crest,
        pinion_bore_mm=bore,
        pinion_bore_depth_mm=y[1] - floor,
        pinion_y_mm=y,
        centre_distance_mm=distance,
        direction_rad=direction,
        ratio=ratio,
        rim_angles_rad=rim,
        hub_radius_mm=shaft_mm / 2 + HUB_WALL_MM,
        nose_radius_mm=NOSE_RADIUS_MM,
        turns_rad=(NOSE_TURN_RAD, 0.0),
        lug_length_mm=lug_length,
        lug_radii_mm=lug,
        slot_radius_mm=slot_radius_mm,
        slot_width_mm=slot_width,
        slot_angles_rad=(reach[0] + play, reach[1] - play),
        cable_length_mm=pitch_radius_mm * (rim[1] - rim[0])
        + (NOSE_RADIUS_MM + d / 2) * NOSE_TURN_RAD
        + 2 * (lug_length + head)
        + PINION_WRAPS * tau * pinion_pitch,
        keep_out_radius_mm=hypot(lug[1], lug_length + head),
    )
