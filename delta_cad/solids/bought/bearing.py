"""The shoulder's ball bearing."""

from __future__ import annotations

from delta_cad.dimensions import Dimensions
from delta_cad.solids.making import bought_part, round_y
from delta_cad.solids.part import Hole, Part
from delta_cad.solids.primitive import feature, turned


def make_bearing(d: Dimensions) -> Part:
    """Bearing along y from 0 to its width: both rings and the shields between them, drawn as one body."""
    b = d.bearing
    bore, outer = b.bore_mm / 2, b.outer_mm / 2
    inner_edge, outer_edge = b.inner_ring_outer_mm / 2, b.outer_ring_inner_mm / 2
    w, sunk = b.width_mm, 0.4
    ring = [
        (bore, 0.0),
        (inner_edge, 0.0),
        (inner_edge, sunk),
        (outer_edge, sunk),
        (outer_edge, 0.0),
        (outer, 0.0),
        (outer, w),
        (outer_edge, w),
        (outer_edge, w - sunk),
        (inner_edge, w - sunk),
        (inner_edge, w),
        (bore, w),
    ]
    shape = feature("bearing", "rings", "hardware.bearing", lambda: turned(ring))
    holes = Hole(b.bore_mm, 1, "bore"), Hole(b.outer_ring_inner_mm, 1, "inside of the outer ring")
    return bought_part("bearing", b, shape, "steel", round_y(outer, (0.0, w)), b.mass_g, holes=holes)
