"""What parts may not bear and joints not hold, in closed form: with the weight of what moves at least."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields
from typing import Any

import numpy as np
from scipy.optimize import brentq

from delta_cad import catalogue
from delta_cad.common.units import MM_PER_M
from delta_cad.design import Design
from delta_cad.design.record import CAPSTAN_RATIO_MOST, SECTOR_MOST_MM
from delta_cad.dimensions import Dimensions, Reason
from delta_cad.dimensions.capstan import widest_pinion_mm
from delta_cad.dimensions.joint import PRELOAD_N, PRELOAD_PER_N
from delta_cad.dimensions.rules import ARM, RATIO, SECTOR, WIDTH, Way, another, larger, smaller
from delta_cad.drive import drive_torque
from delta_cad.structure.hardware.lightest import lightest
from delta_cad.structure.holds import holds
from delta_cad.structure.loads import Borne, Load, borne, loads, sampled_mm
from delta_cad.structure.table import structure_table

SHARE = 5e-5  # of a force, to which what a part bears is found
FAR = 1e9  # in any load's unit: no number beyond is looked at
FORCE, PEAK_FORCE = "requirements.force_N", "requirements.peak_force_N"
TORQUE, PEAK_TORQUE = "requirements.joint_torque_N_m", "requirements.peak_torque_N_m"
TENSIONED = "cable's slack strand", "cable's slip"  # what a higher tension of the cable holds
SPRUNG = "ball joint", "ball joint preload", "cup shell", "rod end bending", "rod bond, tilt"  # what springs make
SIZED = {  # load -> the part of the hardware that bears it
    "rod buckling": "tube",
    "rod end bending": "tube",
    "stud": "ball_diameter_mm",
    "motor shaft": "motor",
    "cable": "cable",
    "shoulder bearing": "bearing",
    "shoulder bearing life": "bearing",
}


def overloads(d: Dimensions, weighed: float = 1.0, estimated: bool = False) -> list[Reason]:
    """Gives every reason why parts may not bear what they must, for both forces, or joints not hold force and weight.

    Args:
        d: The machine.
        weighed: How many times what moves at least is taken to weigh; 0: nothing weighs anything.
        estimated: Whether reasons carry a search's estimates of what is enough.
    """
    required, cube = d.design.requirements, d.design.cube
    positions = sampled_mm(cube.bottom_height_mm, cube.half_side_mm)
    table, limits, what = structure_table(d), holds(d), lightest(d)
    pushed = borne(table, what, positions, 1.0, np.zeros(3))
    hanging = borne(table, what, positions, 0.0, np.array(required.gravity_m_s2))

    def given(force: float, at: slice = slice(None)) -> Borne:  # every one is `|g| F + |w|`
        each = ((f.name, getattr(pushed, f.name)[at], getattr(hanging, f.name)[at]) for f in fields(Borne))
        return Borne(**{name: force * unit + weighed * weight for name, unit, weight in each})

    def bears(load: Load, force: float) -> float:
        """Force that a part bears where it bears least, with the weight; 0 where that is none."""
        k = int(np.argmin(np.linalg.norm(positions - np.array(load.position_mm), axis=1)))
        at = slice(k, k + 1)

        def over(force: float) -> float:
            now = next(x for x in loads(table, limits, positions[at], given(force, at)) if x.name == load.name)
            return float(np.clip((now.limit - now.value if now.least else now.value - now.limit), -FAR, FAR))

        if over(0.0) > 0.0:
            return 0.0
        root: Any = brentq(over, 0.0, force, xtol=SHARE * force)
        return max(float(root) - SHARE * force, 0.0)

    found: dict[str, Reason] = {}
    forces = {"force_N": required.force_N, "peak_force_N": required.peak_force_N}
    for field, force in forces.items():
        if force is None:
            continue
        now = given(force)
        for load in loads(table, limits, positions, now):
            if load.holds or (load.least and field == "peak_force_N"):  # of what lasts, see `structure_report`
                continue
            force_field, able = f"requirements.{field}", bears(load, force) if estimated else 0.0
            found[load.name] = _overloaded(d, load, force_field, force, able, estimated)
    if not weighed:  # who knows no weight learns of the torque elsewhere
        return list(found.values())
    return [*found.values(), *_torque(d.design, pushed.torque / MM_PER_M, hanging.torque / MM_PER_M, weighed)]


def gravity_share_N_m(d: Dimensions) -> float:
    """Estimates, rather too low, what the weight of what moves takes of a joint beside the lasting force, N m.

    Args:
        d: The machine.
    """
    required, cube = d.design.requirements, d.design.cube
    positions = sampled_mm(cube.bottom_height_mm, cube.half_side_mm)
    table, what = structure_table(d), lightest(d)
    alone, both = (
        float(borne(table, what, positions, required.force_N, gravity).torque.max())
        for gravity in (np.zeros(3), np.array(required.gravity_m_s2))
    )
    return (both - alone) / MM_PER_M


def _torque(design: Design, pushed: np.ndarray, hanging: np.ndarray, weighed: float) -> Iterator[Reason]:
    """Force in the worst direction and weight over the torque that a joint is to give continuously.

    Args:
        design: The design.
        pushed: (n, 3 chains) torque for a force of 1 N, N m.
        hanging: The same for the least weight, N m.
        weighed: How many times that weight.
    """
    force, held = design.requirements.force_N, design.requirements.joint_torque_N_m
    if (most := float((force * pushed + weighed * hanging).max())) <= held:
        return
    message = (
        f"{force:g} N in the worst direction take {force * float(pushed.max()):.3g} N m, the weight "
        f"{float(hanging.max()):.3g} at least, both at once {most:.3g}; at most {held:g}"
    )
    yield Reason(
        "drive", "torque with gravity", message, TORQUE, held, ways=(smaller(ARM), larger(TORQUE), smaller(FORCE))
    )


def _overloaded(d: Dimensions, load: Load, field: str, force: float, able: float, estimated: bool) -> Reason:
    """Says what bears too much, and what may be changed.

    Args:
        d: The design's dimensions.
        load: What a part may not bear.
        field: Field of the force that makes it.
        force: That force, N.
        able: Estimate of the force that the part bears, N; 0: none.
        estimated: Whether estimates are wanted.
    """
    message = f"{load.value:.4g} {load.unit}, {'at least' if load.least else 'at most'} {load.limit:.4g}"
    weaker, hardware = smaller(field), d.design.hardware

    def reason(field: str, value: float | str, bound: float | None, *ways: Way) -> Reason:
        forces = (weaker,) if field == FORCE else (weaker, smaller(PEAK_FORCE, FORCE))
        return Reason(load.name, "load", message, field, value, bound if estimated else None, ways=(*ways, *forces))

    if load.name in TENSIONED:
        drive = drive_torque(d.design)
        tensioned = larger(PEAK_TORQUE if d.design.requirements.peak_torque_N_m is not None else TORQUE)
        weak = drive.peak_torque_N_m < drive.required_peak_N_m
        held = (RATIO, hardware.capstan_ratio) if weak else (PEAK_TORQUE, drive.required_peak_N_m)
        return reason(*held, None, larger(RATIO), tensioned)
    part = SIZED.get(load.name)
    if part == "ball_diameter_mm":
        needed = d.forearm.ball_diameter_mm * (1.0 / load.margin) ** (1.0 / 3.0)
        sizes = sorted({row.diameter_mm for row in catalogue.ball.rows.values() if row.diameter_mm >= needed})
        bound = next(iter(sizes), needed)
        return reason(f"hardware.{part}", hardware.ball_diameter_mm, bound, *another(part))
    if part == "motor":
        wider = hardware.sector_radius_mm / load.margin  # the same torque on a larger pinion pulls less
        if d.capstan is None or wider > SECTOR_MOST_MM or _ratio(d, wider) > CAPSTAN_RATIO_MOST:
            return reason(field, force, able or None, *another(part))
        return reason(SECTOR, hardware.sector_radius_mm, wider, larger(SECTOR), larger(SECTOR, RATIO), *another(part))
    if part is not None:
        return reason(f"hardware.{part}", getattr(hardware, part), None, *another(part))
    if estimated and not able and load.name in SPRUNG:  # springs for a smaller force are weaker by so much at least
        share = max(load.margin, 0.0)
        able = min(d.forearm.joint.spring_N * share / (PRELOAD_N[1] / PRELOAD_N[0] * PRELOAD_PER_N), force * share)
        able = able if PRELOAD_PER_N * able >= PRELOAD_N[0] else 0.0  # there are none
    return reason(field, force, able or None, larger(WIDTH), smaller(WIDTH), *another("ball_diameter_mm"))


def _ratio(d: Dimensions, sector_mm: float) -> float:
    """The ratio with which a larger sector's pinion passes the motor's screws."""
    return sector_mm / widest_pinion_mm(d.motor, d.cable.diameter_mm)
