"""Conditioning: does the handle move alike in all directions, everywhere in the cube?"""

from __future__ import annotations

import numpy as np

from delta_cad.checks.limits import CheckLimits
from delta_cad.checks.report import CheckResult
from delta_cad.common.units import MM_PER_M
from delta_cad.mechanism import DeltaGeometry, conditioning


def check_conditioning(geometry: DeltaGeometry, limits: CheckLimits, largest: float) -> CheckResult:
    """Holds the worst condition number of the Jacobian over sampled positions of the cube against a limit.

    Args:
        geometry: The mechanism's lengths, m.
        limits: With the cube.
        largest: The largest condition number that is allowed, at least 1.
    """
    poses = limits.poses_mm()
    kappa = conditioning(geometry, poses / MM_PER_M)
    worst = int(np.argmax(np.where(np.isnan(kappa), np.inf, kappa)))
    x, y, z = poses[worst].tolist()
    value = float(kappa[worst])
    detail = f"condition number of the Jacobian, largest of {len(poses)} positions"
    return CheckResult("conditioning", value <= largest, value, largest, "", (x, y, z), detail=detail)
