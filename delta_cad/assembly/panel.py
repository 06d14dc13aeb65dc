"""Panel, bezel and boot of a design, and the sleeves under its base: placed, with contacts and supplies."""

from __future__ import annotations

from math import pi

from delta_cad import catalogue
from delta_cad.assembly.bench import Bench, at, pointing
from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.installation.panel import CLOTH_MM, COLLAR_MM, SCREW, SLEEVE_WALL_MM
from delta_cad.solids import panel
from delta_cad.solids.base_plate import mount_places
from delta_cad.solids.bought.fasteners import CORE_PLAY_MM
from delta_cad.solids.panel import panel_of
from delta_cad.solids.part import Contact, Supply

SHARE = 0.6  # of a flat face, beside edges and the bores of screws
SEATED_MM = 0.02  # along a normal: what a shim cannot enter
FIT_MM = 0.02  # radius: the collar is tied on the stem
FLOOR = "screw M5"  # by which the base is held down: its length depends on what it stands on


def place_sleeves(bench: Bench) -> None:
    """Places the sleeves under the base plate's mounting holes, where the design has any."""
    d = bench.d
    if not d.sleeve_mm:
        return
    sleeve = bench.once("mount_sleeve", lambda: panel.make_mount_sleeve(d))
    low = d.base.top_mm - d.base.thickness_mm - d.sleeve_mm
    for k, (x, y) in enumerate(mount_places(d)):
        bench.put(f"mount_sleeve_{k}", sleeve, "base", at(x, y, low))


def place_panel(bench: Bench) -> tuple[str, ...]:
    """Places panel, boot and bezel, where the design has them.

    Returns:
        Names of what the dashboard carries, and not the base.
    """
    d = bench.d
    if d.panel is None:
        return ()
    p, over = panel_of(d), d.panel.under_mm + d.panel.thickness_mm
    carried = [
        bench.put("panel", bench.once("panel", lambda: panel.make_panel(d)), "base", at(z=p.under_mm)),
        bench.put("boot", bench.once("boot", lambda: panel.make_boot_rim(d)), "base", at(z=over)),
        bench.put("bezel", bench.once("bezel", lambda: panel.make_bezel(d)), "base", at(z=over + CLOTH_MM)),
    ]
    screw = bench.screw(SCREW, p.screw_mm)
    for k, (x, y) in enumerate(p.screw_places()):
        carried.append(bench.put(f"bezel_screw_{k}", screw, "base", pointing((0, 0, -1), x, y, p.under_mm)))
    collar = bench.once("boot_collar", lambda: panel.make_boot_collar(d))
    bench.piece("boot", bench.put("boot_collar", collar, "platform", at(z=p.collar_mm)))
    return tuple(carried)


def panel_contacts(d: Dimensions) -> tuple[Contact, ...]:
    """Declares what of panel, boot, bezel and sleeves lies on what."""
    found = []
    hole = d.base.mount_hole_mm
    ring = SHARE * pi / 4 * ((hole + 2 * SLEEVE_WALL_MM) ** 2 - hole**2)
    for k in range(len(mount_places(d)) if d.sleeve_mm else 0):
        found.append(Contact(f"mount_sleeve_{k}", "base_plate", "plane", ring, SEATED_MM, "sleeve under the plate"))
    if (p := d.panel) is None:
        return tuple(found)
    area = SHARE * (p.area_mm2(p.rim_mm) - p.area_mm2(p.opening_mm))
    found.append(Contact("boot", "panel", "plane", area, SEATED_MM, "boot's rim on the panel"))
    found.append(Contact("bezel", "boot", "plane", area, SEATED_MM, "bezel on the boot's rim"))
    row = catalogue.screw(SCREW)
    under = SHARE * pi / 4 * (row.head_diameter_mm**2 - row.clearance_hole_mm**2)
    for k in range(len(p.screw_places())):
        name = f"bezel_screw_{k}"
        found.append(Contact(name, "panel", "plane", under, SEATED_MM, "screw's head under the panel"))
        thread = p.screw_mm - p.thickness_mm - CLOTH_MM
        found.append(Contact(name, "bezel", "cylinder", 0.98 * thread, CORE_PLAY_MM, "screw in the bezel's thread"))
    found.append(
        Contact("handle_stem", "boot_collar", "cylinder", 0.95 * COLLAR_MM[1], FIT_MM, "boot's collar tied on the stem")
    )
    return tuple(found)


def panel_supplies(d: Dimensions) -> tuple[Supply, ...]:
    """Lists what holds the base down and the boot on its stem."""
    found = []
    if d.design.hardware.mounting in ("screws", "both"):
        through = d.base.thickness_mm + d.sleeve_mm
        text = f"{FLOOR} through the base plate, {through:g} mm and what it stands on long"
        count = len(mount_places(d))
        found.append(Supply("mount_screw", text, count, "", 0.0, "ISO 4762", f"ISO 4762 {FLOOR[6:]}", "stock screw"))
    if d.panel is not None:
        text = "cable tie 2.5 around the boot's collar"
        found.append(Supply("boot_tie", text, 1, "Polyamide", 0.0, "", "cable tie 2.5 x 100", "stock tie"))
    return tuple(found)
