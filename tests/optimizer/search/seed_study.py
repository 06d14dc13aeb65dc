"""GA, SQP and both in a row on one step with one seed: what the study over many seeds repeats."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from optimizer.problem.requirements import Requirements
from optimizer.search.genetic import GENERATIONS, Generation
from optimizer.search.result import Result
from optimizer.synthesis.three_step import Run


class Memory:
    """A store that forgets everything at the end: GA+SQP takes up the GA that was run alone."""

    def __init__(self) -> None:
        self._done: dict[str, dict[str, Any]] = {}

    def finished(self, phase: str) -> dict[str, Any] | None:
        return self._done.get(phase)

    def finish(self, phase: str, data: dict[str, Any]) -> None:
        self._done[phase] = data

    def generations(self, phase: str) -> Sequence[Generation]:
        assert phase
        return ()

    def keep(self, phase: str, generation: Generation) -> None:
        assert len(generation.objective), phase


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
