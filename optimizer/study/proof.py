"""Proofs beside a front: how far below each point a design could be, and how much larger than the largest a cube."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from optimizer.globalopt.optimum import prove_optimum
from optimizer.problem.step import Problem, step_problem
from optimizer.search.result import finite
from optimizer.study.front import Curve
from optimizer.synthesis.checkpoint import Checkpoint
from optimizer.synthesis.three_step import remembered

GAP = 1e-4  # gap at which each proof ends, as a share of the objective
# Boxes of designs for each proof: with three free variables 5,000 are usual, with more the gap stays as it then is.
BOXES = 12_000


def proved(
    curve: Curve,
    report: Callable[[int, int], None] | None = None,
    stop: Callable[[], bool] = bool,
    store: Checkpoint | None = None,
    seconds: float = math.inf,
) -> Curve:
    """Adds a proven bound to every point of a front, and to its largest cube.

    Args:
        curve: The front.
        report: Called after each proof: how many are done, and how many there are.
        stop: Called before and in each proof; True ends with the bounds there are.
        store: Keeps each proof; None keeps nothing.
        seconds: Time after which each proof ends with what it reached.

    Returns:
        The same front with its bounds; None where a proof came to none.
    """
    if not curve.points:
        return curve
    total = len(curve.points) + 1
    key, most = f"{curve.name}/proof/largest", step_problem(curve.given, 2)
    largest = _bound(key, most, curve.points[-1].result.design_mm, stop, store, seconds)
    points = []
    for number, point in enumerate(curve.points, 1):
        if report is not None:
            report(number, total)
        result = point.result
        key = f"{curve.name}/proof/{point.half_side!r}"
        bound = None if stop() else _bound(key, result.problem, result.design_mm, stop, store, seconds)
        points.append(replace(point, bound=bound))
    if report is not None:
        report(total, total)
    return replace(curve, points=tuple(points), largest_bound=largest)


def _bound(
    key: str,
    problem: Problem,
    design_mm: tuple[float, ...],
    stop: Callable[[], bool],
    store: Checkpoint | None,
    seconds: float,
) -> float | None:
    def solve() -> dict[str, Any] | None:
        proven = prove_optimum(problem, gap=GAP, max_boxes=BOXES, incumbent_mm=design_mm, seconds=seconds, stop=stop)
        if stop():  # as far as it came is no fact to keep
            return None
        # without an incumbent nothing stands beside the bound
        return {"bound": finite(proven.bound) if proven.design_mm else None}

    kept = remembered(store, f"{key}/{seconds!r}", solve)
    return None if kept is None else kept["bound"]
