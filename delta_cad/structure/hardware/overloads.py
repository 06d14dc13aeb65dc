"""What parts may not bear and joints not hold, in closed form: with the weight of what moves at least."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import fields
from math import tanh
from typing import Any

import numpy as np
from scipy.optimize import brentq

from delta_cad import catalogue
from delta_cad.common.units import MM_PER_M
from delta_cad.design import Design
from delta_cad.design.record import CAPSTAN_RATIO_MOST, SECTOR_MOST_MM
from delta_cad.dimensions import Dimensions, Reason
from delta_cad.dimensions.cable.run import FRICTION
from delta_cad.dimensions.capstan import ROPE_FACTOR, widest_pinion_mm
from delta_cad.dimensions.forearm import TUBE_GLUE_MM
from delta_cad.dimensions.joint import PRELOAD_N, PRELOAD_PER_N
from delta_cad.dimensions.rules import down, up
from delta_cad.drive import drive_torque
from delta_cad.drive.report import SLACK_N
from delta_cad.structure.hardware.lightest import lightest
from delta_cad.structure.hardware.would_do import HEAVIER, named, one, rows
from delta_cad.structure.holds import holds
from delta_cad.structure.loads import Borne, Load, borne, loads, sampled_mm
from delta_cad.structure.table import structure_table

SHARE = 5e-5  # of a force that is told with three digits
FAR = 1e9  # in any load's unit: no number beyond is told
TORQUE = "requirements.joint_torque_N_m"
AGAIN = 1.04  # times that is told, lest what else changes asks for it once more
SLACK, SLIP = "cable's slack strand", "cable's slip"
TENSIONED = SLACK, SLIP  # what a higher tension of the cable holds
SPRUNG = "ball joint", "ball joint preload", "cup shell", "rod end bending", "rod bond, tilt"  # what springs make
# Load -> the field of the design that sizes its part, and what of its row counts.
SIZED: dict[str, tuple[str, str]] = {
    "rod buckling": ("hardware.tube", "of a bending stiffness"),
    "rod end bending": ("hardware.tube", "of an inside diameter"),
    "stud": ("hardware.ball_diameter_mm", ""),
    "motor shaft": ("hardware.motor", "whose shaft may bear across"),
    "cable": ("hardware.cable", "of a breaking load"),
    "shoulder bearing": ("hardware.bearing", "of a static load"),
    "shoulder bearing life": ("hardware.bearing", "of a dynamic load"),
}


def overloads(d: Dimensions, weighed: float = 1.0) -> list[Reason]:
    """Gives every reason why parts may not bear what they must, for both forces, or joints not hold force and weight.

    Args:
        d: The machine.
        weighed: How many times what moves at least is taken to weigh; 0: nothing weighs anything.
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
            half = float(now.cable.max()) / 2.0
            found[load.name] = _overloaded(d, load, (f"requirements.{field}", force, bears(load, force)), half)
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
    """Force in the worst direction and weight over the torque that a joint is asked to give for ever.

    Args:
        design: The design.
        pushed: (n, 3 chains) torque for a force of 1 N, N m.
        hanging: The same for the least weight, N m.
        weighed: How many times that weight.
    """
    force, held, field = design.requirements.force_N, design.requirements.joint_torque_N_m, TORQUE
    if float((force * pushed + weighed * hanging).max()) <= held:
        return
    more = HEAVIER * AGAIN
    needed = float((force * pushed + more * hanging).max())
    bears = float(((held - more * hanging) / pushed).min())
    less = f", or requirements.force_N = {force:g} at most {down(bears, 3)} N" if bears > 0.0 else ""
    told = (
        f"{field} = {held:g} must be at least {up(needed)} N m{less}: {force:g} N in the worst direction takes "
        f"{force * float(pushed.max()):.3g} N m, the weight {float(hanging.max()):.3g} at least"
    )
    instead = ("requirements.force_N", bears) if bears > 0.0 else None
    yield Reason("drive", "torque with gravity", told, field, held, needed, instead=instead)


def _overloaded(d: Dimensions, load: Load, force: tuple[str, float, float], half_N: float) -> Reason:
    """Says which field is to change for a load.

    Args:
        d: The design's dimensions.
        load: What a part may not bear.
        force: Field of the force that makes it, the force, and the one that the part would bear, N.
        half_N: Half the largest difference between the cable's strands.
    """
    told = f"{load.value:.4g} {load.unit}, {'at least' if load.least else 'at most'} {load.limit:.4g}"
    less = f"{force[0]} = {force[1]:g} at most {down(force[2], 3)} N"
    if force[2] == 0.0 and load.name not in SPRUNG:
        less = "a lighter machine, whose weight alone is more than that"
    elif force[2] == 0.0:  # the springs alone are too strong: those for a smaller force are weaker by so much at least
        share = max(load.margin, 0.0)
        weaker = d.forearm.joint.spring_N * share / (PRELOAD_N[1] / PRELOAD_N[0] * PRELOAD_PER_N)
        force = *force[:2], min(weaker, force[1] * share)
        less = f"{force[0]} = {force[1]:g} at most {down(force[2], 3)} N, for which weaker springs do"
        if PRELOAD_PER_N * force[2] < PRELOAD_N[0]:  # there are none
            force, less = (*force[:2], 0.0), "another parallelogram_width_mm, whose springs pull less"
    if load.name in TENSIONED:
        return _tensioned(d, load, half_N, told, less)
    field, column = SIZED.get(load.name, ("", ""))
    if not field:
        return Reason(load.name, "load", f"{less}: {told}", force[0], force[1], force[2] or None)
    held, more = getattr(d.design.hardware, field.split(".")[1]), 1.0 / load.margin
    needed, does, size = load.value, list[str](), None
    if load.name == "motor shaft":
        motor = f"hardware.motor = {held} one {column} of at least {up(needed)}"
        sector = d.design.hardware.sector_radius_mm
        wider = sector * more  # the same torque on a larger pinion pulls less
        beside = () if d.capstan is None else _with_ratio(d, wider)
        if d.capstan is None or wider > SECTOR_MOST_MM or any(ratio > CAPSTAN_RATIO_MOST for _, ratio in beside):
            return Reason(load.name, "load", f"{less}: {told}; or {motor}", force[0], force[1], force[2] or None)
        words = "".join(f" with {name} = {d.capstan.ratio:g} at least {up(ratio)}" for name, ratio in beside)
        field = "hardware.sector_radius_mm"
        message = f"{field} = {sector:g} must be at least {up(wider)} mm{words}: {told}; or {motor}; or {less}"
        return Reason(load.name, "load", message, field, sector, wider, beside)
    if load.name == "cable":
        needed = load.value * ROPE_FACTOR
        does = rows("cable", d.design, lambda row: row.breaking_load_N >= needed)
    elif load.name == "shoulder bearing":
        does = rows("bearing", d.design, lambda row: row.static_load_N >= needed and row.bore_mm == d.bearing.bore_mm)
    elif load.name == "shoulder bearing life":
        needed = d.bearing.dynamic_load_N * more ** (1.0 / 3.0)
        does = rows("bearing", d.design, lambda row: row.dynamic_load_N >= needed)
    elif load.name == "stud":
        needed = d.forearm.ball_diameter_mm * more ** (1.0 / 3.0)
        sizes = sorted({row.diameter_mm for row in catalogue.ball.rows.values() if row.diameter_mm >= needed})
        does, size = [f"{v:g} mm" for v in sizes], next(iter(sizes), None)
    elif load.name == "rod end bending":
        needed = d.forearm.spigot_diameter_mm * more ** (1.0 / 3.0) + 2.0 * TUBE_GLUE_MM
        does = rows("tube", d.design, lambda row: row.inner_mm >= needed)
    else:
        needed = d.tube.outer_mm * more ** (1.0 / 4.0)
        column = "of an outside diameter"
        does = rows("tube", d.design, lambda row: row.outer_mm >= needed)
    words = f"{column} of at least {up(needed)}{named(does)}".strip()
    message = f"{field} = {held} must be one {words}: {told}; or {less}"
    beside = () if load.name == "stud" else one(field.split(".")[1], does)
    instead = (force[0], force[2]) if force[2] else None
    return Reason(load.name, "load", message, field, held, size or needed, beside, instead)


def _with_ratio(d: Dimensions, sector_mm: float) -> tuple[tuple[str, float], ...]:
    """Gives the ratio with which a larger sector's pinion passes the motor's screws, or nothing where it does."""
    ratio = sector_mm / widest_pinion_mm(d.motor, d.cable.diameter_mm)
    return (("hardware.capstan_ratio", ratio),) if ratio > d.design.hardware.capstan_ratio else ()


def _tensioned(d: Dimensions, load: Load, half_N: float, told: str, less: str) -> Reason:
    """Says for which torque the cable must be tensioned, or that the drive must give it first.

    Args:
        d: The design's dimensions.
        load: A slack strand that goes loose, or turns that slip.
        half_N: Half the difference between the strands.
        told: The load beside its limit, in words.
        less: The force that the cable would bear, in words.
    """
    drive, hardware = drive_torque(d.design), d.design.hardware
    assert d.capstan is not None
    # Euler: T + D / 2 = (T - D / 2) e^(friction wrap)
    factor = 1.0 if load.name == SLACK else 1.0 / tanh(FRICTION * d.capstan.run.wrap_rad / 2.0)
    torque = 2.0 * (factor * half_N - SLACK_N) * drive.efficiency * hardware.sector_radius_mm / MM_PER_M
    if drive.peak_torque_N_m < min(torque, drive.required_peak_N_m):
        field, held = "hardware.capstan_ratio", hardware.capstan_ratio
        torque = max(torque, drive.required_peak_N_m)
        bound = held * torque / drive.peak_torque_N_m
        message = f"{field} = {held:g} must be at least {up(bound)}, for a peak of {up(torque)} N m"
    else:
        field, held, bound = "requirements.peak_torque_N_m", drive.required_peak_N_m, torque
        message = f"{field} = {held:g} must be at least {up(torque)} N m"
    return Reason(
        load.name, "load", f"{message}, which the cable is tensioned for: {told}; or {less}", field, held, bound
    )
