"""Wire ropes for the capstan."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi
from typing import ClassVar

from delta_cad.catalogue.reader import Family
from delta_cad.catalogue.row import CatalogueRow, outside

# What no rope is, over its full circle: beyond, a number is in another unit than its column. Ours break at 655 to 817
# N/mm^2 and weigh 5.0 to 5.2 g/cm^3.
BREAKS_N_mm2 = 50.0, 3000.0
DENSITY_g_cm3 = 0.3, 9.0


@dataclass(frozen=True)
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

    defaults: ClassVar = {
        **CatalogueRow.defaults,
        "construction": "not stated",
        "min_bend_ratio": 40.0,  # the largest that we list, of 7x7
        "mass_g_m": lambda row: 0.6 * pi / 4.0 * row["diameter_mm"] ** 2 * 7.9,  # steel fills 0.5 to 0.7 of the circle
    }

    diameter_mm: float
    construction: str
    breaking_load_N: float
    min_bend_ratio: float
    mass_g_m: float
    axial_stiffness_N: float | None

    def fault(self) -> str:
        """Says that strength or mass are not a rope's."""
        area_mm2 = pi / 4.0 * self.diameter_mm**2
        return outside(
            "breaking_load_N over the circle of diameter_mm", self.breaking_load_N / area_mm2, BREAKS_N_mm2, "N/mm^2"
        ) or outside("mass_g_m over the circle of diameter_mm", self.mass_g_m / area_mm2, DENSITY_g_cm3, "g/cm^3")


cable = Family("cable", "cables.csv", Cable)
