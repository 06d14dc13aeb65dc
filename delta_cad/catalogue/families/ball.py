"""Loose bearing balls, for ball joints."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

from delta_cad.catalogue.reader import Family
from delta_cad.catalogue.row import CatalogueRow


@dataclass(frozen=True)
class Ball(CatalogueRow):
    """A loose bearing ball.

    Attributes:
        diameter_mm: Nominal diameter.
        grade: Grade by ISO 3290-1, the 10 of "G10".
        roundness_um: Largest deviation from a sphere that the grade allows.
        lot_variation_um: Largest difference of mean diameters in one lot.
        material: Id of its material.
    """

    partners: ClassVar = {"material": "material"}

    diameter_mm: float
    grade: int
    roundness_um: float
    lot_variation_um: float
    material: str
    mass_g: float


ball = Family("ball", "balls.csv", Ball)
