"""The search for the largest stable wall: time of three axes, what of it is simulated, growth with axes and hands."""

from __future__ import annotations

import json
from collections.abc import Callable
from statistics import median
from time import perf_counter, process_time
from typing import Any

from tests.benchmarks.figure import Figure, of_repeats
from tests.benchmarks.timing import python, slope, succeeded
from tests.committed import BEST

SUBJECT = "haptics"
SEARCH_S = 5.0
ROUNDS = 3
Z_WIDTH_S = 60.0
CHILD = (
    "import os; os.environ['OPENBLAS_NUM_THREADS'] = '1'; "
    "from tests.benchmarks.haptics.wall import measured; measured()"
)
"""As the command does it: with one thread, since numpy reads that when it is loaded, in a process of its own."""


def run(say: Callable[[str], None]) -> list[Figure]:
    """The figures.

    Args:
        say: Told what is being done.
    """
    say(f"search on three axes and its growth, {ROUNDS} rounds in a process of its own")
    found = json.loads(succeeded(python("-c", CHILD)).stdout)
    note = f"{found['pushes']} simulated pushes of 2.1 s, {found['cases']} linear cases; processor time, one thread"
    axes, hands = found["axes"], found["hands"]
    return [
        of_repeats(SUBJECT, "stable-wall search, three axes", found["times"], "s", SEARCH_S, note=note),
        of_repeats(
            SUBJECT, "the same by the clock on the wall", found["clock"], "s", note="others use the machine too"
        ),
        of_repeats(
            SUBJECT,
            "the loop's sheet: four walls, rates, Z-width, noise",
            found["sheet"],
            "s",
            Z_WIDTH_S,
            note="hands at all corners, K-B plane of 4 rates; processor time",
        ),
        of_repeats(SUBJECT, "one simulated push against a wall", found["push"], "s", note="2.1 s of loop, 4 substeps"),
        Figure(SUBJECT, "growth: wall search against axes, log-log slope", slope(*axes), "", note=_reported(axes)),
        Figure(SUBJECT, "growth: wall search against hands, log-log slope", slope(*hands), "", note=_reported(hands)),
    ]


def _reported(grown: tuple[list[int], list[float]]) -> str:
    return ", ".join(f"{size}: {seconds:.2f} s" for size, seconds in zip(*grown, strict=True))


def measured() -> None:
    """Measures in this process and prints the times as JSON."""
    from delta_cad.design import load_design
    from haptics.feel.loops import loop_sheet
    from haptics.loop.stiffness import NOMINAL_HAND, SUBSTEPS, largest_walls
    from haptics.loop.wall_trial import WallBench
    from haptics.model.hands import HANDS
    from tests.haptics.scene_machine import scene_machine

    machine = scene_machine(load_design(BEST))
    stands = WallBench(machine, "x", HANDS["medium"], substeps=SUBSTEPS).stands
    largest_walls(machine, axes=("x",))  # compiles what is not in the cache

    def seconds(function: Callable[[], Any]) -> float:
        start = process_time()
        function()
        return process_time() - start

    found = largest_walls(machine)
    times: list[float] = []
    clock: list[float] = []
    for _ in range(ROUNDS):
        start = perf_counter()
        times.append(seconds(lambda: largest_walls(machine)))
        clock.append(perf_counter() - start)
    axes = [median(seconds(lambda n=n: largest_walls(machine, axes="xyz"[:n])) for _ in range(ROUNDS)) for n in (1, 2)]
    nominal_first = sorted(HANDS, key=lambda name: name != NOMINAL_HAND)
    sets = [{name: HANDS[name] for name in nominal_first[:n]} for n in (1, 2)]
    hands = [median(seconds(lambda s=s: largest_walls(machine, hands=s)) for _ in range(ROUNDS)) for s in sets]
    loop_sheet(machine)  # compiles what is not in the cache
    sheet = [seconds(lambda: loop_sheet(machine)) for _ in range(ROUNDS)]
    print(
        json.dumps(
            {
                "sheet": sheet,
                "times": times,
                "clock": clock,
                "pushes": sum(wall.trials for wall in found.axes),
                "cases": 4 * len(HANDS) * len(found.axes),
                "push": [seconds(lambda: stands(5000.0)) for _ in range(9)],
                "axes": [[1, 2, 3], [*axes, median(times)]],
                "hands": [[1, 2, 3], [*hands, median(times)]],
            }
        )
    )
