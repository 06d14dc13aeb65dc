"""The drivers of encoder and servo drive against simulated chips: what is good is taken, what is not is not fresh."""

from __future__ import annotations

import ctypes
import math
import subprocess
from enum import IntEnum
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest

from haptics.firmware.ports import files_of_ports
from tests.haptics.firmware.rig import FLAGS, tool

CHIPS = Path(__file__).parent / "chips"
COUNTS = 2**21
OVERSPEED, WEAK_FIELD, UNDERVOLTAGE = 1, 2, 4  # Bits of STATUS, data sheet 7.6.8
VOLT_PER_A, LIMIT_A = 0.22, 7.5


class Finding(IntEnum):
    """`mt6835_finding`."""

    FRESH = 0
    NO_TRANSFER = 1
    DEAD_LINE = 2
    WRONG_CRC = 3
    WARNING = 4
    OLD = 5
    STUCK = 6


class Chip(ctypes.Structure):
    """`chip` of the simulation."""

    _fields_ = (
        ("angle", ctypes.c_uint32),
        ("status", ctypes.c_uint),
        ("flips", ctypes.c_uint32),
        ("line", ctypes.c_int),
        ("registers", ctypes.c_ubyte * 0x20),
        ("latched", ctypes.c_uint32),
        ("latched_status", ctypes.c_uint),
        ("unread", ctypes.c_int),
        ("bytes", ctypes.c_int),
        ("command", ctypes.c_uint),
        ("address", ctypes.c_uint),
    )


class Driver(ctypes.Structure):
    """`mt6835`."""

    _fields_ = (
        ("count", ctypes.c_uint32),
        ("status", ctypes.c_uint),
        ("same", ctypes.c_int),
        ("broken", ctypes.c_int),
        ("found", ctypes.c_uint32 * 7),
    )


class Escon(ctypes.Structure):
    """`escon`."""

    _fields_ = (("enabled", ctypes.c_int), ("not_ready", ctypes.c_int * 3))


@pytest.fixture(scope="module")
def library(tmp_path_factory: pytest.TempPathFactory) -> ctypes.CDLL:
    folder = tmp_path_factory.mktemp("drivers")
    for name, text in files_of_ports().items():
        if name.startswith("drivers/"):
            (folder / Path(name).name).write_text(text)
    sources = [str(folder / "mt6835.c"), str(folder / "escon.c"), str(CHIPS / "chip.c"), str(CHIPS / "wires.c")]
    command = [tool("gcc"), *FLAGS, f"-I{folder}", f"-I{CHIPS}", "-fPIC", "-shared", *sources]
    subprocess.run([*command, "-o", str(folder / "drivers.so")], check=True)
    loaded = ctypes.CDLL(str(folder / "drivers.so"))
    loaded.mt6835_rad.restype, loaded.mt6835_rad.argtypes = ctypes.c_double, [ctypes.c_uint32]
    loaded.escon_current.argtypes = [ctypes.c_void_p, ctypes.c_int, ctypes.c_double]
    return loaded


class Bench:
    """One joint's encoder and its driver."""

    def __init__(self, library: ctypes.CDLL, joint: int = 1) -> None:
        self.library, self.joint, self.driver = library, joint, Driver()
        self.chip = (Chip * 3).in_dll(library, "chips")[joint]
        self.breaks = (ctypes.c_int * 3).in_dll(library, "breaks_off_at")
        library.chip_reset(ctypes.byref(self.chip))
        self.breaks[joint] = -1
        self.chip.angle = 5
        assert library.mt6835_begin(ctypes.byref(self.driver), joint, 3) == 0
        assert self.read(6) is Finding.OLD  # of the registers' accesses
        assert self.driver.count == 5

    def read(self, angle: int | None = None) -> Finding:
        """One reading, at an angle in counts."""
        if angle is not None:
            self.chip.angle = angle
        return Finding(self.library.mt6835_read(ctypes.byref(self.driver), self.joint))


@pytest.fixture
def bench(library: ctypes.CDLL) -> Bench:
    return Bench(library)


def test_all_21_bits_are_read(bench: Bench) -> None:
    """Each bit alone, both ends, and angles at random; sixteen bits would lose the lower five."""
    rng = np.random.default_rng(5)
    for angle in [*(1 << bit for bit in range(21)), COUNTS - 1, *rng.integers(1, COUNTS, 500)]:
        assert bench.read(int(angle)) is Finding.FRESH
        assert bench.driver.count == angle
        turned = bench.library.mt6835_rad(bench.driver.count)
        assert -math.pi < turned <= math.pi
        assert math.remainder(turned - 2.0 * math.pi * angle / COUNTS, 2.0 * math.pi) == pytest.approx(0.0, abs=1e-15)


def test_the_bandwidth_is_written_and_the_maker_s_bits_stay(bench: Bench) -> None:
    assert bench.chip.registers[0x011] == 0xA3  # 0xA5 with BW = 3
    bench.chip.line = 1
    assert bench.library.mt6835_begin(ctypes.byref(bench.driver), bench.joint, 3) != 0  # nothing answers
    bench.chip.line, bench.breaks[bench.joint] = -1, 1
    assert bench.library.mt6835_begin(ctypes.byref(bench.driver), bench.joint, 3) != 0


def test_every_wrong_bit_of_a_frame_is_found(bench: Bench) -> None:
    """One, two and three wrong bits of its 32, all 5,488 of them; of random ones one in 256 is not."""
    assert bench.read(1_234_567) is Finding.FRESH
    wrong = [sum(1 << bit for bit in bits) for many in (1, 2, 3) for bits in combinations(range(32), many)]
    for flips in wrong:
        bench.chip.flips = flips
        assert bench.read(1_300_000) is Finding.WRONG_CRC
        assert bench.driver.count == 1_234_567  # what is wrong is not taken
    assert bench.driver.found[Finding.WRONG_CRC] == len(wrong) == 5488
    missed = 0
    for flips in np.random.default_rng(3).integers(1, 2**32, 20_000):
        bench.chip.flips = int(flips)
        missed += bench.read(1_300_000) not in (Finding.WRONG_CRC, Finding.DEAD_LINE)
    assert missed == pytest.approx(20_000 / 256, rel=0.35)  # three standard deviations
    bench.chip.flips = 0
    assert bench.read(1_234_568) is Finding.FRESH


@pytest.mark.parametrize("status", range(1, 8))
def test_a_warning_is_not_fresh(bench: Bench, status: int) -> None:
    bench.chip.status = status
    assert bench.read(77) is Finding.WARNING
    assert bench.driver.status == status
    bench.chip.status = 0
    assert bench.read(78) is Finding.FRESH


@pytest.mark.parametrize("line", [0, 1])
def test_a_dead_line_is_not_the_angle_zero(bench: Bench, line: int) -> None:
    """Zeros have a good CRC: they are refused as such, and the angle 0 itself is left out for a reading."""
    bench.chip.line = line
    assert bench.read(99) is Finding.DEAD_LINE
    bench.chip.line = -1
    assert bench.read(100) is Finding.FRESH
    assert bench.read(0) is Finding.DEAD_LINE


def test_after_a_reading_that_was_broken_off_the_next_is_old(bench: Bench) -> None:
    """The chip keeps its latch until it is read out: the frame after is of then, and has a good CRC."""
    assert bench.read(1000) is Finding.FRESH
    bench.breaks[bench.joint] = 4
    assert bench.read(2000) is Finding.NO_TRANSFER
    bench.breaks[bench.joint] = -1
    assert bench.read(3000) is Finding.OLD
    assert bench.driver.count == 2000
    assert bench.read(4000) is Finding.FRESH
    assert bench.driver.count == 4000


def test_a_value_that_stays_is_stuck_until_it_changes(bench: Bench) -> None:
    found = [bench.read(555) for _ in range(40)]
    assert found[:25] == [Finding.FRESH] * 25
    assert set(found[25:]) == {Finding.STUCK}
    assert bench.read(556) is Finding.FRESH


def test_the_noise_of_the_sheet_is_never_called_stuck(bench: Bench) -> None:
    """0.0015 deg rms with BW = 5, half with BW = 3: at rest, a quarter of a million readings."""
    counts = 0.5 * 0.0015 / 360.0 * COUNTS
    rng = np.random.default_rng(8)
    for angle in np.round(1_000_000 + counts * rng.standard_normal(250_000)).astype(int):
        assert bench.read(int(angle)) is Finding.FRESH


class Drives:
    """The three drives and their wires."""

    def __init__(self, library: ctypes.CDLL) -> None:
        self.library, self.state = library, Escon()
        self.set_value = (ctypes.c_double * 3).in_dll(library, "set_value")
        self.enabled = ctypes.c_int.in_dll(library, "enabled")
        self.ready = (ctypes.c_int * 3).in_dll(library, "ready")
        self.ready[:] = [1, 1, 1]
        library.escon_begin(ctypes.byref(self.state))

    def enable(self, on: bool) -> None:
        self.library.escon_enable(ctypes.byref(self.state), int(on))

    def current(self, joint: int, ampere: float) -> float:
        """The voltage that it makes."""
        self.library.escon_current(ctypes.byref(self.state), joint, ampere)
        return self.set_value[joint]

    def healthy(self) -> bool:
        return bool(self.library.escon_healthy(ctypes.byref(self.state)))


@pytest.fixture
def drives(library: ctypes.CDLL) -> Drives:
    return Drives(library)


def test_a_current_becomes_a_voltage_within_the_limit(drives: Drives) -> None:
    assert (list(drives.set_value), drives.enabled.value) == ([0.0] * 3, 0)
    assert drives.current(0, 2.0) == 0.0  # not enabled
    drives.enable(True)
    assert drives.enabled.value == 1
    for ampere in (0.0, 2.0, -3.5, 7.5):
        assert drives.current(2, ampere) == pytest.approx(VOLT_PER_A * ampere)
    for ampere, given in ((9.0, LIMIT_A), (-99.0, -LIMIT_A), (math.nan, 0.0), (math.inf, LIMIT_A)):
        assert drives.current(1, ampere) == pytest.approx(VOLT_PER_A * given)
    drives.enable(False)
    assert (list(drives.set_value), drives.enabled.value) == ([0.0] * 3, 0)


@pytest.mark.parametrize("joint", range(3))
def test_one_drive_that_is_not_ready_takes_all_out_until_it_is_enabled_again(drives: Drives, joint: int) -> None:
    drives.enable(True)
    drives.current(0, 1.0)
    drives.ready[joint] = 0
    assert [drives.healthy() for _ in range(4)] == [True, True, False, False]  # two readings are put down to noise
    assert (list(drives.set_value), drives.enabled.value) == ([0.0] * 3, 0)
    drives.ready[joint] = 1
    assert not drives.healthy()
    assert drives.current(0, 1.0) == 0.0
    drives.enable(True)
    assert drives.healthy()
    assert drives.current(0, 1.0) == pytest.approx(VOLT_PER_A)


def test_a_ready_line_that_flickers_is_no_fault(drives: Drives) -> None:
    drives.enable(True)
    for k in range(30):
        drives.ready[0] = k % 3 == 0
        assert drives.healthy()
