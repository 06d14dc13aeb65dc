"""Drawings and manual of the committed design, each with the solids in a process of its own."""

from __future__ import annotations

from collections.abc import Callable
from tempfile import TemporaryDirectory

from tests.benchmarks.figure import Figure, of_repeats
from tests.benchmarks.timing import python, succeeded

SUBJECT = "drawings"
ROUNDS = 2
MANUAL = """
import sys
from pathlib import Path
from delta_cad.commands.pipeline import make_machine
from delta_cad.design import load_design
from delta_cad.report.manual.page import write_manual

m = make_machine(load_design(Path("best.json")))
write_manual(m.dimensions, m.assembly, m.meshes, m.masses, Path(sys.argv[1]))
"""


def run(say: Callable[[str], None]) -> list[Figure]:
    """The figures.

    Args:
        say: Told what is being done.
    """
    runs, manuals = [], []
    with TemporaryDirectory() as folder:
        for k in range(ROUNDS):
            say(f"drawings {k + 1} of {ROUNDS}")
            words = ("drawings", "--design", "best.json", "--out", folder)
            runs.append(succeeded(python("-m", "delta_cad", *words)))
            say(f"manual {k + 1} of {ROUNDS}")
            manuals.append(succeeded(python("-c", MANUAL, folder)))
    return [
        of_repeats(SUBJECT, "all drawings", [r.wall_s for r in runs], "s", 60.0, note="best.json, solids included"),
        of_repeats(SUBJECT, "the same in processor time", [r.processor_s for r in runs], "s"),
        of_repeats(SUBJECT, "the manual", [r.wall_s for r in manuals], "s", 30.0, note="best.json, solids included"),
        of_repeats(SUBJECT, "the manual in processor time", [r.processor_s for r in manuals], "s"),
    ]
