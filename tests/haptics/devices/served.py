"""The simulated board of a machine on a socket, served by a thread."""

from __future__ import annotations

import socket
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass

from haptics.devices.board import Board
from haptics.devices.server import listen, serve
from haptics.devices.simulated import SimulatedDevice, simulated_machine
from haptics.model.machine import MachineModel

PATIENT = 20.0
"""Seconds that a board in a test waits for its host: longer than any pause of a busy machine."""


@dataclass
class Served:
    port: int
    board: Board
    device: SimulatedDevice
    listening: socket.socket


@contextmanager
def served(machine: MachineModel, *, torque: float | None = None) -> Iterator[Served]:
    """Serves until the block ends."""
    device, done = simulated_machine(machine, linked=True), threading.Event()
    limit = machine.drive.controlled_torque_N_m if torque is None else torque
    board = Board(device, device.period, limit, 1 << 21)
    with listen() as listening:

        def forever() -> None:
            while not done.is_set():
                serve(board, listening, patience=PATIENT, idle=0.5, stop=done.is_set)

        runner = threading.Thread(target=forever)
        runner.start()
        try:
            yield Served(listening.getsockname()[1], board, device, listening)
        finally:
            done.set()
            runner.join()
