"""How long a force may be held: from the torque that gives it everywhere to the motor's winding at its limit.

Importing this module loads numba.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from delta_cad import catalogue
from delta_cad.mechanism import jacobian
from haptics.feel.field import Drive, inscribed_ball
from haptics.gravity import gravity_torque
from haptics.model.machine import MachineModel
from haptics.model.motor_heat import REFERENCE_C, hold_time, motor_heat

STEPS = 5  # Forces from the continuous one to the peak, both ends among them
_FOR_EVER, _UNKNOWN = "for ever", "unknown"
DEFINITION = (
    "all three motors hold the torque that gives the force in every direction everywhere in the cube beside the "
    f"weight, at rest in air of {REFERENCE_C:g} C, until the winding is as hot as its data sheet allows; `taken back` "
    "is when the controller begins to take force away; `warm` begins where the continuous torque was held for ever. "
    "Two bodies, winding and housing, with resistances, time constant and largest temperature of the catalogue's row, "
    "and the housing's heat capacity from its mass (`model/motor_heat.py`)"
)


@dataclass(frozen=True)
class Hold:
    """A force and how long it may be held; times in s, infinite for ever, None unknown.

    Attributes:
        force: In every direction everywhere, gravity held, N.
        torque: Of a joint that gives it at the worst pose and direction, N m.
        limit: From cold until the winding is at its limit.
        derate: From cold until the controller takes torque back.
        warm: As `limit`, from where the continuous torque has warmed the motor.
    """

    force: float
    torque: float
    limit: float | None
    derate: float | None
    warm: float | None


def holds(machine: MachineModel, drive: Drive, p: np.ndarray) -> tuple[Hold, ...]:
    """Computes how long the forces from the continuous one to the peak may be held; see `DEFINITION`.

    Args:
        machine: The device.
        drive: What its joints do.
        p: (..., 3) positions of the cube, m.

    Raises:
        UnreachableError: A position cannot be reached.
    """
    columns = np.swapaxes(jacobian(machine.geometry, p), -1, -2)
    gravity = gravity_torque(machine.geometry, machine.masses, p, machine.design.requirements.gravity_m_s2)
    motor = catalogue.motor.chosen(machine.design.hardware)
    heat = motor_heat(motor, machine.drive.ratio * machine.drive.efficiency)
    found = []
    for torque in np.unique(np.linspace(drive.continuous, drive.peak, STEPS)).tolist():
        times = (None, None, None)
        if heat.coupling > 0.0:
            times = (
                hold_time(heat, torque, heat.hottest),
                hold_time(heat, torque, heat.derate),
                hold_time(heat, torque, heat.hottest, drive.continuous),
            )
        found.append(Hold(float(inscribed_ball(columns, gravity, torque).min()), torque, *times))
    return tuple(found)


def _as_fact(seconds: float | None) -> float | str:
    """A time as facts have it: s, or in words."""
    return _UNKNOWN if seconds is None else _FOR_EVER if math.isinf(seconds) else seconds


def hold_facts(found: tuple[Hold, ...]) -> list[dict[str, float | str]]:
    """The facts, with a unit in every key; a time is a number or "for ever" or "unknown"."""
    return [
        {
            "force_N": one.force,
            "torque_N_m": one.torque,
            "until_limit_s": _as_fact(one.limit),
            "until_taken_back_s": _as_fact(one.derate),
            "until_limit_warm_s": _as_fact(one.warm),
        }
        for one in found
    ]


def hold_markdown(machine: MachineModel, found: tuple[Hold, ...]) -> list[str]:
    """The part of the page, lines of Markdown."""
    lines = [
        "## How long a force may be held",
        "",
        "| force everywhere, N | torque, N m | to the limit, s | taken back from, s | to the limit, warm, s |",
        "|---:|---:|---:|---:|---:|",
        *(
            f"| {one.force:.1f} | {one.torque:.3f} | {_cell(one.limit)} | {_cell(one.derate)} | {_cell(one.warm)} |"
            for one in found
        ),
        "",
        f"{DEFINITION[0].upper()}{DEFINITION[1:]}.",
        "",
    ]
    if found[0].limit is None:
        row = machine.design.hardware.motor
        assumed = f"{machine.drive.peak_time_s:g} s at the motor's peak is what the catalogue assumes"
        lines += [f"Unknown: the catalogue's row {row} lacks thermal resistances; {assumed}.", ""]
    return lines


def _cell(seconds: float | None) -> str:
    said = _as_fact(seconds)
    return said if isinstance(said, str) else f"{said:.3g}" if said < 1e3 else f"{said:.0f}"
