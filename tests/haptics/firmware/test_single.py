"""Single precision where it does no harm: the error against doubles, and the three things that must lose nothing."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from haptics.control.controller import Controller, fresh
from haptics.control.pose import HOLDING, ROWS, pose
from haptics.control.supervisor import memory as m
from haptics.control.supervisor.faults import FaultCode
from haptics.firmware.precision import MIXED
from haptics.loop.choice import at_rate
from haptics.loop.hardware import board_controller
from haptics.model.machine import MachineModel
from tests.haptics.firmware.rig import (
    COUNTS,
    EMPTY,
    ENABLED,
    NOTHING,
    TWINS,
    WAS_RESET,
    Recorded,
    by_python,
    compile_bare,
    compile_host,
    memory_type,
    recording,
    replay,
    write,
)
from tests.haptics.scene_machine import WITHOUT_NOISE

RATE_Hz = 4000.0


@pytest.fixture(scope="module")
def controller(machine: MachineModel) -> Controller:
    return board_controller(machine, at_rate(RATE_Hz), stale=0.1, **WITHOUT_NOISE)


@pytest.fixture(scope="module")
def folder(controller: Controller, tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write(controller, MIXED, tmp_path_factory.mktemp("single"))


@pytest.fixture(scope="module")
def program(folder: Path) -> Path:
    return compile_host(folder, "-Wdouble-promotion")


@pytest.mark.parametrize("faults", [False, True])
def test_torques_are_those_of_doubles_to_a_bound(
    machine: MachineModel, controller: Controller, program: Path, faults: bool
) -> None:
    recorded = recording(machine, 6000, 7, controller.limits.period, faults)
    bits, torque, _ = by_python(controller, recorded)
    answers, _ = replay(program, recorded, "f4")
    assert np.array_equal(answers["bits"], bits)
    error = np.abs(answers["torque"] - torque).max(axis=-1)
    assert np.abs(torque).max() > 0.2
    assert error.max() < 1e-4  # N m of 0.8: at the handle 1.5 mN
    assert np.median(error) < 1e-5
    assert error.max() > 1e-9  # it is not double


def most_given_J(controller: Controller, recorded: Recorded, torque: np.ndarray) -> float:
    """The most energy that rendered torques gave the joints over any window, by the angles before they were rounded."""
    theta, work, holding = recorded.readings["theta"], np.zeros((ROWS, 3)), np.zeros_like(torque)
    for k, at in enumerate(theta):
        pose(controller.model, np.ascontiguousarray(at), work)
        holding[k] = work[HOLDING]
    given = ((torque - holding)[:-1] * np.diff(theta, axis=0)).sum(axis=1)[600:]  # gravity has come in by then
    level = np.concatenate([[0.0], np.cumsum(given)])
    return float((level - np.minimum.accumulate(level)).max())


@pytest.mark.parametrize("seed", [1, 6, 8])
def test_an_empty_tank_keeps_its_promise_where_it_decides_otherwise_than_in_doubles(
    machine: MachineModel, seed: int, tmp_path: Path
) -> None:
    empty = board_controller(machine, at_rate(RATE_Hz), stale=0.1, **EMPTY)
    recorded = recording(machine, 6000, seed, empty.limits.period, faults=False)._replace(laws=TWINS)
    bits, torque, _ = by_python(empty, recorded)
    answers = replay(compile_host(write(empty, MIXED, tmp_path)), recorded, "f4")[0]
    single = answers["torque"].astype(float)
    error = np.abs(single - torque).max(axis=-1)
    assert error.max() > 1e-4  # else the case below is none
    # An empty tank has two stable answers, a force withheld and a force given back: rounding may choose, nothing else.
    assert np.all(bits[error > 1e-4] & answers["bits"][error > 1e-4] & FaultCode.ENERGY_LIMITED.bit)
    for one in (torque, single):
        assert 0.9 * EMPTY["energy"] < most_given_J(empty, recorded, one) < EMPTY["energy"]


def test_a_cortex_m4_is_this_machine_bit_for_bit_and_keeps_4_khz(
    machine: MachineModel, controller: Controller, folder: Path, program: Path, tmp_path: Path
) -> None:
    recorded = recording(machine, 1500, 8, controller.limits.period)._replace(laws=TWINS)
    here, left = replay(program, recorded, "f4")
    there, also = replay(compile_bare(folder, "m4"), recorded, "f4")
    for field in ("bits", "torque"):
        assert np.array_equal(here[field], there[field])
    assert left == also
    empty = board_controller(machine, at_rate(RATE_Hz), stale=0.1, **EMPTY)
    spent, _ = replay(compile_bare(write(empty, MIXED, tmp_path), "m4"), recorded, "f4")
    assert np.any(spent["bits"] & FaultCode.ENERGY_LIMITED.bit)
    worst = (spent["took"] / COUNTS).max()
    assert (there["took"] / COUNTS).max() < worst
    assert 5000 < worst < 0.5 * 168e6 / RATE_Hz / 1.5  # 1.5 cycles an instruction are assumed


def test_a_clock_that_has_run_for_months_misses_no_deadline(
    machine: MachineModel, controller: Controller, program: Path
) -> None:
    recorded = recording(machine, 1200, 3, controller.limits.period, faults=False)
    recorded.readings["now"] += 1e7
    bits, torque, _ = by_python(controller, recorded)
    answers, _ = replay(program, recorded, "f4")
    late = FaultCode.TICK_LATE.bit | FaultCode.DEADLINE_MISSED.bit | FaultCode.CLOCK_INVALID.bit
    assert not np.any((bits | answers["bits"]) & late)
    assert np.abs(answers["torque"] - torque).max() < 1e-4
    recorded.readings["now"][900:] += 0.3 * controller.limits.late  # a tick that is late is found, too
    assert np.array_equal(by_python(controller, recorded)[0], replay(program, recorded, "f4")[0]["bits"])


def test_every_fault_keeps_its_bit(machine: MachineModel, controller: Controller, program: Path) -> None:
    recorded = recording(machine, 900, 3, controller.limits.period, faults=False)
    readings = recorded.readings
    readings["theta"][700, 0] = np.nan  # in the same tick the smallest code and the largest
    readings["signal"][700] = FaultCode.EMERGENCY_STOP.bit
    readings["request"][600:] = NOTHING
    answers, _ = replay(program, recorded, "f4")
    both = FaultCode.EMERGENCY_STOP.bit | FaultCode.ANGLE_INVALID.bit
    assert answers["bits"][700] & both == both
    assert answers["bits"][-1] & both == both  # latched
    assert np.array_equal(answers["bits"], by_python(controller, recorded)[0])


def test_motors_warm_as_in_doubles(machine: MachineModel, controller: Controller, program: Path) -> None:
    """Minutes of load, of which a tick warms the housing by 1e-8 of its temperature."""
    recorded = recording(machine, 240_000, 8, controller.limits.period, faults=False)
    recorded.readings["request"][2000:][np.isin(recorded.readings["request"][2000:], (WAS_RESET, ENABLED))] = NOTHING
    recorded.readings["request"][::100] = 4
    bits, torque, memory = by_python(controller, recorded)
    answers, left = replay(program, recorded, "f4")
    assert np.square(torque).mean() > 1e-3
    warm = np.frombuffer(left, memory_type(controller, MIXED))[0]["supervisor"]
    supervisor = memory[fresh(controller).filters.size :][: m.MEMORY]
    ambient = controller.limits.motor.ambient
    for name, place in (("WINDING", m.WINDING), ("HOUSING", m.HOUSING)):
        rise = supervisor[place : place + 3] - ambient
        assert rise.min() > 1e-4
        np.testing.assert_allclose(warm[name.lower()] - ambient, rise, rtol=1e-4)
    assert warm["ticks"] == len(torque)
    # Where the tank holds a torque back, its search by halves goes to 2^-12 of what is wanted: a level that is rounded
    # otherwise moves the torque by a step of that, and the next level with it. Everywhere else the bound is the same as
    # above, at touch-downs with 0.5 m/s too, where the damping comes in within 0.02 mm.
    assert not np.any((answers["bits"] ^ bits) & ~FaultCode.ENERGY_LIMITED.bit)
    short = (answers["bits"] | bits) & FaultCode.ENERGY_LIMITED.bit != 0  # said a tick after the torque
    limited = short | np.append(short[1:], False)
    assert 0 < limited.sum() < 1e-3 * len(limited)
    error = np.abs(answers["torque"] - torque).max(axis=-1)
    assert error[~limited].max() < 1e-4
    assert error[limited].max() > 2.0**-12 * 0.5 * np.abs(torque).max()  # else the case above is none
    given = most_given_J(controller, recorded, answers["torque"].astype(float))
    assert given < controller.limits.energy
