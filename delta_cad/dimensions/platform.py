"""The moving platform and its handle, and the base plate (both centred on the z axis)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import atan2, ceil, cos, floor, hypot, radians, sin, tau

from delta_cad import catalogue
from delta_cad.design.stands import EVEN, EVEN_DEG, Gap, narrowest_gap
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

BASE_SCREW = "M4"  # foot blocks on the base plate
_UNDER_HEAD_MM = 1.0  # least metal between a counterbore and the far face


WRIST_MARK = "0"  # punched on the boss of wrist 0 where chains are placed: the platform fits in one position only
BOSS_BEVEL_MM = 0.4  # on the wrist bosses
STEM_FLATS_MM, STEM_FLATS_Z_MM = 8.0, (2.0, 8.0)  # for a spanner: across them, and from where to where of the stem
MOUNT_SCREW = "M5"  # that holds the base plate down
_MOUNT_SPREAD_RAD, _EVEN_RAD = radians(18.0), radians(60.0)  # mounting holes beside the feet, in a gap of twice that
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
    """Base plate under the three foot blocks: discs about the stands, or six-sided where these would stand out alone.

    Attributes:
        radius_mm: Of the disc about a stand, which holds its block with a rim.
        rim_mm: Circles (x, y, radius) whose hull the plate is; empty for one disc, where no chain stands farther out.
        thickness_mm: Of the plate.
        top_mm: Height of its upper face in the base frame.
        centre_hole_mm: Diameter of the hole in its middle.
        window_mm: Diameter of the holes that lighten it, between the chains; 0 where there is no room.
        foot_circle_mm: Diameter on which the rubber feet stand.
        between_rad: Azimuths of the feet, half-way between the chains.
        mount_circle_mm: Diameter on which the mounting holes are, beside the feet.
        mount_spread_rad: Angle between a mounting hole and the foot beside it.
        mount_hole_mm: Diameter of these.
    """

    radius_mm: float
    rim_mm: tuple[Circle, ...]
    thickness_mm: float
    top_mm: float
    centre_hole_mm: float
    window_mm: float
    foot_circle_mm: float
    between_rad: tuple[float, ...]
    mount_circle_mm: float
    mount_spread_rad: float
    mount_hole_mm: float

    @property
    def feet_mm(self) -> list[tuple[float, float]]:
        """(x, y) of the feet, half-way between the chains."""
        return self._between_chains(self.foot_circle_mm / 2)

    @property
    def mounts_mm(self) -> list[tuple[float, float]]:
        """(x, y) of the mounting holes, one on either side of each foot."""
        radius, spread = self.mount_circle_mm / 2, self.mount_spread_rad
        return [at for sign in (-1, 1) for at in self._between_chains(radius, sign * spread)]

    def _between_chains(self, radius: float, spread: float = 0.0) -> list[tuple[float, float]]:
        return [(radius * cos(a + spread), radius * sin(a + spread)) for a in self.between_rad]

    @property
    def holes_mm(self) -> list[Circle]:
        """Circles (x, y, radius) of the large holes: that in the middle, and those between the chains."""
        out = (self.centre_hole_mm + self.foot_circle_mm) / 4
        windows = [(out * cos(a), out * sin(a), self.window_mm / 2) for a in self.between_rad if self.window_mm]
        return [(0.0, 0.0, self.centre_hole_mm / 2), *windows]

    @property
    def reach_mm(self) -> tuple[tuple[float, float], tuple[float, float]]:
        """From where to where the plate lies along x and y."""
        rim = self.rim_mm or ((0.0, 0.0, self.radius_mm),)
        (x0, x1), (y0, y1) = ((min(c[k] - c[2] for c in rim), max(c[k] + c[2] for c in rim)) for k in (0, 1))
        return (x0, x1), (y0, y1)


def platform_dimensions(
    radius_mm: float,
    thickness_mm: float,
    forearm: ForearmDimensions,
    knob: catalogue.Knob,
    grown: float = 1.0,
    stem_grown: float = 1.0,
) -> PlatformDimensions:
    """Dimensions a platform for a wrist radius; the bosses of its cross-bars are as thick as `thickness_mm`.

    Args:
        radius_mm: Platform centre to wrist.
        thickness_mm: Of the bosses.
        forearm: Whose cross-bars it carries.
        knob: On its stem.
        grown: Second moment of the plate over that of the least, see `sizes.growth`.
        stem_grown: The same of the stem.

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
    stem = stem_mm(stem_grown)
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
    bracket: BracketDimensions,
    thickness_mm: float,
    half_width_mm: float,
    behind_mm: float,
    gaps: Sequence[Gap] = EVEN,
    azimuths_deg: Sequence[float] = EVEN_DEG,
) -> BaseDimensions:
    """Dimensions a base plate that carries the brackets' feet with a rim of 4 mm at least.

    Feet and mounting holes are on circles about the base's axis, in each gap alike.

    Args:
        bracket: Brackets, screwed on from below.
        thickness_mm: Thickness of the plate.
        half_width_mm: How far the brackets reach aside of their chain's plane.
        behind_mm: How far arms and motors reach behind the base's centre, opposite to chain 0: so far the plate may.
        gaps: Of the chains.
        azimuths_deg: Of the chains.

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
    azimuths, out = [radians(angle) for angle in azimuths_deg], gaps[0].next_out_mm
    between = tuple((one + after) / 2 for one, after in pairwise([*azimuths, tau]))
    halves = [radians((after - one) / 2) for one, after in pairwise([*azimuths_deg, 360.0])]
    stands = [(cos(a) * off, sin(a) * off) for a, off in zip(azimuths, (0.0, out, out), strict=True)]
    spread = _MOUNT_SPREAD_RAD * (min(halves) / _EVEN_RAD)
    radius = ceil(hypot(bracket.foot_u_mm[1], half_width_mm) + PLATE_RIM_MM)
    behind = max(floor(behind_mm), _FLAT_LEAST_MM)
    is_round = behind >= radius - min(stands[1][0], 0.0)
    flat = float(radius if is_round else behind)
    adjacent = flat - _FOOT_RIM_MM  # of the feet, from the centre
    hole = min(bracket.foot_u_mm[0] + min(out, 0.0) - _HOLE_RIM_MM, adjacent - _HOLE_RIM_MM)
    lacking = EVEN[0].half_sine - narrowest_gap(gaps).half_sine  # of the way aside between even chains, as a share
    narrower = (hole + adjacent) / 2 * lacking
    room = 2 * floor((adjacent - hole) / 2 - _WINDOW_RIM_MM - narrower)
    mount, rim = radius - _MOUNT_RIM_MM, list[Circle]()
    if not is_round:
        mount = (flat - _MOUNT_RIM_MM) / cos(spread)
        corner, far = atan2(half_width_mm, bracket.foot_u_mm[1]), hypot(bracket.foot_u_mm[1], half_width_mm)
        for i, (azimuth, (x, y)) in enumerate(zip(azimuths, stands, strict=True)):
            for before, after, (x0, y0), reach, wide in (
                (corner, corner, (x, y), far, PLATE_RIM_MM),
                (halves[i - 1] - spread, halves[i] - spread, (0.0, 0.0), mount, _MOUNT_RIM_MM),
            ):
                ways = azimuth - before, azimuth + after
                rim += [(x0 + reach * cos(way), y0 + reach * sin(way), wide) for way in ways]
    elif out > 0.0:
        rim = [(x, y, float(radius)) for x, y in stands]
    return BaseDimensions(
        radius_mm=radius,
        rim_mm=tuple(rim),
        thickness_mm=thickness_mm,
        top_mm=bracket.base_top_mm,
        centre_hole_mm=float(floor(2 * hole)),
        window_mm=0.0 if room < _WINDOW_LEAST_MM else min(_WINDOW_MM, room),
        foot_circle_mm=2 * adjacent,
        between_rad=between,
        mount_circle_mm=2 * mount,
        mount_spread_rad=spread,
        mount_hole_mm=catalogue.screw(MOUNT_SCREW).clearance_hole_mm,
    )
