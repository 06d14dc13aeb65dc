"""The moving platform, the handle's stem and its knob (platform's frame, z up)."""

from __future__ import annotations

import cadquery as cq

from delta_cad import catalogue
from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.platform import (
    BOSS_BEVEL_MM,
    STEM_FLATS_MM,
    STEM_FLATS_Z_MM,
    WRIST_MARK,
)
from delta_cad.dimensions.tolerances import bar_bore
from delta_cad.mechanism.placement import CHAINS
from delta_cad.solids.boring import Boring, along_z, between, placed, tapped, within
from delta_cad.solids.bought_parts import CORE_PLAY_MM
from delta_cad.solids.making import BLUE, bought_part, made_part, material, round_z
from delta_cad.solids.part import Hole, Part, Span
from delta_cad.solids.primitive import (
    THROUGH_MM,
    bevelled,
    bore_z,
    box,
    cut,
    cylinder,
    feature,
    fuse,
    hull_along_z,
    round_inside,
    stepped,
)

STEM_CORE_DEPTH_MM = 9.0


def turned_to_chain(d: Dimensions, solid: cq.Shape, i: int) -> cq.Shape:
    """A solid drawn in chain 0's frame, turned to chain i about z."""
    return solid.rotate(cq.Vector(0, 0, 0), cq.Vector(0, 0, 1), d.design.azimuths_deg[i])


def make_platform(d: Dimensions) -> Part:
    """Star of three bosses for the wrists' cross-bars around the handle's hub, with a window in each arm."""
    number, p = "platform", d.platform
    r, half, boss = p.radius_mm, p.boss_length_mm / 2, p.boss_diameter_mm / 2
    top = boss
    plate = (top - p.plate_mm, top)

    def body() -> cq.Shape:
        hub = bore_z(2 * p.hub_radius_mm, (0.0, 0.0), (-top, top))
        webs, shapes = list[cq.Shape](), list[cq.Shape]()
        for i in CHAINS:
            webs.append(turned_to_chain(d, hull_along_z(p.web_mm, plate), i))
            barrel = bevelled(boss, (-half, half), BOSS_BEVEL_MM, (r, 0.0, 0.0))
            shapes.append(turned_to_chain(d, barrel, i))
            if plate[0] > 0.0:  # an upright flank under the plate, where the boss would be undercut
                end = half - BOSS_BEVEL_MM
                shapes.append(turned_to_chain(d, box((r - boss, -end, 0.0), (r, end, plate[0])), i))
        # bosses will stand in the way of a cutter from the side
        star = round_inside(number, fuse(hub, *webs), (0.0, 0.0, 1.0), lambda _: False)
        return fuse(star, *shapes)

    shape = feature(number, "outline", "platform_radius_mm", body)
    boring, tools = Boring(), list[cq.Shape]()
    bars, (wider_um, zone) = [], bar_bore(d.is_printed(number))
    for i in CHAINS:
        u, t = d.turn(i)[:3, 0], d.turn(i)[:3, 1]
        ends = (tuple((r * u + side * t).tolist()) for side in (-half, half))
        bars.append(placed(within(between(p.bar_bore_mm, *ends), 0.0, wider_um), zone))
    boring.add(f"{p.bar_bore_mm:g} through each boss, a cross-bar's middle bonded in it", bars)
    boring.add(f"{p.stem_thread} through, handle", [tapped(along_z(0.0, (0.0, 0.0), (top, -top)), p.stem_thread)])
    if p.window_mm:
        window = hull_along_z(p.window_mm, (plate[0] - THROUGH_MM, plate[1] + THROUGH_MM))
        tools += [turned_to_chain(d, window, i) for i in CHAINS]
    solid = feature(
        number,
        "bores and windows",
        "platform_radius_mm, parallelogram_width_mm",
        lambda: cut(shape, [*boring.tools, *tools]),
    )
    description = f"platform, wrist radius {r:g}"
    if not d.design.geometry.three_fold:
        at = ", ".join(f"{angle:.6g}" for angle in d.design.azimuths_deg)
        marked = f"the one at 0 dimensioned and marked {WRIST_MARK}, scribed on its flat face"
        description += f". Three equal arms at {at} deg about the centre, {marked}"
    extent = *_reach(d), (-top, top)
    return made_part(number, description, solid, material(d.material_of("platform"), BLUE), extent, boring.holes)


def _reach(d: Dimensions) -> tuple[Span, Span]:
    """Reach of the wrist bosses along x and y: their bevelled ends, or their sides."""
    p = d.platform
    boss, half = p.boss_diameter_mm / 2, p.boss_length_mm / 2
    along: list[Span] = []
    for axis in range(2):
        reach = []
        for u in (d.turn(i)[axis] for i in CHAINS):
            middle = p.radius_mm * u[0]
            for radius, end in ((boss, half - BOSS_BEVEL_MM), (boss - BOSS_BEVEL_MM, half)):
                beyond = radius * abs(u[0]) + end * abs(u[1])
                reach += [middle - beyond, middle + beyond]
        along.append((min(reach), max(reach)))
    return along[0], along[1]


def make_handle_stem(d: Dimensions) -> Part:
    """Stem between platform and knob: threads at both ends; its foot stands on the platform at z = 0."""
    number, p = "handle_stem", d.platform
    core = (catalogue.screw(p.stem_thread).tap_drill_mm - CORE_PLAY_MM) / 2
    r, length, up = p.stem_diameter_mm / 2, p.stem_length_mm, d.knob.thread_depth_mm - 1.0
    down = min(STEM_CORE_DEPTH_MM, p.boss_diameter_mm - 0.5)

    stem = stepped((core, -down, 0.0), (r, 0.0, length), (core, length, length + up))
    stem = stem.rotate(cq.Vector(0, 0, 0), cq.Vector(1, 0, 0), 90.0)
    flat, far = (p.stem_diameter_mm - STEM_FLATS_MM) / 2, p.stem_diameter_mm
    low, high = STEM_FLATS_Z_MM
    flats = [box((x, -far, low), (x + far, far, high)) for x in (r - flat, flat - r - far)]
    solid = feature(number, "spanner flats", "stem", lambda: cut(stem, flats))
    description = f"handle stem {2 * r:g} x {length:g}, {p.stem_thread} at both ends, flats {STEM_FLATS_MM:g}"
    extent = round_z(r, (-down, length + up))
    return made_part(number, description, solid, material("aluminium-6082"), extent)


def make_knob(d: Dimensions) -> Part:
    """Ball knob: flat foot at z = 0, ball above."""
    row = d.knob
    radius, foot = row.diameter_mm / 2, row.foot_diameter_mm / 2
    centre = row.height_mm - radius
    drill = catalogue.screw(row.thread).tap_drill_mm
    sphere = cq.Solid.makeSphere(radius, cq.Vector(0, 0, centre), cq.Vector(0, 0, 1), -90, 90, 360)
    keep = cylinder(4 * radius, (0, 0, 0), (0, 0, row.height_mm + 1.0))
    neck = bore_z(2 * foot, (0.0, 0.0), (0.0, centre))
    shape = feature("knob", "ball", "hardware.knob", lambda: sphere.intersect(keep).fuse(neck))
    thread = bore_z(drill, (0.0, 0.0), (-THROUGH_MM, row.thread_depth_mm))
    solid = feature("knob", "thread", "hardware.knob", lambda: cut(shape, [thread]))
    extent = round_z(max(radius, foot), (0.0, row.height_mm))
    hole = Hole(drill, 1, f"{row.thread} x {row.thread_depth_mm:g}")
    return bought_part("knob", row, solid, "pf31", extent, row.mass_g, holes=(hole,))
