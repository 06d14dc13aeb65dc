"""`inspect`: figures of a design that need no CAD."""

from __future__ import annotations

import argparse
import json
from typing import Any

from delta_cad.commands.machine import (
    ALL,
    DESIGN_OPTIONS,
    SUGGEST,
    refuse_design,
    refuse_place,
    suggest,
)
from delta_cad.common.console import BAD_INPUT, DONE, NOT_MET, refuse
from delta_cad.common.options import MASS_PROPERTIES, Option

NAME = "inspect"
TEXT = "table of reach, torque, conditioning, angles and margins, within a second; makes no solids"
_OF_HARDWARE = ("catalogue", "mass_properties", "suggest")
OPTIONS = (
    *DESIGN_OPTIONS,
    ALL,
    Option(
        "--kinematics",
        action="store_true",
        help="inspect four lengths and a cube, of any delta; hardware is neither needed nor looked at",
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

    kinematics = given.kinematics
    for name in _OF_HARDWARE if kinematics else ():
        if getattr(given, name) is not None:
            option = f"--{name.replace('_', '-')} {getattr(given, name)}"
            return refuse(f"{option}: is of hardware; --kinematics looks at none: leave one of both away", BAD_INPUT)
    if (code := refuse_place(given)) is not None:
        return code
    try:
        design = load_design(given.design, given.catalogue, kinematics=kinematics)
        found = [] if kinematics else list(refused(design))
        masses = None
        if given.mass_properties is not None:
            data, _ = read_mass_properties(given.mass_properties, design)
            masses = known_masses(data, design, given.mass_properties.name)
        rows = inspection(design, masses, kinematics=kinematics)
    except DesignError as error:
        if kinematics:
            raise
        return refuse_design(given, error)
    except MechanismError as error:
        return refuse(f"{given.design.name}: cube: {error}", BAD_INPUT)
    holds = all(row.holds is not False for row in rows)
    if not given.json:
        print_inspection(design.name, rows, given.all or kinematics, len(found))
    for one in found:  # of its hardware: the mechanism's figures are computed all the same
        refuse(f"{given.design.name}: no build: {one}", NOT_MET)
    suggested = suggest(given, design) if found or (given.suggest is not None and not holds) else None
    if given.json:
        record: dict[str, Any] = {"name": design.name, "rows": [row.to_json() for row in rows]}
        if not kinematics:
            record |= {"refused": [one.record() for one in found], "suggested": suggested}
        print(json.dumps(record, indent=1))
    return DONE if holds else NOT_MET
