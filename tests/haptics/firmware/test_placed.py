"""The C controller of machines whose chains do not stand alike: bit for bit the Python tick, at what a tick costs."""

from __future__ import annotations

import re
import subprocess
from pathlib import Path

import numpy as np
import pytest

from haptics.control.controller import Controller
from haptics.control.correction import correction
from haptics.control.pose import Model
from haptics.control.startup import record as r
from haptics.control.startup.record import Refusal, Step
from haptics.control.supervisor.faults import FaultCode, findings
from haptics.firmware.precision import DOUBLE, MIXED
from haptics.firmware.project import firmware, write_firmware
from haptics.loop.hardware import board_controller
from haptics.loop.start_up import start_up
from haptics.model.machine import MachineModel
from tests.haptics.calibration.devices import made
from tests.haptics.control.startup.planted import PERIOD, Fault, run
from tests.haptics.firmware.rig import (
    COUNTS,
    TWINS,
    by_python,
    compile_bare,
    compile_host,
    recording,
    remembered,
    replay,
    write,
)
from tests.haptics.firmware.test_ports import compiled
from tests.haptics.model.textbook import textbook
from tests.haptics.scene_machine import PLACED, placed_machine

TICKS = 10_000
LONGEST = 7500  # 20 % of 8 kHz at 600 MHz and 2 cycles an instruction
OF_THE_PLACE = {
    *(FaultCode.EDGE_LEFT, FaultCode.EDGE_FAR, FaultCode.JOINT_RANGE),
    *(FaultCode.NOT_CLOSED, FaultCode.SINGULAR, FaultCode.SINGULAR_NEAR),
}


def controller_of(machine: MachineModel) -> Controller:
    return board_controller(machine, stale=0.1)


@pytest.mark.parametrize("name", PLACED)
def test_ten_thousand_ticks_are_the_python_ones_bit_for_bit(name: str, tmp_path: Path) -> None:
    machine = placed_machine(name)
    controller = controller_of(machine)
    recorded = recording(machine, TICKS, 12, controller.limits.period)._replace(laws=TWINS)
    device = made(machine.design, np.random.default_rng(4), 4.8)
    for label, known in (("drawn", None), ("made", correction(machine.geometry, device))):
        bits, torque, memory = by_python(controller, recorded, *([known] if known else []))
        assert (np.abs(torque).max(axis=-1) > 0.05).sum() > 300
        assert len(findings(int(np.bitwise_or.reduce(bits)))) >= 6
        answers, left = replay(compile_host(write(controller, DOUBLE, tmp_path / label, known)), recorded)
        assert np.array_equal(answers["bits"], bits)
        assert np.array_equal(answers["torque"], torque)
        assert np.array_equal(remembered(left, controller), memory, equal_nan=True)


def test_a_healthy_handle_anywhere_in_the_cube_raises_nothing() -> None:
    """Neither range nor edge nor singularity: the limits are those of the cube where it stands."""
    for name in PLACED:
        machine = placed_machine(name)
        controller = controller_of(machine)
        bits, torque, _ = by_python(controller, recording(machine, 6000, 3, controller.limits.period, faults=False))
        assert not set(findings(int(np.bitwise_or.reduce(bits)))) & OF_THE_PLACE
        assert np.abs(torque).max() > 0.05


def test_a_cortex_m7_and_an_m4_have_the_same_bits_at_the_same_cost(tmp_path: Path) -> None:
    machine = placed_machine("study")
    controller = controller_of(machine)
    recorded = recording(machine, 2000, 9, controller.limits.period)._replace(laws=TWINS)
    _, torque, memory = by_python(controller, recorded)
    answers, left = replay(compile_bare(write(controller, DOUBLE, tmp_path / "m7"), "m7"), recorded)
    assert np.array_equal(answers["torque"], torque)
    assert np.array_equal(remembered(left, controller), memory, equal_nan=True)
    assert answers["took"].max() / COUNTS < LONGEST
    folder = write(controller, MIXED, tmp_path / "m4")
    here, there = (replay(compile_host(folder), recorded, "f4"), replay(compile_bare(folder, "m4"), recorded, "f4"))
    assert np.array_equal(here[0]["torque"], there[0]["torque"])
    assert here[1] == there[1]
    assert np.abs(here[0]["torque"] - torque).max() < 1e-4


def test_a_start_up_ends_in_the_middle_of_the_cube() -> None:
    machine = placed_machine("apart")
    par = start_up(machine, PERIOD)
    ended = run(machine, par, Fault())
    assert (ended.step, ended.refusal) == (Step.READY, Refusal.NONE)
    book, middle = textbook(machine.design), machine.centre
    angles = ended.memory.start[r.ANGLES : r.ANGLES + 3]
    assert np.abs(book.position(angles, middle) - middle).max() < 1.5e-3
    assert np.ptp(book.angles(middle)) > 0.02  # one angle for all arms would be elsewhere


def test_the_board_starts_up_and_holds_its_spring_there(tmp_path: Path) -> None:
    """The wall of `alone.c`, 2 mm above, holds the handle up against the spring, and neither pulls it aside."""
    machine, folder = placed_machine("close"), tmp_path / "board"
    write_firmware(firmware(machine, 8000.0), folder)
    fine = subprocess.run([compiled(folder, "alone", "delta_run.c"), "9"], capture_output=True, text=True, timeout=120)
    steps = [int(line.split()[2]) for line in fine.stdout.splitlines() if line.startswith("event 1 ")]
    assert (fine.returncode, steps[-1], fine.stderr) == (0, Step.READY, "")
    last = fine.stdout.splitlines()[-1]
    angles = np.array([float(text) for text in re.findall(r"-?\d\.\d{6}", last)])
    x, y, z = textbook(machine.design).position(angles, machine.centre) - machine.centre
    assert np.hypot(x, y) < 0.2e-3 < 0.1 * abs(machine.centre[0])
    assert 1.0e-3 < z < 2.0e-3


def test_the_numbers_of_the_placement_are_in_the_controller() -> None:
    machine = placed_machine("study")
    known = controller_of(machine).model
    assert isinstance(known, Model)
    phi = np.radians(116.3)
    expected = (31.19e-3 - 22.55e-3, 38.45e-3 - 22.55e-3, np.cos(phi), np.sin(phi))
    assert known[:4] == pytest.approx(expected, rel=1e-12)
