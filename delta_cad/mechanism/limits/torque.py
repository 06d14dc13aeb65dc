"""Joint torque: every joint holds a force on the handle in its worst direction."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from fractions import Fraction
from typing import Any, ClassVar, Self

import numpy as np

from delta_cad.common.jit import compiled
from delta_cad.mechanism.enclosure import pose as forms
from delta_cad.mechanism.enclosure.affine_form import ROUND, at, constant, multiply, subtract
from delta_cad.mechanism.enclosure.interval import Interval, Slopes
from delta_cad.mechanism.enclosure.slope_pose import SlopePose
from delta_cad.mechanism.enclosure.table import enclosure_of
from delta_cad.mechanism.limits.limit import FigureOfMerit, PoseLimit, Values
from delta_cad.mechanism.limits.numbers import require
from delta_cad.mechanism.statics import worst_joint_torque

RANGE = (1e-6, 1e6)
"""N or N m: keeps every product of the proof far from underflow and overflow."""


@compiled
def _margin(pose, k, n, i):
    """Computes det^2 - (F L_A / torque)^2 w_i^2 |s_j x s_k|^2."""
    lever = multiply(at(pose, forms.UPPER_ARM_2), constant(k[n], k[n + 1]))
    lb2, det, g = at(pose, forms.FOREARM_2), at(pose, forms.DETERMINANT), at(pose, forms.PRODUCT + i)
    face = subtract(multiply(lb2, lb2), multiply(g, g))
    return subtract(multiply(det, det), multiply(multiply(lever, at(pose, forms.W2 + i)), face))


@dataclass(frozen=True)
class HeldForce(PoseLimit):
    """Largest torque of every joint over all directions of a force on the handle, N m and N."""

    force: float
    torque_max: float

    infinite_at_singularity: ClassVar = True
    with_: ClassVar[str] = ""
    """What the joints hold besides the force."""

    def __post_init__(self) -> None:
        super().__post_init__()
        low, high = RANGE
        require("force", self.force, low <= self.force <= high, f"within {low:g} and {high:g} N")

    @classmethod
    def measured(cls, values: Values) -> Self | None:
        """Makes the limit of the stated force with the largest torque that the proof takes, to measure its figure."""
        known = cls.known(values)
        return None if known is None else cls(values["force_N"], RANGE[1], *known)

    def words(self, rounded: Callable[[float, bool], str]) -> str:
        """Says what is required."""
        force = rounded(self.force, False)
        return f"torque <= {rounded(self.torque_max, True)} N m for {force} N in any direction{self.with_}"


@dataclass(frozen=True)
class Torque(HeldForce):
    """Largest torque of every joint for the force alone."""

    name: ClassVar = "torque"
    keys: ClassVar = {"force": "force_N", "torque_max": "torque_max_N_m"}
    figures: ClassVar = (
        FigureOfMerit("torque", "N m", lambda limit, g, p: worst_joint_torque(g, p, limit.force), "torque_max", RANGE),
    )
    output_key: ClassVar = "max_torque_N_m"
    enclosure: ClassVar = enclosure_of(_margin, forms.FOREARMS, 2)

    @classmethod
    def stated(cls, values: Values, strict: bool = False) -> Self:
        """Makes the limit of the force, with the allowance for gravity taken off the torque."""
        del strict
        return cls(values["force_N"], values["joint_torque_N_m"] - (values.get("gravity_torque_N_m") or 0.0))

    def describe(self, values: Values) -> str:
        """Says what is required."""
        del values
        return f"{self.torque_max:g} N m for {self.force:g} N (requirements.joint_torque_N_m)"

    def numbers(self) -> tuple[float, ...]:
        """Gives (F / torque)^2 and its error, 1 / m^2."""
        lever = self.force / self.torque_max
        return lever**2, ROUND * lever**2

    def interval_margins(self, pose: SlopePose, exact: Callable[[float], Interval]) -> list[Slopes]:
        """Computes det^2 (torque / F L_A)^2 - w_i^2 |s_j x s_k|^2."""
        allowed = exact(self.torque_max) * (exact(self.force) * pose.upper_arm).inverse()
        square = pose.determinant.square().times(allowed.square())
        return [square - pose.w2[i] * pose.faces[i] for i in range(3)]

    def margin(self, f: Any) -> np.ndarray:
        """Computes det - F moment / torque: also refuses every direct singularity."""
        return f.determinant - self.force / self.torque_max * f.moment

    def search_quantities(self, f: Any) -> dict[str, np.ndarray]:
        """Computes determinant, closure, and the torque arm with its sign turned."""
        floor = np.maximum(f.determinant, np.finfo(float).tiny)
        return {"determinant": f.determinant, "closure": f.closure, "torque": -f.moment / floor}

    def extreme_value(self, least: Mapping[str, float]) -> float:
        """Computes the torque at the longest arm; infinite where a chain is open or the platform not held."""
        held = least["determinant"] > 0.0 and least["closure"] >= 0.0
        return -least["torque"] * self.force if held else math.inf

    def less_strict_than(self, than: Any) -> bool:
        """Compares the torque of a unit force, in exact fractions."""
        return Fraction(self.torque_max) * Fraction(than.force) > Fraction(than.torque_max) * Fraction(self.force)
