"""Threaded inserts that are melted into printed parts."""

from __future__ import annotations

from typing import ClassVar

from pydantic.dataclasses import dataclass

from delta_cad.catalogue.reader import Family
from delta_cad.catalogue.row import ROW, CatalogueRow, Quantity, Text


@dataclass(frozen=True, kw_only=True, config=ROW)
class Insert(CatalogueRow):
    """A heat-set insert.

    Attributes:
        thread: Id of the screw that goes into it ("M3").
        outer_mm: Over its knurls.
        hole_mm: Of the hole that it is melted into.
        length_mm: Its length.
        wall_mm: Least plastic around the hole.
    """

    partners: ClassVar = {"thread": "screw"}

    thread: Text
    outer_mm: Quantity
    hole_mm: Quantity
    length_mm: Quantity
    wall_mm: Quantity
    mass_g: Quantity

    def fault(self) -> str:
        """Says that its knurls do not bite."""
        return "" if self.hole_mm < self.outer_mm else "must have hole_mm < outer_mm"


insert = Family("insert", "fasteners/inserts.csv", Insert)


def insert_of(thread: str) -> Insert | None:
    """Finds the insert of a thread, such as "M3"; None: there is none in the catalogue."""
    return next((row for row in insert.rows.values() if row.thread == thread), None)
