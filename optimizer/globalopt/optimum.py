"""The proven optimum of a step: an incumbent certified over its whole cube, and a bound that no design can beat.

Feasibility over a cube is monotone in its half side, for cubes on the same bottom face are nested. So "no design has
more than L" is "no design is feasible at L", and "none has a smaller worst kappa than K" is "none is feasible with the
limit K": either way boxes of (L_A, L_B, R - r, H) are excluded one by one. The requested gap is tried at once; a
proof that is too hard for that comes closer to the incumbent in decades. README (1)-(12) of this package.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from time import monotonic
from typing import Any, Literal, NamedTuple

import numpy as np

from delta_cad.common.units import MM_PER_M
from optimizer.globalopt.branch_and_bound import DONE, POINTS, QUESTION, search
from optimizer.globalopt.cutting_points import numbers
from optimizer.globalopt.design_box import design_box, design_of
from optimizer.globalopt.incumbent import BOXES as CERTIFYING
from optimizer.globalopt.incumbent import QUICK, Certified, certified, uncertified
from optimizer.globalopt.placed_box import placed_boxes, placed_design
from optimizer.globalopt.placed_cuts import search_placed
from optimizer.problem.evaluator import half_surface
from optimizer.problem.extremes import design_worst
from optimizer.problem.step import SIDE, Problem, ProblemError
from optimizer.problem.variables import PER_SI, completed
from optimizer.search import sqp
from optimizer.search.active_set import ROUNDING
from optimizer.search.sqp import EXCHANGE_GRID, Search

GAP = 1e-5
BOXES = 2_000_000
CHUNK = 2_000  # boxes between two looks at `stop`, some 50 ms
_STACK = 4_096  # boxes that wait; depth first they are at most the halvings of all edges, a few hundred
MOST = POINTS  # cutting points at once; a further one takes the place of the least useful
_FIRST_GRID = 3  # points along an edge of the cube's surface that are cutting points from the start
# Boxes, some 10 s, in which the requested gap is tried at once: a quarter of the boxes of the way by decades.
_DIRECT = 200_000
_FIRST_GAP = 0.1
_DECADE = 10.0
STARTS = 3  # starts of SQP; what they miss, the search finds
# Designs in a row that look feasible on samples but are no better once proved; from then on none is tried, for a try
# takes some seconds. Only a step whose feasible designs are sharp, without room for a proof, comes to that.
_VAIN = 8
_IDLE = (
    500  # questions in a row that gave neither a cutting point nor a better design; from then on none is looked into
)
# Boxes of designs where kappa of the design of the step before cannot be proved: near a fold little can be excluded.
STEEP_BOXES = 100_000
_NEAR = 1e-7  # share of L within which two of them are the same
# Decimals of what SQP and the searches over the cube hand to the proof: a length in mm, a point in units of L. Their
# last digits may differ from process to process, and with them, unrounded, the boxes that a proof takes.
_SETTLED = 9

_Status = Literal["proved", "gap not reached", "infeasible", "undecided", "interrupted"]
_Ending = Literal["excluded", "better", "open", "budget", "time", "stopped"]


class Now(NamedTuple):
    """The state of a proof.

    Attributes:
        boxes: Examined so far.
        best: Certified objective so far; NaN before there is one.
        bound: What is proved that no design beats.
        design_mm: (9,) the certified design, mm; before there is one the best that SQP found; else empty.
        certifying: Boxes of the cube of a design that is being certified; 0 while designs are excluded.
    """

    boxes: int
    best: float
    bound: float
    design_mm: tuple[float, ...] = ()
    certifying: int = 0


@dataclass(frozen=True)
class Proven:
    """What was proved of a step.

    Attributes:
        objective: Certified objective of the incumbent: half side, mm, or a condition number that its cube nowhere
            exceeds; NaN without one.
        bound: No design within the bounds that meets the constraints is better: mm, or a condition number; NaN where
            none is feasible.
        gap: |objective - bound| / objective; NaN without an incumbent.
        design_mm: (9) the incumbent, in the order of `VARIABLES`, mm; empty without one.
        boxes: Boxes of designs examined.
        status: "proved": the gap is at most the requested one; "gap not reached": it is not, with all boxes or all the
            time; "infeasible": no design is feasible, proved; "undecided": neither was one found nor proved absent;
            "interrupted": stopped by hand.
        cutting_points: Points of the cube that were in use.
        certified: Whether the objective is proved; else its constraints alone are, and the condition number is sampled.
        late: Whether the time was over before that.
    """

    objective: float
    bound: float
    gap: float
    design_mm: tuple[float, ...]
    boxes: int
    status: _Status
    cutting_points: int = 0
    certified: bool = True
    late: bool = False


def prove_optimum(
    problem: Problem,
    *,
    gap: float = GAP,
    max_boxes: int = BOXES,
    incumbent_mm: tuple[float, ...] | np.ndarray | None = None,
    before_mm: tuple[float, ...] | np.ndarray | None = None,
    seed: int = 0,
    seconds: float = math.inf,
    report: Callable[[Now], None] | None = None,
    stop: Callable[[], bool] = bool,
) -> Proven:
    """Finds the optimum of a step and proves how far it can be from the best there is.

    Args:
        problem: The step.
        gap: Relative two-sided gap that is requested.
        max_boxes: Boxes of designs after which the proof ends with the gap that it reached.
        incumbent_mm: (9,) a design to start from, in the order of `VARIABLES`, mm; need not be feasible.
        before_mm: (9,) what the step before found, if it is feasible: the incumbent of step 3 where nothing better can
            be proved, even if its condition number is only sampled.
        seed: Seed of the starts of SQP.
        seconds: Time after which the proof ends with the gap that it reached; with a bound on it, what comes out
            depends on the machine.
        report: Called with the state of the proof, each `CHUNK` boxes, and while a design is certified.
        stop: Called as often; True ends it with what stands.

    Raises:
        ProblemError: The gap is not positive, or reach is left out: no other constraint means anything without it.
    """
    if not 0.0 < gap < math.inf:
        raise ProblemError(f"gap is {gap!r}; it must be > 0 and finite")
    if "reach" not in problem.constraints:
        raise ProblemError("a proof needs the reach of the cube among the constraints")
    return _Proof(problem, gap, max_boxes, seed, monotonic() + seconds, report, stop).run(incumbent_mm, before_mm)


def none_feasible(problem: Problem, max_boxes: int = BOXES, stop: Callable[[], bool] = bool) -> bool:
    """Tries to prove that no design within the bounds of a step is feasible; nothing is sought, and none certified.

    Args:
        problem: The step; as a cube that is feasible contains every smaller one on its bottom, its least half side
            is the one that is looked at.
        max_boxes: Boxes of designs after which it ends.
        stop: Called each `CHUNK` boxes; True ends it.

    Returns:
        Whether that is proved; else nothing is known.
    """
    proof = _Proof(problem, GAP, max_boxes, 0, math.inf, None, stop)
    proof.ends_at_one = True
    return proof._exclude(None) == "excluded"


class _Space(NamedTuple):
    """A box in which designs are searched.

    Attributes:
        box: (2, n) lower and upper ends of its n variables.
        search: Compiled, as `branch_and_bound.search`.
        cube_limits: Half side, m -> numbers of the closed forms.
        design: (n,) a point of it, and a half side in mm -> (9,) mm.
    """

    box: np.ndarray
    search: Any
    cube_limits: Callable[[float], np.ndarray]
    design: Callable[[np.ndarray, float], np.ndarray]


def _spaces(problem: Problem) -> list[_Space]:
    """Lists the boxes that hold all designs of a problem."""
    if problem.symmetric:
        space = design_box(problem)
        if space is None:
            return []
        return [_Space(space.box, search, space.cube_limits, partial(design_of, problem, space))]
    return [
        _Space(one.box, search_placed, one.cube_limits, partial(placed_design, problem, one))
        for one in placed_boxes(problem)
    ]


class _Proof:
    """One proof under way."""

    def __init__(
        self,
        problem: Problem,
        gap: float,
        max_boxes: int,
        seed: int,
        deadline: float,
        report: Callable[[Now], None] | None,
        stop: Callable[[], bool],
    ) -> None:
        self.problem, self.gap, self.max_boxes, self.seed = problem, gap, max_boxes, seed
        self.deadline, self.report, self.stop = deadline, report, stop
        self.spaces = _spaces(problem)
        self.best: Certified | None = None
        self.found: tuple[float, ...] = ()  # what SQP found, before anything is certified
        # before anything is proved: no cube is larger than its bound, no condition number smaller than 1
        self.bound = 1.0 if problem.step == 3 else problem.upper[SIDE]
        self.boxes = 0
        self.units = np.zeros((POINTS, 3))
        first = half_surface(_FIRST_GRID)
        self.units[: len(first)] = first
        self.count, self.fixed = len(first), len(first)
        self.hits = np.zeros(POINTS, dtype=np.int64)
        self.vain = self.idle = 0
        self.certifying, self.certified, self.late = CERTIFYING, True, False
        self.ends_at_one = False  # where it is enough to know that a design looks feasible

    def run(
        self, incumbent_mm: tuple[float, ...] | np.ndarray | None, before_mm: tuple[float, ...] | np.ndarray | None
    ) -> Proven:
        if not self.spaces:
            return self._outcome("infeasible")
        self._tell()
        if before_mm is not None and self.problem.step == 3:
            self._fall_back(np.asarray(before_mm, dtype=float))
        self._first(incumbent_mm)
        if self.best is None:
            ending = self._exclude(None)
            if self.best is None:
                names: dict[_Ending, _Status] = {"excluded": "infeasible", "stopped": "interrupted"}
                return self._outcome(names.get(ending, "undecided"))
        share, most = self.gap, self.max_boxes
        self.max_boxes = min(most, self.boxes + (_DIRECT if self.problem.symmetric else 0))
        while self._gap() > self.gap:
            ending = self._exclude(share * (1.0 - 1e-9))  # so that the quotient is not above it
            if ending == "stopped":
                return self._outcome("interrupted")
            if ending == "budget" and self.max_boxes < most:  # a hard one: what is proved on the way counts, too
                share, self.max_boxes = max(_FIRST_GAP, self.gap), most
                continue
            if ending == "excluded":
                if share == self.gap:
                    break
                share = max(share / _DECADE, self.gap)
            elif ending != "better":
                break
        return self._outcome("proved" if self._gap() <= self.gap else "gap not reached")

    def _outcome(self, status: _Status) -> Proven:
        bound = math.nan if status == "infeasible" else self.bound
        objective, design = self._objective(), self.best.design_mm if self.best else ()
        gap = self._gap() if self.best else math.nan
        if status == "proved" and not self.certified:
            status = "gap not reached"  # the objective is only sampled
        return Proven(objective, bound, gap, design, self.boxes, status, self.count, self.certified, self.late)

    def _gap(self) -> float:
        if self.best is None:
            return math.nan
        distance = abs(self.best.objective - self.bound)
        if distance == 0.0:
            return 0.0
        return distance / self.best.objective if self.best.objective > 0.0 else math.inf

    def _objective(self) -> float:
        return self.best.objective if self.best else math.nan

    def _watch(self, boxes: int, _share: float) -> bool:
        """Reports progress of certifying a design; true ends it."""
        self._tell(boxes)
        return self._ends()

    def _tell(self, certifying: int = 0) -> None:
        if self.report is not None:
            design = self.best.design_mm if self.best else self.found
            self.report(Now(self.boxes, self._objective(), self.bound, design, certifying))

    def _ends(self) -> bool:
        self.late = monotonic() > self.deadline
        return self.stop() or self.late

    def _certified(self, design_mm: np.ndarray) -> Certified | None:
        return certified(self.problem, design_mm, self.certifying, self._watch)

    def _better(self, one: Certified) -> bool:
        if self.best is None:
            return True
        less = one.objective < self.best.objective
        return less if self.problem.step == 3 else one.objective > self.best.objective

    def _first(self, incumbent_mm: tuple[float, ...] | np.ndarray | None) -> None:
        """Finds an incumbent by SQP."""
        if incumbent_mm is not None:
            self._take(np.asarray(incumbent_mm, dtype=float))
            if self.best is not None:
                return
        for start in sqp.start_points(self.problem, self.seed, STARTS):
            if self._ends():
                return
            self._descend(start)

    def _fall_back(self, design_mm: np.ndarray) -> None:
        """Takes the design of the step before, with less effort where its kappa is too steep to be proved."""
        design = self._settled(design_mm)
        incumbent = proved = certified(self.problem, design, QUICK, self._watch)
        if incumbent is None:
            self.certifying, self.max_boxes = QUICK, min(self.max_boxes, STEEP_BOXES)
            incumbent = uncertified(self.problem, design, self._watch)
        if incumbent is not None:
            self._keep(incumbent, proved is not None)

    def _settled(self, design_mm: np.ndarray) -> np.ndarray:
        """Rounds away the last digits of a design's lengths, mm, within the bounds."""
        design_mm = completed(design_mm)
        settled, unit = np.round(design_mm, _SETTLED), 10.0**-_SETTLED
        # down, lest the bound be farther from what was found than the gap; what lies on a round number stays there
        settled[SIDE] = math.floor(design_mm[SIDE] / unit + 0.01) * unit
        return np.clip(settled, self.problem.lower, self.problem.upper)

    def _take(self, design_mm: np.ndarray) -> None:
        """Certifies a design and keeps it if it is the best; then SQP goes on from it."""
        incumbent = self._certified(self._settled(design_mm))
        if incumbent is not None and self._better(incumbent):
            self._keep(incumbent)
        self._descend(self.problem.scaled(design_mm))

    def _descend(self, x: np.ndarray) -> None:
        ending = sqp.descend(self.problem, x, Search())
        if not ending.converged:
            return
        design = self._settled(np.array(self.problem.lengths_mm(ending.x)))
        if self.best is not None and self.problem.step != 3 and design[SIDE] <= self.best.objective:
            return
        if not self.found:
            self.found = tuple(float(v) for v in design)
            self._tell()
        incumbent = self._certified(design)
        if incumbent is not None and self._better(incumbent):
            self._keep(incumbent)

    def _keep(self, incumbent: Certified, proved: bool = True) -> None:
        self.best, self.certified = incumbent, proved
        worst = design_worst(self.problem, np.array(incumbent.design_mm) / PER_SI, EXCHANGE_GRID)
        for w in worst.values():
            for point in w.points:
                self._cut_at(point)
        self._tell()

    def _cut_at(self, point: np.ndarray) -> int | None:
        """Takes a point of the cube in, in the place of the least useful if need be; None if it is known."""
        point, known = np.round(point, _SETTLED), self.units[: self.count]
        if (np.abs(known - point).max(axis=1) < _NEAR).any():
            return None
        if self.count < MOST:
            k = self.count
            self.count += 1
        else:
            k = self.fixed + int(np.argmin(self.hits[self.fixed : self.count]))
        self.units[k] = point
        self.hits[k] = int(self.hits[: self.count].max(initial=0)) // 2  # tried early, until it shows its worth
        return k

    def _exclude(self, share: float | None) -> _Ending:
        """Tries to exclude every design that is better than the incumbent by a share, or that is feasible at all."""
        step, best = self.problem.step, self.best
        side_mm, kappa, proves = self.problem.lower[SIDE], math.inf, math.nan
        if best is not None and share is not None:
            if step == 3:
                kappa = best.objective * (1.0 - share)
                proves = kappa
            else:
                side_mm = best.objective * (1.0 + share)
                if side_mm >= self.problem.upper[SIDE]:  # no cube may be larger than its bound anyway
                    return "excluded"
                proves = math.nextafter(side_mm, math.inf)
            if kappa <= self.bound if step == 3 else proves >= self.bound:  # that much is known
                return "excluded"
        ending: _Ending = "excluded"
        for space in self.spaces:
            ending = self._branch(space, side_mm / MM_PER_M, kappa)
            if ending != "excluded":
                break
        if ending == "excluded" and share is not None:
            self.bound = proves
            self._tell()
        return ending

    def _branch(self, space: _Space, side: float, kappa: float) -> _Ending:
        variables = space.box.shape[1]
        boxes, masks = np.empty((_STACK, 2, variables)), np.ones((_STACK, POINTS), dtype=np.uint8)
        flags, state = np.zeros(_STACK, dtype=np.uint8), np.array([1, 0], dtype=np.int64)
        boxes[0] = space.box
        thresholds, candidate = numbers(self.problem.pose_limits(kappa)), np.empty(variables)
        cube_limits = space.cube_limits(side)
        begun = self.boxes
        opened = False
        while state[0] > 0:
            if self._ends():  # also before a search begun anew, where one better design follows the other
                return "stopped" if self.stop() else "time"
            budget = min(CHUNK - self.boxes % CHUNK, self.max_boxes - self.boxes)
            if budget <= 0:
                return "budget"
            points = self._points(side), self.count, self.hits
            ended = space.search(boxes, masks, flags, state, *points, thresholds, cube_limits, candidate, budget)
            self.boxes = begun + int(state[1])
            top = int(state[0]) - 1
            if ended == QUESTION:
                flags[top] = 1
                if self.idle < _IDLE:
                    answer = self._answer(space, candidate, side, kappa, masks, top + 1)
                    if answer == "better":
                        return "better"
                    self.idle = self.idle + 1 if answer == "known" else 0
                    flags[top] = answer == "known"
            elif ended != DONE:
                opened = True
                state[0] -= 1
            if self.boxes % CHUNK == 0:
                self._tell()
        return "open" if opened else "excluded"

    def _points(self, side: float) -> np.ndarray:
        """Computes the cutting points in metres; |unit| <= 1, so that each lies in the cube also after rounding."""
        points = self.units * side
        points[:, 2] = (1.0 + self.units[:, 2]) * side
        return points

    def _answer(
        self, space: _Space, candidate: np.ndarray, side: float, kappa: float, masks: np.ndarray, waiting: int
    ) -> Literal["refused", "better", "known"]:
        """Searches the whole cube of a design that all cutting points allow."""
        design = space.design(candidate, side * MM_PER_M)
        worst = design_worst(self.problem, design / PER_SI, EXCHANGE_GRID)
        quality = worst.pop("quality", None)
        points = [p for w in worst.values() for p, v in zip(w.points, w.values, strict=True) if v < 0.0]
        if quality is not None and kappa < math.inf:
            pairs = zip(quality.points, quality.values, strict=True)
            points += [p for p, v in pairs if v < 1.0 / kappa]
        new = [k for k in (self._cut_at(p) for p in points) if k is not None]
        for k in new:
            masks[:waiting, k] = 1
        if new:
            return "refused"
        margins = self.problem.design_margins(design[None] / PER_SI)
        if points or min((float(margin[0]) for margin in margins.values()), default=0.0) < -ROUNDING:
            return "known"
        if self.ends_at_one:
            return "better"
        if self.vain >= _VAIN:
            return "known"
        before = self._objective()
        self._take(design)
        self.vain += 1
        if self.best is None:
            return "known"
        target = kappa if self.problem.step == 3 else side * MM_PER_M
        # at least half of what was aimed at, or the search would begin anew for ever smaller steps
        won = math.isnan(before) or abs(self.best.objective - before) >= 0.5 * abs(target - before)
        if not won:
            return "known"
        self.vain = 0
        return "better"
