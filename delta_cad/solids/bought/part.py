"""A bought part of its catalogue row and its shape."""

from __future__ import annotations

import cadquery as cq

from delta_cad.catalogue import CatalogueRow
from delta_cad.solids.materials import material, provenance
from delta_cad.solids.part import Part
from delta_cad.solids.primitive import (
    one_solid,
)


def bought_part(number: str, row: CatalogueRow, shape: cq.Shape, substance: str, mass_g: float) -> Part:
    """Makes a part of a catalogue row.

    Args:
        number: Part number.
        row: Row it is ordered by.
        shape: Its outer shape, mm.
        substance: Id of the material it is mostly made of, for its colour.
        mass_g: Mass as the maker gives it.
    """
    return Part(
        number,
        row.description,
        one_solid(shape, number),
        material(substance),
        False,
        mass_g=mass_g,
        standard=row.standard,
        order_code=f"{row.maker} {row.order_code}" if row.maker != "any" else row.order_code,
        source=provenance(row),
    )
