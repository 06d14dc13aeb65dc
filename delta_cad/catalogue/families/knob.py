"""Ball knobs, the handle."""

from __future__ import annotations

from math import pi
from typing import ClassVar

from pydantic.dataclasses import dataclass

from delta_cad.catalogue.reader import Family
from delta_cad.catalogue.row import ROW, CatalogueRow, Quantity, Text, outside

_DENSITY_g_cm3 = 0.1, 9.0  # over a ball of its diameter; beyond, a number is in another unit. Ours have 1.2


@dataclass(frozen=True, kw_only=True, config=ROW)
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

    diameter_mm: Quantity
    height_mm: Quantity
    foot_diameter_mm: Quantity
    thread: Text
    thread_depth_mm: Quantity
    mass_g: Quantity

    def fault(self) -> str:
        """Says that foot or thread do not lie within the knob, or that the mass is not its."""
        if not self.foot_diameter_mm < self.diameter_mm:
            return "must have foot_diameter_mm < diameter_mm"
        if not self.diameter_mm / 2.0 < self.height_mm < 3.0 * self.diameter_mm:
            return "must have diameter_mm / 2 < height_mm < 3 diameter_mm"
        if not 1.0 <= self.thread_depth_mm < self.height_mm:
            return "must have 1 <= thread_depth_mm < height_mm"
        ball_cm3 = pi / 6.0 * self.diameter_mm**3 / 1e3
        return outside("mass_g over a ball of diameter_mm", self.mass_g / ball_cm3, _DENSITY_g_cm3, "g/cm^3")


knob = Family("knob", "knobs.csv", Knob)
