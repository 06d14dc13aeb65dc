"""Tubes, of which the rods are cut."""

from __future__ import annotations

from typing import ClassVar

from pydantic.dataclasses import dataclass

from delta_cad.catalogue.reader import Family
from delta_cad.catalogue.row import ROW, CatalogueRow, Quantity, Text


@dataclass(frozen=True, kw_only=True, config=ROW)
class Tube(CatalogueRow):
    """A round tube, cut to length.

    Attributes:
        outer_mm: Outside diameter.
        inner_mm: Inside diameter.
        material: Id of its material.
        youngs_modulus_Pa: Along the tube, where its maker states one; None: that of the material.
    """

    partners: ClassVar = {"material": "material"}

    outer_mm: Quantity
    inner_mm: Quantity
    material: Text = "cfrp"
    youngs_modulus_Pa: Quantity | None = None

    def fault(self) -> str:
        """Says that the tube has no wall."""
        return "" if self.inner_mm < self.outer_mm else "must have inner_mm < outer_mm"


tube = Family("tube", "tubes.csv", Tube)
