"""From a proof to a result: the method `proven`, and a bound beside what another method found."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from importlib.util import find_spec

import numpy as np

from delta_cad.common.units import MM_PER_M
from optimizer.problem.step import Problem, ProblemError
from optimizer.search.result import Bound, Result

# Boxes examined, boxes at most, certified objective so far, bound so far.
Report = Callable[[int, int, float, float], None]


@dataclass(frozen=True)
class Effort:
    """How far a proof goes.

    Attributes:
        gap: Relative two-sided gap at which it ends.
        boxes: Boxes of designs after which it ends with the gap that it reached.
    """

    gap: float = 1e-5
    boxes: int = 2_000_000


def available() -> bool:
    """Whether numba is installed, without which nothing is proved."""
    return find_spec("numba") is not None


def solve(
    problem: Problem,
    seed: int,
    effort: Effort,
    report: Report | None = None,
    stop: Callable[[], bool] = bool,
    before_mm: tuple[float, ...] | None = None,
) -> tuple[Result, bool]:
    """The optimum of a step by proof.

    Args:
        problem: The step.
        seed: Of the starts of SQP for the first incumbent.
        effort: How far to go.
        report: Told where it is.
        stop: Asked now and then; True ends it.
        before_mm: (6,) what the step before found, to fall back on, mm; None for nothing.

    Returns:
        The result; its design is the middle of the bounds where none is known. Whether no design is feasible, proved.

    Raises:
        ProblemError: numba is not installed.
    """
    if not available():
        raise ProblemError("a proof needs numba, which is not installed: install delta-haptics[optimize]")
    from optimizer.globalopt.optimum import Now, prove_optimum

    def tell(now: Now) -> None:
        if report is not None:
            report(now.boxes, effort.boxes, now.best, now.bound)

    found = prove_optimum(
        problem, gap=effort.gap, max_boxes=effort.boxes, before_mm=before_mm, seed=seed, report=tell, stop=stop
    )
    design = found.design_mm
    if not design:
        middle = problem.designs(np.full((1, len(problem.free)), 0.5))[0] * MM_PER_M
        design = tuple(float(v) for v in np.clip(middle, problem.lower, problem.upper))
    proof = Bound(
        _told(found.objective) if found.certified else None, _told(found.bound), _told(found.gap), found.boxes
    )
    return Result(problem, "proven", design, found.status, proof=proof), found.status == "infeasible"


def with_bound(
    result: Result,
    seed: int,
    effort: Effort,
    report: Report | None = None,
    stop: Callable[[], bool] = bool,
    within: Problem | None = None,
) -> Result:
    """A feasible result with the bound of its step and its own distance from that.

    Args:
        result: What another method found.
        seed: Of the starts of SQP, should the result not do as an incumbent.
        effort: How far to go.
        report: Told where it is.
        stop: Asked now and then; True ends it.
        within: The step that the bound is of, where the search had narrower bounds; None for the result's own.

    Returns:
        The same with a proof; unchanged if there is no bound, because the result is feasible to a rounding only.
    """
    from optimizer.globalopt.optimum import Now, prove_optimum

    def tell(now: Now) -> None:
        if report is not None:
            report(now.boxes, effort.boxes, now.best, now.bound)

    found = prove_optimum(
        result.problem if within is None else within,
        gap=effort.gap,
        max_boxes=effort.boxes,
        incumbent_mm=result.design_mm,
        before_mm=result.design_mm,
        seed=seed,
        report=tell,
        stop=stop,
    )
    if not math.isfinite(found.bound):
        return result
    distance = abs(result.objective - found.bound)
    gap = distance / result.objective if result.objective > 0.0 else math.inf
    return replace(result, proof=Bound(None, found.bound, _told(gap), found.boxes))


def _told(value: float) -> float | None:
    return value if math.isfinite(value) else None
