"""The three steps one after the other, each by GA, SQP, GA and then SQP, or by proof; every phase can be kept."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import astuple, dataclass, field, replace
from functools import partial
from typing import NamedTuple

import numpy as np

from optimizer.globalopt import bound as proving
from optimizer.globalopt.bound import Effort
from optimizer.globalopt.optimum import Now
from optimizer.problem.extremes import design_worst
from optimizer.problem.requirements import Requirements
from optimizer.problem.step import SIDE, Problem, ProblemError, step_problem
from optimizer.search import genetic, sqp
from optimizer.search.active_set import ROUNDING
from optimizer.search.result import Bound, Result
from optimizer.search.sqp import Ending
from optimizer.synthesis.checkpoint import Checkpoint, remembered
from optimizer.synthesis.infeasible import explain, explain_proved

METHODS = ("ga", "sqp", "ga+sqp", "proven")
_CANDIDATES = 10  # designs of the last generation that are looked at between the samples
HALVINGS = 24  # halvings of the part by which a cube is made smaller: to 1e-9 of L
_SHRINK = 0.05  # largest part; more would be another design


class Progress(NamedTuple):
    """The progress of a run.

    Attributes:
        step: 1, 2 or 3.
        phase: `ga`, `sqp`, `conflict` where a contradiction is looked for, or `proof`.
        done: Generations, starts, or boxes of designs.
        total: How many there are; of boxes at most.
        best: Best objective so far: half side in mm, or kappa; NaN before there is one.
        bound: What is proved so far that no design beats; NaN in the other phases.
        certifying: Boxes of the cube of the design that the proof is certifying; 0 where it is not.
    """

    step: int
    phase: str
    done: int
    total: int
    best: float
    bound: float = math.nan
    certifying: int = 0


class _Outcome(NamedTuple):
    """What a phase adds to its problem and method: fields of `Result`, in their order."""

    design_mm: tuple[float, ...]
    status: str
    evaluations: int
    starts: tuple[Ending, ...]
    proof: Bound | None


@dataclass
class Run:
    """One run of the three steps.

    Attributes:
        given: What the customer gave.
        method: One of `METHODS`.
        seed: Seed of everything random.
        steps: Which of the three, in order.
        population: Individuals of the GA; None for the paper's.
        generations: Generations of the GA.
        effort: How far proofs go.
        prove: Whether the other methods' results get a bound, and contradictions a proof, too, if numba is installed.
        report: Called with the progress of the run.
        stop: Called after each generation, each start, and in proofs; True ends the run with the best so far.
        store: Keeps the phases; None keeps nothing. What a proof came to is kept by its effort, so that a run may be
            taken up with another one, or without.
        found: Called with the results so far, the last of them feasible, and what is still to come: before each proof,
            at each better design in it, and between two steps.
    """

    given: Requirements
    method: str = "ga+sqp"
    seed: int = 0
    steps: tuple[int, ...] = (1, 2, 3)
    population: int | None = None
    generations: int = genetic.GENERATIONS
    effort: Effort = field(default_factory=Effort)
    prove: bool = False
    report: Callable[[Progress], None] | None = None
    stop: Callable[[], bool] = bool
    store: Checkpoint | None = None
    found: Callable[[list[Result], str], None] | None = None

    def results(self) -> list[Result]:
        """Solves the steps.

        Returns:
            One result a step; fewer if the run was stopped, the last of them as far as it came, or where a step ended
            without a cube that step 3 could go on with.

        Raises:
            ProblemError: An unknown method, steps that are not in order, step 3 without a half side, or no numba for
                the method `proven`.
            InfeasibleError: A step whose constraints cannot be met together.
        """
        if self.method not in METHODS:
            raise ProblemError(f"method is {self.method!r}; it must be one of {', '.join(METHODS)}")
        if not self.steps or list(self.steps) != sorted(set(self.steps)):
            raise ProblemError(f"steps are {list(self.steps)}; each of 1, 2, 3 once at most, in order")
        results: list[Result] = []
        for step in self.steps:
            if results:
                self._found(results, f"step {step} is still to come")
            before = results[-1] if results else None
            reached = before.design_mm[SIDE] if before and before.feasible else None
            if step == 3 and 2 not in self.steps:
                reached = None  # what step 1 reached is no half side that the torque allows
            if step == 3 and 2 in self.steps and reached is None and self.given.step_3.half_side_mm is None:
                break  # step 2 says what it lacks
            if step == 2 and self.method == "proven":
                reached = _bound(before)
            result = self._solve(step_problem(self.given, step, reached), reached, results)
            results.append(result)
            if result.status == "interrupted" or result.tiny:
                break
        return results

    def _found(self, results: list[Result], coming: str) -> None:
        last = results[-1]
        if self.found is not None and last.feasible and not last.tiny:
            self.found(results, coming)

    def _solve(self, problem: Problem, reached: float | None, done: list[Result]) -> Result:
        before = done[-1] if done else None
        if self.method == "proven":
            return self._phase(problem, self._by_effort("proven"), lambda: self._proven(problem, reached, done))
        proves, effort = self.prove and proving.available(), (self.seed, self.effort)
        known = np.empty((0, len(problem.free)))
        if before is not None:  # what the step before found, its cube cut down to what this step allows
            known = problem.scaled(before.design_mm)[None]
        result: Result | None = None
        if "ga" in self.method and problem.free:
            result = self._phase(problem, "ga", lambda: self._genetic(problem, known))
        if result is None or (self.method != "ga" and result.status != "interrupted"):
            start = result
            result = self._phase(problem, "sqp", lambda: self._sqp(problem, known, start))
        if not result.feasible and result.status != "interrupted":
            if self.report is not None:
                self.report(Progress(problem.step, "conflict", 0, 0, math.nan))
            error = explain(self.given, problem, reached, self.seed)
            if error is not None:
                tell = partial(self._tell_proof, problem)
                proved = proves and proving.solve(problem, *effort, tell, self.stop).status == "infeasible"
                if self.stop():
                    return replace(result, status="interrupted")
                raise error.as_proved() if proved else error
        if proves and result.feasible and not result.tiny and result.status != "interrupted":
            # what a search of step 1 reached bounds nothing: the proof is within bounds_mm, or what step 1 proved
            within = step_problem(self.given, 2, _bound(before)) if problem.step == 2 else problem
            tell = partial(self._tell_proof, within)
            self._found([*done, result], f"the proof of step {problem.step} is still to come")
            bounded = partial(proving.with_bound, result, *effort, tell, self.stop, within)
            result = self._phase(problem, self._by_effort("bound"), bounded)
        return result

    def _by_effort(self, name: str) -> str:
        """Names a phase that comes to something else with another effort."""
        return f"{name}/" + "/".join(f"{part!r}" for part in astuple(self.effort))

    def _phase(self, problem: Problem, name: str, solve: Callable[[], Result]) -> Result:
        """Takes the result of a phase from the store, or solves it and keeps it, unless the run was stopped."""
        solved: list[Result] = []

        def compute() -> _Outcome | None:
            solved.append(solve())
            return None if self.stop() else _Outcome(*(getattr(solved[0], field) for field in _Outcome._fields))

        kept = remembered(self.store, f"{problem.step}/{name}", compute, _Outcome)
        if kept is None:
            return replace(solved[0], status="interrupted")
        return solved[0] if solved else Result(problem, self.method, *kept)

    def _proven(self, problem: Problem, reached: float | None, done: list[Result]) -> Result:
        known = done[-1].design_mm if done and done[-1].feasible else None
        latest: tuple[float, ...] = ()

        def tell(now: Now) -> None:
            nonlocal latest
            self._tell_proof(problem, now)
            if now.design_mm and now.design_mm != latest:
                latest = now.design_mm
                best = Result(problem, self.method, latest, "interrupted")
                self._found([*done, best], f"the proof of step {problem.step} is under way")

        result = proving.solve(problem, self.seed, self.effort, tell, self.stop, known)
        if result.status == "infeasible":
            raise explain_proved(self.given, problem, reached, self.seed)
        return result

    def _tell_proof(self, problem: Problem, now: Now) -> None:
        if self.report is not None:
            at = (now.boxes, self.effort.boxes, now.best, now.bound, now.certifying)
            self.report(Progress(problem.step, "proof", *at))

    def _genetic(self, problem: Problem, known: np.ndarray) -> Result:
        def report(done: int, total: int, best: float) -> None:
            self._tell(problem, "ga", done, total, -best)

        def memo(x: np.ndarray, compute: Callable[[], genetic.Scores]) -> genetic.Scores:
            return remembered(self.store, f"{problem.step}/ga/generation", compute, genetic.Scores, x.tobytes())

        sizes = self.population, self.generations
        last = genetic.evolve(problem, self.seed, *sizes, known, memo, report, self.stop)
        x = best_holding(problem, last)
        result = Result(problem, self.method, problem.lengths_mm(x), "sampled", last.evaluations)
        if not result.feasible:
            result = replace(result, status="between the samples" if last.violation[0] == 0 else "no feasible design")
        return result

    def _sqp(self, problem: Problem, known: np.ndarray, start: Result | None) -> Result:
        if start is not None:
            starts = np.concatenate([problem.scaled(start.design_mm)[None], known])
        else:
            starts = np.concatenate([known, sqp.start_points(problem, self.seed)])

        def report(done: int, total: int, best: float) -> None:
            self._tell(problem, "sqp", done, total, best)

        outcome = sqp.search(problem, starts, report, self.stop)
        evaluations = outcome.evaluations + (0 if start is None else start.evaluations)
        best = outcome.best
        status = "not improved" if best is None else "converged"
        ending = best or max(outcome.endings, key=lambda e: e.level)
        design = problem.lengths_mm(ending.x)
        result = Result(problem, self.method, design, status, evaluations, tuple(outcome.endings))
        if start is not None and not result.better_than(start):
            result = replace(result, design_mm=start.design_mm, status="not improved")
        return result

    def _tell(self, problem: Problem, phase: str, done: int, total: int, level: float) -> None:
        if self.report is not None:
            self.report(Progress(problem.step, phase, done, total, _objective(problem, level)))


def best_holding(problem: Problem, last: genetic.Population) -> np.ndarray:
    """Finds the best of the last generation that also holds between the samples.

    A cube of steps 1 and 2 that does not is made smaller, about the middle of its bottom face, until it does: it then
    lies inside the old one, so that no margin gets worse.

    Returns:
        (free variables) scaled; the first of the generation if none holds.
    """
    best, worth = last.x[0], -np.inf
    for x in last.x[:_CANDIDATES]:
        shrunk = _shrunk(problem, x)
        if shrunk is not None:
            value = _level(problem, shrunk)
            if value > worth:
                best, worth = shrunk, value
    return best


def _shrunk(problem: Problem, x: np.ndarray) -> np.ndarray | None:
    """Shrinks a design's cube by up to 5 % until it holds on the polished surface; None where it does not."""
    if _holds(problem, x):
        return x
    if "half_side" not in problem.free:
        return None
    k = problem.free.index("half_side")
    design, low, high = x.copy(), x[k] * (1.0 - _SHRINK), x[k]
    design[k] = low
    if not _holds(problem, design):
        return None
    for _ in range(HALVINGS):
        design[k] = (low + high) / 2.0
        low, high = (design[k], high) if _holds(problem, design) else (low, design[k])
    design[k] = low
    return design


def _holds(problem: Problem, x: np.ndarray) -> bool:
    return sqp.violation(problem, x, design_worst(problem, problem.designs(x[None])[0], sqp.EXCHANGE_GRID)) <= ROUNDING


def _bound(one: Result | None) -> float | None:
    """Gives the half side that provably no design of steps 1 and 2 exceeds; None where it is unknown."""
    return None if one is None or one.proof is None else one.proof.bound


def _level(problem: Problem, x: np.ndarray) -> float:
    design = problem.designs(x[None])[0]
    if problem.step != 3:
        return float(design[SIDE])
    return float(design_worst(problem, design, sqp.EXCHANGE_GRID)["quality"].values[0])


def _objective(problem: Problem, level: float) -> float:
    """Computes the half side in mm from L scaled between its bounds, or kappa from its inverse; NaN for none."""
    if problem.step == 3:
        return 1.0 / level if level > 0.0 else np.nan
    low, high = problem.lower[SIDE], problem.upper[SIDE]
    return low + level * (high - low) if np.isfinite(level) else np.nan
