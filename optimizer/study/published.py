"""The published designs of steps 2 and 3 beside a front: their half side, kappa and torque by our equations."""

from __future__ import annotations

from dataclasses import dataclass

from optimizer.paper.published import PublishedRun, published_runs
from optimizer.problem.evaluator import VARIABLES
from optimizer.problem.requirements import Requirements
from optimizer.problem.step import SIDE
from optimizer.search.active_set import ROUNDING
from optimizer.search.result import Result
from optimizer.study.front import FrontPoint
from optimizer.study.limits import at_side

# Tables of [RCIM2018]: step 2 by GA, step 3 by GA, step 2 by SQP, step 3 by SQP, step 3 by GA and GA+SQP.
TABLES = (7, 8, 10, 11, 12)


@dataclass(frozen=True, kw_only=True)
class PublishedDesign(FrontPoint):
    """One published design, recomputed; `active` holds the constraints and bounds that it does not meet.

    Attributes:
        run: As it is printed.
    """

    run: PublishedRun


def published_designs(given: Requirements) -> list[PublishedDesign]:
    """Recomputes the designs of `TABLES` with the force of the requirements.

    Args:
        given: Requirements that they are compared with.

    Returns:
        One for each row that has a result.
    """
    designs = []
    for run in published_runs(TABLES):
        if run.result is not None:
            result = Result(at_side(given, run.result[SIDE]), "published", run.result, "converged")
            designs.append(PublishedDesign(result=result, active=misses(given, result), run=run))
    return designs


def misses(given: Requirements, result: Result) -> tuple[str, ...]:
    """Names what of the requirements a design does not meet: constraints by name, then bounds with the value."""
    named = [name for name, value in result.violations.items() if value > ROUNDING and name != "half_side"]
    for name, value in zip(VARIABLES, result.design_mm, strict=True):
        low, high = getattr(given.bounds_mm, name)
        if not low <= value <= high:
            named.append(f"{name} {value:g} mm")
    return tuple(named)
