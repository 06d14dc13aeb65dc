"""What the tests of the firmware share: compilers and their flags, recordings for `replay.c`, QEMU, and the tick."""

from __future__ import annotations

import shutil
import subprocess
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from delta_cad.common.jit import compiled
from delta_cad.mechanism import inverse_kinematics
from haptics.control.controller import Controller, fresh, tick
from haptics.control.correction import COLUMNS as COLUMNS_MADE
from haptics.control.correction import DRAWN, ROWS, Correction, correct, turned
from haptics.control.supervisor.memory import DISABLE, ENABLE, HEARD, NOW, REQUEST, RESET, SIGNALS
from haptics.control.supervisor.supervisor import ALL_FRESH
from haptics.firmware.generate import sources
from haptics.firmware.memories import SUPERVISOR
from haptics.firmware.ports import files_of_ports
from haptics.firmware.precision import DOUBLE, Precision
from haptics.model.machine import MachineModel
from haptics.rendering import law_table
from haptics.rendering.laws.constant_force import ConstantForce
from haptics.rendering.laws.home import Home
from haptics.rendering.laws.operating_resistance import PAPER_SETTINGS
from haptics.rendering.laws.spring import SpringDamper
from haptics.rendering.laws.virtual_wall import axis_wall
from haptics.rendering.registry import COLUMNS
from haptics.rendering.registry import LAWS as REGISTRY

WARNINGS = ("-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wfloat-equal", "-Werror")
FLAGS = ("-std=c99", "-O2", "-ffp-contract=off", *WARNINGS)
BARE = ("-mthumb", "-mfloat-abi=hard", "-ffreestanding", "-nostartfiles", "-lm", "-lc", "-lgcc")
# Core -> its flags, and QEMU's board with it.
CORES = {
    "m7": (("-mcpu=cortex-m7", "-mfpu=fpv5-d16"), "mps2-an500"),
    "m4": (("-mcpu=cortex-m4", "-mfpu=fpv4-sp-d16"), "mps2-an386"),
}
COUNTS = 25.6  # of SysTick an instruction, at 25 MHz under `-icount shift=10`
EMPTY = {"energy": 2e-3, "energy_start": 2e-3, "energy_time": 10.0}  # Limits with which the tank is soon empty
AS_DRAWN = Correction(*6 * (0.0,), 1.0, np.zeros((3, COLUMNS_MADE)))
NOTHING, ENABLED, DISABLED, WAS_RESET, SPOKEN = range(5)
HOME = np.array([0.0, 0.0, 0.0946])
LAWS = law_table(
    replace(PAPER_SETTINGS["k0.4"], origin=HOME, damping=20.0),
    SpringDamper(stiffness=50.0, damping=1.0, point=HOME),
    ConstantForce([0.1, -0.2, 0.3]),
    Home(stiffness=100.0, damping=2.0, speed=0.2, origin=HOME),
    axis_wall("+x", 0.005, stiffness=1e5, damping=3.0),
    np.array([[kind, 0.5, *(1e-3 * (k + 1) for k in range(COLUMNS - 2))] for kind in REGISTRY]),  # every law there is
)

TWINS = law_table(LAWS, axis_wall("+x", 0.004, stiffness=1e5, damping=3.0))  # two walls at once, held down together


class Recorded(NamedTuple):
    """A recording and what came of it.

    Attributes:
        readings: Structured: now, theta, request, signal.
        laws: Table of laws.
    """

    readings: np.ndarray
    laws: np.ndarray


def tool(name: str) -> str:
    """Path of a program that `make` installs."""
    path = shutil.which(name)
    assert path is not None, f"{name} is needed; scripts/system_libraries.sh installs it"
    return path


def reading_type(real: Any) -> np.dtype:
    """`reading` of `replay.c`."""
    parts = [("now", "f8"), ("theta", real, 3), ("request", "i4"), ("signal", "u4"), ("fresh", "u4")]
    return np.dtype(parts, align=True)


def answer_type(real: Any) -> np.dtype:
    """`answer` of `replay.c`."""
    return np.dtype([("bits", "i8"), ("torque", real, 3), ("took", "u4")], align=True)


def recording(machine: MachineModel, ticks: int, seed: int, period: float, faults: bool = True) -> Recorded:
    """A handle that wanders through the cube, read in counts; an operator, a host, and now and then something wrong.

    Args:
        machine: The device.
        ticks: Their number.
        seed: Of the way.
        period: Of the tick, s.
        faults: Whether readings jump or are no numbers, ticks come late, and the emergency stop is pressed.
    """
    rng = np.random.default_rng(seed)
    knots = rng.uniform(-1.0, 1.0, (ticks // 400 + 3, 3)) * 0.97 * machine.half_side
    at = np.arange(ticks) / 400.0
    p = np.stack([np.interp(at, np.arange(len(knots)), knots[:, k]) for k in range(3)], axis=-1)
    window = np.hanning(201) / np.hanning(201).sum()
    p = np.stack([np.convolve(np.pad(p[:, k], 100, mode="edge"), window, "valid") for k in range(3)], axis=-1)
    theta = inverse_kinematics(machine.geometry, machine.centre + p)
    count = 2.0 * np.pi / 2**18
    result = np.zeros(ticks, reading_type("f8"))
    now = np.cumsum(np.full(ticks, period))
    theta = np.round(theta / count) * count
    request = np.full(ticks, SPOKEN)
    request[300::1500], request[1::1500], request[2::1500] = NOTHING, WAS_RESET, ENABLED
    if faults:
        request[1200::3000] = DISABLED
        for k in rng.integers(ticks // 3, ticks, max(ticks // 900, 4)):
            theta[k, rng.integers(3)] = rng.choice([np.nan, np.inf, 3.0, -9.0, 1e30])
        for k in rng.integers(ticks // 3, ticks, max(ticks // 900, 4)):
            now[k:] += rng.choice([0.0, -period, 2.0 * period, 0.05])
        for k in rng.integers(ticks // 3, ticks, max(ticks // 4000, 2)):
            result["signal"][k : k + 3] = 1 << int(rng.choice([23, 24, 25]))
            request[k : k + 700] = NOTHING
    result["fresh"] = ALL_FRESH
    if faults:
        for k in rng.integers(ticks // 3, ticks, max(ticks // 900, 4)):
            result["fresh"][k : k + rng.integers(1, 5)] = rng.integers(0, ALL_FRESH)
    result["now"], result["theta"], result["request"] = now, theta, request
    return Recorded(result, LAWS)


@compiled
def _run(controller, known, memory, laws, now, theta, request, signal, fresh, torque, bits):
    supervisor, made = memory.supervisor, np.zeros((ROWS, 3))
    out = np.zeros(3)
    for k in range(now.shape[0]):
        required = request[k]
        if required == ENABLED:
            supervisor[REQUEST] = ENABLE
        elif required == DISABLED:
            supervisor[REQUEST] = DISABLE
        elif required == WAS_RESET:
            supervisor[REQUEST] = RESET
        elif required == SPOKEN:
            supervisor[HEARD] = min(now[k], supervisor[NOW])
        supervisor[SIGNALS] = float(signal[k])
        if known.forearm_length > 0.0:
            correct(known, theta[k], made)
            bits[k] = tick(controller, memory, laws, now[k], made[DRAWN], theta[k], fresh[k], out)
            turned(made, out, controller.limits.torque, torque[k])
        else:
            bits[k] = tick(controller, memory, laws, now[k], theta[k], theta[k], fresh[k], out)
            torque[k, :] = out


def by_python(
    controller: Controller, recorded: Recorded, known: Correction = AS_DRAWN
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Bits, torques and the memory at the end, by the compiled Python tick."""
    r, memory = recorded.readings, fresh(controller)
    torque, bits = np.zeros((len(r), 3)), np.zeros(len(r), np.int64)
    columns = [np.ascontiguousarray(r[name]) for name in ("now", "theta", "request", "signal")]
    columns.append(r["fresh"].astype(np.int64))
    _run(controller, known, memory, recorded.laws, *columns, torque, bits)
    return bits, torque, np.concatenate([memory.filters.ravel(), memory.supervisor, memory.work.ravel()])


def memory_type(controller: Controller, precision: Precision = DOUBLE) -> np.dtype:
    """`delta_memory` of a controller."""
    memory, real = fresh(controller), "f4" if precision.single else "f8"
    parts = [
        ("filters", real, memory.filters.shape),
        ("supervisor", SUPERVISOR.dtype(precision)),
        ("work", real, memory.work.shape),
    ]
    return np.dtype(parts, align=True)


def flat(memory: np.ndarray) -> np.ndarray:
    """A C memory in the order of Python's: filters, supervisor, work."""
    supervisor = [np.ravel(memory["supervisor"][one.c_name]).astype(float) for one in SUPERVISOR.members.values()]
    return np.concatenate([memory["filters"].ravel(), *supervisor, memory["work"].ravel()]).astype(float)


def remembered(left: bytes, controller: Controller) -> np.ndarray:
    """What a replay in doubles remembers, in the order of Python's memory."""
    return flat(np.frombuffer(left, memory_type(controller))[0])


@cache
def generated(controller: Controller, precision: Precision) -> dict[str, str]:
    """All files of a controller, ports included."""
    return {**sources(controller, "under-test", precision), **files_of_ports()}


def write(controller: Controller, precision: Precision, folder: Path, known: Correction | None = None) -> Path:
    """Writes all files of a controller, perhaps for one made device, into a folder that is made."""
    made = {} if known is None else sources(controller, "under-test", precision, known=known)
    for name, text in {**generated(controller, precision), **made}.items():
        path = folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
    return folder


def compile_host(folder: Path, *flags: str, compiler: str = "gcc") -> Path:
    """The replay for this machine."""
    program = folder / f"replay-{compiler}"
    parts = [str(folder / name) for name in ("replay.c", "delta_controller.c")]
    command = [tool(compiler), *FLAGS, *flags, f"-I{folder}", *parts, "-o", str(program), "-lm"]
    subprocess.run(command, check=True)
    return program


def compile_bare(folder: Path, core: str, *parts: Path, flags: tuple[str, ...] = ()) -> Path:
    """The replay for a bare core, or another image of other parts."""
    program, bare = folder / f"{core}.elf", folder / "cortex-m"
    replays = (folder / "replay.c", folder / "delta_controller.c", bare / "start.c", bare / "semihosting.c")
    command = [
        tool("arm-none-eabi-gcc"),
        *FLAGS,
        *flags,
        *CORES[core][0],
        f"-T{bare / 'link.ld'}",
        f"-I{folder}",
        f"-I{bare}",
    ]
    subprocess.run([*command, *map(str, parts or replays), "-o", str(program), *BARE], check=True)
    return program


def emulate(program: Path) -> int:
    """Runs a core's image under QEMU in its folder; the exit code."""
    command = (
        *(tool("qemu-system-arm"), "-M", CORES[program.stem][1], "-nographic", "-monitor", "none", "-serial", "none"),
        *("-semihosting-config", "enable=on,target=native", "-icount", "shift=10", "-kernel", str(program)),
    )
    return subprocess.run(command, cwd=program.parent, timeout=600, stdin=subprocess.DEVNULL).returncode


def replay(program: Path, recorded: Recorded, real: str = "f8") -> tuple[np.ndarray, bytes]:
    """Answers and memory of a replay, on this machine or, for a core's image, under QEMU.

    Args:
        program: Of `compile_host` or `compile_bare`.
        recorded: What is replayed.
        real: "f8" or "f4", the reals of the program.
    """
    folder = program.parent
    readings = recorded.readings.astype(reading_type(real))
    head = np.array([len(readings), len(recorded.laws)], np.uint32)
    (folder / "replay.in").write_bytes(head.tobytes() + recorded.laws.astype(real).tobytes() + readings.tobytes())
    bare = program.suffix == ".elf"
    ended = emulate(program) if bare else subprocess.run([program], cwd=folder, timeout=600).returncode
    assert ended == 0
    reported, kind = (folder / "replay.out").read_bytes(), answer_type(real)
    end = len(readings) * kind.itemsize
    return np.frombuffer(reported[:end], kind), reported[end:]
