"""Joints: both frames of each coincide at every sampled position, and ball joints stay within their free tilt."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from delta_cad.assembly.machine import Assembly
from delta_cad.checks.limits import CheckLimits
from delta_cad.checks.report import CheckResult
from delta_cad.solids.part import Joint

ORIGIN_MM = 1e-3  # 1 um: what the issue asks of axes and centres
LEVER_MM = 60.0  # length over which a revolute axis may stray by ORIGIN_MM: half the widest arm


def check_joints(assembly: Assembly, limits: CheckLimits) -> list[CheckResult]:
    """Checks closure and tilt of every joint over corners, grid and random positions.

    Returns:
        `joint closure` over all joints (mm), and `ball tilt` (degrees) where there are ball joints.
    """
    poses = limits.poses_mm()
    links = assembly.placement(poses)
    gaps = [_misfit(joint, links) for joint in assembly.joints]
    if not gaps:
        return [CheckResult("joint closure", False, None, ORIGIN_MM, "mm", detail="the assembly declares no joint")]
    k, pose = _worst([gap for gap, _ in gaps])
    value = float(gaps[k][0][pose])
    detail = (
        f"distance of the joint's two origins, and of its two axes over {LEVER_MM:g} mm, largest of "
        f"{len(gaps)} joints at {len(poses)} positions"
    )
    at, pair = _tuple(poses[pose]), (assembly.joints[k].name,)
    results = [CheckResult("joint closure", value <= ORIGIN_MM, value, ORIGIN_MM, "mm", at, pair, detail)]
    balls = [(joint, tilt) for joint, (_, tilt) in zip(assembly.joints, gaps, strict=True) if joint.kind == "ball"]
    if balls:
        k, pose = _worst([tilt - _tilt_limit(joint) for joint, tilt in balls])
        joint, tilt = balls[k]
        value, limit = float(np.degrees(tilt[pose])), float(np.degrees(_tilt_limit(joint)))
        detail = f"angle between stud and socket axes, closest to its limit of {len(balls)} ball joints"
        holds = bool(tilt[pose] <= _tilt_limit(joint))
        results.append(CheckResult("ball tilt", holds, value, limit, "deg", _tuple(poses[pose]), (joint.name,), detail))
    return results


def _misfit(joint: Joint, links: Mapping[str, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """(n,) distance in mm of the two origins (revolute: or of the axes over the lever), (n,) angle of the axes, rad."""
    if joint.kind not in ("revolute", "ball"):
        raise ValueError(f"joint {joint.name} is of unknown kind {joint.kind!r}; revolute and ball are known")
    a, b = links[joint.link_a] @ joint.frame_a, links[joint.link_b] @ joint.frame_b
    apart = np.linalg.norm(a[..., :3, 3] - b[..., :3, 3], axis=-1)
    across = np.linalg.norm(np.cross(a[..., :3, 1], b[..., :3, 1]), axis=-1)
    angle = np.arctan2(across, (a[..., :3, 1] * b[..., :3, 1]).sum(axis=-1))
    return (np.maximum(apart, angle * LEVER_MM) if joint.kind == "revolute" else apart), angle


def _tilt_limit(joint: Joint) -> float:
    if joint.tilt_limit_rad is None:
        raise ValueError(f"ball joint {joint.name} declares no tilt limit")
    return joint.tilt_limit_rad


def _worst(values: list[np.ndarray]) -> tuple[int, int]:
    """Index of the joint and of the position with the largest value."""
    table = np.array(values)
    k, pose = np.unravel_index(np.argmax(table), table.shape)
    return int(k), int(pose)


def _tuple(p: np.ndarray) -> tuple[float, float, float]:
    x, y, z = p.tolist()
    return x, y, z
