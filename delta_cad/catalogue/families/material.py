"""Materials."""

from __future__ import annotations

from pydantic.dataclasses import dataclass

from delta_cad.catalogue.reader import Family
from delta_cad.catalogue.row import ROW, CatalogueRow, MaybeText, NotNegative, Quantity


@dataclass(frozen=True, kw_only=True, config=ROW)
class MaterialData(CatalogueRow):
    """A material.

    Attributes:
        red: Display colour with green and blue, sRGB 0..1.
        youngs_modulus_Pa: Young's modulus (along the fibre for CFRP).
        yield_strength_Pa: Yield or 0.2 % proof strength; strength for materials that do not yield; None when it has no
            use in design (magnets, electronics).
        process: How parts of it are printed, "fdm" or "sls"; "" where they are cut. Figures are of solid prints.
        creep_modulus_Pa: Stress over strain after 1000 h of a printed part, which designs count with; as all that
            follows None of what is cut.
        layer_strength_Pa: Strength across its layers.
        deflection_temperature_C: Temperature of deflection under 0.45 MPa.
    """

    density_kg_m3: Quantity
    red: NotNegative
    green: NotNegative
    blue: NotNegative
    youngs_modulus_Pa: Quantity
    yield_strength_Pa: Quantity | None = None
    process: MaybeText = ""
    creep_modulus_Pa: Quantity | None = None
    layer_strength_Pa: Quantity | None = None
    deflection_temperature_C: Quantity | None = None

    def fault(self) -> str:
        """Says that no known process prints it, or that a figure of printed parts is missing, or there for cut ones."""
        if self.process not in ("", "fdm", "sls"):
            return f"process = {self.process}: must be fdm or sls, or empty for a material that is cut"
        printed = self.creep_modulus_Pa, self.layer_strength_Pa, self.deflection_temperature_C
        if {value is not None for value in printed} != {bool(self.process)}:
            return "must have creep_modulus_Pa, layer_strength_Pa and deflection_temperature_C, or none and no process"
        return ""

    @property
    def design_modulus_Pa(self) -> float:
        """Modulus that stiffness is computed with: of a printed part that after creep."""
        return self.creep_modulus_Pa or self.youngs_modulus_Pa

    @property
    def design_strength_Pa(self) -> float | None:
        """Strength that loads are held against: of a printed part that across its layers."""
        return self.layer_strength_Pa or self.yield_strength_Pa

    @property
    def colour(self) -> tuple[float, float, float]:
        """Display colour, sRGB 0..1."""
        return (self.red, self.green, self.blue)


material = Family("material", "materials.csv", MaterialData)
