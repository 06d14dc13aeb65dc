"""The board in C and the one in Python, side by side: the same datagrams, the same answers, the same torques.

Scripts are drawn: two hosts, sessions that are sent again, packets that are torn, repeated, out of order, made up or of
another version, silence, an emergency stop, readings that are not fresh. Nothing in one may be other than in the other,
and neither may drive a joint by more than its limit, nor after its watchdog.
"""

from __future__ import annotations

import ctypes
import subprocess
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from haptics.devices.board import Board
from haptics.devices.device import Reading
from haptics.devices.protocol import (
    RESET_WATCHDOG,
    STOP_PRESSED,
    WALL_TOUCHED,
    WATCHDOG_TRIPPED,
    Packet,
    PacketKind,
    decode,
    encode,
)
from haptics.firmware.ports import files_of_ports
from tests.haptics.firmware.rig import FLAGS, tool

PERIOD, LIMIT, COUNTS, WATCHDOG = 1e-3, 0.8, 4096, 5e-3
FREE, TOUCHED = 0.25, 0.75
PEERS = (b"\1" * 32, b"\2" * 32)
DEVICE = f"""
#ifndef DELTA_DEVICE_H
#define DELTA_DEVICE_H
#define DELTA_AMPERE_PER_N_M 1.0
#define DELTA_DAMPING {FREE}
#define DELTA_CONTACT_DAMPING {TOUCHED}
#endif
"""
CONTROLLER = """
#ifndef DELTA_CONTROLLER_H
#define DELTA_CONTROLLER_H
typedef double delta_real;
#define DELTA_EMERGENCY_STOP 1LL
#define DELTA_WATCHDOG 2LL
#endif
"""


class Motors:
    """The device under the Python board."""

    def __init__(self) -> None:
        self.angles, self.fresh, self.time, self.torque, self.touched = np.zeros(3), 7, 0.0, np.zeros(3), False

    def read(self) -> Reading:
        return Reading(self.angles, self.time, 0, self.fresh)

    def write(self, torques: Any) -> None:
        self.torque = np.array(torques, dtype=float)

    def touch(self, touched: bool) -> None:
        self.touched = touched

    def close(self) -> None: ...


@pytest.fixture(scope="module")
def built(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("board")
    files = {name: text for name, text in files_of_ports().items() if name.startswith("delta_")}
    for name, text in (files | {"delta_device.h": DEVICE, "delta_controller.h": CONTROLLER}).items():
        (folder / name).write_text(text)
    sources = [Path(__file__).with_name("c_board.c"), folder / "delta_board.c", folder / "delta_joints.c"]
    library = folder / "board.so"
    shared = ["-fPIC", "-shared", f"-I{folder}", *map(str, sources), "-o", str(library), "-lm"]
    subprocess.run([tool("gcc"), *FLAGS, *shared], check=True)
    return library


class Both:
    """Both boards; each call goes to both, and is compared."""

    def __init__(self, library: Path) -> None:
        self.c: Any = ctypes.CDLL(str(library))
        self.c.board_begin.argtypes = [ctypes.c_double, ctypes.c_double, ctypes.c_uint32]
        self.c.board_received.argtypes = [ctypes.c_char_p, ctypes.c_size_t, ctypes.c_char_p, ctypes.c_char_p]
        self.c.board_received.restype = self.c.board_tick.restype = ctypes.c_size_t
        self.c.board_begin(PERIOD, LIMIT, COUNTS)
        self.reply = ctypes.create_string_buffer(64)
        self.motors, self.first = Motors(), 0
        self.python = Board(self.motors, PERIOD, LIMIT, COUNTS, first=lambda: self.first)
        self.stopped, self.healthy = False, True
        self.state: Packet | None = None
        self.kinds: Counter[str] = Counter()
        self._set("board_healthy", ctypes.c_int, 1)
        self._set("board_damping", ctypes.c_double, FREE)
        self._three("board_torque", ctypes.c_double)[:] = [0.0, 0.0, 0.0]
        self._set("board_stopped", ctypes.c_int, 0)

    def _set(self, name: str, kind: Any, value: float) -> None:
        kind.in_dll(self.c, name).value = value

    def _three(self, name: str, kind: Any) -> Any:
        return (kind * 3).in_dll(self.c, name)

    def figure(self, which: int) -> int:
        return int(self.c.board_figure(which))

    def same(self, by_c: bytes, by_python: bytes | None) -> None:
        """Answers, torques, damping and figures are the same in both."""
        assert by_c == (by_python or b"")
        torque = np.array(self._three("board_torque", ctypes.c_double))
        assert np.array_equal(torque, self.motors.torque)
        assert np.abs(torque).max() <= LIMIT
        damping = ctypes.c_double.in_dll(self.c, "board_damping").value
        assert damping == (TOUCHED if self.motors.touched else FREE)
        board = self.python
        figures = (board.tripped, board.connected, board.served, board.counts["LATE"], board.sessions)
        assert tuple(self.figure(k) for k in range(5)) == figures

    def receive(self, data: bytes, peer: int) -> Packet | None:
        """A datagram to both."""
        size = self.c.board_received(data, len(data), PEERS[peer], self.reply)
        by_c = self.reply.raw[:size]
        if by_c and decode(by_c).kind is PacketKind.WELCOME:  # each draws its first number; give one the other's
            self.first = decode(by_c).sequence - 1
        self.same(by_c, self.python.received(data, PEERS[peer]))
        answer = decode(by_c) if by_c else None
        self.kinds["none" if answer is None else answer.kind.name] += 1
        return answer

    def tick(self, angles: np.ndarray, fresh: int = 7) -> Packet | None:
        """A period of both."""
        self.motors.time = round(self.motors.time + PERIOD, 6)
        self.motors.angles, self.motors.fresh = np.where([fresh >> j & 1 for j in range(3)], angles, np.nan), fresh
        self._set("board_now", ctypes.c_double, self.motors.time)
        self._three("board_angle", ctypes.c_double)[:] = list(self.motors.angles)
        self._three("board_fresh", ctypes.c_int)[:] = [fresh >> joint & 1 for joint in range(3)]
        self.python.stop = self.stopped
        self._set("board_stopped", ctypes.c_int, int(self.stopped))
        size = self.c.board_tick(self.reply)
        by_c = self.reply.raw[:size]
        self.same(by_c, self.python.tick())
        self.state = decode(by_c) if by_c else None
        return self.state


class Script:
    """Draws what hosts, wires and others do."""

    def __init__(self, both: Both, seed: int) -> None:
        self.both, self.rng = both, np.random.default_rng(seed)
        self.sent: list[bytes] = []
        self.sequence = {0: 1, 1: 1}
        self.newest = 0

    def packet(self) -> bytes:
        rng = self.rng
        session, kind = int(rng.choice([7, 9])), rng.random()
        sequence = self.sequence[0] + int(rng.choice([1, 1, 1, 1, 0, -1, 2, 2**31]))
        self.sequence[0] = max(self.sequence[0], sequence) if sequence < 2**30 else self.sequence[0]
        if kind < 0.12:
            watchdog = float(rng.choice([WATCHDOG, WATCHDOG, 0.02, 0.5, 1e-4]))
            return encode(Packet(PacketKind.HELLO, session, sequence % 2**32, 0, 0, (watchdog,)))
        if kind < 0.14:
            return encode(Packet(PacketKind.BYE, session, sequence % 2**32, 0, 0))
        if kind < 0.17:
            return encode(Packet(PacketKind.STATE, session, sequence % 2**32, 0, 0, (0.1, 0.2, 0.3)))
        answers = (self.newest - int(rng.choice([0, 0, 0, 1, 5, 2**20, -3]))) % 2**32
        flags = int(rng.choice([0, 0, WALL_TOUCHED, RESET_WATCHDOG, 3, 256]))
        torque = tuple(float(v) for v in rng.uniform(-1.2, 1.2, 3))
        return encode(Packet(PacketKind.COMMAND, session, sequence % 2**32, answers, 0, torque, flags))

    def spoilt(self, data: bytes) -> bytes:
        """Torn, with a bit turned round, of another version, or noise."""
        rng, kind = self.rng, int(self.rng.integers(4))
        if kind == 0:
            return data[: int(rng.integers(len(data)))]
        if kind == 1:
            at = int(rng.integers(len(data)))
            return data[:at] + bytes([data[at] ^ (1 << int(rng.integers(8)))]) + data[at + 1 :]
        if kind == 2:
            return encode(Packet(PacketKind.HELLO, 7, 1, 0, 0, (WATCHDOG,)), version=int(rng.choice([0, 2, 255])))
        return bytes(rng.integers(0, 256, int(rng.integers(0, 64)), dtype=np.uint8))

    def step(self) -> None:
        rng, both = self.rng, self.both
        if rng.random() < 0.45:
            fresh = 7 if rng.random() < 0.9 else int(rng.integers(8))
            state = both.tick(rng.uniform(-1.0, 1.0, 3), fresh)
            if state is not None:
                self.newest = state.sequence
                assert state.flags >> 2 == ~fresh & 7
            return
        if rng.random() < 0.01:
            both.stopped = not both.stopped
        data = self.packet()
        self.sent.append(data)
        if self.sent and rng.random() < 0.15:
            data = self.sent[int(rng.integers(len(self.sent)))]
        if rng.random() < 0.15:
            data = self.spoilt(data)
        answer = both.receive(data, int(rng.random() < 0.1))
        if answer is not None and answer.kind is PacketKind.WELCOME:
            self.newest = answer.sequence


@pytest.mark.quick(4)
@pytest.mark.parametrize("seed", range(40))
def test_whatever_arrives_both_boards_do_the_same(built: Path, seed: int) -> None:
    both = Both(built)
    script, seen = Script(both, seed), Counter()
    for _ in range(5000):
        script.step()
        if both.state is not None:
            seen["tripped"] += both.state.flags & WATCHDOG_TRIPPED != 0
            seen["stopped"] += both.state.flags & STOP_PRESSED != 0
            driven = bool(np.any(both.motors.torque))
            seen["driven"] += driven
            assert not (driven and both.state.flags & (WATCHDOG_TRIPPED | STOP_PRESSED))
    assert min(seen["tripped"], seen["stopped"], seen["driven"]) > 50
    assert {"WELCOME", "REFUSED", "BYE", "none"} <= set(both.kinds)


def hello(both: Both, session: int, peer: int, sequence: int = 1) -> Packet:
    answer = both.receive(encode(Packet(PacketKind.HELLO, session, sequence, 0, 0, (WATCHDOG,))), peer)
    assert answer is not None
    return answer


def test_a_reset_that_is_sent_again_does_not_arm_a_board_that_has_tripped(built: Path) -> None:
    both = Both(built)
    hello(both, 7, 0)
    state = both.tick(np.zeros(3))
    assert state is not None
    command = encode(Packet(PacketKind.COMMAND, 7, 2, state.sequence, 0, (0.3, 0.0, 0.0), RESET_WATCHDOG))
    both.receive(command, 0)
    both.tick(np.zeros(3))
    assert both.motors.torque[0] == 0.3
    for _ in range(8):
        both.receive(command, 0)
        both.tick(np.zeros(3))
    assert both.python.tripped
    assert not np.any(both.motors.torque)


def test_one_host_at_a_time_until_its_watchdog_has_cut(built: Path) -> None:
    both = Both(built)
    hello(both, 7, 0)
    assert hello(both, 9, 1).kind is PacketKind.REFUSED
    both.receive(
        encode(Packet(PacketKind.COMMAND, 7, 2, both.first + 1, 0, (0.3, 0.0, 0.0))), 1
    )  # spoofed: from elsewhere
    both.tick(np.zeros(3))
    assert not np.any(both.motors.torque)
    for _ in range(8):
        both.tick(np.zeros(3))
    assert hello(both, 9, 1).kind is PacketKind.WELCOME


def test_a_drive_that_is_not_healthy_takes_the_torque_in_the_same_tick(built: Path) -> None:
    """In C alone: the Python board has no drives."""
    both = Both(built)
    welcome = hello(both, 7, 0)
    both.receive(encode(Packet(PacketKind.COMMAND, 7, 2, welcome.sequence, 0, (0.3, 0.0, 0.0))), 0)
    both._set("board_healthy", ctypes.c_int, 0)
    both.c.board_tick(both.reply)
    assert not any(both._three("board_torque", ctypes.c_double))
    assert decode(both.reply.raw[:56]).flags & WATCHDOG_TRIPPED
