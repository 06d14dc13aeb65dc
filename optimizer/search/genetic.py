"""pymoo's genetic algorithm (on arrays: breeding.py) over a fixed sample of the surface, generation by generation.

[RCIM2018] table 2: population 100, 220, 220 in the three steps, crossover fraction 0.8, 100 generations. Its migration
fraction of 0.2 moves individuals between islands; there is one island here. Designs that meet all constraints beat
those that do not; among the latter the smaller sum of violations wins.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from optimizer.problem.step import Problem
from optimizer.search.sqp import sampled

POPULATIONS = {1: 100, 2: 220, 3: 220}
GENERATIONS = 100
CROSSOVER = 0.8
# Points along an edge of the fixed sample: between them kappa of the published design rises by 0.1 % at most.
SEARCH_GRID = 9


class Generation(NamedTuple):
    """Objectives and margins of a generation; with the seed it is all that is needed to take a search up again.

    Attributes:
        objective: (population,) to be minimised.
        margins: (population, constraints) smallest margin of each over the sample.
    """

    objective: np.ndarray
    margins: np.ndarray


class GeneticError(ValueError):
    """A search that cannot be run, or cannot be taken up again."""


@dataclass(frozen=True)
class Population:
    """The last generation, best first.

    Attributes:
        x: (population, free variables) scaled.
        objective: (population,) minimised.
        violation: (population,) sum of what the margins lack.
        history: Best objective of a feasible design after each generation; NaN before there was one.
        evaluations: Designs evaluated, those of a search taken up again included.
    """

    x: np.ndarray
    objective: np.ndarray
    violation: np.ndarray
    history: tuple[float, ...]
    evaluations: int


# Called after each generation with its number, how many there are, and the best objective so far.
GenerationReport = Callable[[int, int, float], None]


def evolve(
    problem: Problem,
    seed: int,
    population: int | None = None,
    generations: int = GENERATIONS,
    known: np.ndarray | None = None,
    record: Sequence[Generation] = (),
    keep: Callable[[Generation], None] | None = None,
    report: GenerationReport | None = None,
    stop: Callable[[], bool] = bool,
) -> Population:
    """Runs the genetic algorithm.

    Args:
        problem: The step; at least one variable must be free.
        seed: Seed of everything random.
        population: Individuals of a generation; left out, the paper's for the step.
        generations: How many, the first one included.
        known: (K, free variables) designs that the first generation contains.
        record: Generations of an earlier run with the same arguments; they are not evaluated again.
        keep: Given each generation after it was evaluated.
        report: Called after each generation.
        stop: Called after each generation; True ends the search there.

    Returns:
        The last generation.

    Raises:
        GeneticError: Nothing is free, fewer than 4 individuals or 1 generation, or the record is not of this search.
    """
    from optimizer.search.breeding import Breeder  # loads pymoo

    size, n = POPULATIONS[problem.step] if population is None else population, len(problem.free)
    if n == 0 or size < 4 or generations < 1:
        raise GeneticError(
            f"{n} free variables, {size} individuals, {generations} generations: at least 1, 4 and 1 are needed"
        )
    first = np.random.default_rng(seed).random((size, n))
    if known is not None:
        first[: len(known)] = known[:size]
    count = sampled(problem, first[:1], SEARCH_GRID)[1].shape[1]
    breeder = Breeder(first, seed, CROSSOVER)
    history, evaluations, best = [], 0, np.nan
    earlier = iter(record)
    for number in range(generations):
        x = breeder.ask()
        if len(x) == 0:  # no offspring that is not there already: the population has converged
            break
        current = next(earlier, None)
        fresh = current is None
        if current is None:
            current = Generation(*sampled(problem, x, SEARCH_GRID))
        if current.objective.shape != (len(x),) or current.margins.shape != (len(x), count):
            raise GeneticError(f"generation {number + 1} of the record is not of this search")
        breeder.tell(x, current.objective, current.margins)
        evaluations += len(x)
        good = current.objective[(current.margins >= 0.0).all(axis=1)]
        best = float(np.fmin(best, good.min())) if len(good) else best
        history.append(best)
        if fresh and keep is not None:
            keep(current)
        if report is not None:
            report(number + 1, generations, best)
        if stop():
            break
    violation = np.maximum(0.0, -breeder.margins).sum(axis=1)
    order = np.lexsort((breeder.objective, violation))
    return Population(breeder.x[order], breeder.objective[order], violation[order], tuple(history), evaluations)
