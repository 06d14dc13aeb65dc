"""The command line of the device: its commands and exit codes. Loads what a command needs only when it runs."""

from __future__ import annotations

from delta_cad.common.command_line import Program
from delta_cad.common.console import NOT_MET
from haptics.commands import board, calibrate, feel, firmware, gravity, interfaces, run, simulate, stiffness

_COMMANDS = (simulate, stiffness, feel, gravity, firmware, calibrate, run, interfaces, board)
_PROGRAM = Program(
    "haptics",
    "What a delta haptic device will feel like, and the controller that drives it.",
    _COMMANDS,
    {NOT_MET: "done, but a promise fails"},
    "sim",
)
parser, main = _PROGRAM.parser, _PROGRAM.main
