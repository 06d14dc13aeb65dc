"""Clearance of neighbouring wrists: the ball joints of two chains that are next to each other on the platform."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from delta_cad.mechanism.limits.lengths.outline import OUTWARDS
from delta_cad.mechanism.limits.limit import DesignBounds, Limit, Values


@dataclass(frozen=True)
class WristClearance(Limit):
    """Least distance of the joints at the wrists of neighbouring chains.

    Attributes:
        clearance_min_mm: Least distance.
        joint_diameter_mm: Of a ball joint.
        parallelogram_width_mm: L_c.
    """

    clearance_min_mm: float
    joint_diameter_mm: float
    parallelogram_width_mm: float

    name: ClassVar = "clearance"

    @classmethod
    def stated(cls, values: Values, strict: bool = False) -> Self | None:
        """Makes the limit where clearance and joint are given; the design file's clearance is that of the solids."""
        del strict
        clearance, joint = values.get("clearance_min_mm"), values.get("joint_diameter_mm")
        if clearance is None or joint is None:
            return None
        return cls(clearance, joint, values["parallelogram_width_mm"])

    def describe(self, values: Values) -> str:
        """Says what is required."""
        del values
        return f"limits.clearance_min_mm = {self.clearance_min_mm}"

    def width_max_mm(self, platform_radius_mm: float) -> float:
        """Computes the largest L_c: the nearest wrists are sqrt(3) r - L_c / 2 apart."""
        return 2.0 * (math.sqrt(3.0) * platform_radius_mm - self.joint_diameter_mm - self.clearance_min_mm)

    def design_margin(self, lengths_mm: np.ndarray) -> np.ndarray:
        """Computes what is left as a share of r: the nearest wrists are sqrt(3) r - L_c / 2 apart."""
        r = lengths_mm[3]
        room = math.sqrt(3.0) * r - self.parallelogram_width_mm / 2.0
        return (room - self.joint_diameter_mm - self.clearance_min_mm) / r

    def design_bounds(self) -> DesignBounds:
        """Gives the smallest platform radius."""
        room = self.parallelogram_width_mm / 2.0 + self.joint_diameter_mm + self.clearance_min_mm
        return DesignBounds(platform_radius_min_mm=room / math.sqrt(3.0) * (1.0 - OUTWARDS))


@dataclass(frozen=True)
class BallClearance(WristClearance):
    """Balls of neighbouring chains that do not meet; every design file is held to it, whatever clearance is set."""

    name: ClassVar = "balls"
    first_step: ClassVar = True
    of_every_design: ClassVar = True

    @classmethod
    def stated(cls, values: Values, strict: bool = False) -> Self | None:
        """Makes the limit where the balls are known."""
        del strict
        ball = values.get("ball_diameter_mm")
        return None if ball is None else cls(0.0, ball, values["parallelogram_width_mm"])

    def describe(self, values: Values) -> str:
        """Says what is required, with the fields that decide it."""
        del values
        width, ball = self.parallelogram_width_mm, self.joint_diameter_mm
        return f"balls of {ball:g} mm that do not meet at the platform (parallelogram_width_mm = {width:g})"
