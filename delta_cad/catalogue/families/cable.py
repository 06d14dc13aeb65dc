"""Wire ropes for the capstan."""

from __future__ import annotations

from dataclasses import dataclass

from delta_cad.catalogue.reader import Family
from delta_cad.catalogue.row import CatalogueRow


@dataclass(frozen=True)
class Cable(CatalogueRow):
    """A stainless steel wire rope for the capstan.

    Attributes:
        diameter_mm: Rope diameter.
        construction: Strands x wires ("7x19").
        breaking_load_N: Least breaking load.
        min_bend_ratio: Recommended least drum diameter over rope diameter for long life.
        mass_g_m: Mass per metre.
    """

    diameter_mm: float
    construction: str
    breaking_load_N: float
    min_bend_ratio: float
    mass_g_m: float


cable = Family("cable", "cables.csv", Cable)
