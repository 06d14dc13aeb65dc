"""The upper arm and the shoulder shaft, in the arm's frame (x along the arm, y along the shoulder axis)."""

from __future__ import annotations

from dataclasses import dataclass
from math import radians

from delta_cad import catalogue
from delta_cad.dimensions.layers import STUB_DEPTH_MM, Layers
from delta_cad.dimensions.rules import RUNNING_GAP_MM, require

MAGNET_GLUE_MM = 0.05  # radial room for the adhesive
MAGNET_WALL_MM = 0.9
STUB_GLUE_MM = 0.05  # diametral: a direct drive's stub is bonded into the arm's bore
ELBOW_SCREW = "M2.5"
COUNTERBORE_WALL_MM = 1.0


@dataclass(frozen=True)
class ArmDimensions:
    """Upper arm: flange with split clamp at the shoulder, tapered beam, split boss at the elbow."""

    length_mm: float
    flange_radius_mm: float
    beam_root_radius_mm: float
    boss_radius_mm: float
    shaft_bore_mm: float
    bar_bore_mm: float
    slit_mm: float
    shoulder_clamp_z_mm: float
    elbow_clamp_x_mm: float
    elbow_slit_x_mm: float
    pocket_depth_mm: float
    pocket_x_mm: tuple[float, float]
    pocket_radii_mm: tuple[float, float]
    collar_diameter_mm: float
    sector_screw_circle_mm: float
    sector_screw_angles_rad: tuple[float, ...]
    sector_dowel_angles_rad: tuple[float, ...]


@dataclass(frozen=True)
class ShaftDimensions:
    """Carrier of the magnet: a through shaft in both bearings (capstan) or a stub in the arm's bore (direct)."""

    diameter_mm: float
    y_mm: tuple[float, float]
    head_diameter_mm: float
    head_to_y_mm: float
    magnet_bore_mm: float
    magnet_depth_mm: float


def arm_dimensions(
    length_mm: float, shaft_mm: float, bar_mm: float, layers: Layers, bearing: catalogue.Bearing
) -> ArmDimensions:
    """Dimensions an upper arm for a shaft that its flange clamps and a cross-bar that its boss clamps.

    The sector's screws and dowels sit in the lower half of the flange; the upper half holds the clamp screw. The collar
    touches the inner ring of the shoulder bearing alone.

    Raises:
        DimensionError: The arm is too short or too thin for its two clamps.
    """
    flange, boss = shaft_mm / 2 + 14.0, bar_mm / 2 + 3.0
    require(
        length_mm >= flange + boss + 30.0,
        "upper_arm",
        "length",
        f"{length_mm:g} mm leave no beam between the clamps; at least {flange + boss + 30.0:g} mm",
    )
    thickness = layers.arm_mm[1] - layers.arm_mm[0]
    least = catalogue.screw(ELBOW_SCREW).counterbore_diameter_mm + 2 * COUNTERBORE_WALL_MM
    require(
        thickness >= least,
        "upper_arm",
        "elbow clamp screw",
        f"hardware.arm_thickness_mm = {thickness:g} must be at least {least:g} mm around the {ELBOW_SCREW} counterbore",
    )
    root = 11.0
    slit_x = length_mm - boss - 9.0
    pocket = (flange + 6.0, slit_x - 9.0)

    def height(x: float) -> float:
        return root + (boss - root) * x / length_mm

    return ArmDimensions(
        length_mm=length_mm,
        flange_radius_mm=flange,
        beam_root_radius_mm=root,
        boss_radius_mm=boss,
        shaft_bore_mm=shaft_mm,
        bar_bore_mm=bar_mm,
        slit_mm=1.0,
        shoulder_clamp_z_mm=shaft_mm / 2 + 7.0,
        elbow_clamp_x_mm=length_mm - boss - 3.0,
        elbow_slit_x_mm=slit_x,
        pocket_depth_mm=(thickness - 2.0) / 2,  # a web of 2 mm stays
        pocket_x_mm=pocket,
        pocket_radii_mm=(height(pocket[0]) - 2.8, height(pocket[1]) - 2.8),  # flanges of 2.8 mm, cutter of 6 mm
        collar_diameter_mm=(bearing.shaft_shoulder_min_mm + bearing.inner_ring_outer_mm) / 2,
        sector_screw_circle_mm=shaft_mm + 18.5,
        sector_screw_angles_rad=(radians(-150.0), radians(-90.0), radians(-30.0)),
        sector_dowel_angles_rad=(radians(-120.0), radians(-60.0)),
    )


def shaft_dimensions(
    shaft_mm: float, drive: str, layers: Layers, encoder: catalogue.Encoder, magnet: catalogue.Magnet
) -> ShaftDimensions:
    """Dimensions the shoulder shaft, whose end holds the magnet at the middle of the encoder's air gap.

    A capstan's shaft goes through both cheeks; with a direct drive it is a stub on the arm's encoder side.

    Raises:
        DimensionError: The magnet does not fit the shaft.
    """
    air_gap = (encoder.air_gap_min_mm + encoder.air_gap_max_mm) / 2
    end = layers.encoder_board_mm[1] + encoder.chip_height_mm + air_gap
    bore = magnet.diameter_mm + 2 * MAGNET_GLUE_MM
    head = bore + 2 * MAGNET_WALL_MM
    if drive == "direct":
        half = (layers.arm_mm[1] - layers.arm_mm[0]) / 2
        return ShaftDimensions(
            diameter_mm=shaft_mm - STUB_GLUE_MM,
            y_mm=(end, -half + STUB_DEPTH_MM),
            head_diameter_mm=max(head, shaft_mm),
            head_to_y_mm=-half - RUNNING_GAP_MM,
            magnet_bore_mm=bore,
            magnet_depth_mm=magnet.thickness_mm,
        )
    require(
        head <= shaft_mm,
        "shoulder_shaft",
        "magnet seat",
        f"a magnet of {magnet.diameter_mm:g} mm needs a shaft of at least {head:g} mm, not {shaft_mm:g} mm",
    )
    return ShaftDimensions(
        diameter_mm=shaft_mm,
        y_mm=(end, layers.motor_cheek_mm[1] - 0.5),
        head_diameter_mm=shaft_mm,
        head_to_y_mm=end,
        magnet_bore_mm=bore,
        magnet_depth_mm=magnet.thickness_mm,
    )
