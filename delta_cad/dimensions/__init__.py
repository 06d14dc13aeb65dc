"""Design -> every dimension of every part, in millimetres; the only place where metres become millimetres.

One record a group of parts, each in a file of its own with the function that derives it; `dimensions` derives all.
No CAD kernel is loaded here.

Frames: the chain's (u, t, z) is radial, tangential (along the shoulder axis), up, from the base centre; the arm's
(x, y, z) is along the arm, along the shoulder axis, square to both, from the shoulder.
"""

from __future__ import annotations

from dataclasses import dataclass

from delta_cad import catalogue
from delta_cad.common.units import MM_PER_M
from delta_cad.design import Design
from delta_cad.dimensions.arm import ArmDimensions, ShaftDimensions, arm_dimensions, shaft_dimensions
from delta_cad.dimensions.bracket import STOP_PIN_MM, BracketDimensions, bracket_dimensions
from delta_cad.dimensions.capstan import CapstanDimensions, capstan_dimensions
from delta_cad.dimensions.forearm import CROSS_BAR_MM, ForearmDimensions, forearm_dimensions
from delta_cad.dimensions.layers import Layers, layers
from delta_cad.dimensions.platform import BaseDimensions, PlatformDimensions, base_dimensions, platform_dimensions
from delta_cad.dimensions.rules import STOP_MARGIN_RAD, DimensionError
from delta_cad.mechanism.workspace import Cube, CubeExtremes, cube_extremes

__all__ = ["DimensionError", "Dimensions", "dimensions"]


@dataclass(frozen=True)
class Dimensions:
    """All dimensions of a design, and the motion and catalogue rows they were derived from."""

    design: Design
    extremes: CubeExtremes
    layers: Layers
    arm: ArmDimensions
    capstan: CapstanDimensions | None
    bracket: BracketDimensions
    shaft: ShaftDimensions
    forearm: ForearmDimensions
    platform: PlatformDimensions
    base: BaseDimensions
    motor: catalogue.Motor
    bearing: catalogue.Bearing
    encoder: catalogue.Encoder
    cable: catalogue.Cable
    tube: catalogue.Tube
    knob: catalogue.Knob
    foot: catalogue.Foot
    magnet: catalogue.Magnet

    @property
    def stops_rad(self) -> tuple[float, float]:
        """Shoulder angles at which the stop pins are met."""
        return (
            self.extremes.shoulder_min.value - STOP_MARGIN_RAD,
            self.extremes.shoulder_max.value + STOP_MARGIN_RAD,
        )


def dimensions(design: Design) -> Dimensions:
    """Derives all dimensions of a design.

    Raises:
        UnreachableError: A point of the cube is out of reach.
        DimensionError: A part cannot be given sound dimensions.
    """
    mechanism, hardware = design.mechanism, design.hardware
    cube = Cube(design.cube.bottom_height_mm / MM_PER_M, design.cube.half_side_mm / MM_PER_M)
    extremes = cube_extremes(design.geometry, cube, design.requirements.force_N)
    shoulder = (extremes.shoulder_min.value, extremes.shoulder_max.value)
    motor = catalogue.motor.chosen(hardware)
    bearing = catalogue.bearing.chosen(hardware)
    encoder, magnet = catalogue.encoder.chosen(hardware), catalogue.magnet.chosen(hardware)
    cable, tube, knob = (
        catalogue.cable.chosen(hardware),
        catalogue.tube.chosen(hardware),
        catalogue.knob.chosen(hardware),
    )
    stack = layers(hardware.arm_thickness_mm, hardware.drive, bearing, encoder, motor)
    shaft_mm = bearing.bore_mm if hardware.drive == "capstan" else motor.shaft_diameter_mm
    arm = arm_dimensions(mechanism.upper_arm_length_mm, shaft_mm, CROSS_BAR_MM, stack, bearing)
    capstan = None
    if hardware.drive == "capstan":
        capstan = capstan_dimensions(
            hardware.sector_radius_mm,
            hardware.capstan_ratio,
            shoulder,
            stack,
            cable,
            motor,
            STOP_PIN_MM,
            arm.flange_radius_mm + STOP_PIN_MM / 2 + 6.0,
            shaft_mm,
        )
    half_width = max(-stack.encoder_cheek_mm[0], stack.motor_cheek_mm[1])
    bracket = bracket_dimensions(
        mechanism.base_radius_mm,
        shoulder,
        extremes.elbow_z_min.value * MM_PER_M,
        hardware.base_plate_thickness_mm,
        half_width,
        arm,
        capstan,
        bearing,
        motor,
    )
    forearm = forearm_dimensions(
        mechanism.forearm_length_mm,
        mechanism.parallelogram_width_mm,
        hardware.ball_diameter_mm,
        stack.elbow_boss_mm[1] - stack.elbow_boss_mm[0],
        tube,
    )
    return Dimensions(
        design=design,
        extremes=extremes,
        layers=stack,
        arm=arm,
        capstan=capstan,
        bracket=bracket,
        shaft=shaft_dimensions(shaft_mm, hardware.drive, stack, encoder, magnet),
        forearm=forearm,
        platform=platform_dimensions(mechanism.platform_radius_mm, hardware.platform_thickness_mm, forearm, knob),
        base=base_dimensions(bracket, hardware.base_plate_thickness_mm, half_width),
        motor=motor,
        bearing=bearing,
        encoder=encoder,
        cable=cable,
        tube=tube,
        knob=knob,
        foot=catalogue.foot.chosen(hardware),
        magnet=magnet,
    )
