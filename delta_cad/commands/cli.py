"""The command line: arguments, progress, tables and exit codes. Loads what a command needs only when it runs."""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from delta_cad.common.console import BAD_INPUT, DONE, INTERRUPTED, Parser, refuse

if TYPE_CHECKING:
    from delta_cad.design import Design
    from delta_cad.pipeline import Outcome

CHECK_FAILED, NOT_BUILT = 1, 3
Answer = tuple[int, Callable[[], None]]  # exit code, and what prints the result
EXIT_CODES = """exit codes: 0 done and all checks hold; 1 done, but a check fails; 2 the input or the usage is wrong;
3 the geometry could not be built; 130 interrupted by Ctrl-C"""


def parser() -> argparse.ArgumentParser:
    """The arguments of `python -m delta_cad`."""
    top = Parser(
        prog="python -m delta_cad",
        description="Delta haptic devices from a design file: CAD, checks, files.",
        epilog=EXIT_CODES,
    )
    commands = top.add_subparsers(dest="command", required=True, metavar="COMMAND")
    texts = {
        "build": "solids, assembly, checks and all files into OUT/NAME (OUT/NAME.rejected if a check fails)",
        "check": "the checks alone; writes OUT/NAME.checks.json only",
        "inspect": "one table: dimensions, reach, torque, conditioning, angles, margins; needs no CAD",
    }
    for name, text in texts.items():
        command = commands.add_parser(name, help=text, description=text, epilog=EXIT_CODES)
        command.add_argument("--design", type=Path, required=True, metavar="FILE", help="design file, delta-design/1")
        command.add_argument("--json", action="store_true", help="the same facts as JSON on stdout")
        if name != "inspect":
            command.add_argument("--out", type=Path, default=Path("out"), metavar="DIR", help="default: out")
        if name == "build":
            command.add_argument("--step-schema", choices=("AP242", "AP214"), default="AP242", help="default: AP242")
    commands.add_parser("schema", help="JSON Schema of the design file", description="JSON Schema of the design file")
    return top


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs one command and returns its exit code; a reader that goes away early does not change it."""
    try:
        code, show = _command(parser().parse_args(arguments))
    except KeyboardInterrupt:
        return _refuse("interrupted; nothing was written", INTERRUPTED)[0]
    try:
        show()
        sys.stdout.flush()
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # what is left goes nowhere
    return code


def _command(given: argparse.Namespace) -> Answer:
    if given.command == "schema":
        from delta_cad.design import design_schema

        return DONE, lambda: print(json.dumps(design_schema(), indent=2))
    from delta_cad.design import DesignError, load_design

    try:
        design = load_design(given.design)
    except DesignError as error:
        return _refuse(str(error), BAD_INPUT)
    if given.command == "inspect":
        return _inspect(design, given.design, given.json)
    return _make(design, given)


def _refuse(message: str, code: int) -> Answer:
    return refuse(message, code), lambda: None


def _inspect(design: Design, file: Path, as_json: bool) -> Answer:
    from delta_cad.commands.inspection import inspection
    from delta_cad.commands.tables import print_inspection
    from delta_cad.mechanism import MechanismError

    try:
        rows = inspection(design)
    except MechanismError as error:
        return _refuse(f"{file.name}: cube: {error}", BAD_INPUT)
    code = DONE if all(row.holds is not False for row in rows) else CHECK_FAILED
    if as_json:
        record = {"name": design.name, "rows": [row.to_json() for row in rows]}
        return code, lambda: print(json.dumps(record, indent=1))
    return code, lambda: print_inspection(design.name, rows)


def _make(design: Design, given: argparse.Namespace) -> Answer:
    from delta_cad.commands.tables import phases, print_outcome
    from delta_cad.mechanism import MechanismError

    try:
        given.out.mkdir(parents=True, exist_ok=True)  # an unusable folder is told before the work, not after
    except OSError as error:
        return _refuse(f"--out {given.out}: {error.strerror or error}; a folder that can be written", BAD_INPUT)
    with phases("loading the CAD kernel") as progress:
        try:
            outcome = _run(design, given, progress)
        except ModuleNotFoundError as error:
            return _refuse(f"{error.name} is not installed: pip install 'delta-haptics[cad]'", NOT_BUILT)
        except MechanismError as error:
            return _refuse(f"{given.design.name}: cube: {error}", BAD_INPUT)
        except PermissionError as error:
            return _refuse(f"--out {given.out}: {error.strerror}; a folder that can be written", BAD_INPUT)
        except _geometry_errors() as error:
            return _refuse(f"{given.design.name}: {error}", NOT_BUILT)
    code = DONE if outcome.passed else CHECK_FAILED
    if given.json:
        record = outcome.record() | {"folder": None if outcome.folder is None else str(outcome.folder)}
        return code, lambda: print(json.dumps(record, indent=1))
    return code, lambda: print_outcome(outcome)


def _run(design: Design, given: argparse.Namespace, progress: Callable[[str], None]) -> Outcome:
    from delta_cad.pipeline import build, check

    if given.command == "build":
        return build(design, given.out, progress, given.step_schema)
    outcome = check(design, progress)
    report = given.out / f"{design.name}.checks.json"
    partial = report.with_suffix(".json.part")
    partial.write_text(json.dumps(outcome.record(), indent=1) + "\n", encoding="utf-8")
    partial.replace(report)
    return outcome


def _geometry_errors() -> tuple[type[Exception], ...]:
    from delta_cad.dimensions import DimensionError
    from delta_cad.export.mass_properties import MassError
    from delta_cad.export.meshes import MeshError
    from delta_cad.export.step import StepError
    from delta_cad.export.views.scene import PictureError
    from delta_cad.solids.primitive import BuildError

    return (DimensionError, BuildError, MassError, MeshError, StepError, PictureError)
