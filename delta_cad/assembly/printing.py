"""What a printer is given of a printed part: its orientation, and the body with the holes that it is printed with.

The machine is drawn with its inserts in: a thread is there as its core. The body to print has the insert's hole
instead, and other holes are wider by what they shrink. A bore with a fit has its nominal diameter: it comes out
narrower by that, and is reamed. Dowels' holes that are reamed through two parts at assembly have their pilot hole, or
none.
"""

# pyright: reportAttributeAccessIssue=false
# OCP builds its modules at run time, so a type checker does not see their names

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from math import cos, radians
from typing import Any

import numpy as np

from delta_cad.assembly.tessellation import Mesh, tessellate
from delta_cad.catalogue.families.fasteners.insert import Insert, insert_of
from delta_cad.common.memoize import memoize
from delta_cad.solids.part import Bore, Part, Triple

SHRINK_MM = {"fdm": 0.2, "sls": 0.1}
"""By which a printed hole comes out narrower than drawn. Source: layer-one.com.au/blog/design-for-3d-printing-guide;
of powder from memory (read 2026-11-28)."""
STEEP_DEG = 45.0  # of an overhang against the horizontal, below which filament needs support
_BRIDGED_MM = 8.0  # diameter of a level hole whose top bridges itself
_RELIEF_MM = 1.0  # of an insert's hole past its end, for the plastic that it displaces
_BED_MM = 0.05  # above the lowest point, within which a face lies on the bed
_MESH_MM, _MESH_RAD = 0.02, 0.2


def inserts_of(part: Part) -> list[tuple[Bore, Insert]]:
    """Lists the threads of a printed part that get an insert, each with its row; two in line each have their own."""
    if not part.material.process:
        return []
    threads = [bore for hole in part.holes for bore in hole.bores if bore.thread]
    return [(bore, row) for bore in threads if (row := insert_of(bore.thread)) is not None]


@memoize
def print_up(part: Part) -> np.ndarray:
    """Finds the axis of a part that points up in the printer, (3,): that with the least area to support."""
    ways = [sign * axis for axis in np.eye(3) for sign in (1.0, -1.0)]
    overhangs = [overhang_mm2(part, up) for up in ways]
    beds = [bed_mm2(part, up) for up in ways]
    return ways[min(range(len(ways)), key=lambda k: (round(overhangs[k], 1), -round(beds[k], 1)))]


def overhang_mm2(part: Part, up: np.ndarray) -> float:
    """Computes the area of a part that hangs over nothing, flatter than `STEEP_DEG`, printed with an axis up, mm^2.

    Level holes up to 8 mm bridge themselves and do not count; powder supports everything.
    """
    if part.material.process == "sls":
        return 0.0
    mesh, bed = _mesh(part), _lowest(part, up)
    normals, areas, middles = _triangles(mesh)
    down = (normals @ up < -cos(radians(STEEP_DEG))) & (middles @ up > bed + _BED_MM)
    for bore in (bore for hole in part.holes for bore in hole.bores):
        along = np.array(bore.direction)
        if bore.diameter_mm <= _BRIDGED_MM and abs(along @ up) < 0.1:
            apart = middles - np.array(bore.start_mm)
            off = np.linalg.norm(apart - (apart @ along)[:, None] * along, axis=1)
            down &= ~((off <= bore.diameter_mm / 2 + _BED_MM) & (np.abs(normals @ along) < 0.1))
    return float(areas[down].sum())


def bed_mm2(part: Part, up: np.ndarray) -> float:
    """Computes the area with which a part stands on the bed, printed with an axis up, mm^2."""
    normals, areas, middles = _triangles(_mesh(part))
    return float(areas[(normals @ up < -0.99) & (middles @ up < _lowest(part, up) + _BED_MM)].sum())


def print_high_mm(part: Part, up: np.ndarray) -> float:
    """Computes how high a part stands, printed with an axis up, mm."""
    return float(np.ptp(_mesh(part).vertices @ up))


def _lowest(part: Part, up: np.ndarray) -> float:
    return float((_mesh(part).vertices @ up).min())


def _triangles(mesh: Mesh) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Normals (n, 3), areas (n,) and middles (n, 3) of a mesh's triangles."""
    a, b, c = np.moveaxis(mesh.triangles, 1, 0)
    across = np.cross(b - a, c - a)
    doubled = np.linalg.norm(across, axis=1)
    return across / np.maximum(doubled, 1e-12)[:, None], doubled / 2.0, (a + b + c) / 3.0


@memoize
def _mesh(part: Part) -> Mesh:
    return tessellate(part.solid, _MESH_MM, _MESH_RAD)


def print_body(part: Part) -> Any:
    """Makes the solid to print of a printed part, in the part's frame: a `cadquery.Solid`.

    Raises:
        BuildError: The cuts leave no valid solid.
    """
    from delta_cad.solids.boring import tool  # these load the CAD kernel
    from delta_cad.solids.primitive import cut, cylinder, fuse, one_solid

    together = [bore for hole in part.holes for bore in hole.bores if bore.reamed_with]
    plugs = [cylinder(bore.diameter_mm, bore.start_mm, _end(bore)) for bore in together]
    solid = fuse(part.solid, *plugs) if plugs else part.solid
    tools = [tool(bore) for bore in printed_bores(part)]
    return one_solid(cut(solid, tools) if tools else solid, part.number)


def _end(bore: Bore) -> Triple:
    x, y, z = (np.array(bore.start_mm) + bore.depth_mm * np.array(bore.direction)).tolist()
    return x, y, z


def printed_bores(part: Part) -> Iterator[Bore]:
    """Gives the holes that are printed otherwise than they are drawn, as they are printed."""
    shrink, inserted = SHRINK_MM[part.material.process], inserts_of(part)
    for bore, row in inserted:
        deep = min(row.length_mm + _RELIEF_MM, bore.depth_mm) if bore.through else row.length_mm + _RELIEF_MM
        yield replace(bore, diameter_mm=row.hole_mm + shrink, depth_mm=deep, through=False, tip_deg=0.0)
    for bore in (bore for hole in part.holes for bore in hole.bores):
        if bore.predrilled_mm:
            yield replace(bore, diameter_mm=bore.predrilled_mm + shrink)
        elif not (bore.fit or bore.thread):
            yield replace(bore, diameter_mm=bore.diameter_mm + shrink)


def print_mesh(part: Part) -> Mesh:
    """Meshes the body to print, turned so that it stands on the bed, z up, its lowest point at 0."""
    mesh, up = tessellate(print_body(part), _MESH_MM, _MESH_RAD), print_up(part)
    aside = np.eye(3)[(int(np.abs(up).argmax()) + 1) % 3]
    turn = np.stack([aside, np.cross(up, aside), up])
    vertices = mesh.vertices @ turn.T
    return Mesh(vertices - [0.0, 0.0, vertices[:, 2].min()], mesh.faces, mesh.deviation_mm, mesh.layer_mm3)
