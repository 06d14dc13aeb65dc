"""The shoulder's ball bearing, and the wave spring that preloads the pair."""

from __future__ import annotations

from dataclasses import replace
from math import pi

import cadquery as cq

from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.tolerances import preload_range_N, spring_height_mm
from delta_cad.solids.making import bought_part, round_y
from delta_cad.solids.part import Hole, Part
from delta_cad.solids.primitive import THROUGH_MM, bore_y, cut, feature, turned

PRELOAD_PLAY_MM = 0.3  # of diameter, by which a wave spring is smaller than its bore
STEEL_G_MM3 = 7.9e-3


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


def make_wave_spring(d: Dimensions) -> Part:
    """Wave spring along y from 0 to its working height, drawn as the ring between which it waves."""
    row = d.preload
    assert row is not None
    height, outer = row.work_height_mm, row.housing_mm - PRELOAD_PLAY_MM

    def ring() -> cq.Shape:
        inside = bore_y(row.inner_mm, (0.0, 0.0), (-THROUGH_MM, height + THROUGH_MM))
        return cut(bore_y(outer, (0.0, 0.0), (0.0, height)), [inside])

    shape = feature("wave_spring", "ring", "hardware.bearing", ring)
    mass = pi / 4 * (outer**2 - row.inner_mm**2) * row.thickness_mm * STEEL_G_MM3
    holes = (Hole(row.inner_mm, 1, "inside"),)
    extent = round_y(outer / 2, (0.0, height))
    (low, high), (least, most) = spring_height_mm(row), preload_range_N(row)
    at = f", {least:.1f} to {most:.1f} N at {high:.2f} to {low:.2f} mm in its seat"
    part = bought_part("wave_spring", row, shape, "steel", extent, mass, holes=holes)
    return replace(part, description=part.description + at)
