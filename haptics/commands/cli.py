"""The command line of the device: its commands and exit codes. Loads what a command needs only when it runs."""

from __future__ import annotations

from collections.abc import Sequence

from delta_cad.common.console import Parser, command_parser, run_command
from haptics.commands import board, calibrate, feel, firmware, gravity, interfaces, run, simulate, stiffness

COMMANDS = (simulate, stiffness, feel, gravity, firmware, calibrate, run, interfaces, board)
EXIT_CODES = (
    "exit codes: 0 done; 1 done, but a promise fails; 2 the input or the usage is wrong; 130 interrupted by Ctrl-C"
)


def parser() -> Parser:
    """The arguments of `python -m haptics`."""
    description = "What a delta haptic device will feel like, and the controller that drives it."
    return command_parser("python -m haptics", description, EXIT_CODES, COMMANDS)


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs one command and returns its exit code."""
    return run_command(parser(), arguments, "sim")
