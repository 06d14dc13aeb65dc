"""The command line: arguments of every command, and the exit codes. Loads what a command needs only when it runs."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence

from delta_cad.console import BAD_INPUT, DONE, INTERRUPTED, Parser, refuse, with_negatives
from haptics.commands import firmware, gravity, stiffness

COMMANDS = (firmware, gravity, stiffness)
EXIT_CODES = "exit codes: 0 done; 1 done, but a promise fails; 2 the input or the usage is wrong"


def parser() -> Parser:
    """The arguments of `python -m haptics`."""
    top = Parser(
        prog="python -m haptics",
        description="What a delta haptic device will feel like, and the controller that drives it.",
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
        given = parser().parse_args(with_negatives(sys.argv[1:] if arguments is None else arguments))
        code = given.run(given)
        sys.stdout.flush()
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # what is left goes nowhere
        return DONE
    except KeyboardInterrupt:
        return refuse("interrupted; nothing was written", INTERRUPTED)
    except ModuleNotFoundError as error:
        return refuse(f"{error.name} is not installed: pip install 'delta-haptics[sim]'", BAD_INPUT)
    return code
