"""What can be said of a design without any CAD: dimensions, reach, torque, conditioning, angles and margins."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from math import degrees
from typing import Any

from delta_cad.common.units import MM_PER_M
from delta_cad.design import Design
from delta_cad.drive import drive_torque
from delta_cad.mechanism.geometry import SIN_60
from delta_cad.mechanism.workspace import Cube, CubeExtremes, cube_extremes


@dataclass(frozen=True)
class InspectionRow:
    """One line of the inspection.

    Attributes:
        group: Heading it stands under.
        quantity: What it is.
        value: Its value in `unit`; text where the quantity is no number.
        unit: Unit, "" where there is none.
        limit: What it is held against, with its sense ("<= 28"), or "".
        holds: Whether the limit holds; None where there is no limit.
        at_mm: Handle position where it occurs, mm, or None.
    """

    group: str
    quantity: str
    value: float | str
    unit: str
    limit: str = ""
    holds: bool | None = None
    at_mm: tuple[float, float, float] | None = None

    def to_json(self) -> dict[str, Any]:
        """The row as JSON types."""
        return asdict(self)


def inspection(design: Design) -> list[InspectionRow]:
    """All rows for a design.

    Args:
        design: A validated design.

    Raises:
        UnreachableError: A point of the cube is out of reach.
    """
    cube = Cube(design.cube.bottom_height_mm / MM_PER_M, design.cube.half_side_mm / MM_PER_M)
    extremes = cube_extremes(design.geometry, cube, design.requirements.force_N)
    return [*_dimensions(design), *_motion(design, extremes), *_force(design, extremes), *_drive(design)]


def _dimensions(design: Design) -> list[InspectionRow]:
    m, c, required = design.mechanism, design.cube, design.requirements
    named = (
        ("base radius R", m.base_radius_mm),
        ("platform radius r", m.platform_radius_mm),
        ("upper arm L_A", m.upper_arm_length_mm),
        ("forearm L_B", m.forearm_length_mm),
        ("parallelogram width L_c", m.parallelogram_width_mm),
        ("cube bottom H", c.bottom_height_mm),
        ("cube side 2 L", 2 * c.half_side_mm),
    )
    rows = [InspectionRow("dimensions", name, value, "mm") for name, value in named]
    reach = m.base_radius_mm + m.upper_arm_length_mm
    points = sorted(
        (m.parallelogram_width_mm * 0.5 + 2 * SIN_60 * reach, m.parallelogram_width_mm * SIN_60 / 2 + 1.5 * reach),
        reverse=True,
    )
    sides = sorted((required.envelope_width_mm, required.envelope_depth_mm), reverse=True)
    rows += [
        InspectionRow("outline by eq. (1), points only", name, value, "mm", f"<= {side:g}", value <= side)
        for name, value, side in zip(("longer side", "shorter side"), points, sides, strict=True)
    ]
    return rows


def _motion(design: Design, e: CubeExtremes) -> list[InspectionRow]:
    required = design.requirements
    group = "motion over the cube (sampled and polished)"
    low, high, lean = required.shoulder_min_deg, required.shoulder_max_deg, required.lean_max_deg
    lowest, highest = degrees(e.shoulder_min.value), degrees(e.shoulder_max.value)
    leaning = degrees(e.lean_max.value)

    def row(
        quantity: str, value: float, unit: str, extreme: Any, limit: str = "", holds: bool | None = None
    ) -> InspectionRow:
        x, y, z = (MM_PER_M * float(v) for v in extreme.position)
        return InspectionRow(group, quantity, value, unit, limit, holds, (x, y, z))

    return [
        row(
            "reach margin w",
            max(e.closure_margin_min.value, 0.0) ** 0.5 * MM_PER_M,
            "mm",
            e.closure_margin_min,
            "> 0",
            e.closure_margin_min.value > 0,
        ),
        row(
            "lowest shoulder angle",
            lowest,
            "deg",
            e.shoulder_min,
            "" if low is None else f">= {low:g}",
            None if low is None else lowest >= low,
        ),
        row(
            "highest shoulder angle",
            highest,
            "deg",
            e.shoulder_max,
            "" if high is None else f"<= {high:g}",
            None if high is None else highest <= high,
        ),
        row(
            "largest lean of a rod",
            leaning,
            "deg",
            e.lean_max,
            "" if lean is None else f"<= {lean:g}",
            None if lean is None else leaning <= lean,
        ),
        row("smallest arm to forearm angle", degrees(e.forearm_angle_min.value), "deg", e.forearm_angle_min),
        row("largest arm to forearm angle", degrees(e.forearm_angle_max.value), "deg", e.forearm_angle_max),
        row("lowest elbow", e.elbow_z_min.value * MM_PER_M, "mm", e.elbow_z_min),
        row("highest elbow", e.elbow_z_max.value * MM_PER_M, "mm", e.elbow_z_max),
    ]


def _force(design: Design, e: CubeExtremes) -> list[InspectionRow]:
    required = design.requirements
    group = "force over the cube (sampled and polished)"

    def row(
        quantity: str, value: float, unit: str, extreme: Any, limit: str = "", holds: bool | None = None
    ) -> InspectionRow:
        x, y, z = (MM_PER_M * float(v) for v in extreme.position)
        return InspectionRow(group, quantity, value, unit, limit, holds, (x, y, z))

    torque, kappa = e.torque_max.value, e.kappa_max.value
    return [
        row(
            f"joint torque for {required.force_N:g} N in the worst direction",
            torque,
            "N m",
            e.torque_max,
            f"<= {required.joint_torque_N_m:g}",
            torque <= required.joint_torque_N_m,
        ),
        row(
            "worst condition number",
            kappa,
            "",
            e.kappa_max,
            "" if required.kappa_max is None else f"<= {required.kappa_max:g}",
            None if required.kappa_max is None else kappa <= required.kappa_max,
        ),
        row("smallest singular value of J", e.singular_value_min.value * MM_PER_M, "mm/rad", e.singular_value_min),
        row("largest singular value of J", e.singular_value_max.value * MM_PER_M, "mm/rad", e.singular_value_max),
        row(
            "margin to a fold, w / L_B",
            e.serial_margin_min.value,
            "",
            e.serial_margin_min,
            "> 0",
            e.serial_margin_min.value > 0,
        ),
        row(
            "margin to a direct singularity, det",
            e.direct_margin_min.value,
            "",
            e.direct_margin_min,
            "> 0",
            e.direct_margin_min.value > 0,
        ),
    ]


def _drive(design: Design) -> list[InspectionRow]:
    drive, required = drive_torque(design), design.requirements.joint_torque_N_m
    rows = [
        InspectionRow("drive", "motor", drive.motor, ""),
        InspectionRow("drive", "ratio", drive.ratio, ":1"),
        InspectionRow("drive", "joint torque, for ever", drive.continuous_torque_N_m, "N m"),
        InspectionRow(
            "drive",
            f"joint torque, {drive.peak_time_s:g} s",
            drive.peak_torque_N_m,
            "N m",
            f">= {required:g}",
            drive.verdict != "insufficient",
        ),
        InspectionRow("drive", f"{required:g} N m", drive.verdict, ""),
        InspectionRow("drive", "rotor's inertia at the joint", drive.reflected_inertia_kg_m2 * 1e6, "kg mm^2"),
    ]
    if drive.bend_ratio is not None and drive.cable_safety_factor is not None:
        rows += [
            InspectionRow("drive", "cable safety at the peak", drive.cable_safety_factor, ""),
            InspectionRow(
                "drive", "drum to cable ratio", drive.bend_ratio, "", f"advised {drive.bend_ratio_recommended:g}"
            ),
        ]
    return rows
