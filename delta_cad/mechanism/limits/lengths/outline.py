"""Outline: the rectangle that the mechanism takes, of points and bars; the swept machine is checked by the build.

With its upper arms level each elbow is a bar of length L_c along its shoulder axis, R_i + L_A out. With c and s of the
azimuth of chains 1 and 2, their bars reach `(R_1 + L_A) c -+ L_c s / 2` along x and `(R_1 + L_A) s + L_c |c| / 2` along
y, so that the rectangle of all three is, with `reach = R_0 + L_A` and `shift = R_1 - R_0`,

    width  `L_c |c| + 2 s (reach + shift)`,
    depth  `L_c s / 2 + |(1 - c) reach - c shift|`,

at least as much as one bar takes: L_c and L_c s. At 120 degrees this is [RCIM2018] eq. (1).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike

from delta_cad.mechanism.geometry import THREE_FOLD
from delta_cad.mechanism.limits.limit import DesignBounds, Limit, Values

OUTWARDS = 1e-14
"""Share by which a bound that is rounded is moved outwards; some ten roundings of 1e-16, among them that of mm to m."""


@dataclass(frozen=True)
class Outline(Limit):
    """Largest rectangle, either way round, or largest R_i + L_A in its place.

    Attributes:
        width_mm: W.
        depth_mm: D.
        parallelogram_width_mm: L_c.
        overhead_mm: What the hardware takes beyond eq. (1), along W and along D.
        radius_max_mm: Largest R_i + L_A; None where the rectangle decides.
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

    def _linear(self, side_shift_mm: ArrayLike, side_cosine: ArrayLike) -> tuple[np.ndarray, ...]:
        """Width and depth as numbers that stand and factors of the reach, without overhead."""
        shift, c, width = np.asarray(side_shift_mm), np.asarray(side_cosine), self.parallelogram_width_mm
        s = np.sqrt((1.0 - c) * (1.0 + c))
        return width * np.abs(c) + 2.0 * s * shift, 2.0 * s, width * s / 2.0, 1.0 - c, c * shift

    def size_mm(
        self, reach_mm: ArrayLike, side_shift_mm: ArrayLike = 0.0, side_cosine: ArrayLike = THREE_FOLD
    ) -> tuple[np.ndarray, np.ndarray]:
        """Computes the rectangle that a mechanism takes.

        Args:
            reach_mm: (...) R_0 + L_A.
            side_shift_mm: (...) R_1 - R_0.
            side_cosine: (...) cosine of the azimuth of chain 1.

        Returns:
            (...) width, along y, and (...) depth, along x.

        Source:
            [RCIM2018] eq. (1) for chains in any place, plus the overhead of the real hardware where it is given.
        """
        reach = np.asarray(reach_mm)
        wide, by_width, half, by_depth, back = self._linear(side_shift_mm, side_cosine)
        width = np.maximum(self.parallelogram_width_mm, wide + by_width * reach)
        depth = np.maximum(2.0 * half, half + np.abs(by_depth * reach - back))
        return width + self.overhead_mm[0], depth + self.overhead_mm[1]

    def largest_reach_mm(self, side_shift_mm: float = 0.0, side_cosine: float = THREE_FOLD) -> float:
        """Computes the largest R_0 + L_A that is allowed for a placement, the rectangle either way round, mm.

        Args:
            side_shift_mm: R_1 - R_0.
            side_cosine: Cosine of the azimuth of chain 1.
        """
        if self.radius_max_mm is not None:
            return self.radius_max_mm - max(side_shift_mm, 0.0)
        wide, by_width, half, by_depth, back = (float(x) for x in self._linear(side_shift_mm, side_cosine))
        width, depth = wide + self.overhead_mm[0], half - back + self.overhead_mm[1]
        W, D = self.width_mm, self.depth_mm
        return max(min((w - width) / by_width, (d - depth) / by_depth) for w, d in ((W, D), (D, W)))

    @property
    def reach_max_mm(self) -> float:
        """Largest R + L_A that is allowed of a three-fold symmetric mechanism, mm."""
        return self.largest_reach_mm()

    def room(
        self, reach_mm: ArrayLike, side_shift_mm: ArrayLike = 0.0, side_cosine: ArrayLike = THREE_FOLD
    ) -> tuple[np.ndarray, np.ndarray]:
        """Computes how far the outline is inside what is allowed, as a share of it.

        Args:
            reach_mm: (...) R_0 + L_A.
            side_shift_mm: (...) R_1 - R_0.
            side_cosine: (...) cosine of the azimuth of chain 1.

        Returns:
            (...) margin; (...) whether the rectangle is turned: the mechanism's width along the requirements' depth.
        """
        width, depth = self.size_mm(reach_mm, side_shift_mm, side_cosine)
        W, D = self.width_mm, self.depth_mm
        straight = np.minimum((W - width) / W, (D - depth) / D)
        turned = np.minimum((D - width) / D, (W - depth) / W)
        if self.radius_max_mm is not None:
            farthest = np.asarray(reach_mm) + np.maximum(side_shift_mm, 0.0)
            return (self.radius_max_mm - farthest) / self.radius_max_mm, turned > straight
        return np.maximum(straight, turned), turned > straight

    def design_margin(self, lengths_mm: np.ndarray) -> np.ndarray:
        """Computes the room that is left, as a share."""
        return self.room(lengths_mm[2] + lengths_mm[0], *lengths_mm[6:8])[0]

    def smooth_margins(self, lengths_mm: np.ndarray) -> np.ndarray:
        """Computes the room in width and in depth, of each design the way round that leaves more."""
        shift, cosine = lengths_mm[6:8]
        reach = lengths_mm[2] + lengths_mm[0]
        if self.radius_max_mm is not None:
            return np.stack([1.0 - reach / self.radius_max_mm, 1.0 - (reach + shift) / self.radius_max_mm])
        width, depth = self.size_mm(reach, shift, cosine)
        turned = self.room(reach, shift, cosine)[1]
        W, D = np.where(turned, self.depth_mm, self.width_mm), np.where(turned, self.width_mm, self.depth_mm)
        return np.stack([(W - width) / W, (D - depth) / D])

    def design_bounds(self) -> DesignBounds:
        """Gives the largest R + L_A, either way round."""
        rounding = 0.0 if self.radius_max_mm is not None else OUTWARDS * (self.width_mm + self.depth_mm)
        return DesignBounds(reach_max_mm=self.reach_max_mm + rounding)
