"""A candidate: lengths and hardware as in a design file, with the masses of its solids and its closed-form refusals."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from delta_cad.design import Design, design_from_dict, design_hash
from delta_cad.dimensions.joint import known_joints
from delta_cad.drive import drive_torque
from delta_cad.drive.held import held_masses
from delta_cad.drive.masses import masses_from_dict
from delta_cad.mechanism import cube_extremes
from delta_cad.mechanism.limits import EffectiveMass, HoldingTorque, Outline, Torque
from delta_cad.mechanism.proof.extremes import worst_of
from delta_cad.mechanism.workspace import CubeSearch
from optimizer.codesign.corrections import (
    TORQUE_MARGIN,
    TORQUE_MARGIN_N_M,
    WEIGHED_AGAIN,
    Corrections,
    MassEstimate,
    as_symmetric,
    reference,
)
from optimizer.codesign.estimates import Estimate, estimates
from optimizer.codesign.hardware import BASE_ENTRIES, TORQUE_DIGITS, Selection, motor_of
from optimizer.problem.brief import DesignBrief, Objective
from optimizer.problem.variables import SIDE, VARIABLES, completed, design_fields, mechanism_of

if TYPE_CHECKING:
    from delta_cad.checks.report import CheckResult
    from delta_cad.commands.pipeline import BuiltMachine, Outcome

PEAK_MARGIN = 1.02  # of the torque stated for the peak force, over what lengths and weight ask
_CABLE_MARGIN = 1.05  # of the torque that the cable is tensioned for, over the lasting one, where no peak is asked

T = TypeVar("T")


@dataclass(frozen=True)
class Candidate:
    """A design that closed forms pass, weighed.

    Attributes:
        design: As its file has it.
        choice: Its hardware.
        lengths_mm: (9) in the order of `VARIABLES`.
        corrections: What closed forms asked for; masses, once it is weighed by its own solids.
        score: What is sought, larger is better.
        weighed: Whether its weights pass, too.
    """

    design: Design
    choice: Selection
    lengths_mm: tuple[float, ...]
    corrections: Corrections
    score: float
    weighed: bool = False

    @property
    def side_mm(self) -> float:
        """Side of its cube."""
        return 2.0 * self.lengths_mm[SIDE]

    @property
    def elbow_deg(self) -> float:
        """Smallest angle between upper arm and rods over its cube."""
        design = self.design
        fold = cube_extremes(design.geometry, design.workspace, design.requirements.force_N).forearm_angle_max
        return 180.0 - math.degrees(fold.value)

    @property
    def radii_mm(self) -> dict[str, float]:
        """How far out its chains stand, and how far apart, as `as_symmetric` tells it of a placed machine."""
        if not self.choice.placed:
            radius = self.lengths_mm[VARIABLES.index("base_radius")]
            return {"base_radius": radius, "platform_radius": self.lengths_mm[VARIABLES.index("platform_radius")]}
        found = as_symmetric(completed(self.lengths_mm), self.choice.width_mm)
        least = {name: float(min(values)) for name, values in found.items()}
        return least | {"base_radius": least.pop("shoulders"), "platform_radius": least.pop("wrists")}


@dataclass(frozen=True)
class Start:
    """Where the search for a machine may begin: what closed forms pass.

    Attributes:
        choice: Hardware.
        lengths_mm: (9) in the order of `VARIABLES`.
        corrections: What they asked for.
    """

    choice: Selection
    lengths_mm: tuple[float, ...]
    corrections: Corrections


def first_corrections(brief: DesignBrief, choice: Selection, weightless: bool = False) -> Corrections:
    """Gives what is known of a choice to begin with: the rotor of its own motor, and the masses of `reference`.

    Args:
        brief: The requirements.
        choice: The hardware.
        weightless: Whether to begin with `Corrections.weightless` of it.
    """
    first = reference()
    row = motor_of(brief, choice.motor)
    masses = replace(first.masses, rotor_inertia=row.rotor_inertia_kg_m2 * choice.ratio**2)
    margin = max(TORQUE_MARGIN_N_M, TORQUE_MARGIN * choice.torque_N_m(row))
    found = Corrections(replace(first, masses=masses, ratio=choice.ratio), torque_margin_N_m=margin)
    return found.weightless() if weightless else found


def design_for(
    brief: DesignBrief,
    choice: Selection,
    lengths_mm: tuple[float, ...],
    corrections: Corrections,
    folder: Path = Path(),
) -> Design:
    """Makes the design of a candidate.

    Args:
        brief: What the customer asks; its limits become the design's requirements.
        choice: Hardware.
        lengths_mm: (9) in the order of `VARIABLES`; (6) of a three-fold symmetric machine.
        corrections: What is known of it: what gravity takes of a joint, and the machine of its outline.
        folder: Where its file will stand: a folder of own parts is named from there.

    Returns:
        The design, without provenance.

    Raises:
        DesignError: The design file refuses it.
    """
    row = motor_of(brief, choice.motor)
    values = brief.values
    fields = {name: values[name] for name in _REQUIRED if values.get(name) is not None}
    outline = brief.outline_mm or _taken(choice, lengths_mm, corrections.beyond_mm(choice.placed))
    low, high = brief.limits.shoulder_deg or (None, None)
    torque = brief.requirements.joint_torque_N_m or choice.torque_N_m(row)
    task: dict[str, Any] = {
        **fields,
        "envelope_width_mm": outline[0],
        "envelope_depth_mm": outline[1],
        "joint_torque_N_m": torque,
        "shoulder_min_deg": low,
        "shoulder_max_deg": high,
    }
    task["peak_torque_N_m"] = brief.requirements.peak_torque_N_m or _peak_torque(
        brief, lengths_mm, torque, corrections.held_torque_N_m, choice.peak_torque_N_m(row)
    )
    mechanism, cube = design_fields(lengths_mm)
    data = {
        "schema": "delta-design/1",
        "name": brief.name,
        "mechanism": {**mechanism, "parallelogram_width_mm": choice.width_mm},
        "cube": cube,
        "requirements": {name: value for name, value in task.items() if value is not None},
        "hardware": brief.hardware_from(folder, _allowed(brief, {**BASE_ENTRIES, **choice.hardware(row)})),
    }
    if brief.panel is not None:
        data["panel"] = brief.panel.model_dump()
    return design_from_dict(data, brief.name, folder)


_REQUIRED = (
    "force_N",
    "peak_force_N",
    "kappa_max",
    "couple_index_min",
    "effective_mass_max_kg",
    "friction_max_N",
    "position_step_max_mm",
    "lean_max_deg",
    "elbow_angle_min_deg",
    "stiffness_min_N_mm",
    "height_max_mm",
    "clearance_min_mm",
    "gravity_m_s2",
)
"""Fields of a brief that a design states as they are."""


def _allowed(brief: DesignBrief, entries: Mapping[str, Any]) -> dict[str, Any]:
    """The entries of a hardware that the brief leaves open, or has among what may be used; a ratio is between two."""
    stated = brief.choices
    free = "capstan_ratio", *(entry for entry in entries if entry not in brief.hardware)
    return {entry: value for entry, value in entries.items() if entry in free or value in stated[entry]}


def _taken(choice: Selection, lengths_mm: Sequence[float], overhead_mm: tuple[float, float]) -> tuple[float, float]:
    """The outline of a machine, by eq. (1) and what its hardware takes beyond, in whole millimetres."""
    limit = Outline(0.0, 0.0, choice.width_mm, overhead_mm)
    width, depth = limit.size_mm(*outline_arguments(lengths_mm))
    return math.ceil(float(width)), math.ceil(float(depth))


def outline_arguments(lengths_mm: Sequence[float]) -> tuple[float, float, float]:
    """Gives R_0 + L_A, R_1 - R_0 in mm and cos phi, of which the outline of points and bars depends."""
    upper_arm, _, base, *_, shift, cosine, _ = completed(lengths_mm).tolist()
    return base + upper_arm, shift, cosine


def _peak_torque(brief: DesignBrief, lengths_mm: Sequence[float], torque: float, gravity: float, given: float) -> float:
    """The torque of a joint for the peak force with the weight; where none is asked a little over the lasting one.

    It is no more than the motor gives, of which nobody may have told a peak.
    """
    force, digits = brief.requirements.peak_force_N, 10**TORQUE_DIGITS
    needed = torque * _CABLE_MARGIN if force is None else (worst_torque(lengths_mm, force) + gravity) * PEAK_MARGIN
    return max(torque, min(math.ceil(needed * digits), math.floor(given * digits)) / digits)


def worst_torque(lengths_mm: Sequence[float], force: float) -> float:
    """Computes the largest joint torque over a cube, N m.

    Args:
        lengths_mm: (9) in the order of `VARIABLES`.
        force: In any direction, N.
    """
    (g, cube), limit = mechanism_of(lengths_mm), Torque(force, 1.0)
    return worst_of(CubeSearch(cube), g, limit, limit.figures[0]).value


def moment_torque_N_m(brief: DesignBrief, lengths_mm: Sequence[float], gravity: float) -> float:
    """Computes the most torque of a joint for a moment, N m: for the peak force, and what gravity takes."""
    return worst_torque(lengths_mm, brief.requirements.peak_force_N or brief.requirements.force_N) + gravity


def effective_mass_kg(candidate: Candidate) -> float:
    """Estimates the largest effective mass at the handle of a candidate over its cube, kg, with the masses known."""
    upper_arm, forearm, *_ = candidate.lengths_mm
    inertia = candidate.corrections.mass_estimate.inertia(upper_arm, forearm, candidate.choice.ratio)
    limit, design = EffectiveMass(1.0, inertia), candidate.design
    return worst_of(CubeSearch(design.workspace), design.geometry, limit, limit.figures[0]).value


def with_gravity_torque(design: Design, corrections: Corrections) -> Corrections:
    """Raises the gravity torque to the lower bound that closed-form masses give, before solids exist.

    Returns:
        The same where that is no more than what is taken for it.
    """
    from delta_cad.dimensions import dimensions
    from delta_cad.structure.hardware.overloads import gravity_share_N_m

    least, known = gravity_share_N_m(dimensions(design)), corrections.mass_estimate
    if least <= known.gravity_torque_N_m * (1.0 + WEIGHED_AGAIN):
        return corrections
    why = f"weight: {least:.3g} N m of a joint at least"
    return corrections.updated(why, mass_estimate=replace(known, gravity_torque_N_m=least))


def weigh(design: Design, begin: Callable[[str], None]) -> tuple[MassEstimate, list[CheckResult]]:
    """Makes the solids of a design, weighs them and takes their outline; loads the CAD kernel.

    Returns:
        weighed: What they weigh.
        results: The checks that this decides.

    Raises:
        BuildError: A solid could not be built.
    """
    from delta_cad.commands.pipeline import check_weighed

    machine = solid(design, begin)
    return mass_estimate_of(design, machine.masses), check_weighed(machine)


def _last(memo: dict[str, T], design: Design, compute: Callable[[], T]) -> T:
    """Computes something of a design, once for one after the other that are equal."""
    key = design_hash(design)
    if key not in memo:
        found = compute()
        memo.clear()
        memo[key] = found
    return memo[key]


_REFUSED: dict[str, tuple[Estimate, ...]] = {}  # what does not bind a design may be raised several times
_MADE: dict[str, BuiltMachine] = {}  # what is weighed is looked at next


def refused(design: Design) -> tuple[Estimate, ...]:
    """Gives why closed forms refuse a design of a search, with estimates.

    Raises:
        UnreachableError: A point of the cube is out of reach.
    """
    return _last(_REFUSED, design, lambda: estimates(design))


def solid(design: Design, begin: Callable[[str], None]) -> BuiltMachine:
    """Makes the solids of a design; `begin` is called before each part. Raises as `make_machine` and `begin` do."""
    from delta_cad.commands.pipeline import make_machine

    return _last(_MADE, design, lambda: make_machine(design, begin))


def ball_joint_friction(design: Design) -> tuple[float, float]:
    """Bounds the friction of a design's ball joints at the knob: along z, and perpendicular to z, N."""
    found = known_joints(design)["friction"]
    return (0.0, 0.0) if found is None else (found.upright, found.level)


def mass_estimate_of(design: Design, report: Mapping[str, Any]) -> MassEstimate:
    """Reads the masses of a machine that was made."""
    m, g = design.mechanism, design.geometry
    masses = masses_from_dict(report, g.forearm_length, drive_torque(design))
    held = held_masses(design.name, report["bodies"], design)
    force, torque = design.requirements.force_N, design.requirements.joint_torque_N_m
    limit, bare = HoldingTorque(force, torque, held), Torque(force, torque)
    search = CubeSearch(design.workspace)
    most, least = (worst_of(search, g, one, one.figures[0]).value for one in (limit, bare))
    return MassEstimate(
        masses, max(most - least, 0.0), m.upper_arm_length_mm, m.forearm_length_mm, drive_torque(design).ratio, own=True
    )


def reported(objective: Objective, outcome: Outcome) -> float | None:
    """Gives what is reported of a machine that was built, of what is to be least.

    Returns:
        Width and depth of the swept machine together, mm; its worst effective mass, kg; its price, EUR. None where the
        cube is sought, or that was not found.
    """
    if objective == "cost":
        return outcome.cost_EUR
    names = {"outline": ("envelope width", "envelope depth"), "effective_mass": ("effective mass",)}.get(objective, ())
    values = [one.value for one in outcome.results if one.name in names and one.value is not None]
    return sum(values) if names and len(values) == len(names) else None
