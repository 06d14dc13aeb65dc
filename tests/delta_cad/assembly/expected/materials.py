"""What every part of a design is made of, or ordered as and weighs, from the rows of the catalogue."""

from __future__ import annotations

from dataclasses import dataclass
from math import pi

from delta_cad import catalogue
from delta_cad.catalogue import CatalogueRow
from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.capstan import TENSION_SCREW
from delta_cad.dimensions.leads import LEAD_G_M, SENSOR_G_M
from delta_cad.solids.base_plate import PAD_CODE
from delta_cad.solids.bought_parts import spring_mass_g
from delta_cad.solids.leads import CLIP, CLIP_G, CODES, SENSOR
from delta_cad.solids.making import ordered
from delta_cad.solids.panel import BOOT_CODE
from tests.delta_cad.assembly.expected.parts import MACHINED

CABLE_PIECES = ("", "_inner", "_turns", "_inner_end", "_outer_end", "_strand_inner", "_strand_outer")
ROPE_FILL = (0.45, 0.75)  # strands of wires leave that much of their circle, drawn thinner by its play
SPRING_STEEL_G_MM3 = 7.9e-3  # 1.4310


@dataclass(frozen=True)
class ExpectedMake:
    """What the parts of a number are made of or ordered as.

    Attributes:
        number: Part number.
        material: Id of the material in the catalogue.
        make: True when we machine it, False when it is bought.
        order_code: What it, or the stock it is made from, is ordered by; "" for none.
        standard: That what is bought follows; "" for none.
        piece_of: As in `Part`: a part that says so falsely is missing from the bill of materials.
        mass_g: Mass as its maker states it; None: its volume times its density, within `fill`.
        fill: Least and largest share of that which is mass, of what is drawn as a solid bar and is none.
        to_drawing: Whether a maker of such parts makes it by our drawing: nobody has it in stock.
    """

    number: str
    material: str
    make: bool
    order_code: str = ""
    standard: str = ""
    piece_of: str = ""
    mass_g: float | None = None
    fill: tuple[float, float] = (1.0, 1.0)
    to_drawing: bool = False


def expected_makes(d: Dimensions) -> tuple[ExpectedMake, ...]:
    """Lists material, order and mass of every part number that a design may have; screws and pins by their stock."""
    stated = [ExpectedMake(number, material, True) for number, material in MACHINED.items()]
    stated += [
        _bought("motor", d.motor, "aluminium-black", d.motor.mass_g),
        _bought("foot", d.foot, "rubber", d.foot.mass_g),
        _bought("knob", d.knob, "pf31", d.knob.mass_g),
        _bought("encoder_board", d.encoder, "fr4", d.encoder.mass_g),
        _bought("encoder_magnet", d.magnet, "ndfeb", d.magnet.mass_g),
        _bought("bearing", d.bearing, "steel", d.bearing.mass_g),
        _bought("rod_spring", d.forearm.spring, "spring-wire", spring_mass_g(d.forearm)),
        ExpectedMake("joint_ball", d.forearm.ball.material, True, *_order(d.forearm.ball)),
        ExpectedMake("rod_tube", d.tube.material, True, *_order(d.tube)),
        _spacer("board_spacer", d.board_spacer, "brass", 5.0),
        _spacer("shoulder_washer", d.shaft.washer, "stainless-1.4305", 3.0),
        *_stock(),
        *_panel(d),
        *_leads(d),
    ]
    if d.capstan is not None:
        stated.append(ExpectedMake("crimp_sleeve", "brass", False, to_drawing=True))
        for piece in CABLE_PIECES:
            of = "capstan_cable" if piece else ""
            number, order = f"capstan_cable{piece}", _order(d.cable)
            stated.append(ExpectedMake(number, "stainless-1.4305", False, *order, piece_of=of, fill=ROPE_FILL))
    if (row := d.preload) is not None:
        ring = pi / 4 * ((row.housing_mm - 0.3) ** 2 - row.inner_mm**2)
        stated.append(_bought("wave_spring", row, "spring-strip", ring * row.thickness_mm * SPRING_STEEL_G_MM3))
    return tuple(stated)


def _bought(number: str, row: CatalogueRow, material: str, mass_g: float | None) -> ExpectedMake:
    drawn = number in ("rod_spring", "wave_spring") or row.id.startswith("mt68")
    return ExpectedMake(number, material, False, *_order(row), mass_g=mass_g, to_drawing=drawn)


def _spacer(number: str, row: catalogue.Spacer | None, material: str, length_mm: float) -> ExpectedMake:
    """A spacer of the catalogue and its length, or one that is turned."""
    order = () if row is None else _order(row, f" x {length_mm:g}")
    return ExpectedMake(number, material, row is None, *order)


def _order(row: CatalogueRow, size: str = "") -> tuple[str, str]:
    """Order code and standard of a row."""
    order = ordered(row, size)
    return order.get("order_code", ""), order.get("standard", "")


def _stock() -> list[ExpectedMake]:
    """Screws, set screws and dowels in all lengths that are in stock."""
    found = []
    for prefix, family, material in (
        ("screw_", catalogue.screw, "stainless-1.4305"),
        ("screw_", catalogue.low_screw, "stainless-1.4305"),
        ("set_screw_", catalogue.set_screw, "stainless-1.4305"),
        ("dowel_", catalogue.dowel, "steel"),
    ):
        for key, row in family.rows.items():
            for length in row.lengths_mm:
                found.append(ExpectedMake(f"{prefix}{key}x{length:g}", material, False, *_order(row, f" x {length:g}")))
    pulls = catalogue.screw(TENSION_SCREW)
    for length in pulls.lengths_mm:
        number = f"tension_screw_{TENSION_SCREW}x{length:g}"
        found.append(ExpectedMake(number, "stainless-1.4305", False, *_order(pulls, f" x {length:g}")))
    return found


def _panel(d: Dimensions) -> list[ExpectedMake]:
    stated = [ExpectedMake("mount_sleeve", "aluminium-6082", True), ExpectedMake("bench_plate", "steel-s235", True)]
    pad = pi / 4 * 30.0**2 * 6.0 * 1.15e-3
    stated.append(ExpectedMake("bench_pad", "rubber", False, PAD_CODE, mass_g=pad))
    if (p := d.panel) is not None:
        stated += [ExpectedMake("panel", "aluminium-6082", True), ExpectedMake("bezel", "pom-c", True)]
        stated.append(ExpectedMake("boot", "rubber", False, BOOT_CODE, mass_g=p.boot_g - p.carried_g))
        stated.append(ExpectedMake("boot_collar", "rubber", False, BOOT_CODE, piece_of="boot", mass_g=p.carried_g))
    return stated


def _leads(d: Dimensions) -> list[ExpectedMake]:
    weights = {one.number: (LEAD_G_M if one.number == "motor_lead" else SENSOR_G_M) * one.length_mm for one in d.leads}
    masses = {number: mass / 1000.0 for number, mass in weights.items()}
    if d.sensor_lead is not None:
        masses |= {SENSOR: SENSOR_G_M * d.sensor_lead.length_mm / 1000.0, CLIP: CLIP_G}
    stuff = {CLIP: "pa12"}
    return [ExpectedMake(n, stuff.get(n, "rubber"), False, CODES[n], mass_g=mass) for n, mass in masses.items()]
