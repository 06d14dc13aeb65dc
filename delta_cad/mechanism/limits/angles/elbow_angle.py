"""Angle between upper arm and rods at the elbows, which must not fold onto arm, motor or what holds them."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np

from delta_cad.common.jit import compiled
from delta_cad.mechanism.enclosure import pose as forms
from delta_cad.mechanism.enclosure.affine_form import ROUND, add, at, constant, multiply, scale, subtract
from delta_cad.mechanism.enclosure.interval import Interval, Slopes
from delta_cad.mechanism.enclosure.slope_pose import SlopePose
from delta_cad.mechanism.enclosure.table import EXCLUDED, keep, store
from delta_cad.mechanism.geometry import DeltaGeometry
from delta_cad.mechanism.inverse import forearm_angle
from delta_cad.mechanism.limits.limit import (
    DEGREE,
    Field,
    FigureOfMerit,
    PoseLimit,
    Values,
    cosine_sine,
    require,
    strict_radians,
)


def _angles(limit: ElbowAngle, g: DeltaGeometry, p: np.ndarray) -> np.ndarray:
    del limit
    return np.pi - forearm_angle(g, p)


@compiled
def _margin(pose, k, n, i):
    """Computes q^2 + t^2 + z^2 - L_A^2 - L_B^2 + 2 L_A L_B cos(angle), the law of cosines."""
    q, t, z = at(pose, forms.Q + i), at(pose, forms.T + i), at(pose, forms.Z)
    apart = add(add(multiply(q, q), multiply(t, t)), multiply(z, z))
    lengths = multiply(at(pose, forms.UPPER_ARM), at(pose, forms.FOREARM_LENGTH))
    room = subtract(apart, add(at(pose, forms.UPPER_ARM_2), at(pose, forms.FOREARM_2)))
    return add(room, scale(2.0, multiply(constant(k[n], k[n + 1]), lengths)))


@compiled
def _enclose(pose, k, n, work, out, row):
    """Computes the margin of each chain."""
    for i in range(3):
        store(out, row + i, _margin(pose, k, n, i))


@compiled
def _cut(pose, k, n, work, cuts, count):
    """Adds the margin of each chain."""
    for i in range(3):
        count = keep(cuts, count, _margin(pose, k, n, i))
        if count == EXCLUDED:
            return count
    return count


@dataclass(frozen=True)
class ElbowAngle(PoseLimit):
    """Smallest angle between upper arm and rods at an elbow, rad: 0 folded, pi stretched."""

    angle_min: float

    name: ClassVar = "elbow_angle"
    fields_: ClassVar = (Field("elbow_angle_min_deg", "smallest angle between upper arm and rods", ge=0, lt=180),)
    keys: ClassVar = {"angle_min": "elbow_angle_min_rad"}
    figures: ClassVar = (
        FigureOfMerit("elbow_angle", "elbow angle", "deg", DEGREE, False, False, _angles, "angle_min", (0.0, math.pi)),
    )
    tier: ClassVar = forms.CHAINS
    rows: ClassVar = 3
    size: ClassVar = 2
    enclose: ClassVar = staticmethod(_enclose)
    cut: ClassVar = staticmethod(_cut)
    cuts: ClassVar = 3

    def __post_init__(self) -> None:
        require("angle_min", self.angle_min, 0.0 <= self.angle_min < math.pi, "at least 0, less than pi rad")

    @classmethod
    def stated(cls, values: Values, strict: bool = False) -> Self | None:
        """Asks for it where it is given."""
        value = values.get("elbow_angle_min_deg")
        if value is None:
            return None
        return cls(strict_radians(value, math.inf) if strict else math.radians(value))

    @classmethod
    def measured(cls, values: Values) -> Self:
        """Makes the limit that every closed chain keeps, so that only its figure is measured."""
        del values
        return cls(0.0)

    def describe(self, values: Values) -> str:
        """Says what is asked."""
        return f"limits.elbow_angle_min_deg = {values['elbow_angle_min_deg']}"

    def numbers(self) -> tuple[float, ...]:
        """Gives the angle's cosine and its error."""
        return cosine_sine(self.angle_min, self.angle_min)[0], ROUND

    def second(self, pose: SlopePose, exact: Callable[[float], Interval]) -> list[Slopes]:
        """Computes the forearm along its upper arm and L_B cos(angle_min): L_B times the difference of the cosines."""
        del exact
        cosine = pose.rounded(cosine_sine(self.angle_min, self.angle_min)[0])
        found = []
        for (x, y, up), (c, s), cos, sin in zip(pose.forearm, pose.azimuths, pose.cos, pose.sin, strict=True):
            along = (x.times(c) + y.times(s)) * cos + up * sin
            found.append(along.plus(cosine * pose.forearm_length))
        return found

    def margin(self, f: Any) -> np.ndarray:
        """Computes the difference of the cosines of the angle allowed and of the sharpest elbow."""
        return f.folds() + math.cos(self.angle_min)
