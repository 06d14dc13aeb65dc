"""Loose bearing balls, for ball joints."""

from __future__ import annotations

from typing import ClassVar

from pydantic.dataclasses import dataclass

from delta_cad.catalogue.reader import Family
from delta_cad.catalogue.row import ROW, CatalogueRow, Count, Quantity, Text


@dataclass(frozen=True, kw_only=True, config=ROW)
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

    diameter_mm: Quantity
    grade: Count
    roundness_um: Quantity
    lot_variation_um: Quantity
    material: Text
    mass_g: Quantity


ball = Family("ball", "balls.csv", Ball)
