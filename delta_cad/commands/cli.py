"""The command line: its commands and exit codes. Loads what a command needs only when it runs."""

from __future__ import annotations

from delta_cad.commands import build, check, compare, drawings, fixture, inspect, schema, view
from delta_cad.common.command_line import Program
from delta_cad.common.console import DONE, NOT_BUILT, NOT_MET

COMMANDS = (build, check, drawings, fixture, inspect, compare, view, schema)
PROGRAM = Program(
    "delta_cad",
    "Delta haptic devices from a design file: CAD, checks, files.",
    COMMANDS,
    {
        DONE: "done and all checks hold",
        NOT_MET: "done, but a check fails",
        NOT_BUILT: "the geometry could not be built",
    },
    "cad",
)
parser, main = PROGRAM.parser, PROGRAM.main
