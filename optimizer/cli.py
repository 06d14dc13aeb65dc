"""The command line: arguments of every command, and the exit codes. Loads what a command needs only when it runs."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence

from optimizer.commands import atlas, certify, front, reproduce, synthesize, verify
from optimizer.console import DONE, EXIT_CODES, INTERRUPTED, Parser, refuse

COMMANDS = (synthesize, reproduce, certify, verify, front, atlas)


def parser() -> Parser:
    """The arguments of `python -m optimizer`."""
    top = Parser(
        prog="python -m optimizer",
        description="Dimensions of a delta haptic device from the customer's requirements.",
        epilog=EXIT_CODES,
    )
    commands = top.add_subparsers(dest="command", required=True, metavar="COMMAND")
    for module in COMMANDS:
        command = commands.add_parser(module.NAME, help=module.TEXT, description=module.TEXT, epilog=EXIT_CODES)
        module.arguments(command)
        command.set_defaults(run=module.run)
    return top


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs one command and returns its exit code; a reader that goes away early is no error of ours."""
    try:
        given = parser().parse_args(arguments)
        code = given.run(given)
        sys.stdout.flush()
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # what is left goes nowhere
        return DONE
    except KeyboardInterrupt:
        return refuse("interrupted; nothing was written", INTERRUPTED)
    return code
