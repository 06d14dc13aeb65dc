"""Compliance as felt by a person: first resonance, and bandwidth of the force on a held handle.

The structure is that of the build where `structure.json` is at hand, else as stiff as the design requires. Importing
this module loads numba.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from haptics.loop.choice import BOARD, LoopChoice
from haptics.loop.discrete import continuous, loaded
from haptics.loop.hardware import LOSS, real_plant
from haptics.loop.linear import linearise, structure_at
from haptics.loop.noise import shares
from haptics.model.machine import MachineModel
from haptics.model.plant import FREE

FIXED = 1e9  # N m/rad that hold a motor whose structure alone is to swing, and N/m that hold a handle
LEVEL = 10.0 ** (3.0 / 20.0)  # 3 dB
SWEEP_Hz = np.geomspace(1.0, 3000.0, 3000)


class Bandwidth(NamedTuple):
    """Of the force on a held handle over the command, Hz.

    Attributes:
        within: Up to which it keeps within 3 dB.
        less: From which it has lost 3 dB for good.
    """

    within: float
    less: float


def first_resonance(machine: MachineModel) -> float:
    """Lowest mode at the centre with the motors held, as the walls' model has it, Hz."""
    here = linearise(real_plant(machine, BOARD), machine.centre, structure_at(machine, machine.centre))
    body, _ = here.body(FREE)
    motors = here.ports(np.eye(3), len(body.mass)).push.T @ np.eye(len(body.mass))
    held = loaded(body, motors, stiffness=FIXED)
    roots = np.linalg.eigvals(continuous(held, np.zeros((len(body.mass), 1)))[0])
    return float(np.abs(roots.imag[np.abs(roots.imag) > 1.0]).min() / (2.0 * math.pi))


def held_force(
    machine: MachineModel, normal: np.ndarray, frequency: np.ndarray, loop: LoopChoice = BOARD, share: float = 1.0
) -> np.ndarray:
    """Force on a handle that is held still over the force commanded, at the cube's centre.

    Args:
        machine: The device.
        normal: (3,) direction of the force.
        frequency: (n,) Hz.
        loop: Whose hold and current loop stand between.
        share: Of the structure's stiffness.

    Returns:
        (n,) complex, dimensionless; without the delay, which turns its phase alone.
    """
    here = linearise(real_plant(machine, loop), machine.centre, structure_at(machine, machine.centre, LOSS[1], share))
    body, place = here.body(FREE)
    n = len(body.mass)
    rate, asked = continuous(
        loaded(body, place, stiffness=FIXED), here.ports(normal[:, None], n).push, loop.current_lag
    )
    s = 2j * math.pi * frequency[:, None, None] * np.eye(len(rate))
    moved = np.linalg.solve(s - rate, np.broadcast_to(asked + 0j, (len(s), *asked.shape)))
    return FIXED * (normal @ place @ moved[:, :n, 0].T) * np.sinc(frequency * loop.period)


def force_bandwidth(machine: MachineModel, normal: np.ndarray, loop: LoopChoice = BOARD) -> tuple[Bandwidth, Bandwidth]:
    """Bandwidth of the force on a held handle, with the softest and the stiffest structure of `shares`.

    Args:
        machine: The device.
        normal: (3,) direction of the force.
        loop: The loop.
    """
    found = []
    for share in (shares(machine)[0], shares(machine)[-1]):
        level = np.abs(held_force(machine, normal, SWEEP_Hz, loop, share))
        off, less = np.flatnonzero(np.abs(np.log(level)) > math.log(LEVEL)), np.flatnonzero(level >= 1.0 / LEVEL)
        within = SWEEP_Hz[off[0]] if len(off) else SWEEP_Hz[-1]
        found.append(Bandwidth(float(within), float(SWEEP_Hz[less[-1]])))
    return found[0], found[1]
