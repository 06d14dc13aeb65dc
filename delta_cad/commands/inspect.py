"""`inspect`: figures of a design that need no CAD."""

from __future__ import annotations

import argparse
import json
from pathlib import Path

from delta_cad.commands.machine import (
    all_option,
    design_arguments,
    refuse_design,
    refuse_place,
    suggest,
    suggest_option,
)
from delta_cad.common.console import BAD_INPUT, DONE, NOT_MET, refuse, refuse_all

NAME = "inspect"
TEXT = "table of reach, torque, conditioning, angles and margins, within a second; makes no solids"


def arguments(command: argparse.ArgumentParser) -> None:
    """Adds the command's arguments."""
    design_arguments(command)
    all_option(command)
    text = "inspect four lengths and a cube, of any delta; hardware is neither needed nor looked at"
    command.add_argument("--kinematics", action="store_true", help=text)
    suggest_option(command)
    command.add_argument(
        "--mass-properties",
        type=Path,
        metavar="FILE",
        help="mass_properties.json of a build, for limits on effective mass and torque with gravity",
    )


def run(given: argparse.Namespace) -> int:
    """Prints the table, and why the hardware cannot do; returns the exit code, by the limits in the table."""
    from delta_cad.commands.inspection import inspection
    from delta_cad.commands.tables import print_inspection
    from delta_cad.design import DesignError, load_design
    from delta_cad.drive.held import known_masses
    from delta_cad.drive.masses import MassError, read_mass_properties
    from delta_cad.mechanism import MechanismError
    from delta_cad.structure.hardware.thresholds import refused

    if given.kinematics:
        return _kinematics(given)
    if (code := refuse_place(given)) is not None:
        return code
    try:
        design = load_design(given.design, given.catalogue)
        found = list(refused(design))
        masses = None
        if given.mass_properties is not None:
            data, _ = read_mass_properties(given.mass_properties, design)
            masses = known_masses(data, design, given.mass_properties.name)
        rows = inspection(design, masses)
    except DesignError as error:
        return refuse_design(given, error)
    except MassError as error:
        return refuse(str(error), BAD_INPUT)
    except MechanismError as error:
        return refuse(f"{given.design.name}: cube: {error}", BAD_INPUT)
    holds = all(row.holds is not False for row in rows)
    if not given.json:
        print_inspection(design.name, rows, given.all, len(found))
    for one in found:  # of its hardware: the mechanism's figures are computed all the same
        refuse(f"{given.design.name}: no build: {one}", NOT_MET)
    suggested = suggest(given, design) if found or (given.suggest is not None and not holds) else None
    if given.json:
        record = {"name": design.name, "rows": [row.to_json() for row in rows]}
        print(json.dumps(record | {"refused": [one.record() for one in found], "suggested": suggested}, indent=1))
    return DONE if holds else NOT_MET


def _kinematics(given: argparse.Namespace) -> int:
    """Prints the figures of the mechanism alone; returns the exit code."""
    for name in ("catalogue", "mass_properties", "suggest"):
        if getattr(given, name) is not None:
            option = f"--{name.replace('_', '-')} {getattr(given, name)}"
            return refuse(f"{option}: is of hardware; --kinematics looks at none: leave one of both away", BAD_INPUT)
    from delta_cad.commands.inspection import inspection
    from delta_cad.commands.tables import print_inspection
    from delta_cad.design import DesignError, load_design
    from delta_cad.mechanism import MechanismError

    try:
        design = load_design(given.design, kinematics=True)
        rows = inspection(design, kinematics=True)
    except DesignError as error:
        return refuse_all([str(error), *error.more], BAD_INPUT)
    except MechanismError as error:
        return refuse(f"{given.design.name}: cube: {error}", BAD_INPUT)
    if given.json:
        print(json.dumps({"name": design.name, "rows": [row.to_json() for row in rows]}, indent=1))
    else:
        print_inspection(design.name, rows, whole=True)
    return DONE if all(row.holds is not False for row in rows) else NOT_MET
