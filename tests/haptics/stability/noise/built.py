"""What noise moves on the structure as it is built, and what the drives' damping drags: figures that the README prints.

    python -m tests.haptics.stability.noise.built DESIGN MASS_PROPERTIES

Flexibility is that of the parts by `delta_cad.structure`, which haptics does not know, in each direction its own,
without the cable, a spring of the loop's model; a fifth softer to a fifth stiffer, and damping least.
"""

from __future__ import annotations

import sys
from itertools import product
from pathlib import Path

import numpy as np

from delta_cad.common.units import MM_PER_M
from delta_cad.dimensions import dimensions
from delta_cad.mechanism import jacobian
from delta_cad.structure.compliance import compliance
from delta_cad.structure.table import StructureTable, structure_table
from haptics.model.machine import MachineModel, load_machine
from haptics.simulation.hardware import LOSS, real_plant
from haptics.simulation.loops import BOARD, LoopChoice
from haptics.stability.linear import Structure, linearise
from haptics.stability.noise import BARELY, NoiseFigures, NoisyLoop
from haptics.stability.wall_share import closed_form, proven_cap, rendered

WALL = 5000.0  # N/m at the centre
SHARES = (0.8, 0.9, 1.0, 1.1, 1.2)
CENTRE = (0.0, 0.0, 0.0)
POSES = [np.array(p) for p in product((-1.0, 0.0, 1.0), (0.0, 1.0), (-1.0, 0.0, 1.0))]  # y and -y are mirrored
FAST = 0.2  # m/s, of a handle that is led quickly


def built(table: StructureTable, machine: MachineModel, p: np.ndarray, share: float, loss: float) -> Structure:
    gives = compliance(table, MM_PER_M * p).at_knob()
    stiffness = share * MM_PER_M * np.linalg.inv(sum(one for name, one in gives.items() if name != "cable"))
    values, turns = np.linalg.eigh((stiffness + stiffness.T) / 2.0)
    root = turns * np.sqrt(values) @ turns.T  # damps each direction's own swing by the same share of critical
    return Structure(stiffness, 2.0 * loss * np.sqrt(real_plant(machine).knob) * root)


def walls(machine: MachineModel, p: np.ndarray, loop: LoopChoice = BOARD) -> list[tuple[np.ndarray, float, float]]:
    """The walls that are rendered at a place across x, y, z and the worst direction."""
    cap, columns = proven_cap(machine, loop), jacobian(machine.geometry, p)
    normals = [*np.eye(3), rendered(cap, columns)[2]]
    return [
        (n, min(WALL, stiffness), damping) for n in normals for stiffness, damping in [closed_form(cap, columns, n)]
    ]


def moved(machine: MachineModel, table: StructureTable, place: np.ndarray, loop: LoopChoice = BOARD) -> NoiseFigures:
    """The most of all walls and structures at a place of the cube, -1 to 1 a side, all but let go of."""
    p, par, found = machine.centre + machine.half_side * place, real_plant(machine, loop, 0), []
    for normal, stiffness, damping in walls(machine, p, loop):
        for share in SHARES:
            gives = built(table, machine, p, share, LOSS[0])
            noisy = NoisyLoop(machine, loop, p, BARELY, normal=normal, par=par, structure=gives)
            found.append(noisy.figures(stiffness, damping))
    most = max(one.force for one in found), max(one.motion for one in found)
    return NoiseFigures(*most, all(one.steady for one in found))


def drag(machine: MachineModel, p: np.ndarray, touched: bool) -> np.ndarray:
    """Force of the drives' damping on a handle at `FAST` along x and z, (2,) N."""
    par = real_plant(machine)
    here = linearise(par.in_contact if touched else par, p)
    return FAST * np.array([here.effective_friction(normal) for normal in np.eye(3)[[0, 2]]])


def main(design: str, masses: str) -> None:
    machine = load_machine(Path(design), Path(masses))
    table = structure_table(dimensions(machine.design))
    found = {tuple(place): moved(machine, table, place) for place in POSES}
    print(f"walls of {WALL / MM_PER_M:g} N/mm or what is rendered: force and motion of the handle in the band, rms")
    for place, most in found.items():
        p, told = machine.centre + machine.half_side * np.array(place), [int(part) for part in place]
        least = min(stiffness for _, stiffness, _ in walls(machine, p)) / MM_PER_M
        print(f"{told}: {most.force:.4f} N, {1e6 * most.motion:.4f} um, wall from {least:.2f} N/mm")
    worst = max(found.values(), key=lambda one: one.motion)
    print(f"most: {1e6 * worst.motion:.4f} um; centre: {1e6 * found[CENTRE].motion:.4f} um")
    low = machine.centre - [0.0, 0.0, machine.half_side]
    for name, p in (("centre", machine.centre), ("floor's middle", low)):
        for state, touched in (("free", False), ("at a wall", True)):
            along = ", ".join(f"{force:.2f} N" for force in drag(machine, p, touched))
            print(f"drag at {FAST:g} m/s along x and z, {name}, {state}: {along}")


if __name__ == "__main__":
    main(*sys.argv[1:])
