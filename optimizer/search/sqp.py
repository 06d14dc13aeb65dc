"""SciPy's SLSQP on the active points, with exchange: solve, look for points that are worse, add them, solve again."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np
from scipy.optimize import minimize
from scipy.stats import qmc
from threadpoolctl import threadpool_limits

from optimizer.problem.evaluator import fold_points, shared_points
from optimizer.problem.extremes import Worst, design_worst
from optimizer.problem.step import Problem
from optimizer.search.active_set import ROUNDING, SLACK, Active, Program

EXCHANGE_GRID = 17  # points along an edge where worse points are looked for, before they are polished
CONFIRMING_GRID = 41  # the same before an ending is believed; a result checks itself on this grid
_START_GRID = 5
_ROUNDS = 15  # exchanges; 3 to 8 are usual
# By kind of program. Towards feasibility 2 to 15 are usual; where there is none each costs a line search at a kink.
_ITERATIONS = {"feasibility": 25, "half_side": 60, "quality": 60}
_PRECISION = 1e-12  # SLSQP ends at this change of the scaled objective, a millionth of a micrometre
# Part of the level given up before each exchange: from a point that is 1e-8 outside SLSQP finds no descent of its
# merit.
_STEP_BACK = 1e-3
# Share of a level of feasibility by which an exchange has to change it, and in how many in a row it may not: once it
# was found after one that did not.
_CHANGED, _STAGNANT = 1e-3, 2
_STUCK = 8  # exit mode of SLSQP: its line search finds nothing better
_FALLS = 3  # returns to a design that held, before that one is taken
_SAMPLES = 128
STARTS = 6
# Exit modes of SLSQP.
_SLSQP_ENDS = {
    0: "converged",
    3: "a subproblem took too many iterations",
    4: "its linear constraints contradict each other",
    5: "a subproblem is singular",
    6: "a subproblem is singular",
    7: "a subproblem is singular",
    8: "no direction downhill is left",
    9: "the iteration limit was reached",
}


class Ending(NamedTuple):
    """How one start ended.

    Attributes:
        start: (free variables) scaled, where it began.
        x: (free variables) scaled, where it ended.
        level: Largest objective reached: L scaled, 1 / kappa, or the feasibility level.
        converged: Whether every constraint holds there on the polished surface.
        reason: One line: how it ended.
        history: Level after every exchange.
    """

    start: tuple[float, ...]
    x: tuple[float, ...]
    level: float
    converged: bool
    reason: str
    history: tuple[float, ...]


@dataclass
class Search:
    """What the starts of one problem came to.

    Attributes:
        endings: One for each start, in their order.
        evaluations: Designs evaluated at the active points.
        trail: After each exchange towards the objective: designs evaluated so far, and the level of a design that meets
            every constraint on the polished surface, NaN of another.
    """

    endings: list[Ending] = field(default_factory=list)
    evaluations: int = 0
    trail: list[tuple[int, float]] = field(default_factory=list)
    _looked_at: tuple[Problem, bytes, int, dict[str, Worst]] | None = field(
        default=None, init=False, repr=False, compare=False
    )

    def worst(self, problem: Problem, x: np.ndarray, n: int) -> dict[str, Worst]:
        """Finds the worst points of a design; those of the last one again without a search.

        A program begins where the one before it ended, and ends where it began if nothing better is near.

        Args:
            problem: The step.
            x: (free variables) scaled.
            n: Grid points along an edge.

        Returns:
            Name -> its worst points, `quality` among them where the step asks for it.
        """
        last = self._looked_at
        if last is None or last[0] is not problem or last[1:3] != (x.tobytes(), n):
            last = self._looked_at = (problem, x.tobytes(), n, design_worst(problem, problem.designs(x[None])[0], n))
        return last[3]

    @property
    def best(self) -> Ending | None:
        """The best start that converged, the first of equals; None if none did."""
        good = [ending for ending in self.endings if ending.converged]
        return max(good, key=lambda ending: ending.level) if good else None


# Called after each start with its number, how many there are, and the best level so far.
Report = Callable[[int, int, float], None]


def search(
    problem: Problem, starts: np.ndarray, report: Report | None = None, stop: Callable[[], bool] = bool
) -> Search:
    """Runs every start to its end.

    Args:
        problem: The step.
        starts: (S, free variables) scaled.
        report: Called after each start.
        stop: Called after each start; True leaves out the others.
    """
    outcome = Search()
    for k, start in enumerate(starts):
        outcome.endings.append(descend(problem, start, outcome))
        if report is not None:
            report(k + 1, len(starts), outcome.best.level if outcome.best else -np.inf)
        if stop():
            break
    return outcome


def descend(problem: Problem, start: np.ndarray, count: Search) -> Ending:
    """Follows one start: towards feasibility if it is not feasible, then to the optimum.

    Args:
        problem: The step.
        start: (free variables) scaled.
        count: Its `evaluations` are added to.
    """
    ready = exchange(problem, "feasibility", start, count)
    if ready.level < -SLACK:
        reason = f"no feasible design near this start: the worst margin stays at {ready.level:.3g} ({ready.reason})"
        return ready._replace(converged=False, reason=reason)
    kind = "quality" if problem.step == 3 else "half_side"
    return exchange(problem, kind, np.array(ready.x), count)._replace(start=ready.start)


@threadpool_limits.wrap(limits=1)  # with more, the last digits depend on how the threads share the sums
def exchange(problem: Problem, kind: str, start: np.ndarray, count: Search) -> Ending:
    """Solves over the active points and adds what is worse elsewhere until nothing is.

    Args:
        problem: The step.
        kind: Kind of the program: `half_side`, `quality` or `feasibility`.
        start: (free variables) scaled.
        count: Its `evaluations` are added to.

    Returns:
        How it ended; `converged` says whether all that the program asks holds on the whole surface.
    """
    program, x = Program(problem, kind), np.asarray(start, dtype=float)
    worst = _worst(program, x, count)
    program.add([Active(name, _key(p)) for name, w in worst.items() for p in w.points])
    level, history = _own_level(program, x, worst), []
    if kind == "feasibility" and level >= 0.0:
        return Ending(_plain(start), _plain(x), level, True, "feasible from the start", (level,))
    reason, wanted, falls, again = "nothing to vary: every variable's bounds are equal", level, 0, False
    before, stagnant = np.inf, 0  # level of feasibility of the exchange before, and how many in a row changed it little
    inside = (x, level, worst) if violation(problem, x, worst) <= ROUNDING else None  # the best design that held
    for _ in range(_ROUNDS):
        stuck = False
        if len(x):
            unknowns = np.append(x, level) if program.has_level else x.copy()
            if program.level_index is not None:
                # a smaller cube, a lower level: inside, where the line search can start
                unknowns[program.level_index] = max(unknowns[program.level_index] - _STEP_BACK, program.level_min)
            answer = minimize(
                program.objective,
                unknowns,
                jac=True,
                method="SLSQP",
                bounds=program.bounds(),
                constraints={"type": "ineq", "fun": program.constraints, "jac": program.jacobian},
                options={"maxiter": _ITERATIONS[kind], "ftol": _PRECISION},
            )
            x = np.clip(answer.x[: len(x)], 0.0, 1.0)
            wanted = float(answer.x[-1])
            reason = _SLSQP_ENDS.get(int(answer.status), str(answer.message))
            stuck = answer.status == _STUCK and answer.nfev == 1
        worst = _worst(program, x, count)
        new = program.add(_violated(program, worst, wanted))
        if not new and kind != "feasibility":  # a narrow peak may stand between the points
            worst = _worst(program, x, count, CONFIRMING_GRID)
            new = program.add(_violated(program, worst, wanted))
        level = _own_level(program, x, worst)
        history.append(level)
        held = violation(problem, x, worst) <= ROUNDING
        if kind != "feasibility":
            count.trail.append((count.evaluations + program.evaluations, level if held else np.nan))
        if not len(x):
            break
        if kind == "feasibility" and wanted < -SLACK:
            stagnant = stagnant + 1 if abs(wanted - before) <= _CHANGED * abs(wanted) else 0
            if stagnant == _STAGNANT:
                break
            before = wanted
        if held and (inside is None or level >= inside[1]):
            inside = (x, level, worst)
        elif stuck and new and kind != "feasibility" and inside:  # far outside no line search finds back
            falls += 1
            x, level, worst = inside  # with the new points
            if falls > _FALLS:
                break
        if not new:
            # SLSQP may have stopped short of rows that it knows: once more, from inside
            if again or held or kind == "feasibility":
                break
            again = True
    else:
        reason = f"after {_ROUNDS} exchanges there still are worse points"
    count.evaluations += program.evaluations
    if kind != "feasibility":
        if inside and violation(problem, x, worst) > ROUNDING:
            x, level, worst = inside
            reason = f"the best design that held: {reason}"
        worst = _worst(program, x, count, CONFIRMING_GRID)
    short = violation(problem, x, worst)
    if short > ROUNDING:
        reason = f"ended {short:.3g} short of the constraints: {reason}"
    return Ending(_plain(start), _plain(x), level, short <= ROUNDING, reason, tuple(history))


def violation(problem: Problem, x: np.ndarray, worst: dict[str, Worst]) -> float:
    """Computes how far the worst constraint is below 0, without unit; 0 where all are met.

    Args:
        problem: The step.
        x: (free variables) scaled.
        worst: Worst points of that design, as `design_worst` gives them.
    """
    lowest = [float(w.values[0]) for name, w in worst.items() if name != "quality"]
    lowest += [float(v[0]) for v in problem.design_margins(problem.designs(x[None])).values()]
    return max(0.0, -min(lowest, default=0.0))


def start_points(problem: Problem, seed: int, starts: int = STARTS) -> np.ndarray:
    """Gives the middle of the bounds, then the best feasible or least violated designs of a Latin hypercube.

    Returns:
        (starts, free variables) scaled; one row where nothing is free.
    """
    n = len(problem.free)
    middle = np.full((1, n), 0.5)
    if n == 0 or starts < 2:
        return middle
    x = qmc.LatinHypercube(n, rng=np.random.default_rng(seed)).random(_SAMPLES)
    objective, margin = sampled(problem, x, _START_GRID)
    order = np.lexsort((objective, np.maximum(0.0, -margin.min(axis=1))))
    return np.concatenate([middle, x[order[: starts - 1]]])


def sampled(problem: Problem, x: np.ndarray, n: int) -> tuple[np.ndarray, np.ndarray]:
    """Computes objective and margins of many designs on a fixed grid of the cube's surface.

    Args:
        problem: The step.
        x: (D, free variables) scaled.
        n: Grid points along an edge.

    Returns:
        (D,) objective to minimise: minus L scaled, or minus 1 / kappa; (D, constraints) margins, each the
        smallest over the grid.
    """
    designs = problem.designs(x)
    # the grid is the same for all designs: not copied for each of them
    parts = [problem.figures(designs, points) for points in (shared_points(n), fold_points(designs))]
    margins = [problem.point_margins(f) for f in parts]
    columns = [np.minimum(*(margin[name].min(axis=1) for margin in margins)) for name in margins[0]]
    columns += list(problem.design_margins(designs).values())
    objective = np.zeros(len(x))
    if problem.step == 3:
        objective = -np.minimum(*(f.quality.min(axis=1) for f in parts))
    elif "half_side" in problem.free:
        objective = -x[:, problem.free.index("half_side")]
    return objective, np.stack(columns, axis=1) if columns else np.zeros((len(x), 1))


def _violated(program: Program, worst: dict[str, Worst], wanted: float) -> list[Active]:
    """Selects the worst points at which a margin is less than the program asks."""
    return [
        Active(name, _key(point))
        for name, w in worst.items()
        for point, value in zip(w.points, w.values, strict=True)
        if value - (wanted if program.kind == "feasibility" or name == "quality" else 0.0) < SLACK / 2.0
    ]


def _worst(program: Program, x: np.ndarray, count: Search, n: int = EXCHANGE_GRID) -> dict[str, Worst]:
    found = count.worst(program.problem, x, n)
    return {name: worst for name, worst in found.items() if name != "quality" or program.kind == "quality"}


def _own_level(program: Program, x: np.ndarray, worst: dict[str, Worst]) -> float:
    """Computes the level that a design reaches by itself, on the polished surface."""
    if program.kind == "quality":
        return float(worst["quality"].values[0])
    if program.kind == "half_side":
        return -program.objective(x)[0]
    lowest = [w.values[0] for w in worst.values()]
    lowest += [v[0] for v in program.problem.design_margins(program.problem.designs(x[None])).values()]
    return float(min(lowest, default=0.0))


def _plain(x: np.ndarray) -> tuple[float, ...]:
    return tuple(float(value) for value in x)


def _key(point: np.ndarray) -> tuple[float, float, float]:
    return (float(point[0]), float(point[1]), float(point[2]))
