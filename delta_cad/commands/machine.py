"""The common part of the commands that make a machine: arguments, refusals, the display of the result."""

from __future__ import annotations

import argparse
import json
import os
from collections.abc import Callable, Sequence
from contextlib import suppress
from importlib.util import find_spec
from pathlib import Path
from typing import TYPE_CHECKING, Any

from delta_cad.common.console import (
    BAD_INPUT,
    DONE,
    NOT_BUILT,
    NOT_MET,
    ProgressLine,
    Step,
    print_result,
    refuse,
    refuse_all,
    refuse_folder,
)
from delta_cad.common.files import require_room
from delta_cad.common.options import CATALOGUE, DESIGN, JSON, NO_CACHE, OUT_FOLDER, PROGRESS, Option
from delta_cad.common.refusal import not_installed

if TYPE_CHECKING:
    from delta_cad.design import Design, DesignError

# Imported late, some after a minute of work: that all are there is looked at first.
_BUILT_WITH = ("cadquery", "trimesh", "fcl", "lxml", "networkx", "jinja2", "ezdxf", "fontTools", "matplotlib")
# How the names of the phases of each step begin; any other phase is of step `_CHECKS`.
_PHASES: tuple[tuple[str, ...], ...] = (
    ("loading",),
    ("dimensions", "solid ", "masses", "mesh "),
    (),
    ("drawings", "meshes", "quotation", "manual", "report.html", "manifest"),
)
_CHECKS = 2
# Command -> names of its steps; other commands have none.
_STEPS = {
    "build": ("loading", "solids", "checks and STEP files", "drawings, pictures and report"),
    "check": ("loading", "solids", "checks"),
}
# design, what was typed, what to call with the name of the next phase -> what came of it: passed, folder, record()
_Work = Callable[["Design", argparse.Namespace, Callable[[str], None]], Any]
# design, what was typed -> where that is written
_Place = Callable[["Design", argparse.Namespace], Path]

ALL = Option("--all", action="store_true", help="print the full table, not only failures and ten key figures")
SUGGEST = Option(
    "--suggest",
    type=Path,
    metavar="FILE",
    help="where the design is refused: write the smallest change found that passes all closed forms as a design file; "
    "requirements stay as they are",
)
DESIGN_OPTIONS = (DESIGN, CATALOGUE, JSON)
MACHINE_OPTIONS = (*DESIGN_OPTIONS, OUT_FOLDER, NO_CACHE, PROGRESS)


def made(
    given: argparse.Namespace, work: _Work, place: _Place, *, folder: bool, tell: Callable[[Any], None] | None = None
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

    if (code := refuse_place(given)) is not None:
        return code
    try:
        design = load_design(given.design, given.catalogue)
    except DesignError as error:
        return refuse_design(given, error)
    from delta_cad.commands.tables import print_outcome
    from delta_cad.mechanism import MechanismError

    try:
        if (code := refuse_hardware(given, design)) is not None:
            return code
    except MechanismError as error:
        return refuse(f"{given.design.name}: cube: {error}", BAD_INPUT)
    try:
        require_room(place(design, given), folder=folder)
    except OSError as error:
        return refuse_folder(given.out, error)
    if absent := [name for name in _BUILT_WITH if find_spec(name) is None]:
        return refuse(not_installed(absent[0], "cad"), NOT_BUILT)
    less = (name for name in ("no_drawings", "no_report") if getattr(given, name, False))
    with ProgressLine(work=" ".join([given.command, *less])) as line:
        show = in_steps(line.show, _STEPS.get(given.command, ()))
        show("loading the CAD kernel")
        try:
            outcome = work(design, given, show)
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
    facts = outcome.record() | {"folder": None if outcome.folder is None else str(outcome.folder)}
    print_result(given, facts, lambda: tell(outcome) if tell else print_outcome(outcome, whole=given.all))
    return DONE if outcome.passed else NOT_MET


def in_steps(show: Callable[[str], None], steps: Sequence[str]) -> Callable[[str], None]:
    """Makes a report of phases one of steps: a step ends where a phase of a later one begins.

    Args:
        show: Takes the steps.
        steps: Their names; none: phases are shown as they are.
    """
    reached = 0

    def phase(name: str) -> None:
        nonlocal reached
        number = next((k for k, begins in enumerate(_PHASES) if begins and name.startswith(begins)), _CHECKS)
        reached = min(max(reached, number), len(steps) - 1)
        show(Step(name, steps[reached], reached + 1, len(steps)))

    return phase if steps else show


def refuse_hardware(given: argparse.Namespace, design: Design) -> int | None:
    """Prints every closed-form reason why a design is refused, each as it is found, and with `--json` as records.

    Args:
        given: What was typed.
        design: The design.

    Returns:
        The exit code; None where nothing refuses it.
    """
    from delta_cad.structure.hardware.thresholds import refused

    records = list[dict[str, Any]]()
    for one in refused(design):
        refuse(f"{given.design.name}: {one}", BAD_INPUT)
        records.append(one.record())
    if not records:
        return None
    return _refuse(given, design, records)


def refuse_design(given: argparse.Namespace, error: DesignError) -> int:
    """Refuses a design file with all that was found in it and, where it can be computed with, its hardware."""
    from delta_cad.mechanism import MechanismError
    from delta_cad.structure.hardware.thresholds import refused

    lines, design = error.lines, error.design
    refuse_all(lines, BAD_INPUT)
    if design is None:
        return BAD_INPUT
    records: list[dict[str, Any]] = [{"message": line} for line in lines]
    with suppress(MechanismError, ValueError, ArithmeticError):  # its numbers cannot go together, which is said already
        for one in refused(design):
            refuse(f"{given.design.name}: {one}", BAD_INPUT)
            records.append(one.record())
    return _refuse(given, design, records)


def _refuse(given: argparse.Namespace, design: Design, records: Sequence[dict[str, Any]]) -> int:
    suggested = suggest(given, design) if getattr(given, "suggest", None) or "part" in records[-1] else None
    if getattr(given, "json", False):  # `view` has none
        record = {"name": design.name, "passed": False, "refused": records, "suggested": suggested, "folder": None}
        print(json.dumps(record, indent=1))
    return BAD_INPUT


def refuse_place(given: argparse.Namespace) -> int | None:
    """Refuses a file for a suggestion that is there already or cannot be written, before the work."""
    file: Path | None = getattr(given, "suggest", None)
    if file is None:
        return None
    if file.exists():
        return refuse(f"--suggest {file}: exists; must be the name of a new file", BAD_INPUT)
    try:
        require_room(file)
    except OSError as error:
        return refuse(f"--suggest {file}: {error.strerror or error}; must be a file that can be written", BAD_INPUT)
    return None


def suggest(given: argparse.Namespace, design: Design) -> dict[str, Any] | None:
    """Writes the suggestion that was asked for and tells what it changes; without `--suggest` it tells of that.

    Returns:
        The same as a record; None where none was asked for or found.
    """
    from delta_cad.common.files import write_whole
    from delta_cad.design import design_hash, design_to_json
    from delta_cad.structure.hardware.suggestion import suggestion

    if not hasattr(given, "suggest"):
        return None
    file: Path | None = given.suggest
    if file is None:
        refuse(f"{given.design.name}: --suggest FILE writes the smallest change found that passes all this", BAD_INPUT)
        return None
    found = suggestion(design)
    if found is None:
        words = "no change of lengths and parts was found that passes all closed forms; requirements were not changed"
        refuse(f"{given.design.name}: {words}; {file.name} was not written", BAD_INPUT)
        return None
    hardware = found.design.hardware
    if hardware.catalogue is not None:
        folder = Path(os.path.relpath(given.design.parent / hardware.catalogue, file.parent)).as_posix()
        hardware = hardware.model_copy(update={"catalogue": folder})
    provenance = {"suggestion": {"input_sha256": design_hash(design), "was": dict(found.own)}}
    write_whole(file, design_to_json(found.design.model_copy(update={"hardware": hardware, "provenance": provenance})))
    margin = "" if found.with_margin else "; closed forms pass without the margin that solids take: check it"
    refuse(f"{file.name}: {found}: the smallest change found; requirements are the same{margin}", BAD_INPUT)
    return {"file": str(file), "values": dict(found.values), "was": dict(found.own), "with_margin": found.with_margin}


def geometry_errors() -> tuple[type[Exception], ...]:
    """Gives the errors of geometry that cannot be made; loads the CAD kernel."""
    from delta_cad.common.worker_process import WorkerProcessError
    from delta_cad.dimensions import DimensionError
    from delta_cad.export.mass_properties import MassPropertiesError
    from delta_cad.export.meshes import MeshError
    from delta_cad.export.step import StepError
    from delta_cad.export.views.scene import PictureError
    from delta_cad.solids.primitive import BuildError

    return (WorkerProcessError, DimensionError, BuildError, MassPropertiesError, MeshError, StepError, PictureError)
