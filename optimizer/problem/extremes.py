"""The worst points of a cube: the best grid point of every face, then a compass search that stays on the face."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import NamedTuple

import numpy as np

from optimizer.problem.evaluator import CENTRE, fold_points, half_surface
from optimizer.problem.step import Problem
from optimizer.problem.variables import completed

# Halvings of the grid's step: down to 1e-5 of L, and where a figure is smooth its error goes with the square.
_REFINEMENTS = 20
# Axis and side of the faces that the mirror plane y = 0 leaves.
_FACES = ((0, -1.0), (0, 1.0), (1, 1.0), (2, -1.0), (2, 1.0))
STEPS = np.array([[i, j, k] for i in (-1, 0, 1) for j in (-1, 0, 1) for k in (-1, 0, 1)], dtype=float)
# (rows, 3) steps of one search: nine within each face, then all of the one that goes anywhere; and whose they are.
_WITHIN = [np.where(np.arange(3) == axis, 0.0, STEPS[STEPS[:, axis] == -1.0]) for axis, _ in _FACES]
_MOVES = np.concatenate([*_WITHIN, STEPS])
_MOVER = np.repeat(np.arange(len(_FACES) + 1), [len(steps) for steps in (*_WITHIN, STEPS)])
_FIRST = np.arange(len(_FACES)) * len(_WITHIN[0])  # row of a face's first step
LEAST = np.array([-1.0, 0.0, -1.0])  # of the half cube

_Margins = Callable[[np.ndarray], Mapping[str, np.ndarray]]


class Worst(NamedTuple):
    """Local minima of one margin over the cube, worst first.

    Attributes:
        points: (C, 3) in the coordinates of the cube.
        values: (C,) margins there.
    """

    points: np.ndarray
    values: np.ndarray


def worst_points(margins: _Margins, n: int, further: np.ndarray = CENTRE) -> dict[str, Worst]:
    """Finds the smallest values of every margin: one on each face that is no mirror image, and one anywhere.

    Args:
        margins: (K, 3) points in the coordinates of the cube -> name -> (K,) values.
        n: Points of the grid along an edge.
        further: (M, 3) points beside the grid to start from.

    Returns:
        Name -> its worst points.
    """
    grid = np.concatenate([half_surface(n), further])
    values = margins(grid)
    names = list(values)
    if not names:
        return {}
    faces = [*(np.flatnonzero(grid[:, axis] == side) for axis, side in _FACES), np.arange(len(grid))]
    starts = np.array([[face[values[name][face].argmin()] for face in faces] for name in names])
    own, inner = np.arange(len(names))[:, None], len(_MOVES) - len(STEPS)
    best, cost = grid[starts], np.stack([values[name] for name in names])[own, starts]
    step = 1.0 / (n - 1)  # half the grid's
    table, chosen = np.empty((len(names), len(_MOVES))), np.empty_like(starts)
    within, anywhere = table[:, :inner].reshape(len(names), len(_FACES), -1), table[:, inner:]  # views
    for _ in range(_REFINEMENTS):
        around = np.maximum(np.minimum(best[:, _MOVER] + step * _MOVES, 1.0), LEAST)
        found = margins(around.reshape(-1, 3))
        for k, name in enumerate(names):
            table[k] = found[name][k * len(_MOVES) : (k + 1) * len(_MOVES)]
        chosen[:, :-1] = within.argmin(axis=2) + _FIRST
        chosen[:, -1] = anywhere.argmin(axis=1) + inner
        least = table[own, chosen]
        better = least < cost
        best = np.where(better[..., None], around[own, chosen], best)
        cost = np.where(better, least, cost)
        step /= 1.6 if better.any() else 2.0  # slower while it moves on
    result = {}
    for k, name in enumerate(names):
        order = np.argsort(cost[k], kind="stable")
        result[name] = Worst(best[k, order], cost[k, order])
    return result


def design_worst(problem: Problem, design: np.ndarray, n: int) -> dict[str, Worst]:
    """Finds the worst points of every pointwise margin of a problem, and of `quality` where it asks for it.

    Args:
        problem: The step.
        design: (9,) in the order of `VARIABLES`, SI units; or (6,), three-fold symmetric.
        n: Grid points along an edge.

    Returns:
        Name -> its worst points.
    """
    row = completed(design)[None]

    def margins(points: np.ndarray) -> dict[str, np.ndarray]:
        f = problem.figures(row, points)
        found = {name: value[0] for name, value in problem.point_margins(f).items()}
        return found | ({"quality": f.quality[0]} if problem.step == 3 else {})

    return worst_points(margins, n, np.concatenate([CENTRE, fold_points(row)[0]]))
