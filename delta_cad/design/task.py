"""What a customer asks for, as a design file and a file of requirements both state it."""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import BaseModel, ConfigDict, Field

from delta_cad.mechanism.limits import LIMITS
from delta_cad.mechanism.limits.torque import RANGE

LEAST = RANGE[0]  # N and N m: the proof of the torque takes none below
GRAVITY_MAX = 100.0  # m/s^2, ten times the Earth's: a larger figure is a wrong unit

_Component = Annotated[float, Field(ge=-GRAVITY_MAX, le=GRAVITY_MAX)]
# JSON and TOML have lists, not tuples; the numbers inside stay strict
Gravity = Annotated[
    tuple[_Component, _Component, _Component], Field(strict=False, description="gravity in the base frame")
]


class Section(BaseModel):
    """A part of a file: no unknown key, no number that is not finite, nothing converted."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, allow_inf_nan=False)


class Task(Section):
    """What the customer asks for: table `[requirements]`."""

    envelope_width_mm: float = Field(ge=10, le=5000, description="W of the horizontal outline; may be turned")
    envelope_depth_mm: float = Field(ge=10, le=5000, description="D of the horizontal outline; may be turned")
    height_max_mm: float | None = Field(
        default=None, gt=0, le=5000, description="height, from the mounting surface to the knob's top at the cube's top"
    )
    force_N: float = Field(ge=LEAST, le=1000, description="force at the handle, any direction, anywhere in the cube")
    joint_torque_N_m: float = Field(
        ge=LEAST, le=100, description="continuous torque that each joint must give, weight included"
    )
    peak_force_N: float | None = Field(
        default=None, gt=0, le=1000, description="force at the handle for the motor's peak time, any direction"
    )
    peak_torque_N_m: float | None = Field(
        default=None, gt=0, le=100, description="torque each joint must give for the motor's peak time"
    )
    stiffness_min_N_mm: float | None = Field(
        default=None, gt=0, le=1000, description="least stiffness at the knob, any direction, actuators held"
    )


def limit_fields() -> dict[str, Any]:
    """Gives the optional fields of all limits, as pydantic declares fields."""
    stated = (field for limit in LIMITS for field in limit.fields_)
    return {f.name: (float | None, Field(default=None, description=f.description, **f.bounds)) for f in stated}
