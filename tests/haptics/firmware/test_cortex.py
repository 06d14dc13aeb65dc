"""The controller on bare Cortex-M cores under QEMU: bit for bit the Python tick, and what a tick costs."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from haptics.control.controller import Controller
from haptics.control.supervisor.faults import FaultCode, findings
from haptics.firmware.precision import DOUBLE
from haptics.loop.hardware import board_controller
from haptics.model.machine import MachineModel
from tests.haptics.firmware.rig import (
    COUNTS,
    LAWS,
    TWINS,
    by_python,
    compile_bare,
    compile_host,
    recording,
    remembered,
    replay,
    write,
)

TICKS = 2000


@pytest.fixture(scope="module")
def controller(machine: MachineModel) -> Controller:
    return board_controller(machine, stale=0.1)


def faults(bits: np.ndarray) -> set[FaultCode]:
    return set(findings(int(np.bitwise_or.reduce(bits))))


def test_a_cortex_m7_is_the_python_tick_bit_for_bit(
    machine: MachineModel, controller: Controller, tmp_path: Path
) -> None:
    recorded = recording(machine, TICKS, 9, controller.limits.period)._replace(laws=TWINS)
    bits, torque, memory = by_python(controller, recorded)
    assert len(faults(bits)) >= 6
    assert np.abs(torque - by_python(controller, recorded._replace(laws=LAWS))[1]).max() > 0.01
    assert (np.abs(torque).max(axis=-1) > 0.05).sum() > 300
    folder = write(controller, DOUBLE, tmp_path)
    for program in (compile_host(folder), compile_bare(folder, "m7")):
        answers, left = replay(program, recorded)
        assert np.array_equal(answers["bits"], bits)
        assert np.array_equal(answers["torque"], torque)
        assert np.array_equal(remembered(left, controller), memory, equal_nan=True)
    instructions = answers["took"] / COUNTS
    assert 2000 < np.median(instructions) < 6000
    assert instructions.max() < 7500  # 20 % of 8 kHz at 600 MHz and 2 cycles an instruction


@pytest.mark.slow
def test_a_million_ticks_on_a_cortex_m7(machine: MachineModel, controller: Controller, tmp_path: Path) -> None:
    recorded = recording(machine, 1_000_000, 12, controller.limits.period)
    bits, torque, memory = by_python(controller, recorded)
    answers, left = replay(compile_bare(write(controller, DOUBLE, tmp_path), "m7"), recorded)
    assert np.array_equal(answers["bits"], bits)
    assert np.array_equal(answers["torque"], torque)
    assert np.array_equal(remembered(left, controller), memory, equal_nan=True)
    assert len(faults(bits)) >= 8


@pytest.mark.slow
@pytest.mark.parametrize("flag", ["-O3", "-Os"])
def test_the_compiler_s_zeal_does_not_matter(
    machine: MachineModel, controller: Controller, tmp_path: Path, flag: str
) -> None:
    recorded = recording(machine, TICKS, 7, controller.limits.period)
    answers, _ = replay(compile_bare(write(controller, DOUBLE, tmp_path), "m7", flags=(flag,)), recorded)
    assert np.array_equal(answers["torque"], by_python(controller, recorded)[1])


@pytest.mark.slow
def test_a_cortex_m4_computes_doubles_by_software_to_the_same_bits(
    machine: MachineModel, controller: Controller, tmp_path: Path
) -> None:
    recorded = recording(machine, TICKS, 7, controller.limits.period)
    answers, _ = replay(compile_bare(write(controller, DOUBLE, tmp_path), "m4"), recorded)
    assert np.array_equal(answers["torque"], by_python(controller, recorded)[1])
    assert np.median(answers["took"] / COUNTS) > 40_000  # so single precision is what an M4 needs
