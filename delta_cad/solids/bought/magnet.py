"""The encoder's magnet."""

from __future__ import annotations

from delta_cad.dimensions import Dimensions
from delta_cad.solids.making import bought_part, round_y
from delta_cad.solids.part import Part
from delta_cad.solids.primitive import bore_y


def make_encoder_magnet(d: Dimensions) -> Part:
    """Encoder magnet along y from 0 to its thickness."""
    m = d.magnet
    y = (0.0, m.thickness_mm)
    extent = round_y(m.diameter_mm / 2, y)
    return bought_part("encoder_magnet", m, bore_y(m.diameter_mm, (0.0, 0.0), y), "ndfeb", extent, m.mass_g)
