"""Height of the machine: the cube's top over the shoulder axes, with what its parts take below and above."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, Self

import numpy as np

from delta_cad.mechanism.limits.limit import Limit, Values


@dataclass(frozen=True)
class Height(Limit):
    """Largest height from the mounting surface to the knob's top, with the handle at the cube's top.

    Attributes:
        height_max_mm: The most it may be.
        beyond_mm: What parts take of it: from the mounting surface to the shoulder axes, and from the wrists to the
            knob's top.
    """

    height_max_mm: float
    beyond_mm: float = 0.0

    name: ClassVar = "height"
    first_step: ClassVar = True

    @classmethod
    def stated(cls, values: Values, strict: bool = False) -> Self | None:
        """Makes the limit where a height is stated."""
        del strict
        most = values.get("height_max_mm")
        return None if most is None else cls(most, values.get("height_beyond_mm") or 0.0)

    def describe(self, values: Values) -> str:
        """Says what is required, with the fields that state it."""
        del values
        parts = f", of which parts take limits.height_beyond_mm = {self.beyond_mm:g} mm" if self.beyond_mm else ""
        return f"height of {self.height_max_mm:g} mm (requirements.height_max_mm{parts})"

    def design_margin(self, lengths_mm: np.ndarray) -> np.ndarray:
        """Computes the room over the knob, as a share of the height allowed."""
        return 1.0 - (lengths_mm[4] + 2.0 * lengths_mm[5] + self.beyond_mm) / self.height_max_mm
