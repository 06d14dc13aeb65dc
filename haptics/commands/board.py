"""`board`: the simulated machine behind the socket protocol, instead of a controller board."""

from __future__ import annotations

import argparse
import sys
from typing import TYPE_CHECKING

from delta_cad.common.console import BAD_INPUT, DONE, INTERRUPTED, refuse
from delta_cad.common.options import MOST_PORT, POSITIVE, Option, number, whole
from delta_cad.common.refusal import RefusedError
from haptics.commands.device import DEVICE_OPTIONS

if TYPE_CHECKING:
    from haptics.devices.board import Board

NAME = "board"
TEXT = "simulated controller board on a socket, for hosts that speak haptics/devices/PROTOCOL.md"
OPTIONS = (
    *DEVICE_OPTIONS,
    Option("--host", default="127.0.0.1", metavar="ADDRESS", help="address to listen on; default: 127.0.0.1"),
    Option(
        "--port",
        type=whole(0, MOST_PORT),
        default=0,
        metavar="N",
        help="port to listen on; default: any free one, which is printed",
    ),
    Option("--allow-remote", action="store_true", help="let other machines connect; there is no password"),
    Option("--paced", action="store_true", help="tick in real time instead of as fast as the host answers"),
    Option("--once", action="store_true", help="exit after the first session"),
    Option(
        "--idle",
        type=number(POSITIVE, 1e6, "s"),
        default=60.0,
        metavar="S",
        help="exit after this time without a host, s; default: 60",
    ),
)


def run(given: argparse.Namespace) -> int:
    """Runs it and returns the exit code."""
    from haptics.devices.server import listen, serve

    try:
        board, period = _board(given)
        listening = listen(given.host, given.port, allow_remote=given.allow_remote)
    except RefusedError:
        raise
    except (ValueError, OSError) as error:
        return refuse(f"--host {given.host} --port {given.port}: {error}", BAD_INPUT)
    with listening:
        host, port = listening.getsockname()[:2]
        print(f"listening on {host} {port}")
        sys.stdout.flush()
        patience = period if given.paced else 0.05
        try:
            serve(board, listening, patience=patience, paced=given.paced, idle=given.idle, once=given.once)
        except KeyboardInterrupt:  # the way to end it by hand
            return refuse(f"interrupted; {_summary(board)}", INTERRUPTED)
    print(_summary(board))
    return DONE


def _summary(board: Board) -> str:
    """Summary of what the board served and dropped, in one line."""
    dropped = ", ".join(f"{number} {why}" for why, number in sorted(board.counts.items())) or "nothing"
    return f"{board.sessions} sessions, {board.served} commands served; dropped: {dropped}"


def _board(given: argparse.Namespace):
    from delta_cad.drive import joint_counts_per_turn
    from haptics.devices.board import Board
    from haptics.devices.simulated import simulated_machine
    from haptics.model.machine import load_machine

    machine = load_machine(given.design, given.mass_properties, given.catalogue)
    device = simulated_machine(machine, linked=True)
    counts = round(joint_counts_per_turn(machine.design))
    return Board(device, device.period, machine.drive.controlled_torque_N_m, counts), device.period
