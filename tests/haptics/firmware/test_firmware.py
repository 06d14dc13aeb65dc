"""The C controller: compiled, and double for double the Python tick over good and bad readings."""

from __future__ import annotations

import ctypes
import math
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numba import float64, int64, typeof

from delta_cad.common import jit
from delta_cad.mechanism import inverse_kinematics
from haptics.commands.cli import main
from haptics.control.controller import TOUCHED, Controller, fresh, tick
from haptics.control.pose import POSITION
from haptics.control.supervisor.faults import EXTERNAL, FaultCode, State, findings
from haptics.control.supervisor.memory import ENABLE, REQUEST, RESET
from haptics.control.supervisor.supervisor import ALL_FRESH
from haptics.control.wall_cap import capped_force
from haptics.devices.device import Reading
from haptics.devices.host import Host
from haptics.firmware.expressions import TranslationError
from haptics.firmware.generate import _translated, sources
from haptics.firmware.layout import LayoutError, c_type
from haptics.firmware.literals import literal
from haptics.firmware.precision import DOUBLE, MIXED, Precision
from haptics.firmware.project import write_firmware
from haptics.firmware.translate import Translation
from haptics.loop.assumptions import default_controller
from haptics.loop.hardware import board_controller
from haptics.model.machine import MachineModel
from haptics.rendering import law_table
from haptics.rendering.laws.virtual_wall import axis_wall
from haptics.rendering.registry import COLUMNS, layout
from haptics.rendering.registry import LAWS as REGISTRY
from tests.committed import BEST, Built
from tests.haptics.firmware.rig import (
    FLAGS,
    HOME,
    LAWS,
    by_python,
    compile_host,
    flat,
    memory_type,
    recording,
    remembered,
    replay,
    tool,
    write,
)


def compiled(controller: Controller, folder: Path, *macros: str) -> Any:
    """The C controller as a library; warnings are errors."""
    write_firmware(sources(controller, "under-test"), folder)
    library, code = folder.with_suffix(".so"), folder / "delta_controller.c"
    shared = ("-fPIC", "-shared", *macros, str(code), "-o", str(library), "-lm")
    subprocess.run([tool("gcc"), *FLAGS, *shared], check=True)
    loaded = ctypes.CDLL(str(library))
    double = ctypes.POINTER(ctypes.c_double)
    loaded.delta_tick.restype = ctypes.c_longlong
    out = (double, double, ctypes.c_void_p, double)
    loaded.delta_tick.argtypes = [double, double, ctypes.c_long, ctypes.c_double, *out]
    loaded.delta_signal.argtypes = [double, ctypes.c_longlong]
    loaded.delta_heard.argtypes = [double, ctypes.c_double]
    return loaded


FRESH_BUT = 5  # all but joint 1


def pointer(array: Any) -> Any:
    return np.asarray(array).ctypes.data_as(ctypes.POINTER(ctypes.c_double))


def c_tick(library: Any, memory: np.ndarray, now: float, theta: np.ndarray, fresh: int, out: np.ndarray) -> int:
    """One tick in C, of a device without calibration."""
    flags, angles = (ctypes.c_int * 3)(*(fresh >> joint & 1 for joint in range(3))), pointer(theta)
    return library.delta_tick(pointer(memory), pointer(LAWS), len(LAWS), now, angles, angles, flags, pointer(out))


def readings(machine: MachineModel, ticks: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Times and angles of a handle that wanders, with jumps, numbers that are none, and late ticks in between."""
    rng = np.random.default_rng(seed)
    way = np.cumsum(rng.normal(0.0, 1.0, (ticks, 3)), axis=0)
    way -= np.linspace(0.0, 1.0, ticks)[:, None] * way[-1]
    p = HOME + 0.035 * way / np.abs(way).max()
    theta = inverse_kinematics(machine.geometry, p)
    count = 2.0 * np.pi / 16384
    theta = np.round(theta / count) * count
    time = np.cumsum(np.full(ticks, 1e-3))
    for k in rng.integers(ticks // 3, ticks, 12):
        theta[k, rng.integers(3)] = rng.choice([np.nan, np.inf, 3.0, -9.0])
        time[k:] += rng.choice([0.0, 2e-3, 0.05])
    return time, theta


def test_it_is_the_python_tick_double_for_double(machine: MachineModel, tmp_path: Path) -> None:
    controller = default_controller(machine, joint_speed=60.0)
    library = compiled(controller, tmp_path / "controller")
    own = fresh(controller)
    theirs = np.frombuffer(bytearray(b"\x07" * memory_type(controller).itemsize), memory_type(controller))[0]
    library.delta_start(pointer(theirs))
    assert np.array_equal(flat(theirs), np.concatenate([own.filters.ravel(), own.supervisor, own.work.ravel()]))
    time, theta = readings(machine, 6000, 4)
    theta = np.ascontiguousarray(theta)
    out, c_out = np.zeros(3), np.zeros(3)
    seen, rendered, met, let_go = 0, 0, 0, 0
    for k in range(len(time)):
        if k % 500 == 0:  # the operator tries again and again
            request = RESET if k % 1000 else ENABLE
            own.supervisor[REQUEST] = request
            (library.delta_reset if request == RESET else library.delta_enable)(pointer(theirs))
        # two ticks are left out, four are too many
        held = FRESH_BUT if k % 750 in (7, 8) or k % 3000 > 2995 else ALL_FRESH
        bits = tick(controller, own, LAWS, time[k], theta[k], theta[k], held, out)
        c_bits = c_tick(library, theirs, time[k], theta[k], held, c_out)
        assert bits == c_bits, f"tick {k}"
        assert np.array_equal(out, c_out), f"tick {k}"
        seen |= bits
        rendered += bool(np.abs(out).max() > 0.06)
        assert library.delta_touched(pointer(theirs)) == own.work[TOUCHED], f"tick {k}"
        met += int(own.work[TOUCHED])
        inside = capped_force(controller.walls, own.work, LAWS, *own.work[POSITION], 0.0, 0.0, 0.0)[3]
        off = library.delta_state(pointer(theirs)) in (State.DISABLED, State.FAULT)
        assert library.delta_touched(pointer(theirs)) == (0.0 if off else inside), f"tick {k}"
        let_go += off and inside
    left = np.concatenate([own.filters.ravel(), own.supervisor, own.work.ravel()])
    assert np.array_equal(flat(theirs), left, equal_nan=True)
    assert seen.bit_count() >= 5  # the run met faults
    assert rendered > 500  # and rendered force
    assert 500 < met < 5500  # of a wall, too
    assert let_go >= 5  # and was inside it without force


class Twins:
    """The host in Python and the C controller, told the same; the handle trembles at its home, and ticks must agree."""

    def __init__(self, machine: MachineModel, folder: Path, stale: float = math.inf, *macros: str) -> None:
        controller = default_controller(machine, stale=stale)
        given = default_controller(machine, stale=math.inf) if macros else controller
        self.library = compiled(given, folder / "controller", *macros)
        self.host, self.now = Host(controller, LAWS), 0.0
        self.memory = np.zeros(1, memory_type(controller))[0]
        self.library.delta_start(pointer(self.memory))
        self.theta = inverse_kinematics(machine.geometry, HOME)

    def press(self, button: str) -> None:
        """enable, disable or reset on both."""
        getattr(self.host, button)()
        getattr(self.library, f"delta_{button}")(pointer(self.memory))

    def signal(self, bits: int) -> None:
        """To C; the host has it from the sample."""
        self.flags = bits
        self.library.delta_signal(pointer(self.memory), bits)

    flags = 0

    def tick(self, ticks: int = 1) -> np.ndarray:
        """Some ticks; the last torques."""
        out = np.full(3, np.nan)
        for _ in range(ticks):
            self.now += 1e-3
            theta = self.theta + 4e-4 * math.sin(60.0 * self.now)
            own = self.host(Reading(theta, self.now, self.flags))
            bits = c_tick(self.library, self.memory, self.now, theta, ALL_FRESH, out)
            assert bits == self.host.bits
            assert np.array_equal(out, own)
            own = self.host.memory
            assert np.array_equal(flat(self.memory)[own.filters.size : -own.work.size], own.supervisor)
        return out

    @property
    def latched(self) -> int:
        """In C."""
        return int(self.memory["supervisor"]["latched"])


@pytest.mark.parametrize("fault", findings(EXTERNAL))
def test_what_comes_from_outside_latches_in_c_as_in_python(
    machine: MachineModel, tmp_path: Path, fault: FaultCode
) -> None:
    twins = Twins(machine, tmp_path)
    twins.signal(fault.bit)  # while nothing is enabled, only the emergency stop latches
    twins.tick()
    assert twins.latched == (fault.bit if fault is FaultCode.EMERGENCY_STOP else 0)
    twins.signal(0)
    twins.press("reset")
    twins.tick()
    twins.press("enable")
    torque = twins.tick(700)
    assert np.abs(torque).max() > 0.02
    twins.signal(fault.bit)
    assert np.abs(twins.tick()).max() > 0.0  # along the slew
    assert twins.latched == fault.bit == 1 << int(fault)
    twins.signal(0)
    assert not np.any(twins.tick(60))
    assert twins.latched == fault.bit  # released, and yet latched
    twins.press("reset")
    twins.tick()
    assert twins.latched == 0
    twins.press("enable")
    assert np.abs(twins.tick(700)).max() > 0.02


def test_other_bits_cannot_be_signalled_in_c(machine: MachineModel, tmp_path: Path) -> None:
    twins = Twins(machine, tmp_path)
    twins.signal(-1)
    assert twins.memory["supervisor"]["signals"] == EXTERNAL
    twins.signal(~EXTERNAL)
    assert twins.memory["supervisor"]["signals"] == 0


@pytest.mark.parametrize("macros", [(), ("-DDELTA_STALE_S=0.1",)], ids=["from the design", "by the macro"])
def test_a_host_that_falls_silent_is_noticed_in_c(
    machine: MachineModel, tmp_path: Path, macros: tuple[str, ...]
) -> None:
    twins = Twins(machine, tmp_path, 0.1, *macros)
    stale = FaultCode.COMMAND_STALE.bit
    twins.press("enable")
    twins.tick(100)
    assert not twins.host.bits & stale
    twins.tick(2)
    assert twins.host.bits & stale
    twins.host.heard()
    twins.library.delta_heard(pointer(twins.memory), twins.now + 7.0)  # from the future: as the last tick
    twins.tick(99)
    assert not twins.host.bits & stale
    for wrong in (math.nan, math.inf):
        twins.library.delta_heard(pointer(twins.memory), wrong)
    twins.tick(3)
    assert twins.host.bits & stale
    twins.library.delta_heard(pointer(twins.memory), twins.now - 0.05)
    assert twins.memory["supervisor"]["heard"] == twins.now - 0.05


def test_without_the_macro_silence_is_never_noticed(machine: MachineModel, tmp_path: Path) -> None:
    twins = Twins(machine, tmp_path)
    twins.press("enable")
    twins.tick(700)
    assert not twins.host.bits & FaultCode.COMMAND_STALE.bit
    assert "#define DELTA_STALE_S INFINITY" in (tmp_path / "controller" / "delta_controller.c").read_text()
    limited = sources(default_controller(machine, stale=0.25), "limited")
    assert "#define DELTA_STALE_S 0.25" in limited["delta_controller.c"]


def test_header_and_guide_have_what_can_be_raised(machine: MachineModel) -> None:
    files = sources(default_controller(machine), "a")
    _, table = files["README.md"].split("| bit | found |")
    rows = [line.split(" | ") for line in table.splitlines() if line.startswith("| ") and line[2].isdigit()]
    by = {int(row[0].strip("| ")): row[2] for row in rows}
    assert set(by) == {int(fault) for fault in FaultCode} - {FaultCode.ORDER}  # a tick keeps its own order
    assert {code for code, text in by.items() if "delta_signal" in text} == {int(f) for f in findings(EXTERNAL)}
    assert by[int(FaultCode.COMMAND_STALE)] == "`delta_tick`, `DELTA_STALE_S` finite"
    for fault in findings(EXTERNAL):
        assert f"#define DELTA_{fault.name} (1LL << {int(fault)})" in files["delta_controller.h"]


def test_header_names_every_law_and_its_columns(machine: MachineModel) -> None:
    header = sources(default_controller(machine), "a")["delta_controller.h"]
    lines = (line.split() for line in header.splitlines() if line.startswith("#define DELTA_"))
    named = {words[1]: words[2] for words in lines if len(words) > 2 and words[2].isdigit()}
    assert int(named["DELTA_LAW_COLUMNS"]) == COLUMNS == LAWS.shape[1]
    wall = axis_wall("-z", 0.25, stiffness=7.0, damping=3.0, blend=2e-3)
    row = law_table(wall)[0]
    assert row[int(named["DELTA_LAW_KIND"])] == int(named["DELTA_VIRTUAL_WALL"])
    assert row[int(named["DELTA_LAW_GAIN"])] == 1.0
    for field, value in (("STIFFNESS", 7.0), ("DAMPING", 3.0), ("BLEND", 2e-3)):
        assert row[int(named[f"DELTA_VIRTUAL_WALL_{field}"])] == value
    point, normal = (int(named[f"DELTA_VIRTUAL_WALL_{field}"]) for field in ("POINT", "NORMAL"))
    assert row[point : point + 3].tolist() == [0.0, 0.0, 0.25]
    assert row[normal : normal + 3].tolist() == [0.0, 0.0, 1.0]


def test_the_columns_of_a_law_do_not_overlap() -> None:
    for law in REGISTRY.values():
        places = [first + k for _, first, width, _ in layout(law) for k in range(width)]
        assert places == list(range(2, 2 + len(places)))


@pytest.mark.slow
def test_what_is_written_does_not_depend_on_the_day(machine: MachineModel) -> None:
    controller = default_controller(machine)
    written = sources(controller, "a")
    _translated.cache_clear()
    assert written == sources(controller, "a")
    assert "malloc" not in written["delta_controller.c"]


@pytest.mark.quick(2)
@pytest.mark.parametrize(
    ("compiler", "precision"),
    [("clang", DOUBLE), ("gcc", MIXED), ("gcc", DOUBLE), ("clang", MIXED)],
    ids=["clang-double", "gcc-single", "gcc-double", "clang-single"],
)
def test_it_is_clean_under_both_compilers_and_sanitizers(
    machine: MachineModel, tmp_path: Path, compiler: str, precision: Precision
) -> None:
    controller = board_controller(machine, stale=0.1)
    folder = write(controller, precision, tmp_path)
    checked = ("-O1", "-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")
    program = compile_host(folder, *checked, compiler=compiler)
    recorded = recording(machine, 3000, 9, controller.limits.period)
    bits, torque, _ = by_python(controller, recorded)
    answers, _ = replay(program, recorded, "f4" if precision.single else "f8")
    assert np.array_equal(answers["bits"], bits)
    assert np.abs(answers["torque"] - torque).max() <= (1e-4 if precision.single else 0.0)


PARTS = ("-funsafe-math-optimizations", "-freciprocal-math", "-fno-signed-zeros")
"""Of fast-math, each of which changes results and no NaN; gcc tells of them, clang does not."""


@pytest.mark.parametrize(
    ("compiler", "flag"),
    [*(("gcc", flag) for flag in ("-ffast-math", "-Ofast", "-ffinite-math-only", *PARTS)), ("clang", "-ffast-math"),
     ("clang", "-ffinite-math-only")],
)  # fmt: skip
def test_fast_math_is_refused(machine: MachineModel, tmp_path: Path, compiler: str, flag: str) -> None:
    folder = write(board_controller(machine, stale=0.1), DOUBLE, tmp_path)
    (folder / "delta_device.h").write_text("#define DELTA_AMPERE_PER_N_M 1.0\n")
    parts = ("delta_controller.c",) if flag in PARTS else ("delta_controller.c", "delta_joints.c", "delta_board.c")
    for part in parts:
        command = [tool(compiler), "-std=c99", flag, "-c", part, "-o", "x.o"]
        refused = subprocess.run(command, cwd=folder, capture_output=True, text=True)
        assert refused.returncode != 0, part
        assert "fast-math" in refused.stderr


def test_clang_keeps_the_order_of_operations_whatever_it_may(machine: MachineModel, tmp_path: Path) -> None:
    """It has no word for a part of fast-math; the source forbids what that would allow."""
    controller = board_controller(machine, stale=0.1)
    recorded = recording(machine, 2000, 9, controller.limits.period)
    program = compile_host(write(controller, DOUBLE, tmp_path), "-fassociative-math", "-fno-signed-zeros",
                           "-fno-trapping-math", compiler="clang")  # fmt: skip
    assert np.array_equal(replay(program, recorded)[0]["torque"], by_python(controller, recorded)[1])


@pytest.mark.slow
def test_a_million_ticks_with_faults_are_the_python_ones(machine: MachineModel, tmp_path: Path) -> None:
    controller = board_controller(machine, stale=0.1)
    recorded = recording(machine, 1_000_000, 11, controller.limits.period)
    answers, left = replay(compile_host(write(controller, DOUBLE, tmp_path)), recorded)
    bits, torque, memory = by_python(controller, recorded)
    assert np.array_equal(answers["bits"], bits)
    assert np.array_equal(answers["torque"], torque)
    assert np.array_equal(remembered(left, controller), memory, equal_nan=True)
    assert int(np.bitwise_or.reduce(bits)).bit_count() >= 10


def test_numbers_read_back_to_the_last_bit() -> None:
    for value in (0.1, -1e-300, 1.0 / 3.0, 5e-324, 3.0):
        assert float(literal(value).strip("()")) == value
    assert (literal(math.inf), literal(-math.inf), literal(math.nan)) == ("INFINITY", "(-INFINITY)", "NAN")
    assert literal(3) == "3LL"


@jit.compiled
def _power(x):
    return x**4


@jit.compiled
def _named(x):
    return max(x, 2.0) + sum((x, x))


@jit.compiled
def _with_else(x):
    for _ in range(3):
        x += 1.0
    else:
        x += 2.0
    return x


@jit.compiled
def _slice(a):
    return a[1:][0]


@jit.compiled
def _chosen(x):
    a, b = divmod(x, 2.0) if x > 0.0 else (x, x)
    return a + b


@pytest.mark.parametrize("function", [_power, _named, _with_else, _chosen])
def test_what_has_no_translation_is_refused_with_its_line(function: Any) -> None:
    with pytest.raises(TranslationError, match=rf"{__name__}\.{function.py_func.__name__}, line \d+"):
        Translation().add(function, (float64,))


def test_slices_need_their_end() -> None:
    with pytest.raises(TranslationError, match=r"line \d+"):
        Translation().add(_slice, (typeof(np.zeros(3)),))


def test_types_without_a_counterpart_are_refused() -> None:
    assert c_type(int64) == "long long"
    with pytest.raises(LayoutError):
        c_type(typeof("text"))


def test_the_command_writes_the_files(built: Built, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    masses, folder = built.folder / "mass_properties.json", tmp_path / "board"
    command = ["firmware", "--design", str(BEST), "--mass-properties", str(masses), "--out", str(folder)]
    assert main(command) == 0
    assert "#define DELTA_PERIOD_S 0.000125\n" in (folder / "delta_controller.h").read_text()
    assert main([*command, "--rate", "1000", "--json"]) == 0  # again: replaced
    assert "#define DELTA_PERIOD_S 0.001\n" in (folder / "delta_controller.h").read_text()
    assert {"README.md", "PORTING.md", "delta_controller.c", "delta_hal.h", "posix"} <= {
        p.name for p in folder.iterdir()
    }
    assert main([*command, "--single", "--stale", "0.05", "--home"]) == 0
    code = (folder / "delta_controller.c").read_text()
    assert "typedef float delta_real;" in (folder / "delta_controller.h").read_text()
    assert "#define DELTA_STALE_S 0.05\n" in code
    assert ".absolute = 0.0f," in code
    (folder / "mine.txt").write_text("keep")
    assert main(command) == 2
    assert "holds mine.txt, which no run wrote here" in capsys.readouterr().err
    assert (folder / "mine.txt").read_text() == "keep"
    assert sorted(path.name for path in tmp_path.iterdir()) == ["board"]
    assert main(["firmware", "--design", "none.json", "--out", str(folder)]) == 2
