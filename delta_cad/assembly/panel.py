"""Panel, bezel and boot of a design, and the sleeves or the bench plate under its base: placed, with connections."""

from __future__ import annotations

from math import hypot, pi

from delta_cad import catalogue
from delta_cad.assembly.builder import (
    CHAMFERS_MM,
    DOWN,
    DRIVEN,
    SHARE,
    UP,
    AssemblyBuilder,
    at,
    bolted,
    pointing,
    pressed,
    ring,
    seated,
)
from delta_cad.assembly.machine import PathSegment
from delta_cad.dimensions.panel import CLOTH_MM, COLLAR_MM, SCREW, SLEEVE_WALL_MM
from delta_cad.dimensions.platform import BENCH_HOLE, MOUNT_SCREW, PAD_MM
from delta_cad.solids import panel
from delta_cad.solids.base_plate import make_bench_pad, make_bench_plate

_OVER_MM = 1.0  # by which a screw's tip goes below the panel, on its way in from aside


def place_sleeves(builder: AssemblyBuilder) -> None:
    """Places the sleeves under the base plate's mounting holes, where the design has any."""
    d, hole = builder.d, builder.d.base.mount_hole_mm
    if not d.sleeve_mm:
        return
    low = d.base.top_mm - d.base.thickness_mm - d.sleeve_mm
    under = seated("base_plate", ring(hole + 2 * SLEEVE_WALL_MM, hole), "sleeve under the plate")
    for k, (x, y) in enumerate(d.base.mounts_mm):
        sleeve = builder.made(panel.make_mount_sleeve)
        builder.put(f"mount_sleeve_{k}", sleeve, "base", at(x, y, low), under, path=UP, frame="base_plate")


def place_bench(builder: AssemblyBuilder) -> None:
    """Places the bench plate, its pads and the screws that hold the base plate on it, where the design has one."""
    b, bench = builder.d.base, builder.d.bench
    if bench is None:
        return
    area = SHARE * pi * (b.radius_mm**2 - sum(r**2 for _, _, r in b.holes_mm))
    on_it = seated("base_plate", area, "base plate on the bench plate")
    builder.put("bench_plate", builder.made(make_bench_plate), "base", at(), on_it, path=UP)
    under = seated("bench_plate", pi / 4 * PAD_MM[0] ** 2, "pad glued under the bench plate")
    for k, (x, y) in enumerate(bench.pads_mm):
        placed = at(x, y, bench.ground_mm)
        builder.put(f"bench_pad_{k}", builder.made(make_bench_pad), "base", placed, under, path=UP, frame="base_plate")
    row, hole = catalogue.low_screw(f"low-{MOUNT_SCREW}"), catalogue.screw(BENCH_HOLE).clearance_hole_mm
    screw, low = builder.cap_screw(row, bench.screw_mm), bench.top_mm - bench.thickness_mm
    held = (
        seated("bench_plate", SHARE * ring(row.head_diameter_mm, hole), "screw's head under the bench plate"),
        bolted("base_plate", bench.screw_mm - bench.thickness_mm - CHAMFERS_MM, "screw in the base plate's thread"),
    )
    for k, (x, y) in enumerate(b.mounts_mm):
        builder.put(f"mount_screw_{k}", screw, "base", pointing((0, 0, -1), x, y, low), *held, path=DRIVEN)


def place_panel(builder: AssemblyBuilder) -> tuple[str, ...]:
    """Places panel, boot and bezel, where the design has them.

    Returns:
        Names of what the dashboard carries, and not the base.
    """
    if (p := builder.d.panel) is None:
        return ()
    over, area = p.under_mm + p.thickness_mm, p.area_mm2(p.rim_mm) - p.area_mm2(p.opening_mm)
    on_panel, on_rim = seated("panel", area, "boot's rim on the panel"), seated("boot", area, "bezel on the boot's rim")
    middle = at(p.centre_x_mm)
    carried = [
        builder.put("panel", builder.made(panel.make_panel), "base", middle @ at(z=p.under_mm), path=DOWN),
        builder.put("boot", builder.made(panel.make_boot), "base", middle @ at(z=over), on_panel),
        builder.put("bezel", builder.made(panel.make_bezel), "base", middle @ at(z=over + CLOTH_MM), on_rim, path=DOWN),
    ]
    row = catalogue.screw(SCREW)
    held = (
        seated("panel", ring(row.head_diameter_mm, row.clearance_hole_mm), "screw's head under the panel"),
        bolted("bezel", 0.98 * (p.screw_mm - p.thickness_mm - CLOTH_MM), "screw in the bezel's thread"),
    )
    for k, (x, y) in enumerate(p.screw_places()):  # in from aside under the panel, then up
        inwards = (
            PathSegment((-x / hypot(x, y), -y / hypot(x, y), 0.0)),
            PathSegment((0.0, 0.0, 1.0), p.screw_mm + _OVER_MM),
        )
        placed, screw = middle @ pointing((0, 0, -1), x, y, p.under_mm), builder.screw(SCREW, p.screw_mm)
        carried.append(builder.put(f"bezel_screw_{k}", screw, "base", placed, *held, path=inwards, frame="base_plate"))
    builder.put("boot_collar", builder.made(panel.make_boot_collar), "platform", at(z=p.collar_mm))
    builder.connect("handle_stem", pressed("boot_collar", 0.95 * COLLAR_MM[1], "boot's collar tied on the stem"))
    builder.piece("boot", "boot_collar")
    return tuple(carried)
