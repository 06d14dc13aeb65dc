"""pymoo's genetic algorithm over a fixed sample of the surface, generation by generation.

[RCIM2018] table 2: population 100, 220, 220 in the three steps, crossover fraction 0.8, 100 generations. Its migration
fraction of 0.2 moves individuals between islands; there is one island here. Designs that meet all constraints beat
those that do not; among the latter the smaller sum of violations wins.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from optimizer.problem.step import Problem
from optimizer.search.sqp import sampled

POPULATIONS = {1: 100, 2: 220, 3: 220}
GENERATIONS = 100
CROSSOVER = 0.8
# Points along an edge of the fixed sample: between them kappa of the published design rises by 0.1 % at most.
SEARCH_GRID = 9


Scores = tuple[list[float], list[list[float]]]
"""Of a generation (population,) objectives, to be minimised, and (population, constraints) smallest margins over the
sample; with the seed they are all that is needed to take a search up again."""
Memo = Callable[[np.ndarray, Callable[[], Scores]], Scores]
"""Gives the scores of designs, (population, free variables), or computes them by what it is called with."""


class GeneticError(ValueError):
    """A search that cannot be run."""


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
_GenerationReport = Callable[[int, int, float], None]


def evolve(
    problem: Problem,
    seed: int,
    population: int | None = None,
    generations: int = GENERATIONS,
    known: np.ndarray | None = None,
    memo: Memo = lambda _, compute: compute(),
    report: _GenerationReport | None = None,
    stop: Callable[[], bool] = bool,
) -> Population:
    """Runs the genetic algorithm.

    Args:
        problem: The step; at least one variable must be free.
        seed: Seed of everything random.
        population: Individuals of a generation; left out, the paper's for the step.
        generations: How many, the first one included.
        known: (K, free variables) designs that the first generation contains.
        memo: Asked for the scores of each generation; left out, all are computed.
        report: Called after each generation.
        stop: Called after each generation; True ends the search there.

    Raises:
        GeneticError: Nothing is free, or fewer than 4 individuals or 1 generation.
    """
    from pymoo.algorithms.soo.nonconvex.ga import GA
    from pymoo.core.evaluator import Evaluator
    from pymoo.core.problem import Problem as Posed
    from pymoo.operators.crossover.sbx import SBX
    from pymoo.problems.static import StaticProblem

    size, n = POPULATIONS[problem.step] if population is None else population, len(problem.free)
    if n == 0 or size < 4 or generations < 1:
        raise GeneticError(
            f"{n} free variables, {size} individuals, {generations} generations: at least 1, 4 and 1 are needed"
        )
    first = np.random.default_rng(seed).random((size, n))
    if known is not None:
        first[: len(known)] = known[:size]
    count = sampled(problem, first[:1], SEARCH_GRID)[1].shape[1]
    posed = Posed(n_var=n, n_obj=1, n_ieq_constr=count, xl=np.zeros(n), xu=np.ones(n))
    own: Any = {"sampling": first, "crossover": SBX(prob=CROSSOVER)}  # an array is no sampling by pymoo's annotation
    algorithm: Any = GA(pop_size=size, **own)
    algorithm.setup(posed, termination=("n_gen", generations), seed=seed, verbose=False)
    history, evaluations, best = [], 0, np.nan
    for number in range(generations):
        required = algorithm.ask()
        if (
            required is None or len(required) == 0
        ):  # no offspring that is not there already: the population has converged
            break
        x = required.get("X").astype(float)
        objective, margins = map(np.array, memo(x, lambda x=x: _scores(problem, x)))
        Evaluator().eval(StaticProblem(posed, F=objective[:, None], G=-margins), required)
        algorithm.tell(infills=required)
        evaluations += len(x)
        good = objective[(margins >= 0.0).all(axis=1)]
        best = float(np.fmin(best, good.min())) if len(good) else best
        history.append(best)
        if report is not None:
            report(number + 1, generations, best)
        if stop():
            break
    x, objective = algorithm.pop.get("X").astype(float), algorithm.pop.get("F")[:, 0]
    violation = np.maximum(0.0, algorithm.pop.get("G")).sum(axis=1)
    order = np.lexsort((objective, violation))
    return Population(x[order], objective[order], violation[order], tuple(history), evaluations)


def _scores(problem: Problem, x: np.ndarray) -> Scores:
    objective, margins = sampled(problem, x, SEARCH_GRID)
    return objective.tolist(), margins.tolist()
