"""The default wall on the structure as it is built: what the encoders' noise moves, all over the cube.

Flexibility is that of the parts by `delta_cad.structure`, which haptics does not know, in each direction its own,
without the cable, a spring of the loop's model; a fifth softer to a fifth stiffer, and damping least.
"""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import product

import numpy as np
import pytest
from scipy.linalg import sqrtm

from delta_cad.common.units import MM_PER_M
from delta_cad.design import Design
from delta_cad.dimensions import dimensions
from delta_cad.mechanism import jacobian
from delta_cad.structure.compliance import compliance
from delta_cad.structure.table import StructureTable, structure_table
from haptics.model.hands import HANDS
from haptics.model.machine import MachineModel
from haptics.model.plant import FREE
from haptics.rendering import law_table
from haptics.rendering.laws.virtual_wall import axis_wall
from haptics.scenes.noise import in_band
from haptics.simulation.assumptions import encoder_count
from haptics.simulation.hardware import (
    LOSS,
    STIFFER,
    board_controller,
    reading_age,
    real_plant,
    sensor_errors,
    structured,
)
from haptics.simulation.loop import simulate, timing
from haptics.simulation.loops import BOARD, LoopChoice
from haptics.stability.linear import Structure
from haptics.stability.noise import BARELY, FORCE, MOTION, NoisyLoop
from haptics.stability.port import handle, impedance
from haptics.stability.wall_share import closed_form, proven_cap, rendered
from haptics.stability.wall_trial import LOOP_SUBSTEPS
from haptics.stability.walls import ACTIVE, SHARE, WallAt
from tests.haptics.scene_machine import scene_machine

WALL, MET = 5000.0, 2000.0  # N/m at the centre, and everywhere
SHARES = (0.8, 0.9, 1.0, 1.1, 1.2)
POSES = [np.array(p) for p in product((-1.0, 0.0, 1.0), (0.0, 1.0), (-1.0, 0.0, 1.0))]  # y and -y are mirrored


@pytest.fixture(scope="module")
def machine(best: Design) -> MachineModel:
    return scene_machine(best)


@pytest.fixture(scope="module")
def table(best: Design) -> StructureTable:
    return structure_table(dimensions(best))


def built(table: StructureTable, machine: MachineModel, p: np.ndarray, share: float, loss: float) -> Structure:
    gives = compliance(table, MM_PER_M * p).at_knob()
    stiffness = share * MM_PER_M * np.linalg.inv(sum(one for name, one in gives.items() if name != "cable"))
    root = np.real(sqrtm(stiffness))  # damps each direction's own swing by the same share of critical
    return Structure(stiffness, 2.0 * loss * np.sqrt(real_plant(machine).knob) * root)


def walls(machine: MachineModel, p: np.ndarray, loop: LoopChoice) -> list[tuple[np.ndarray, float, float]]:
    """The walls that are rendered at a place across x, y, z and the worst direction."""
    cap, columns = proven_cap(machine, loop), jacobian(machine.geometry, p)
    normals = [*np.eye(3), rendered(cap, columns)[2]]
    return [
        (n, min(WALL, stiffness), damping) for n in normals for stiffness, damping in [closed_form(cap, columns, n)]
    ]


def moved(machine: MachineModel, table: StructureTable, p: np.ndarray, loop: LoopChoice = BOARD) -> float:
    """The most of all walls and structures, m rms, all but let go of; force within its bound."""
    par, most = real_plant(machine, loop, 0), 0.0
    for normal, stiffness, damping in walls(machine, p, loop):
        for share in SHARES:
            gives = built(table, machine, p, share, LOSS[0])
            noisy = NoisyLoop(machine, loop, p, BARELY, normal=normal, par=par, structure=gives)
            found = noisy.figures(stiffness, damping)
            assert found.force <= FORCE
            most = max(most, found.motion)
    return most


@pytest.mark.parametrize("place", [pytest.param(p, id=str(p)) for p in POSES])
def test_noise_is_unnoticed_everywhere(machine: MachineModel, table: StructureTable, place: np.ndarray) -> None:
    p = machine.centre + machine.half_side * place
    assert moved(machine, table, p) <= MOTION
    assert min(stiffness for _, stiffness, _ in walls(machine, p, BOARD)) >= MET


@pytest.mark.parametrize(
    ("loop", "place"),
    [
        (replace(BOARD, sensing=1.0), (0.0, 0.0, 0.0)),  # which its shorter delay allows
        (replace(BOARD, contact_damping=BOARD.drive_damping, damping=1.95), (0.0, 0.0, 0.0)),
    ],
    ids=["encoders as the maker sets them", "law in place of drives"],
)
def test_none_of_what_it_takes_may_be_left_out(
    machine: MachineModel, table: StructureTable, loop: LoopChoice, place: tuple[float, float, float]
) -> None:
    p = machine.centre + machine.half_side * np.array(place)
    assert moved(machine, table, p, loop) > 1.02 * MOTION


@pytest.mark.parametrize("place", [(0.0, 0.0, 0.0), (0.0, 0.0, 1.0), (-1.0, 1.0, 1.0), (-1.0, 1.0, -1.0)])
def test_the_walls_are_steady_and_passive_at_the_handle(
    machine: MachineModel, table: StructureTable, place: tuple[float, float, float]
) -> None:
    """With every hand and none, and what is capped from; averaged, with the least friction."""
    p, par = machine.centre + machine.half_side * np.array(place), real_plant(machine, BOARD, 0)
    for (normal, stiffness, damping), share in product(walls(machine, p, BOARD), SHARES[::2]):
        gives, at = built(table, machine, p, share, LOSS[0]), WallAt(machine, BOARD, p, normal, place=0)
        for hand in (BARELY, *HANDS.values()):
            noisy = NoisyLoop(machine, BOARD, p, hand, normal=normal, par=par, structure=gives)
            assert noisy.loop.radius(stiffness / SHARE, damping) < 1.0
        body, knob = at.here.body(FREE, gives)
        port = handle(body, at.here.ports(normal[:, None], len(body.mass)), normal @ knob, at.timing)
        z = impedance(port, at.estimator, stiffness, damping)
        assert (np.real(z) >= ACTIVE * np.abs(z)).all()


@pytest.mark.parametrize("stiffer", [STIFFER[2], STIFFER[7]])
def test_friction_that_sticks_does_not_hide_the_motion(machine: MachineModel, stiffer: float) -> None:
    """A handle that 1.8 N press into the default wall, simulated: joints stick, and the knob rings on its structure."""
    plain, ticks, T = real_plant(machine, BOARD, 0), round(5.6 / BOARD.period), BOARD.period
    par = structured(plain, stiffer * plain.structure_stiffness, LOSS[0])
    push = np.zeros((ticks, 3))
    ramp = np.clip((np.arange(ticks) * T - 0.6) / 0.6, 0.0, 1.0)
    push[:, 0] = 1.8 * ramp**2 * (3.0 - 2.0 * ramp)
    record = simulate(
        par, board_controller(machine, energy=1e3, energy_start=1e3, ramp_power=1e3),
        law_table(axis_wall("+x", float(machine.centre[0]), stiffness=WALL, damping=BOARD.damping)),
        timing(T, BOARD.delay + reading_age(machine), LOOP_SUBSTEPS), machine.centre, hand=BARELY,
        anchor=np.tile(machine.centre, (ticks, 1)), push=push, count=encoder_count(machine),
        errors=sensor_errors(machine), seed=1,
    )  # fmt: skip
    late = record.time >= 1.6
    assert np.ptp(record.position[late, 0]) < 2e-5
    found = math.sqrt(float(np.linalg.eigvalsh(np.cov(in_band(record.knob[late], T).T))[-1]))
    told = NoisyLoop(machine, hand=BARELY, normal=np.eye(3)[0], par=par).figures(WALL, BOARD.damping).motion
    assert found == pytest.approx(told, rel=0.3)
    assert (found > MOTION) == (stiffer < STIFFER[7])
