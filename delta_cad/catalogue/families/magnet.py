"""Magnets for shaft encoders."""

from __future__ import annotations

from dataclasses import dataclass

from delta_cad.catalogue.reader import Family
from delta_cad.catalogue.row import CatalogueRow


@dataclass(frozen=True)
class Magnet(CatalogueRow):
    """A diametrically magnetised disc for a shaft encoder."""

    diameter_mm: float
    thickness_mm: float
    mass_g: float


magnet = Family("magnet", "magnets.csv", Magnet)
