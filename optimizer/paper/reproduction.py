"""The published runs beside ours: what is printed, what follows from it, our three methods and the proven optimum."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import asdict, dataclass, field
from decimal import Decimal
from typing import Any, NamedTuple

from optimizer.globalopt.optimum import Now, Proven, prove_optimum
from optimizer.paper.evaluation import GAP, Evaluation, evaluate
from optimizer.paper.published import EXCHANGED_H, Lengths, PublishedRun, problem_of, start_within
from optimizer.problem.step import Problem
from optimizer.problem.variables import named
from optimizer.search.genetic import GENERATIONS
from optimizer.search.result import Result, finite
from optimizer.search.sqp import Search, descend
from optimizer.synthesis.three_step import Run

# Largest difference between a printed objective and what the printed lengths give: 0.3 %, stated bare and with half the
# last printed digit added.
AGREEMENT = 3e-3
METHODS = ("ga", "sqp", "ga+sqp")


class _Attempt(NamedTuple):
    """One of our methods under the bounds of a published run.

    Attributes:
        result: The design.
        start: Where SQP began: `paper`, or `project_own`.
        ending: How it ended.
    """

    result: Result
    start: str
    ending: str

    @property
    def objective(self) -> float | None:
        """Half side in mm, or kappa; None where the method ended outside its constraints."""
        return finite(self.result.objective) if self.result.feasible else None

    def record(self) -> dict[str, Any]:
        """Gathers the facts as plain data for JSON."""
        facts = self.result.record()
        names = ("variables", "max_kappa", "max_torque_N_m", "evaluations")
        own = {"start": self.start, "objective": self.objective, "ending": self.ending}
        return own | {name: facts[name] for name in names}


@dataclass(frozen=True)
class ReproducedRun:
    """A published run beside ours.

    Attributes:
        run: As printed.
        changed: Changes to its bounds and start.
        published: Its result by our equations; None where it has "no results".
        exchanged: The same with the H of the other row, where print looks exchanged.
        attempts: Method of `METHODS` -> its attempt.
        proven: The proven optimum under the same bounds.
    """

    run: PublishedRun
    changed: tuple[str, ...]
    published: Evaluation | None
    exchanged: Evaluation | None
    attempts: dict[str, _Attempt]
    proven: Proven

    @property
    def follows(self) -> float | None:
        """What should be printed: the largest half side that the printed lengths allow with the best H, or kappa."""
        if self.published is None:
            return None
        return self.published.max_kappa if self.run.step == 3 else self.published.largest_half_side_mm

    @property
    def difference(self) -> float | None:
        """Printed objective / `follows` - 1; None where nothing is compared."""
        printed, follows = self.run.objective, self.follows
        return None if printed is None or follows is None else (printed - follows) / follows

    @property
    def within(self) -> bool | None:
        """Whether print is within `AGREEMENT` with nothing added to it."""
        return None if self.difference is None else abs(self.difference) <= AGREEMENT

    @property
    def agrees(self) -> bool | None:
        """Whether print is within `AGREEMENT` beside half of its last digit."""
        printed, follows = self.run.objective, self.follows
        if printed is None or follows is None:
            return None
        exponent = Decimal(repr(printed)).as_tuple().exponent
        digit = 10.0**exponent if isinstance(exponent, int) else 0.0
        return max(0.0, abs(printed - follows) - digit / 2.0) <= AGREEMENT * follows

    @property
    def gap(self) -> float | None:
        """How far the published result is from the proven bound, as a share of it.

        Of the printed half side, negative where it is larger than any that is possible; of kappa by our equations.
        """
        if self.difference is None or self.run.objective is None or not math.isfinite(self.proven.bound):
            return None
        if self.run.step == 3:
            return (self.follows or math.nan) / self.proven.bound - 1.0
        return 1.0 - self.run.objective / self.proven.bound

    def record(self) -> dict[str, Any]:
        """Gathers the facts as plain data for JSON."""
        run, proven = self.run, self.proven
        return {
            "row": run.row,
            "method": run.method,
            "lower": _named(run.lower),
            "upper": _named(run.upper),
            "start": _named(run.start),
            "changed": list(self.changed),
            "note": run.note,
            "printed": _named(run.result),
            "printed_objective": run.objective,
            "by_our_equations": _evaluated(self.published),
            "with_H_exchanged": _evaluated(self.exchanged),
            "follows": self.follows,
            "difference": self.difference,
            "within_agreement": self.within,
            "within_beside_half_last_digit": self.agrees,
            "gap": self.gap,
            "found": {name: attempt.record() for name, attempt in self.attempts.items()},
            "proven": {
                **{name: finite(getattr(proven, name)) for name in ("objective", "bound", "gap")},
                "status": proven.status,
                "boxes": proven.boxes,
                "variables": _named(proven.design_mm or None),
            },
        }


def _named(design: Lengths | None) -> dict[str, float] | None:
    return None if design is None else named(design)


def _evaluated(evaluation: Evaluation | None) -> dict[str, Any] | None:
    return None if evaluation is None else {"keeps_its_constraints": not evaluation.faults, **asdict(evaluation)}


@dataclass
class Reproduction:
    """The recomputation of published runs; runs with the same bounds are solved once.

    Attributes:
        seed: Seed of everything random.
        population: Individuals of the GA; None for the paper's.
        generations: Generations of the GA.
        gap: Gap at which the proofs end.
        seconds: Time after which each of them ends with what it reached.
        report: Called with a line that says what is being done.
    """

    seed: int = 0
    population: int | None = None
    generations: int = GENERATIONS
    gap: float = GAP
    seconds: float = math.inf
    report: Callable[[str], None] = lambda _: None
    _solved: dict[Any, Any] = field(default_factory=dict, init=False)

    def recompute(self, runs: tuple[PublishedRun, ...]) -> list[ReproducedRun]:
        """Recomputes published runs.

        Returns:
            One for each, in order.
        """
        return [self._one(run, runs, f"{run.name} ({k} of {len(runs)})") for k, run in enumerate(runs, 1)]

    def _one(self, run: PublishedRun, runs: tuple[PublishedRun, ...], name: str) -> ReproducedRun:
        problem, changed = problem_of(run)
        start, moved = start_within(run, problem)
        attempts = {}
        for method in METHODS:
            self.report(f"{name}: {method}")
            attempts[method] = self._attempt(problem, method, start if method == "sqp" else None)
        self.report(f"{name}: proof of the optimum")
        proven = self._proven(problem, attempts, name)
        self.report(f"{name}: the published design")
        designs = (run.result, _exchanged(run, runs))
        published, exchanged = (None if d is None else evaluate(problem, d, self.gap) for d in designs)
        return ReproducedRun(run, (*changed, *moved), published, exchanged, attempts, proven)

    def _attempt(self, problem: Problem, method: str, start: Lengths | None) -> _Attempt:
        def solve() -> _Attempt:
            if start is not None:
                return _descended(problem, start)
            run = Run(problem.requirements, method, self.seed, (problem.step,), self.population, self.generations)
            result = run.results()[-1]
            return _Attempt(result, "ours", result.status)

        return self._once((problem.step, problem.lower, problem.upper, method, start), solve)

    def _proven(self, problem: Problem, attempts: dict[str, _Attempt], name: str) -> Proven:
        def tell(now: Now) -> None:
            self.report(f"{name}: proof of the optimum, {now.boxes:,} boxes")

        sign = 1.0 if problem.step == 3 else -1.0
        best = min(attempts.values(), key=lambda f: math.inf if f.objective is None else sign * f.objective)
        known = best.result.design_mm
        return self._once(
            (problem.step, problem.lower, problem.upper),
            lambda: prove_optimum(
                problem, gap=self.gap, incumbent_mm=known, seed=self.seed, seconds=self.seconds, report=tell
            ),
        )

    def _once(self, key: tuple[Any, ...], solve: Callable[[], Any]) -> Any:
        if key not in self._solved:
            self._solved[key] = solve()
        return self._solved[key]


def _descended(problem: Problem, start: Lengths) -> _Attempt:
    """Runs SQP from one start alone, as the paper did."""
    count = Search()
    ending = descend(problem, problem.scaled(start), count)
    status = "converged" if ending.converged else "not improved"
    return _Attempt(
        Result(problem, "sqp", problem.lengths_mm(ending.x), status, count.evaluations), "paper", ending.reason
    )


def _exchanged(run: PublishedRun, runs: tuple[PublishedRun, ...]) -> Lengths | None:
    """Gives the design with the H of the other of two rows, where print looks exchanged."""
    if (run.table, run.row) not in EXCHANGED_H or run.result is None:
        return None
    other = next(o.result for o in runs if (o.table, o.row) in EXCHANGED_H and o.row != run.row)
    return None if other is None else (*run.result[:4], other[4], run.result[5])
