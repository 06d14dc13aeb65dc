"""The atlas over processes: sets a second with one worker and with two, and what the scheduler itself costs."""

from __future__ import annotations

import tomllib
from collections.abc import Callable
from time import perf_counter
from typing import Any

from optimizer.study.grid import Grid, grid_from_dict
from tests.benchmarks.figure import Figure
from tests.benchmarks.timing import ROOT, slope

SUBJECT = "atlas"
WORKERS = (1, 2)
ROUNDS = 2
AXES = {
    "limits.outline_radius_max_mm": {"linspace": [122.0, 130.0, 2]},
    "requirements.joint_torque_N_m": {"linspace": [0.3, 0.8, 4]},
}


def run(say: Callable[[str], None]) -> list[Figure]:
    """The figures.

    Args:
        say: Told what is being done.

    Raises:
        RuntimeError: A set came to no row, or the rows of one and of two workers differ.
    """
    grid = _grid()
    times, start, rows, own = {}, {}, {}, {}
    for workers in WORKERS:
        say(f"{len(grid.sets)} sets on {workers} processes, {ROUNDS} rounds")
        times[workers], start[workers], rows[workers], own[workers] = _timed(grid, workers)
    if any(rows[workers] != rows[WORKERS[0]] for workers in WORKERS):
        raise RuntimeError("the rows depend on the number of workers")
    best = [min(times[workers]) for workers in WORKERS]
    count, last = len(grid.sets), WORKERS[-1]
    note = f"{count} sets, two steps by GA+SQP each: {best[0]:.2f} s and {best[-1]:.2f} s; -1 where cores are free"
    share = 100.0 * own[last] / (last * times[last][-1])
    load = "what is missing waits for other programs of a loaded machine, and for the last set"
    return [
        Figure(SUBJECT, "growth: time against processes, log-log slope", slope(WORKERS, best), "", note=note),
        Figure(SUBJECT, f"sets a second on {last} processes", count / best[-1], "1/s", note="the same"),
        Figure(SUBJECT, f"processor time of the sets within {last} processes' time", share, "%", note=load),
        Figure(SUBJECT, f"start and end of a cluster of {last} processes", start[last], "s", note="with imports"),
    ]


def _timed(grid: Grid, workers: int) -> tuple[list[float], float, list[dict[str, Any]], float]:
    """Seconds of the rounds, to start and end the cluster; rows without their seconds; these, of the last round."""
    from optimizer.study.cluster import AtlasRow, collect, local_cluster

    times: list[float] = []
    found: list[AtlasRow] = []
    before = perf_counter()
    with local_cluster(workers) as client:
        collect(client, grid.sets[:workers], found.append)  # everything is loaded
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
    rows = [{k: v for k, v in row.items() if k != "seconds"} for row in found]
    return times, around, rows, sum(row["seconds"] for row in found)


def _grid() -> Grid:
    base = tomllib.loads((ROOT / "examples/synthesized.toml").read_text())
    base["bounds_mm"]["upper_arm_length"] = [82, 90]
    return grid_from_dict({"base": base, "axes": AXES, "steps": [1, 2]})
