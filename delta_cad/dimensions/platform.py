"""The moving platform and its handle, and the base plate (both centred on the z axis)."""

from __future__ import annotations

from dataclasses import dataclass
from math import atan2, ceil, cos, floor, hypot, pi, radians, sin

from delta_cad import catalogue
from delta_cad.dimensions.bracket import PLATE_RIM_MM, BracketDimensions, Circle
from delta_cad.dimensions.forearm import BAR_BEYOND_MM, BAR_GLUE_MM, BAR_WALL_MM, ForearmDimensions
from delta_cad.dimensions.rules import (
    BASE,
    DRILL_DIAMETERS,
    PLATFORM,
    PLATFORM_THICKNESS,
    WIDTH,
    ceil_sig,
    larger,
    require,
    smaller,
)
from delta_cad.dimensions.sizes import plate_mm, stem_mm
from delta_cad.mechanism.placement import CHAINS

BASE_SCREW = "M4"  # foot blocks on the base plate
_UNDER_HEAD_MM = 1.0  # least metal between a counterbore and the far face


BOSS_BEVEL_MM = 0.4  # on the wrist bosses
STEM_FLATS_MM, STEM_FLATS_Z_MM = 8.0, (2.0, 8.0)  # for a spanner: across them, and from where to where of the stem
MOUNT_SPREAD_RAD = radians(18.0)  # mounting holes beside the feet
_FLAT_LEAST_MM = 45.0  # from the plate's centre: beside a hole for the cables, feet that do not tip at once
_FOOT_RIM_MM, _MOUNT_RIM_MM = 10.0, 8.0  # from the axis of a foot, and of a mounting hole, to the plate's edge
_HOLE_RIM_MM = 8.0  # around the hole in the middle
_WINDOW_MM, _WINDOW_LEAST_MM, _WINDOW_RIM_MM = 34.0, 12.0, 5.0  # holes that lighten the plate
_PLATE_MM = 5.0  # the least; it grows with loads and lengths
_STEM_WALL_MM = 3.0  # of the hub around the stem
RIB_MM = 4.0  # width of what stays around a window of it
_WINDOW_LONG_MM, _WINDOW_REACH_MM, _WINDOW_CORNER_MM = (
    4.0,
    3.0,
    1.5,
)  # of these windows: least length, half width; corners
WEB_CORNER_MM = 5.0, 3.0  # of a web, which ends so much inside its boss's ends, in corners of such a radius
_BOSS_LEAST_MM = 2 * WEB_CORNER_MM[0]  # length of a wrist boss, at whose ends its web's corners lie
LENGTH_MM = 1e-9  # roundings of a length that is asked


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

    @property
    def web_mm(self) -> tuple[Circle, ...]:
        """Circles (x, y, radius) whose hull the plate is from the hub to chain 0's boss."""
        aside, corner = self.boss_length_mm / 2 - WEB_CORNER_MM[0], WEB_CORNER_MM[1]
        u = self.radius_mm
        return (0.0, 0.0, self.hub_radius_mm), (u, aside, corner), (u, -aside, corner)

    @property
    def window_reach_mm(self) -> tuple[float, float, float] | None:
        """From where to where the window in it goes along x, and how far aside; None where there is no room."""
        near, far = self.hub_radius_mm + RIB_MM, self.radius_mm - self.boss_diameter_mm / 2 - 1.0
        reach = (self.boss_length_mm / 2 - WEB_CORNER_MM[0]) * far / self.radius_mm - RIB_MM
        return (near, far, reach) if far - near >= _WINDOW_LONG_MM and reach >= _WINDOW_REACH_MM else None

    @property
    def window_mm(self) -> tuple[Circle, ...]:
        """Circles whose hull this window is; none where there is no room."""
        if self.window_reach_mm is None:
            return ()
        (near, far, reach), r = self.window_reach_mm, _WINDOW_CORNER_MM
        return (near + r, 0.0, r), (far - r, reach - r, r), (far - r, r - reach, r)


@dataclass(frozen=True)
class BaseDimensions:
    """Base plate under the three foot blocks: a disc, or six-sided where that would stand out alone between the chains.

    Attributes:
        radius_mm: Of the disc, which holds the six-sided one, too.
        rim_mm: Circles (x, y, radius) whose hull the six-sided plate is; empty for a disc.
        thickness_mm: Of the plate.
        top_mm: Height of its upper face in the base frame.
        centre_hole_mm: Diameter of the hole in its middle.
        window_mm: Diameter of the holes that lighten it, between the chains; 0 where there is no room.
        foot_circle_mm: Diameter on which the rubber feet stand.
        mount_circle_mm: The same of the mounting holes, beside the feet.
        mount_hole_mm: Diameter of these.
    """

    radius_mm: float
    rim_mm: tuple[Circle, ...]
    thickness_mm: float
    top_mm: float
    centre_hole_mm: float
    window_mm: float
    foot_circle_mm: float
    mount_circle_mm: float
    mount_hole_mm: float

    @property
    def holes_mm(self) -> list[Circle]:
        """Circles (x, y, radius) of the large holes: that in the middle, and those between the chains."""
        out, angles = (self.centre_hole_mm + self.foot_circle_mm) / 4, [pi / 3 + i * 2 * pi / 3 for i in CHAINS]
        windows = [(out * cos(a), out * sin(a), self.window_mm / 2) for a in angles if self.window_mm]
        return [(0.0, 0.0, self.centre_hole_mm / 2), *windows]

    @property
    def reach_mm(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """From where to where the plate lies along x and y."""
        rim = self.rim_mm or ((0.0, 0.0, self.radius_mm),)
        (x0, x1), (y0, y1) = ((min(c[k] - c[2] for c in rim), max(c[k] + c[2] for c in rim)) for k in (0, 1))
        return (x0, x1), (y0, y1)


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
            of one another, or a boss would run into the hub; so thick that rods which lean leave its bosses no length.
    """
    least = forearm.bar_diameter_mm + 2 * BAR_WALL_MM
    require(
        thickness_mm >= least,
        "platform",
        "wrist boss",
        f"{thickness_mm:g} mm are too thin around the cross-bar; at least {least:g}",
        larger(PLATFORM_THICKNESS),
    )
    stem = stem_mm(grown)
    hub = stem / 2 + _STEM_WALL_MM
    require(
        radius_mm >= hub + thickness_mm / 2 + 2.0,
        "platform",
        "wrist boss",
        f"on a radius of {radius_mm:g} mm it meets the hub; at least {hub + thickness_mm / 2 + 2.0:g} mm",
        larger(PLATFORM),
    )
    require(
        radius_mm >= forearm.wrist_radius_min_mm,
        "platform",
        "wrists",
        f"neighbouring cups come within the clearance on a radius of {radius_mm:g} mm; at least "
        f"{ceil_sig(forearm.wrist_radius_min_mm)} mm",
        larger(PLATFORM),
        larger(BASE, PLATFORM),
        smaller(WIDTH),
    )
    # A boss's edge comes as near as `b cos(tilt) - r sin(tilt)` to the axis of a rod that hangs b beside its end.
    tilt, needed = forearm.tilt_limit_rad, forearm.tube_outer_mm / 2 + forearm.room_mm
    adjacent = (needed + thickness_mm / 2 * sin(tilt)) / cos(tilt)
    length = forearm.width_mm - 2 * adjacent
    ways = smaller(PLATFORM_THICKNESS), larger(WIDTH)
    message = f"rods that lean leave its wrists' bosses {max(length, 0.0):.1f} mm; at least {_BOSS_LEAST_MM:g}"
    require(length >= _BOSS_LEAST_MM - LENGTH_MM, "platform", "wrist boss, length", message, *ways)
    bore = forearm.bar_diameter_mm + 2 * BAR_GLUE_MM
    return PlatformDimensions(
        radius_mm=radius_mm,
        boss_diameter_mm=thickness_mm,
        boss_length_mm=min(
            forearm.bar_length_mm - 2 * max(BAR_BEYOND_MM, forearm.cone_mm),
            length,
            float(floor(DRILL_DIAMETERS * bore)),
        ),
        bar_bore_mm=bore,
        plate_mm=plate_mm(_PLATE_MM, grown),
        hub_radius_mm=hub,
        stem_diameter_mm=stem,
        stem_length_mm=25.0,
        stem_thread=knob.thread,
    )


def base_dimensions(
    bracket: BracketDimensions, thickness_mm: float, half_width_mm: float, behind_mm: float
) -> BaseDimensions:
    """Dimensions a base plate that carries the brackets' feet with a rim of 4 mm at least.

    Args:
        bracket: Brackets, screwed on from below.
        thickness_mm: Thickness of the plate.
        half_width_mm: How far the brackets reach aside of their chain's plane.
        behind_mm: How far arms and motors reach behind the base's centre, opposite to a chain: so far the plate may.

    Raises:
        DimensionError: The screws' counterbores leave too little under their heads.
    """
    least = catalogue.screw(BASE_SCREW).counterbore_depth_mm + _UNDER_HEAD_MM
    require(
        thickness_mm >= least,
        "base_plate",
        "counterbore",
        f"{thickness_mm:g} mm leave too little under the screws' heads; at least {least:g} mm",
        larger("hardware.base_plate_thickness_mm"),
    )
    radius = ceil(hypot(bracket.foot_u_mm[1], half_width_mm) + PLATE_RIM_MM)
    flat = float(min(radius, max(floor(behind_mm), _FLAT_LEAST_MM)))
    adjacent = flat - _FOOT_RIM_MM  # of the feet, from the centre
    hole = min(bracket.foot_u_mm[0] - _HOLE_RIM_MM, adjacent - _HOLE_RIM_MM)
    room = 2 * floor((adjacent - hole) / 2 - _WINDOW_RIM_MM)
    mount, rim = radius - _MOUNT_RIM_MM, list[Circle]()
    if flat < radius:
        mount = (flat - _MOUNT_RIM_MM) / cos(MOUNT_SPREAD_RAD)
        corner = atan2(half_width_mm, bracket.foot_u_mm[1])
        for i in CHAINS:
            for off, out, wide in (
                (corner, hypot(bracket.foot_u_mm[1], half_width_mm), PLATE_RIM_MM),
                (pi / 3 - MOUNT_SPREAD_RAD, mount, _MOUNT_RIM_MM),
            ):
                ways = (side * off + 2 * pi / 3 * i for side in (-1, 1))
                rim += [(out * cos(way), out * sin(way), wide) for way in ways]
    return BaseDimensions(
        radius_mm=radius,
        rim_mm=tuple(rim),
        thickness_mm=thickness_mm,
        top_mm=bracket.base_top_mm,
        centre_hole_mm=float(floor(2 * hole)),
        window_mm=0.0 if room < _WINDOW_LEAST_MM else min(_WINDOW_MM, room),
        foot_circle_mm=2 * adjacent,
        mount_circle_mm=2 * mount,
        mount_hole_mm=5.5,
    )
