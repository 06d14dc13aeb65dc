"""Ball knobs, the handle."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi
from typing import ClassVar

from delta_cad.catalogue.reader import Family
from delta_cad.catalogue.row import CatalogueRow, outside

DENSITY_g_cm3 = 0.1, 9.0  # over a ball of its diameter; beyond, a number is in another unit. Ours have 1.2


@dataclass(frozen=True)
class Knob(CatalogueRow):
    """A ball knob with a threaded hole.

    Attributes:
        diameter_mm: Ball diameter.
        height_mm: From the flat foot to the top.
        foot_diameter_mm: Diameter of the flat foot.
        thread: Thread of the hole ("M6").
        thread_depth_mm: Usable depth of the thread.
    """

    partners: ClassVar = {"thread": "screw"}

    diameter_mm: float
    height_mm: float
    foot_diameter_mm: float
    thread: str
    thread_depth_mm: float
    mass_g: float

    def fault(self) -> str:
        """Says that foot or thread do not lie within the knob, or that the mass is not its."""
        if not self.foot_diameter_mm < self.diameter_mm:
            return "must have foot_diameter_mm < diameter_mm"
        if not self.diameter_mm / 2.0 < self.height_mm < 3.0 * self.diameter_mm:
            return "must have diameter_mm / 2 < height_mm < 3 diameter_mm"
        if not 1.0 <= self.thread_depth_mm < self.height_mm:
            return "must have 1 <= thread_depth_mm < height_mm"
        ball_cm3 = pi / 6.0 * self.diameter_mm**3 / 1e3
        return outside("mass_g over a ball of diameter_mm", self.mass_g / ball_cm3, DENSITY_g_cm3, "g/cm^3")


knob = Family("knob", "knobs.csv", Knob)
