"""Angle between upper arm and rods at the elbows, which must not fold onto arm, motor or what holds them."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from delta_cad.common.jit import compiled
from delta_cad.mechanism.enclosure import pose as forms
from delta_cad.mechanism.enclosure.affine_form import ROUND, add, at, constant, multiply, scale, subtract
from delta_cad.mechanism.enclosure.interval import Interval, Slopes
from delta_cad.mechanism.enclosure.slope_pose import SlopePose
from delta_cad.mechanism.enclosure.table import enclosure_of
from delta_cad.mechanism.inverse import forearm_angle
from delta_cad.mechanism.limits.limit import Field, FigureOfMerit, ThresholdLimit
from delta_cad.mechanism.limits.numbers import cosine_sine, require


@compiled
def _margin(pose, k, n, i):
    """Computes q^2 + t^2 + z^2 - L_A^2 - L_B^2 + 2 L_A L_B cos(angle), the law of cosines."""
    q, t, z = at(pose, forms.Q + i), at(pose, forms.T + i), at(pose, forms.Z)
    apart = add(add(multiply(q, q), multiply(t, t)), multiply(z, z))
    lengths = multiply(at(pose, forms.UPPER_ARM), at(pose, forms.FOREARM_LENGTH))
    room = subtract(apart, add(at(pose, forms.UPPER_ARM_2), at(pose, forms.FOREARM_2)))
    return add(room, scale(2.0, multiply(constant(k[n], k[n + 1]), lengths)))


@dataclass(frozen=True)
class ElbowAngle(ThresholdLimit):
    """Smallest angle between upper arm and rods at an elbow, rad: 0 folded, pi stretched."""

    angle_min: float

    name: ClassVar = "elbow_angle"
    fields_: ClassVar = (Field("elbow_angle_min_deg", "smallest angle between upper arm and rods", ge=0, lt=180),)
    keys: ClassVar = {"angle_min": "elbow_angle_min_rad"}
    figures: ClassVar = (
        FigureOfMerit(
            "elbow_angle",
            "deg",
            lambda _, g, p: np.pi - forearm_angle(g, p),
            "angle_min",
            (0.0, math.pi),
            upper=False,
            relative=False,
        ),
    )
    enclosure: ClassVar = enclosure_of(_margin, forms.CHAINS, 2)

    def __post_init__(self) -> None:
        require("angle_min", self.angle_min, 0.0 <= self.angle_min < math.pi, "at least 0, less than pi rad")

    def numbers(self) -> tuple[float, ...]:
        """Gives the angle's cosine and its error."""
        return cosine_sine(self.angle_min, self.angle_min)[0], ROUND

    def interval_margins(self, pose: SlopePose, exact: Callable[[float], Interval]) -> list[Slopes]:
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
