"""Convergence of GA and SQP on one step 3, seed by seed: best objective so far against designs evaluated."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import product
from typing import Any, NamedTuple

import numpy as np

from optimizer.problem.step import Problem
from optimizer.search import genetic, sqp
from optimizer.search.result import finite
from optimizer.synthesis.checkpoint import Checkpoint
from optimizer.synthesis.three_step import remembered


class Trace(NamedTuple):
    """One run.

    Attributes:
        method: `ga` or `sqp`.
        seed: Seed of the run.
        evaluations: (K,) designs evaluated so far, ascending.
        best: (K,) smallest worst kappa of a feasible design so far; NaN before there was one. The GA's is that on its
            own sample of the surface, SQP's that on the polished surface.
    """

    method: str
    seed: int
    evaluations: tuple[int, ...]
    best: tuple[float, ...]


Run = Callable[[Problem, int, Callable[[], bool]], Trace]


def traces(
    problem: Problem,
    seeds: int,
    report: Callable[[str, int, int], None] | None = None,
    stop: Callable[[], bool] = bool,
    store: Checkpoint | None = None,
) -> list[Trace]:
    """Runs both methods from each seed: the GA with the paper's parameters, SQP from its usual starts.

    Args:
        problem: A step 3.
        seeds: How many, from 0.
        report: Called before each run: method, seed, and how many seeds there are.
        stop: Called before each run and in it; True ends there.
        store: Keeps each run; None keeps nothing.

    Returns:
        The runs that came to their end.
    """
    done = []
    for seed, (method, run) in product(range(seeds), (("sqp", _sqp), ("ga", _ga))):

        def solve(method: str = method, run: Run = run, seed: int = seed) -> dict[str, Any] | None:
            if report is not None:
                report(method, seed, seeds)
            trace = run(problem, seed, stop)
            lists = {"evaluations": list(trace.evaluations), "best": [finite(value) for value in trace.best]}
            return None if stop() else lists

        kept = remembered(store, f"convergence/{method}/{seed}", solve)
        if kept is None:
            break
        best = tuple(math.nan if value is None else float(value) for value in kept["best"])
        done.append(Trace(method, seed, tuple(kept["evaluations"]), best))
    return done


def band(traces: list[Trace], method: str, at: np.ndarray) -> np.ndarray:
    """Computes least, median and largest of the best values of a method's runs.

    Args:
        traces: Runs.
        method: Method whose runs count.
        at: (K,) numbers of designs evaluated.

    Returns:
        (3, K) least, median, largest; infinite where no run, half of them, or not all have a feasible design yet.
    """
    rows = []
    for trace in traces:
        if trace.method == method:
            k = np.searchsorted(trace.evaluations, at, side="right") - 1
            rows.append(np.where(k >= 0, np.nan_to_num(trace.best, nan=np.inf)[np.maximum(k, 0)], np.inf))
    values = np.sort(rows, axis=0)
    # of an even number the upper median: half the runs are as good
    return np.stack([values[0], values[len(values) // 2], values[-1]])


def _ga(problem: Problem, seed: int, stop: Callable[[], bool]) -> Trace:
    evaluations: list[int] = []

    def count(x: np.ndarray, compute: Callable[[], genetic.Scores]) -> genetic.Scores:
        evaluations.append(len(x) + (evaluations[-1] if evaluations else 0))
        return compute()

    last = genetic.evolve(problem, seed, memo=count, stop=stop)
    return Trace("ga", seed, tuple(evaluations), tuple(-1.0 / value for value in last.history))


def _sqp(problem: Problem, seed: int, stop: Callable[[], bool]) -> Trace:
    starts = np.roll(sqp.start_points(problem, seed), -1, axis=0)  # what no seed moves, the middle, comes last
    outcome = sqp.search(problem, starts, stop=stop)
    levels = np.fmax.accumulate([level for _, level in outcome.trail])
    best = tuple(1.0 / float(level) if level > 0.0 else math.nan for level in levels)
    return Trace("sqp", seed, tuple(evaluations for evaluations, _ in outcome.trail), best)
