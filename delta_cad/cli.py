"""The command line: arguments, progress, tables and exit codes. Loads what a command needs only when it runs."""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from delta_cad.build import Outcome
    from delta_cad.design import Design

DONE, CHECK_FAILED, BAD_INPUT, NOT_BUILT = 0, 1, 2, 3
INTERRUPTED = 130  # 128 + SIGINT, as shells have it
EXIT_CODES = """exit codes: 0 done and all checks hold; 1 done, but a check fails; 2 the input or the usage is wrong;
3 the geometry could not be built"""


class _Parser(argparse.ArgumentParser):
    """Usage errors in one line, as all other errors."""

    def error(self, message: str) -> Any:
        self.exit(BAD_INPUT, f"{self.prog}: {message}; see {self.prog} --help\n")


def parser() -> argparse.ArgumentParser:
    """The arguments of `python -m delta_cad`."""
    top = _Parser(
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
    """Runs one command and returns its exit code; a reader that goes away early is no error of ours."""
    try:
        code = _command(parser().parse_args(arguments))
        sys.stdout.flush()
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # what is left goes nowhere
        return DONE
    except KeyboardInterrupt:
        return _refuse("interrupted; nothing was written", INTERRUPTED)
    return code


def _command(given: argparse.Namespace) -> int:
    if given.command == "schema":
        from delta_cad.design import design_schema

        print(json.dumps(design_schema(), indent=2))
        return DONE
    from delta_cad.design import DesignError, load_design

    try:
        design = load_design(given.design)
    except DesignError as error:
        return _refuse(str(error), BAD_INPUT)
    if given.command == "inspect":
        return _inspect(design, given.design, given.json)
    return _make(design, given)


def _refuse(message: str, code: int) -> int:
    print(message.replace("\n", " "), file=sys.stderr)
    return code


def _inspect(design: Design, file: Path, as_json: bool) -> int:
    from delta_cad.mechanism import MechanismError

    try:
        from delta_cad.inspection import inspection

        rows = inspection(design)
    except MechanismError as error:
        return _refuse(f"{file.name}: cube: {error}", BAD_INPUT)
    if as_json:
        print(json.dumps({"name": design.name, "rows": [row.to_json() for row in rows]}, indent=1))
    else:
        from delta_cad.tables import print_inspection

        print_inspection(design.name, rows)
    return DONE if all(row.holds is not False for row in rows) else CHECK_FAILED


def _make(design: Design, given: argparse.Namespace) -> int:
    from delta_cad.mechanism import MechanismError
    from delta_cad.tables import phases, print_outcome

    with phases("loading the CAD kernel") as progress:
        try:
            outcome = _run(design, given, progress)
        except ModuleNotFoundError as error:
            return _refuse(f"{error.name} is not installed: pip install 'delta-haptics[cad]'", NOT_BUILT)
        except MechanismError as error:
            return _refuse(f"{given.design.name}: cube: {error}", BAD_INPUT)
        except OSError as error:
            return _refuse(f"{given.out}: {error.strerror or error}", BAD_INPUT)
        except _geometry_errors() as error:
            return _refuse(f"{given.design.name}: {error}", NOT_BUILT)
    if given.json:
        record = outcome.record() | {"folder": None if outcome.folder is None else str(outcome.folder)}
        print(json.dumps(record, indent=1))
    else:
        print_outcome(outcome)
    return DONE if outcome.passed else CHECK_FAILED


def _run(design: Design, given: argparse.Namespace, progress: Callable[[str], None]) -> Outcome:
    from delta_cad.build import build, check

    if given.command == "build":
        return build(design, given.out, progress, given.step_schema)
    outcome = check(design, progress)
    given.out.mkdir(parents=True, exist_ok=True)
    report = given.out / f"{design.name}.checks.json"
    partial = report.with_suffix(".json.part")
    partial.write_text(json.dumps(outcome.record(), indent=1) + "\n", encoding="utf-8")
    partial.replace(report)
    return outcome


def _geometry_errors() -> tuple[type[Exception], ...]:
    from delta_cad.dimensions import DimensionError
    from delta_cad.export.scene import PictureError
    from delta_cad.export.step import StepError
    from delta_cad.solids.primitive import BuildError

    return (DimensionError, BuildError, StepError, PictureError)
