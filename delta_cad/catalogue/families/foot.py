"""Rubber feet."""

from __future__ import annotations

from math import pi
from typing import ClassVar

from pydantic.dataclasses import dataclass

from delta_cad.catalogue.reader import Family
from delta_cad.catalogue.row import ROW, CatalogueRow, Quantity, Text, outside

_DENSITY_g_cm3 = 0.1, 12.0  # with its stud; beyond, a number is in another unit. Ours have 1.9 and 2.8


@dataclass(frozen=True, kw_only=True, config=ROW)
class Foot(CatalogueRow):
    """A rubber foot under the base plate.

    Attributes:
        diameter_mm: Outside diameter.
        height_mm: Height without the stud.
        thread: Thread of the stud, or of the screw through its hole ("M4").
        stud_length_mm: Length of the stud; None when it has a hole.
        hole_diameter_mm: Through hole; None when it has a stud.
    """

    partners: ClassVar = {"thread": "screw"}

    diameter_mm: Quantity
    height_mm: Quantity
    thread: Text
    stud_length_mm: Quantity | None = None
    hole_diameter_mm: Quantity | None = None
    mass_g: Quantity

    def fault(self) -> str:
        """Says that there is nothing to fasten it by, or two things, or that the mass is not a foot's."""
        one = (self.stud_length_mm is None) != (self.hole_diameter_mm is None)
        if not one:
            return "must have either stud_length_mm or hole_diameter_mm"
        if not (self.hole_diameter_mm or 0.0) < self.diameter_mm:
            return "must have hole_diameter_mm < diameter_mm"
        volume_cm3 = pi / 4.0 * self.diameter_mm**2 * self.height_mm / 1e3
        return outside("mass_g over its volume", self.mass_g / volume_cm3, _DENSITY_g_cm3, "g/cm^3")


foot = Family("foot", "feet.csv", Foot)
