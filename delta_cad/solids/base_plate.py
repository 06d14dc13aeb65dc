"""The base plate under the three brackets, and the bench plate with its pads under that (base frame)."""

from __future__ import annotations

from math import cos, pi, radians, sin, sqrt

from delta_cad import catalogue
from delta_cad.common.units import MM_PER_M
from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.platform import BENCH_HOLE, BENCH_MATERIAL, MOUNT_SCREW, PAD_MM
from delta_cad.dimensions.tolerances import PREDRILLED_MM
from delta_cad.dimensions.tolerances.general import general_mm
from delta_cad.dimensions.tolerances.mates import screw_zone_mm
from delta_cad.solids.boring import Boring, along_z, placed, sunk, tapped
from delta_cad.solids.brackets import BASE_SCREW, DOWEL_MM, base_dowels, base_zone_mm, is_base_slotted
from delta_cad.solids.making import GRAPHITE, made_part, material, round_z
from delta_cad.solids.part import FOR_WHAT_IT_STANDS_ON, Bore, Part
from delta_cad.solids.primitive import bore_z, cut, edge_break, feature, hull_along_z, one_solid

_CORNER_MM = 6.0  # radius of the bench plate's corners
PAD_CODE = f"rubber disc {PAD_MM[0]:g} x {PAD_MM[1]:g}, 60 Shore A, self-adhesive"
_PAD_SOURCE = "common stock size; verified: no, from memory, check before ordering"


def make_base_plate(d: Dimensions) -> Part:
    """Disc, hull of discs, or six-sided plate, with the holes of all that is screwed to it."""
    number, b, k = "base_plate", d.base, d.bracket
    low, high = b.top_mm - b.thickness_mm, b.top_mm
    through = (low, high)
    blank = hull_along_z(b.rim_mm, (low, high)) if b.rim_mm else bore_z(2 * b.radius_mm, (0.0, 0.0), (low, high))
    plate = edge_break(number, blank, ">Z or <Z", 1.0)
    screw = catalogue.screw(BASE_SCREW)
    middle = (d.layers.encoder_cheek_mm[1] + d.layers.motor_cheek_mm[0]) / 2
    seat = low + screw.counterbore_depth_mm
    boring = Boring()

    def bored(callout: str, diameter: float, places: list[tuple[float, float]]) -> None:
        boring.add(callout, (along_z(diameter, at, through) for at in places))

    def of_chains(along: tuple[float, ...]) -> list[tuple[float, float]]:
        found = []
        for angle, out in zip(map(radians, d.design.azimuths_deg), d.outs_mm, strict=True):
            c, s = cos(angle), sin(angle)
            found += [((u + out) * c - middle * s, (u + out) * s + middle * c) for u in along]
        return found

    bored(f"{b.centre_hole_mm:g} through, cables", b.centre_hole_mm, [(0.0, 0.0)])
    screws, dowels = of_chains(k.base_screw_u_mm), of_chains(k.base_dowel_u_mm)
    rest = [placed(along_z(screw.clearance_hole_mm, at, (seat, high)), base_zone_mm(d)) for at in screws]
    boring.add(f"{screw.clearance_hole_mm:g} through, foot blocks", rest)
    heads = [sunk(along_z(screw.counterbore_diameter_mm, at, (low, seat))) for at in screws]
    boring.add(f"counterbore {screw.counterbore_depth_mm:g} deep from below", heads)
    how = (
        "" if is_base_slotted(d) else f", drilled {PREDRILLED_MM:g}, opened and reamed with the foot blocks at assembly"
    )
    pins = base_dowels(d, (along_z(DOWEL_MM, at, through) for at in dowels))
    boring.add(f"{DOWEL_MM:g} H7 through, dowels{how}", pins)
    if d.has_feet:
        boring.add(f"{d.foot.thread} through, feet", _threads(d, through))
    mounts = [tapped(along_z(0.0, at, through), MOUNT_SCREW) for at in b.mounts_mm]
    if d.bench is not None:
        mounts = [placed(thread, _bench_zone_mm(d)) for thread in mounts]
    boring.add(f"{MOUNT_SCREW} through, {FOR_WHAT_IT_STANDS_ON}", mounts)
    if b.window_mm:
        bored(f"{b.window_mm:g} through, lightening", b.window_mm, [(x, y) for x, y, _ in b.holes_mm[1:]])
    solid = feature(number, "bores", "base_radius_mm", lambda: cut(plate, boring.tools))
    along, across = b.reach_mm
    description = f"base plate {max(along[1] - along[0], across[1] - across[0]):.4g} x {b.thickness_mm:g}"
    if not d.design.geometry.three_fold:
        (_, first, second), radii = d.design.azimuths_deg, d.design.geometry.base_radii * MM_PER_M
        description += f", shoulder of chain 0 at R {radii[0]:.6g}, of chains 1, 2 at R {radii[1]:.6g}, "
        description += f"at azimuths 0, {first:.6g}, {second:.6g} deg"
    extent = along, across, (low, high)
    return made_part(number, description, solid, material(d.material_of("base_plate"), GRAPHITE), extent, boring.holes)


def _threads(d: Dimensions, through: tuple[float, float]) -> list[Bore]:
    """The feet's threads."""
    return [tapped(along_z(0.0, at, through), d.foot.thread) for at in d.base.feet_mm]


def make_bench_plate(d: Dimensions) -> Part:
    """Steel plate that a machine stands on which stands free, with holes for screws from below."""
    number, b = "bench_plate", d.bench
    assert b is not None
    z = (b.top_mm - b.thickness_mm, b.top_mm)
    blank = hull_along_z([(x, y, _CORNER_MM) for x, y in b.corners_mm(_CORNER_MM)], z)
    plate = edge_break(number, blank, ">Z or <Z", 1.0)
    boring = Boring()
    boring.add(f"{d.base.centre_hole_mm:g} through, cables", [along_z(d.base.centre_hole_mm, (0.0, 0.0), z)])
    hole = catalogue.screw(BENCH_HOLE).clearance_hole_mm
    boring.add(f"{hole:g} through, base plate", (along_z(hole, at, z) for at in d.base.mounts_mm))
    solid = feature(number, "bores", "mounting", lambda: cut(plate, boring.tools))
    long, wide = b.size_mm
    text = f"bench plate {long:g} x {wide:g} x {b.thickness_mm:g}, {b.mass_kg:.1f} kg, on which the machine stands free"
    return made_part(number, text, solid, material(BENCH_MATERIAL), (b.x_mm, b.y_mm, z), boring.holes)


def make_bench_pad(_: Dimensions) -> Part:
    """Rubber pad in a corner of the bench plate, z from the table."""
    (diameter, height), number = PAD_MM, "bench_pad"
    solid, rubber = one_solid(bore_z(diameter, (0.0, 0.0), (0.0, height)), number), material("rubber")
    grams, extent = pi / 4 * diameter**2 * height * rubber.density_kg_m3 * 1e-6, round_z(diameter / 2, (0.0, height))
    text = f"rubber pad {diameter:g} x {height:g}, self-adhesive, under the bench plate"
    return Part(
        number, text, solid, rubber, False, (), grams, extent_mm=extent, order_code=PAD_CODE, source=_PAD_SOURCE
    )


def _bench_zone_mm(d: Dimensions) -> float:
    """Zone of the threads of the bench plate's screws, whose holes in it are drilled to general tolerances."""
    hole, drilled = catalogue.screw(BENCH_HOLE).clearance_hole_mm, 2.0 * sqrt(2.0) * general_mm(d.base.mount_circle_mm)
    return screw_zone_mm(hole, catalogue.screw(MOUNT_SCREW).diameter_mm, other_mm=drilled)
