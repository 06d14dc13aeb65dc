"""The start-up in C: tick for tick the Python one, on a device as it should be and on one that is refused."""

from __future__ import annotations

import ctypes
import math
import subprocess
from pathlib import Path

import numpy as np
import pytest

from haptics.control.startup import record as r
from haptics.control.startup.record import ABOUT, Refusal, Step
from haptics.control.supervisor.faults import FaultCode
from haptics.firmware.generate import sources
from haptics.firmware.memories import START
from haptics.firmware.precision import DOUBLE, MIXED, Precision
from haptics.loop.choice import at_rate
from haptics.loop.hardware import board_controller, real_plant
from haptics.loop.start_up import start_up
from haptics.model.machine import MachineModel
from tests.haptics.control.startup.planted import LONGEST, PERIOD, Ended, Fault, Held, lying, run, scaled
from tests.haptics.firmware.rig import FLAGS, tool

FRESH = (ctypes.c_int * 3)(1, 1, 1)


class Refused(ctypes.Structure):
    """`delta_refusal`."""

    _fields_ = (("code", ctypes.c_int), ("joint", ctypes.c_int), ("value", ctypes.c_double), ("bound", ctypes.c_double))


def library(machine: MachineModel, folder: Path, precision: Precision, absolute: bool) -> ctypes.CDLL:
    controller = board_controller(machine, at_rate(1.0 / PERIOD), stale=0.1)
    files = sources(controller, "x", precision, start_up(machine, PERIOD, absolute=absolute))
    for name, text in files.items():
        (folder / name).write_text(text, encoding="utf-8")
    reported = ("-fPIC", "-shared", str(folder / "delta_controller.c"), "-o", str(folder / "x.so"), "-lm")
    subprocess.run([tool("gcc"), *FLAGS, *reported], check=True)
    loaded = ctypes.CDLL(str(folder / "x.so"))
    loaded.delta_startup_tick.restype = ctypes.c_longlong
    loaded.delta_startup_tick.argtypes = [
        ctypes.c_void_p, ctypes.c_double, ctypes.c_void_p, ctypes.c_void_p, ctypes.c_void_p,
    ]  # fmt: skip
    loaded.delta_startup_signal.argtypes = [ctypes.c_void_p, ctypes.c_longlong]
    loaded.delta_startup_refusal.restype = Refused
    return loaded


def replayed(loaded: ctypes.CDLL, ended: Ended, real: type) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Torques, bits and memory of the C start-up on the readings of a Python one."""
    memory, out = np.zeros(4096, np.uint8), np.zeros(3, real)
    loaded.delta_startup_begin(memory.ctypes.data_as(ctypes.c_void_p))
    torques, bits = [], []
    for row, signal in zip(ended.readings, ended.signals, strict=True):
        loaded.delta_startup_signal(memory.ctypes.data, int(signal))
        theta = row[1:].astype(real)
        bits.append(loaded.delta_startup_tick(memory.ctypes.data, row[0], theta.ctypes.data, FRESH, out.ctypes.data))
        torques.append(out.copy())
    return np.array(torques), np.array(bits), memory


CASES = {
    "ready": (Fault(read=lambda theta, _: theta + np.array([0.4, -2.0, 7.0])), False),
    "a torque constant": (Fault(drive=scaled(1, 2.2)), True),
    "silence": (Fault(read=Held(0, 2.0, math.nan)), True),
    "stop": (Fault(signal=lambda t: FaultCode.EMERGENCY_STOP.bit * (t > 1.0)), True),
}


def test_it_is_the_python_one_tick_for_tick(machine: MachineModel, tmp_path: Path) -> None:
    libraries = {}
    for absolute in (False, True):
        folder = tmp_path / str(absolute)
        folder.mkdir()
        libraries[absolute] = library(machine, folder, DOUBLE, absolute)
    for name, (fault, absolute) in CASES.items():
        ended = run(machine, start_up(machine, PERIOD, absolute=absolute), fault)
        loaded = libraries[absolute]
        torques, bits, memory = replayed(loaded, ended, np.float64)
        assert np.array_equal(bits, ended.bits), name
        assert np.array_equal(torques, ended.torques), name
        place = memory.ctypes.data_as(ctypes.c_void_p)
        assert loaded.delta_startup_step(place) == ended.step
        refused, offset = loaded.delta_startup_refusal(place), np.zeros(3)
        assert (refused.code, refused.joint) == (ended.refusal, ended.joint)
        assert (refused.value, refused.bound) == tuple(ended.memory.start[[r.VALUE, r.BOUND]])
        loaded.delta_startup_offsets(place, offset.ctypes.data_as(ctypes.c_void_p))
        assert np.array_equal(offset, ended.memory.start[r.OFFSET : r.OFFSET + 3])


@pytest.mark.slow
def test_single_precision_finds_the_same(machine: MachineModel, tmp_path: Path) -> None:
    loaded, par = library(machine, tmp_path, MIXED, False), start_up(machine, PERIOD, absolute=False)
    ended = run(machine, par, Fault())
    device = lying(machine, par, real_plant(machine))
    memory, out, off = np.zeros(4096, np.uint8), np.zeros(3, np.float32), np.array([0.4, -2.0, 1.0])
    place = memory.ctypes.data_as(ctypes.c_void_p)
    loaded.delta_startup_begin(place)
    zeroed_at, zero = 0.0, np.zeros(3)  # the reading that ends the first step is that of the stops
    while device.time < LONGEST and loaded.delta_startup_step(place) < Step.READY:
        sample = device.read()
        theta = (sample.angles + off).astype(np.float32)
        if loaded.delta_startup_step(place) == Step.SETTLE:
            zeroed_at, zero = sample.time, theta.astype(float)
        loaded.delta_startup_tick(memory.ctypes.data, sample.time, theta.ctypes.data, FRESH, out.ctypes.data)
        device.write(out.astype(float))
    assert loaded.delta_startup_step(place) == Step.READY == ended.step
    reported, known = memory[: START.dtype(MIXED).itemsize].view(START.dtype(MIXED))[0], ended.memory.start
    # a step may end a tick sooner or later, a fortieth of a pulse
    assert reported["gains"] == pytest.approx(known[r.GAINS : r.GAINS + 3], abs=0.05)
    # and then takes another reading, with other noise, for the zeros: each is held to the reading that it took
    assert reported["offset"] == pytest.approx(par.stop_low - zero, abs=1e-6)
    taken = np.isclose(ended.readings[:, 1:], par.stop_low - known[r.OFFSET : r.OFFSET + 3], rtol=0.0, atol=1e-12)
    assert zeroed_at == pytest.approx(ended.readings[np.argmax(taken.all(axis=1)), 0], abs=1.5 * PERIOD)
    assert taken.all(axis=1).any()


def test_header_and_guide_name_every_step_and_refusal(machine: MachineModel) -> None:
    files = sources(board_controller(machine), "x", DOUBLE, start_up(machine, PERIOD))
    for step in Step:
        assert f"    DELTA_STARTUP_{step.name} = {int(step)}" in files["delta_controller.h"]
    for refusal in Refusal:
        assert f"    DELTA_REFUSED_{refusal.name} = {int(refusal)}" in files["delta_controller.h"]
    for refusal in set(Refusal) - {Refusal.NONE}:
        assert f"| {int(refusal)} {refusal.name} | {ABOUT[refusal][0]} |" in files["README.md"]
