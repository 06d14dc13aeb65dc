"""The search's figures as one writes them from the paper: trigonometry, `numpy.linalg.solve`, `numpy.linalg.cond`."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from unittest.mock import patch

import numpy as np

from optimizer.problem.evaluator import Figures, figures
from optimizer.problem.variables import completed
from tests.optimizer.tasks import sample_points

USERS = ("optimizer.problem.step.figures", "optimizer.search.active_set.figures", "optimizer.search.result.figures")
"""Where the search calls the evaluator."""


def figures_by_solve(
    designs: np.ndarray, points: np.ndarray, conditioning: bool = True, angles: bool = True
) -> Figures:
    """The figures of `optimizer.problem.evaluator.figures`, with the same arguments, of three-fold symmetric designs.

    Beyond the reach, where the paper's formulas have no value, the chains are continued as in the evaluator: a search
    needs margins there. `cond` is left out where the step does not ask for it, as in ours.
    """
    designs = completed(designs)
    L_A, L_B, R, r, H, L = (designs[:, k, None] for k in range(6))
    phi = np.radians([0.0, 120.0, 240.0])
    x, y, z = np.broadcast_arrays(L * points[..., 0], L * points[..., 1], H + L * (1.0 + points[..., 2]))
    x, y, z = x[..., None], y[..., None], z[..., None]  # (D, K, 1)
    L_A, L_B, a = L_A[..., None], L_B[..., None], (R - r)[..., None]
    q = x * np.cos(phi) + y * np.sin(phi) - a
    t = y * np.cos(phi) - x * np.sin(phi)
    m = (q**2 + t**2 + z**2 + L_A**2 - L_B**2) / (2.0 * L_A)
    w2 = q**2 + z**2 - m**2
    w = np.sqrt(np.maximum(w2, 0.0))
    rho2 = np.maximum(q**2 + z**2, np.finfo(float).tiny)
    # within the reach the angle of the paper; beyond it m^2 > rho^2 and the forearm is what is left
    cos, sin = (q * m + z * w) / rho2, (z * m - q * w) / rho2
    theta = np.arctan2(sin, cos)
    s = (
        np.stack(
            [
                (q - L_A * cos) * np.cos(phi) - t * np.sin(phi),
                (q - L_A * cos) * np.sin(phi) + t * np.cos(phi),
                np.broadcast_to(z - L_A * sin, q.shape),
            ],
            axis=-1,
        )
        / L_B[..., None]
    )
    closure, determinant = (w2 / L_B**2).min(axis=-1), np.linalg.det(s)
    regular = np.where((np.abs(determinant) > 1e-300)[..., None, None], s, np.eye(3))  # solve refuses the others
    jacobian = np.linalg.solve(regular, (L_A * w / L_B)[..., None] * np.eye(3))
    moment = np.linalg.norm(jacobian, axis=-2).max(axis=-1) * np.abs(determinant)
    quality = np.ones_like(closure)
    if conditioning:
        quality = np.sign(determinant) / np.linalg.cond(jacobian)
        quality = np.where(closure <= 0.0, np.minimum(closure, 0.0), quality)
    if not angles:
        theta = np.zeros_like(theta)
    return Figures(closure, determinant, moment, quality, theta.min(axis=-1), theta.max(axis=-1), designs, points)


@contextmanager
def numpy_objective() -> Iterator[None]:
    """The whole search on those figures."""
    with ExitStack() as stack:
        for user in USERS:
            stack.enter_context(patch(user, figures_by_solve))
        yield


def agree() -> None:
    """Both must come to the same, or their times say nothing.

    Raises:
        RuntimeError: They do not.
    """
    rng = np.random.default_rng(5)
    low, high = np.array([82, 90, 40, 20, 40, 0]), np.array([82, 130, 40, 45, 100, 75])
    designs = (low + (high - low) * rng.random((40, 6))) / 1000.0
    points = sample_points(designs, 5)
    for name, a, b in zip(Figures._fields, figures(designs, points), figures_by_solve(designs, points), strict=True):
        # solve and cond lose the digits that the condition number has, up to 1e5 here; the moment is their product
        if not np.allclose(a, b, rtol=1e-8, atol=1e-8):
            raise RuntimeError(f"{name}: ours and NumPy solve and cond disagree: nothing to compare")
