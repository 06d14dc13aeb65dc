"""Clearance of neighbouring wrists: the ball joints of two chains that are next to each other on the platform.

Two chains whose azimuths are 2 u apart mirror each other about the plane between them, so that their nearest wrists
are `2 (r sin u - L_c / 2 |cos u|)` apart. Between chains 0 and 1 (and 2) u is phi / 2, between chains 1 and 2 it is
180 degrees less phi: with c and s of phi the distances are `sqrt(2 - 2 c) r - sqrt((1 + c) / 2) L_c` and
`2 s r - |c| L_c`. At 120 degrees both are `sqrt(3) r - L_c / 2`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike

from delta_cad.mechanism.geometry import THREE_FOLD
from delta_cad.mechanism.limits.lengths.outline import OUTWARDS
from delta_cad.mechanism.limits.limit import DesignBounds, Limit, Values


def between_neighbours(side_cosine: ArrayLike) -> tuple[tuple[np.ndarray, np.ndarray], ...]:
    """Factors of r and of L_c in the distance of the nearest wrists: of chains 0 and 1, and of chains 1 and 2."""
    c = np.asarray(side_cosine)
    back = 2.0 * np.sqrt((1.0 - c) * (1.0 + c))
    return (np.sqrt(2.0 - 2.0 * c), np.sqrt((1.0 + c) / 2.0)), (back, np.abs(c))


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

    def width_max_mm(self, platform_radius_mm: float, side_cosine: float = THREE_FOLD) -> float:
        """Computes the largest L_c, mm.

        Args:
            platform_radius_mm: r.
            side_cosine: Cosine of the azimuth of chain 1.
        """
        return min(
            float(by_radius * platform_radius_mm - self.joint_diameter_mm - self.clearance_min_mm) / float(by_width)
            for by_radius, by_width in between_neighbours(side_cosine)
            if by_width > 0.0
        )

    def design_margin(self, lengths_mm: np.ndarray) -> np.ndarray:
        """Computes what is left between the nearest wrists as a share of r."""
        return self.smooth_margins(lengths_mm).min(axis=0)

    def smooth_margins(self, lengths_mm: np.ndarray) -> np.ndarray:
        """Computes the same of chains 0 and 1, and of chains 1 and 2."""
        r, width = lengths_mm[3], self.parallelogram_width_mm
        rooms = [by_radius * r - by_width * width for by_radius, by_width in between_neighbours(lengths_mm[7])]
        return (np.stack(rooms) - self.joint_diameter_mm - self.clearance_min_mm) / r

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
