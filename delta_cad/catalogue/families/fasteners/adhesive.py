"""Adhesives."""

from __future__ import annotations

from pydantic.dataclasses import dataclass

from delta_cad.catalogue.reader import Family
from delta_cad.catalogue.row import ROW, CatalogueRow, Quantity, Text

_KINDS = ("retaining", "structural")


@dataclass(frozen=True, kw_only=True, config=ROW)
class Adhesive(CatalogueRow):
    """An adhesive for cylindrical fits or for structural joints.

    Attributes:
        kind: "retaining" (anaerobic, between fitted metal) or "structural" (epoxy in an overlap).
        substrate: What the strength was measured on, as the source names it.
        shear_strength_MPa: Of that joint at room temperature, fully cured; None when no source was opened.
        gap_max_mm: Largest gap on the diameter that it fills; None when unknown or without meaning.
        handling_time_h: Until the joint may be moved; None when unknown.
        temperature_max_C: Highest lasting temperature; None when unknown.
    """

    kind: Text
    substrate: Text
    shear_strength_MPa: Quantity | None = None
    gap_max_mm: Quantity | None = None
    handling_time_h: Quantity | None = None
    temperature_max_C: Quantity | None = None

    def fault(self) -> str:
        """Says that its kind is not known."""
        return "" if self.kind in _KINDS else f"kind = {self.kind}: must be {' or '.join(_KINDS)}"


adhesive = Family("adhesive", "fasteners/adhesives.csv", Adhesive)
