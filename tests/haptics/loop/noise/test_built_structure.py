"""The default wall on the structure as it is built: what the encoders' noise moves, all over the cube.

`tests/optimizer/codesign/test_committed.py` asks the same of the committed design.
"""

from __future__ import annotations

import math
from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from delta_cad.common.units import MM_PER_M
from delta_cad.design import Design
from delta_cad.dimensions import dimensions
from delta_cad.mechanism import jacobian
from delta_cad.structure.beam_model import beam_model
from delta_cad.structure.compliance import compliance
from haptics.loop.assumptions import encoder_count
from haptics.loop.choice import DAMPED, LoopChoice
from haptics.loop.hardware import (
    BUILT_SHARES,
    LOSS,
    STIFFER,
    board_controller,
    reading_age,
    real_plant,
    sensor_errors,
    structure_stiffness,
)
from haptics.loop.linear import structure_at
from haptics.loop.noise import BARELY, MOTION, NoisyLoop
from haptics.loop.passivity import handle, impedance
from haptics.loop.simulation import simulate, timing
from haptics.loop.wall_trial import LOOP_SUBSTEPS
from haptics.loop.walls import STABILITY_MARGIN, WallStability
from haptics.model.hands import HANDS
from haptics.model.machine import MachineModel
from haptics.model.plant import FREE
from haptics.rendering import law_table
from haptics.rendering.laws.virtual_wall import axis_wall
from haptics.scenes.noise import in_band
from tests.haptics.loop.noise.built import POSES, WALL, moved, structured, walls, with_structure
from tests.haptics.scene_machine import scene_machine

ACTIVE = -1e-6  # Re Z as a share of |Z| that rounding may cause
MET = 2000.0  # N/m everywhere in the cube


@pytest.fixture(scope="module")
def machine(best: Design) -> MachineModel:
    return with_structure(scene_machine(best))


@pytest.mark.parametrize("place", [(0.0, 0.0, 0.0), (-1.0, 1.0, 1.0), (0.3, -0.6, -0.2)])
def test_the_structure_is_that_of_the_parts_without_the_cable(
    machine: MachineModel, place: tuple[float, float, float]
) -> None:
    """Of each part by itself; the loop's own cable, a spring of its model, is 6 % off the parts' in the centre."""
    p = machine.centre + machine.half_side * np.array(place)
    gives = compliance(beam_model(dimensions(machine.design)), MM_PER_M * p).at_knob()
    rest = sum(one for name, one in gives.items() if name != "cable") / MM_PER_M
    cable = gives["cable"] / MM_PER_M
    found = np.linalg.inv(structure_stiffness(machine, p))
    own = np.linalg.inv(real_plant(machine).cable_stiffness * np.linalg.inv(_square(machine, p)))
    assert found + own == pytest.approx(rest + cable, abs=0.04 * np.abs(rest + cable).max())
    assert np.linalg.norm(found - rest) < 0.3 * np.linalg.norm(rest)


def _square(machine: MachineModel, p: np.ndarray) -> np.ndarray:
    columns = jacobian(machine.geometry, p)
    return columns @ columns.T


@pytest.mark.parametrize("place", [pytest.param(p, id=str(p)) for p in POSES])
def test_noise_is_unnoticed_everywhere(machine: MachineModel, place: np.ndarray) -> None:
    assert moved(machine, place).quiet
    assert min(one for _, one, _ in walls(machine, machine.centre + machine.half_side * place)) >= MET


@pytest.mark.parametrize(
    "loop",
    [
        replace(DAMPED, sensing=1.0),  # which its shorter delay allows
        replace(DAMPED, contact_damping=DAMPED.drive_damping, damping=1.95),
    ],
    ids=["encoders as the maker sets them", "law in place of drives"],
)
def test_none_of_what_it_takes_may_be_left_out(machine: MachineModel, loop: LoopChoice) -> None:
    assert moved(machine, np.zeros(3), loop).motion > 1.02 * MOTION


@pytest.mark.parametrize("place", [(0.0, 0.0, 0.0), (0.0, 0.0, 1.0), (-1.0, 1.0, 1.0), (-1.0, 1.0, -1.0)])
def test_the_walls_are_steady_and_passive_at_the_handle(
    machine: MachineModel, place: tuple[float, float, float]
) -> None:
    """With every hand and none, and what is capped from; averaged, with the least friction."""
    p, par = machine.centre + machine.half_side * np.array(place), real_plant(machine, DAMPED, 0)
    for (normal, stiffness, damping), share in product(walls(machine, p), BUILT_SHARES[::2]):
        gives, at = structure_at(machine, p, LOSS[0], share), WallStability(machine, DAMPED, p, normal, place=0)
        for hand in (BARELY, *HANDS.values()):
            noisy = NoisyLoop(machine, DAMPED, p, hand, normal=normal, par=par, structure=gives)
            assert noisy.loop.radius(stiffness / STABILITY_MARGIN, damping) < 1.0
        body, knob = replace(at.here, structure=gives).body(FREE)
        port = handle(body, at.here.ports(normal[:, None], len(body.mass)), normal @ knob, at.timing)
        z = impedance(port, at.estimator, stiffness, damping)
        assert (np.real(z) >= ACTIVE * np.abs(z)).all()


@pytest.mark.parametrize("stiffer", [STIFFER[2], STIFFER[7]])
def test_friction_that_sticks_does_not_hide_the_motion(machine: MachineModel, stiffer: float) -> None:
    """A handle that 1.8 N press into the default wall, simulated: joints stick, and the knob rings on its structure."""
    machine = replace(machine, structure=None)
    plain, ticks, T = real_plant(machine, DAMPED, 0), round(5.6 / DAMPED.period), DAMPED.period
    par = structured(plain, stiffer * plain.structure_stiffness, LOSS[0])
    push = np.zeros((ticks, 3))
    ramp = np.clip((np.arange(ticks) * T - 0.6) / 0.6, 0.0, 1.0)
    push[:, 0] = 1.8 * ramp**2 * (3.0 - 2.0 * ramp)
    record = simulate(
        par, board_controller(machine, DAMPED, energy=1e3, energy_start=1e3, ramp_power=1e3),
        law_table(axis_wall("+x", float(machine.centre[0]), stiffness=WALL, damping=DAMPED.damping)),
        timing(T, DAMPED.delay + reading_age(machine), LOOP_SUBSTEPS), machine.centre, hand=BARELY,
        anchor=np.tile(machine.centre, (ticks, 1)), push=push, count=encoder_count(machine),
        errors=sensor_errors(machine), seed=1,
    )  # fmt: skip
    late = record.time >= 1.6
    assert np.ptp(record.position[late, 0]) < 2e-5
    found = math.sqrt(float(np.linalg.eigvalsh(np.cov(in_band(record.knob[late], T).T))[-1]))
    reported = (
        NoisyLoop(machine, DAMPED, hand=BARELY, normal=np.eye(3)[0], par=par).figures(WALL, DAMPED.damping).motion
    )
    assert found == pytest.approx(reported, rel=0.3)
    assert (found > MOTION) == (stiffer < STIFFER[7])
