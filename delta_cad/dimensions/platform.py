"""The moving platform and its handle, and the base plate (both centred on the z axis)."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, hypot

from delta_cad import catalogue
from delta_cad.dimensions.bracket import PLATE_RIM_MM, BracketDimensions
from delta_cad.dimensions.forearm import ForearmDimensions
from delta_cad.dimensions.rules import require
from delta_cad.mechanism.geometry import SIN_60

BASE_SCREW = "M4"  # foot blocks on the base plate
UNDER_HEAD_MM = 1.0  # least metal between a counterbore and the far face


BOSS_BEVEL_MM = 1.5  # on the wrist bosses: makes room for the tilted sockets


@dataclass(frozen=True)
class PlatformDimensions:
    """Platform plate with three wrist bosses, and the handle on it."""

    radius_mm: float
    boss_diameter_mm: float
    boss_length_mm: float
    plate_mm: float
    hub_radius_mm: float
    stem_diameter_mm: float
    stem_length_mm: float
    stem_thread: str


@dataclass(frozen=True)
class BaseDimensions:
    """Base plate: a disc under the three foot blocks."""

    radius_mm: float
    thickness_mm: float
    top_mm: float
    centre_hole_mm: float
    foot_circle_mm: float
    mount_circle_mm: float
    mount_hole_mm: float


def platform_dimensions(
    radius_mm: float, thickness_mm: float, forearm: ForearmDimensions, knob: catalogue.Knob
) -> PlatformDimensions:
    """Dimensions a platform for a wrist radius; its wrist bosses are as thick as `thickness_mm`.

    Raises:
        DimensionError: The bosses of neighbouring chains would run through one another or through the hub.
    """
    boss = forearm.bar_length_mm
    face = forearm.collar_diameter_mm + 2 * BOSS_BEVEL_MM
    require(
        thickness_mm >= face,
        "platform",
        "wrist boss",
        f"hardware.platform_thickness_mm = {thickness_mm:g} must be at least {face:g} mm: stud collar and bevel",
    )
    hub = 8.0
    require(
        radius_mm >= hub + thickness_mm / 2 + 2.0,
        "platform",
        "wrist boss",
        f"platform_radius_mm = {radius_mm:g} must be at least {hub + thickness_mm / 2 + 2.0:g} mm",
    )
    # In the frame of the wrist, the neighbour's boss ends where its axis comes within (r sqrt 3 - l / 2) of ours.
    free = 2 * SIN_60 * radius_mm - boss / 2
    require(
        free >= thickness_mm / 2 + forearm.socket_outer_mm / 2,
        "platform",
        "wrist boss",
        f"bosses of {boss:g} mm meet at platform_radius_mm = {radius_mm:g}; it must be at least "
        f"{(thickness_mm / 2 + forearm.socket_outer_mm / 2 + boss / 2) / (2 * SIN_60):.1f} mm",
    )
    return PlatformDimensions(
        radius_mm=radius_mm,
        boss_diameter_mm=thickness_mm,
        boss_length_mm=boss,
        plate_mm=3.0,
        hub_radius_mm=hub,
        stem_diameter_mm=10.0,
        stem_length_mm=25.0,
        stem_thread=knob.thread,
    )


def base_dimensions(bracket: BracketDimensions, thickness_mm: float, half_width_mm: float) -> BaseDimensions:
    """Dimensions a base plate that carries the brackets' feet with a rim of 4 mm at least.

    Args:
        bracket: Brackets, screwed on from below.
        thickness_mm: Thickness of the plate.
        half_width_mm: How far the brackets reach aside of their chain's plane.

    Raises:
        DimensionError: The screws' counterbores leave too little under their heads.
    """
    least = catalogue.screw(BASE_SCREW).counterbore_depth_mm + UNDER_HEAD_MM
    require(
        thickness_mm >= least,
        "base_plate",
        "counterbore",
        f"hardware.base_plate_thickness_mm = {thickness_mm:g} must be at least {least:g} mm",
    )
    radius = ceil(hypot(bracket.foot_u_mm[1], half_width_mm) + PLATE_RIM_MM)
    return BaseDimensions(
        radius_mm=radius,
        thickness_mm=thickness_mm,
        top_mm=bracket.base_top_mm,
        centre_hole_mm=2 * (bracket.foot_u_mm[0] - 8.0),
        foot_circle_mm=2 * (radius - 10.0),
        mount_circle_mm=2 * (radius - 8.0),
        mount_hole_mm=5.5,
    )
