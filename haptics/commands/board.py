"""`board`: the simulated machine behind the socket protocol, in place of a controller board."""

from __future__ import annotations

import argparse
import sys
from typing import TYPE_CHECKING

from delta_cad.common.console import BAD_INPUT, DONE, INTERRUPTED, refuse
from haptics.commands.device import device_arguments

if TYPE_CHECKING:
    from haptics.devices.board import Board

NAME = "board"
TEXT = "simulated controller board on a socket, for hosts that speak haptics/devices/PROTOCOL.md"


def arguments(command: argparse.ArgumentParser) -> None:
    """Adds the command's arguments."""
    device_arguments(command)
    command.add_argument(
        "--host", default="127.0.0.1", metavar="ADDRESS", help="address to listen on; default: 127.0.0.1"
    )
    command.add_argument(
        "--port", type=int, default=0, metavar="N", help="port to listen on; default: any free one, which is printed"
    )
    command.add_argument("--allow-remote", action="store_true", help="let other machines connect; there is no password")
    command.add_argument(
        "--paced", action="store_true", help="tick in real time instead of as fast as the host answers"
    )
    command.add_argument("--once", action="store_true", help="exit after the first session")
    command.add_argument(
        "--idle", type=float, default=60.0, metavar="S", help="exit after this time without a host, s; default: 60"
    )


def run(given: argparse.Namespace) -> int:
    """Runs it and returns the exit code."""
    from delta_cad.design import DesignError
    from delta_cad.drive.masses import MassError
    from haptics.devices.server import listen, serve

    try:
        if not 0 <= given.port <= 65535:
            return refuse(f"--port {given.port}: must be 0 to 65535", BAD_INPUT)
        if not 0.0 < given.idle < 1e6:
            return refuse(f"--idle {given.idle:g}: must be more than 0 s and at most 1e6 s", BAD_INPUT)
        board, period = _board(given)
        listening = listen(given.host, given.port, allow_remote=given.allow_remote)
    except (DesignError, MassError) as error:
        return refuse(str(error), BAD_INPUT)
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

    machine = load_machine(given.design, given.masses, given.catalogue)
    device = simulated_machine(machine, linked=True)
    counts = round(joint_counts_per_turn(machine.design))
    return Board(device, device.period, machine.drive.controlled_torque_N_m, counts), device.period
