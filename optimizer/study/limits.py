"""Step 3 at a half side, and what keeps a cube from being larger, or from being at all."""

from __future__ import annotations

from optimizer.problem.requirements import Requirements
from optimizer.problem.step import SIDE, Problem, step_problem
from optimizer.synthesis.infeasible import InfeasibleError, explain

# Part of the largest half side: less is no range of sizes but one size; part of its upper bound: less is no cube.
RANGE_MIN = 1e-3
# Larger by this part than the largest half side: there the contradicting constraints are searched.
BEYOND = 0.01


def at_side(given: Requirements, side: float) -> Problem:
    """Poses step 3 at a half side in mm, whatever `bounds_mm.half_side` says."""
    step_3 = given.step_3.model_copy(update={"half_side_mm": side})
    return step_problem(given.model_copy(update={"step_3": step_3}), 3)


def beyond(given: Requirements, largest: float, seed: int) -> tuple[str, ...]:
    """Finds the smallest set of constraints that cannot be met together 1 % beyond the largest half side.

    Args:
        given: The requirements.
        largest: Largest half side, mm.
        seed: Seed of the feasibility searches.

    Returns:
        The constraints, described; none where the searches found a larger cube feasible.
    """
    problem, bound = at_side(given, largest * (1.0 + BEYOND)), given.bounds_mm.half_side[1]
    if problem.upper[SIDE] > bound:
        return (f"half side <= {bound:g} mm (bounds_mm.half_side)",)
    return described_conflict(problem, explain(problem.requirements, problem, None, seed))


def no_cube(given: Requirements, seed: int) -> InfeasibleError | None:
    """Finds what contradicts every cube that has a size, where only one without is left: kappa of 1 holds in a point.

    Args:
        given: The requirements.
        seed: Seed of the feasibility searches.

    Returns:
        The contradiction with a half side of `RANGE_MIN` of its upper bound; None where that can be met.
    """
    problem = at_side(given, RANGE_MIN * given.bounds_mm.half_side[1])
    error = explain(problem.requirements, problem, None, seed)
    if error is None:
        return None
    return InfeasibleError(2, error.conflict, described_conflict(problem, error), error.shortfall)


def described_conflict(problem: Problem, error: InfeasibleError | None) -> tuple[str, ...]:
    """Describes the members of a contradiction, the half side by its number."""
    if error is None:
        return ()
    side = f"half side {problem.lower[SIDE]:.4g} mm"
    named = zip(error.conflict, error.words, strict=True)
    return tuple(side if name == "half_side" and problem.lower[SIDE] > 0.0 else words for name, words in named)
