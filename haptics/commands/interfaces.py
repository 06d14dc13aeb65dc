"""`interfaces`: the library in C for a design, and the CHAI3D and ROS 2 devices that use it."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from delta_cad.common.arguments import json_option
from delta_cad.common.console import DONE
from haptics.commands.device import device_arguments, refusing

NAME = "interfaces"
TEXT = "C library for a board of this design, with a CHAI3D device and a ROS 2 node"


def arguments(command: argparse.ArgumentParser) -> None:
    """Adds the command's arguments."""
    device_arguments(command)
    command.add_argument(
        "--out", type=Path, required=True, metavar="DIR", help="folder of the files; one that a run wrote is replaced"
    )
    json_option(command)


@refusing
def run(given: argparse.Namespace) -> int:
    """Runs it and returns the exit code."""
    from delta_cad.common.files import require_room
    from haptics.model.machine import load_machine

    machine = load_machine(given.design, given.masses, given.catalogue)
    require_room(given.out, folder=True)
    from haptics.interfaces.sources import write_sources

    files = write_sources(machine, given.out)
    if given.json:
        print(json.dumps({"name": machine.design.name, "folder": str(given.out), "files": files}, indent=1))
    else:
        print("\n".join(str(given.out / name) for name in files))
    return DONE
