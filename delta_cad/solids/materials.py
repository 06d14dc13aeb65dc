"""Material records of the catalogue as parts carry them."""

from __future__ import annotations

from delta_cad import catalogue
from delta_cad.solids.part import Material


def material(key: str, colour: tuple[float, float, float] | None = None) -> Material:
    """Material of a catalogue id; `colour` shows an anodised or painted part."""
    row = catalogue.material(key)
    return Material(row.description, row.density_kg_m3, colour or row.colour)


GRAPHITE = (0.22, 0.23, 0.26)  # anodised colours of the parts that a person tells apart in the pictures
ORANGE = (0.85, 0.36, 0.08)
BLUE = (0.16, 0.42, 0.68)
