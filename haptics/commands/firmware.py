"""`firmware`: the C controller of a design."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from delta_cad.common.arguments import json_option
from delta_cad.common.console import BAD_INPUT, DONE, refuse
from haptics.commands.device import device_arguments, number, refusing

NAME = "firmware"
TEXT = "the controller in C99 for a board: start-up, hardware layer, ports to POSIX and Cortex-M, porting guide"


def arguments(command: argparse.ArgumentParser) -> None:
    """Adds the command's arguments."""
    device_arguments(command)
    command.add_argument(
        "--out", type=Path, required=True, metavar="DIR", help="folder of the files; one that a run wrote is replaced"
    )
    rate = number("number from 100 to 100000 Hz", 100.0, 1e5)
    command.add_argument("--rate", type=rate, default=8000.0, metavar="HZ", help="control rate, Hz; default: 8000")
    command.add_argument(
        "--single", action="store_true", help="single precision, for a Cortex-M4; time, faults and heat stay double"
    )
    age = number("number from 0.001 to 10 s", 1e-3, 10.0)
    command.add_argument(
        "--stale",
        type=age,
        default=0.1,
        metavar="S",
        help="age of the last host message at which forces fade, s; default: 0.1",
    )
    command.add_argument("--calibration", type=Path, metavar="FILE", help="calibration.json of this device")
    command.add_argument("--home", action="store_true", help="find the zeros at the lower stops at each start")
    json_option(command)


@refusing
def run(given: argparse.Namespace) -> int:
    """Runs it and returns the exit code."""
    from delta_cad.common.files import require_room
    from haptics.model.machine import load_machine

    machine = load_machine(given.design, given.masses, given.catalogue)
    require_room(given.out, folder=True)
    from haptics.calibration.record import CalibrationError, load_calibration
    from haptics.firmware.project import firmware, write_firmware

    try:
        known = given.calibration and load_calibration(given.calibration, machine.design).unknowns
        files = firmware(machine, given.rate, single=given.single, stale=given.stale, homing=given.home, known=known)
    except CalibrationError as error:
        return refuse(str(error), BAD_INPUT)
    except ValueError as error:
        return refuse(f"--rate {given.rate:g}: {error}", BAD_INPUT)
    write_firmware(files, given.out)
    if given.json:
        print(json.dumps({"name": machine.design.name, "folder": str(given.out), "files": sorted(files)}, indent=1))
    else:
        print("\n".join(str(given.out / name) for name in files))
    return DONE
