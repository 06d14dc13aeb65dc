"""`delta_cad build` against a bare `import cadquery`, its memory and where its time goes.

Run as a program it builds `best.json` into the folder given and prints the seconds of each phase as JSON.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter

from tests.benchmarks.figure import Figure, of_repeats
from tests.benchmarks.timing import ROOT, Child, python, ratios, succeeded

SUBJECT = "build"
ROUNDS = 2  # builds, each between two imports
PATIENCE_S = 60.0  # after which no further round begins: a busy machine must not keep its owner waiting
PHASES_REPORTED = 8  # the longest phases
GB = 1e9
KINDS = {"solid": "solids", "mesh": "meshes", "parts": "files of parts"}  # told one by one, counted together


def run(say: Callable[[str], None]) -> list[Figure]:
    """The figures.

    Args:
        say: Told what is being done.
    """
    say("import cadquery, so that all files are in memory")
    _import()
    imports, builds = [_import()], []
    with TemporaryDirectory() as folder:
        start = perf_counter()
        for k in range(ROUNDS):
            if k and perf_counter() - start > PATIENCE_S:
                say("the machine is busy: no further round")
                break
            say(f"build {k + 1} of {ROUNDS} and import")
            builds.append(succeeded(python("-m", "delta_cad", "build", "--design", "best.json", "--out", folder)))
            imports.append(_import())
        say("build once more, watched from outside")
        watched = succeeded(python("-m", "tests.benchmarks.delta_cad.build_time", folder, watch=True))
    around = list(pairwise(imports))
    wall = ratios([b.wall_s for b in builds], [(a.wall_s + b.wall_s) / 2 for a, b in around])
    busy = ratios([b.processor_s for b in builds], [(a.processor_s + b.processor_s) / 2 for a, b in around])
    figures = [
        of_repeats(SUBJECT, "build / bare import cadquery", wall, "x", 5.0, note="best.json, everything; wall time"),
        of_repeats(SUBJECT, "the same in processor time", busy, "x", note="all processes; moved less by other work"),
        of_repeats(SUBJECT, "build", [b.wall_s for b in builds], "s"),
        of_repeats(SUBJECT, "bare import cadquery", [a.wall_s for a in imports], "s"),
        Figure(SUBJECT, "peak memory, all processes", watched.tree_bytes / GB, "GB", 1.5, note="shared pages once"),
        of_repeats(SUBJECT, "peak memory, largest process", [b.largest_bytes / GB for b in builds], "GB", 1.5),
    ]
    phases: dict[str, float] = json.loads(watched.stdout)
    longest = sorted(phases, key=phases.__getitem__, reverse=True)[:PHASES_REPORTED]
    proof = "clearance: proof over the cube"
    for name in longest:
        target = 60.0 if name == proof else None
        figures.append(
            Figure(
                SUBJECT,
                f"phase: {name}",
                phases[name],
                "s",
                target,
                note="of this process: what the others do is only waited for",
            )
        )
    return figures


def _import() -> Child:
    return succeeded(python("-c", "import cadquery"))


def phases(folder: Path) -> dict[str, float]:
    """Seconds of each phase of a build, those of single parts together, and of loading the program."""
    start = perf_counter()
    from delta_cad.commands.pipeline import build
    from delta_cad.design import load_design

    seconds: dict[str, float] = {}
    current, since = "loading", start

    def progress(text: str) -> None:
        nonlocal current, since
        now = perf_counter()
        seconds[current] = seconds.get(current, 0.0) + now - since
        kind = KINDS.get(text.replace("/", " ").split(" ")[0])
        current, since = kind or text, now

    build(load_design(ROOT / "best.json"), folder, progress)
    progress("")
    return seconds


if __name__ == "__main__":
    print(json.dumps(phases(Path(sys.argv[1]))))
