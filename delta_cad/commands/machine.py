"""The common part of the commands that make a machine: arguments, refusals, the display of the result."""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import asdict, replace
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

from delta_cad.common.arguments import design_option, json_option, out_option
from delta_cad.common.console import BAD_INPUT, DONE, NOT_MET, Line, catalogue_option, refuse, refuse_all, refuse_folder
from delta_cad.common.files import require_room
from delta_cad.common.refusal import not_installed

if TYPE_CHECKING:
    from delta_cad.design import Design, DesignError
    from delta_cad.structure.hardware.advice import Advice

NOT_BUILT = 3
# Imported late, some after a minute of work: that all are there is looked at first.
BUILT_WITH = ("cadquery", "trimesh", "fcl", "lxml", "networkx", "jinja2", "ezdxf", "fontTools", "matplotlib")
# design, what was typed, what to call with the name of the next phase -> what came of it: passed, folder, record()
Work = Callable[["Design", argparse.Namespace, Callable[[str], None]], Any]
# design, what was typed -> where that is written
Place = Callable[["Design", argparse.Namespace], Path]


def design_arguments(command: argparse.ArgumentParser) -> None:
    """Adds the design file, the folder of own parts and the form of the answer."""
    design_option(command)
    catalogue_option(command)
    json_option(command)


def all_option(command: argparse.ArgumentParser) -> None:
    """Adds `--all`, with which everything is told, not what fails and ten figures."""
    command.add_argument(
        "--all", action="store_true", help="print the full table, not only failures and ten key figures"
    )


def machine_arguments(command: argparse.ArgumentParser) -> None:
    """Adds what `design_arguments` adds and the folder for what is written."""
    design_arguments(command)
    out_option(command)


def made(
    given: argparse.Namespace, work: Work, place: Place, *, folder: bool, tell: Callable[[Any], None] | None = None
) -> int:
    """Does a command's work on the design that was typed, shows what came of it and returns the exit code.

    Args:
        given: What was typed.
        work: The work.
        place: Where its files go; that it can be written there is made sure before the work, not after.
        folder: Whether that is a folder.
        tell: Shows a person what came of it; None: `tables.print_outcome`.
    """
    from delta_cad.design import DesignError, load_design

    try:
        design = load_design(given.design, given.catalogue)
    except DesignError as error:
        return refuse_design(given, error)
    from delta_cad.commands.tables import print_outcome
    from delta_cad.mechanism import MechanismError

    try:
        if (found := refused(design, given.design.name)).reasons:
            return refuse_hardware(given, design.name, [], found, told=len(found.reasons))
    except MechanismError as error:
        return refuse(f"{given.design.name}: cube: {error}", BAD_INPUT)
    try:
        require_room(place(design, given), folder=folder)
    except OSError as error:
        return refuse_folder(given.out, error)
    if absent := [name for name in BUILT_WITH if find_spec(name) is None]:
        return refuse(not_installed(absent[0], "cad"), NOT_BUILT)
    with Line() as line:
        line.show("loading the CAD kernel")
        try:
            outcome = work(design, given, line.show)
        except KeyboardInterrupt:  # the last clause would load the CAD kernel, again where that was interrupted
            raise
        except ModuleNotFoundError as error:
            return refuse(not_installed(str(error.name), "cad"), NOT_BUILT)
        except MechanismError as error:
            return refuse(f"{given.design.name}: cube: {error}", BAD_INPUT)
        except OSError as error:
            return refuse_folder(given.out, error)
        except geometry_errors() as error:
            return refuse(f"{given.design.name}: {error}", NOT_BUILT)
    if given.json:
        landed = None if outcome.folder is None else str(outcome.folder)
        print(json.dumps(outcome.record() | {"folder": landed}, indent=1))
    else:
        (tell or partial(print_outcome, whole=getattr(given, "all", False)))(outcome)
    return DONE if outcome.passed else NOT_MET


def refused(design: Design, file: str = "") -> Advice:
    """Gives every reason why the hardware of a design cannot do, in closed form: no kernel is loaded for it.

    Args:
        design: The design.
        file: Name of its file, under which the reasons are told at once, before what would do is looked for; "": not.
    """
    from delta_cad.structure.hardware.advice import advice

    def tell(reasons: Sequence[object]) -> None:
        refuse_all([f"{file}: {reason}" for reason in reasons], BAD_INPUT)

    return advice(design, tell if file else None)


def hardware_lines(found: Advice) -> list[str]:
    """Says why hardware cannot do: what is wrong, what would be once that is mended, and values that mend it all."""
    lines = [*map(str, found.reasons), *(f"then {reason}" for reason in found.then)]
    first = {reason.field for reason in found.reasons[:1]}
    alone = len(lines) == 1 and set(found.together or ()) == first  # which its one line says
    if found.together and not alone:
        values = ", ".join(
            f"{field} = {value if isinstance(value, str) else f'{value:g}'}" for field, value in found.together.items()
        )
        lines.append(f"together {values} leave nothing of this; inspect tells what they make of the other limits")
    return lines


def refuse_design(given: argparse.Namespace, error: DesignError) -> int:
    """Refuses a design file with all that was found in it and, where it can be computed with, its hardware."""
    from delta_cad.mechanism import MechanismError
    from delta_cad.structure.hardware.advice import DESIGN, Advice, advice

    found = Advice(())
    if error.design is not None:
        with suppress(MechanismError, ValueError, ArithmeticError):  # told already: its numbers cannot go together
            found = advice(error.design)
    name = "" if error.design is None else error.design.name
    fresh = tuple(reason for reason in found.reasons if reason.part != DESIGN)
    found = replace(found, reasons=fresh) if fresh else Advice(())  # what follows of numbers alone they say themselves
    return refuse_hardware(given, name, (str(error), *error.more), found)


def refuse_hardware(given: argparse.Namespace, name: str, lines: Sequence[str], found: Advice, told: int = 0) -> int:
    """Tells why a design is refused, one line a reason, and with `--json` as records, too.

    Args:
        given: What was typed.
        name: The design's name; "" where its file could not be read as one.
        lines: Lines of the design file's own refusal.
        found: Why its hardware cannot do.
        told: How many of its lines were told before.
    """
    if given.json and name:
        said = [{"message": line} for line in lines]
        print(json.dumps({"name": name, "passed": False, **hardware_record(found, said), "folder": None}, indent=1))
    left = hardware_lines(found)[told:]
    return refuse_all([*lines, *(f"{given.design.name}: {line}" for line in left)], BAD_INPUT)


def hardware_record(found: Advice, told: Sequence[dict[str, str]] = ()) -> dict[str, Any]:
    """Gives what `hardware_lines` says as plain data, after what was told before."""
    return {
        "refused": [*told, *map(asdict, found.reasons)],
        "then": [*map(asdict, found.then)],
        "together": dict(found.together or {}),
    }


def geometry_errors() -> tuple[type[Exception], ...]:
    """Gives the errors of geometry that cannot be made; loads the CAD kernel."""
    from delta_cad.common.beside import BesideError
    from delta_cad.dimensions import DimensionError
    from delta_cad.export.mass_properties import MassPropertiesError
    from delta_cad.export.meshes import MeshError
    from delta_cad.export.step import StepError
    from delta_cad.export.views.scene import PictureError
    from delta_cad.solids.primitive import BuildError

    return (BesideError, DimensionError, BuildError, MassPropertiesError, MeshError, StepError, PictureError)
