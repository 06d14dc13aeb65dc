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
# Young's modulus over the full circle, N/mm^2, by construction, of a settled rope by handbooks, from memory; one not
# listed counts as the softest. A maker's stretch of 302 stainless, 1.20e-5 W[lb] / D[in]^2 for 7x7, gives 73 GPa.
_HANDBOOK_N_mm2 = {"7x7": 57.3e3, "7x19": 42.4e3}
_NEW_SHARE = 0.9  # of it, of a rope that has not settled, up to a fifth of its breaking load (handbooks, from memory)
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
        axial_stiffness_N: Pull over stretch, E A, of the settled rope by its maker; None when no source was opened.
    """

    # steel fills 0.5 to 0.7 of the circle
    derived: ClassVar = {"mass_g_m": lambda cell: 0.6 * pi / 4.0 * cell("diameter_mm") ** 2 * 7.9}

    diameter_mm: Quantity
    construction: Text = "not stated"
    breaking_load_N: Quantity
    min_bend_ratio: Quantity = 40.0  # the largest that we list, of 7x7
    mass_g_m: Quantity
    axial_stiffness_N: Quantity | None = None

    @property
    def stiffness_N(self) -> tuple[float, float]:
        """Pull over stretch, E A, N: of a new rope by the softer of maker and handbook, of a settled one by its maker.

        The latter is the handbook's where no maker states any.
        """
        modulus = _HANDBOOK_N_mm2.get(self.construction, min(_HANDBOOK_N_mm2.values()))
        listed = modulus * pi / 4.0 * self.diameter_mm**2
        stated = listed if self.axial_stiffness_N is None else self.axial_stiffness_N
        return _NEW_SHARE * min(listed, stated), stated

    def fault(self) -> str:
        """Says that strength or mass are not a rope's."""
        area_mm2 = pi / 4.0 * self.diameter_mm**2
        return outside(
            "breaking_load_N over the circle of diameter_mm", self.breaking_load_N / area_mm2, _BREAKS_N_mm2, "N/mm^2"
        ) or outside("mass_g_m over the circle of diameter_mm", self.mass_g_m / area_mm2, _DENSITY_g_cm3, "g/cm^3")


cable = Family("cable", "cables.csv", Cable)
