"""Forward kinematics: the joint angles of every sampled position lead back to it, so the encoders tell the handle."""

from __future__ import annotations

import numpy as np

from delta_cad.checks.limits import CheckLimits
from delta_cad.checks.report import CheckResult
from delta_cad.common.units import MM_PER_M
from delta_cad.mechanism import DeltaGeometry
from delta_cad.mechanism.forward import platform_positions
from delta_cad.mechanism.inverse import joint_angles

_MISS_MM = 1e-6  # a nanometre: roundings are a thousandth of it, another assembly mode lies millimetres away


def check_forward(geometry: DeltaGeometry, limits: CheckLimits) -> CheckResult:
    """Compares every position with the one that forward kinematics finds from its joint angles.

    Args:
        geometry: The mechanism, metres.
        limits: The cube.

    Returns:
        The largest distance of the two, mm; it fails where the position belongs to another assembly mode.
    """
    poses = limits.poses_mm()
    back = platform_positions(geometry, joint_angles(geometry, poses / MM_PER_M)) * MM_PER_M
    miss = np.linalg.norm(back - poses, axis=-1)
    pose = int(np.argmax(np.where(np.isnan(miss), np.inf, miss)))
    x, y, z = poses[pose].tolist()
    value = float(miss[pose])
    return CheckResult(
        "forward kinematics",
        value <= _MISS_MM,
        None if np.isnan(value) else value,
        _MISS_MM,
        "mm",
        (x, y, z),
        detail=f"distance of FK(IK(p)) from p, largest of {len(poses)} positions",
    )
