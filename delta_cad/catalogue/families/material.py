"""Materials."""

from __future__ import annotations

from pydantic.dataclasses import dataclass

from delta_cad.catalogue.reader import Family
from delta_cad.catalogue.row import ROW, CatalogueRow, NotNegative, Quantity


@dataclass(frozen=True, kw_only=True, config=ROW)
class MaterialData(CatalogueRow):
    """A material.

    Attributes:
        red: Display colour with green and blue, sRGB 0..1.
        youngs_modulus_Pa: Young's modulus (along the fibre for CFRP).
        yield_strength_Pa: Yield or 0.2 % proof strength; strength for materials that do not yield; None when it has no
            use in design (magnets, electronics).
    """

    density_kg_m3: Quantity
    red: NotNegative
    green: NotNegative
    blue: NotNegative
    youngs_modulus_Pa: Quantity
    yield_strength_Pa: Quantity | None = None

    @property
    def colour(self) -> tuple[float, float, float]:
        """Display colour, sRGB 0..1."""
        return (self.red, self.green, self.blue)


material = Family("material", "materials.csv", MaterialData)
