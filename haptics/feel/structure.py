"""What gives way as a person meets it: structural stiffness, first resonance, bandwidth of the force on a held handle.

The build writes the stiffness of its exact structure; this project's loops take one spring as stiff as the design asks
for. Both are told. Importing this module loads numba.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

import numpy as np

from delta_cad.common.reading import ReadError, read_json
from delta_cad.design import Design, design_hash
from haptics.model.machine import MachineModel
from haptics.model.plant import FREE, Plant
from haptics.simulation.hardware import STIFFER, real_plant, structured
from haptics.simulation.loops import BOARD, LoopChoice
from haptics.stability.bodies import continuous, loaded
from haptics.stability.linear import linearise
from haptics.stability.walls import WallAt

FILE, SCHEMA = "structure.json", "delta-structure/1"
FIXED = 1e9  # N m/rad that hold a motor whose structure alone is to swing, and N/m that hold a handle
LEVEL = 10.0 ** (3.0 / 20.0)  # 3 dB
SWEEP_Hz = np.geomspace(1.0, 3000.0, 3000)


@dataclass(frozen=True)
class BuiltStructure:
    """What the build computed of its structure, motors held, cable included.

    Attributes:
        centre: Least stiffness at the knob of all directions, in the cube's centre, N/m.
        softest: The same at the softest of its positions, N/m.
        mode: First mode in the centre, Hz.
        slowest: The lowest over the cube, Hz.
    """

    centre: float
    softest: float
    mode: float
    slowest: float


class Bandwidth(NamedTuple):
    """Of the force on a held handle over the command, Hz.

    Attributes:
        within: Up to which it keeps within 3 dB.
        less: From which it has lost 3 dB for good.
    """

    within: float
    less: float


def built_structure(folder: Path, design: Design) -> BuiltStructure | None:
    """Reads `structure.json` of a design's build; None where it is missing, of another design, or cannot be read."""
    try:
        data = read_json(folder / FILE)
        if data["schema"] != SCHEMA or data["input_sha256"] != design_hash(design):
            return None
        stiffness = (1e3 * float(data[place]["softest_N_mm"]) for place in ("centre", "softest"))
        modes = (float(data[place]["first_mode_Hz"]) for place in ("centre", "slowest"))
        found = BuiltStructure(*stiffness, *modes)
    except (ReadError, KeyError, TypeError, ValueError):
        return None
    return found if all(math.isfinite(v) and v > 0.0 for v in vars(found).values()) else None


def first_resonance(machine: MachineModel, loop: LoopChoice = BOARD) -> float:
    """Lowest mode at the centre with the motors held, of the loop's model, Hz."""
    here = WallAt(machine, replace(loop, drive_damping=0.0, contact_damping=0.0)).here
    body, _ = here.body(FREE)
    motors = here.ports(np.eye(3), len(body.mass)).push.T @ np.eye(len(body.mass))
    held = loaded(body, motors, stiffness=FIXED)
    roots = np.linalg.eigvals(continuous(held, np.zeros((len(body.mass), 1)))[0])
    return float(np.abs(roots.imag[np.abs(roots.imag) > 1.0]).min() / (2.0 * math.pi))


def held_force(
    machine: MachineModel, par: Plant, normal: np.ndarray, frequency: np.ndarray, loop: LoopChoice = BOARD
) -> np.ndarray:
    """Force on a handle that is held still over the force commanded, at the cube's centre.

    Args:
        machine: The device.
        par: Its plant.
        normal: (3,) direction of the force.
        frequency: (n,) Hz.
        loop: Whose hold and current loop stand between.

    Returns:
        (n,) complex, dimensionless; without the delay, which turns its phase alone.
    """
    here = linearise(par, machine.centre)
    body, place = here.body(FREE)
    n = len(body.mass)
    rate, asked = continuous(
        loaded(body, place, stiffness=FIXED), here.ports(normal[:, None], n).push, loop.current_lag
    )
    s = 2j * math.pi * frequency[:, None, None] * np.eye(len(rate))
    moved = np.linalg.solve(s - rate, np.broadcast_to(asked + 0j, (len(s), *asked.shape)))
    return FIXED * (normal @ place @ moved[:, :n, 0].T) * np.sinc(frequency * loop.period)


def force_bandwidth(machine: MachineModel, normal: np.ndarray, loop: LoopChoice = BOARD) -> tuple[Bandwidth, Bandwidth]:
    """Bandwidth of the force on a held handle, with the structure as soft as the design asks for, and the stiffest.

    Args:
        machine: The device.
        normal: (3,) direction of the force.
        loop: The loop.
    """
    plain = real_plant(machine, loop)
    found = []
    for share in (STIFFER[0], STIFFER[-1]):
        par = structured(plain, share * plain.structure_stiffness)
        level = np.abs(held_force(machine, par, normal, SWEEP_Hz, loop))
        off, less = np.flatnonzero(np.abs(np.log(level)) > math.log(LEVEL)), np.flatnonzero(level >= 1.0 / LEVEL)
        within = SWEEP_Hz[off[0]] if len(off) else SWEEP_Hz[-1]
        found.append(Bandwidth(float(within), float(SWEEP_Hz[less[-1]])))
    return found[0], found[1]
