"""Host and board in two processes on loopback; the server with clocks of the test; the command."""

from __future__ import annotations

import errno
import json
import os
import re
import signal
import socket
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from haptics.commands.cli import main
from haptics.devices.board import Board
from haptics.devices.device import DeviceLostError, Reading, run
from haptics.devices.link import UdpLink, readable, udp_socket
from haptics.devices.protocol import Packet, PacketKind, decode, encode
from haptics.devices.remote import RemoteDevice
from haptics.devices.server import listen, serve
from haptics.devices.simulated import SimulatedDevice
from tests.committed import BEST, ROOT
from tests.haptics.control.supervisor.rig import HOME, LIMITS, PLANT
from tests.haptics.devices.fake import FakeDevice
from tests.terminal import said

PULL = np.array([0.02, -0.03, 0.04])
PATIENT = 5.0
"""Seconds that a board in a test waits for its host: longer than any pause of a busy machine."""


def wavy(sample: Reading) -> np.ndarray:
    return PULL * np.cos(100.0 * sample.time)


@pytest.fixture
def process(request: pytest.FixtureRequest) -> Iterator[tuple[subprocess.Popen[str], int]]:
    patience = getattr(request, "param", PATIENT)
    started = subprocess.Popen(
        [sys.executable, "-m", "tests.haptics.devices.boards.board_process", str(patience)],
        stdout=subprocess.PIPE,
        text=True,
        cwd=ROOT,
    )
    assert started.stdout is not None
    try:
        yield started, int(started.stdout.readline())
    finally:
        started.kill()
        started.wait()
        started.stdout.close()


def test_the_plant_at_the_other_end_of_a_socket_is_the_plant(process: tuple[subprocess.Popen[str], int]) -> None:
    board, port = process
    device = RemoteDevice(UdpLink("127.0.0.1", port), timeout=PATIENT)
    far = run(device, wavy, ticks=500)
    near = run(SimulatedDevice(PLANT, HOME, count=LIMITS.encoder_count), wavy, ticks=500)
    np.testing.assert_array_equal(far.angles, near.angles)
    np.testing.assert_allclose(far.torques, near.torques, rtol=1e-12)  # whole nanoseconds against sums of periods
    assert sum(device.counts.values()) == 0
    # the zero torque at the end is a second answer to the last STATE, and may come after the next one
    assert board.communicate(timeout=30)[0] in ("1 {}\n", "1 {'LATE': 1}\n")
    assert board.returncode == 0


def test_a_board_that_dies_is_lost(process: tuple[subprocess.Popen[str], int]) -> None:
    board, port = process
    device = RemoteDevice(UdpLink("127.0.0.1", port), timeout=PATIENT)
    done = []

    def tick(sample: Reading) -> np.ndarray:
        done.append(sample)
        if len(done) == 20:
            board.kill()
            board.wait()
        return PULL

    with pytest.raises(DeviceLostError, match=os.strerror(errno.ECONNREFUSED)):
        run(device, tick, ticks=100)
    assert 20 <= len(done) <= 21


@pytest.mark.parametrize("process", [1e-3], indirect=True)
def test_noise_on_the_boards_port_does_no_harm(process: tuple[subprocess.Popen[str], int]) -> None:
    board, port = process
    device = RemoteDevice(UdpLink("127.0.0.1", port), timeout=PATIENT)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as stranger:
        stranger.connect(("127.0.0.1", port))

        def tick(sample: Reading) -> np.ndarray:
            stranger.send(os.urandom(50))
            stranger.send(encode(Packet(PacketKind.COMMAND, 1, 1, 1, 0, (0.8, 0.8, 0.8))))
            return wavy(sample)

        recording = run(device, tick, ticks=50)
    assert np.abs(recording.angles - recording.angles[0]).max() < 0.5
    assert "STRANGER" in board.communicate(timeout=30)[0]


def test_a_port_without_a_board() -> None:
    with listen() as free:
        port = free.getsockname()[1]
    with pytest.raises(DeviceLostError, match=os.strerror(errno.ECONNREFUSED)):
        RemoteDevice(UdpLink("127.0.0.1", port))


@pytest.mark.parametrize("host", ["192.0.2.1", "0.0.0.0", "::"])
def test_other_machines_must_be_allowed(host: str) -> None:
    with pytest.raises(ValueError, match="loopback"):
        UdpLink(host, 1)
    with pytest.raises(ValueError, match="loopback"):
        listen(host)
    udp_socket(host, allow_remote=True).close()


def test_names_are_no_addresses() -> None:
    with pytest.raises(ValueError, match=r"^'localhost'"):
        UdpLink("localhost", 1)


def test_a_port_that_is_taken() -> None:
    with listen() as first, pytest.raises(OSError, match=os.strerror(errno.EADDRINUSE)):
        listen(port=first.getsockname()[1])


# ---- the server, with clocks of the test ----


class Clock:
    """Goes on only while somebody waits, and by a hundredth of a millisecond when it is looked at."""

    def __init__(self) -> None:
        self.now = 0.0

    def __call__(self) -> float:
        self.now += 1e-5
        return self.now

    def ready(self, waiting: socket.socket, seconds: float) -> bool:
        """Never waits really."""
        if readable(waiting, 0.0):
            return True
        self.now += seconds
        return False


def served(messages: list[bytes], **more: Any) -> tuple[Board, FakeDevice, list[Packet], int]:
    """Serves what is waiting on the socket already."""
    motors, clock = FakeDevice([[0.1, 0.2, 0.3]] * 10_000), Clock()
    board = Board(motors, 1e-3, 0.8, 16384, first=lambda: 0)
    with listen() as listening, socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as host:
        host.connect(listening.getsockname())
        for message in messages:
            host.send(message)
        sessions = serve(board, listening, clock=clock, ready=clock.ready, **more)
        host.setblocking(False)
        replies = []
        try:
            while True:
                replies.append(decode(host.recv(2048)))
        except BlockingIOError:
            return board, motors, replies, sessions


HELLO = encode(Packet(PacketKind.HELLO, 7, 1, 0, 0, (0.02,)))
BYE = encode(Packet(PacketKind.BYE, 7, 2, 0, 0))


def test_a_server_without_a_host_ends_when_it_is_idle() -> None:
    _, motors, replies, sessions = served([], patience=0.01, idle=0.5)
    assert (sessions, replies, motors.written) == (0, [], [])


def test_what_opens_no_session_does_not_keep_a_server_awake() -> None:
    """Each look at the clock is 10 us: 200 datagrams are more than 2 ms, after which it ends among them."""
    others = [b"junk", encode(Packet(PacketKind.COMMAND, 7, 2, 1, 0, (0.1, 0.1, 0.1))), HELLO[:-1]]
    board, _, replies, sessions = served([others[k % 3] for k in range(200)], patience=0.01, idle=2e-3)
    assert (sessions, replies) == (0, [])
    assert 10 < board.counts.total() < 150


def test_a_session_from_hello_to_bye() -> None:
    _, _, replies, sessions = served([HELLO, BYE], patience=1.0, once=True)
    assert [r.kind for r in replies] == [PacketKind.WELCOME, PacketKind.STATE, PacketKind.BYE]
    assert sessions == 1


def test_a_host_that_falls_silent_loses_the_torque_and_then_the_session() -> None:
    command_packet = encode(Packet(PacketKind.COMMAND, 7, 2, 1, 0, (0.1, 0.1, 0.1)))
    board, motors, replies, sessions = served([HELLO, command_packet], patience=0.01, idle=1.0)
    kinds = [r.kind for r in replies]
    assert kinds[0] is PacketKind.WELCOME
    assert kinds[-1] is PacketKind.BYE
    assert kinds.count(PacketKind.STATE) > 25
    states = [r for r in replies if r.kind is PacketKind.STATE]
    assert not states[15].flags
    assert states[24].flags
    assert sum(torque[0] == 0.1 for torque in motors.written) == 21  # one tick, and 20 ms of watchdog
    assert not np.any(motors.written[-1])
    assert not board.connected
    assert sessions == 1


def test_a_paced_server_ticks_by_the_clock() -> None:
    _, motors, _, _ = served([HELLO], patience=1e-3, paced=True, idle=0.2)
    assert len(motors.written) == pytest.approx(0.2 / 1e-3, abs=2)  # the first and the last may be cut


def test_it_can_be_stopped_and_says_bye() -> None:
    required = iter([False] * 5 + [True] * 100)
    _, _, replies, _ = served([HELLO], patience=1.0, stop=lambda: next(required))
    assert replies[0].kind is PacketKind.WELCOME
    assert replies[-1].kind is PacketKind.BYE


# ---- the command ----


@pytest.fixture
def masses(tmp_path: Path) -> Path:
    def body(mass: float, centre: list[float], *inertia: float) -> dict[str, Any]:
        return {"mass_kg": mass, "centre_m": centre, "inertia_kg_m2": np.diag(inertia).tolist()}

    bodies: dict[str, Any] = {"platform": body(0.07, [0.0, 0.0, 0.0], 1e-5, 1e-5, 1e-5)}
    for i in range(3):
        bodies[f"upper_arm_{i}"] = body(0.04, [0.03, 0.0, 0.0], 1e-6, 2e-5, 2e-5)
        bodies[f"pinion_{i}"] = body(0.005, [0.0, 0.0, 0.0], 1e-7, 1e-7, 1e-7)
        for j in range(2):
            bodies[f"rod_{i}_{j}"] = body(0.005, [0.056, 0.0, 0.0], 1e-8, 5e-6, 5e-6)
    path = tmp_path / "mass_properties.json"
    path.write_text(json.dumps({"schema": "delta-mass-properties/1", "bodies": bodies}), encoding="utf-8")
    return path


def call(*arguments: object) -> int:
    try:
        return main(["board", *map(str, arguments)])
    except SystemExit as ended:
        return int(ended.code or 0)


def test_the_command_serves_the_design(masses: Path) -> None:
    arguments = ["--design", str(BEST), "--mass-properties", str(masses), "--once"]
    with subprocess.Popen(
        [sys.executable, "-m", "haptics", "board", *arguments], stdout=subprocess.PIPE, text=True, cwd=ROOT
    ) as process:
        assert process.stdout is not None
        words = process.stdout.readline().split()
        assert words[:3] == ["listening", "on", "127.0.0.1"]
        device = RemoteDevice(UdpLink(words[2], int(words[3])), timeout=PATIENT)
        assert (device.torque_limit, device.counts_per_turn) == (0.8, 2**21)
        recording = run(device, wavy, ticks=20)
        assert len(recording.time) == 20
        # the zero torque at the end is one more, or two; a busy machine may make a COMMAND late
        reported = re.fullmatch(r"1 sessions, (\d+) commands served; dropped: .+\n", process.stdout.read())
        assert reported
        assert 20 <= int(reported[1]) <= 22
    assert process.returncode == 0


def test_ctrl_c_on_the_command_says_what_it_did(masses: Path) -> None:
    arguments = ["-m", "haptics", "board", "--design", str(BEST), "--mass-properties", str(masses)]
    with subprocess.Popen(
        [sys.executable, *arguments],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        cwd=ROOT,
    ) as process:
        assert process.stdout is not None
        assert process.stderr is not None
        port = int(process.stdout.readline().split()[-1])
        link = UdpLink("127.0.0.1", port)
        device = RemoteDevice(link, timeout=PATIENT)
        link.send(b"noise")
        run(device, wavy, ticks=20)
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=30)
    assert process.returncode == 130
    assert out == ""
    reported = re.fullmatch(r"interrupted; 1 sessions, (\d+) commands served; dropped: .*\b1 SHORT\b.*\n", said(err))
    assert reported, err
    assert 20 <= int(reported[1]) <= 22


def test_ctrl_c_before_any_host(
    masses: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def interrupted(*_: Any, **__: Any) -> int:
        raise KeyboardInterrupt

    monkeypatch.setattr("haptics.devices.server.serve", interrupted)
    assert call("--design", BEST, "--mass-properties", masses) == 130
    assert capsys.readouterr().err == "interrupted; 0 sessions, 0 commands served; dropped: nothing\n"
