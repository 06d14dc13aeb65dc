"""The leads of the motors, drawn as far as they bend: placed, with contact, count, order and mass."""

from __future__ import annotations

from math import pi

import cadquery as cq

from delta_cad.assembly.bench import UPRIGHT, Bench, at
from delta_cad.assembly.order.record import Bring, Step
from delta_cad.common.units import MM_PER_M
from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.installation.leads import LEAD_G_M, PLUG_MM, TAIL_MM, LeadDimensions
from delta_cad.mechanism.placement import CHAINS, chain_frame
from delta_cad.solids.materials import material
from delta_cad.solids.part import Contact, Make, Part, Stated
from delta_cad.solids.primitive import feature, one_solid, swept_round

NUMBER = "motor_lead"
CODE = "silicone lead 0.5 mm2, 2.3"
SOURCE = "common stock size; verified: no, from memory, check before ordering"
SHARE = 0.9  # of the lead's end, on the motor's back
SEATED_MM = 0.02  # along a normal


def place_leads(bench: Bench, i: int) -> None:
    """Places the leads behind a motor, where the design draws them."""
    d = bench.d
    if d.leads is None:
        return
    leads = d.leads
    part = bench.once(NUMBER, lambda: _make_lead(leads))
    u, z = d.bracket.motor_axis_mm
    back = d.layers.motor_cheek_mm[1] + d.motor.length_mm
    for name, x in zip(lead_names(d, i), leads.across_mm, strict=True):
        bench.put(name, part, "base", chain_frame(i) @ at(u, back, z) @ UPRIGHT @ at(x))


def lead_names(d: Dimensions, i: int) -> tuple[str, ...]:
    """Names the leads of a motor; none where the design draws none."""
    return () if d.leads is None else tuple(f"{NUMBER}_{i}_{k}" for k in range(len(d.leads.across_mm)))


def _make_lead(leads: LeadDimensions) -> Part:
    """A lead: from the motor's back at the origin along +y, then to -z, which is inwards in the machine."""
    bend, middle = leads.bend_mm, leads.bend_mm / 2**0.5
    start, turn = (0.0, 0.0, 0.0), (0.0, PLUG_MM, 0.0)
    top, low = (0.0, PLUG_MM + middle, middle - bend), (0.0, PLUG_MM + bend, -bend)
    pieces = ((start, turn), (turn, top, low), (low, (0.0, PLUG_MM + bend, -bend - TAIL_MM)))
    shape: cq.Shape = feature(NUMBER, "bend", "hardware.leads", lambda: swept_round(pieces, leads.diameter_mm))
    half = leads.diameter_mm / 2.0
    extent = (-half, half), (0.0, leads.behind_mm), (-bend - TAIL_MM, half)
    text = f"lead of a motor, drawn for {leads.length_mm:.0f} mm; bent by {bend:g} or more"
    solid, mass = one_solid(shape, NUMBER), _mass_g(leads)
    return Part(
        NUMBER, text, solid, material("rubber"), False, (), mass, extent_mm=extent, order_code=CODE, source=SOURCE
    )


def _mass_g(leads: LeadDimensions) -> float:
    return LEAD_G_M * leads.length_mm / MM_PER_M


def lead_contacts(d: Dimensions) -> tuple[Contact, ...]:
    """Declares that each lead's end is on the back of its motor."""
    if d.leads is None:
        return ()
    area = SHARE * pi / 4.0 * d.leads.diameter_mm**2
    return tuple(
        Contact(name, f"motor_{i}", "plane", area, SEATED_MM, "lead on the motor's terminal")
        for i in CHAINS
        for name in lead_names(d, i)
    )


def lead_statement(d: Dimensions, i: int) -> list[Stated]:
    """States the leads of a motor, with their count and link."""
    if d.leads is None:
        return []
    return [Stated(f"drive_{i}", f"{NUMBER}_{i}_?", len(d.leads.across_mm), NUMBER, "base")]


def lead_makes(d: Dimensions) -> list[Make]:
    """States material, order and mass of a lead."""
    return [] if d.leads is None else [Make(NUMBER, "rubber", False, CODE, mass_g=_mass_g(d.leads))]


def lead_steps(d: Dimensions) -> list[Step]:
    """States how the leads come on the motors; nothing where none are drawn."""
    if d.leads is None:
        return []
    words = (
        "Plug or solder the leads on the motors' terminals, each joint under a sleeve.",
        "Bend them towards the middle of the machine, by a radius of "
        f"{d.leads.bend_mm - d.leads.diameter_mm / 2.0:g} mm or more inside: they stand out by "
        f"{d.leads.behind_mm:.1f} mm, which the outline counts. Tie them to the bracket.",
    )
    brought = Bring(tuple(name for i in CHAINS for name in lead_names(d, i)), is_laid=True)
    return [Step("Leads", words, (brought,), checks=("No lead touches what moves.",))]
