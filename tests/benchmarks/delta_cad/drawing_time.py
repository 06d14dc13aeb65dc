"""`delta_cad drawings` of the committed design: solids, all drawings and their check, in a process of its own."""

from __future__ import annotations

from collections.abc import Callable
from tempfile import TemporaryDirectory

from tests.benchmarks.figure import Figure, of_repeats
from tests.benchmarks.timing import python, succeeded

SUBJECT = "drawings"
ROUNDS = 2


def run(say: Callable[[str], None]) -> list[Figure]:
    """The figures.

    Args:
        say: Told what is being done.
    """
    runs = []
    with TemporaryDirectory() as folder:
        for k in range(ROUNDS):
            say(f"drawings {k + 1} of {ROUNDS}")
            words = ("drawings", "--design", "best.json", "--out", folder)
            runs.append(succeeded(python("-m", "delta_cad", *words)))
    return [
        of_repeats(SUBJECT, "all drawings", [r.wall_s for r in runs], "s", 60.0, note="best.json, solids included"),
        of_repeats(SUBJECT, "the same in processor time", [r.processor_s for r in runs], "s"),
    ]
