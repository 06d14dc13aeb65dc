"""A simulated board after a fault: a new HELLO finds it alive, and stops keep its arms where the machine's are."""

from __future__ import annotations

import numpy as np
import pytest

from delta_cad.design import Design
from haptics.devices.board import Board
from haptics.devices.protocol import Packet, PacketKind, decode, encode
from haptics.devices.simulated import simulated_machine
from haptics.loop.hardware import real_plant
from tests.haptics.devices.fake import FakeDevice
from tests.haptics.scene_machine import scene_machine


def hello(session: int) -> bytes:
    return encode(Packet(PacketKind.HELLO, session, 1, 0, 0, (0.02,)))


def test_a_board_that_lost_its_numbers_lives_again_in_a_new_session(best: Design) -> None:
    device = simulated_machine(scene_machine(best))
    board = Board(device, device.period, 0.8, 1 << 21, first=lambda: 0)
    board.received(hello(1), "host")
    start = decode(board.tick() or b"").values
    device.state[:] = np.nan
    for _ in range(3):
        assert np.isnan(decode(board.tick() or b"").values).all()  # in the session it stays what it is
    board.received(hello(1), "host")  # a HELLO repeated is no new session
    assert np.isnan(decode(board.tick() or b"").values).all()
    before = device.time
    board.received(hello(2), "host")
    state = decode(board.tick() or b"")
    np.testing.assert_allclose(state.values, start, atol=1e-4)
    assert device.time > before
    for n in range(2, 5):
        board.received(encode(Packet(PacketKind.COMMAND, 2, n, n, 0, (0.1, 0.1, 0.1))), "host")
        assert np.isfinite(decode(board.tick() or b"").values).all()


def test_a_healthy_board_goes_on_where_it_is(best: Design) -> None:
    device = simulated_machine(scene_machine(best))
    board = Board(device, device.period, 0.8, 1 << 21, first=lambda: 0)
    board.received(hello(1), "host")
    for n in range(2, 40):
        board.received(encode(Packet(PacketKind.COMMAND, 1, n, n - 1, 0, (0.2, 0.2, 0.2))), "host")
        board.tick()
    moved = device.state[:3].copy()
    assert np.linalg.norm(moved - device.anchor) > 1e-3
    board.received(hello(2), "other" if board.tripped else "host")
    np.testing.assert_array_equal(device.state[:3], moved)


def test_a_session_that_is_sent_again_moves_nothing() -> None:
    """The same number from the same address, HELLO first, as a recorder on the line would have it."""
    motors = FakeDevice([[0.1, 0.2, 0.3]] * 500)
    board = Board(motors, 1e-3, 0.8, 16384)
    reported = [hello(1)]
    newest = decode(board.received(reported[0], "host") or b"").sequence
    for n in range(2, 7):
        reported.append(encode(Packet(PacketKind.COMMAND, 1, n, newest, 0, (0.1, 0.1, 0.1))))
        board.received(reported[-1], "host")
        newest = decode(board.tick() or b"").sequence
    assert np.all(motors.written[-1] == 0.1)
    board.end()
    begun = len(motors.written)
    for data in reported:
        board.received(data, "host")
        board.tick()
    assert (board.sessions, board.counts["FOREIGN"]) == (2, 5)
    assert not np.any(motors.written[begun:])


@pytest.mark.parametrize("sense", [-1.0, 1.0])
def test_its_arms_stop_where_the_machines_do(best: Design, sense: float) -> None:
    machine = scene_machine(best)
    device = simulated_machine(machine)
    low, high = real_plant(machine).stop_low, real_plant(machine).stop_high
    for _ in range(600):
        device.write(np.full(3, 0.3 * sense))
        angles = device.read().angles
    # a stop of 500 N m/rad bends by less than 0.8 / 500 under the torque and the weight
    assert np.isfinite(angles).all()
    assert low - 0.01 < angles.min()
    assert angles.max() < high + 0.01
    assert abs(angles.mean() - (high if sense > 0 else low)) < 0.05
