"""The command line of the optimiser: its commands and exit codes. Loads what a command needs only when it runs."""

from __future__ import annotations

from delta_cad.common.command_line import Program
from delta_cad.common.console import CUT_SHORT, NOT_MET
from optimizer.commands import atlas, certify, design, front, init, reproduce, schema, studio, synthesize, verify

COMMANDS = (init, schema, studio, design, synthesize, reproduce, certify, verify, front, atlas)
PROGRAM = Program(
    "optimizer",
    "Dimensions of a delta haptic device from the customer's requirements.",
    COMMANDS,
    {
        NOT_MET: "the requirements cannot be met, or were not",
        CUT_SHORT: "a search ran out of time or candidates, or Ctrl-C ended it",
    },
    "optimize",
)
parser, main = PROGRAM.parser, PROGRAM.main
