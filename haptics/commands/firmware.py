"""`firmware`: the C controller of a design."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from delta_cad.common.console import DONE
from haptics.commands.device import device_arguments, refusing

NAME = "firmware"
TEXT = "the controller in C99 for a board: header, code with the design's numbers, and how to use it"


def arguments(command: argparse.ArgumentParser) -> None:
    """Adds the command's arguments."""
    device_arguments(command)
    command.add_argument("--out", type=Path, required=True, metavar="DIR", help="folder for the files; replaced")
    command.add_argument("--json", action="store_true", help="the names of the files as JSON on stdout")


@refusing
def run(given: argparse.Namespace) -> int:
    """Runs it and returns the exit code."""
    from delta_cad.common.files import require_room
    from haptics.model.machine import load_machine

    machine = load_machine(given.design, given.masses, given.catalogue)
    require_room(given.out, folder=True)
    from haptics.firmware.generate import sources, write_firmware
    from haptics.simulation.assumptions import default_controller

    files = sources(default_controller(machine), machine.design.name)
    write_firmware(files, given.out)
    if given.json:
        print(json.dumps({"name": machine.design.name, "folder": str(given.out), "files": sorted(files)}, indent=1))
    else:
        print("\n".join(str(given.out / name) for name in files))
    return DONE
