"""`interfaces`: the library in C for a design, and the CHAI3D and ROS 2 devices that use it."""

from __future__ import annotations

import argparse

from delta_cad.common.console import DONE, print_result
from delta_cad.common.options import JSON
from haptics.commands.device import DEVICE_OPTIONS, FILES_FOLDER

NAME = "interfaces"
TEXT = "C library for a board of this design, with a CHAI3D device and a ROS 2 node"
OPTIONS = (*DEVICE_OPTIONS, FILES_FOLDER, JSON)


def run(given: argparse.Namespace) -> int:
    """Runs it and returns the exit code."""
    from delta_cad.common.files import require_room
    from haptics.model.machine import load_machine

    machine = load_machine(given.design, given.mass_properties, given.catalogue)
    require_room(given.out, folder=True)
    from haptics.interfaces.sources import write_sources

    files = write_sources(machine, given.out)
    facts = {"name": machine.design.name, "folder": str(given.out), "files": files}
    print_result(given, facts, lambda: print("\n".join(str(given.out / name) for name in files)))
    return DONE
