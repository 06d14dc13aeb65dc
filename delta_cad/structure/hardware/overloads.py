"""Overloaded parts and joints in closed form, with the lower bound of the moving mass."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields

import numpy as np

from delta_cad.common.units import MM_PER_M
from delta_cad.design import Design
from delta_cad.dimensions import Dimensions, Reason
from delta_cad.dimensions.rules import ARM, RATIO, SECTOR, WIDTH, another, larger, smaller
from delta_cad.drive import drive_torque
from delta_cad.structure.beam_model import beam_model
from delta_cad.structure.hardware.mass_lower_bound import mass_lower_bound
from delta_cad.structure.loads import Load, PartLoads, loads, part_loads, sampled_mm
from delta_cad.structure.strength import allowables

FORCE, _PEAK_FORCE = "requirements.force_N", "requirements.peak_force_N"
_TORQUE, _PEAK_TORQUE = "requirements.joint_torque_N_m", "requirements.peak_torque_N_m"
_TENSIONED = ("cable's slip",)  # what a higher tension of the cable holds
_SIZED = {  # load -> the part of the hardware that bears it
    "rod buckling": "tube",
    "rod end bending": "tube",
    "stud": "ball_diameter_mm",
    "motor shaft": "motor",
    "cable": "cable",
    "shoulder bearing": "bearing",
    "shoulder bearing life": "bearing",
}


def overloads(d: Dimensions, weighed: float = 1.0) -> list[Reason]:
    """Gives every reason why parts may not bear what they must, for both forces, or joints not hold force and weight.

    Args:
        d: The machine.
        weighed: How many times what moves at least is taken to weigh; 0: nothing weighs anything.
    """
    required, positions = d.design.requirements, sampled_mm(d.design.workspace)
    table, limits, what = beam_model(d), allowables(d), mass_lower_bound(d)
    pushed = part_loads(table, what, positions, 1.0, np.zeros(3))
    below_elbows = part_loads(table, what, positions, 0.0, np.array(required.gravity_m_s2))

    def given(force: float) -> PartLoads:  # every one is `|g| F + |w|`
        each = ((f.name, getattr(pushed, f.name), getattr(below_elbows, f.name)) for f in fields(PartLoads))
        return PartLoads(**{name: force * unit + weighed * weight for name, unit, weight in each})

    found: dict[str, Reason] = {}
    forces = {"force_N": required.force_N, "peak_force_N": required.peak_force_N}
    for field, force in forces.items():
        if force is None:
            continue
        between = given(required.force_N) if field == "peak_force_N" else None
        for load in loads(table, limits, positions, given(force), between):
            if load.holds or (load.least and field == "peak_force_N"):  # of what lasts, see `structure_report`
                continue
            found[load.name] = _overloaded(d, load, f"requirements.{field}")
    if not weighed:  # who knows no weight learns of the torque elsewhere
        return list(found.values())
    return [*found.values(), *_torque(d.design, pushed.torque / MM_PER_M, below_elbows.torque / MM_PER_M, weighed)]


def gravity_share_N_m(d: Dimensions) -> float:
    """Estimates from below the gravity torque of a joint in addition to the continuous force, N m.

    Args:
        d: The machine.
    """
    required, positions = d.design.requirements, sampled_mm(d.design.workspace)
    table, what = beam_model(d), mass_lower_bound(d)
    alone, both = (
        float(part_loads(table, what, positions, required.force_N, gravity).torque.max())
        for gravity in (np.zeros(3), np.array(required.gravity_m_s2))
    )
    return (both - alone) / MM_PER_M


def _torque(design: Design, pushed: np.ndarray, below_elbows: np.ndarray, weighed: float) -> Iterator[Reason]:
    """Force in the worst direction and weight over the torque that a joint is to give continuously.

    Args:
        design: The design.
        pushed: (n, 3 chains) torque for a force of 1 N, N m.
        below_elbows: The same for the least weight, N m.
        weighed: How many times that weight.
    """
    force, held = design.requirements.force_N, design.requirements.joint_torque_N_m
    if (most := float((force * pushed + weighed * below_elbows).max())) <= held:
        return
    message = (
        f"{force:g} N in the worst direction take {force * float(pushed.max()):.3g} N m, the weight "
        f"{float(below_elbows.max()):.3g} at least, both at once {most:.3g}; at most {held:g}"
    )
    given = (larger(_TORQUE),) if most <= drive_torque(design).continuous_torque_N_m else ()  # else the drive lacks it
    yield Reason("drive", "torque with gravity", message, (*given, smaller(ARM), smaller(FORCE)))


def _overloaded(d: Dimensions, load: Load, field: str) -> Reason:
    """Gives the overloaded parts, and the fields that may be changed.

    Args:
        d: The design's dimensions.
        load: What a part may not bear.
        field: Field of the force that makes it.
    """
    required, part = d.design.requirements, _SIZED.get(load.name)
    weaker = (smaller(field),) if field == FORCE else (smaller(field), smaller(_PEAK_FORCE, FORCE))
    if load.name in _TENSIONED:
        drive = drive_torque(d.design)
        tensioned = larger(_PEAK_TORQUE if required.peak_torque_N_m is not None else _TORQUE)
        weak = drive.peak_torque_N_m < drive.required_peak_N_m
        ways = (larger(RATIO), tensioned) if weak else (tensioned, larger(RATIO))
    elif part == "motor":
        wheels = (larger(SECTOR), larger(SECTOR, RATIO)) if d.capstan is not None else ()
        ways = *wheels, *another(part)
    elif part is not None:
        ways = another(part)
    else:
        ways = *weaker, larger(WIDTH), smaller(WIDTH), *another("ball_diameter_mm")
    message = f"{load.value:.4g} {load.unit}, {'at least' if load.least else 'at most'} {load.limit:.4g}"
    return Reason(load.name, "load", message, tuple(dict.fromkeys((*ways, *weaker))), load.margin)
