"""`firmware`: the C controller of a design."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from delta_cad.common.arguments import json_option
from delta_cad.common.console import DONE
from haptics.commands.device import device_arguments, number, refusing

NAME = "firmware"
TEXT = "the controller in C99 for a board: header, code with the design's numbers, and how to use it"


def arguments(command: argparse.ArgumentParser) -> None:
    """Adds the command's arguments."""
    device_arguments(command)
    command.add_argument("--out", type=Path, required=True, metavar="DIR", help="folder for the files; replaced")
    rate = number("number from 100 to 100000 Hz", 100.0, 1e5)
    command.add_argument("--rate", type=rate, default=8000.0, metavar="HZ", help="of the tick; default 8000")
    json_option(command)


@refusing
def run(given: argparse.Namespace) -> int:
    """Runs it and returns the exit code."""
    from delta_cad.common.files import require_room
    from haptics.model.machine import load_machine

    machine = load_machine(given.design, given.masses, given.catalogue)
    require_room(given.out, folder=True)
    from haptics.firmware.generate import sources, write_firmware
    from haptics.simulation.hardware import board_controller
    from haptics.simulation.loops import at_rate

    files = sources(board_controller(machine, at_rate(given.rate)), machine.design.name)
    write_firmware(files, given.out)
    if given.json:
        print(json.dumps({"name": machine.design.name, "folder": str(given.out), "files": sorted(files)}, indent=1))
    else:
        print("\n".join(str(given.out / name) for name in files))
    return DONE
