"""Unthreaded spacers: distance sleeves and thick washers that screws go through."""

from __future__ import annotations

from typing import ClassVar

from pydantic.dataclasses import dataclass

from delta_cad.catalogue.reader import Family
from delta_cad.catalogue.row import ROW, CatalogueRow, Lengths, Quantity, Text

_ROUNDING_MM = 1e-9


@dataclass(frozen=True, kw_only=True, config=ROW)
class Spacer(CatalogueRow):
    """A round sleeve without a thread, cut square at both ends.

    Attributes:
        thread: Thread of the screw that goes through ("M4").
        outer_mm: Outside diameter.
        inner_mm: Bore.
        lengths_mm: Stock lengths, ascending.
        length_tolerance_mm: Of a length, either way.
        material: Id of its material.
    """

    partners: ClassVar = {"thread": "screw", "material": "material"}

    thread: Text
    outer_mm: Quantity
    inner_mm: Quantity
    lengths_mm: Lengths
    length_tolerance_mm: Quantity
    material: Text

    def fault(self) -> str:
        """Says that it has no wall."""
        return "" if self.inner_mm < self.outer_mm else "must have inner_mm < outer_mm"


spacer = Family("spacer", "fasteners/spacers.csv", Spacer)


def stock_spacer(thread: str, length_mm: float, outer_mm: tuple[float, float], material: str = "") -> Spacer | None:
    """Chooses the spacer of the catalogue that serves: the first of its file, whose rows ascend in price for a thread.

    Args:
        thread: Of the screw through it, such as "M4".
        length_mm: Length, which must be in stock.
        outer_mm: Least and largest outside diameter.
        material: Id of its material; "": any.

    Returns:
        The row; None: none is in stock, and it has to be made.
    """
    low, high = outer_mm
    for row in spacer.rows.values():
        fits = row.thread == thread and low - _ROUNDING_MM <= row.outer_mm <= high + _ROUNDING_MM
        if fits and row.material == (material or row.material) and length_mm in row.lengths_mm:
            return row
    return None
