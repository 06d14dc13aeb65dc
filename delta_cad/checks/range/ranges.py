"""Limits on every position of the cube, held over sampled positions; `optimizer certify` proves them."""

from __future__ import annotations

import numpy as np

from delta_cad.checks.limits import CheckLimits
from delta_cad.checks.report import CheckResult
from delta_cad.common.units import MM_PER_M
from delta_cad.mechanism import DeltaGeometry
from delta_cad.mechanism.limits import FigureOfMerit, PoseLimit


def check_ranges(geometry: DeltaGeometry, limits: CheckLimits) -> list[CheckResult]:
    """Holds every figure that the limits bound against its threshold.

    Returns:
        One for each figure, in the order of the registry; reach alone where it fails, for nothing else has a meaning.
    """
    poses = limits.poses_mm()
    results: list[CheckResult] = []
    for limit in limits.pose:
        results += [_result(limit, figure, geometry, poses) for figure in limit.figures]
        if limit.always and not all(result.passed for result in results):
            break
    return results


def _result(limit: PoseLimit, figure: FigureOfMerit, geometry: DeltaGeometry, poses: np.ndarray) -> CheckResult:
    """The worst chain's figure against its threshold, in people's unit; NaN fails."""
    sign = 1.0 if figure.upper else -1.0
    values, bound = figure.values(limit, geometry, poses / MM_PER_M), limit.bound(figure)
    worst = np.where(np.isnan(values), np.inf, sign * values)
    pose, chain = np.unravel_index(np.argmax(worst), worst.shape)
    x, y, z = poses[pose].tolist()
    detail = f"{figure.words}, {'largest' if figure.upper else 'least'} of {len(poses)} positions"
    chains = () if worst.shape[1] == 1 else (f"chain_{chain}",)
    passed = bool(worst[pose, chain] < sign * bound if limit.strict else worst[pose, chain] <= sign * bound)
    value, allowed = float(values[pose, chain]) * figure.scale, bound * figure.scale
    name = (figure.name or limit.name).replace("_", " ")
    return CheckResult(name, passed, value, allowed, figure.unit, (x, y, z), chains, detail)
