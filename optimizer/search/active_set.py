"""A problem over a handful of active points, as a smooth program for SQP: values and gradients by central differences.

The three kinds share one form, `maximise level subject to margin_k(x) - weight_k level >= slack`:

- `half_side`: level is L itself, weights are 0;
- `quality`: the epigraph of the worst condition number, `1 / kappa(p_k) >= level`, which is `kappa(p_k) <= t` with
  t = 1 / level, but stays finite at both singularities;
- `feasibility`: every margin at least `level`, so that the best level is >= 0 exactly where all can be met.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from optimizer.problem.evaluator import figures, fold_points
from optimizer.problem.step import Problem

# Step of the central differences in the scaled variables: truncation 2e-11 of the third derivative, rounding 1e-11 of
# the margin. Gradients agree with a fourth-order formula to 1e-6 where two singular values nearly meet, else to 1e-9.
DIFFERENCE = 1e-5
# What every margin keeps at the optimum, so that what the solver leaves open (1e-10) still is no violation.
SLACK = 1e-8
# Margins this little below 0 still are met: lengths pass from mm to m and back (1e-16), sums of them 1e-14.
ROUNDING = 1e-9
# Distance, as a share of L, within which a margin differs by 1e-6 of its second derivative: the polish moved it.
_NEAR = 1e-3
_LEVEL_MAX = 1e-3  # feasibility is shown once every margin is this large; a higher level would only cost iterations


class Active(NamedTuple):
    """One margin at one point of the cube."""

    name: str
    point: tuple[float, float, float]


class Program:
    """A problem at its active points.

    The unknowns are the free variables, scaled to [0, 1], and last the level, unless the kind is `half_side`.

    Attributes:
        problem: The step.
        kind: `half_side`, `quality` or `feasibility`.
        active: Pointwise margins that are constraints.
        evaluations: How many designs were evaluated.
        has_level: Whether the last unknown is a level of its own.
        level_index: Place of what is maximised among the unknowns; None where L is fixed and only feasibility counts.
        level_min: Lower bound of that unknown.
    """

    def __init__(self, problem: Problem, kind: str) -> None:
        self.problem, self.kind = problem, kind
        self.active: list[Active] = []
        self.evaluations = 0
        self.has_level = kind != "half_side"
        self.level_min = -np.inf if self.has_level else 0.0
        self.level_index: int | None = None
        if self.has_level or "half_side" in problem.free:
            self.level_index = len(problem.free) if self.has_level else problem.free.index("half_side")
        eye = np.eye(len(problem.free))
        self._steps = DIFFERENCE * np.concatenate([np.zeros((1, len(eye))), eye, -eye])
        self._points, self._rows = np.empty((0, 3)), dict[str, np.ndarray]()  # of the active ones; name -> places
        self._kept: tuple[bytes, np.ndarray, np.ndarray] | None = None

    def add(self, active: list[Active]) -> int:
        """Takes in margins that are not yet active and returns how many were new.

        A point very near to an active one takes its place: two almost equal rows make SLSQP's subproblem singular.
        """
        new = [item for item in dict.fromkeys(active) if item not in self.active]
        for item in new:
            near = (other for other in self.active if other.name == item.name)
            gone = [k for k in near if max(abs(a - b) for a, b in zip(k.point, item.point, strict=True)) < _NEAR]
            self.active = [other for other in self.active if other not in gone] + [item]
        names = np.array([item.name for item in self.active])
        self._points = np.array([item.point for item in self.active])
        self._rows = {name: np.flatnonzero(names == name) for name in dict.fromkeys(names.tolist())}
        self._kept = None
        return len(new)

    def bounds(self) -> list[tuple[float, float]]:
        """Gives (lower, upper) of every unknown."""
        box = [(0.0, 1.0)] * len(self.problem.free)
        return box + ([(-np.inf, _LEVEL_MAX if self.kind == "feasibility" else 1.0)] if self.has_level else [])

    def objective(self, unknowns: np.ndarray) -> tuple[float, np.ndarray]:
        """Computes what is minimised, and its gradient: minus the level, or minus L scaled."""
        gradient = np.zeros(len(unknowns))
        if self.level_index is not None:
            gradient[self.level_index] = -1.0
        return float(gradient @ unknowns), gradient

    def constraints(self, unknowns: np.ndarray) -> np.ndarray:
        """Computes the left sides of all constraints, each >= 0 where it is met."""
        return self._both(unknowns)[0]

    def jacobian(self, unknowns: np.ndarray) -> np.ndarray:
        """Computes the (rows, unknowns) gradients of the constraints."""
        return self._both(unknowns)[1]

    def _both(self, unknowns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        key = unknowns.tobytes()
        if self._kept is None or self._kept[0] != key:
            self._kept = (key, *self._values(unknowns))
        return self._kept[1], self._kept[2]

    def _values(self, unknowns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        n = len(self.problem.free)
        table, weights = self.margins(unknowns[:n] + self._steps)  # (1 + 2 n, rows), (rows,)
        gradient = (table[1 : n + 1] - table[n + 1 :]).T / (2.0 * DIFFERENCE)
        # a margin that no free variable moves can keep no slack: it is met to a rounding
        value = table[0] - np.where((gradient != 0.0).any(axis=1), SLACK, -ROUNDING)
        if self.has_level:
            value = value - weights * unknowns[-1]
            gradient = np.column_stack([gradient, -weights])
        return value, gradient

    def margins(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Computes the margins at the active points, without level and slack.

        Args:
            x: (D, number of free variables) scaled variables.

        Returns:
            (D, rows) margins, the active points first, then what holds for the whole design; (rows,) weights of the
            level.
        """
        designs = self.problem.designs(x)
        self.evaluations += len(designs)
        count, cube = len(self.active), self._cube_margins(designs)
        table, feasibility = np.empty((len(x), count + len(cube))), self.kind == "feasibility"
        weights = np.full(count + len(cube), 1.0 if feasibility else 0.0)
        if self.active:
            f = self.problem.figures(designs, self._points)
            values = self.problem.point_margins(f) | {"quality": f.quality}
            for name, rows in self._rows.items():
                table[:, rows] = values[name][:, rows]
            weights[self._rows.get("quality", [])] = 1.0
        for k, margin in enumerate(cube):
            table[:, count + k] = margin
        return table, weights

    def _cube_margins(self, designs: np.ndarray) -> list[np.ndarray]:
        """Computes the (D,) margins that each hold for the whole design.

        The point of the bottom face where a chain folds first moves with R - r: exchanged for ever newer points it is
        met in the limit only, followed as it moves it is one smooth row.
        """
        margins = self.problem.smooth_design_margins(designs)
        if "reach" in self.problem.constraints:
            margins += list(figures(designs, fold_points(designs), False, False).closure.T)
        return margins
