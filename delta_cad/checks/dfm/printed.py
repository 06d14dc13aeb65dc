"""Manufacturing rules of printed parts: walls, plastic around inserts, smallest holes, overhangs, the printer's bed."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from delta_cad.assembly.printing import inserts_of, overhang_mm2, print_up
from delta_cad.checks.dfm.bores import Finding, at, bores
from delta_cad.checks.dfm.lines import FAR_MM, Lines
from delta_cad.common.vectors import cross
from delta_cad.solids.part import Part

LEAST_WALL_MM = {"fdm": 1.2, "sls": 1.0}
"""Source: layer-one.com.au/blog/design-for-3d-printing-guide (two lines of filament), arti90.com/en/design-clues and
printit4me.com.au/guides/designing-for-3d-printing (powder); read 2026-11-28, as all below."""
_LEAST_HOLE_MM = {"fdm": 2.0, "sls": 1.5}  # the first two of these
_MOST_OVERHANG = 0.1  # of a part's area: supports that are broken off leave a rough face
BED_MM = 220.0  # edge of a common printer's bed, and its height
_SHOTS = 24  # directions about a hole in which the wall around it is looked at
_OFF_MM = 1e-3


def insert_walls(part: Part) -> Iterator[Finding]:
    """The thinnest plastic around each insert's hole over its length, over what its maker asks."""
    lines = Lines(part.solid)
    for bore, row in inserts_of(part):
        along, start = np.array(bore.direction), np.array(bore.start_mm)
        across = cross(along, np.eye(3)[int(np.argmin(np.abs(along)))])
        across /= np.linalg.norm(across)
        aside, begin = cross(along, across), bore.diameter_mm / 2 + _OFF_MM
        reach = FAR_MM
        for deep in (0.2 * row.length_mm, 0.5 * row.length_mm, 0.8 * row.length_mm):
            for angle in 2.0 * np.pi * np.arange(_SHOTS) / _SHOTS:
                way = np.cos(angle) * across + np.sin(angle) * aside
                if (hit := lines.first(start + deep * along + begin * way, way, reach)) is not None:
                    reach = min(reach, begin + hit[0])
        if reach < FAR_MM:
            wall = reach - row.hole_mm / 2
            where = f"{at(bore)}: {wall:.2f} mm around the insert {row.id}, {row.wall_mm:g} needed"
            yield Finding(part.number, round(wall, 3), row.wall_mm, where, is_least=True)


def insert_depths(part: Part) -> Iterator[Finding]:
    """Depth of each thread's hole over the length of the insert that goes into it."""
    for bore, row in inserts_of(part):
        where = f"{at(bore)}: {bore.depth_mm:.1f} mm deep, insert {row.id} has {row.length_mm:g}"
        yield Finding(part.number, bore.depth_mm, row.length_mm, where, is_least=True)


def small_holes(part: Part) -> Iterator[Finding]:
    """The smallest hole that is printed, not drilled at assembly."""
    for bore in bores(part):
        if not bore.thread:
            size = bore.predrilled_mm or bore.diameter_mm
            yield Finding(part.number, size, _LEAST_HOLE_MM[part.material.process], f"{at(bore)}: {size:g} mm", True)


def no_inserts(part: Part) -> Iterator[Finding]:
    """Threads for which the catalogue has no insert: printed threads strip."""
    with_one = {id(bore) for bore, _ in inserts_of(part)}
    for bore in bores(part):
        if bore.thread and id(bore) not in with_one:
            yield Finding(part.number, bore.diameter_mm, 0.0, f"{at(bore)}: no insert {bore.thread}")


def overhangs(part: Part) -> Iterator[Finding]:
    """Area to support as a share of a part's area, in the orientation that has the least."""
    up = print_up(part)
    share = overhang_mm2(part, up) / float(part.solid.Area())
    x, y, z = (round(float(v)) for v in up)
    yield Finding(part.number, share, _MOST_OVERHANG, f"{part.number}: {100 * share:.1f} %, ({x}, {y}, {z}) up")


def sizes(part: Part) -> Iterator[Finding]:
    """Largest edge of a part over the printer's bed."""
    box = part.solid.BoundingBox(1e-3)
    edge = max(box.xlen, box.ylen, box.zlen)
    yield Finding(part.number, edge, BED_MM, f"{part.number}: {edge:.0f} mm")
