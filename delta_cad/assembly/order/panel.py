"""The order of what stands under the base and of what hangs over the machine: sleeves, panel, boot, bezel."""

from __future__ import annotations

from math import hypot

from delta_cad.assembly.order.record import Bring, Leg, Step
from delta_cad.assembly.order.shoulder import named
from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.installation.panel import TEMPLATE

DOWN = (Leg((0.0, 0.0, -1.0)),)
UP = (Leg((0.0, 0.0, 1.0)),)
OVER_MM = 1.0  # by which a screw's tip goes below the panel, on its way in from aside
TORQUE_N_m = 0.3  # of an M3 in a polyacetal's thread; from memory: until it no longer turns lightly
SQUARE_MM = 0.5  # of the opening about the handle: what a rule shows


def mounting_steps(d: Dimensions, names: tuple[str, ...]) -> list[Step]:
    """States how the base is screwed down; nothing where it only stands on its feet."""
    if d.design.hardware.mounting not in ("screws", "both"):
        return []
    sleeves = named(names, "mount_sleeve_")
    beside = "Slip a sleeve on each screw, between plate and floor: the feet give way by half a millimetre."
    words = (
        "Drill what the machine stands on by the mounting holes of the base plate's drawing, and screw it down.",
        *((beside,) if sleeves else ()),
    )
    brings = tuple(Bring((sleeve,), UP, "base_plate") for sleeve in sleeves)
    told = "on its sleeves" if sleeves else "flat"
    return [Step("Base screwed down", words, brings, supplies=("mount_screw",), checks=(f"The plate lies {told}.",))]


def panel_steps(d: Dimensions, names: tuple[str, ...]) -> list[Step]:
    """States how panel, boot and bezel come over the handle; nothing where the design has no panel."""
    if (p := d.panel) is None:
        return []
    screws = named(names, "bezel_screw_")
    far = p.half_mm + p.opening_mm - p.stem_radius_mm
    return [
        Step(
            "Panel over the handle",
            (
                f"Cut the panel by {TEMPLATE}.dxf, which is as large as it is to be, and break its edges.",
                f"Bring it down over the handle, its lower face {p.under_mm:g} mm over the shoulders' axes, its sides "
                "along x and y of the machine.",
            ),
            (Bring(("panel",), DOWN),),
            tools=("rule", "height gauge"),
            checks=(
                f"With the handle in the middle, the stem stands {far:.1f} mm off all four sides of the opening, to "
                f"{SQUARE_MM:g} mm.",
            ),
        ),
        Step(
            "Boot and bezel",
            (
                "Lay the boot's rim on the panel, its holes over the panel's, and draw the collar over knob and stem.",
                "Lay the bezel on it, put the screws in from below, move the handle out of their way, tighten them "
                "crosswise.",
                f"Tie the collar on the stem, {p.collar_mm - d.platform.boss_diameter_mm / 2:g} mm over the platform.",
            ),
            (
                Bring(("boot", "boot_collar"), is_laid=True),
                Bring(("bezel",), DOWN),
                *(_from_below(d, screw, at) for screw, at in zip(screws, p.screw_places(), strict=True)),
            ),
            screws,
            TORQUE_N_m,
            supplies=("boot_tie",),
            checks=(
                "The handle goes to every corner of the cube, and the boot is nowhere taut.",
                f"Pushed aside, the stem meets the bezel some {p.limit_mm:g} mm outside the cube, before any arm meets "
                "its stop.",
            ),
        ),
    ]


def _from_below(d: Dimensions, screw: str, at: tuple[float, float]) -> Bring:
    """A screw's way: in from aside under the panel, then up."""
    assert d.panel is not None
    inwards = (-at[0] / hypot(*at), -at[1] / hypot(*at), 0.0)
    return Bring((screw,), (Leg(inwards), Leg((0.0, 0.0, 1.0), d.panel.screw_mm + OVER_MM)), "base_plate")
