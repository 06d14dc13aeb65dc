"""The result of a step: a record that recomputes its own violations on a fine surface of the cube."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from delta_cad.mechanism.limits import POSE_LIMITS, Kappa, PoseLimit, Torque
from optimizer.problem.evaluator import CENTRE, figures, fold_points
from optimizer.problem.extremes import design_worst, worst_points
from optimizer.problem.step import TINY_MM, Problem, outline_of
from optimizer.problem.variables import PER_SI, SIDE, completed, named
from optimizer.search.active_set import ROUNDING
from optimizer.search.sqp import Ending

# Endings of which only a bound tells how far they are from the best there is.
_GUESSES = ("converged", "sampled", "not improved")
CLOSE = 1e-3  # relative gap below which nothing is left to be gained that could be built
# Points along an edge of the surface on which a result checks itself, before each face's worst point is polished.
FINE_GRID = 41

# How a result can end -> what to do about it.
ADVICE = {
    "converged": "a local optimum of this start; other seeds or `proven` tell whether it is the best there is",
    "sampled": "the best of the last generation; `ga+sqp` takes it to the optimum",
    "not improved": "SQP found nothing better than its start; see the reasons of the starts",
    "between the samples": "the constraints hold on the GA's sample but not between its points; use `ga+sqp`",
    "no feasible design": "the GA met no feasible design though there is one; raise the population or use `sqp`",
    "interrupted": "stopped by hand; `--resume` goes on where it stopped",
    "proved": "holds at every point of its cube, and no design within the bounds is better by more than the gap",
    "gap not reached": "holds at every point of its cube; the gap is what was reached",
    "undecided": "no design was found and none was proved to be impossible",
    "infeasible": "no design within the bounds meets the constraints, proved; relax one of them",
}
STEEP = "its constraints hold at every point of its cube; kappa rises too steeply there to be proved and is sampled"
# What ended a proof that did not come to its end, by whether that was the time -> what to raise.
_MORE = {False: "raise --boxes", True: "the time was over: raise --proof-minutes"}
_NOTHING_GAINED = ("not improved", "gap not reached", "undecided")
FULL_SIDE = (
    "its half side is the largest that step 2 found, which leaves kappa next to nothing to gain: "
    "set step_3.half_side_mm below it"
)
# What the step before took from this one.
CAPPED = "its half side is all that the search of step 1 reached: `--method proven`, or more of that search, gives room"


class Bound(NamedTuple):
    """What was proved beside a result.

    Attributes:
        certified: Objective that is proved of the design at every point of its cube; None if it was sampled only.
        bound: No design within the bounds of the step is better: mm, or a condition number; None if there is none.
        gap: Distance of the objective from it, as a share of the objective; None without either.
        boxes: Boxes of designs that were examined.
        late: Whether the time was over before the proof came to its end.
    """

    certified: float | None
    bound: float | None
    gap: float | None
    boxes: int
    late: bool = False


@dataclass(frozen=True)
class Result:
    """The outcome of one step.

    Attributes:
        problem: The step that was solved.
        method: `ga`, `sqp`, `ga+sqp` or `proven`.
        design_mm: (9) in the order of `VARIABLES`, mm; (6) is completed, three-fold symmetric.
        status: How it ended, a key of `ADVICE`.
        evaluations: Designs evaluated.
        starts: How each start of SQP ended.
        proof: Bound and gap; None where nothing was proved.
    """

    problem: Problem
    method: str
    design_mm: tuple[float, ...]
    status: str
    evaluations: int = 0
    starts: tuple[Ending, ...] = ()
    proof: Bound | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "design_mm", tuple(completed(self.design_mm).tolist()))

    @property
    def advice(self) -> str:
        """Advice on how the step ended; a proven bound replaces guesses."""
        gap = None if self.proof is None else self.proof.gap
        if self.status in _GUESSES and gap is not None and gap <= CLOSE:
            return "the best there is within the bounds, but for the gap"
        text, more = ADVICE[self.status], _MORE[self.proof is not None and self.proof.late]
        if self.status in ("gap not reached", "undecided"):
            text = f"{text}: {more}"
        if self.status == "gap not reached" and self.proof is not None and self.proof.certified is None:
            text = STEEP
        if self.status in _GUESSES and gap is not None:
            text = f"at most {gap:.2g} of it can still be gained; {more}, or use `proven`"
        return text if gap is not None and gap <= CLOSE else text + self._narrowed()

    def _narrowed(self) -> str:
        """Notes that the half side found by the step before limits this one; empty where it does not."""
        given, step = self.problem.requirements, self.problem.step
        most = self.problem.upper[SIDE]
        if step == 3 and given.step_3.half_side_mm is None and self.status in _NOTHING_GAINED:
            return f"; {FULL_SIDE}"
        if step == 2 and most < given.bounds_mm.half_side[1] and self.design_mm[SIDE] >= most * (1.0 - ROUNDING):
            return f"; {CAPPED}"
        return ""

    @property
    def tiny(self) -> bool:
        """Whether the half side is below a micrometre: no cube that could be given to a machinist."""
        return self.design_mm[SIDE] < TINY_MM

    @cached_property
    def violations(self) -> dict[str, float]:
        """Name of each constraint -> how far its worst margin is below 0, without unit; 0 where it is met."""
        row = self._row
        worst_of = design_worst(self.problem, row[0], FINE_GRID)
        lowest = {name: float(worst.values[0]) for name, worst in worst_of.items() if name != "quality"}
        lowest |= {name: float(margin[0]) for name, margin in self.problem.design_margins(row).items()}
        if "half_side" in self.problem.constraints:
            low = self.problem.lower[SIDE]
            lowest["half_side"] = (self.design_mm[SIDE] - low) / low
        return {name: max(0.0, -lowest[name]) for name in self.problem.constraints}

    @property
    def feasible(self) -> bool:
        """Whether every constraint is met, to the rounding of lengths."""
        return max(self.violations.values(), default=0.0) <= ROUNDING

    @property
    def objective(self) -> float:
        """Half side in mm (steps 1 and 2) or largest condition number (step 3); the proved one where there is one."""
        if self.proof is not None and self.proof.certified is not None:
            return self.proof.certified
        return self.max_kappa if self.problem.step == 3 else self.design_mm[SIDE]

    @property
    def max_kappa(self) -> float:
        """Largest condition number over the cube; infinite where the determinant changes sign or a chain folds."""
        return self.worst(Kappa)

    @property
    def max_torque(self) -> float:
        """Largest joint torque over the cube and all directions of the force, N m; infinite where it is not held."""
        return self.worst(Torque)

    @cached_property
    def reported_limits(self) -> tuple[PoseLimit, ...]:
        """The limits whose worst figure can be told, bounding nothing; without those whose masses are not stated."""
        values = self.problem.requirements.values
        measured = (limit.measured(values) for limit in POSE_LIMITS if limit.output_key)
        return tuple(limit for limit in measured if limit is not None)

    def worst(self, kind: type[PoseLimit]) -> float:
        """Computes the worst value of a limit's figure over the cube.

        Args:
            kind: A limit of `wording`.

        Returns:
            SI units; infinite where it grows without bound.
        """
        if kind not in self._worst:
            limit = next(limit for limit in self.reported_limits if type(limit) is kind)
            self._worst.update(self._searched([limit]))
        return self._worst[kind]

    @property
    def _row(self) -> np.ndarray:
        """(1, 9) in SI units."""
        return np.array(self.design_mm)[None] / PER_SI

    @cached_property
    def _worst(self) -> dict[type[PoseLimit], float]:
        """Those of the worst values that are known; what grows without bound at a singularity is sought together."""
        return self._searched([limit for limit in self.reported_limits if limit.infinite_at_singularity])

    def _searched(self, limits: list[PoseLimit]) -> dict[type[PoseLimit], float]:
        row, wanted = self._row, {name for limit in limits for name in limit.evaluates}
        near = fold_points(row)[0] if any(limit.infinite_at_singularity for limit in limits) else np.empty((0, 3))

        def values(points: np.ndarray) -> dict[str, np.ndarray]:
            f = figures(row, points, "quality" in wanted, "angles" in wanted)
            return {f"{a.name} {name}": value[0] for a in limits for name, value in a.search_quantities(f).items()}

        found = worst_points(values, FINE_GRID, np.concatenate([CENTRE, near]))
        least: dict[str, dict[str, float]] = {}
        for key, worst in found.items():
            limit, _, name = key.partition(" ")
            least.setdefault(limit, {})[name] = float(worst.values[0])
        return {type(limit): limit.extreme_value(least[limit.name]) for limit in limits}

    def better_than(self, other: Result) -> bool:
        """Tells whether this one is feasible and the other is not, or its objective is better, or it violates less."""
        if self.feasible != other.feasible:
            return self.feasible
        if not self.feasible:
            return sum(self.violations.values()) < sum(other.violations.values())
        if self.problem.step == 3:
            return self.objective < other.objective
        return self.objective > other.objective

    def record(self) -> dict[str, Any]:
        """Gathers the facts as plain data for JSON; what is infinite is None."""
        L_A, _, R, _, _, _, shift, cosine, _ = self.design_mm
        _, bound, gap, boxes, _ = (None,) * 5 if self.proof is None else self.proof
        turned = bool(outline_of(self.problem.requirements).room(R + L_A, shift, cosine)[1])
        return {
            "step": self.problem.step,
            "method": self.method,
            "objective": finite(self.objective),
            "objective_name": self.problem.objective_name,
            "variables": named(self.design_mm),
            **{
                limit.output_key: finite(self.worst(type(limit)) * limit.figures[0].scale)
                for limit in self.reported_limits
            },
            "proven_bound": bound,
            "gap": gap,
            "boxes": boxes,
            "status": self.status,
            "advice": self.advice,
            "feasible": self.feasible,
            "violations": dict(self.violations),
            "outline": "turned" if turned else "straight",
            "evaluations": self.evaluations,
            "starts": [
                {"converged": start.converged, "reason": start.reason, "exchanges": len(start.history)}
                for start in self.starts
            ],
        }


def finite(value: float) -> float | None:
    """Gives a number, or None where it is infinite or not a number, for which JSON has no sign."""
    return value if math.isfinite(value) else None
