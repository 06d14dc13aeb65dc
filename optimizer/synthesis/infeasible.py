"""The smallest set of constraints that cannot be met together: feasibility searches over their subsets."""

from __future__ import annotations

from collections.abc import Callable
from itertools import combinations

import numpy as np

from optimizer.problem.requirements import Requirements
from optimizer.problem.step import CONSTRAINTS, Problem, step_problem
from optimizer.search.active_set import SLACK
from optimizer.search.sqp import Search, exchange, start_points

# Starts of each feasibility search; a contradiction shows from any of them, only what is barely possible wants more.
STARTS = 4
_CLEAR = (
    10.0 * SLACK
)  # what some of the constraints must lack for a contradiction: searches end so near to a mere point


class InfeasibleError(ValueError):
    """A step whose constraints cannot be met together.

    Attributes:
        step: 1, 2 or 3.
        conflict: Names of constraints, of `CONSTRAINTS`: the smallest set that cannot be met together.
        words: The same, described.
        shortfall: How far the best design found stays below the worst margin of all constraints, without unit.
        proved: Whether it is proved that no design within the bounds meets all constraints of the step.
    """

    def __init__(
        self, step: int, conflict: tuple[str, ...], words: tuple[str, ...], shortfall: float, proved: bool = False
    ) -> None:
        self.step, self.conflict, self.words, self.shortfall, self.proved = step, conflict, words, shortfall, proved
        what = " and ".join(words)
        verb = "cannot be met together" if len(words) > 1 else "cannot be met"
        super().__init__(
            f"step {step}: {what} {verb} within bounds_mm; the nearest design found lacks {shortfall:.3g} of a margin"
            + ("; proved: no design within bounds_mm meets all constraints of the step" if proved else "")
        )

    def as_proved(self) -> InfeasibleError:
        """Gives the same error, with a proof behind it."""
        return InfeasibleError(self.step, self.conflict, self.words, self.shortfall, True)


def best_level(problem: Problem, seed: int) -> float:
    """Searches from several starts for the largest worst margin, until that shows feasibility.

    Returns:
        The level, without unit; >= 0, to `SLACK`, where all constraints are met.
    """
    level = -np.inf
    for start in start_points(problem, seed, STARTS):
        level = max(level, exchange(problem, "feasibility", start, Search()).level)
        if level >= -SLACK:
            break
    return float(level)


def explain(given: Requirements, problem: Problem, reached_mm: float | None, seed: int) -> InfeasibleError | None:
    """Finds the smallest set of constraints that cannot be met together.

    Single constraints are tried first. Then a deletion filter finds a set none of whose members can be left out, and
    all smaller sets are tried, so that no contradiction has fewer members. Sets of the same size are told apart by the
    filter, which leaves out in the order of `CONSTRAINTS`. Feasibility is decided by local searches from several
    starts.

    Args:
        given: What the customer gave.
        problem: The step that failed.
        reached_mm: Half side that the step before reached, as `step_problem` takes it.
        seed: Seed of the starts.

    Returns:
        The error that names the contradiction; None if the step is feasible after all.
    """
    shortfall = best_level(problem, seed)
    if shortfall >= -SLACK:
        return None
    every = frozenset(problem.constraints)

    def impossible(members: frozenset[str]) -> bool:
        level = best_level(step_problem(given, problem.step, reached_mm, every - members), seed)
        return level < -_CLEAR

    smallest = _smallest(problem.constraints, impossible)
    conflict = tuple(name for name in CONSTRAINTS if name in smallest)
    return InfeasibleError(problem.step, conflict, tuple(problem.describe(name) for name in conflict), -shortfall)


def _smallest(names: tuple[str, ...], impossible: Callable[[frozenset[str]], bool]) -> frozenset[str]:
    """Finds the smallest impossible set of constraints, all of which together are impossible.

    What lies inside a set that can be met can be met too, and is not tried. A search that fails proves nothing: a
    single constraint is named only where no set of all but one other can be met.
    """
    every, possible, failed = frozenset(names), list[frozenset[str]](), set[frozenset[str]]()

    def fails(trial: frozenset[str]) -> bool:
        if any(trial <= one for one in possible):
            return False
        if trial in failed or impossible(trial):
            failed.add(trial)
            return True
        possible.append(trial)
        return False

    for name in names:
        if fails(frozenset({name})) and all(fails(every - {other}) for other in names if other != name):
            return frozenset({name})
    smallest = every
    for name in names:
        if fails(smallest - {name}):
            smallest -= {name}
    for size in range(2, len(smallest)):
        for members in combinations(names, size):
            if fails(frozenset(members)):
                return frozenset(members)
    return smallest


def explain_proved(given: Requirements, problem: Problem, reached_mm: float | None, seed: int) -> InfeasibleError:
    """Finds that set for a step that is proved to be infeasible.

    Args:
        given: What the customer gave.
        problem: The step.
        reached_mm: Half side that the step before reached, as `step_problem` takes it.
        seed: Seed of the starts.

    Returns:
        The error, marked as proved. It names the smallest contradiction, or all constraints where the local searches
        see none: then no more than a rounding is lacking.
    """
    error = explain(given, problem, reached_mm, seed)
    if error is not None:
        return error.as_proved()
    described = tuple(problem.describe(name) for name in problem.constraints)
    return InfeasibleError(problem.step, problem.constraints, described, max(0.0, -best_level(problem, seed)), True)
