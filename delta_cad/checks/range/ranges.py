"""Ranges of the mechanism over the sampled cube: reach, lean of the rods, shoulder angles, torque."""

from __future__ import annotations

import numpy as np

from delta_cad.checks.limits import CheckLimits
from delta_cad.checks.report import CheckResult
from delta_cad.common.units import MM_PER_M
from delta_cad.mechanism import DeltaGeometry, closure_margin, joint_angles, rod_lean, worst_joint_torque


def check_ranges(geometry: DeltaGeometry, limits: CheckLimits) -> list[CheckResult]:
    """Hold the mechanism's ranges against the limits that are given.

    Args:
        geometry: The mechanism, metres.
        limits: The cube and the limits.

    Returns:
        `reach` always; if it holds, `lean`, `shoulder lowest`, `shoulder highest` and `torque` for the limits that
        are not None.
    """
    poses = limits.poses_mm()
    p = poses / MM_PER_M
    margin = closure_margin(geometry, p) * MM_PER_M**2
    reach = _result("reach", margin, 0.0, "mm^2", poses, "closure margin w^2 of the chains", least=True)
    if not reach.passed:
        return [reach]
    results = [reach]
    if limits.lean_max_rad is not None:
        lean = np.abs(rod_lean(geometry, p))
        results.append(_result("lean", lean, limits.lean_max_rad, "rad", poses, "lean of the rods out of their plane"))
    if limits.shoulder_range_rad is not None:
        low, high = limits.shoulder_range_rad
        theta = joint_angles(geometry, p)
        results.append(_result("shoulder lowest", theta, low, "rad", poses, "shoulder angle, lower stop", least=True))
        results.append(_result("shoulder highest", theta, high, "rad", poses, "shoulder angle, upper stop"))
    if limits.force_N is not None and limits.joint_torque_N_m is not None:
        torque = worst_joint_torque(geometry, p, limits.force_N)
        detail = f"joint torque for {limits.force_N:g} N in the worst direction, without gravity"
        results.append(_result("torque", torque, limits.joint_torque_N_m, "N m", poses, detail))
    return results


def _result(
    name: str, values: np.ndarray, limit: float, unit: str, poses: np.ndarray, detail: str, least: bool = False
) -> CheckResult:
    """The largest (or least) of values (n, 3 chains) against an upper (or lower) limit; NaN fails."""
    sign = -1.0 if least else 1.0
    worst = np.where(np.isnan(values), np.inf, sign * values)
    pose, chain = np.unravel_index(np.argmax(worst), worst.shape)
    value = float(values[pose, chain])
    x, y, z = poses[pose].tolist()
    detail = f"{detail}; {'least' if least else 'largest'} of {len(poses)} positions, on chain {chain}"
    passed = bool(worst[pose, chain] <= sign * limit)
    return CheckResult(name, passed, value, limit, unit, (x, y, z), (f"chain_{chain}",), detail)
