"""A task with wide bounds, for limits that are carried up to the proven optimum, and designs beside that optimum."""

from __future__ import annotations

from typing import Any

import numpy as np

from delta_cad.mechanism import Cube, DeltaGeometry
from optimizer.globalopt.optimum import Proven
from optimizer.problem.step import Problem

LIMITS: dict[str, Any] = {
    "outline_radius_max_mm": 122.0,
    "kappa_max": 2.27,
    "lean_max_deg": 28.0,
    "shoulder_deg": [-65.5, 70.0],
    "gravity_torque_N_m": 0.08,
}
WIDE = ((80, 180), (30, 45), (20, 150))
NARROW = ((110, 120), (40, 40), (50, 60))  # where little has to be searched to prove that there is nothing
ROUNDING = 1e-9
"""A margin this little below 0 is met, as in `search.active_set`."""
DESIGNS = 4_000


def mechanism(design: np.ndarray) -> tuple[DeltaGeometry, Cube]:
    """The mechanism and the cube of a design of a three-fold symmetric machine, m."""
    L_A, L_B, R, r, H, L = design[:6]
    return DeltaGeometry(R, r, L_A, L_B), Cube(H, L)


def random_designs(problem: Problem, found: Proven, count: int = DESIGNS) -> np.ndarray:
    """(count, 6) designs within the bounds, m; half of them near the optimum at widths from 1e-6 to 0.3."""
    rng = np.random.default_rng(5)
    x = rng.random((count, len(problem.free)))
    width = 10.0 ** rng.uniform(-6.0, -0.5, (count // 2, 1))
    near = problem.scaled(np.array(found.design_mm))
    x[: count // 2] = np.clip(near + width * rng.normal(size=(count // 2, len(near))), 0.0, 1.0)
    return problem.designs(x)
