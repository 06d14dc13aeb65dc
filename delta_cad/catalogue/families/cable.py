"""Wire ropes for the capstan."""

from __future__ import annotations

from math import pi
from typing import ClassVar

from pydantic.dataclasses import dataclass

from delta_cad.catalogue.reader import Family
from delta_cad.catalogue.row import ROW, CatalogueRow, Quantity, Text, outside

# What no rope is, over its full circle: beyond, a number is in another unit than its column. Ours break at 655 to 817
# N/mm^2 and weigh 5.0 to 5.2 g/cm^3.
_BREAKS_N_mm2 = 50.0, 3000.0
_DENSITY_g_cm3 = 0.3, 9.0


@dataclass(frozen=True, kw_only=True, config=ROW)
class Cable(CatalogueRow):
    """A stainless steel wire rope for the capstan.

    Attributes:
        diameter_mm: Rope diameter.
        construction: Strands x wires ("7x19").
        breaking_load_N: Least breaking load.
        min_bend_ratio: Recommended least drum diameter over rope diameter for long life.
        mass_g_m: Mass per metre.
        axial_stiffness_N: Pull over stretch, E A, of the settled rope; None when no source was opened.
    """

    # steel fills 0.5 to 0.7 of the circle
    derived: ClassVar = {"mass_g_m": lambda cell: 0.6 * pi / 4.0 * cell("diameter_mm") ** 2 * 7.9}

    diameter_mm: Quantity
    construction: Text = "not stated"
    breaking_load_N: Quantity
    min_bend_ratio: Quantity = 40.0  # the largest that we list, of 7x7
    mass_g_m: Quantity
    axial_stiffness_N: Quantity | None = None

    def fault(self) -> str:
        """Says that strength or mass are not a rope's."""
        area_mm2 = pi / 4.0 * self.diameter_mm**2
        return outside(
            "breaking_load_N over the circle of diameter_mm", self.breaking_load_N / area_mm2, _BREAKS_N_mm2, "N/mm^2"
        ) or outside("mass_g_m over the circle of diameter_mm", self.mass_g_m / area_mm2, _DENSITY_g_cm3, "g/cm^3")


cable = Family("cable", "cables.csv", Cable)
