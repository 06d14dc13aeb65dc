"""GA, SQP and both in a row on one step with one seed: what the study over many seeds repeats."""

from __future__ import annotations

from optimizer.problem.requirements import Requirements
from optimizer.search.genetic import GENERATIONS
from optimizer.search.result import Result
from optimizer.synthesis.three_step import Run
from tests.optimizer.tasks import Memory


def trial(
    given: Requirements, step: int, seed: int, population: int | None = None, generations: int = GENERATIONS
) -> dict[str, Result]:
    """Results of `ga`, `ga+sqp` from that very GA, and `sqp` from its own starts.

    Args:
        given: The task; of step 3 with its half side.
        step: 1, 2 or 3.
        seed: Of everything random.
        population: Individuals of the GA; left out, the paper's.
        generations: Of the GA.
    """
    memory, found = Memory(), {}
    for method in ("ga", "ga+sqp", "sqp"):
        store = None if method == "sqp" else memory
        (found[method],) = Run(given, method, seed, (step,), population, generations, store=store).results()
    return found


def distance(result: Result, bound: float) -> float:
    """Share by which a result's objective can be away from the best possible; infinite where it is not feasible."""
    return abs(result.objective - bound) / result.objective if result.feasible else float("inf")
