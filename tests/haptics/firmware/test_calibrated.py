"""The C controller of one made device: bit for bit the Python tick behind its calibration, in both precisions."""

from __future__ import annotations

import json
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from delta_cad.design import Design, design_hash
from haptics.calibration.record import Calibration, save_calibration, to_dict
from haptics.calibration.unknowns import ZERO, Unknowns
from haptics.commands.cli import main
from haptics.control.controller import Controller
from haptics.control.correction import Correction, correction
from haptics.control.startup.record import Step
from haptics.control.supervisor.faults import FaultCode
from haptics.firmware.precision import DOUBLE, MIXED
from haptics.firmware.project import firmware, write_firmware
from haptics.loop.hardware import board_controller
from haptics.model.machine import MachineModel
from tests.committed import BEST, Built
from tests.haptics.calibration.devices import made
from tests.haptics.firmware.rig import (
    COUNTS,
    EMPTY,
    TWINS,
    Recorded,
    by_python,
    compile_bare,
    compile_host,
    recording,
    remembered,
    replay,
    write,
)
from tests.haptics.firmware.test_ports import CHECKED, compiled


@pytest.fixture(scope="module")
def controller(machine: MachineModel) -> Controller:
    return board_controller(machine, stale=0.1)


@pytest.fixture(scope="module")
def device(best: Design) -> Unknowns:
    return made(best, np.random.default_rng(4), 4.8)


@pytest.fixture(scope="module")
def known(machine: MachineModel, device: Unknowns) -> Correction:
    return correction(machine.geometry, device)


@pytest.fixture(scope="module")
def recorded(machine: MachineModel, controller: Controller) -> Recorded:
    return recording(machine, 2000, 7, controller.limits.period)


def test_this_machine_and_a_cortex_m7_are_python_bit_for_bit(
    controller: Controller, known: Correction, recorded: Recorded, tmp_path: Path
) -> None:
    bits, torque, memory = by_python(controller, recorded, known)
    plain = by_python(controller, recorded)[1]
    assert (np.abs(torque).max(axis=-1) > 0.05).sum() > 300
    assert np.abs(torque - plain).max() > 1e-3  # the calibration matters
    assert np.abs(torque).max() <= controller.limits.torque
    assert np.bitwise_or.reduce(bits) & FaultCode.ANGLE_INVALID.bit
    folder = write(controller, DOUBLE, tmp_path, known)
    for program in (compile_host(folder, *CHECKED), compile_bare(folder, "m7")):
        answers, left = replay(program, recorded)
        assert np.array_equal(answers["bits"], bits)
        assert np.array_equal(answers["torque"], torque)
        assert np.array_equal(remembered(left, controller), memory, equal_nan=True)


def test_its_longest_tick_is_a_fifth_of_the_period(machine: MachineModel, known: Correction, tmp_path: Path) -> None:
    """Of an empty energy tank, which is searched for what it allows: 20 % of 8 kHz at 600 MHz, 2 cycles each."""
    controller = board_controller(machine, stale=0.1, **EMPTY)
    recorded = recording(machine, 6000, 12, controller.limits.period)._replace(laws=TWINS)
    bits, torque, memory = by_python(controller, recorded, known)
    assert np.bitwise_or.reduce(bits) & FaultCode.ENERGY_LIMITED.bit
    answers, left = replay(compile_bare(write(controller, DOUBLE, tmp_path, known), "m7"), recorded)
    assert np.array_equal(answers["bits"], bits)
    assert np.array_equal(answers["torque"], torque)
    assert np.array_equal(remembered(left, controller), memory, equal_nan=True)
    assert answers["took"].max() / COUNTS < 7500


def test_singles_are_near_and_a_cortex_m4_has_the_same_bits(
    controller: Controller, known: Correction, recorded: Recorded, tmp_path: Path
) -> None:
    bits, torque, _ = by_python(controller, recorded, known)
    folder = write(controller, MIXED, tmp_path, known)
    here, left = replay(compile_host(folder, "-Wdouble-promotion"), recorded, "f4")
    there, also = replay(compile_bare(folder, "m4"), recorded, "f4")
    assert np.array_equal(here["bits"], bits)
    assert np.abs(here["torque"] - torque).max() < 1e-4  # as without a calibration
    assert np.array_equal(here["torque"], there["torque"])
    assert left == also


@pytest.mark.parametrize("single", [False, True])
def test_a_board_with_a_calibration_starts_up(
    machine: MachineModel, device: Unknowns, tmp_path: Path, single: bool
) -> None:
    """The simulated device is as drawn, so its zeros stay: lengths and waves are what a small calibration has."""
    table = device.table.copy()
    table[:, ZERO] = 0.0
    folder = tmp_path / "board"
    write_firmware(firmware(machine, 8000.0, single=single, known=replace(device, table=table)), folder)
    fine = subprocess.run([compiled(folder, "alone", "delta_run.c"), "9"], capture_output=True, text=True, timeout=120)
    steps = [int(line.split()[2]) for line in fine.stdout.splitlines() if line.startswith("event 1 ")]
    assert (fine.returncode, steps[-1], fine.stderr) == (0, Step.READY, "")


def test_the_command_takes_the_file_of_this_design_alone(
    best: Design, built: Built, device: Unknowns, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, folder = tmp_path / "calibration.json", tmp_path / "board"
    calibration = Calibration(best.name, design_hash(best), device, np.zeros((3, 11)), (), {})
    save_calibration(calibration, path)
    command = ["firmware", "--design", str(BEST), "--mass-properties", str(built.folder / "mass_properties.json"),
               "--out", str(folder), "--calibration", str(path)]  # fmt: skip
    assert main(command) == 0
    assert repr(float(device.mechanism.upper_arm_length[1])) in (folder / "delta_controller.c").read_text()
    path.write_text(json.dumps({**to_dict(calibration), "design_sha256": "0" * 64}))
    capsys.readouterr()
    assert main(command) == 2
    reported = capsys.readouterr().err
    assert reported.count("\n") == 1
    assert "design_sha256" in reported
