"""Magnets for shaft encoders."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi
from typing import ClassVar

from delta_cad.catalogue.reader import Family
from delta_cad.catalogue.row import CatalogueRow


@dataclass(frozen=True)
class Magnet(CatalogueRow):
    """A diametrically magnetised disc for a shaft encoder."""

    defaults: ClassVar = {
        **CatalogueRow.defaults,
        "mass_g": lambda row: 7.5e-3 * pi / 4.0 * row["diameter_mm"] ** 2 * row["thickness_mm"],  # 7500 kg/m3
    }

    diameter_mm: float
    thickness_mm: float
    mass_g: float

    def fault(self) -> str:
        """Says that it is no disc that an encoder reads."""
        if not 0.05 * self.diameter_mm < self.thickness_mm < 5.0 * self.diameter_mm:
            return "must have diameter_mm / 20 < thickness_mm < 5 diameter_mm"
        return ""


magnet = Family("magnet", "magnets.csv", Magnet)
