"""The atlas over processes: sets a second with one worker and with two, and what the scheduler itself costs."""

from __future__ import annotations

import tomllib
from collections.abc import Callable
from time import perf_counter
from typing import Any

from optimizer.grid import Grid, grid_from_dict
from tests.benchmarks.figure import Figure
from tests.benchmarks.timing import ROOT, slope

SUBJECT = "atlas"
WORKERS = (1, 2)
ROUNDS = 3
AXES = {
    "limits.outline_radius_max_mm": {"linspace": [122.0, 130.0, 4]},
    "requirements.joint_torque_N_m": {"linspace": [0.3, 1.0, 4]},
}


def run(say: Callable[[str], None]) -> list[Figure]:
    """The figures.

    Args:
        say: Told what is being done.

    Raises:
        RuntimeError: A set came to no row, or the rows of one and of two workers differ.
    """
    grid = _grid()
    times, start, rows = {}, {}, {}
    for workers in WORKERS:
        say(f"{len(grid.sets)} sets on {workers} processes, {ROUNDS} rounds")
        times[workers], start[workers], rows[workers] = _timed(grid, workers)
    if any(rows[workers] != rows[WORKERS[0]] for workers in WORKERS):
        raise RuntimeError("the rows depend on the number of workers")
    best = [min(times[workers]) for workers in WORKERS]
    count, last = len(grid.sets), WORKERS[-1]
    note = f"{count} sets, three steps by GA+SQP each: {best[0]:.2f} s and {best[-1]:.2f} s; -1 where cores are free"
    return [
        Figure(SUBJECT, "growth: time against processes, log-log slope", slope(WORKERS, best), "", note=note),
        Figure(SUBJECT, f"sets a second on {last} processes", count / best[-1], "1/s", note="the same"),
        Figure(SUBJECT, f"start and end of a cluster of {last} processes", start[last], "s", note="with imports"),
    ]


def _timed(grid: Grid, workers: int) -> tuple[list[float], float, list[dict[str, Any]]]:
    """Seconds of every round, seconds to start and end the cluster, and the rows without their seconds."""
    from optimizer.atlas import Row, collect, local_cluster

    times: list[float] = []
    found: list[Row] = []
    before = perf_counter()
    with local_cluster(workers) as client:
        collect(client, grid.sets[: 2 * workers], found.append)  # everything is loaded
        began = perf_counter()
        for _ in range(ROUNDS):
            found, start = [], perf_counter()
            failed = collect(client, grid.sets, found.append)
            times.append(perf_counter() - start)
            if failed:
                raise RuntimeError(f"set {failed[0].place}: {failed[0].reason}")
        ended = perf_counter()
    around = began - before + perf_counter() - ended
    found.sort(key=lambda row: row["index"])
    return times, around, [{k: v for k, v in row.items() if k != "seconds"} for row in found]


def _grid() -> Grid:
    base = tomllib.loads((ROOT / "joystick.toml").read_text())
    base["bounds_mm"]["upper_arm_length"] = [82, 90]
    return grid_from_dict({"base": base, "axes": AXES})
