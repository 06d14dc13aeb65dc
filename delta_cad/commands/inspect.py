"""`inspect`: figures of a design that need no CAD."""

from __future__ import annotations

import argparse
import json
from pathlib import Path
from typing import Any

from delta_cad.commands.machine import (
    ALL,
    SUGGEST,
    refuse_design,
    refuse_place,
    suggest,
)
from delta_cad.common.console import BAD_INPUT, DONE, NOT_MET, refuse
from delta_cad.common.options import CATALOGUE, DESIGN, JSON, MASS_PROPERTIES, Option, settle_design

NAME = "inspect"
TEXT = "table of reach, torque, conditioning, angles and margins; makes no solids"
_OF_HARDWARE = ("catalogue", "mass_properties", "suggest")
_OF_DESIGN = Path()  # FILE is left out: that of --design


def _settle(command: argparse.ArgumentParser, given: argparse.Namespace) -> None:
    """Takes the design of the current folder, where `--kinematics` names no file."""
    if given.kinematics is None or given.kinematics == _OF_DESIGN:
        settle_design(command, given)
    elif given.design is not None:
        command.error(f"--design {given.design}: --kinematics {given.kinematics} is inspected: leave one of both out")


OPTIONS = (
    DESIGN.but(settle=_settle),
    CATALOGUE,
    JSON,
    ALL,
    Option(
        "--kinematics",
        type=Path,
        nargs="?",
        const=_OF_DESIGN,
        metavar="FILE",
        help="inspect lengths and a cube of any delta, up to 3 m; no hardware is looked at; default: that of --design",
    ),
    SUGGEST,
    MASS_PROPERTIES.but(help="mass_properties.json of a build, for limits on effective mass and torque with gravity"),
)


def run(given: argparse.Namespace) -> int:
    """Prints the table, and why the hardware cannot do; returns the exit code, by the limits in the table."""
    from delta_cad.commands.inspection import inspection
    from delta_cad.commands.tables import print_inspection
    from delta_cad.design import DesignError, load_design
    from delta_cad.drive.held import known_masses
    from delta_cad.drive.masses import read_mass_properties
    from delta_cad.mechanism import MechanismError
    from delta_cad.structure.hardware.thresholds import refused

    if given.kinematics is not None:
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
    except MechanismError as error:
        return refuse(f"{given.design.name}: cube: {error}", BAD_INPUT)
    holds = all(row.holds is not False for row in rows)
    if not given.json:
        print_inspection(design.name, rows, given.all, len(found))
    for one in found:  # of its hardware: the mechanism's figures are computed all the same
        refuse(f"{given.design.name}: no build: {one}", NOT_MET)
    suggested = suggest(given, design) if found or (given.suggest is not None and not holds) else None
    if given.json:
        record: dict[str, Any] = {"name": design.name, "rows": [row.to_json() for row in rows]}
        record |= {"refused": [one.record() for one in found], "suggested": suggested}
        print(json.dumps(record, indent=1))
    return DONE if holds else NOT_MET


def _kinematics(given: argparse.Namespace) -> int:
    """Prints the table of a delta of which lengths alone are known."""
    from delta_cad.commands.kinematic import kinematic_rows
    from delta_cad.commands.tables import print_inspection
    from delta_cad.design.lengths import load_lengths
    from delta_cad.mechanism import MechanismError

    for name in _OF_HARDWARE:
        if getattr(given, name) is not None:
            option = f"--{name.replace('_', '-')} {getattr(given, name)}"
            return refuse(f"{option}: is of hardware; --kinematics looks at none: leave one of both away", BAD_INPUT)
    file: Path = given.design if given.kinematics == _OF_DESIGN else given.kinematics
    try:
        lengths = load_lengths(file)
        rows = kinematic_rows(lengths, file.name)
    except MechanismError as error:
        return refuse(f"{file.name}: cube: {error}", BAD_INPUT)
    if given.json:
        print(json.dumps({"name": lengths.design.name, "rows": [row.to_json() for row in rows]}, indent=1))
    else:
        print_inspection(lengths.design.name, rows, whole=True)
    return DONE if all(row.holds is not False for row in rows) else NOT_MET
