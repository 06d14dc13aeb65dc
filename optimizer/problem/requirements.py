"""The requirements file: what the customer gives and the bounds of the search; read, validated, hashed.

A file that is refused says which field, its value and what is allowed, in one line (`RequirementsError`).
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator
from functools import partial
from math import radians
from pathlib import Path
from typing import Annotated, Any, ClassVar

from pydantic import BaseModel, Field, JsonValue, PrivateAttr, create_model

from delta_cad.common.reading import MOST_TOML_BYTES, ReadError, parse_toml, read_bounded
from delta_cad.common.refusal import short
from delta_cad.common.units import DOWN
from delta_cad.design import NAME_PATTERN, Hardware
from delta_cad.design.task import Gravity, Section, Task, limit_fields
from delta_cad.mechanism.geometry import AZIMUTH_MAX_DEG, AZIMUTH_MIN_DEG, azimuth_cosine
from delta_cad.mechanism.limits import HandleFriction, HandleInertia
from optimizer.problem.contradictions import SHOULDER, beyond_proof, peaks, swapped
from optimizer.problem.hardware import check_hardware, first_hardware, own_folder, placed_hardware
from optimizer.problem.validation import Fault, Found, RequirementsError, read
from optimizer.problem.variables import COSINE, SYMMETRIC, VARIABLES

LENGTH_MAX_MM = 1000.0  # the design file's own limit: above it the unit is wrong
_BALL = "ball_diameter_mm"  # hardware that the lengths must leave room for
_CLEARANCE = "between bodies that are not neighbours; the search keeps it between neighbouring wrist joints"


# [lower, upper]: TOML has lists, not tuples; the numbers inside stay strict
_Length = Annotated[float, Field(ge=1, le=LENGTH_MAX_MM)]
_Height = Annotated[float, Field(ge=1, le=2 * LENGTH_MAX_MM)]
_Side = Annotated[float, Field(ge=0, le=LENGTH_MAX_MM)]
_Shift = Annotated[float, Field(ge=-LENGTH_MAX_MM, le=LENGTH_MAX_MM)]
_Azimuth = Annotated[float, Field(ge=AZIMUTH_MIN_DEG, le=AZIMUTH_MAX_DEG)]
_Degrees = Annotated[float, Field(ge=-180, le=180)]
Length = Annotated[tuple[_Length, _Length], Field(strict=False)]
Height = Annotated[tuple[_Height, _Height], Field(strict=False)]
_HalfSide = Annotated[tuple[_Side, _Side], Field(strict=False)]
_Shifts = Annotated[tuple[_Shift, _Shift], Field(strict=False)]
_Azimuths = Annotated[tuple[_Azimuth, _Azimuth], Field(strict=False)]
_Angle = Annotated[tuple[_Degrees, _Degrees], Field(strict=False)]
_Overhead = Annotated[tuple[_Side, _Side], Field(strict=False)]


class Bounds(Section):
    """Range of each design variable, mm; equal bounds fix it: table `[bounds_mm]`."""

    upper_arm_length: Length = Field(description="L_A: shoulder to elbow")
    forearm_length: Length = Field(description="L_B: elbow to wrist")
    base_radius: Length = Field(description="R: base centre to shoulder axis")
    platform_radius: Length = Field(description="r: platform centre to wrist")
    bottom_height: Height = Field(description="H: bottom face of the cube over the plane of the shoulder axes")
    half_side: _HalfSide = Field(description="L: half the side of the cube")
    side_shift: _Shifts | None = Field(
        default=None, description="R_1 - R: how much farther out chains 1 and 2 stand than chain 0; left out: 0"
    )
    centre_x: _Shifts | None = Field(
        default=None, description="x_c: how far the cube's middle stands off the axis, towards chain 0; left out: 0"
    )


class AngleBounds(Section):
    """Range of the design variable that is an angle, deg; equal bounds fix it: table `[bounds_deg]`."""

    azimuth: _Azimuths | None = Field(
        default=None, description="phi: chains 1 and 2 stand at phi and -phi from chain 0; left out: 120"
    )


class _Hardware(Section):
    outline_radius_max_mm: float | None = Field(default=None, gt=0, le=5000, description="largest R + L_A")
    parallelogram_width_mm: float = Field(default=48.0, gt=0, le=500, description="L_c: distance of a forearm's rods")
    outline_overhead_mm: _Overhead = Field(default=(0.0, 0.0), description="hardware over eq. (1): along W, along D")
    height_beyond_mm: float | None = Field(
        default=None, ge=0, le=5000, description="of the height, below the shoulder axes and above the wrists"
    )


_Limited: Any = create_model(
    "_Limited",
    __base__=_Hardware,
    **{name: field for name, field in limit_fields().items() if name not in SHOULDER},
)


class LimitTable(_Limited):
    """What the hardware asks beyond the paper; all optional: table `[limits]`."""

    shoulder_deg: _Angle | None = Field(default=None, description="smallest and largest shoulder angle")
    clearance_min_mm: float | None = Field(default=None, ge=0, le=100, description=_CLEARANCE)
    joint_diameter_mm: float = Field(default=8.0, gt=0, le=100, description="ball joint at a rod's end")
    gravity_torque_N_m: float = Field(default=0.0, ge=0, le=100, description="taken off each joint's torque")
    gravity_m_s2: Gravity = DOWN


class InertiaTable(Section):
    """What moves, as the effective mass at the handle sees it: table `[inertia]`."""

    carried_mass_kg: float = Field(gt=0, le=1000, description="platform and the rods' share that moves with it")
    elbow_mass_kg: float = Field(ge=0, le=1000, description="one chain's rods, share that moves with the elbow")
    cross_mass_kg: float = Field(ge=-1000, le=1000, description="one chain's rods, share that couples both ends")
    joint_inertia_kg_m2: float = Field(ge=0, le=1000, description="upper arm, rotor and pinion about the joint")


class JointTable(Section):
    """Friction and encoder of a joint, as limits on the feel see them: table `[joints]`."""

    friction_N_m: float | None = Field(default=None, ge=0, le=100, description="Coulomb friction of a joint's drive")
    ball_upright_N: float = Field(default=0.0, ge=0, le=1000, description="of all ball joints, for a motion along z")
    ball_level_N: float = Field(default=0.0, ge=0, le=1000, description="the same for motions square to z")
    encoder_count_deg: float | None = Field(default=None, gt=0, le=180, description="turn of a joint for one count")

    @property
    def known(self) -> dict[str, Any]:
        """What limits are made from."""
        drive, count = self.friction_N_m, self.encoder_count_deg
        sources = None if drive is None else HandleFriction(drive, self.ball_upright_N, self.ball_level_N)
        return {"friction": sources, "encoder_count": None if count is None else radians(count)}


class Step3(Section):
    """The third step: table `[step_3]`."""

    half_side_mm: float | None = Field(default=None, gt=0, le=LENGTH_MAX_MM, description="L; else what step 2 reached")


class Requirements(Section):
    """One task for the optimiser."""

    name: str = Field(pattern=NAME_PATTERN, description="name of the design")
    requirements: Task
    bounds_mm: Bounds
    bounds_deg: AngleBounds | None = None
    limits: LimitTable = Field(default_factory=LimitTable)
    step_3: Step3 = Field(default_factory=Step3)
    inertia: InertiaTable | None = None
    joints: JointTable | None = None
    hardware: dict[str, JsonValue] | None = Field(default=None, description="of the design; lists: what may be used")
    _own_parts: Path | None = PrivateAttr(default=None)
    # Fields of the second edition alone (`optimizer.problem.brief`), which are reported as such.
    second_edition: ClassVar[tuple[str, ...]] = (
        *("feel", "goal", "placement"),
        *(f"requirements.{name}" for name in ("cube_side_mm", "clearance_min_mm", "gravity_m_s2")),
    )

    def hardware_from(self, folder: Path) -> dict[str, Any]:
        """Gives the hardware of a design file in a folder: what is stated, the first of each list."""
        return placed_hardware(self.hardware or {}, self._own_parts, folder)

    @property
    def ranges(self) -> tuple[tuple[float, float], ...]:
        """(9) lower and upper bound in the order of `VARIABLES`, mm; of the cosine without unit."""
        azimuth = None if self.bounds_deg is None else self.bounds_deg.azimuth
        found = [getattr(self.bounds_mm, n, None) or (SYMMETRIC[n], SYMMETRIC[n]) for n in VARIABLES]
        if azimuth is not None:
            found[COSINE] = azimuth_cosine(azimuth[1]), azimuth_cosine(azimuth[0])
        return tuple(found)

    @property
    def values(self) -> dict[str, Any]:
        """What limits are made from: fields of all tables by name, `inertia` and the joints where they are stated."""
        low, high = self.limits.shoulder_deg or (None, None)
        inertia = None if self.inertia is None else HandleInertia(*self.inertia.model_dump().values())
        return {
            **self.requirements.model_dump(),
            **self.limits.model_dump(),
            **dict(zip(SHOULDER, (low, high), strict=True)),
            _BALL: first_hardware(self.hardware or {}).get(_BALL, Hardware.model_fields[_BALL].default),
            "inertia": inertia,
            **(self.joints or JointTable()).known,
        }


def load_requirements(path: str | Path, own_parts: Path | None = None) -> Requirements:
    """Reads and validates a requirements file.

    Args:
        path: TOML file, UTF-8.
        own_parts: Folder of the user's own parts, in place of the one that `hardware.catalogue` names beside the file.

    Returns:
        The requirements, with all defaults filled in.

    Raises:
        RequirementsError: Unreadable, not TOML, or anything `requirements_from_dict` or `check_hardware` refuses.
    """
    path = Path(path)
    checked = partial(check_hardware, file=path.name, folder=path.parent, own_parts=own_parts)
    record, _ = read(Requirements, read_toml(path, path.name), path.name, _contradictions, checked)
    record._own_parts = own_folder(record.hardware or {}, path.parent, own_parts)
    return record


def read_toml(path: Path, name: str, refused: type[RequirementsError] = RequirementsError) -> dict[str, Any]:
    """Reads a TOML file.

    Args:
        path: The file, UTF-8.
        name: What error messages call it.
        refused: The error to raise.

    Raises:
        RequirementsError: Unreadable, or refused by `parse_toml`.
    """
    try:
        return parse_toml(read_bounded(path, MOST_TOML_BYTES), name)
    except ReadError as error:
        raise refused(name, "", "", error.allowed) from None


def requirements_from_dict(data: object, file: str = "requirements") -> Requirements:
    """Validates requirements given as plain data.

    Args:
        data: What the TOML file holds: nested dicts, lists, numbers, strings.
        file: Name that error messages start with.

    Returns:
        The requirements, with all defaults filled in.

    Raises:
        RequirementsError: A missing or unknown field, a wrong type, a number that is not finite or out of its range,
            a lower bound above its upper bound, a half side fixed at zero, no torque left beside gravity's share, a
            step 3 outside the bounds, or a name that is not safe as a file name.
    """
    return read(Requirements, data, file, _contradictions)[0]


def requirements_hash(given: BaseModel) -> str:
    """Computes the SHA-256, 64 hex digits, of the canonical JSON: sorted keys, no blanks, ASCII, defaults spelled out.

    What is not stated is left out, so that a limit that the file does not know yet changes no hash.
    """
    text = json.dumps(
        given.model_dump(mode="json", exclude_none=True), sort_keys=True, separators=(",", ":"), allow_nan=False
    )
    return hashlib.sha256(text.encode("ascii")).hexdigest()


_INERTIA = ", ".join(InertiaTable.model_fields)


def _contradictions(found: Found) -> Iterator[Fault]:
    """Finds the numbers that contradict each other whatever the design, among those that are known."""
    known = found.known
    yield from swapped(known)
    low, high = known.get("bounds_mm.half_side", (0.0, LENGTH_MAX_MM))
    yield from peaks(known)
    torque, reserve = known.get("requirements.joint_torque_N_m"), known.get("limits.gravity_torque_N_m", 0.0)
    if torque is not None and reserve >= torque:
        allowed = f"must be < requirements.joint_torque_N_m = {torque:g} N m, or nothing is left for the force"
        yield "limits.gravity_torque_N_m", short(reserve), allowed
    masses = [known[f"inertia.{name}"] for name in InertiaTable.model_fields if f"inertia.{name}" in known]
    joints = {name: known[f"joints.{name}"] for name in JointTable.model_fields if f"joints.{name}" in known}
    needed = {
        "effective_mass_max_kg": (masses, f"the masses of what moves: table [inertia] with {_INERTIA}"),
        "friction_max_N": ("friction_N_m" in joints, "what sources in a joint: joints.friction_N_m"),
        "position_step_max_mm": ("encoder_count_deg" in joints, "the count of the encoders: joints.encoder_count_deg"),
    }
    for name, (there, what) in needed.items():
        if (value := known.get(f"limits.{name}")) is not None and not there:
            yield f"limits.{name}", short(value), f"needs {what}"
    inertia = {"inertia": HandleInertia(*masses)} if len(masses) == len(InertiaTable.model_fields) else {}
    yield from beyond_proof(known, inertia | JointTable(**joints).known)
    if (side := known.get("step_3.half_side_mm")) is not None and not low <= side <= high:
        yield "step_3.half_side_mm", short(side), f"must be within bounds_mm.half_side = [{low:g}, {high:g}] mm"
