"""Predicted accuracy of a calibrated device: the covariance of its parameters propagated over the cube.

At a position p the error is `A(p) x` with the derivatives A of the kinematics and the error x of the parameters, so
that its covariance is `A C A^T`. Where the frame of the positions was fitted, its error belongs to x: what counts is
the place of the handle in that frame. A further pose with rows A and noise W turns C into
`C - C A^T (A C A^T + W)^-1 A C`, from which the effect of each candidate pose follows without a fit.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from delta_cad.design import Design
from delta_cad.mechanism.workspace import cube_grid
from haptics.calibration.fit import Fit

_FINE, COARSE = 9, 5  # positions along an edge of the cube: where the error is computed, and of candidate poses
POSES_MOST = 12  # that are proposed
_GOAL = 0.9  # of the limit, to which they lead: with them the parameters and the derivatives are a little others


@dataclass(frozen=True)
class Accuracy:
    """Predicted distance between where the controller believes the handle is and where it is.

    Attributes:
        rms: Root mean square over the cube, m.
        worst: Root mean square at the position where it is largest, m.
        worst_at: (3,) that position in the base frame, m.
    """

    rms: float
    worst: float
    worst_at: np.ndarray


@dataclass(frozen=True)
class Proposal:
    """Further poses and what they lead to.

    Attributes:
        positions: (k, 3) in the base frame, m.
        accuracy: With them measured as noisily as the others.
    """

    positions: np.ndarray
    accuracy: Accuracy


def accuracy(found: Fit, design: Design) -> Accuracy:
    """Predicts the position error of a calibrated device over its cube.

    Args:
        found: The fit.
        design: The device as drawn, with its cube.

    Raises:
        FitError: The calibrated device does not reach all of it.
    """
    grid = cube_grid(design.workspace, _FINE)
    return _accuracy(grid, _squares(found.at(grid).rows(found.x), found.covariance))


def helpful_poses(found: Fit, design: Design, limit: float) -> Proposal:
    """Picks further poses from a grid in the cube, each the one that lowers the largest predicted errors most.

    Args:
        found: The fit.
        design: The device as drawn, with its cube.
        limit: Worst predicted error that is allowed, m.

    Returns:
        At most `POSES_MOST` poses, which may repeat, and the accuracy after them.

    Raises:
        FitError: The calibrated device does not reach all of the cube.
    """
    grid, places = cube_grid(design.workspace, _FINE), cube_grid(design.workspace, COARSE)
    rows, there = found.at(grid).rows(found.x), found.at(places)
    # In units in which the noise of each coordinate is 1; a misfit makes a further pose worth as little as the others.
    candidates = there.whitened(found.x) @ there.rows(found.x) / max(1.0, found.misfit)
    covariance, chosen = found.covariance, list[int]()
    squares = _squares(rows, covariance)
    while len(chosen) < POSES_MOST and squares.max() > (_GOAL * limit) ** 2:
        pulled = candidates @ covariance  # (c, 3, n)
        inside = np.linalg.inv(pulled @ np.swapaxes(candidates, 1, 2) + np.eye(3))
        gain = np.einsum("gin,cjn->gcij", rows, pulled)
        after = squares[:, None] - np.einsum("gcij,cjk,gcik->gc", gain, inside, gain, optimize=True)
        # the fourth power of errors weighs the worst places; the largest alone stops where two corners change places
        best = int((after**2).mean(axis=0).argmin())
        chosen.append(best)
        covariance = covariance - pulled[best].T @ inside[best] @ pulled[best]
        squares = after[:, best]
    return Proposal(places[chosen], _accuracy(grid, squares))


def _squares(rows: np.ndarray, covariance: np.ndarray) -> np.ndarray:
    """(m,) mean square of the error at each position, m^2, of rows (m, 3, n)."""
    return ((rows @ covariance) * rows).sum(axis=(1, 2))


def _accuracy(grid: np.ndarray, squares: np.ndarray) -> Accuracy:
    worst = int(squares.argmax())
    return Accuracy(float(np.sqrt(squares.mean())), float(np.sqrt(squares[worst])), grid[worst])
