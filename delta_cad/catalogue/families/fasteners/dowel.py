"""Dowel pins."""

from __future__ import annotations

from dataclasses import dataclass

from delta_cad.catalogue.reader import Family
from delta_cad.catalogue.row import CatalogueRow


@dataclass(frozen=True)
class Dowel(CatalogueRow):
    """A hardened parallel pin, tolerance m6, pressed into an H7 hole.

    Attributes:
        diameter_mm: Nominal diameter.
        chamfer_mm: Length of the chamfered end.
        lengths_mm: Stock lengths, ascending.
    """

    diameter_mm: float
    chamfer_mm: float
    lengths_mm: tuple[float, ...]


dowel = Family("dowel", "fasteners/dowels.csv", Dowel)
