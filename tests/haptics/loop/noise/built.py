"""Machines with the structure of their parts, as `structure.json` has it, and what noise moves on it."""

from __future__ import annotations

from dataclasses import replace
from itertools import product

import numpy as np

from delta_cad.common.units import MM_PER_M
from delta_cad.dimensions import dimensions
from delta_cad.mechanism import jacobian
from delta_cad.structure.beam_model import beam_model
from delta_cad.structure.compliance import compliance
from haptics.loop.choice import DAMPED, LoopChoice
from haptics.loop.hardware import BUILT_SHARES, LOSS, real_plant
from haptics.loop.linear import structure_at
from haptics.loop.noise import BARELY, NoiseFigures, NoisyLoop
from haptics.loop.walls import closed_form, proven_cap, rendered
from haptics.model.built import BuiltStructure
from haptics.model.machine import MachineModel
from haptics.model.plant import Plant

WALL = 5000.0  # N/m at the centre
POSES = [np.array(p) for p in product((-1.0, 0.0, 1.0), (0.0, 1.0), (-1.0, 0.0, 1.0))]  # y and -y are mirrored
EDGE = 5  # positions along an edge, as in the file


def with_structure(machine: MachineModel) -> MachineModel:
    """The machine as if its build were at hand; modes are left out."""
    half = machine.half_side * np.linspace(-1.0, 1.0, EDGE)
    places = (half, half, machine.centre[2] + half)
    grid = np.stack(np.meshgrid(*places, indexing="ij"), axis=-1)
    gives = compliance(beam_model(dimensions(machine.design)), MM_PER_M * grid.reshape(-1, 3)).at_knob()
    flexibility = np.sum(list(gives.values()), axis=0) / MM_PER_M
    stiffest = 1.0 / np.linalg.eigvalsh(flexibility)[:, -1]
    middle = len(stiffest) // 2
    return replace(
        machine,
        structure=BuiltStructure(
            places, flexibility.reshape(*grid.shape[:3], 3, 3), stiffest[middle], stiffest.min(), np.nan, np.nan
        ),
    )


def structured(par: Plant, stiffness: float, loss: float) -> Plant:
    """The plant with another structure between platform and knob, N/m and share of critical."""
    damping = 2.0 * loss * np.sqrt(stiffness * par.knob)
    return par._replace(structure_stiffness=stiffness, structure_damping=damping)


def walls(machine: MachineModel, p: np.ndarray, loop: LoopChoice = DAMPED) -> list[tuple[np.ndarray, float, float]]:
    """The walls that are rendered at a place across x, y, z and the worst direction."""
    cap, columns = proven_cap(machine, loop), jacobian(machine.geometry, p)
    normals = [*np.eye(3), rendered(cap, columns)[2]]
    return [
        (n, min(WALL, stiffness), damping) for n in normals for stiffness, damping in [closed_form(cap, columns, n)]
    ]


def moved(machine: MachineModel, place: np.ndarray, loop: LoopChoice = DAMPED) -> NoiseFigures:
    """The most of all walls and structures at a place of the cube, -1 to 1 a side, all but let go of."""
    p, par, found = machine.centre + machine.half_side * place, real_plant(machine, loop, 0), []
    for normal, stiffness, damping in walls(machine, p, loop):
        for share in BUILT_SHARES:
            gives = structure_at(machine, p, LOSS[0], share)
            noisy = NoisyLoop(machine, loop, p, BARELY, normal=normal, par=par, structure=gives)
            found.append(noisy.figures(stiffness, damping))
    most = max(one.force for one in found), max(one.motion for one in found)
    return NoiseFigures(*most, all(one.steady for one in found))
