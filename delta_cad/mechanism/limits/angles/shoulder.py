"""Shoulder angles, which stops, cable and neighbouring parts allow."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np

from delta_cad.common.jit import compiled
from delta_cad.mechanism.enclosure import pose as forms
from delta_cad.mechanism.enclosure.affine_form import ROUND, add, at, constant, multiply, subtract
from delta_cad.mechanism.enclosure.interval import Interval, Slopes
from delta_cad.mechanism.enclosure.slope_pose import SlopePose
from delta_cad.mechanism.enclosure.table import enclosure_of
from delta_cad.mechanism.inverse import joint_angles
from delta_cad.mechanism.limits.limit import DEGREE, Field, FigureOfMerit, PoseLimit, Values
from delta_cad.mechanism.limits.numbers import cosine_sine, number, require, strict_radians

_RANGE = (-math.pi, math.pi)


@compiled
def _margin(pose, k, n, i):
    """Computes L_A (cos(theta - middle) - cos(half the range)), so that cos and sin need not be divided out."""
    c, s = constant(k[n], k[n + 3]), constant(k[n + 1], k[n + 3])
    along, up = multiply(c, at(pose, forms.ELBOW_RADIAL + i)), multiply(s, at(pose, forms.ELBOW_VERTICAL + i))
    return subtract(add(along, up), multiply(at(pose, forms.UPPER_ARM), constant(k[n + 2], k[n + 3])))


@dataclass(frozen=True)
class Shoulder(PoseLimit):
    """Smallest and largest shoulder angle, rad, within [-pi, pi]."""

    shoulder_min: float
    shoulder_max: float

    name: ClassVar = "shoulder"
    evaluates: ClassVar = ("angles",)
    keys: ClassVar = {"": "shoulder_rad"}
    fields_: ClassVar = (
        Field("shoulder_min_deg", "smallest shoulder angle", ge=-180, le=180),
        Field("shoulder_max_deg", "largest shoulder angle", ge=-180, le=180),
    )
    figures: ClassVar = (
        FigureOfMerit(
            "shoulder_min",
            "deg",
            lambda _, g, p: joint_angles(g, p),
            "shoulder_min",
            _RANGE,
            upper=False,
            relative=False,
            words="shoulder, smallest",
        ),
        FigureOfMerit(
            "shoulder_max",
            "deg",
            lambda _, g, p: joint_angles(g, p),
            "shoulder_max",
            _RANGE,
            relative=False,
            words="shoulder, largest",
        ),
    )
    enclosure: ClassVar = enclosure_of(_margin, forms.CHAINS, 4)

    def __post_init__(self) -> None:
        low, high = self.shoulder_min, self.shoulder_max
        require("shoulder", (low, high), -math.pi <= low < high <= math.pi, "rising, within -pi and pi rad")

    @classmethod
    def stated(cls, values: Values, strict: bool = False) -> Self | None:
        """Makes the range where one of its ends is given; the other end is then half a turn away."""
        low, high = values.get("shoulder_min_deg"), values.get("shoulder_max_deg")
        if low is None and high is None:
            return None
        ends = []
        for value, other, inwards in ((low, -math.pi, math.inf), (high, math.pi, -math.inf)):
            if value is None:
                ends.append(other)
            else:
                angle = strict_radians(value, inwards) if strict else math.radians(value)
                ends.append(min(max(angle, -math.pi), math.pi))
        return cls(*ends)

    def describe(self, values: Values) -> str:
        """Says what is required."""
        low, high = (values.get(name) for name in ("shoulder_min_deg", "shoulder_max_deg"))
        return f"limits.shoulder_deg = [{-180.0 if low is None else low:g}, {180.0 if high is None else high:g}]"

    def numbers(self) -> tuple[float, ...]:
        """Gives cosine and sine of the middle, cosine of half the range, and the error of each."""
        low, high = self.shoulder_min, self.shoulder_max
        return *cosine_sine(low, high), cosine_sine(high, -low)[0], ROUND

    def interval_margins(self, pose: SlopePose, exact: Callable[[float], Interval]) -> list[Slopes]:
        """Computes cos(theta - middle) - cos(half the range) of each chain."""
        del exact
        low, high = self.shoulder_min, self.shoulder_max
        (c, s), (least, _) = cosine_sine(low, high), cosine_sine(high, -low)
        return [
            (cos.times(pose.rounded(c)) + sin.times(pose.rounded(s))).plus(-pose.rounded(least))
            for cos, sin in zip(pose.cos, pose.sin, strict=True)
        ]

    def margin(self, f: Any) -> np.ndarray:
        """Computes how far the angles are inside, rad."""
        return np.minimum(f.shoulder_min - self.shoulder_min, self.shoulder_max - f.shoulder_max)

    def words(self, rounded: Callable[[float, bool], str]) -> str:
        """Says what is required."""
        low, high = self.shoulder_min * DEGREE, self.shoulder_max * DEGREE
        return f"shoulder angle {rounded(low, False)} to {rounded(high, True)} deg"

    def record(self) -> dict[str, Any]:
        """Gives the pair."""
        return {"shoulder_rad": (self.shoulder_min, self.shoulder_max)}

    @classmethod
    def from_record(cls, data: Any) -> Self | None:
        """Reads the pair."""
        pair = data.get("shoulder_rad")
        if pair is None:
            return None
        is_pair = isinstance(pair, list | tuple) and len(pair) == 2
        require("shoulder_rad", pair, is_pair, "two numbers")
        return cls(*(number("shoulder_rad", value) for value in pair))
