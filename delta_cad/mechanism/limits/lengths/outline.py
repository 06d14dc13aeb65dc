"""Outline: the rectangle that the mechanism takes, of points and bars; the swept machine is checked by the build."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from delta_cad.mechanism.limits.limit import DesignBounds, Limit, Values

OUTWARDS = 1e-14
"""Share by which a bound that is rounded is moved outwards; some ten roundings of 1e-16, among them that of mm to m."""


@dataclass(frozen=True)
class Outline(Limit):
    """Largest rectangle, either way round, or largest R + L_A in its place.

    Attributes:
        width_mm: W.
        depth_mm: D.
        parallelogram_width_mm: L_c.
        overhead_mm: What the hardware takes beyond eq. (1), along W and along D.
        radius_max_mm: Largest R + L_A; None where the rectangle decides.
    """

    width_mm: float
    depth_mm: float
    parallelogram_width_mm: float
    overhead_mm: tuple[float, float] = (0.0, 0.0)
    radius_max_mm: float | None = None

    name: ClassVar = "outline"
    first_step: ClassVar = True

    @classmethod
    def stated(cls, values: Values, strict: bool = False) -> Self:
        """Makes the limit of what is given."""
        del strict
        return cls(
            values["envelope_width_mm"],
            values["envelope_depth_mm"],
            values["parallelogram_width_mm"],
            values.get("outline_overhead_mm") or (0.0, 0.0),
            values.get("outline_radius_max_mm"),
        )

    def describe(self, values: Values) -> str:
        """Says what is required."""
        del values
        if self.radius_max_mm is not None:
            return f"R + L_A <= {self.radius_max_mm:g} mm (limits.outline_radius_max_mm)"
        return f"outline {self.width_mm:g} x {self.depth_mm:g} mm (requirements.envelope_*_mm)"

    def size_mm(self, reach_mm: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Computes the rectangle that a mechanism takes.

        Args:
            reach_mm: (...) R + L_A.

        Returns:
            (...) width and (...) depth.

        Source:
            [RCIM2018] eq. (1), plus the overhead of the real hardware where it is given.
        """
        reach = np.asarray(reach_mm)
        width = self.parallelogram_width_mm * 0.5 + math.sqrt(3.0) * reach + self.overhead_mm[0]
        depth = self.parallelogram_width_mm * math.sqrt(3.0) / 4.0 + 1.5 * reach + self.overhead_mm[1]
        return width, depth

    @property
    def reach_max_mm(self) -> float:
        """Largest R + L_A that is allowed, the rectangle either way round, mm."""
        if self.radius_max_mm is not None:
            return self.radius_max_mm
        width, depth = (float(part) for part in self.size_mm(np.array(0.0)))
        W, D = self.width_mm, self.depth_mm
        return max(min((w - width) / math.sqrt(3.0), (d - depth) / 1.5) for w, d in ((W, D), (D, W)))

    def room(self, reach_mm: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Computes how far the outline is inside what is allowed, as a share of it.

        Args:
            reach_mm: (...) R + L_A.

        Returns:
            (...) margin; (...) whether the rectangle is turned: eq. (1)'s W along the requirements' depth.
        """
        width, depth = self.size_mm(reach_mm)
        reach, W, D = np.asarray(reach_mm), self.width_mm, self.depth_mm
        straight = np.minimum((W - width) / W, (D - depth) / D)
        turned = np.minimum((D - width) / D, (W - depth) / W)
        if self.radius_max_mm is not None:
            return (self.radius_max_mm - reach) / self.radius_max_mm, turned > straight
        return np.maximum(straight, turned), turned > straight

    def design_margin(self, lengths_mm: np.ndarray) -> np.ndarray:
        """Computes the room that is left, as a share."""
        return self.room(lengths_mm[2] + lengths_mm[0])[0]

    def design_bounds(self) -> DesignBounds:
        """Gives the largest R + L_A, either way round."""
        rounding = 0.0 if self.radius_max_mm is not None else OUTWARDS * (self.width_mm + self.depth_mm)
        return DesignBounds(reach_max_mm=self.reach_max_mm + rounding)
