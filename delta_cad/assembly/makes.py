"""What every part of a design is made of, or ordered as and weighs: stated here, held against what was made."""

from __future__ import annotations

from math import pi

from delta_cad import catalogue
from delta_cad.assembly.leads import lead_makes
from delta_cad.assembly.panel import panel_makes
from delta_cad.catalogue import CatalogueRow
from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.capstan import TENSION_SCREW
from delta_cad.dimensions.forearm import END_MATERIAL
from delta_cad.dimensions.joint import CUP_MATERIAL
from delta_cad.solids.bought.bearing import PRELOAD_PLAY_MM
from delta_cad.solids.bought.spring import spring_mass_g
from delta_cad.solids.making import ordered
from delta_cad.solids.part import Make

MACHINED = {
    "base_plate": "aluminium-6082",
    "motor_cheek": "aluminium-6082",
    "encoder_cheek": "aluminium-6082",
    "foot_block": "aluminium-6082",
    "board_spacer": "brass",
    "upper_arm": "aluminium-7075",
    "shoulder_shaft": "stainless-1.4305",
    "shoulder_washer": "stainless-1.4305",
    "cross_bar": "aluminium-7075",
    "sector": "aluminium-7075",
    "pinion": "aluminium-7075",
    "tension_carriage": "brass",
    "rod_cup": END_MATERIAL,
    "cup_shell": CUP_MATERIAL,
    "rod_eye": "aluminium-6082",
    "platform": "aluminium-7075",
    "handle_stem": "aluminium-6082",
}
"""Number of a part that is made from plate or bar -> its material."""
CABLE_PIECES = ("", "_inner", "_turns", "_inner_end", "_outer_end", "_strand_inner", "_strand_outer")
ROPE_FILL = (0.45, 0.75)  # strands of wires leave that much of their circle, drawn thinner by its play
SPRING_STEEL_G_MM3 = 7.9e-3  # 1.4310


def makes(d: Dimensions) -> tuple[Make, ...]:
    """States material, order and mass of every part number that a design may have; screws and pins by their stock."""
    stated = [Make(number, material, True) for number, material in MACHINED.items()]
    stated += [
        _bought("motor", d.motor, "aluminium-black", d.motor.mass_g),
        _bought("foot", d.foot, "rubber", d.foot.mass_g),
        _bought("knob", d.knob, "pf31", d.knob.mass_g),
        _bought("encoder_board", d.encoder, "fr4", d.encoder.mass_g),
        _bought("encoder_magnet", d.magnet, "ndfeb", d.magnet.mass_g),
        _bought("bearing", d.bearing, "steel", d.bearing.mass_g),
        _bought("rod_spring", d.forearm.spring, "steel", spring_mass_g(d.forearm)),
        Make("joint_ball", d.forearm.ball.material, True, *_order(d.forearm.ball)),
        Make("rod_tube", d.tube.material, True, *_order(d.tube)),
        *_stock(),
        *panel_makes(d),
        *lead_makes(d),
    ]
    if (c := d.capstan) is not None:
        rope = f"crimp sleeve for {c.cable_diameter_mm:g} mm wire rope"
        stated.append(Make("crimp_sleeve", "brass", False, rope))
        for piece in CABLE_PIECES:
            of = "capstan_cable" if piece else ""
            number, order = f"capstan_cable{piece}", _order(d.cable)
            stated.append(Make(number, "stainless-1.4305", False, *order, piece_of=of, fill=ROPE_FILL))
    if (row := d.preload) is not None:
        ring = pi / 4 * ((row.housing_mm - PRELOAD_PLAY_MM) ** 2 - row.inner_mm**2)
        stated.append(_bought("wave_spring", row, "steel", ring * row.thickness_mm * SPRING_STEEL_G_MM3))
    return tuple(stated)


def _bought(number: str, row: CatalogueRow, material: str, mass_g: float | None) -> Make:
    return Make(number, material, False, *_order(row), mass_g=mass_g)


def _order(row: CatalogueRow, size: str = "") -> tuple[str, str]:
    """Order code and standard of a row."""
    order = ordered(row, size)
    return order.get("order_code", ""), order.get("standard", "")


def _stock() -> list[Make]:
    """Screws, set screws and dowels in all lengths that are in stock."""
    found = []
    for prefix, family, material in (
        ("screw_", catalogue.screw, "stainless-1.4305"),
        ("set_screw_", catalogue.set_screw, "stainless-1.4305"),
        ("dowel_", catalogue.dowel, "steel"),
    ):
        for key, row in family.rows.items():
            for length in row.lengths_mm:
                found.append(Make(f"{prefix}{key}x{length:g}", material, False, *_order(row, f" x {length:g}")))
    pulls = catalogue.screw(TENSION_SCREW)
    for length in pulls.lengths_mm:
        number = f"tension_screw_{TENSION_SCREW}x{length:g}"
        found.append(Make(number, "stainless-1.4305", False, *_order(pulls, f" x {length:g}")))
    return found
