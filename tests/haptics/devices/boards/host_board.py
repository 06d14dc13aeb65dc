"""A simulated board with a hand on its handle, in a process of its own; its emergency stop is pressed for a while."""

from __future__ import annotations

import sys

from haptics.devices.board import Board
from haptics.devices.server import listen, serve
from haptics.devices.simulated import SimulatedDevice
from haptics.model.plant import Hand
from tests.haptics.control.supervisor.rig import HOME, LIMITS, PLANT

HAND = Hand(0.1, 6.0, 400.0)


def simulated() -> SimulatedDevice:
    """The machine behind the board, for tests in their own process too."""
    return SimulatedDevice(PLANT, HOME, count=LIMITS.encoder_count, hand=HAND)


def main() -> None:
    patience, pressed, released, limit = (float(word) for word in sys.argv[1:])
    device = simulated()
    board = Board(device, 1e-3, limit, 16384)

    def look() -> bool:
        following = device.time + 1.5 * device.period  # of the reading to come, and half a period for rounding
        board.stop = pressed < following < released
        return False

    with listen() as listening:
        print(listening.getsockname()[1], flush=True)
        serve(board, listening, patience=patience, idle=20.0, once=True, stop=look)


if __name__ == "__main__":
    main()
