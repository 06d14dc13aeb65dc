"""The upper arm and the shoulder shaft, in the arm's frame (x along the arm, y along the shoulder axis)."""

from __future__ import annotations

from dataclasses import dataclass
from math import radians

from delta_cad import catalogue
from delta_cad.dimensions.layers import STUB_DEPTH_MM, Layers
from delta_cad.dimensions.rules import ARM, ARM_THICKNESS, RUNNING_GAP_MM, another, larger, require, tenths_below

MAGNET_GLUE_MM = 0.05  # radial room for the adhesive
_MAGNET_WALL_MM = 0.9
_STUB_GLUE_MM = 0.05  # diametral: a direct drive's stub is bonded into the arm's bore
CLAMP_SCREW = "M3"  # of a direct drive's arm on its motor's shaft
DOWEL_MM = 3.0  # between arm and sector
_DOWEL_WALL_MM = 2.0  # around them
_ARM_LEAST_MM = 5.0  # plate that holds a dowel by more than its diameter
_BOSS_WALL_MM = 3.0  # around the cross-bar
_BEAM_LEAST_MM = 30.0  # of arm between its ends
_END_SCREWS = ("M4", "M3", "M2.5")  # in the shaft's end, the largest that its wall allows
_END_WALL_MM = 1.5
_END_THREAD_DIAMETERS = 2.0
WASHER_MATERIAL = "stainless-1.4305"
WASHER_MM = 3.0  # it bears on a narrow ring: strength goes with the square
_SPANNERS_MM = (13.0, 10.0, 8.0, 7.0, 5.5)
_FLATS_DEEP_MM = 0.5  # of the flats on a shaft's head, either side, at least
FLATS_LONG_MM = 2.5  # they begin at the head's end, before the encoder's board is on
INSIDE_RING_MM = (
    0.6  # the shaft ends so far before its bearing's face: more than bearings and parts are shorter together
)


@dataclass(frozen=True)
class ArmDimensions:
    """Upper arm: a plate that tapers from its hub to the boss of the cross-bar, which is bonded.

    A capstan's arm is clamped along the shaft between the bearings' inner rings, the sector beside it; a direct
    drive's has a larger hub, split around the motor's shaft.
    """

    length_mm: float
    flange_radius_mm: float
    beam_root_radius_mm: float
    boss_radius_mm: float
    shaft_bore_mm: float
    bar_bore_mm: float
    slit_mm: float
    shoulder_clamp_z_mm: float
    collar_diameter_mm: float
    dowel_circle_mm: float
    dowel_angles_rad: tuple[float, ...]


@dataclass(frozen=True)
class ShaftDimensions:
    """Carrier of the magnet: a through shaft in both bearings (capstan) or a stub in the arm's bore (direct).

    A capstan's shaft has a head against the encoder's bearing, with flats for a spanner where the magnet leaves them
    room, and a screw with a washer against the motor's: a spacer of the catalogue, or turned where `washer` is None.
    """

    diameter_mm: float
    y_mm: tuple[float, float]
    head_diameter_mm: float
    head_to_y_mm: float
    magnet_bore_mm: float
    magnet_depth_mm: float
    end_screw: str
    end_thread_mm: float
    washer: catalogue.Spacer | None
    washer_diameter_mm: float
    flats_mm: float


def arm_dimensions(
    length_mm: float,
    shaft_mm: float,
    bar_bore_mm: float,
    drive: str,
    layers: Layers,
    bearing: catalogue.Bearing,
    apart_mm: float = 0.0,
) -> ArmDimensions:
    """Dimensions an upper arm for a shaft and a cross-bar; the screw of a clamp stays `apart_mm` off the cheeks.

    The collar touches the inner ring of the shoulder bearing alone; the sector's dowels stand around it.

    Raises:
        DimensionError: The arm is too short or too thin.
    """
    collar = (bearing.shaft_shoulder_min_mm + bearing.inner_ring_outer_mm) / 2
    circle = max(shaft_mm, collar - 2.0) + DOWEL_MM + 2 * _DOWEL_WALL_MM
    hub = (circle + DOWEL_MM) / 2 + _DOWEL_WALL_MM + 0.5
    flange = hub if drive == "capstan" else shaft_mm / 2 + 14.0
    boss = tenths_below(bar_bore_mm / 2 + _BOSS_WALL_MM)
    require(
        length_mm >= flange + boss + _BEAM_LEAST_MM,
        "upper_arm",
        "length",
        f"{length_mm - flange - boss:g} mm are left for a beam between hub and boss; at least {_BEAM_LEAST_MM:g}",
        larger(ARM),
    )
    thickness = layers.arm_mm[1] - layers.arm_mm[0]
    head = catalogue.screw(CLAMP_SCREW).head_diameter_mm  # of a direct drive's clamp, in the arm's middle
    least = _ARM_LEAST_MM if drive == "capstan" else head + 2.0 * max(0.5, apart_mm - RUNNING_GAP_MM)
    require(
        thickness >= least,
        "upper_arm",
        "thickness",
        f"{thickness:g} mm are too thin for its dowels or its clamp's screw, which take {least:g}",
        larger(ARM_THICKNESS),
    )
    return ArmDimensions(
        length_mm=length_mm,
        flange_radius_mm=flange,
        beam_root_radius_mm=hub if drive == "capstan" else 11.0,
        boss_radius_mm=boss,
        shaft_bore_mm=shaft_mm,
        bar_bore_mm=bar_bore_mm,
        slit_mm=1.0,
        shoulder_clamp_z_mm=shaft_mm / 2 + 7.0,
        collar_diameter_mm=collar,
        dowel_circle_mm=circle,
        dowel_angles_rad=(radians(-90.0), radians(90.0)),
    )


def shaft_dimensions(
    shaft_mm: float,
    drive: str,
    layers: Layers,
    bearing: catalogue.Bearing,
    encoder: catalogue.Encoder,
    magnet: catalogue.Magnet,
) -> ShaftDimensions:
    """Dimensions the shoulder shaft, whose end holds the magnet at the middle of the encoder's air gap.

    A capstan's shaft goes through both bearings; with a direct drive it is a stub on the arm's encoder side.

    Raises:
        DimensionError: The magnet does not fit the shaft's head, or no screw its end.
    """
    air_gap = (encoder.air_gap_min_mm + encoder.air_gap_max_mm) / 2
    end = layers.encoder_board_mm[1] + encoder.chip_height_mm + air_gap
    bore = magnet.diameter_mm + 2 * MAGNET_GLUE_MM
    head = bore + 2 * _MAGNET_WALL_MM
    if drive == "direct":
        half = (layers.arm_mm[1] - layers.arm_mm[0]) / 2
        return ShaftDimensions(
            diameter_mm=shaft_mm - _STUB_GLUE_MM,
            y_mm=(end, -half + STUB_DEPTH_MM),
            head_diameter_mm=max(head, shaft_mm),
            head_to_y_mm=-half - RUNNING_GAP_MM,
            magnet_bore_mm=bore,
            magnet_depth_mm=magnet.thickness_mm,
            end_screw="",
            end_thread_mm=0.0,
            washer=None,
            washer_diameter_mm=0.0,
            flats_mm=0.0,
        )
    collar = (bearing.shaft_shoulder_min_mm + bearing.inner_ring_outer_mm) / 2
    require(
        head <= bearing.inner_ring_outer_mm,
        "shoulder_shaft",
        "magnet seat",
        f"a magnet of {magnet.diameter_mm:g} mm needs a head of {head:g} mm, which touches more than the bearing's "
        f"inner ring of {bearing.inner_ring_outer_mm:g} mm",
        *another("magnet", "bearing"),
    )
    sizes = [size for size in _END_SCREWS if catalogue.screw(size).diameter_mm <= shaft_mm - 2 * _END_WALL_MM]
    require(
        bool(sizes),
        "shoulder_shaft",
        "end screw",
        f"a shaft of {shaft_mm:g} mm has no room for {_END_SCREWS[-1]}, which takes "
        f"{catalogue.screw(_END_SCREWS[-1]).diameter_mm + 2 * _END_WALL_MM:g} mm",
        *another("bearing"),
    )
    sizes = sizes or [_END_SCREWS[-1]]
    wide = max(head, collar)
    on_ring = bearing.shaft_shoulder_min_mm, bearing.inner_ring_outer_mm
    washer = catalogue.stock_spacer(sizes[0], WASHER_MM, on_ring, WASHER_MATERIAL)
    flats = [mm for mm in _SPANNERS_MM if head <= mm <= wide - 2 * _FLATS_DEEP_MM]
    return ShaftDimensions(
        diameter_mm=shaft_mm,
        y_mm=(end, layers.bearings_mm[1][1] - INSIDE_RING_MM),
        head_diameter_mm=wide,
        head_to_y_mm=layers.bearings_mm[0][0],
        magnet_bore_mm=bore,
        magnet_depth_mm=magnet.thickness_mm,
        end_screw=sizes[0],
        end_thread_mm=_END_THREAD_DIAMETERS * catalogue.screw(sizes[0]).diameter_mm,
        washer=washer,
        washer_diameter_mm=collar if washer is None else washer.outer_mm,
        flats_mm=flats[0] if flats else 0.0,
    )
