"""Dowel pins."""

from __future__ import annotations

from pydantic.dataclasses import dataclass

from delta_cad.catalogue.reader import Family
from delta_cad.catalogue.row import ROW, CatalogueRow, Lengths, Quantity


@dataclass(frozen=True, kw_only=True, config=ROW)
class Dowel(CatalogueRow):
    """A hardened parallel pin, tolerance m6, pressed into an H7 hole.

    Attributes:
        diameter_mm: Nominal diameter.
        chamfer_mm: Length of the chamfered end.
        lengths_mm: Stock lengths, ascending.
    """

    diameter_mm: Quantity
    chamfer_mm: Quantity
    lengths_mm: Lengths


dowel = Family("dowel", "fasteners/dowels.csv", Dowel)
