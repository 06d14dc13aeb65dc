"""The leads of motors and sensors: placed, with contact and order."""

from __future__ import annotations

from math import pi

from delta_cad.assembly.bench import UPRIGHT, Bench, at
from delta_cad.assembly.order.record import Bring, Leg, Step
from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.installation.leads import (
    CLIP_MM,
    PLUGGED_MM,
    SENSOR_MM,
    STRAIGHT_MM,
    TIE_MM,
    LeadDimensions,
)
from delta_cad.mechanism.placement import CHAINS, chain_frame
from delta_cad.solids.leads import CLIP, SENSOR, make_lead, make_lead_clip, make_sensor_lead
from delta_cad.solids.part import Contact

SHARE = 0.9  # of the lead's end, on the motor's back; of a plug's face, of a tie's base
SEATED_MM = 0.02  # along a normal


def place_leads(bench: Bench, i: int) -> None:
    """Places the leads of a chain's motor and board, where the design draws them."""
    d, b = bench.d, bench.d.bracket
    u, z = b.motor_axis_mm
    back = d.layers.motor_cheek_mm[1] + d.motor.length_mm
    for leads in d.leads:
        part = bench.once(leads.number, lambda leads=leads: make_lead(leads))
        for name, x in zip(_names(leads, i), leads.across_mm, strict=True):
            bench.put(name, part, "base", chain_frame(i) @ at(u, back, z) @ UPRIGHT @ at(x))
    if (s := d.sensor_lead) is not None:
        shoulder = chain_frame(i) @ at(b.shoulder_u_mm)
        bench.put(f"{SENSOR}_{i}", bench.once(SENSOR, lambda: make_sensor_lead(s)), "base", shoulder @ at(*s.plug_mm))
        seat = at(s.plug_mm[0] + s.way_mm[0], s.leg_y_mm, s.clip_z_mm)
        bench.put(f"{CLIP}_{i}", bench.once(CLIP, make_lead_clip), "base", shoulder @ seat)


def _names(leads: LeadDimensions, i: int) -> tuple[str, ...]:
    return tuple(f"{leads.number}_{i}_{k}" for k in range(len(leads.across_mm)))


def lead_names(d: Dimensions, i: int) -> tuple[str, ...]:
    """Names the leads of a motor; none where the design draws none."""
    return tuple(name for leads in d.leads for name in _names(leads, i))


def lead_contacts(d: Dimensions) -> tuple[Contact, ...]:
    """Declares that each lead's end is on its motor's back or in its board, and tied to the leg."""
    found = [
        Contact(name, f"motor_{i}", "plane", SHARE * pi / 4.0 * leads.diameter_mm**2, SEATED_MM, "lead on its motor")
        for i in CHAINS
        for leads in d.leads
        for name in _names(leads, i)
    ]
    if d.sensor_lead is None:
        return tuple(found)
    plug, base = SHARE * PLUGGED_MM[0] * PLUGGED_MM[1], SHARE * CLIP_MM[0] ** 2
    for i in CHAINS:
        lead, clip = f"{SENSOR}_{i}", f"{CLIP}_{i}"
        found += [
            Contact(lead, f"encoder_board_{i}", "plane", plug, SEATED_MM, "plug in the board's header"),
            Contact(clip, f"encoder_cheek_{i}", "plane", base, SEATED_MM, "tie's base on the leg"),
            Contact(lead, clip, "cylinder", SHARE * TIE_MM[0], SEATED_MM, "lead in its tie"),
        ]
    return tuple(found)


def lead_steps(d: Dimensions) -> list[Step]:
    """States how the leads come on the motors; nothing where none are drawn."""
    if not d.leads:
        return []
    furthest = max(d.leads, key=lambda leads: leads.behind_mm)
    words = (
        "Plug or solder the leads on the motors' terminals, each joint under a sleeve.",
        "Bend them towards the middle of the machine, by a radius of "
        f"{furthest.bend_mm - furthest.diameter_mm / 2.0:g} mm or more inside: they stand out by "
        f"{furthest.behind_mm:.1f} mm, which the outline counts. Tie them to the bracket.",
        *(("The boards' leads go with them over the plate's edge.",) if d.sensor_lead is not None else ()),
    )
    brought = Bring(tuple(name for i in CHAINS for name in lead_names(d, i)), is_laid=True)
    return [Step("Leads", words, (brought,), checks=("No lead touches what moves.",))]


def sensor_lead_steps(d: Dimensions, i: int) -> list[Step]:
    """States how a board's lead comes on its drive, while no neighbour's motor is before the leg."""
    if (s := d.sensor_lead) is None:
        return []
    low = -s.clip_z_mm - d.encoder.board_length_mm / 2.0
    words = (
        f"Degrease the outer face of the encoder's leg and press the tie's base on it, its middle {low:.0f} mm below "
        f"the board's lower edge and {s.way_mm[0]:.0f} mm further out than the board's middle.",
        f"Push the plug into the board, let the lead go straight for {STRAIGHT_MM:g} mm, bend it by "
        f"{s.bend_mm - SENSOR_MM / 2.0:g} mm or more inside on to the leg, and tie it. From there it hangs down it.",
    )
    glued = Bring((f"{CLIP}_{i}",), (Leg((0.0, 1.0, 0.0)),), f"encoder_cheek_{i}")
    brings = (glued, Bring((f"{SENSOR}_{i}",), is_laid=True))
    checks = ("Pulled below the tie, the lead does not pull at its plug.",)
    return [Step("The encoder's lead", words, brings, tools=("degreaser",), checks=checks)]
