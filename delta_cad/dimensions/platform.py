"""The moving platform and its handle, and the base plate (both centred on the z axis)."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, cos, floor, hypot, radians, sin

from delta_cad import catalogue
from delta_cad.dimensions.bracket import PLATE_RIM_MM, BracketDimensions
from delta_cad.dimensions.forearm import BAR_GLUE_MM, BAR_WALL_MM, ROOM_MM, ForearmDimensions
from delta_cad.dimensions.rules import require
from delta_cad.dimensions.sizes import plate_mm, stem_mm

BASE_SCREW = "M4"  # foot blocks on the base plate
UNDER_HEAD_MM = 1.0  # least metal between a counterbore and the far face


BAR_BEYOND_MM = 1.0  # of a cross-bar from its boss, at least: its cones are not bonded
BOSS_BEVEL_MM = 0.4  # on the wrist bosses
STEM_FLATS_MM, STEM_FLATS_Z_MM = 8.0, (2.0, 8.0)  # for a spanner: across them, and from where to where of the stem
PLATE_MM = 5.0  # the least; it grows with loads and lengths
STEM_WALL_MM = 3.0  # of the hub around the stem
MOUNT_SPREAD_RAD = radians(18.0)  # mounting holes beside the feet


@dataclass(frozen=True)
class PlatformDimensions:
    """Platform plate with three wrist bosses, and the handle on it."""

    radius_mm: float
    boss_diameter_mm: float
    boss_length_mm: float
    bar_bore_mm: float
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
    radius_mm: float, thickness_mm: float, forearm: ForearmDimensions, knob: catalogue.Knob, grown: float = 1.0
) -> PlatformDimensions:
    """Dimensions a platform for a wrist radius; the bosses of its cross-bars are as thick as `thickness_mm`.

    Args:
        radius_mm: Platform centre to wrist.
        thickness_mm: Of the bosses.
        forearm: Whose cross-bars it carries.
        knob: On its stem.
        grown: Second moments of plate and stem over those of the least, see `sizes.growth`.

    Raises:
        DimensionError: Too thin around the cross-bars; the cups of neighbouring chains would come within the clearance
            of one another, or a boss would run into the hub.
    """
    least = forearm.bar_diameter_mm + 2 * BAR_WALL_MM
    require(
        thickness_mm >= least,
        "platform",
        "wrist boss",
        f"hardware.platform_thickness_mm = {thickness_mm:g} must be at least {least:g} mm around the cross-bar",
        "hardware.platform_thickness_mm",
        thickness_mm,
        least,
    )
    stem = stem_mm(grown)
    hub = stem / 2 + STEM_WALL_MM
    require(
        radius_mm >= hub + thickness_mm / 2 + 2.0,
        "platform",
        "wrist boss",
        f"platform_radius_mm = {radius_mm:g} must be at least {hub + thickness_mm / 2 + 2.0:g} mm",
        "mechanism.platform_radius_mm",
        radius_mm,
        hub + thickness_mm / 2 + 2.0,
    )
    require(
        radius_mm >= forearm.wrist_radius_min_mm,
        "platform",
        "wrists",
        f"platform_radius_mm = {radius_mm:g} must be at least {forearm.wrist_radius_min_mm:.2f} mm, or neighbouring "
        f"cups come within the clearance at parallelogram_width_mm = {forearm.width_mm:g}",
        "mechanism.platform_radius_mm",
        radius_mm,
        forearm.wrist_radius_min_mm,
    )
    # A boss's edge comes as near as `b cos(tilt) - r sin(tilt)` to the axis of a rod that hangs b beside its end.
    tilt, needed = forearm.tilt_limit_rad, forearm.tube_outer_mm / 2 + ROOM_MM
    beside = (needed + thickness_mm / 2 * sin(tilt)) / cos(tilt)
    return PlatformDimensions(
        radius_mm=radius_mm,
        boss_diameter_mm=thickness_mm,
        boss_length_mm=min(
            forearm.bar_length_mm - 2 * max(BAR_BEYOND_MM, forearm.cone_mm), forearm.width_mm - 2 * beside
        ),
        bar_bore_mm=forearm.bar_diameter_mm + 2 * BAR_GLUE_MM,
        plate_mm=plate_mm(PLATE_MM, grown),
        hub_radius_mm=hub,
        stem_diameter_mm=stem,
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
        "hardware.base_plate_thickness_mm",
        thickness_mm,
        least,
    )
    radius = ceil(hypot(bracket.foot_u_mm[1], half_width_mm) + PLATE_RIM_MM)
    return BaseDimensions(
        radius_mm=radius,
        thickness_mm=thickness_mm,
        top_mm=bracket.base_top_mm,
        centre_hole_mm=float(floor(2 * (bracket.foot_u_mm[0] - 8.0))),
        foot_circle_mm=2 * (radius - 10.0),
        mount_circle_mm=2 * (radius - 8.0),
        mount_hole_mm=5.5,
    )
