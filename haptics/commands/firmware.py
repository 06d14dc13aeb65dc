"""`firmware`: the C controller of a design."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from delta_cad.common.console import BAD_INPUT, DONE, refuse
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
    from haptics.model.machine import load_machine

    machine = load_machine(given.design, given.masses)
    from haptics.firmware.generate import sources, write_firmware
    from haptics.simulation.assumptions import default_controller

    try:
        controller = default_controller(machine)
    except ValueError as error:
        return refuse(f"{given.design.name}: {error}", BAD_INPUT)
    files = sources(controller, machine.design.name)
    try:
        write_firmware(files, given.out)
    except OSError as error:
        return refuse(f"--out {given.out}: {error.strerror or error}", BAD_INPUT)
    if given.json:
        print(json.dumps({"name": machine.design.name, "folder": str(given.out), "files": sorted(files)}, indent=1))
    else:
        print("\n".join(str(given.out / name) for name in files))
    return DONE
