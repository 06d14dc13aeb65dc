"""Cost rates of machine hours, material and cuts, each with its source.

All are estimates in EUR without tax, for ordering of magnitude and for comparing designs; change them here.
"""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

CURRENCY = "EUR"
BATCHES = (1, 10, 100)
"""Machines made at once."""
_SHOP = "myshopmetrics.com/resources/cost-estimation: material + (setup + cycle) x rate + tools; 75 to 150 USD an hour "
_SHOP += "for standard work, 15 to 60 min a set-up in a vice or chuck, 15 to 30 % of a cycle without cutting"
_BEAM = "flowwaterjetblog.com/2015/03/20 (shops charge 125 to 150 USD an hour for a jet), my.wardjet.com/waterjet/"
_BEAM += "university/nozzle-orifice (18 mm a minute through 101.6 mm of aluminium at the finest quality: 1830 mm^2), "
_BEAM += "fliphtml5.com/osspz/trhw, p. 117 (a laser is faster), with 20 min to study and nest, 6 s to pierce"
ESTIMATE = "estimate"


@dataclass(frozen=True)
class Rates:
    """A shop.

    Attributes:
        hour_EUR: An hour of machine and operator.
        program_min: Programming and drawing's study of a part number, once a batch.
        setup_min: Fixture, zero and first piece of one clamping, once a batch.
        handle_min: Loading and unloading a piece in one clamping.
        idle_share: Of the cutting time: ways between cuts.
        finish_mm2_min: Area that is finished in a minute.
        drill_min: A drilled hole.
        thread_min: A thread, beside its hole.
        fit_min: A bore to a fit, beside its hole: reamed or bored, and gauged.
        tool_min: A change of tool, of which a piece has one a diameter and one a clamping.
        deburr_min: Breaking the edges of a piece.
        saw_min: Cutting a piece of tube or bar to length.
        erode_min: Eroding a hole into hardened steel.
        anodise_lot_EUR: A lot to be anodised.
        anodise_EUR: A piece of it.
        beam_lot_EUR: Nesting a part number that is cut from sheet by laser or jet.
        beam_EUR_mm2: Of the faces that it cuts.
        pierce_EUR: Each contour.
        allowance_mm: Stock beyond the part, on either side.
    """

    hour_EUR: float = 80.0
    program_min: float = 30.0
    setup_min: float = 20.0
    handle_min: float = 1.0
    idle_share: float = 0.2
    finish_mm2_min: float = 3000.0
    drill_min: float = 0.25
    thread_min: float = 0.4
    fit_min: float = 1.0
    tool_min: float = 0.15
    deburr_min: float = 1.0
    saw_min: float = 1.0
    erode_min: float = 6.0
    anodise_lot_EUR: float = 60.0
    anodise_EUR: float = 0.5
    beam_lot_EUR: float = 40.0
    beam_EUR_mm2: float = 0.0011
    pierce_EUR: float = 0.2
    allowance_mm: float = 1.5

    def record(self) -> dict[str, Any]:
        """Gives all rates as JSON types, with where they come from."""
        return {**asdict(self), "source": f"{ESTIMATE}, within {_SHOP}; laser or jet: {_BEAM}"}


@dataclass(frozen=True)
class Stock:
    """A material as a shop buys and cuts it: EUR per kg, and mm^3 that a rough cut takes in a minute."""

    price_EUR_kg: float
    removal_mm3_min: float


STOCKS = {
    "aluminium-7075": Stock(14.0, 20_000.0),
    "aluminium-6082": Stock(9.0, 20_000.0),
    "stainless-1.4305": Stock(12.0, 4_000.0),
    "brass": Stock(14.0, 15_000.0),
    "pom-c": Stock(12.0, 30_000.0),
    "peek-bearing": Stock(180.0, 15_000.0),
    "steel": Stock(5.0, 5_000.0),
    "steel-s235": Stock(3.0, 6_000.0),
}
"""Id of a material in the catalogue -> how it is bought and cut; prices of small lengths, removal on a small mill."""
PLATES_MM = (5.0, 6.0, 8.0, 10.0, 12.0, 15.0, 20.0)
"""Thicknesses of plate bought with both faces milled, mm; an estimate, at the price by mass of other stock."""
PLATE_MATERIALS = ("aluminium-6082", "aluminium-7075")


@dataclass(frozen=True)
class Print:
    """How a printer makes parts of a process.

    Attributes:
        hour_EUR: An hour of the machine: what it is written off by, power, wear.
        volume_mm3_h: That it prints in an hour, solid.
        prepare_min: Slicing and starting a part number, once a batch.
        handle_min: Taking a piece off and breaking its supports away.
        insert_min: Melting in an insert.
        ream_min: Reaming a bore.
        waste_share: Of the material: supports, purge, prints that fail.
        work_EUR_h: An hour of who does it.
    """

    hour_EUR: float
    volume_mm3_h: float
    prepare_min: float = 5.0
    handle_min: float = 2.0
    insert_min: float = 0.5
    ream_min: float = 1.0
    waste_share: float = 0.15
    work_EUR_h: float = 25.0


PRINTS = {"fdm": Print(0.75, 25_000.0), "sls": Print(12.0, 60_000.0)}
"""Process -> how it prints. Source: 0.75 EUR an hour below 5 h (formlab.schoolofarts.be, how much does FDM printing
cost, read 2026-11-28); 25 cm^3 an hour of a 0.4 mm nozzle, hours of powder and what work takes from memory: check."""
PRINTED_EUR_KG = {"petg-fdm": 25.0, "pla-fdm": 20.0, "pa-cf-fdm": 70.0, "pa12-sls": 90.0}
"""Id of a printed material -> its price; the shop of that page takes 0.032 EUR for a gram of PLA."""
OTHER = Stock(20.0, 5_000.0)
BREAKS = {1: 1.0, 10: 0.9, 100: 0.75}
"""Machines made at once -> share of the single price that bought parts cost then."""


def share_at(machines: int) -> float:
    """Gives the share of their single price at which parts are bought for a number of machines."""
    return next(share for count, share in sorted(BREAKS.items(), reverse=True) if machines >= count)
