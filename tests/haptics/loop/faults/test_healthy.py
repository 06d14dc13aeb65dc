"""A healthy device is not stopped by its readings: at rest, drawing, knocked, thrown at stops, with every encoder."""

from __future__ import annotations

import numpy as np
import pytest

from delta_cad.design import design_from_dict
from haptics.control.supervisor.faults import FaultCode, findings, mask
from haptics.loop.assumptions import encoder_count
from haptics.loop.choice import BOARD, LoopChoice, at_rate
from haptics.loop.hardware import board_controller, reading_age, real_plant, sensor_errors
from haptics.loop.simulation import SimulatedRun, simulate, timing
from haptics.model.hands import HANDS
from haptics.model.machine import MachineModel
from haptics.model.plant import FREE, Hand
from haptics.rendering import law_table
from haptics.rendering.laws.virtual_wall import axis_wall
from tests.committed import changed
from tests.haptics.scene_machine import scene_machine

OF_READINGS = mask(code for code in FaultCode if code.name.startswith("ANGLE_"))
HARDWARE = {
    **{encoder: {"hardware__encoder": encoder} for encoder in ("mt6835-board", "as5048a-board", "as5047p-board")},
    "mt6825-board": {"hardware__encoder": "mt6825-board"},
    "on the motor": {"hardware__encoder_at": "motor", "hardware__motor": "maxon-re30-310009-500"},
}


def machine(hardware: str) -> MachineModel:
    return scene_machine(design_from_dict(changed(**HARDWARE[hardware])))


def used(
    device: MachineModel, loop: LoopChoice, hand: Hand, anchor: np.ndarray, push: np.ndarray, place: int
) -> SimulatedRun:
    """A device in use near a wall 3 mm off its centre, with friction at a place of its range."""
    return simulate(
        real_plant(device, loop, place), board_controller(device, loop),
        law_table(axis_wall("+x", float(device.centre[0] + 3e-3), stiffness=1e5)),
        timing(loop.period, loop.delay + reading_age(device, loop), max(2, round(16_000 * loop.period))),
        anchor[0].copy(), hand=hand, anchor=anchor, push=push, count=encoder_count(device),
        errors=sensor_errors(device, loop), seed=3,
    )  # fmt: skip


def found(run: SimulatedRun) -> tuple[FaultCode, ...]:
    return findings(int(np.bitwise_or.reduce(run.bits)) & OF_READINGS)


@pytest.mark.quick(2)
@pytest.mark.parametrize("rate_Hz", [8000.0, 1000.0])
@pytest.mark.parametrize("hardware", HARDWARE)
def test_at_rest_and_drawing(hardware: str, rate_Hz: float) -> None:
    device, loop = machine(hardware), at_rate(rate_Hz)
    ticks = round(8.0 * rate_Hz)
    time = np.arange(ticks) * loop.period
    moving = np.clip(time - 4.0, 0.0, 1.0)[:, None]  # at rest for four seconds
    way = np.stack([np.sin(9.0 * time), np.sin(7.3 * time), np.sin(5.1 * time)], axis=-1)
    anchor = device.centre + 0.8 * device.half_side * moving * way
    for place, hand in enumerate((HANDS["light"], HANDS["firm"], Hand(0.1, 10.0, 1000.0))):
        run = used(device, loop, hand, anchor, np.zeros((ticks, 3)), place)
        assert found(run) == ()
        assert np.ptp(run.position[ticks // 2 :], axis=0).max() > 0.01


@pytest.mark.parametrize("rate_Hz", [8000.0, 1000.0])
def test_knocked_and_thrown_at_stops_and_bezel(rate_Hz: float) -> None:
    """Knocks of 150 N within 2 ms; and a handle that nobody holds, pushed into each corner by 12 N."""
    device, loop = machine("mt6835-board"), at_rate(rate_Hz)
    ticks = round(4.0 * rate_Hz)
    time, rest = np.arange(ticks) * loop.period, np.tile(device.centre, (ticks, 1))
    rng = np.random.default_rng(4)
    sides = rng.normal(size=(8, 3))
    sides /= np.linalg.norm(sides, axis=1)[:, None]
    at = np.minimum((time / 0.5).astype(int), 7)
    within = time % 0.5
    knock = 150.0 * np.sin(np.pi * np.clip(within - 0.2, 0.0, 2e-3) / 2e-3)
    run = used(device, loop, Hand(0.1, 10.0, 1000.0), rest, knock[:, None] * sides[at], 1)
    assert found(run) == ()
    assert np.abs(run.velocity).max() > 0.3
    thrown = used(device, loop, FREE, rest, np.where(within < 0.4, 12.0, 0.0)[:, None] * sides[at], 1)
    assert found(thrown) == ()
    assert np.abs(thrown.velocity).max() > 1.0


def test_the_loop_of_the_tests_is_the_default() -> None:
    assert at_rate(8000.0) == BOARD
