"""Rubber feet."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from delta_cad.catalogue.reader import Family
from delta_cad.catalogue.row import CatalogueRow


@dataclass(frozen=True)
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

    diameter_mm: float
    height_mm: float
    thread: str
    stud_length_mm: float | None
    hole_diameter_mm: float | None
    mass_g: float

    def fault(self) -> str:
        """Says that there is nothing to fasten it by, or two things."""
        one = (self.stud_length_mm is None) != (self.hole_diameter_mm is None)
        return "" if one else "must have either stud_length_mm or hole_diameter_mm"


foot = Family("foot", "feet.csv", Foot)
