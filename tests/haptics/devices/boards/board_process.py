"""A simulated board in a process of its own: prints its port, serves one session, prints what it dropped."""

from __future__ import annotations

import sys

from haptics.devices.board import Board
from haptics.devices.server import listen, serve
from haptics.devices.simulated import SimulatedDevice
from tests.haptics.control.supervisor.rig import HOME, LIMITS, PLANT


def main() -> None:
    patience = float(sys.argv[1])
    board = Board(SimulatedDevice(PLANT, HOME, count=LIMITS.encoder_count), 1e-3, 0.8, 16384)
    with listen() as listening:
        print(listening.getsockname()[1], flush=True)
        sessions = serve(board, listening, patience=patience, idle=20.0, once=True)
    print(sessions, dict(board.counts), flush=True)


if __name__ == "__main__":
    main()
