"""The command line: its commands and exit codes. Loads what a command needs only when it runs."""

from __future__ import annotations

from collections.abc import Sequence

from delta_cad.commands import build, check, drawings, fixture, inspect, schema, view
from delta_cad.common.console import Parser, command_parser, run_command

COMMANDS = (build, check, drawings, fixture, inspect, view, schema)
EXIT_CODES = """exit codes: 0 done and all checks hold; 1 done, but a check fails; 2 the input or the usage is wrong;
3 the geometry could not be built; 130 interrupted by Ctrl-C"""


def parser() -> Parser:
    """The arguments of `python -m delta_cad`."""
    description = "Delta haptic devices from a design file: CAD, checks, files."
    return command_parser("python -m delta_cad", description, EXIT_CODES, COMMANDS)


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs one command and returns its exit code."""
    return run_command(parser(), arguments, "cad")
