"""The limits: one module each, listed here once; whatever requires, proves or reports them goes through the list.

A new limit is its module, one line in `LIMITS` and its test.
"""
# ruff: noqa: F401  the names are for those who import the package

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Self, TypeVar

from delta_cad.mechanism.errors import GeometryError
from delta_cad.mechanism.limits.angles.elbow_angle import ElbowAngle
from delta_cad.mechanism.limits.angles.lean import Lean
from delta_cad.mechanism.limits.angles.shoulder import Shoulder
from delta_cad.mechanism.limits.assembly_mode import AssemblyMode
from delta_cad.mechanism.limits.couple_index import CoupleIndex
from delta_cad.mechanism.limits.effective_mass import EffectiveMass, HandleInertia
from delta_cad.mechanism.limits.friction import Friction, HandleFriction
from delta_cad.mechanism.limits.holding_torque import HeldMasses, HoldingTorque
from delta_cad.mechanism.limits.kappa import Kappa
from delta_cad.mechanism.limits.lengths.elbow_outside import ElbowOutside
from delta_cad.mechanism.limits.lengths.height import Height
from delta_cad.mechanism.limits.lengths.outline import Outline
from delta_cad.mechanism.limits.lengths.wrist_clearance import BallClearance, WristClearance
from delta_cad.mechanism.limits.limit import DesignBounds, Field, FigureOfMerit, Limit, PoseLimit, Values
from delta_cad.mechanism.limits.position_step import PositionStep
from delta_cad.mechanism.limits.reach import Reach
from delta_cad.mechanism.limits.torque import Torque

Kind = TypeVar("Kind", bound=PoseLimit)

LIMITS: tuple[type[Limit], ...] = (
    Outline,
    Height,
    ElbowOutside,
    BallClearance,
    Reach,
    AssemblyMode,
    Torque,
    HoldingTorque,
    Kappa,
    Lean,
    Shoulder,
    ElbowAngle,
    EffectiveMass,
    Friction,
    PositionStep,
    CoupleIndex,
    WristClearance,
)
"""All there are, in the order in which they are tested and reported."""

POSE_LIMITS: tuple[type[PoseLimit], ...] = tuple(limit for limit in LIMITS if issubclass(limit, PoseLimit))
"""Those on every position of the cube."""


@dataclass(frozen=True)
class Limits:
    """Limits on every position of a cube; reach is always among them, for the others need it.

    Attributes:
        each: The limits, in the order of `POSE_LIMITS`.
    """

    each: tuple[PoseLimit, ...]

    @classmethod
    def of(cls, *limits: PoseLimit | None) -> Self:
        """Gathers limits; reach is added, and of two of a kind the later one counts.

        Args:
            limits: In any order; None is left out.
        """
        known: dict[type[PoseLimit], PoseLimit] = {limit: limit() for limit in POSE_LIMITS if limit.always}
        known |= {type(limit): limit for limit in limits if limit is not None}
        return cls(tuple(known[limit] for limit in POSE_LIMITS if limit in known))

    @classmethod
    def stated(cls, values: Values) -> Self:
        """Makes the limits that requirements state, degrees rounded to the strict side of their radians.

        Args:
            values: Fields of a requirements file, and what is known of the machine (`PoseLimit.needs`).

        Raises:
            GeometryError: A number that the proof does not take, or something that a stated limit needs is not known.
        """
        return cls.of(*(limit.stated(values, strict=True) for limit in POSE_LIMITS))

    @staticmethod
    def measured(values: Values) -> tuple[PoseLimit, ...]:
        """Makes those limits that can be measured, to measure their figures by.

        Args:
            values: Fields of a requirements file, and what is known of the machine (`PoseLimit.needs`).

        Returns:
            In the order of the registry; a limit whose numbers are missing is left out.
        """
        return tuple(limit for kind in POSE_LIMITS if (limit := kind.measured(values)) is not None)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the limits."""
        return tuple(limit.name for limit in self.each)

    def __iter__(self) -> Iterator[PoseLimit]:
        """Goes through the limits."""
        return iter(self.each)

    def __getitem__(self, name: str) -> PoseLimit:
        """Gives a limit by its name.

        Raises:
            KeyError: It is not among them.
        """
        for limit in self.each:
            if limit.name == name:
                return limit
        raise KeyError(name)

    def get(self, kind: type[Kind]) -> Kind | None:
        """Gives the limit of a kind; None where there is none."""
        return next((limit for limit in self.each if isinstance(limit, kind)), None)

    def with_(self, *limits: PoseLimit) -> Self:
        """The same with some limits added or replaced."""
        return type(self).of(*self.each, *limits)

    def less_strict_than(self, required: Limits) -> str | None:
        """Finds the first limit that is less strict than in another list, each number taken as exact.

        Args:
            required: The other list.

        Returns:
            Its name; None if all are contained.
        """
        mine = {type(limit): limit for limit in self.each}
        for limit in required.each:
            own = mine.get(type(limit))
            if own is None or own.less_strict_than(limit):
                return limit.name
        return None

    def record(self) -> dict[str, Any]:
        """The limits as a certificate has them: key with unit -> number, None where there is none."""
        return dict.fromkeys(self.keys()) | {key: v for limit in self.each for key, v in limit.record().items()}

    @staticmethod
    def keys() -> tuple[str, ...]:
        """The keys of all limits in a certificate."""
        return tuple(key for limit in POSE_LIMITS for key in limit.keys.values())

    @classmethod
    def from_record(cls, data: Mapping[str, Any]) -> Self:
        """The limits of a certificate.

        Raises:
            GeometryError: A number that the proof does not take, or one of several that belong together is missing.
        """
        return cls.of(*(limit.from_record(data) for limit in POSE_LIMITS))
