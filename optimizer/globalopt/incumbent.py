"""An incumbent that is certified: what it reaches is proved for every point of its cube, not sampled."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from delta_cad.mechanism import GeometryError
from delta_cad.mechanism.proof.prove import Progress, prove
from optimizer.problem.extremes import worst_points
from optimizer.problem.step import Problem
from optimizer.problem.variables import PER_SI, SIDE, VARIABLES, completed, mechanism_of

_HEIGHT = VARIABLES.index("bottom_height")
# Shares that are given up: nothing if possible, else the least of them that can be proved.
YIELDS = (0.0, 1e-10, 1e-9, 1e-8, 1e-7, 1e-6, 1e-5)
# Boxes of one proof, 5 s at most, and of the first try. Along a fold a million are needed, else some thousands.
BOXES, QUICK = 1_500_000, 50_000
_OWN_ROUNDING = 1e-15  # a closed-form margin this little below 0 is its own rounding: three operations on shares of 1
GRID = 33


class Certified(NamedTuple):
    """A design and what is proved of it.

    Attributes:
        design_mm: (9,) in the order of `VARIABLES`, mm; or (6,), three-fold symmetric.
        objective: Half side, mm, or a condition number that is exceeded nowhere in the cube.
    """

    design_mm: tuple[float, ...]
    objective: float


def certified(
    problem: Problem,
    design_mm: np.ndarray,
    boxes: int = BOXES,
    progress: Progress | None = None,
) -> Certified | None:
    """Proves a design over the whole cube, giving up as little as possible of its half side, or of its kappa.

    A cube that is given up in part shrinks from all its faces, so that it lies inside the old one and away from a fold
    that the bottom touches. The proof is about the doubles of `design_mm / PER_SI`; outline, lean and clearance are
    taken in closed form.

    Args:
        problem: The step.
        design_mm: (9,) in the order of `VARIABLES`, mm; or (6,), three-fold symmetric.
        boxes: Most boxes of one proof.
        progress: As `prove` calls it, in each of its proofs.

    Returns:
        The design, with a smaller cube where one was needed; None if it cannot be proved to be feasible.
    """
    kappa = _largest_kappa(problem, design_mm) if problem.step == 3 else None
    best = _proved(problem, design_mm, kappa, YIELDS[0], min(QUICK, boxes), progress)
    if best is not None:
        return best
    for share in reversed(YIELDS[1:]):  # what gives up less is harder to prove: the first failure ends it
        less = _proved(problem, design_mm, kappa, share, boxes, progress)
        if less is None:
            break
        best = less
    return best


def uncertified(problem: Problem, design_mm: np.ndarray, progress: Progress | None = None) -> Certified | None:
    """Proves the constraints of a design of step 3 over the whole cube, but samples its condition number.

    Where the cube touches a fold the condition number rises too steeply to be proved, while the torque that holds it
    finite is not too steep.

    Args:
        problem: The step.
        design_mm: (9,) in the order of `VARIABLES`, mm; or (6,), three-fold symmetric.
        progress: As `certified` calls it.

    Returns:
        The design with its sampled condition number; None if its constraints cannot be proved.
    """
    kappa = _largest_kappa(problem, design_mm)
    best = _proved(problem, design_mm, None, YIELDS[0], BOXES, progress)
    return best._replace(objective=kappa) if best is not None and math.isfinite(kappa) else None


def _proved(
    problem: Problem,
    design_mm: np.ndarray,
    kappa: float | None,
    share: float,
    boxes: int,
    progress: Progress | None,
) -> Certified | None:
    """Proves the design with a share given up; None if it cannot be proved."""
    design = completed(design_mm).copy()
    level = None if kappa is None else kappa * (1.0 + share)
    if level == math.inf:  # a chain folds: no limit says that
        return None
    if level is None:
        half, height = design[SIDE], design[_HEIGHT]
        design[SIDE] = max(half * (1.0 - share), problem.lower[SIDE])
        design[_HEIGHT] = min(height + (half - design[SIDE]), problem.upper[_HEIGHT])
    row = design / PER_SI
    if any(margin[0] < -_OWN_ROUNDING for margin in problem.design_margins(row[None]).values()):
        return None
    try:
        limits = problem.pose_limits(math.inf if level is None else level)
        proof = prove(*mechanism_of(design), limits, max_boxes=boxes, progress=progress)
    except GeometryError:
        return None
    if proof.verdict != "proved":
        return None
    return Certified(tuple(float(v) for v in design), float(design[SIDE]) if level is None else level)


def _largest_kappa(problem: Problem, design_mm: np.ndarray) -> float:
    row = completed(design_mm)[None] / PER_SI
    quality = worst_points(lambda points: {"quality": problem.figures(row, points).quality[0]}, GRID)["quality"]
    worst = float(quality.values[0])
    return 1.0 / worst if worst > 0.0 else math.inf
