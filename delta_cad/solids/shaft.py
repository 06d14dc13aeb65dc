"""The shoulder shaft (or a direct drive's stub) with the encoder magnet in its end; y along the axis."""

from __future__ import annotations

from delta_cad.dimensions import Dimensions
from delta_cad.solids.making import made_part, round_y
from delta_cad.solids.materials import material
from delta_cad.solids.part import Hole, Part
from delta_cad.solids.primitive import THROUGH_MM, bore_y, cut, feature, turned

EDGE_MM = 0.3


def make_shoulder_shaft(d: Dimensions) -> Part:
    """Turned shaft; the magnet's seat is bored in the encoder's end."""
    number, s = "shoulder_shaft", d.shaft
    (y0, y1), r, head = s.y_mm, s.diameter_mm / 2, s.head_diameter_mm / 2
    profile = [(0.0, y0), (head - EDGE_MM, y0), (head, y0 + EDGE_MM)]
    if head > r:
        profile += [(head, s.head_to_y_mm), (r, s.head_to_y_mm)]
    profile += [(r, y1 - EDGE_MM), (r - EDGE_MM, y1), (0.0, y1)]
    seat = bore_y(s.magnet_bore_mm, (0.0, 0.0), (y0 - THROUGH_MM, y0 + s.magnet_depth_mm))
    solid = feature(number, "magnet seat", "hardware.magnet", lambda: cut(turned(profile), [seat]))
    description = f"shoulder shaft {s.diameter_mm:g} h6 x {y1 - y0:.1f}"
    hole = Hole(s.magnet_bore_mm, 1, f"{s.magnet_bore_mm:g} x {s.magnet_depth_mm:g}, magnet bonded flush")
    return made_part(number, description, solid, material("stainless-1.4305"), round_y(head, s.y_mm), [hole])
