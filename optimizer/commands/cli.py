"""The command line of the optimiser: its commands and exit codes. Loads what a command needs only when it runs."""

from __future__ import annotations

from collections.abc import Sequence

from delta_cad.common.console import Parser, command_parser, run_command
from optimizer.commands import atlas, certify, design, front, init, reproduce, schema, synthesize, verify

COMMANDS = (init, schema, design, synthesize, reproduce, certify, verify, front, atlas)
EXIT_CODES = (
    "exit codes: 0 done; 1 the requirements cannot be met, or were not; 2 the input or the usage is wrong; "
    "4 a search ended without a result; 130 interrupted by Ctrl-C"
)


def parser() -> Parser:
    """Makes the parser of `python -m optimizer`."""
    description = "Dimensions of a delta haptic device from the customer's requirements."
    return command_parser("python -m optimizer", description, EXIT_CODES, COMMANDS)


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs one command and returns its exit code."""
    return run_command(parser(), arguments, "optimize")
