"""Wire ropes for the capstan."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi
from typing import ClassVar

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


cable = Family("cable", "cables.csv", Cable)
