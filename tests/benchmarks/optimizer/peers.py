"""Other optimisers on the NumPy objective of one step: time, objective reached, what they leave violated."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from time import process_time
from typing import Any

import numpy as np

from optimizer.problem.requirements import Requirements
from optimizer.problem.step import Problem
from optimizer.search import sqp
from optimizer.search.genetic import CROSSOVER, GENERATIONS, POPULATIONS, SEARCH_GRID
from optimizer.search.result import Result
from optimizer.search.sqp import sampled
from optimizer.synthesis.three_step import Run
from tests.benchmarks.optimizer.numpy_objective import numpy_objective

SEED = 0
ACCURACY = 1e-6
"""`ftol` of SciPy's SLSQP where nothing else is said."""


@dataclass(frozen=True)
class Outcome:
    """What an optimiser came to.

    Attributes:
        seconds: Processor time.
        evaluations: Designs evaluated.
        objective: Half side in mm, or largest kappa, recomputed on the fine surface of the cube.
        violation: Largest violation there, without unit; also between the points on which a peer looked.
    """

    seconds: float
    evaluations: int
    objective: float
    violation: float

    @property
    def feasible(self) -> bool:
        """Whether it meets every constraint to SLSQP's own accuracy."""
        return self.violation <= ACCURACY

    def off(self, best: float) -> float:
        """Share by which the objective differs from the best of all."""
        return abs(self.objective / best - 1.0)

    def wording(self, best: float) -> str:
        """Objective and violation in words, against the best of all."""
        kept = "feasible" if self.feasible else f"violates by {self.violation:.1g}"
        return (
            f"{self.objective:.5g}, {100.0 * self.off(best):.2g} % off the best, {kept}; {self.evaluations:,} designs"
        )


class Counted:
    """Objective and margins on the search's sample, each design once; what a peer's two functions share."""

    def __init__(self, problem: Problem) -> None:
        self.problem, self.evaluations = problem, 0
        self._key, self._kept = b"", (np.empty(0), np.empty((0, 0)))

    def __call__(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(D,) objective and (D, constraints) margins of (D, free variables)."""
        x = np.ascontiguousarray(np.clip(x, 0.0, 1.0))
        if x.tobytes() != self._key:
            self._key, self._kept = x.tobytes(), sampled(self.problem, x, SEARCH_GRID)
            self.evaluations += len(x)
        return self._kept


def pymoo_ga(worth: Counted) -> np.ndarray:
    """pymoo's GA as it comes, the paper's population and generations."""
    from pymoo.algorithms.soo.nonconvex.ga import GA
    from pymoo.core.problem import Problem as PymooProblem
    from pymoo.operators.crossover.sbx import SBX
    from pymoo.optimize import minimize

    n = len(worth.problem.free)
    count = worth(np.full((1, n), 0.5))[1].shape[1]

    class Posed(PymooProblem):
        def _evaluate(self, x: np.ndarray, out: dict[str, Any], *_: Any, **__: Any) -> None:
            objective, margins = worth(x.astype(float))
            out["F"], out["G"] = objective[:, None], -margins

    posed = Posed(n_var=n, n_obj=1, n_ieq_constr=count, xl=np.zeros(n), xu=np.ones(n))
    algorithm: Any = GA(pop_size=POPULATIONS[worth.problem.step], crossover=SBX(prob=CROSSOVER))
    found = minimize(posed, algorithm, ("n_gen", GENERATIONS), seed=SEED)
    if found.X is None:
        raise RuntimeError("pymoo's GA met no feasible design: nothing to compare")
    return np.asarray(found.X, dtype=float)


def differential_evolution(worth: Counted) -> np.ndarray:
    """SciPy's, its defaults but for the whole population in one call and no polish; until it has converged."""
    from scipy.optimize import NonlinearConstraint
    from scipy.optimize import differential_evolution as evolution

    n = len(worth.problem.free)
    return evolution(
        lambda x: worth(np.atleast_2d(x.T))[0],
        [(0.0, 1.0)] * n,
        constraints=NonlinearConstraint(lambda x: worth(np.atleast_2d(x.T))[1].T, 0.0, np.inf),
        vectorized=True,
        updating="deferred",
        polish=False,
        rng=SEED,
    ).x


def slsqp(worth: Counted) -> np.ndarray:
    """SciPy's from our starts, straight on the worst point, gradients by its own differences: as the paper used SQP."""
    from scipy.optimize import minimize

    best, least = None, (np.inf, np.inf)
    for start in sqp.start_points(worth.problem, SEED):
        found = minimize(
            lambda x: float(worth(x[None])[0][0]),
            start,
            method="SLSQP",
            bounds=[(0.0, 1.0)] * len(start),
            constraints={"type": "ineq", "fun": lambda x: worth(x[None])[1][0]},
        )
        x = np.clip(found.x, 0.0, 1.0)
        objective, margins = worth(x[None])
        lacking = max(0.0, -float(margins.min()) - ACCURACY)
        if (lacking, objective[0]) < least:
            best, least = x, (lacking, float(objective[0]))
    if best is None:
        raise RuntimeError("SciPy's SLSQP gave no design: nothing to compare")
    return best


PEERS: dict[str, Callable[[Counted], np.ndarray]] = {
    "pymoo's GA": pymoo_ga,
    "SciPy's differential_evolution": differential_evolution,
    "SciPy's SLSQP, 6 starts": slsqp,
}


def peer(name: str, problem: Problem) -> Outcome:
    """One peer on one step, on the NumPy objective.

    Args:
        name: A key of `PEERS`.
        problem: The step.

    Raises:
        RuntimeError: It found no design at all.
    """
    worth = Counted(problem)
    with numpy_objective():
        start = process_time()
        x = PEERS[name](worth)
        seconds = process_time() - start
    mm = np.clip(problem.designs(x[None])[0] * 1000.0, problem.lower, problem.upper)
    return _outcome(seconds, worth.evaluations, Result(problem, name, tuple(mm.tolist()), "sampled"))


def own(given: Requirements, method: str, step: int) -> Outcome:
    """One of our methods on one step, on the NumPy objective."""
    run = partial(Run(given, method, SEED, (step,)).results)
    with numpy_objective():
        start = process_time()
        (result,) = run()
        seconds = process_time() - start
    return _outcome(seconds, result.evaluations, result)


def _outcome(seconds: float, evaluations: int, result: Result) -> Outcome:
    return Outcome(seconds, evaluations, result.objective, max(result.violations.values(), default=0.0))
