"""From a proof to a result: the method `proven`, and a bound beside what another method found."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from importlib.util import find_spec
from typing import Any

import numpy as np

from delta_cad.common.refusal import not_installed
from optimizer.globalopt.optimum import Now, prove_optimum
from optimizer.problem.step import Problem, ProblemError
from optimizer.search.result import Bound, Result, finite

PLACED_GAP = 1e-2  # at which the bound beside another method's result ends where the placement is free


@dataclass(frozen=True)
class Effort:
    """How far a proof goes.

    Attributes:
        gap: Relative two-sided gap at which it ends.
        boxes: Boxes of designs after which it ends with the gap that it reached.
        seconds: Time after which it does so.
    """

    gap: float = 1e-5
    boxes: int = 2_000_000
    seconds: float = math.inf

    def most(self) -> dict[str, Any]:
        """Gives it as arguments of `prove_optimum`."""
        return {"gap": self.gap, "max_boxes": self.boxes, "seconds": self.seconds}


def available() -> bool:
    """Tells whether numba is installed, without which nothing is proved."""
    return find_spec("numba") is not None


def solve(
    problem: Problem,
    seed: int,
    effort: Effort,
    report: Callable[[Now], None] | None = None,
    stop: Callable[[], bool] = bool,
    before_mm: tuple[float, ...] | None = None,
) -> Result:
    """Finds the optimum of a step by proof.

    Args:
        problem: The step.
        seed: Seed of SQP's starts for the first incumbent.
        effort: How far to go.
        report: Called with the state of the proof.
        stop: Called now and then; True ends the proof.
        before_mm: (9,) design of the step before, to fall back on, mm; None without one.

    Returns:
        The result. Its design is the certified one; without one the best that was found, and without that the middle
        of the bounds. Its status is "infeasible" where that is proved of every design.

    Raises:
        ProblemError: numba is not installed.
    """
    if not available():
        raise ProblemError(not_installed("numba", "optimize"))
    found: tuple[float, ...] = ()

    def tell(now: Now) -> None:
        nonlocal found
        found = now.design_mm or found
        if report is not None:
            report(now)

    proven = prove_optimum(problem, **effort.most(), before_mm=before_mm, seed=seed, report=tell, stop=stop)
    design = proven.design_mm or found or problem.lengths_mm(np.full(len(problem.free), 0.5))
    objective = finite(proven.objective) if proven.certified else None
    proof = Bound(objective, finite(proven.bound), finite(proven.gap), proven.boxes, proven.late)
    return Result(problem, "proven", design, proven.status, proof=proof)


def with_bound(
    result: Result,
    seed: int,
    effort: Effort,
    report: Callable[[Now], None] | None = None,
    stop: Callable[[], bool] = bool,
    within: Problem | None = None,
) -> Result:
    """Adds to a feasible result the bound of its step and its own distance from that bound.

    Args:
        result: Result of another method.
        seed: Seed of SQP's starts, should the result not do as an incumbent.
        effort: How far to go.
        report: Called with the state of the proof.
        stop: Called now and then; True ends the proof.
        within: The step that is bounded, where the search had narrower bounds; None for the result's own.

    Returns:
        The same with a proof; unchanged if there is no bound, because the result is feasible to a rounding only.
    """
    if not result.problem.symmetric:
        effort = replace(effort, gap=max(effort.gap, PLACED_GAP))
    proven = prove_optimum(
        result.problem if within is None else within,
        **effort.most(),
        incumbent_mm=result.design_mm,
        before_mm=result.design_mm,
        seed=seed,
        report=report,
        stop=stop,
    )
    if not math.isfinite(proven.bound):
        return result
    gap = abs(result.objective - proven.bound) / result.objective if result.objective > 0.0 else math.inf
    return replace(result, proof=Bound(None, proven.bound, finite(gap), proven.boxes, proven.late))
