"""The leads of motors and sensors placed, each on its motor or in its board, and tied to the leg."""

from __future__ import annotations

from math import pi

from delta_cad.assembly.builder import IN, SEATED_MM, UPRIGHT, AssemblyBuilder, Connection, at
from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.leads import CLIP_MM, PLUGGED_MM, TIE_MM
from delta_cad.solids.leads import CLIP, SENSOR, make_lead, make_lead_clip, make_sensor_lead

SHARE = 0.9  # of the lead's end, on the motor's back; of a plug's face, of a tie's base


def lead_names(d: Dimensions, i: int) -> tuple[str, ...]:
    """Names the leads of a motor; none where the design draws none."""
    return tuple(f"{leads.number}_{i}_{k}" for leads in d.leads for k in range(len(leads.across_mm)))


def place_leads(builder: AssemblyBuilder, i: int) -> None:
    """Places the leads of a chain's motor and board, where the design draws them."""
    d, b = builder.d, builder.d.bracket
    u, z = b.motor_axis_mm
    back = d.layers.motor_face_mm + d.motor.length_mm
    for leads in d.leads:
        part = builder.once(leads.number, make_lead, leads)
        on = _flat(f"motor_{i}", pi / 4.0 * leads.diameter_mm**2, "lead on its motor")
        for k, x in enumerate(leads.across_mm):
            placed = d.stand(i) @ at(u - leads.inside_mm, back, z) @ UPRIGHT @ at(x)
            builder.put(f"{leads.number}_{i}_{k}", part, "base", placed, on)
    if (s := d.sensor_lead) is not None:
        shoulder, cheek, clip = d.stand(i) @ at(b.shoulder_u_mm), f"encoder_cheek_{i}", f"{CLIP}_{i}"
        part = builder.once(SENSOR, make_sensor_lead, s)
        plug = _flat(f"encoder_board_{i}", PLUGGED_MM[0] * PLUGGED_MM[1], "plug in the board's header")
        tied = Connection(clip, "lead in its tie", "cylinder", SHARE * TIE_MM[0], SEATED_MM)
        builder.put(f"{SENSOR}_{i}", part, "base", shoulder @ at(*s.plug_mm), plug, tied)
        seat = shoulder @ at(s.plug_mm[0] + s.way_mm[0], s.leg_y_mm, s.clip_z_mm)
        on = _flat(cheek, CLIP_MM[0] ** 2, "tie's base on the leg")
        builder.put(clip, builder.once(CLIP, make_lead_clip), "base", seat, on, path=IN, frame=cheek)


def _flat(to: str, area_mm2: float, reason: str) -> Connection:
    return Connection(to, reason, "plane", SHARE * area_mm2, SEATED_MM)
