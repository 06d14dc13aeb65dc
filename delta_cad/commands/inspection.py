"""Inspection of a design without any CAD: dimensions, reach, torque, conditioning, angles and margins."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from math import degrees, sqrt
from typing import Any

from delta_cad.common.units import MM_PER_M
from delta_cad.design import Design
from delta_cad.design.stands import gaps_of
from delta_cad.dimensions import DimensionError, dimensions
from delta_cad.dimensions.capstan import base_radius_min_mm
from delta_cad.dimensions.joint import FRICTION_RANGE, limit_values
from delta_cad.dimensions.tolerances.cable_setting import cable_setting
from delta_cad.drive import drive_friction_N_m, drive_torque
from delta_cad.mechanism.limits import POSE_LIMITS, Friction, Limits, Outline, Torque
from delta_cad.mechanism.proof.judgement import can_prove, judge
from delta_cad.mechanism.workspace import CubeExtremes, cube_extremes
from delta_cad.structure.report import stiffness

OUTLINE = "outline by eq. (1), points only"


@dataclass(frozen=True)
class InspectionRow:
    """One line of the inspection.

    Attributes:
        group: Heading it stands under.
        quantity: What it is.
        value: Its value in `unit`; text where the quantity is no number.
        unit: Unit, "" where there is none.
        limit: What it is held against, with its sense ("<= 28"), or "".
        holds: Whether the limit holds; None where there is no limit, or its value is not known.
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


def inspection(design: Design, masses: Mapping[str, Any] | None = None) -> list[InspectionRow]:
    """Inspects a design.

    Args:
        design: A validated design.
        masses: What is known of them, as `known_masses` gives it; None: nothing.

    Raises:
        UnreachableError: A point of the cube is out of reach.
    """
    extremes = cube_extremes(design.geometry, design.workspace, design.requirements.force_N)
    return [
        *dimension_rows(design),
        *limit_rows(design, masses),
        *other_rows(extremes),
        *_height(design),
        *_smallest(design),
        *_drive(design),
        *_structure(design),
        *_panel(design),
    ]


def dimension_rows(design: Design) -> list[InspectionRow]:
    """Lists the lengths and the outline of points and bars."""
    m, c, required = design.mechanism, design.cube, design.requirements
    g, centre_x = design.geometry, c.centre_x_mm or 0.0
    named: list[tuple[str, float]] = [
        ("base radius R" if g.three_fold else "base radius R of chain 0", m.base_radius_mm),
        ("platform radius r", m.platform_radius_mm),
        ("upper arm L_A", m.upper_arm_length_mm),
        ("forearm L_B", m.forearm_length_mm),
        ("parallelogram width L_c", m.parallelogram_width_mm),
        ("cube bottom H", c.bottom_height_mm),
        ("cube side 2 L", 2 * c.half_side_mm),
    ]
    if not g.three_fold:
        named.insert(1, ("base radius R of chains 1 and 2", m.base_radius_mm + g.side_shift * MM_PER_M))
    if centre_x:
        named.append(("cube's middle from the base's axis, towards arm 0", centre_x))
    rows = [InspectionRow("dimensions", name, value, "mm") for name, value in named]
    if not g.three_fold:
        azimuth = InspectionRow("dimensions", "azimuth of chains 1 and 2, either way", design.azimuths_deg[1], "deg")
        rows.insert(2, azimuth)
    outline = Outline(required.envelope_width_mm, required.envelope_depth_mm, m.parallelogram_width_mm)
    reach, shift = m.base_radius_mm + m.upper_arm_length_mm, g.side_shift * MM_PER_M
    points = sorted(map(float, outline.size_mm(reach, shift, g.side_cosine)), reverse=True)
    sides = sorted((required.envelope_width_mm, required.envelope_depth_mm), reverse=True)
    return rows + [
        InspectionRow(OUTLINE, name, value, "mm", f"<= {side:g}", value <= side)
        for name, value, side in zip(("longer side", "shorter side"), points, sides, strict=True)
    ]


def limit_rows(design: Design, masses: Mapping[str, Any] | None = None) -> list[InspectionRow]:
    """Judges every limit over the cube; one that needs masses which are not known says so.

    Args:
        design: The design.
        masses: What is known of them, as `known_masses` gives it; None: nothing.
    """
    proof, values = can_prove(), limit_values(design, masses)
    group = "limits over the cube (" + ("proved)" if proof else "searched, not proved: numba is not installed)")
    missing = {kind for kind in POSE_LIMITS if kind.needs and values.get(kind.needs) is None}
    limits = Limits.of(*(kind.stated(values, strict=True) for kind in POSE_LIMITS if kind not in missing))
    others = [one for one in Limits.measured(values) if limits.get(type(one)) is None]
    rows = []
    for one in judge(design.geometry, design.workspace, limits, others, proof):
        figure = one.figure
        x, y, z = (MM_PER_M * v for v in one.position)
        words, value, bound = figure.words, one.value * figure.scale, ""
        if isinstance(one.limit, Torque):
            words = f"{words} for {one.limit.force:g} N in the worst direction"
        if one.verdict is not None:
            undecided = ", undecided" if one.verdict == "undecided" else ""
            bound = f"{figure.sense} {one.limit.bound(figure) * figure.scale:g}{undecided}"
        rows.append(InspectionRow(group, words, value, figure.unit, bound, one.holds, (x, y, z)))
    for kind in POSE_LIMITS:
        stated = [
            values[field.name] for field in kind.fields_ if kind in missing and values.get(field.name) is not None
        ]
        why = "not known of these joints" if kind is Friction else "give --mass-properties"
        rows += [InspectionRow(group, f.words, why, "", f"{f.sense} {v:g}") for f in kind.figures for v in stated]
    return rows


def other_rows(e: CubeExtremes) -> list[InspectionRow]:
    """Lists figures over the cube that no limit bounds."""
    table = (
        ("smallest arm to forearm angle", "deg", e.forearm_angle_min),
        ("lowest elbow", "mm", e.elbow_z_min),
        ("highest elbow", "mm", e.elbow_z_max),
        ("smallest singular value of J", "mm/deg", e.singular_value_min),
        ("largest singular value of J", "mm/deg", e.singular_value_max),
        ("margin to a fold, w / L_B", "", e.serial_margin_min),
    )
    rows = []
    for quantity, unit, extreme in table:
        shown = {"deg": degrees(1.0), "": 1.0, "mm/deg": MM_PER_M / degrees(1.0)}
        value = extreme.value * shown.get(unit, MM_PER_M)
        x, y, z = (MM_PER_M * float(v) for v in extreme.position)
        rows.append(InspectionRow("over the cube (sampled and polished)", quantity, value, unit, at_mm=(x, y, z)))
    return rows


def reach_rows(design: Design) -> list[InspectionRow]:
    """Gives the heights over the middle between which upper arm and forearm fold and stretch in line."""
    m = design.mechanism
    aside = [MM_PER_M * float(a) for a in design.geometry.radius_differences]
    low, high = abs(m.forearm_length_mm - m.upper_arm_length_mm), m.forearm_length_mm + m.upper_arm_length_mm
    heights = (("lowest", low, max), ("highest", high, min))
    return [
        InspectionRow(
            "reach (closed form)",
            f"{word} position on the axis",
            sqrt(max(0.0, decides(far**2 - a**2 for a in aside))),
            "mm",
        )
        for word, far, decides in heights
    ]


def _height(design: Design) -> list[InspectionRow]:
    """Height of the machine; none of parts that cannot be made."""
    try:
        value, most = dimensions(design).height_mm, design.requirements.height_max_mm
    except DimensionError:
        return []
    limit, holds = ("", None) if most is None else (f"<= {most:g}", value <= most)
    words = "height, from the mounting surface to the knob at the cube's top"
    return [InspectionRow("height (closed form)", words, value, "mm", limit, holds)]


def _smallest(design: Design) -> list[InspectionRow]:
    """Radii at which the parts of neighbouring chains still pass one another; none of parts that cannot be made."""
    try:
        d = dimensions(design)
    except DimensionError:
        return []
    group = "smallest for this hardware (closed form)"
    clear = design.requirements.clearance_min_mm
    rows = [InspectionRow(group, "platform radius r, for the wrists", d.forearm.wrist_radius_min_mm, "mm")]
    if (c := d.capstan) is not None:
        thickness = d.layers.arm_mm[1] - d.layers.arm_mm[0]
        least = base_radius_min_mm(
            c.run, c.cable_diameter_mm, thickness, d.arm.flange_radius_mm, clear, gaps_of(design.geometry)
        )
        rows.insert(0, InspectionRow(group, "base radius R, for the sectors", least, "mm"))
    return rows


def _structure(design: Design) -> list[InspectionRow]:
    """Stiffness at the knob, softest direction, actuators held; of a design whose parts cannot be made, the reason."""
    group, demand = "structure over the cube (sampled)", design.requirements.stiffness_min_N_mm
    try:
        over = stiffness(dimensions(design))
    except DimensionError as error:
        return [InspectionRow(group, "least stiffness at the knob", str(error), "")]
    values, settled = over.new.stiffness_N_mm, over.softest.stiffness_N_mm
    k = int(values.argmin())
    x, y, z = (float(v) for v in over.positions_mm[k])
    value = over.least_N_mm
    limit, holds = ("", None) if demand is None else (f">= {demand:g}", value >= demand)
    shares = {name: float(share[k]) for name, share in over.new.shares.items()}
    most = max(shares, key=lambda name: shares[name])
    knob = f"{over.table.knob_mm:g} mm over the wrists"
    return [
        InspectionRow(group, f"least stiffness at the knob, {knob}", value, "N/mm", limit, holds, (x, y, z)),
        *(
            []
            if over.table.cable is None
            else [InspectionRow(group, "the same, cables settled", float(settled.min()), "N/mm")]
        ),
        InspectionRow(group, f"of what gives there: {most}", 100.0 * shares[most], "%"),
        InspectionRow(group, "the same in the cube's centre", float(values[-1]), "N/mm"),
        InspectionRow(group, "ball joint, as taken", over.table.joint_N_mm, "N/mm"),
    ]


def _cable_setting(design: Design) -> list[tuple[Any, ...]]:
    """How the cables are tensioned; nothing of a design whose parts cannot be made."""
    try:
        setting = cable_setting(dimensions(design))
    except DimensionError:
        return []
    if setting is None:
        return []
    low, high = setting.pull_N
    return [
        ("pull at the arm that sets its cable", f"{low:g} to {high:g}", "N"),
        ("tension of a strand at rest, at most", setting.tension_N, "N"),
    ]


def _panel(design: Design) -> list[InspectionRow]:
    """Panel over the machine, in closed form; nothing where there is none, or no parts that can be made."""
    try:
        d = dimensions(design)
    except DimensionError:
        return []
    if (p := d.panel) is None:
        return []
    group, least = "panel (closed form)", design.requirements.clearance_min_mm
    rows: list[tuple[Any, ...]] = [
        ("side of the opening", 2 * (p.half_mm + p.opening_mm), "mm"),
        ("radius of its corners", p.opening_mm, "mm"),
        ("side of the bezel", 2 * (p.half_mm + p.rim_mm), "mm"),
        ("panel's lower face over the shoulders' axes", p.under_mm, "mm"),
        ("panel's lower face over what the machine stands on", p.under_mm - d.floor_mm, "mm"),
        ("stem from platform to knob", p.stem_length_mm, "mm"),
        ("handle stopped aside, outside the cube", p.limit_mm, "mm", f"> {least:g}", p.limit_mm > least),
        ("boot from bezel to collar", p.cloth_mm, "mm"),
    ]
    return [InspectionRow(group, *row) for row in rows]


def _drive(design: Design) -> list[InspectionRow]:
    drive, (low, nominal, high) = drive_torque(design), FRICTION_RANGE
    least, usual, largest = (torque * MM_PER_M for torque in drive_friction_N_m(design))

    def held(value: float, required: float) -> tuple[Any, ...]:
        return value, "N m", f">= {required:g}", value >= required

    rows: list[tuple[Any, ...]] = [
        ("motor", drive.motor, ""),
        ("ratio", drive.ratio, ":1"),
        ("joint torque, continuous", *held(drive.continuous_torque_N_m, drive.required_torque_N_m)),
        (f"joint torque, {drive.peak_time_s:g} s", *held(drive.peak_torque_N_m, drive.required_peak_N_m)),
        ("rotor's inertia at the joint", drive.reflected_inertia_kg_m2 * 1e6, "kg mm^2"),
        ("friction at a joint, nominal", usual, "mN m"),
        ("friction at a joint, least to largest", f"{least:.1f} to {largest:.1f}", "mN m"),
        ("ball joints' coefficient of friction", f"{nominal:g}, {low:g} to {high:g}", ""),
    ]
    if drive.cable is not None:
        rows += [
            *_cable_setting(design),
            ("drum to cable ratio", drive.bend_ratio, "", f"advised {drive.bend_ratio_recommended:g}"),
            ("cable's bending life, of that at the advised ratio", 100.0 * (drive.bend_life_share or 0.0), "%"),
        ]
    return [InspectionRow("drive", *row) for row in rows]
