"""The dashboard's panel, its bezel and the boot between bezel and stem, each in its own frame; sleeves under the base.

Panel: z from its lower face; bezel: from its lower face; boot's rim: from the panel; collar: from its lower end.
"""

from __future__ import annotations

from dataclasses import replace

import cadquery as cq

from delta_cad import catalogue
from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.panel import (
    CLOTH_MM,
    COLLAR_MM,
    SCREW,
    SLEEVE_WALL_MM,
    TEMPLATE,
    PanelDimensions,
)
from delta_cad.dimensions.tolerances.mates import screw_zone_mm
from delta_cad.solids.boring import Boring, along_z, placed, tapped
from delta_cad.solids.bought_parts import make_spacer
from delta_cad.solids.making import GRAPHITE, made_part, material, round_z
from delta_cad.solids.part import Extent, Hole, Part, Span
from delta_cad.solids.primitive import THROUGH_MM, bore_z, cut, edge_break, feature, hull_along_z, one_solid

BOOT_CODE = "boot to pattern, coated cloth 0.6 mm, 250 g/m2"
_BOOT_SOURCE = "cloth and mass are estimates; verified: no, to be confirmed by the maker's offer"
_BREAK_MM = 0.5


def _panel_of(d: Dimensions) -> PanelDimensions:
    """Gives the dimensions of a design that has a panel."""
    assert d.panel is not None
    return d.panel


def square(p: PanelDimensions, corner_mm: float, z: Span) -> cq.Solid:
    """Prism over the cube's square with round corners about its own, see `dimensions/panel.py`."""
    half = p.half_mm
    corners = [(sx * half, sy * half, corner_mm) for sx, sy in ((1, 1), (-1, 1), (-1, -1), (1, -1))]
    return hull_along_z(corners, z)


def _frame(p: PanelDimensions, outer_mm: float, inner_mm: float, z: Span) -> cq.Shape:
    low, high = z
    return cut(square(p, outer_mm, z), [square(p, inner_mm, (low - THROUGH_MM, high + THROUGH_MM))])


def _reach(p: PanelDimensions, corner_mm: float, z: Span) -> Extent:
    far = p.half_mm + corner_mm
    return (-far, far), (-far, far), z


def _screws_zone_mm() -> float:
    """Zone of the bezel's screws, which alone hold it in its place."""
    row = catalogue.screw(SCREW)
    return screw_zone_mm(row.clearance_hole_mm, row.diameter_mm)


def make_panel(d: Dimensions) -> Part:
    """The dashboard's sheet around its opening, with the holes of the bezel's screws."""
    number, p = "panel", _panel_of(d)
    z, clear = (0.0, p.thickness_mm), catalogue.screw(SCREW).clearance_hole_mm
    boring = Boring()
    zone = _screws_zone_mm()
    boring.add(f"{clear:g} through, bezel", (placed(along_z(clear, at, z), zone) for at in p.screw_places()))
    solid = feature(number, "opening", "panel", lambda: cut(_frame(p, p.piece_mm, p.opening_mm, z), boring.tools))
    text = f"dashboard's panel {p.thickness_mm:g} thick, the piece around its opening; cut yours by {TEMPLATE}.dxf"
    extent = _reach(p, p.piece_mm, z)
    return made_part(number, text, solid, material("aluminium-6082"), extent, boring.holes)


def make_bezel(d: Dimensions) -> Part:
    """Frame that holds the boot on the panel; its edge stops the handle's stem."""
    number, p = "bezel", _panel_of(d)
    z = (0.0, p.bezel_mm)
    frame = edge_break(number, _frame(p, p.rim_mm, p.edge_mm, z), ">Z", _BREAK_MM)
    boring = Boring()
    threads = (tapped(along_z(0.0, at, z), SCREW, p.thread_mm) for at in p.screw_places())
    boring.add(f"{SCREW} x {p.thread_mm:g}, from below", (placed(one, _screws_zone_mm()) for one in threads))
    solid = feature(number, "threads", "panel", lambda: cut(frame, boring.tools))
    text = f"bezel {2 * (p.half_mm + p.rim_mm):g} square, its edge stops the stem {p.limit_mm:g} outside the cube"
    return made_part(number, text, solid, material("pom-c", GRAPHITE), _reach(p, p.rim_mm, z), boring.holes)


def make_boot(d: Dimensions) -> Part:
    """The boot, drawn as its rim between panel and bezel; with the mass of all that the handle does not carry."""
    number, p = "boot", _panel_of(d)
    z, hole = (0.0, CLOTH_MM), catalogue.screw(SCREW).clearance_hole_mm
    tools = [bore_z(hole, at, (-THROUGH_MM, CLOTH_MM + THROUGH_MM)) for at in p.screw_places()]
    solid = feature(number, "rim", "panel", lambda: cut(_frame(p, p.rim_mm, p.opening_mm, z), tools))
    text = f"boot of coated cloth, {p.cloth_mm:.0f} from the bezel's edge to its collar of {2 * p.stem_radius_mm:g}"
    holes = (Hole(hole, len(tools), f"{hole:g} through"),)
    return _cloth(number, text, solid, p.boot_g - p.carried_g, _reach(p, p.rim_mm, z), holes)


def make_boot_collar(d: Dimensions) -> Part:
    """The boot's collar on the stem, with the mass of all of it that the handle carries."""
    p, number = _panel_of(d), "boot_collar"
    height = COLLAR_MM[1]
    ring = bore_z(2 * p.collar_radius_mm, (0.0, 0.0), (0.0, height))
    bore = bore_z(2 * p.stem_radius_mm, (0.0, 0.0), (-THROUGH_MM, height + THROUGH_MM))
    shape, extent = cut(ring, [bore]), round_z(p.collar_radius_mm, (0.0, height))
    holes = (Hole(2 * p.stem_radius_mm, 1, "stem"),)
    return replace(_cloth(number, "boot, drawn in pieces", shape, p.carried_g, extent, holes), piece_of="boot")


def _cloth(number: str, text: str, shape: cq.Shape, mass_g: float, extent: Extent, holes: tuple[Hole, ...]) -> Part:
    solid, cloth = one_solid(shape, number), material("rubber")
    return Part(
        number, text, solid, cloth, False, holes, mass_g, extent_mm=extent, order_code=BOOT_CODE, source=_BOOT_SOURCE
    )


def make_mount_sleeve(d: Dimensions) -> Part:
    """Sleeve under a mounting hole, between the base plate and what it is screwed on, beside the feet."""
    return make_spacer(
        d.base.mount_hole_mm, d.sleeve_mm, "mount_sleeve", "aluminium-6082", 2 * SLEEVE_WALL_MM, "under the base plate"
    )
