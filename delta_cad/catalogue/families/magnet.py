"""Magnets for shaft encoders."""

from __future__ import annotations

from math import pi
from typing import ClassVar

from pydantic.dataclasses import dataclass

from delta_cad.catalogue.reader import Family
from delta_cad.catalogue.row import ROW, CatalogueRow, Quantity


@dataclass(frozen=True, kw_only=True, config=ROW)
class Magnet(CatalogueRow):
    """A diametrically magnetised disc for a shaft encoder."""

    derived: ClassVar = {  # 7500 kg/m3
        "mass_g": lambda cell: 7.5e-3 * pi / 4.0 * cell("diameter_mm") ** 2 * cell("thickness_mm")
    }

    diameter_mm: Quantity
    thickness_mm: Quantity
    mass_g: Quantity

    def fault(self) -> str:
        """Says that it is no disc that an encoder reads."""
        if not 0.05 * self.diameter_mm < self.thickness_mm < 5.0 * self.diameter_mm:
            return "must have diameter_mm / 20 < thickness_mm < 5 diameter_mm"
        return ""


magnet = Family("magnet", "magnets.csv", Magnet)
