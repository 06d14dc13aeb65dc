"""The dashboard's panel over the machine: opening, bezel, boot, and the stem that passes them.

Everything lies about the cube's middle, seen from above, the origin here. The handle does not turn: x and y go from -L
to L whatever its height. What a stem of radius r passes of a level plane is therefore exactly the square of half side L
with a disc of radius r around each of its points, and what keeps a distance g from that, the same square with discs of
`r + g`. So every outline here is a square with round corners about the same four centres (+-L, +-L); each is told by
its radius alone.

The bezel's edge is met by the stem alone: the platform stays below the panel, the knob and the boot's collar above it.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, hypot, pi, sqrt

from delta_cad import catalogue
from delta_cad.design import Design
from delta_cad.dimensions.platform import PlatformDimensions
from delta_cad.dimensions.rules import another, require
from delta_cad.dimensions.tolerances import drilled_mm, tip_mm

TEMPLATE = "panel_template"  # name of the files that a panel is cut by
SCREW = "M3"  # bezel on the panel, from below: nothing is seen of them
CLOTH_MM = 0.6  # coated cloth, as it is clamped
_CLOTH_G_M2 = 250.0  # polyamide coated with polyurethane or neoprene; estimate
_EASE = 1.03  # of the cloth's length over the longest way: it is never taut
LIP_MM = 1.0  # of the bezel over the panel's edge, which the stem must not meet
_NEXT_TO_SCREW_MM = 6.0  # from a screw's axis to the opening, and to the bezel's rim
_AROUND_MM = 5.0  # of the panel around the bezel that is drawn
_APART_MM = 80.0  # of neighbouring screws, at most
_UNDER_TIP_MM = 1.0  # of the bezel over the tips of its bores
MARGIN_MM = 0.5  # beyond a clearance, for what is drawn round by flats; and of a thread beyond its screw
COLLAR_MM = (2.0, 8.0)  # the boot's collar on the stem: wall with its tie, and height
_UNDER_KNOB_MM = 1.0  # from the collar to the knob
_STEP_MM = 0.5  # heights are whole steps
_SQUEEZE_MM = 0.5  # by which a foot gives way to the sleeve beside it
SLEEVE_WALL_MM = 2.25
_SLEEVE_LEAST_MM = 2.0


@dataclass(frozen=True)
class PanelDimensions:
    """Panel, bezel and boot.

    Attributes:
        half_mm: L: the round corners' centres are at (+-L, +-L).
        under_mm: Height of the panel's lower face over the shoulders' plane.
        thickness_mm: Of the panel.
        bezel_mm: Of the bezel.
        stem_radius_mm: Of the stem that passes.
        limit_mm: How far outside the cube the stem meets the bezel, through the cloth.
        thread_mm: Usable depth of the bezel's threads.
        screw_mm: Length of its screws.
        stem_length_mm: From platform to knob.
        collar_mm: From the platform's centre to the collar's lower end.
        cloth_mm: Length of the boot from rim to collar.
        centre_x_mm: Of the opening's middle, the cube's, along the base's x axis.
    """

    half_mm: float
    under_mm: float
    thickness_mm: float
    bezel_mm: float
    stem_radius_mm: float
    limit_mm: float
    thread_mm: float
    screw_mm: float
    stem_length_mm: float
    collar_mm: float
    cloth_mm: float
    centre_x_mm: float = 0.0

    @property
    def edge_mm(self) -> float:
        """Corner radius of the bezel's edge, which the stem meets."""
        return self.stem_radius_mm + self.limit_mm + CLOTH_MM

    @property
    def opening_mm(self) -> float:
        """Corner radius of the panel's opening."""
        return self.edge_mm + LIP_MM

    @property
    def screws_mm(self) -> float:
        """Corner radius of the line that the screws stand on."""
        return self.opening_mm + _NEXT_TO_SCREW_MM

    @property
    def rim_mm(self) -> float:
        """Corner radius of the bezel's outer rim."""
        return self.screws_mm + _NEXT_TO_SCREW_MM

    @property
    def piece_mm(self) -> float:
        """Corner radius of the piece of the panel that is drawn."""
        return self.rim_mm + _AROUND_MM

    @property
    def top_mm(self) -> float:
        """Height of the bezel's upper face over the shoulders' plane."""
        return self.under_mm + self.thickness_mm + CLOTH_MM + self.bezel_mm

    @property
    def collar_radius_mm(self) -> float:
        """Outer radius of the boot's collar."""
        return self.stem_radius_mm + COLLAR_MM[0]

    def area_mm2(self, corner_mm: float) -> float:
        """Area within the outline of a corner radius, mm^2."""
        return 4.0 * self.half_mm**2 + 8.0 * self.half_mm * corner_mm + pi * corner_mm**2

    def screw_places(self) -> list[tuple[float, float]]:
        """(x, y) of the bezel's screws: at the corners, and between them where these are far apart."""
        at = round(self.half_mm + self.screws_mm / sqrt(2.0), 1)
        places = [(sx * at, sy * at) for sx, sy in ((1, 1), (-1, 1), (-1, -1), (1, -1))]
        if 2.0 * at > _APART_MM:
            side = self.half_mm + self.screws_mm
            places += [(side, 0.0), (0.0, side), (-side, 0.0), (0.0, -side)]
        return places

    @property
    def boot_g(self) -> float:
        """Mass of the boot's cloth: a band from the bezel's edge to the collar, and what is clamped."""
        skin = (8.0 * self.half_mm + 2.0 * pi * (self.edge_mm + self.collar_radius_mm)) / 2.0 * self.cloth_mm
        clamped = self.area_mm2(self.rim_mm) - self.area_mm2(self.opening_mm)
        collar = pi * (self.collar_radius_mm**2 - self.stem_radius_mm**2) * COLLAR_MM[1] / CLOTH_MM
        return (skin + clamped + collar) * _CLOTH_G_M2 * 1e-6

    @property
    def carried_g(self) -> float:
        """What of it the handle carries: a third of the band, which moves by its share of the way, and the collar."""
        skin = (8.0 * self.half_mm + 2.0 * pi * (self.edge_mm + self.collar_radius_mm)) / 2.0 * self.cloth_mm
        collar = pi * (self.collar_radius_mm**2 - self.stem_radius_mm**2) * COLLAR_MM[1] / CLOTH_MM
        return (skin / 3.0 + collar) * _CLOTH_G_M2 * 1e-6


def panel_dimensions(design: Design, platform: PlatformDimensions, cup_radius_mm: float) -> PanelDimensions | None:
    """Dimensions panel, bezel and boot over the highest platform, and the stem that reaches through them.

    Args:
        design: The design.
        platform: Its platform.
        cup_radius_mm: Of the cups at the wrists, which may stand higher than the bosses.

    Returns:
        None where the design states no panel.
    """
    if (panel := design.panel) is None:
        return None
    cube, clear = design.cube, design.requirements.clearance_min_mm
    row, boss = catalogue.screw(SCREW), platform.boss_diameter_mm / 2
    highest = cube.bottom_height_mm + 2 * cube.half_side_mm + max(boss, cup_radius_mm)
    under = _stepped(highest + clear + row.head_height_mm + MARGIN_MM)
    clamped = panel.thickness_mm + CLOTH_MM
    screw = next(length for length in row.lengths_mm if length >= clamped + row.diameter_mm)
    thread = _stepped(screw - clamped + MARGIN_MM)
    bezel = _stepped(drilled_mm(SCREW, thread) + tip_mm(row.tap_drill_mm) + _UNDER_TIP_MM)
    top, lowest = under + clamped + bezel, cube.bottom_height_mm + boss
    stem = _stepped(top + clear + MARGIN_MM + COLLAR_MM[1] + _UNDER_KNOB_MM - lowest)
    collar = boss + stem - _UNDER_KNOB_MM - COLLAR_MM[1]
    radius = platform.stem_diameter_mm / 2
    edge = radius + panel.limit_mm + CLOTH_MM
    aside = sqrt(2.0) * (2.0 * cube.half_side_mm + panel.limit_mm) + edge - radius - COLLAR_MM[0]
    up = cube.bottom_height_mm + 2 * cube.half_side_mm + collar - under - panel.thickness_mm
    return PanelDimensions(
        half_mm=cube.half_side_mm,
        under_mm=under,
        thickness_mm=panel.thickness_mm,
        bezel_mm=bezel,
        stem_radius_mm=radius,
        limit_mm=panel.limit_mm,
        thread_mm=thread,
        screw_mm=screw,
        stem_length_mm=stem,
        collar_mm=collar,
        cloth_mm=_EASE * hypot(aside, up),
        centre_x_mm=cube.centre_x_mm or 0.0,
    )


def sleeve_mm(design: Design, foot: catalogue.Foot, circle_mm: float, spread_rad: float, hole_mm: float) -> float:
    """Gives the height of the sleeves under the base plate's mounting holes, mm; 0 where there are none.

    Args:
        design: The design.
        foot: Its feet, between the sleeves.
        circle_mm: Diameter that the holes stand on.
        spread_rad: Angle between a hole and the foot beside it.
        hole_mm: Diameter of the holes.

    Raises:
        DimensionError: The feet are too low, or too wide, for sleeves beside them.
    """
    if design.hardware.mounting != "both":
        return 0.0
    height = foot.height_mm - _SQUEEZE_MM
    apart = circle_mm * spread_rad / 2.0 * 0.98  # the chord of a small angle
    least = foot.diameter_mm / 2 + hole_mm / 2 + SLEEVE_WALL_MM + MARGIN_MM
    words, ways = "hardware.mounting = both asks for sleeves beside the feet", another("foot", "mounting")
    low = f"{words}: a foot of {foot.height_mm:g} mm leaves them {height:g} mm; at least {_SLEEVE_LEAST_MM:g}"
    require(height >= _SLEEVE_LEAST_MM, "mount_sleeve", "height", low, *ways)
    wide = f"{words}: a foot stands {apart:.1f} mm from them; at least {least:.1f}"
    require(apart >= least, "mount_sleeve", "room", wide, *ways)
    return height


def _stepped(height_mm: float) -> float:
    return _STEP_MM * ceil(height_mm / _STEP_MM - 1e-9)
