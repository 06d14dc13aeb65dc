"""The genetic algorithm on arrays against pymoo's own: every design of every generation, to the last bit."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from pymoo.algorithms.soo.nonconvex.ga import GA
from pymoo.core.evaluator import Evaluator
from pymoo.core.problem import Problem
from pymoo.operators.crossover.sbx import SBX
from pymoo.problems.static import StaticProblem

from optimizer.search.breeding import Breeder

Worth = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]


def sphere(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """All feasible."""
    return ((x - 0.3) ** 2).sum(axis=1), np.ones((len(x), 1))


def coarse(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Many equal objectives and violations, feasible on one side only: ties are decided by lot."""
    return (4.0 * x[:, 0]).round(), np.column_stack([(8.0 * (x[:, -1] - 0.6)).round(), x.sum(axis=1) - 0.5])


def hopeless(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Nothing is feasible; the corner x = 1 is least bad, so that many are cut off at the bound."""
    return x[:, 0], x - 1.5


def ours(first: np.ndarray, seed: int, worth: Worth, generations: int) -> list[np.ndarray]:
    breeder, told = Breeder(first, seed, 0.8), []
    for _ in range(generations):
        x = breeder.ask()
        breeder.tell(x, *worth(x))
        told += [x, breeder.x, breeder.objective, breeder.margins]
    return told


def theirs(first: np.ndarray, seed: int, worth: Worth, generations: int) -> list[np.ndarray]:
    n, count = first.shape[1], worth(first)[1].shape[1]
    posed = Problem(n_var=n, n_obj=1, n_ieq_constr=count, xl=np.zeros(n), xu=np.ones(n))
    algorithm: Any = GA(pop_size=len(first), sampling=first, crossover=SBX(prob=0.8))
    algorithm.setup(posed, termination=("n_gen", generations), seed=seed, verbose=False)
    told = []
    for _ in range(generations):
        asked = algorithm.ask()
        x = asked.get("X").astype(float)
        objective, margins = worth(x)
        Evaluator().eval(StaticProblem(posed, F=objective[:, None], G=-margins), asked)
        algorithm.tell(infills=asked)
        pop = algorithm.pop
        told += [x, pop.get("X").astype(float), pop.get("F")[:, 0], -pop.get("G")]
    return told


@pytest.mark.parametrize("worth", [sphere, coarse, hopeless])
@pytest.mark.parametrize(("size", "n"), [(4, 1), (15, 3), (40, 5)])
def test_every_generation_is_that_of_pymoo(worth: Worth, size: int, n: int) -> None:
    first = np.random.default_rng(size).random((size, n))
    first[-1] = first[0]  # the same design twice: one of them goes
    for seed in (0, 7):
        for a, b in zip(ours(first, seed, worth, 12), theirs(first, seed, worth, 12), strict=True):
            np.testing.assert_array_equal(a, b)


def test_designs_stay_in_their_bounds_and_no_generation_holds_one_twice() -> None:
    for x in ours(np.random.default_rng(3).random((20, 2)), 1, hopeless, 20)[::4]:
        assert ((x >= 0.0) & (x <= 1.0)).all()
        assert len(np.unique(x, axis=0)) == len(x)


def test_what_mating_repeats_is_taken_once_and_what_is_there_already_is_not_taken(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    breeder = Breeder(np.array([[0.1], [0.2], [0.3], [0.4]]), 0, 0.8)
    breeder.tell(breeder.ask(), np.arange(4.0), np.ones((4, 1)))
    monkeypatch.setattr(Breeder, "_mate", lambda *_: np.array([[0.5], [0.1], [0.7], [0.5]]))
    np.testing.assert_array_equal(breeder.ask(), [[0.5], [0.7]])
    monkeypatch.setattr(Breeder, "_mate", lambda *_: np.array([[0.2], [0.4]]))
    assert breeder.ask().shape == (0, 1)
