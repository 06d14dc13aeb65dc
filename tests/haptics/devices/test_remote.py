"""Host and board over a link that loses, repeats, reorders and spoils; no socket, no clock but the test's."""

import errno
import os
from collections import deque
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from haptics.control.controller import Controller
from haptics.control.filters import low_pass
from haptics.control.pose import model
from haptics.control.supervisor.faults import FaultCode, State
from haptics.control.supervisor.memory import LATCHED
from haptics.devices.board import LONGEST_WATCHDOG, Board
from haptics.devices.device import DeviceLostError, Reading, run
from haptics.devices.host import Host
from haptics.devices.protocol import Packet, PacketKind, decode, encode
from haptics.devices.remote import TRIES, DeviceRefusedError, RemoteDevice
from haptics.devices.simulated import SimulatedDevice
from haptics.rendering.laws.constant_force import ConstantForce
from tests.haptics.control.supervisor.rig import DESIGN, GEOMETRY, HOME, LIMITS, MASSES, PLANT
from tests.haptics.devices.fake import FakeDevice

PULL = np.array([0.02, -0.03, 0.04])
HOST = ("127.0.0.1", 50000)
Through = Callable[[int, bytes], list[bytes]]


def clean(_number: int, data: bytes) -> list[bytes]:
    return [data]


class Wire:
    """A link to a board that ticks when the host waits; `up` and `down` are what becomes of each datagram."""

    def __init__(self, board: Board, up: Through = clean, down: Through = clean) -> None:
        self.board, self.up, self.down = board, up, down
        self.arrived: deque[bytes] = deque()
        self.sent = self.replied = 0
        self.now = 0.0
        self.closed = False
        self.dead = False

    def clock(self) -> float:
        return self.now

    def _deliver(self, data: bytes | None) -> None:
        if data is not None:
            self.arrived.extend(self.down(self.replied, data))
            self.replied += 1

    def send(self, data: bytes) -> None:
        if self.dead:
            raise ConnectionRefusedError(111, "Connection refused")
        for copy in self.up(self.sent, data):
            self._deliver(self.board.received(copy, HOST))
        self.sent += 1

    def receive(self, seconds: float) -> bytes | None:
        if self.dead:
            raise ConnectionRefusedError(111, "Connection refused")
        if not self.arrived and seconds > 0.0:
            self.now += min(seconds, 0.02)  # the board's patience
            self._deliver(self.board.tick())
        return self.arrived.popleft() if self.arrived else None

    def close(self) -> None:
        self.closed = True


def board(**more: Any) -> Board:
    device = SimulatedDevice(PLANT, HOME, count=LIMITS.encoder_count)
    return Board(device, 1e-3, 0.8, 16384, **more)


def scripted() -> tuple[Board, FakeDevice]:
    device = FakeDevice([[0.1, 0.2, 0.3]] * 500)
    return Board(device, 1e-3, 0.8, 16384, first=lambda: 0), device


def remote(wire: Wire, **more: Any) -> RemoteDevice:
    return RemoteDevice(wire, session=77, clock=wire.clock, **more)


def wavy(sample: Reading) -> np.ndarray:
    return PULL * np.cos(100.0 * sample.time)


def test_over_a_clean_link_it_is_the_simulated_device_bit_by_bit() -> None:
    wire = Wire(board())
    device = remote(wire)
    assert (device.period, device.watchdog, device.torque_limit, device.counts_per_turn) == (1e-3, 0.02, 0.8, 16384)
    far = run(device, wavy, ticks=300)
    near = run(SimulatedDevice(PLANT, HOME, count=LIMITS.encoder_count), wavy, ticks=301)
    # the board reads after its first period, with no torque yet: nothing is lost, all is one tick later
    assert len(far.time) == 300
    np.testing.assert_allclose(np.diff(far.time), 1e-3, atol=1e-12)
    np.testing.assert_array_equal(far.angles, near.angles[:300])
    assert sum(device.counts.values()) == 0
    assert wire.closed
    assert not wire.board.connected


def test_lost_states_are_counted_and_the_next_is_taken() -> None:
    wire = Wire(board(), down=lambda n, data: [] if n in (5, 6, 20) else [data])
    device = remote(wire)
    recording = run(device, wavy, ticks=40)
    steps = np.round(np.diff(recording.time) / 1e-3).astype(int)
    assert sorted(steps)[-2:] == [2, 3]
    assert device.counts["LOST"] == 3
    assert device.counts.total() == 3


def test_lost_commands_leave_the_torque_and_are_seen() -> None:
    far, motors = scripted()
    wire = Wire(far, up=lambda n, data: [] if n in (5, 9) else [data])
    device = remote(wire)
    run(device, lambda sample: np.full(3, 0.1 + 0.1 * (round(sample.time * 1000) % 2)), ticks=20)
    assert device.counts["UNANSWERED"] == 2
    assert not far.counts["TRIPPED"]
    held = [k for k in range(2, 19) if motors.written[k][0] == motors.written[k - 1][0]]
    assert len(held) == 4, "twice the last torque was held instead of the next"


def test_repeated_and_reordered_datagrams_are_dropped() -> None:
    kept: list[bytes] = []

    def twice(_n: int, data: bytes) -> list[bytes]:
        return [data, data]

    def late(n: int, data: bytes) -> list[bytes]:
        kept.append(data)
        return [data, kept[n - 3]] if n > 5 else [data]

    wire = Wire(board(), up=late, down=twice)
    device = remote(wire)
    recording = run(device, wavy, ticks=30)
    np.testing.assert_allclose(np.diff(recording.time), 1e-3, atol=1e-12)
    near = run(SimulatedDevice(PLANT, HOME, count=LIMITS.encoder_count), wavy, ticks=30)
    np.testing.assert_array_equal(recording.angles, near.angles)
    assert device.counts["OLD"] >= 29
    assert wire.board.counts["OLD"] >= 20


def test_of_several_states_the_newest_is_taken() -> None:
    wire = Wire(board())
    device = remote(wire)
    device.read()
    for _ in range(3):
        wire._deliver(wire.board.tick())
    newest = wire.board._time
    assert device.read().time == newest
    assert device.counts["SKIPPED"] == 2


def test_spoilt_datagrams_are_dropped_on_both_sides() -> None:
    def spoil(_n: int, data: bytes) -> list[bytes]:
        return [b"", data[:10], bytes([data[0] ^ 1]) + data[1:], data[:-1] + bytes([data[-1] ^ 1]), data]

    wire = Wire(board(), up=spoil, down=spoil)
    device = remote(wire)
    recording = run(device, wavy, ticks=10)
    near = run(SimulatedDevice(PLANT, HOME, count=LIMITS.encoder_count), wavy, ticks=10)
    np.testing.assert_array_equal(recording.angles, near.angles)
    for counts in (device.counts, wire.board.counts):
        assert counts["SHORT"] >= 20
        assert counts["MAGIC"] >= 10
        assert counts["CHECK"] >= 10


def test_another_session_and_another_address_are_strangers() -> None:
    far, motors = scripted()
    wire = Wire(far)
    device = remote(wire)
    device.read()
    packet = Packet(PacketKind.COMMAND, 78, 9, 0, 0, (0.5, 0.5, 0.5))
    assert far.received(encode(packet), HOST) is None
    assert far.received(encode(packet._replace(session=77)), ("127.0.0.1", 50001)) is None
    assert far.received(encode(packet._replace(session=78, kind=PacketKind.BYE, values=())), HOST) is None
    assert far.counts["STRANGER"] == 3
    far.tick()
    assert not np.any(motors.written[-1])
    wire.arrived.append(encode(Packet(PacketKind.STATE, 78, 99, 0, 0, (9.0, 9.0, 9.0))))
    assert device.read().angles[0] == 0.1
    assert device.counts["STRANGER"] == 1


def test_what_a_board_does_not_expect_is_counted() -> None:
    far, _ = scripted()
    wire = Wire(far)
    remote(wire)
    assert far.received(encode(Packet(PacketKind.STATE, 77, 9, 0, 0, (0.5, 0.5, 0.5))), HOST) is None
    assert far.counts["UNEXPECTED"] == 1


def test_a_late_command_is_applied_if_it_is_the_newest() -> None:
    far, motors = scripted()
    remote(Wire(far))
    far.tick()
    far.tick()
    far.received(encode(Packet(PacketKind.COMMAND, 77, 5, 2, 0, (0.1, 0.2, 0.3))), HOST)
    assert far.counts["LATE"] == 1
    far.tick()
    np.testing.assert_array_equal(motors.written[-1], [0.1, 0.2, 0.3])


def test_the_watchdog_cuts_the_torque_until_it_is_reported_otherwise() -> None:
    far, motors = scripted()
    wire = Wire(far)
    device = remote(wire, watchdog=5e-3)
    device.read()
    device.write(PULL)
    for _ in range(6):
        far.tick()
        np.testing.assert_array_equal(motors.written[-1], PULL)
    far.tick()
    assert not np.any(motors.written[-1])
    assert far.tripped
    sample = device.read()
    assert sample.flags == FaultCode.WATCHDOG.bit
    device.write(PULL)
    device.read()
    assert not np.any(motors.written[-1]), "a command alone does not end it"
    device.reset_watchdog()
    device.write(PULL)
    assert device.read().flags == 0
    np.testing.assert_array_equal(motors.written[-1], PULL)


def test_a_host_that_is_slow_to_begin_finds_no_fault() -> None:
    """Nobody had commanded yet: what the watchdog cut is given back before force is asked for."""
    far = board()
    device = remote(Wire(far), watchdog=5e-3)
    for _ in range(9):  # while the host compiles
        far.tick()
    assert far.tripped
    known = model(GEOMETRY, MASSES, DESIGN.requirements.gravity_m_s2)
    host = Host(Controller(known, low_pass(1e-3, 100.0), LIMITS, np.inf), ConstantForce([0.0, 0.0, 0.1]))
    host.begin(device)
    host.enable()
    for _ in range(3):
        device.write(host(device.read()))
    assert not far.tripped
    assert int(host.supervisor.memory[LATCHED]) == 0
    assert host.supervisor.state is State.RAMPING


def test_a_host_that_is_quick_loses_no_tick() -> None:
    wire = Wire(board())
    device = remote(wire)
    device.rouse()
    first = device.read()
    assert first.time == 0.0
    assert wire.sent == 1  # the HELLO alone


def test_the_boards_emergency_stop() -> None:
    far, motors = scripted()
    device = remote(Wire(far))
    device.read()
    device.write(PULL)
    far.stop = True
    assert device.read().flags == FaultCode.EMERGENCY_STOP.bit
    assert not np.any(motors.written[-1])
    far.stop = False
    device.write(PULL)
    assert device.read().flags == FaultCode.WATCHDOG.bit
    assert not np.any(motors.written[-1])  # the release alone gives no torque back
    device.reset_watchdog()
    device.write(PULL)
    device.read()
    assert device.read().flags == 0
    device.write(PULL)
    device.read()
    assert np.any(motors.written[-1])


def test_torque_beyond_the_boards_limit_is_clipped() -> None:
    far, motors = scripted()
    device = remote(Wire(far))
    device.read()
    device.write([5.0, -5.0, 0.1])
    device.read()
    np.testing.assert_array_equal(motors.written[-1], [0.8, -0.8, 0.1])


def test_torque_that_is_none_is_not_sent() -> None:
    wire = Wire(board())
    device = remote(wire)
    before = wire.sent
    with pytest.raises(ValueError, match=r"^torques"):
        device.write([np.nan, 0.0, 0.0])
    assert wire.sent == before


def test_an_encoder_without_a_number_comes_through() -> None:
    far = Board(FakeDevice([[0.1, np.nan, 0.3]] * 3), 1e-3, 0.8, 16384)
    assert np.isnan(remote(Wire(far)).read().angles[1])


# ---- beginning and end ----


def test_a_lost_hello_or_welcome_is_repeated_and_the_session_is_one() -> None:
    for lossy in ({"up": lambda n, data: [] if n < 2 else [data]}, {"down": lambda n, data: [] if n < 2 else [data]}):
        wire = Wire(board(), **lossy)
        device = remote(wire)
        assert device.read().time <= 0.2  # its clock went on while the WELCOME was on its way
        device.close()
        assert not wire.board.connected


def test_nobody_answers() -> None:
    wire = Wire(board(), up=lambda _n, _data: [])
    with pytest.raises(DeviceLostError, match=r"0\.5 s"):
        remote(wire)
    assert wire.closed
    assert wire.sent == TRIES
    assert wire.now == pytest.approx(0.5)


def test_a_dead_port() -> None:
    wire = Wire(board())
    wire.dead = True
    with pytest.raises(DeviceLostError, match=os.strerror(errno.ECONNREFUSED)):
        remote(wire)
    assert wire.closed
    wire = Wire(board())
    device = remote(wire)
    wire.dead = True
    with pytest.raises(DeviceLostError, match=os.strerror(errno.ECONNREFUSED)):
        device.read()
    with pytest.raises(DeviceLostError, match=os.strerror(errno.ECONNREFUSED)):
        device.write(PULL)
    device.close()
    assert wire.closed


def test_a_board_that_falls_silent() -> None:
    wire = Wire(board())
    device = remote(wire, timeout=0.05)
    device.read()
    wire.down = lambda _n, _data: []
    before = wire.now
    with pytest.raises(DeviceLostError, match=r"0\.05 s"):
        device.read()
    assert wire.now - before == pytest.approx(0.05)
    device.close()
    assert wire.closed, "nobody answers the BYE, and it is closed all the same"


def test_a_board_that_sends_only_noise_is_lost_too() -> None:
    wire = Wire(board())
    device = remote(wire)
    wire.down = lambda _n, _data: [b"noise"]
    with pytest.raises(DeviceLostError):
        device.read()


def test_the_board_ends_the_session() -> None:
    wire = Wire(board())
    device = remote(wire)
    wire.arrived.append(wire.board.farewell() or b"")
    with pytest.raises(DeviceLostError):
        device.read()
    assert wire.board.farewell() is None


def test_another_version_is_refused_by_both() -> None:
    old = Wire(board(), up=lambda _n, data: [encode(decode(data), version=2)])
    with pytest.raises(DeviceRefusedError, match="version 1"):
        remote(old)
    assert old.closed
    assert old.board.counts["VERSION"] == 1
    new = Wire(board(), down=lambda _n, data: [encode(decode(data), version=2)])
    with pytest.raises(DeviceRefusedError, match="version"):
        remote(new)


def test_within_a_session_another_version_is_only_dropped() -> None:
    wire = Wire(board())
    device = remote(wire)
    wire.arrived.append(encode(Packet(PacketKind.STATE, 77, 50, 0, 0, (9.0, 9.0, 9.0)), version=3))
    assert device.read().angles[0] != 9.0
    assert device.counts["VERSION"] == 1


def test_a_second_host_is_refused_until_the_watchdog_has_let_go() -> None:
    far, motors = scripted()
    device = remote(Wire(far))
    device.read()
    hello = encode(Packet(PacketKind.HELLO, 5, 1, 0, 0, (0.02,)))
    other = ("127.0.0.1", 50001)
    reply = decode(far.received(hello, other) or b"")
    assert (reply.kind, reply.values) == (PacketKind.REFUSED, (2, 1))
    assert far.counts["BUSY"] == 1
    while not far.tripped:
        far.tick()
    assert decode(far.received(hello, other) or b"").kind is PacketKind.WELCOME
    assert far.peer == other
    assert not np.any(motors.written[-1])


@pytest.mark.parametrize("watchdog", [0.0, 5e-4, 0.2, -1.0])
def test_a_watchdog_that_is_none_is_refused(watchdog: float) -> None:
    assert LONGEST_WATCHDOG < 0.2
    with pytest.raises(DeviceRefusedError, match="watchdog"):
        remote(Wire(board()), watchdog=watchdog)


def test_a_reason_of_a_later_board_is_reported_by_its_number() -> None:
    wire = Wire(board(), down=lambda _n, _data: [encode(Packet(PacketKind.REFUSED, 77, 1, 0, 0, (9, 1)))])
    with pytest.raises(DeviceRefusedError, match="reason 9"):
        remote(wire)


def test_the_same_host_may_begin_anew() -> None:
    far, motors = scripted()
    wire = Wire(far)
    device = remote(wire)
    device.read()
    device.write(PULL)
    RemoteDevice(wire, session=78, clock=wire.clock)
    far.tick()
    assert not np.any(motors.written[-1]), "a new session begins without torque"


def test_a_closed_device_says_bye_once() -> None:
    wire = Wire(board())
    device = remote(wire)
    device.close()
    sent = wire.sent
    device.close()
    assert wire.sent == sent


def test_without_a_host_a_board_ticks_without_torque() -> None:
    far, motors = scripted()
    assert far.tick() is None
    assert not np.any(motors.written[-1])
    assert far.peer is None
