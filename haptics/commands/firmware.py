"""`firmware`: the C controller of a design."""

from __future__ import annotations

import argparse

from delta_cad.common.console import BAD_INPUT, DONE, print_result, refuse
from delta_cad.common.options import CALIBRATION, JSON, Option, number
from haptics.commands.device import DEVICE_OPTIONS, FILES_FOLDER, HERTZ

NAME = "firmware"
TEXT = "the controller in C99 for a board: start-up, hardware layer, ports to POSIX and Cortex-M, porting guide"
OPTIONS = (
    *DEVICE_OPTIONS,
    FILES_FOLDER,
    Option("--rate", type=HERTZ, default=8000.0, metavar="HZ", help="control rate, Hz; default: 8000"),
    Option(
        "--single", action="store_true", help="single precision, for a Cortex-M4; time, faults and heat stay double"
    ),
    Option(
        "--stale",
        type=number(1e-3, 10.0, "s"),
        default=0.1,
        metavar="S",
        help="age of the last host message at which forces fade, s; default: 0.1",
    ),
    CALIBRATION,
    Option("--home", action="store_true", help="find the zeros at the lower stops at each start"),
    JSON,
)


def run(given: argparse.Namespace) -> int:
    """Runs it and returns the exit code."""
    from delta_cad.common.files import require_room
    from haptics.model.machine import load_machine

    machine = load_machine(given.design, given.mass_properties, given.catalogue)
    require_room(given.out, folder=True)
    from haptics.calibration.record import load_calibration
    from haptics.firmware.project import firmware, write_firmware

    known = given.calibration and load_calibration(given.calibration, machine.design).unknowns
    try:
        files = firmware(machine, given.rate, single=given.single, stale=given.stale, homing=given.home, known=known)
    except ValueError as error:
        return refuse(f"--rate {given.rate:g}: {error}", BAD_INPUT)
    write_firmware(files, given.out)
    facts = {"name": machine.design.name, "folder": str(given.out), "files": sorted(files)}
    print_result(given, facts, lambda: print("\n".join(str(given.out / name) for name in files)))
    return DONE
