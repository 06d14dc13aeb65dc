"""The front of cube size against the worst condition number: step 3 at one half side after another, each proved.

A smaller cube on the same bottom face lies inside a larger one, so what holds for a design with the larger cube holds
with the smaller, and its kappa is no worse: the front never falls. Each half side is started from its neighbours on
both sides, the coarse ones from several other places too; at the end the front is swept up and down once more.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Any

import numpy as np

from optimizer.globalopt.optimum import prove_optimum
from optimizer.paper.published import PublishedRun, published_runs
from optimizer.problem.extremes import design_worst
from optimizer.problem.requirements import Requirements
from optimizer.problem.step import SIDE, Problem, outline_of, step_problem
from optimizer.problem.variables import COSINE, PER_SI, VARIABLES, azimuth_deg
from optimizer.search import sqp
from optimizer.search.active_set import ROUNDING
from optimizer.search.result import Result, finite
from optimizer.synthesis.checkpoint import Checkpoint
from optimizer.synthesis.infeasible import InfeasibleError, explain
from optimizer.synthesis.three_step import remembered

_COARSE = 9  # half sides that are started cold as well, evenly spaced; between them lie what neighbours started
_COLD = 3  # cold starts of each; the neighbour is a fourth
POINTS_MIN = 4
# Smallest half side where the requirements bound none from below, as a part of the largest: less is no workspace.
_SMALLEST_SHARE = 0.25
_INTERVAL_MIN = 1e-4  # shortest piece that is halved, as a part of the range, whatever kappa does in it
_LARGER_ROUNDS = 5  # times that a larger cube found beyond the largest is followed; once has not been seen yet
_BETTER = 1e-9  # part by which a sweep must lower kappa to be believed: the polish of the worst points agrees to 1e-10
# Margins, without unit, and parts of a variable's range below which a constraint binds: the solver keeps 1e-8.
_ACTIVE = 1e-6
# Largest part by which the largest cube is cut where it does not hold between the points of the search's grid.
CUT = 0.05
_CUTS = 24  # halvings of that part: to 3e-9 of L
STARTS = "not improved"  # ending of a point that is a neighbour's design; a key of `result.ADVICE`
# Part of the largest half side: less is no range of sizes but one size; part of its upper bound: less is no cube.
_RANGE_MIN = 1e-3
# Larger by this part than the largest half side: there the contradicting constraints are searched.
_BEYOND = 0.01
_HEIGHT = VARIABLES.index("bottom_height")
_GAP = 1e-4  # gap at which each proof ends, as a share of the objective
# Boxes of designs for each proof: with three free variables 5,000 are usual, with more the gap stays as it then is.
BOXES = 12_000
# Tables of [RCIM2018]: step 2 by GA, step 3 by GA, step 2 by SQP, step 3 by SQP, step 3 by GA and GA+SQP.
TABLES = (7, 8, 10, 11, 12)


class FrontError(ValueError):
    """A front that cannot be posed."""


@dataclass(frozen=True)
class FrontPoint:
    """One design of the front.

    Attributes:
        result: Step 3 at its half side; it checks itself on a fine surface.
        active: What binds there: constraints, and variables at their bounds.
        bound: Proven: no design has a smaller worst kappa at this half side; None without a proof.
    """

    result: Result
    active: tuple[str, ...]
    bound: float | None = None

    @property
    def half_side(self) -> float:
        """L, mm."""
        return self.result.design_mm[SIDE]

    @property
    def kappa(self) -> float:
        """Worst condition number over the cube."""
        return self.result.max_kappa

    @property
    def torque(self) -> float:
        """Worst joint torque for the force, N m."""
        return self.result.max_torque

    @property
    def reach(self) -> float:
        """R + L_A of chain 0, mm."""
        return self.result.design_mm[0] + self.result.design_mm[2]

    @property
    def outline(self) -> tuple[float, float]:
        """The rectangle that the design takes, mm: eq. (1) with the hardware's overhead."""
        placed = self.result.design_mm[6:8]
        width, depth = outline_of(self.result.problem.requirements).size_mm(self.reach, *placed)
        return float(width), float(depth)


@dataclass(frozen=True)
class Curve:
    """A front.

    Attributes:
        given: The requirements that all its points meet.
        name: Short, unique among the curves of a trade.
        words: What sets it apart, in a sentence.
        points: Ascending in half side and in kappa; no one is dominated.
        largest: Largest half side, mm; NaN where nothing meets the requirements.
        beyond: Constraints that cannot be met together 1 % beyond it, or at all.
        finished: Whether it was traced to its end.
        largest_bound: Proven: no cube within the requirements has a larger half side, mm; None without
            a proof.
    """

    given: Requirements
    name: str
    words: str
    points: tuple[FrontPoint, ...]
    largest: float = math.nan
    beyond: tuple[str, ...] = ()
    finished: bool = True
    largest_bound: float | None = None


# Called after each point with the name of the curve, how many points it has, and the newest.
_PointReport = Callable[[str, int, FrontPoint | None], None]


@dataclass
class Tracer:
    """Traces one front.

    Attributes:
        given: The requirements; their `step_3.half_side_mm`, if any, becomes one of the half sides.
        count: Points wanted.
        seed: Seed of the cold starts.
        name: Name of the curve, and of its phases in the store.
        words: What sets the curve apart.
        report: Called after each point.
        stop: Called before each point; True ends with what there is.
        store: Keeps what was solved; None keeps nothing.
    """

    given: Requirements
    count: int = 50
    seed: int = 0
    name: str = "as required"
    words: str = "as required"
    report: _PointReport | None = None
    stop: Callable[[], bool] = bool
    store: Checkpoint | None = None
    _found: dict[float, Result] = field(default_factory=dict, init=False)

    def curve(self) -> Curve:
        """Traces it.

        Returns:
            The front; as far as it came if it was stopped.

        Raises:
            FrontError: Too few points, no range of half sides, or no design found.
            InfeasibleError: The constraints cannot be met together at any half side.
        """
        if self.count < POINTS_MIN:
            raise FrontError(f"{self.count} points are no front; at least {POINTS_MIN} are needed")
        top = self._largest()
        if top is None:
            return Curve(self.given, self.name, self.words, (), finished=False)
        high = top.design_mm[SIDE]
        low = self._smallest(high)
        finished = self._coarse(low, high, top.design_mm) and self._fine(low, high) and self._sweeps()
        points = tuple(FrontPoint(result, _active_constraints(result)) for result in self._front())
        if finished and not points:
            raise FrontError("no design holds between the points of the search's grid; give another --seed")
        beyond = self._beyond(high) if finished else ()
        return Curve(self.given, self.name, self.words, points, high, beyond, finished)

    def _largest(self) -> Result | None:
        """Finds the largest cube by step 2; None if stopped."""
        problem = step_problem(self.given, 2)
        kept = remembered(self.store, f"{self.name}/largest", lambda: self._search_largest(problem))
        return None if kept is None else Result(problem, "sqp", tuple(kept["design_mm"]), "converged")

    def _search_largest(self, problem: Problem) -> dict[str, Any] | None:
        if self.stop():
            return None
        starts = sqp.start_points(problem, self.seed)
        best = sqp.search(problem, starts).best
        if best is None:
            error = explain(self.given, problem, None, self.seed) or no_cube(self.given, self.seed)
            raise error or FrontError("no design found from the starts of this seed; give another --seed")
        tiny = problem.lengths_mm(best.x)[SIDE] < _RANGE_MIN * self.given.bounds_mm.half_side[1]
        if tiny and (error := no_cube(self.given, self.seed)) is not None:
            raise error  # a point alone holds
        for _ in range(_LARGER_ROUNDS):
            design = problem.lengths_mm(best.x)
            further = at_side(self.given, design[SIDE] * (1.0 + _BEYOND))
            if further.upper[SIDE] > problem.upper[SIDE]:
                break
            larger = sqp.search(further, np.concatenate([[further.scaled(design)], _cold(further, 0)])).best
            if larger is None:
                break
            start = problem.scaled(further.lengths_mm(larger.x))
            best = sqp.search(problem, start[None]).best or best
        result = _held(Result(problem, "sqp", problem.lengths_mm(best.x), "converged"))
        return {"design_mm": list(result.design_mm)}

    def _smallest(self, high: float) -> float:
        low, bound = self.given.bounds_mm.half_side
        if low == 0.0:
            low = _SMALLEST_SHARE * high
        if high - low < _RANGE_MIN * high:
            raise FrontError(
                f"bounds_mm.half_side = [{self.given.bounds_mm.half_side[0]:g}, {bound:g}] mm leaves no range "
                f"of sizes: {high:.6g} mm is the largest possible"
            )
        return low

    def _coarse(self, low: float, high: float, top: tuple[float, ...]) -> bool:
        """Solves evenly spaced half sides from the largest down, with cold starts; False if stopped."""
        sides = [float(side) for side in np.linspace(low, high, min(_COARSE, self.count))]
        wanted = self.given.step_3.half_side_mm
        if wanted is not None and low < wanted < high:
            sides[1 + int(np.argmin(np.abs(np.array(sides[1:-1]) - wanted)))] = wanted
        before = top
        for side in reversed(sides):
            if self.stop():
                return False
            self._solve(side, [before], cold=True)
            before = self._found[side].design_mm
        return True

    def _fine(self, low: float, high: float) -> bool:
        """Halves the longest piece until there are as many points as wanted; False if stopped."""
        while len(self._found) < self.count:
            if self.stop():
                return False
            sides = sorted(self._found)
            quality = np.array([1.0 / self._found[side].max_kappa for side in sides])
            scale = max(float(quality.max() - quality.min()), np.finfo(float).tiny)
            across = np.diff(sides) / (high - low)
            length = np.where(across > _INTERVAL_MIN, np.hypot(across, np.diff(quality) / scale), 0.0)
            k = int(np.argmax(length))
            if length[k] == 0.0:
                break
            near = [self._found[sides[k + 1]].design_mm, self._found[sides[k]].design_mm]
            self._solve((sides[k] + sides[k + 1]) / 2.0, near)
        return True

    def _sweeps(self) -> bool:
        """Sweeps the front up and down, each point started from the one before; False if stopped."""
        sides = sorted(self._found)
        for name, order in (("up", sides), ("down", sides[::-1])):
            for before, side in pairwise(order):
                if self.stop():
                    return False
                self._solve(side, [self._found[before].design_mm], phase=name)
        return True

    def _solve(self, side: float, near: list[tuple[float, ...]], cold: bool = False, phase: str = "point") -> None:
        """Solves step 3 at one half side from designs near it, and keeps the better of the old and the new design."""
        problem = at_side(self.given, side)
        kept = remembered(self.store, f"{self.name}/{phase}/{side!r}", lambda: self._descend(problem, near, cold))
        result = Result(problem, "sqp", tuple(kept["design_mm"]), kept["status"], kept["evaluations"])
        known = self._found.get(side)
        if known is None or (result.feasible and result.max_kappa < known.max_kappa * (1.0 - _BETTER)):
            self._found[side] = result
        if self.report is not None and known is None:
            self.report(self.name, len(self._found), FrontPoint(self._found[side], ()))

    def _descend(self, problem: Problem, near: list[tuple[float, ...]], cold: bool) -> dict[str, Any]:
        starts = [problem.scaled(design) for design in near]
        outcome = sqp.search(problem, np.array(starts + list(_cold(problem, self.seed) if cold else [])))
        best = outcome.best
        # the first neighbour is larger, or the point is swept: its design holds here too and sets the least to reach
        own = Result(problem, "sqp", problem.lengths_mm(starts[0]), STARTS)
        chosen = own
        if best is not None:
            result = Result(problem, "sqp", problem.lengths_mm(best.x), "converged")
            chosen = result if result.feasible and not (own.feasible and own.max_kappa < result.max_kappa) else own
        return {"design_mm": list(chosen.design_mm), "status": chosen.status, "evaluations": outcome.evaluations}

    def _front(self) -> list[Result]:
        """Selects the feasible results that no other one dominates, ascending."""
        kept: list[Result] = []
        least = math.inf
        for side in sorted(self._found, reverse=True):
            result = self._found[side]
            if result.feasible and result.max_kappa < least:
                kept.append(result)
                least = result.max_kappa
        return kept[::-1]

    def _beyond(self, high: float) -> tuple[str, ...]:
        """Names the constraints that cannot be met together a little beyond the largest half side."""
        conflict = lambda: {"words": list(beyond(self.given, high, self.seed))}  # noqa: E731
        return tuple(remembered(self.store, f"{self.name}/beyond", conflict)["words"])


def _active_constraints(result: Result) -> tuple[str, ...]:
    """Names the constraints whose worst margin is used up, then free variables at a bound as `base_radius >= 30 mm`."""
    problem, design = result.problem, np.array(result.design_mm)
    row = design[None] / PER_SI
    lowest = {n: float(w.values[0]) for n, w in design_worst(problem, row[0], sqp.EXCHANGE_GRID).items()}
    lowest |= {name: float(value[0]) for name, value in problem.design_margins(row).items()}
    active = [name for name in problem.constraints if lowest.get(name, math.inf) <= _ACTIVE]
    for k in problem.free_index:
        low, high = problem.lower[k], problem.upper[k]
        if design[k] - low <= _ACTIVE * (high - low):
            active.append(_bound(k, ">=", low))
        if high - design[k] <= _ACTIVE * (high - low):
            active.append(_bound(k, "<=", high))
    return tuple(active)


def _bound(k: int, sign: str, value: float) -> str:
    """Writes a bound of a variable; of the cosine as that of the azimuth, which falls where the cosine rises."""
    if k == COSINE:
        return f"azimuth {'<=' if sign == '>=' else '>='} {azimuth_deg(value):g} deg"
    return f"{VARIABLES[k]} {sign} {value:g} mm"


def _held(result: Result) -> Result:
    """Shrinks the cube of a design of step 2 about its centre until the design holds on the fine surface, too.

    The search looks for worst points on a coarser grid than the result checks itself on, and can miss one.
    """
    if result.feasible:
        return result
    bottom, side = result.design_mm[_HEIGHT], result.design_mm[SIDE]
    ceiling = result.problem.upper[_HEIGHT]
    low, high, held = 0.0, CUT * side, result
    for _ in range(_CUTS):
        cut = high if held is result else (low + high) / 2.0
        trial = replace(result, design_mm=_with_cube(result, min(ceiling, bottom + cut), side - cut))
        if trial.feasible:
            high, held = cut, trial
        elif held is result:
            break
        else:
            low = cut
    return held


def _with_cube(result: Result, bottom: float, side: float) -> tuple[float, ...]:
    design = list(result.design_mm)
    design[_HEIGHT], design[SIDE] = bottom, side
    return tuple(design)


def _cold(problem: Problem, seed: int) -> np.ndarray:
    return sqp.start_points(problem, seed, _COLD)


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
    problems = [("largest", step_problem(curve.given, 2), curve.points[-1].result)]
    problems += [(repr(point.half_side), point.result.problem, point.result) for point in curve.points]
    bounds: list[float | None] = []
    for key, problem, result in problems:

        def solve(problem: Problem = problem, known: tuple[float, ...] = result.design_mm) -> dict[str, Any] | None:
            found = prove_optimum(problem, gap=_GAP, max_boxes=BOXES, incumbent_mm=known, seconds=seconds, stop=stop)
            # as far as a stopped proof came is no fact to keep; without an incumbent nothing stands beside the bound
            return None if stop() else {"bound": finite(found.bound) if found.design_mm else None}

        kept = None if stop() else remembered(store, f"{curve.name}/proof/{key}/{seconds!r}", solve)
        bounds.append(None if kept is None else kept["bound"])
        if report is not None:
            report(len(bounds), len(problems))
    points = tuple(replace(point, bound=bound) for point, bound in zip(curve.points, bounds[1:], strict=True))
    return replace(curve, points=points, largest_bound=bounds[0])


@dataclass(frozen=True, kw_only=True)
class PublishedDesign(FrontPoint):
    """One published design, recomputed; `active` holds the constraints and bounds that it does not meet.

    Attributes:
        run: As it is printed.
    """

    run: PublishedRun


def published_designs(given: Requirements) -> list[PublishedDesign]:
    """Recomputes the designs of `TABLES` that have a result, with the force of requirements that they may miss."""
    designs = []
    for run in published_runs(TABLES):
        if run.result is not None:
            result = Result(at_side(given, run.result[SIDE]), "published", run.result, "converged")
            designs.append(PublishedDesign(result=result, active=misses(given, result), run=run))
    return designs


def misses(given: Requirements, result: Result) -> tuple[str, ...]:
    """Names what of the requirements a design does not meet: constraints by name, then bounds with the value."""
    named = [name for name, value in result.violations.items() if value > ROUNDING and name != "half_side"]
    for name, value, (low, high) in zip(VARIABLES, result.design_mm, given.ranges, strict=True):
        if not low <= value <= high:
            named.append(f"azimuth {azimuth_deg(value):g} deg" if name == "side_cosine" else f"{name} {value:g} mm")
    return tuple(named)


def at_side(given: Requirements, side: float) -> Problem:
    """Poses step 3 at a half side in mm, whatever `bounds_mm.half_side` says."""
    step_3 = given.step_3.model_copy(update={"half_side_mm": side})
    return step_problem(given.model_copy(update={"step_3": step_3}), 3)


def beyond(given: Requirements, largest: float, seed: int) -> tuple[str, ...]:
    """Finds the smallest set of constraints that cannot be met together 1 % beyond the largest half side.

    Returns:
        The constraints, described; none where the searches found a larger cube feasible.
    """
    problem, bound = at_side(given, largest * (1.0 + _BEYOND)), given.bounds_mm.half_side[1]
    if problem.upper[SIDE] > bound:
        return (f"half side <= {bound:g} mm (bounds_mm.half_side)",)
    return described_conflict(problem, explain(problem.requirements, problem, None, seed))


def no_cube(given: Requirements, seed: int) -> InfeasibleError | None:
    """Finds what contradicts every cube that has a size, where only one without is left: kappa of 1 holds in a point.

    Returns:
        The contradiction with a half side of `_RANGE_MIN` of its upper bound; None where that can be met.
    """
    problem = at_side(given, _RANGE_MIN * given.bounds_mm.half_side[1])
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
