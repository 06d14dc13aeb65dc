"""The customer's brief: the requirements file as `design` reads it, where a name and an outline or a cube are enough.

A file of the first edition (`optimizer.problem.requirements`) is a brief, too; what stands elsewhere there is put in
its place, so that the record has each number once. A file that is refused is told with all its faults.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import partial
from pathlib import Path
from typing import Annotated, Any, Literal, Optional

from pydantic import BaseModel, Field, JsonValue, PrivateAttr, create_model

from delta_cad import catalogue
from delta_cad.common.refusal import short
from delta_cad.common.units import DOWN
from delta_cad.design import NAME_PATTERN
from delta_cad.design.feel_defaults import COUPLE_INDEX
from delta_cad.design.record import Panel
from delta_cad.design.task import LEAST, Gravity, Section, Task, limit_fields
from optimizer.problem.contradictions import beyond_proof, limit_values, peaks, swapped
from optimizer.problem.hardware import check_choices, choices, own_folder, placed_hardware
from optimizer.problem.requirements import (
    LENGTH_MAX_MM,
    AngleBounds,
    Bounds,
    InertiaTable,
    JointTable,
    LimitTable,
    Step3,
    read_toml,
    requirements_hash,
)
from optimizer.problem.validation import Fault, Found, read

Objective = Literal["cube_side", "effective_mass", "outline", "cost"]
Placement = Literal["rectangle", "symmetric"]
_CAPSTAN = ("capstan_ratio", "sector_radius_mm", "cable")  # hardware that a direct drive has not
IN_RECTANGLE = ("cube_side", "effective_mass")  # what is sought within a rectangle; the others look for the least one
_LEAST_OUTLINE_MM = 50.0  # of a machine: less is another unit
_SIGNS = ("gt", "ge", "lt", "le")


def _optional(model: type[BaseModel]) -> dict[str, Any]:
    """Gives the fields of a record, each optional with default None."""
    fields: dict[str, Any] = {}
    for name, info in model.model_fields.items():
        bounds = {s: getattr(m, s) for m in info.metadata for s in _SIGNS if getattr(m, s, None) is not None}
        other = [m for m in info.metadata if not any(hasattr(m, s) for s in _SIGNS)]
        kind = Annotated[(info.annotation, *other)] if other else info.annotation
        fields[name] = (Optional[kind], Field(default=None, description=info.description, **bounds))  # noqa: UP045
    return fields


class BriefRequirements(Section):
    """What the customer asks for: table `[requirements]`."""

    envelope_width_mm: float | None = Field(
        default=None,
        ge=_LEAST_OUTLINE_MM,
        le=5000,
        description="largest width of the swept machine, motors and their leads included",
    )
    envelope_depth_mm: float | None = Field(
        default=None, ge=_LEAST_OUTLINE_MM, le=5000, description="largest depth; width and depth may be exchanged"
    )
    height_max_mm: float | None = Field(
        default=None,
        gt=0,
        le=5000,
        description="largest height, from the mounting surface to the knob's top with the handle at the cube's top",
    )
    force_N: float = Field(
        default=3.0,
        ge=LEAST,
        le=1000,
        description="continuous force in any direction, anywhere in the cube, on top of the weight",
    )
    peak_force_N: float | None = Field(
        default=None, gt=0, le=1000, description="force for the motor's peak time, any direction, anywhere in the cube"
    )
    cube_side_mm: float | None = Field(
        default=None, ge=1, le=2 * LENGTH_MAX_MM, description="least side of the cube; left out: as large as it can be"
    )
    clearance_min_mm: float = Field(default=2.0, ge=0, le=100, description="between bodies that are not neighbours")
    joint_torque_N_m: float | None = Field(
        default=None, ge=LEAST, le=100, description="continuous torque of a joint; left out: what the drive gives"
    )
    peak_torque_N_m: float | None = Field(
        default=None, gt=0, le=100, description="torque of a joint for the peak time; left out: what the drive gives"
    )
    stiffness_min_N_mm: float | None = Field(
        default=None, gt=0, le=1000, description="as in [feel], where the record has it"
    )
    gravity_m_s2: Gravity = DOWN


_FEEL: dict[str, Any] = _optional(Task) | limit_fields()
# What is about feel of the fields that limits declare, and what is asked of a machine beside these.
FEEL = (
    "kappa_max",
    "effective_mass_max_kg",
    "couple_index_min",
    "friction_max_N",
    "position_step_max_mm",
    "stiffness_min_N_mm",
)
_Felt: Any = create_model("_Felt", __base__=Section, **{name: _FEEL[name] for name in FEEL})
_Limited: Any = create_model("_Limited", __base__=Section, **_optional(LimitTable))
_Bounded: Any = create_model("_Bounded", __base__=Section, **_optional(Bounds))


class Feel(_Felt):
    """What the handle must feel like at every place of the cube: table `[feel]`; what is left out is not asked."""


class BriefLimits(_Limited):
    """What the mechanism must keep beside what is asked: table `[limits]`; what is left out is what its parts allow."""

    # In a brief that was read only the angles, `outline_radius_max_mm`, `parallelogram_width_mm` and what `notes` tells
    # stand here; everything else of the first edition's table is in `[requirements]` or `[feel]` then.


class BriefBounds(_Bounded):
    """Range of each design variable: table `[bounds_mm]`; equal bounds fix it, left out it is sought everywhere."""


class Goal(Section):
    """What is sought among the machines that do all that is asked: table `[goal]`, one of the two."""

    maximize: Literal["cube_side"] | None = Field(default=None, description="the largest cube")
    minimize: Literal["effective_mass", "outline", "cost"] | None = Field(
        default=None, description="the least mass felt, outline or price, with the cube that is asked"
    )


# Where the first edition has a field -> where a brief has it.
MOVED = {
    "requirements.stiffness_min_N_mm": "feel.stiffness_min_N_mm",
    "limits.clearance_min_mm": "requirements.clearance_min_mm",
    "limits.gravity_m_s2": "requirements.gravity_m_s2",
    **{f"limits.{name}": f"feel.{name}" for name in FEEL if name in BriefLimits.model_fields},
}
# Fields of the first edition that `design` does not use, and why.
UNUSED = {
    "limits.outline_overhead_mm": "the outline is that of the machine itself",
    "limits.height_beyond_mm": "the height is that of the machine itself",
    "limits.joint_diameter_mm": "joints are those of the machine itself",
    "limits.gravity_torque_N_m": "the machine's own weight is counted",
    "step_3": "the third step is the paper's: requirements.cube_side_mm asks for a cube",
    "inertia": "the masses are those of the machine itself",
    "joints": "the joints are those of the machine itself",
}


class DesignBrief(Section):
    """One task for `design`: what the customer asks, what may be used, what is sought."""

    name: str = Field(pattern=NAME_PATTERN, description="name of the design and of its folder")
    requirements: BriefRequirements = Field(default_factory=BriefRequirements)
    feel: Feel = Field(default_factory=Feel)
    hardware: dict[str, JsonValue] = Field(
        default_factory=dict, description="entries of a design's hardware: a value, or a list of what may be used"
    )
    panel: Panel | None = Field(default=None, description="over the machine, passed by the stem; left out: none")
    placement: Placement | None = Field(
        default=None, description="of the chains: for the outline, or three-fold symmetric; left out: what pays"
    )
    goal: Goal = Field(default_factory=Goal)
    bounds_mm: BriefBounds = Field(default_factory=BriefBounds)
    bounds_deg: AngleBounds | None = None
    limits: BriefLimits = Field(default_factory=BriefLimits)
    step_3: Step3 | None = None
    inertia: InertiaTable | None = None
    joints: JointTable | None = None
    _own_folder: Path | None = PrivateAttr(default=None)
    _own_parts: catalogue.OwnParts | None = PrivateAttr(default=None)
    _notes: tuple[str, ...] = PrivateAttr(default=())
    _stated: frozenset[str] = PrivateAttr(default=frozenset())

    @property
    def outline_mm(self) -> tuple[float, float] | None:
        """Largest width and depth, mm; None where the outline is free."""
        width, depth = self.requirements.envelope_width_mm, self.requirements.envelope_depth_mm
        return None if width is None or depth is None else (width, depth)

    @property
    def objective(self) -> Objective:
        """What is sought: the largest cube, or the least of the others."""
        return self.goal.minimize or "cube_side"

    @property
    def placeable(self) -> bool:
        """Whether chains may be placed for the outline: not asked otherwise, and the rectangle is a limit of what is
        sought.
        """
        rectangle = self.outline_mm is not None and self.limits.outline_radius_max_mm is None
        return self.placement != "symmetric" and rectangle and self.objective in IN_RECTANGLE

    @property
    def values(self) -> dict[str, Any]:
        """Fields of `[requirements]`, `[limits]` and `[feel]` by name, as limits are made from: what is not None.

        What `notes` tells is left out, for the machine itself has these: who makes limits adds them, and the masses.
        """
        tables = {name: getattr(self, name).model_dump() for name in ("limits", "requirements", "feel")}
        known = {f"{t}.{f}": value for t, fields in tables.items() for f, value in fields.items() if value is not None}
        return limit_values({field: value for field, value in known.items() if field not in UNUSED})

    @property
    def couple_index_min(self) -> float:
        """Least rotational stiffness index of a candidate: the set limit, or the default."""
        return self.feel.couple_index_min or COUPLE_INDEX

    @property
    def choices(self) -> dict[str, tuple[Any, ...]]:
        """What may be used, as `optimizer.problem.hardware.choices` lists it: entry of the hardware -> values."""
        return choices(self.hardware, self._own_parts)

    @property
    def own_parts(self) -> catalogue.OwnParts | None:
        """The user's own parts, whose ids are among the choices; they were read with the file."""
        return self._own_parts

    @property
    def notes(self) -> tuple[str, ...]:
        """Fields that the file states and `design` does not use, one line each with the reason."""
        return self._notes

    @property
    def stated(self) -> frozenset[str]:
        """Table and field of what the file sets, where a brief has it; all else is a default."""
        return self._stated

    def value(self, field: str) -> float | None:
        """Gives the value of a table and field; None where nothing is set and there is no default."""
        table, name = field.split(".")
        value: float | None = getattr(getattr(self, table), name)
        return value

    def with_values(self, values: Mapping[str, float | None]) -> DesignBrief:
        """Gives the same task with other values of some fields, each named by its table and field."""
        changed: dict[str, Any] = {}
        for field, value in values.items():
            table, name = field.split(".")
            changed[table] = changed.get(table, getattr(self, table)).model_copy(update={name: value})
        return self.model_copy(update=changed)

    def hardware_from(self, folder: Path, chosen: Mapping[str, Any]) -> dict[str, Any]:
        """Makes the hardware of a design file.

        Args:
            folder: Folder of the design file, from which it names that of own parts.
            chosen: What was chosen, by entry; of the others the first of what is stated is taken.
        """
        return placed_hardware(self.hardware | dict(chosen), self._own_folder, folder)


def load_brief(path: str | Path, own_parts: Path | None = None) -> DesignBrief:
    """Reads and validates a requirements file of either edition as a brief.

    Args:
        path: TOML file, UTF-8.
        own_parts: Folder of the user's own parts, in place of the one that `hardware.catalogue` names beside the file.

    Returns:
        The brief, with all defaults filled in and its goal settled.

    Raises:
        RequirementsError: Unreadable, not TOML, or anything `brief_from_dict` refuses.
    """
    path = Path(path)
    name = path.name or str(path)  # of "." nothing is left
    return brief_from_dict(read_toml(path, name), name, path.parent, own_parts)


def brief_from_dict(
    data: object, file: str = "requirements", folder: Path = Path(), own_parts: Path | None = None
) -> DesignBrief:
    """Validates a brief given as plain data.

    Args:
        data: What the TOML file holds: nested dicts, lists, numbers, strings.
        file: Name that error messages start with.
        folder: Folder that `hardware.catalogue` starts from.
        own_parts: Folder of the user's own parts, in place of that one.

    Returns:
        The brief, with all defaults filled in and its goal settled.

    Raises:
        RequirementsError: All that is wrong, the first as the error and the others as its `more`: fields as `read`
            refuses them, hardware as `check_choices` does, a field that stands in two tables, numbers that contradict
            each other, an outline of which one side is missing, a goal that what is given does not bound.
    """
    checked = partial(check_choices, file=file, folder=folder, own_parts=own_parts)
    record, stated = read(DesignBrief, data, file, _contradictions, checked)
    brief = _settled(record, stated)
    brief._own_folder = own_folder(brief.hardware, folder, own_parts)
    if brief._own_folder is not None:
        brief._own_parts = catalogue.own_parts(brief._own_folder)
    brief._stated = frozenset(MOVED.get(one, one) for one in stated)
    brief._notes = (*_notes(stated), *_unused_capstan_hardware(brief), *_unused_placement(brief, brief._stated))
    return brief


def brief_hash(brief: DesignBrief) -> str:
    """Computes the SHA-256, 64 hex digits, of the canonical JSON: the same for a number wherever the file has it."""
    return requirements_hash(brief)


def _settled(brief: DesignBrief, stated: frozenset[str]) -> DesignBrief:
    """Moves the first edition's fields to their places and sets the default goal where none is stated."""
    tables = {name: getattr(brief, name).model_dump() for name in ("requirements", "limits", "feel")}
    for old, new in MOVED.items():
        if old in stated:
            (table, name), (place, _) = old.split("."), new.split(".")
            tables[place][name], tables[table][name] = tables[table][name], None
    kinds: dict[str, type[BaseModel]] = {"requirements": BriefRequirements, "limits": BriefLimits, "feel": Feel}
    changed: dict[str, Any] = {name: kind.model_validate(tables[name]) for name, kind in kinds.items()}
    task = changed["requirements"]
    if brief.goal.maximize is None and brief.goal.minimize is None:
        free = task.cube_side_mm is not None and task.envelope_width_mm is None
        changed["goal"] = Goal(minimize="outline") if free else Goal(maximize="cube_side")
    return brief.model_copy(update=changed)


def _notes(stated: frozenset[str]) -> Iterator[str]:
    for field, why in UNUSED.items():
        if field in stated or any(one.startswith(f"{field}.") for one in stated):
            yield f"{field} is not used by design: {why}"


def _unused_capstan_hardware(brief: DesignBrief) -> Iterator[str]:
    """Notes capstan hardware that is stated although only direct drives may be used."""
    for entry in _CAPSTAN if "capstan" not in brief.choices["drive"] else ():
        if entry in brief.hardware:
            yield f"hardware.{entry} is not used by design: it is a capstan's, and all that may be used is direct"


def _unused_placement(brief: DesignBrief, stated: frozenset[str]) -> Iterator[str]:
    """Notes bounds of a placement that is three-fold symmetric."""
    for field in _SYMMETRIC if not brief.placeable else ():
        if field in stated:
            yield f"{field} is not used by design: the chains are three-fold symmetric"


def _contradictions(found: Found) -> Iterator[Fault]:
    """Finds contradictory or insufficient requirements among the fields that are not refused."""
    known = found.known
    for old, new in MOVED.items():
        if {old, new} <= found.stated:
            yield old, short(known[old]) if old in known else "", f"must stand here or in {new}, not in both"
    yield from swapped(known)
    yield from peaks(known)
    yield from beyond_proof({f: v for f, v in known.items() if f not in UNUSED}, {})
    if not found.refused & {"", "requirements", "requirements.cube_side_mm", *_SIDES}:
        yield from _not_bounded(known)
    yield from _placement(found)
    limit, least = known.get("panel.limit_mm"), known.get("requirements.clearance_min_mm", 0.0)
    if limit is not None and limit <= least and any(one.partition(".")[0] == "panel" for one in found.stated):
        allowed = f"must be > requirements.clearance_min_mm = {least:g} mm, which the stem keeps within the cube"
        yield "panel.limit_mm", short(limit), allowed
    side, highest = known.get("requirements.cube_side_mm"), known.get("bounds_mm.half_side")
    if side is not None and highest is not None and side > 2.0 * highest[1]:
        allowed = f"must be <= {2.0 * highest[1]:g} mm, twice the largest bounds_mm.half_side"
        yield "requirements.cube_side_mm", short(side), allowed
    if side is not None and side >= (most := known.get("requirements.height_max_mm", side + 1.0)):
        yield "requirements.height_max_mm", short(most), f"must be > requirements.cube_side_mm = {side:g} mm"
    for sides in _SIDES:
        if side is not None and sides in known and side > known[sides]:
            allowed = f"must be <= {sides} = {known[sides]:g} mm: the swept outline holds the cube"
            yield "requirements.cube_side_mm", short(side), allowed


_SIDES = ("requirements.envelope_width_mm", "requirements.envelope_depth_mm")


_SYMMETRIC = {"bounds_mm.side_shift": 0.0, "bounds_mm.centre_x": 0.0, "bounds_deg.azimuth": 120.0}
"""Bounds of the placement -> its value in a three-fold symmetric machine."""


def _placement(found: Found) -> Iterator[Fault]:
    """Finds a placement for a rectangle that is no limit of what is sought, and bounds without a symmetric machine."""
    for field, value in _SYMMETRIC.items():
        low, high = found.known.get(field, (value, value))
        if low <= high and not low <= value <= high:  # else they are swapped, which is said
            allowed = f"must hold {value:g}, that of the three-fold symmetric machine from which design begins"
            yield field, short([low, high]), allowed
    known, free = found.known, [side for side in _SIDES if side not in found.known]
    if known.get("placement") != "rectangle" or found.refused & set(_SIDES):
        return
    radius, least = known.get("limits.outline_radius_max_mm"), known.get("goal.minimize")
    why = ""
    if free:
        why = f"an outline: state {' and '.join(_SIDES)}"
    elif radius is not None:
        why = f"the outline as limit: leave limits.outline_radius_max_mm = {radius:g} out, which stands in its place"
    elif least is not None and least not in IN_RECTANGLE:
        why = f"{' or '.join(IN_RECTANGLE)} as goal: with goal.minimize = {short(least)} the least outline is symmetric"
    if why:
        yield "placement", short("rectangle"), f'needs {why}; or write placement = "symmetric"'


def _not_bounded(known: Mapping[str, Any]) -> Iterator[Fault]:
    """Finds an outline with one side missing, and a goal without the requirement that bounds it."""
    missing = [side for side in _SIDES if side not in known]
    cube, outline = "requirements.cube_side_mm" in known, not missing
    most, least = known.get("goal.maximize"), known.get("goal.minimize")
    both = " and ".join(_SIDES)
    if len(missing) == 1:
        yield missing[0], "", f"is missing: an outline needs both, {both}, or neither"
    elif not outline and not cube:
        yield "requirements", "", f"must state an outline, {both}, or a cube, requirements.cube_side_mm"
    elif most is not None and not outline:
        yield "goal.maximize", short(most), f'needs an outline: state {both}, or minimize = "outline"'
    if most is not None and least is not None:
        yield "goal", short({"maximize": most, "minimize": least}), "must be one of the two"
    elif least is not None and not cube:
        yield (
            "goal.minimize",
            short(least),
            "needs a cube, or the least machine has none: state requirements.cube_side_mm",
        )
