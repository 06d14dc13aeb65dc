"""The published runs beside ours: what is printed, what follows from it, our three methods and the proven optimum."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from decimal import Decimal
from typing import Any

import numpy as np

from optimizer.globalopt.optimum import Proven, prove_optimum
from optimizer.paper.cases import EXCHANGED_H, Case, Lengths, posed, start_of
from optimizer.paper.judgement import GAP, Judged, judge
from optimizer.problem.step import MM_PER_M, Problem
from optimizer.search.genetic import GENERATIONS
from optimizer.search.result import Result
from optimizer.search.sqp import Search, descend
from optimizer.synthesis.three_step import Run

AGREEMENT = 3e-3
"""Between a printed objective and what follows from the printed lengths: 0.3 %, told bare and with half the last
printed digit added."""
METHODS = ("ga", "sqp", "ga+sqp")
Tell = Callable[[str], None]


@dataclass(frozen=True)
class Found:
    """What one of our methods found under the bounds of a published run.

    Attributes:
        method: `ga`, `sqp` or `ga+sqp`.
        start: Where SQP began: `paper`, or `ours`.
        objective: Half side in mm, or kappa; None where the method ended outside its constraints.
        design_mm: (6) lengths.
        kappa: Worst condition number; None where it is infinite.
        torque_N_m: Worst joint torque; None where it is infinite.
        ending: How it ended.
        evaluations: Designs evaluated.
    """

    method: str
    start: str
    objective: float | None
    design_mm: Lengths
    kappa: float | None
    torque_N_m: float | None
    ending: str
    evaluations: int


@dataclass(frozen=True)
class Recomputed:
    """A published run beside ours.

    Attributes:
        case: As printed.
        changed: What of its bounds and start had to be changed, in words.
        published: Its result by our equations; None where it has "no results".
        exchanged: The same with the H of the other row, where print looks exchanged.
        found: Ours: GA, SQP, GA+SQP.
        proven: The proven optimum under the same bounds.
        follows: What the printed objective should be: the largest half side that the printed lengths allow with the
            best H, or their kappa; None without a result.
        difference: printed objective / `follows` - 1.
        agrees: Whether that is within `AGREEMENT`, beside half of the last printed digit.
        gap: How far the published result is from the proven bound, as a share of it: of the printed half side, negative
            where it is larger than any that is possible; of kappa by our equations.
    """

    case: Case
    changed: tuple[str, ...]
    published: Judged | None
    exchanged: Judged | None
    found: tuple[Found, ...]
    proven: Proven
    follows: float | None
    difference: float | None
    agrees: bool | None
    gap: float | None

    def method(self, name: str) -> Found:
        """What one of our methods found."""
        return next(found for found in self.found if found.method == name)

    @property
    def within(self) -> bool | None:
        """Whether print is within `AGREEMENT` with nothing added to it; None where nothing is compared."""
        return None if self.difference is None else bool(self.agrees and abs(self.difference) <= AGREEMENT)


def _silent(_: str) -> None:
    """Tells nobody."""


@dataclass
class Reproduction:
    """The recomputation of published runs; runs with the same bounds are solved once.

    Attributes:
        seed: Of everything random.
        population: Individuals of the GA; None for the paper's.
        generations: Of the GA; None for the paper's.
        gap: That the proofs are asked for.
        tell: Told what is being done.
    """

    seed: int = 0
    population: int | None = None
    generations: int | None = None
    gap: float = GAP
    tell: Tell = _silent
    _runs: dict[Any, Found] = field(default_factory=dict, init=False)
    _proofs: dict[Any, Proven] = field(default_factory=dict, init=False)

    def recompute(self, cases: tuple[Case, ...]) -> list[Recomputed]:
        """Recomputes published runs.

        Args:
            cases: The runs.

        Returns:
            One for each, in order.
        """
        return [self._one(case, cases, f"{case.name} ({k + 1} of {len(cases)})") for k, case in enumerate(cases)]

    def _one(self, case: Case, cases: tuple[Case, ...], name: str) -> Recomputed:
        problem, changed = posed(case)
        start, moved = start_of(case, problem)
        found = []
        for method in METHODS:
            self.tell(f"{name}: {method}")
            found.append(self._found(problem, method, start if method == "sqp" else None))
        self.tell(f"{name}: proof of the optimum")
        best = min(found, key=lambda f: (f.objective is None, _cost(problem, f.objective)))
        proven = self._proven(problem, best)
        self.tell(f"{name}: the published design")
        published = exchanged = None
        if case.result is not None:
            published = judge(problem, case.result, self.gap)
            other = _exchanged(case, cases)
            exchanged = None if other is None else judge(problem, other, self.gap)
        follows, difference, agrees = _compared(case, published)
        gap = _gap(case, published, proven)
        return Recomputed(
            case, (*changed, *moved), published, exchanged, tuple(found), proven, follows, difference, agrees, gap
        )

    def _found(self, problem: Problem, method: str, start: Lengths | None) -> Found:
        key = (problem.step, problem.lower, problem.upper, method, start)
        if key not in self._runs:
            self._runs[key] = self._solve(problem, method) if start is None else self._descended(problem, start)
        return self._runs[key]

    def _solve(self, problem: Problem, method: str) -> Found:
        generations = GENERATIONS if self.generations is None else self.generations
        run = Run(problem.requirements, method, self.seed, (problem.step,), self.population, generations)
        result = run.results()[-1]
        return _told(result, result.status, "ours")

    def _descended(self, problem: Problem, start: Lengths) -> Found:
        """SQP from one start alone, as the paper did."""
        count = Search()
        ending = descend(problem, problem.scaled(np.array(start)), count)
        mm = problem.designs(np.array(ending.x)[None])[0] * MM_PER_M
        design = tuple(float(v) for v in np.clip(mm, problem.lower, problem.upper))
        result = Result(problem, "sqp", design, "converged" if ending.converged else "not improved", count.evaluations)
        return _told(result, ending.reason, "paper")

    def _proven(self, problem: Problem, best: Found) -> Proven:
        key = (problem.step, problem.lower, problem.upper)
        if key not in self._proofs:
            self._proofs[key] = prove_optimum(problem, gap=self.gap, incumbent_mm=best.design_mm, seed=self.seed)
        return self._proofs[key]


def _exchanged(case: Case, cases: tuple[Case, ...]) -> Lengths | None:
    """The design with the H of the other of two rows, where print looks exchanged."""
    if (case.table, case.row) not in EXCHANGED_H or case.result is None:
        return None
    other = next(c for c in cases if (c.table, c.row) in EXCHANGED_H and c.row != case.row)
    return None if other.result is None else (*case.result[:4], other.result[4], case.result[5])


def _compared(case: Case, published: Judged | None) -> tuple[float | None, float | None, bool | None]:
    """What should be printed, how far print is from it, and whether that is agreement."""
    follows = None if published is None else published.kappa if case.step == 3 else published.largest_mm
    if case.objective is None or follows is None:
        return follows, None, None
    exponent = Decimal(repr(case.objective)).as_tuple().exponent
    digit = 10.0**exponent if isinstance(exponent, int) else 0.0
    difference = case.objective - follows
    agrees = max(0.0, abs(difference) - digit / 2.0) <= AGREEMENT * follows
    return follows, difference / follows, agrees


def _gap(case: Case, published: Judged | None, proven: Proven) -> float | None:
    if published is None or case.objective is None or not math.isfinite(proven.bound):
        return None
    if case.step == 3:
        return None if published.kappa is None else published.kappa / proven.bound - 1.0
    return 1.0 - case.objective / proven.bound


def _told(result: Result, ending: str, start: str) -> Found:
    return Found(
        result.method,
        start,
        _finite(result.objective) if result.feasible else None,
        result.design_mm,
        _finite(result.max_kappa),
        _finite(result.max_torque),
        ending,
        result.evaluations,
    )


def _cost(problem: Problem, objective: float | None) -> float:
    if objective is None:
        return math.inf
    return objective if problem.step == 3 else -objective


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
