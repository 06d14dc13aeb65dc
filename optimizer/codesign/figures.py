"""Figures of a machine that was built: results, and the limits that the requirements set.

A limit that the user's file sets, a value derived from it or from the machine, and a result are three things: a result
is held here against set limits, never against what was derived.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from scipy.optimize import brentq

from delta_cad.checks.range.feel import feel_figures
from delta_cad.design import Design
from delta_cad.design.task import LEAST
from delta_cad.dimensions import Dimensions, dimensions
from delta_cad.drive import drive_torque
from delta_cad.mechanism.limits import HoldingTorque
from delta_cad.mechanism.proof.extremes import worst_of
from delta_cad.mechanism.workspace import CubeSearch
from optimizer.certify.gravity import held_masses
from optimizer.problem.brief import DesignBrief

if TYPE_CHECKING:
    from delta_cad.commands.pipeline import Outcome

BINDS = 0.01  # share of a set limit within which a result binds
FORCE_ROOM_N = 1e-5  # to which a force is found, rather too little


@dataclass(frozen=True)
class Figure:
    """A result.

    Attributes:
        key: Among the facts of a run.
        words: What a person reads.
        unit: Unit; "" for none.
        field: Table and field of the requirements that limits it; "" for none.
        least: Whether that is the least it may be; else the most.
        check: Name of the check that finds it, if it is among the checks; "" where none does.
        head: Whether it is one of those that are always told first.
    """

    key: str
    words: str
    unit: str
    field: str = ""
    least: bool = False
    check: str = ""
    head: bool = False


FIGURES = (
    Figure("cube_side_mm", "cube", "mm", "requirements.cube_side_mm", True),
    Figure("force_N", "continuous force", "N", "requirements.force_N", True, head=True),
    Figure("peak_force_N", "peak force", "N", "requirements.peak_force_N", True, head=True),
    Figure(
        "effective_mass_max_kg", "effective mass", "kg", "feel.effective_mass_max_kg", check="effective mass", head=True
    ),
    Figure("friction_max_N", "friction", "N", "feel.friction_max_N", check="friction", head=True),
    Figure(
        "stiffness_min_N_mm",
        "stiffness",
        "N/mm",
        "feel.stiffness_min_N_mm",
        True,
        "structure stiffness at the knob",
        True,
    ),
    Figure("height_mm", "height", "mm", head=True),
    Figure("outline_width_mm", "outline, width", "mm", "requirements.envelope_width_mm", check="envelope width"),
    Figure("outline_depth_mm", "outline, depth", "mm", "requirements.envelope_depth_mm", check="envelope depth"),
    Figure("outline_radius_mm", "R + L_A", "mm", "limits.outline_radius_max_mm"),
    Figure("clearance_mm", "clearance", "mm", "requirements.clearance_min_mm", True, "clearance"),
    Figure("kappa_max", "condition number", "", "feel.kappa_max", check="kappa"),
    Figure("couple_index_min", "couple index", "", "feel.couple_index_min", True, "couple index"),
    Figure("position_step_max_mm", "position step", "mm", "feel.position_step_max_mm", check="position step"),
    Figure("lean_deg", "lean of the rods", "deg", "limits.lean_max_deg", check="lean"),
    Figure("elbow_angle_deg", "angle at the elbow", "deg", "limits.elbow_angle_min_deg", True, "elbow angle"),
    Figure(
        "holding_torque_N_m",
        "joint torque, force and weight together",
        "N m",
        "requirements.joint_torque_N_m",
        check="torque with gravity",
    ),
    Figure("first_mode_Hz", "first mode", "Hz", check="structure first mode"),
)


@dataclass(frozen=True)
class ResultAtLimit:
    """A result beside a limit.

    Attributes:
        figure: What it is.
        value: The result.
        limit: The limit.
    """

    figure: Figure
    value: float
    limit: float

    @property
    def margin(self) -> float:
        """Room to the limit, as a share of it; less than 0 beyond it."""
        return (self.value - self.limit if self.figure.least else self.limit - self.value) / abs(self.limit)

    def __str__(self) -> str:
        sense = "at least" if self.figure.least else "at most"
        return f"{self.figure.words} {self.value:.3g} {self.figure.unit}".rstrip() + f", {sense} {self.limit:.3g}"


def results_of(outcome: Outcome) -> dict[str, float]:
    """Computes the results of a machine that was built, whatever limits are set.

    Args:
        outcome: What came of it, with its masses.

    Returns:
        Key of a figure -> value, the worst over the cube; those of checks are theirs.
    """
    design, d = outcome.design, dimensions(outcome.design)
    m = design.mechanism
    found: dict[str, float] = {
        "cube_side_mm": 2.0 * design.cube.half_side_mm,
        "height_mm": height_mm(d),
        "outline_radius_mm": m.base_radius_mm + m.upper_arm_length_mm,
        "force_N": force_N(design, outcome.masses, design.requirements.joint_torque_N_m),
        "peak_force_N": force_N(design, outcome.masses, drive_torque(design).required_peak_N_m),
        **feel_figures(design, outcome.masses),
    }
    from delta_cad.structure.report import stiffness

    found["stiffness_min_N_mm"] = float(stiffness(d).softest.stiffness_N_mm.min())
    checked = {one.name: one.value for one in outcome.results if one.value is not None}
    return found | {one.key: checked[one.check] for one in FIGURES if one.check in checked}


def force_N(design: Design, masses: Mapping[str, Any], torque_N_m: float) -> float:
    """Computes the force that a torque of the joints gives beside the weight, in any direction, anywhere in the cube.

    Args:
        design: The machine.
        masses: Result of `mass_report`.
        torque_N_m: Of each joint.

    Returns:
        The force, N; 0 where the weight takes all of the torque.
    """
    held = held_masses(design.name, masses["bodies"], design)
    search = CubeSearch(design.workspace)

    def needed(force: float) -> float:
        limit = HoldingTorque(force, torque_N_m, held)
        return worst_of(search, design.geometry, limit, limit.figures[0]).value

    if needed(LEAST) >= torque_N_m:
        return 0.0
    high = design.requirements.force_N
    while needed(high) <= torque_N_m:
        high *= 2.0
    found: Any = brentq(lambda force: needed(force) - torque_N_m, LEAST, high, xtol=FORCE_ROOM_N)
    return max(float(found) - FORCE_ROOM_N, 0.0)


def height_mm(d: Dimensions) -> float:
    """Computes the height of a machine with its handle at the top of the cube, from what it stands on, mm."""
    feet = d.foot.height_mm if d.has_feet else 0.0
    floor = d.base.top_mm - d.base.thickness_mm - feet
    knob = d.platform.boss_diameter_mm / 2.0 + d.platform.stem_length_mm + d.knob.height_mm
    return d.design.cube.bottom_height_mm + 2.0 * d.design.cube.half_side_mm + knob - floor


def set_limits(brief: DesignBrief, values: Mapping[str, float | None]) -> list[ResultAtLimit]:
    """Lists the results of which the requirements file sets a limit, in the order of `FIGURES`.

    Args:
        brief: The requirements.
        values: Key of a figure -> result; None where it is not known.
    """
    return [
        ResultAtLimit(one, value, limit)
        for one in FIGURES
        if one.field in brief.stated
        and (limit := brief.value(one.field)) is not None
        and (value := values.get(one.key)) is not None
    ]


def binding(brief: DesignBrief, values: Mapping[str, float | None]) -> list[ResultAtLimit]:
    """Lists the set limits that bind: those within a hundredth of which the machine is."""
    return [one for one in set_limits(brief, values) if abs(one.margin) <= BINDS]
