"""A healthy device in a hand is not stopped: strokes and drawing with friction, counts and a trembling hand."""

from __future__ import annotations

import numpy as np
import pytest

from delta_cad.design import design_from_dict
from haptics.control.supervisor.faults import LATCHING, FaultCode
from haptics.loop.assumptions import default_controller, encoder_count, joint_friction, nominal_plant
from haptics.loop.simulation import simulate, timing
from haptics.model.hands import HANDS
from haptics.model.machine import MachineModel
from haptics.rendering import law_table
from haptics.rendering.laws.constant_force import ConstantForce
from tests.committed import changed
from tests.haptics.scene_machine import scene_machine

NOTHING = law_table(ConstantForce([0.0, 0.0, 0.0]))
PERIOD = 1e-3


def latched(machine: MachineModel, anchor: np.ndarray, hand: str, place: int, seed: int, **limits: float) -> int:
    """What the supervisor latched while a hand led the handle along a path, no force but gravity's asked for."""
    par = joint_friction(machine).of(nominal_plant(machine), place)
    record = simulate(
        par,
        default_controller(machine, **limits),
        NOTHING,
        timing(PERIOD, 0.5e-3),
        anchor[0],
        hand=HANDS[hand],
        anchor=anchor,
        push=np.zeros(anchor.shape),
        count=encoder_count(machine),
        seed=seed,
    )
    return int(np.bitwise_or.reduce(record.bits)) & LATCHING


def drawing(machine: MachineModel, seconds: float, rng: np.random.Generator) -> np.ndarray:
    """(n, 3) a wandering path that fills the cube, with a tremor of 50 um at 9 Hz, m."""
    half, bottom = machine.design.cube.half_side_mm / 1000.0, machine.design.cube.bottom_height_mm / 1000.0
    t = np.arange(round(seconds / PERIOD)) * PERIOD
    path = np.zeros((len(t), 3))
    for j in range(3):
        f, phase, a = rng.uniform(0.1, 0.6, 4), rng.uniform(0.0, 2.0 * np.pi, 4), rng.uniform(0.3, 1.0, 4)
        path[:, j] = 1.3 * half * (a / a.sum() * np.sin(2.0 * np.pi * f * t[:, None] + phase)).sum(axis=1)
    path = np.clip(path, -0.9 * half, 0.9 * half)
    path[:, 2] += bottom + half
    return path + 5e-5 * np.sin(2.0 * np.pi * 9.0 * t)[:, None] * [1.0, 0.7, -0.5]


@pytest.mark.slow
@pytest.mark.parametrize("hand", ["light", "medium", "firm"])
def test_drawing_is_never_stopped(machine: MachineModel, hand: str) -> None:
    rng = np.random.default_rng(11)
    for place in range(3):
        assert latched(machine, drawing(machine, 20.0, rng), hand, place, place) == 0


@pytest.mark.slow
def test_the_path_is_one_that_a_narrower_threshold_would_stop() -> None:
    """With 14 bits: of finer counts some always change."""
    machine = scene_machine(design_from_dict(changed(hardware__encoder="as5048a-board")))
    rng = np.random.default_rng(11)
    stopped = [latched(machine, drawing(machine, 20.0, rng), "medium", 2, k, frozen_turn=0.2) for k in range(4)]
    assert any(found & FaultCode.ANGLE_FROZEN.bit for found in stopped)


@pytest.mark.slow
def test_straight_strokes_are_never_stopped(machine: MachineModel) -> None:
    rng = np.random.default_rng(12)
    half, bottom = machine.design.cube.half_side_mm / 1000.0, machine.design.cube.bottom_height_mm / 1000.0
    share = np.clip(np.arange(2000) * PERIOD - 0.7, 0.0, 1.0)[:, None]
    for k in range(40):
        ends = rng.uniform(-0.95, 0.95, (2, 3)) * half + [0.0, 0.0, bottom + half]
        anchor = ends[0] + share**3 * (10.0 + share * (6.0 * share - 15.0)) * (ends[1] - ends[0])
        assert latched(machine, anchor, "medium", 1, k) == 0
