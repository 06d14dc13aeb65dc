"""Elbows outside their wrists, as the inverse kinematics takes them: R_i + L_A > r at least, with level upper arms."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from delta_cad.mechanism.limits.limit import DesignBounds, Limit

_APART = 1e-6
"""Share of R_i + L_A that an elbow is farther out than its wrist: at 0 the mechanism is singular."""


@dataclass(frozen=True)
class ElbowOutside(Limit):
    """Largest platform radius, by the reach of level upper arms; every design file is held to it."""

    name: ClassVar = "elbow_outside"
    described: ClassVar = "elbows outside their wrists (r < R + L_A)"
    first_step: ClassVar = True
    of_every_design: ClassVar = True

    def design_margin(self, lengths_mm: np.ndarray) -> np.ndarray:
        """Computes how far the elbow nearest to the base's centre can be outside its wrist, as a share of R_i + L_A."""
        nearest = lengths_mm[2] + np.minimum(lengths_mm[6], 0.0)
        return 1.0 - lengths_mm[3] / (nearest + lengths_mm[0]) - _APART

    def design_bounds(self) -> DesignBounds:
        """Gives the least R + L_A - r."""
        return DesignBounds(level_elbow_min_mm=0.0)
