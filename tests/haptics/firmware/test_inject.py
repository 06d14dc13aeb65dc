"""A hardware layer that fails: each function once, late, repeating or for good, at start-up and while it renders."""

from __future__ import annotations

import subprocess
from pathlib import Path
from typing import NamedTuple

import pytest

from delta_cad.design import Design
from haptics.control.startup.record import Refusal, Step
from haptics.control.supervisor.faults import FaultCode, findings
from haptics.firmware.project import firmware, write_firmware
from haptics.loop.choice import at_rate
from haptics.loop.hardware import sensor_limits
from tests.committed import ROOT
from tests.haptics.firmware.rig import FLAGS, tool
from tests.haptics.scene_machine import scene_machine

RATE_Hz = 8000.0
DONE, NO_HARDWARE, REFUSED, FAULT = range(4)  # How delta_run ends
FOR_GOOD = 10**9
WRAPPED = ("begin", "wait", "now", "encoders", "current", "enable", "damping", "healthy", "stop_pressed", "watchdog")
GONE_s = 0.025  # The weight's torque along its slew, after what pushes
LOWERED_s = 1.01


class Ended(NamedTuple):
    """How it ended: code, whether the power stage is on, at which tick, and what was found."""

    code: int
    powered: int
    tick: int
    found: tuple[FaultCode, ...]
    refusal: int


@pytest.fixture(scope="module")
def program(best: Design, tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("inject") / "board"
    write_firmware(firmware(scene_machine(best), RATE_Hz), folder)
    renamed = [f"-Dhal_{name}=sound_hal_{name}" for name in WRAPPED]
    flags = [*FLAGS, f"-I{folder}"]
    part = folder / "sound.o"
    source = str(folder / "simulated" / "hal_simulated.c")
    subprocess.run([tool("gcc"), *flags, *renamed, "-c", source, "-o", str(part)], check=True)
    parts = ["simulated/device.c", "delta_run.c", "delta_joints.c", "delta_controller.c"]
    made = folder / "inject"
    sources = [str(Path(__file__).with_name("inject.c")), *(str(folder / one) for one in parts), str(part)]
    subprocess.run([tool("gcc"), *flags, *sources, "-o", str(made), "-lm"], check=True)
    return made


def ran(program: Path, kind: str, begin: int, many: int) -> Ended:
    run = subprocess.run([program, kind, str(begin), str(many)], capture_output=True, text=True, check=True, cwd=ROOT)
    lines = [line.split() for line in run.stdout.splitlines()]
    bits = [int(float(line[3])) for line in lines if line[:2] == ["event", "5"]]
    codes = [int(line[2]) for line in lines if line[:2] == ["event", "4"]]
    _, code, powered, tick, fed, largest = lines[-1]
    assert float(largest) > 0.0 or int(code) == NO_HARDWARE
    assert int(fed) >= int(tick) - 1  # a sign of life in every period, and none after the last
    return Ended(int(code), int(powered), int(tick), findings(bits[0]) if bits else (), codes[0] if codes else 0)


@pytest.fixture(scope="module")
def ready(program: Path) -> int:
    """Tick at which a sound device is ready."""
    run = subprocess.run([program], capture_output=True, text=True, check=True)
    steps = [line.split() for line in run.stdout.splitlines() if line.startswith("step ")]
    assert steps[-1][1] == str(int(Step.READY))
    assert run.stdout.splitlines()[-1].startswith("ended 0 0 80000 ")
    return int(steps[-1][2])


LATE = (FaultCode.DEADLINE_MISSED, LOWERED_s)
STALE, REPEATED = (FaultCode.ANGLE_STALE, GONE_s), (FaultCode.ANGLE_REPEATED, GONE_s)
# What fails, for how many ticks: the fault that stops it and the time within which all torque is gone, s; None goes on.
WHILE_RENDERING: dict[tuple[str, int], tuple[FaultCode, float] | None] = {
    ("wait late", 1): LATE,
    ("wait repeats", 1): (FaultCode.CLOCK_INVALID, LOWERED_s),
    ("now none", 1): (FaultCode.CLOCK_INVALID, LOWERED_s),
    ("now ahead", 1): LATE,
    ("encoders no bus", 2): None,
    ("encoders no bus", 3): STALE,
    ("encoders not fresh", FOR_GOOD): STALE,
    ("encoders none", 1): (FaultCode.ANGLE_INVALID, GONE_s),
    ("encoders repeat", FOR_GOOD): REPEATED,
    ("encoder repeats", FOR_GOOD): REPEATED,
    ("healthy", 1): (FaultCode.WATCHDOG, GONE_s),
    ("stop", 1): (FaultCode.EMERGENCY_STOP, GONE_s),
    ("now repeats", 1): (FaultCode.CLOCK_INVALID, LOWERED_s),
    ("now late", 1): (FaultCode.CLOCK_INVALID, LOWERED_s),
    ("encoders no bus", 1): None,
    ("encoders not fresh", 2): None,
    ("encoders late", FOR_GOOD): STALE,
    ("encoders repeat", 3): None,
    ("encoder repeats", 10): None,
    ("current lost", 1): None,
}


@pytest.mark.quick(12)
@pytest.mark.parametrize(("kind", "many"), WHILE_RENDERING)
def test_a_function_that_fails_while_force_is_rendered(program: Path, ready: int, kind: str, many: int) -> None:
    expected, begin = WHILE_RENDERING[kind, many], ready + round(0.9 * RATE_Hz)
    ended = ran(program, kind, begin, many)
    assert not ended.powered
    if expected is None:
        assert (ended.code, ended.found) == (DONE, ())
        return
    code, within = expected
    assert ended.code == FAULT
    assert code in ended.found
    assert (ended.tick - begin) / RATE_Hz <= within


UNDER_START_UP = ("wait late", "wait repeats", "now none", "encoders no bus", "encoders repeat", "healthy", "stop")


@pytest.mark.quick(3)
@pytest.mark.parametrize("kind", UNDER_START_UP)
def test_a_function_that_fails_under_the_start_up_refuses_it(program: Path, ready: int, kind: str) -> None:
    begin = round(0.4 * ready)
    ended = ran(program, kind, begin, 20)
    assert (ended.code, ended.powered, ended.refusal) == (REFUSED, 0, int(Refusal.SUPERVISOR))
    assert (ended.tick - begin) / RATE_Hz <= 0.2


def test_the_header_has_the_limits_of_readings(best: Design, program: Path) -> None:
    header = (program.parent / "delta_controller.h").read_text()
    found = {line.split()[1]: line.split()[2] for line in header.splitlines() if len(line.split()) > 2}
    limits = sensor_limits(scene_machine(best), at_rate(RATE_Hz))
    assert (found["DELTA_REPEATS"], found["DELTA_ALL_REPEAT"]) == (
        f"{limits['repeats']:g}",
        f"{limits['all_repeat']:g}",
    )
    assert found["DELTA_UNREAD"] == "2"


def test_hardware_that_does_not_answer_is_never_switched_on(program: Path) -> None:
    ended = ran(program, "begin", 0, 1)
    assert (ended.code, ended.powered, ended.tick) == (NO_HARDWARE, 0, 0)
