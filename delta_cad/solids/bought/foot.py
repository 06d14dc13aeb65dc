"""The rubber foot."""

from __future__ import annotations

from typing import cast

from delta_cad import catalogue
from delta_cad.dimensions import Dimensions
from delta_cad.solids.bought.fasteners import CORE_PLAY_MM
from delta_cad.solids.making import bought_part, round_z
from delta_cad.solids.part import Hole, Part
from delta_cad.solids.primitive import bore_z, cut, fuse


def make_foot(d: Dimensions) -> Part:
    """Rubber foot hanging below z = 0, its stud above."""
    f = d.foot
    holes: tuple[Hole, ...] = ()
    pad = bore_z(f.diameter_mm, (0.0, 0.0), (-f.height_mm, 0.0))
    if f.stud_length_mm is not None:
        core = catalogue.screw(f.thread).tap_drill_mm - CORE_PLAY_MM
        shape = fuse(pad, bore_z(core, (0.0, 0.0), (-1.0, f.stud_length_mm)))
    else:
        hole = cast(float, f.hole_diameter_mm)  # the catalogue refuses feet with neither
        row = catalogue.screw(f.thread)
        seat = row.counterbore_depth_mm - f.height_mm
        tools = [bore_z(hole, (0.0, 0.0), (-f.height_mm - 1, 1))]
        tools.append(bore_z(row.counterbore_diameter_mm, (0.0, 0.0), (-f.height_mm - 1, seat)))
        shape = cut(pad, tools)
        sunk = f"counterbore {row.counterbore_diameter_mm:g} x {row.counterbore_depth_mm:g}"
        holes = Hole(hole, 1, f"{hole:g} through"), Hole(row.counterbore_diameter_mm, 1, sunk)
    extent = round_z(f.diameter_mm / 2, (-f.height_mm, f.stud_length_mm or 0.0))
    return bought_part("foot", f, shape, "rubber", extent, f.mass_g, holes=holes)
