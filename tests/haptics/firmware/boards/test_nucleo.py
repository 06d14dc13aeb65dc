"""The port for a NUCLEO-G474RE: compiled for its core, and run on simulated registers with simulated chips behind.

What is simulated are registers and pins as the reference manual has them, encoders byte by byte, drives as voltages:
no timing of the core, and no electrical fault.

25 s of processor: start-ups of nine seconds at 4 kHz, one for each fault, under the sanitizers.
"""

from __future__ import annotations

import os
import re
import shlex
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from delta_cad.design.record import Loop
from haptics.control.startup.record import Step
from haptics.devices.device import Reading, run
from haptics.devices.link import SerialLink
from haptics.devices.remote import RemoteDevice
from haptics.firmware.project import device_files, firmware, write_firmware
from haptics.loop.choice import chosen_loop
from haptics.model.machine import MachineModel
from tests.haptics.firmware.boards.test_drivers import CHIPS
from tests.haptics.firmware.rig import BARE, CORES, FLAGS, tool

PORT = "nucleo-g474re"
DRIVERS = ("drivers/mt6835.c", "drivers/escon.c")
COMMON = (f"{PORT}/board.c", f"{PORT}/serial.c", *DRIVERS, "delta_joints.c", "delta_controller.c")
MAIN = {"alone": "delta_run.c", "linked": "delta_board.c"}
FLASH, RAM = 512 * 1024, 96 * 1024
EVENT = np.dtype([("event", "i4"), ("joint", "i4"), ("value", "f8"), ("bound", "f8")])  # of `hal_report`
STEP, READY, REFUSED, CODE, FAULT = range(1, 6)  # Events of delta_run.h
READY_AT = 9.0  # s; the start-up is over
LINKED_Hz = 1000.0


@pytest.fixture(scope="module")
def folders(machine: MachineModel, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Firmware in single precision for each of its programs."""
    made = {name: tmp_path_factory.mktemp("nucleo") / name for name in MAIN}
    write_firmware(firmware(machine, 4000.0, single=True), made["alone"])
    write_firmware(firmware(machine, LINKED_Hz, single=True), made["linked"])
    return made


@pytest.fixture(scope="module")
def programs(folders: dict[str, Path]) -> dict[str, Path]:
    """The port on simulated registers, under the sanitizers."""
    made = {}
    for name, folder in folders.items():
        parts = (*COMMON, MAIN[name], "simulated/device.c")
        files = [str(folder / part) for part in parts] + [str(CHIPS / "chip.c"), str(CHIPS / "nucleo.c")]
        checked = ("-O1", "-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")
        flags = [*FLAGS, *checked, "-DDELTA_SIMULATED_REGISTERS", f"-I{folder / PORT}", f"-I{CHIPS}"]
        main = str(folder / "main.o")
        compiler = tool("gcc")
        subprocess.run(
            [compiler, *flags, "-Dmain=port_main", "-c", str(folder / PORT / f"{name}.c"), "-o", main], check=True
        )
        made[name] = folder / "simulated-board"
        subprocess.run([compiler, *flags, main, *files, "-o", str(made[name]), "-lm"], check=True)
    return made


@pytest.mark.parametrize("name", MAIN)
def test_it_compiles_for_its_core_and_fits(folders: dict[str, Path], name: str) -> None:
    folder = folders[name]
    image = folder / f"{name}.elf"
    parts = (f"{PORT}/{name}.c", f"{PORT}/start.c", *COMMON, MAIN[name])
    command = [tool("arm-none-eabi-gcc"), *FLAGS, *CORES["m4"][0], f"-T{folder / PORT / 'link.ld'}"]
    subprocess.run([*command, *(str(folder / part) for part in parts), "-o", str(image), *BARE], check=True)
    printed = subprocess.run(["arm-none-eabi-size", image], capture_output=True, text=True, check=True).stdout
    text, data, bss = (int(word) for word in printed.splitlines()[1].split()[:3])
    assert 10_000 < text + data < 0.1 * FLASH
    assert 1_000 < data + bss < 0.1 * RAM
    vectors = subprocess.run(
        ["arm-none-eabi-objcopy", "-O", "binary", "-j", ".text", image, "/dev/stdout"], capture_output=True, check=True
    ).stdout[: 4 * 108]
    stack, reset, *rest = np.frombuffer(vectors, "<u4")
    assert stack == 0x20000000 + RAM
    assert all(0x08000000 <= address < 0x08000000 + FLASH and address % 2 for address in (reset, rest[0], rest[-1]))


def test_it_refuses_walls_that_count_on_drives_that_damp(
    machine: MachineModel, folders: dict[str, Path], tmp_path: Path
) -> None:
    """The ESCON adds no damping: a design whose walls count on it does not compile."""
    damping = machine.design.model_copy(update={"loop": Loop(drive_damping=0.3)})
    figures = device_files(replace(machine, design=damping), chosen_loop(damping, 4000.0))["delta_device.h"]
    shutil.copytree(folders["alone"], tmp_path / "it")
    source = tmp_path / "it" / PORT / "board.c"
    check = [tool("gcc"), "-std=c99", "-fsyntax-only", "-DDELTA_SIMULATED_REGISTERS", f"-I{CHIPS}", str(source)]
    assert subprocess.run(check, capture_output=True).returncode == 0
    (tmp_path / "it" / "delta_device.h").write_text(figures)
    refused = subprocess.run(check, capture_output=True, text=True)
    assert refused.returncode != 0
    assert "adds no damping" in refused.stderr


@pytest.mark.parametrize("name", MAIN)
def test_the_command_of_the_guide_makes_the_image(folders: dict[str, Path], name: str) -> None:
    """As it stands in PORTING.md, and with the two exchanges that it names."""
    folder = folders[name]
    guide = (folder / "PORTING.md").read_text()
    found = re.search(r"^    (arm-none-eabi-gcc (?:.*\\\n)+.*-o nucleo\.elf)$", guide, re.MULTILINE)
    assert found is not None
    words = shlex.split(found[1].replace("\\\n", " "))
    linked = {f"{PORT}/alone.c": f"{PORT}/linked.c", "delta_run.c": "delta_board.c"}
    subprocess.run([linked.get(word, word) if name == "linked" else word for word in words], cwd=folder, check=True)
    assert (folder / "nucleo.elf").read_bytes()[:4] == b"\x7fELF"


def run_alone(program: Path, *words: str) -> tuple[np.ndarray, dict[str, float]]:
    """Events on the serial line, and what the simulation found."""
    done = subprocess.run([program, "alone", *words], capture_output=True, timeout=300)
    assert done.returncode == 0, done.stderr.decode()
    reading, writing = os.pipe()
    os.close(writing)
    link = SerialLink(reading, reading)
    link._take(done.stdout)
    events = np.array([np.frombuffer(one, EVENT)[0] for one in link._coming if len(one) == EVENT.itemsize], EVENT)
    link.close()
    words_found = done.stderr.decode().replace(",", "").split()
    places = {"ended": 1, "ticks": 2, "feeds": 4, "enable": 7, "off_ms": 10}
    return events, {name: float(words_found[place]) for name, place in places.items()}


def test_it_starts_up_and_renders(programs: dict[str, Path]) -> None:
    events, found = run_alone(programs["alone"], str(READY_AT + 0.5))
    assert events["event"][-1] == READY
    assert events["joint"][events["event"] == STEP][-1] == Step.READY
    assert found["enable"] == 1
    assert found["feeds"] >= found["ticks"] - 2  # each tick


FAULTS = ("crc", "weak", "zeros", "ones", "bus", "stuck", "ready", "stop")


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_takes_the_current_and_the_enable_pin(programs: dict[str, Path], fault: str) -> None:
    """Of one encoder, one drive or the button, while the spring holds the handle: within 20 ms, and to the end."""
    events, found = run_alone(programs["alone"], str(READY_AT + 1.0), fault, "1", str(READY_AT + 0.5))
    assert events["event"][-1] == FAULT
    assert found["ended"] == 3  # DELTA_RUN_FAULT
    assert found["enable"] == 0
    assert 0.0 <= found["off_ms"] < 20.0


@pytest.mark.parametrize("fault", ["crystal", "watchdog", "bus"])
def test_it_does_not_start_without_its_hardware_or_after_its_watchdog(programs: dict[str, Path], fault: str) -> None:
    _, found = run_alone(programs["alone"], "1.0", fault, "0", "0.0")
    assert (found["ended"], found["ticks"], found["enable"]) == (1, 0, 0)  # DELTA_RUN_NO_HARDWARE


def test_a_host_drives_it_through_the_serial_line(programs: dict[str, Path]) -> None:
    """Packets both ways; the handle follows the torques; the enable pin is high only while there is a host."""
    process = subprocess.Popen(
        [programs["linked"], "linked", "100"], stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE
    )
    assert process.stdin is not None
    assert process.stdout is not None
    assert process.stderr is not None
    device = RemoteDevice(SerialLink(*(os.dup(one.fileno()) for one in (process.stdout, process.stdin))), timeout=5.0)
    assert device.period == 1.0 / LINKED_Hz

    def wavy(sample: Reading) -> np.ndarray:
        return np.array([0.02, -0.03, 0.06]) * np.cos(100.0 * sample.time)

    recorded = run(device, wavy, ticks=300)
    process.stdin.close()
    process.stdout.close()
    printed = process.stderr.read().decode()
    process.stderr.close()
    assert process.wait(timeout=30) == 0
    assert np.ptp(recorded.angles, axis=0).min() > 1e-4
    assert "enable 0" in printed
