"""The joystick's requirements for the tests of the front, and a check of designs that shares nothing with our code."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from optimizer.problem.requirements import Requirements, load_requirements
from optimizer.study.front import Curve

JOYSTICK = Path(__file__).parents[1] / "references" / "joystick.toml"

FIXED: dict[str, Any] = {"gravity_torque_N_m": 0.11, "shoulder_deg": None}
"""Whatever the machine that is built has come to weigh, and its stops."""


def joystick(
    half_side_mm: float | None = None, half_side: tuple[float, float] | None = None, **limits: Any
) -> Requirements:
    """The former task, some of it replaced."""
    given = load_requirements(JOYSTICK)
    changed: dict[str, Any] = {"limits": given.limits.model_copy(update=FIXED | limits)}
    if half_side_mm is not None:
        changed["step_3"] = given.step_3.model_copy(update={"half_side_mm": half_side_mm})
    if half_side is not None:
        changed["bounds_mm"] = given.bounds_mm.model_copy(update={"half_side": half_side})
    return given.model_copy(update=changed)


def kappa_at(curve: Curve, half_side: float) -> float | None:
    """A front's kappa at a half side in mm, on the line between two points; None outside the front."""
    sides = [point.half_side for point in curve.points]
    if not sides or not sides[0] <= half_side <= sides[-1]:
        return None
    return float(np.interp(half_side, sides, [point.kappa for point in curve.points]))


class Checked(NamedTuple):
    """Largest values over the points that were looked at; lengths in mm."""

    kappa: float
    torque: float
    lean_deg: float
    reachable: bool


def check(design_mm: tuple[float, ...], force: float, n: int = 33) -> Checked:
    """Figures of a design by the paper's equations (1)-(16): angles, elbows, the Jacobian from its rows.

    The surface of the cube on an even grid and its volume on a coarse one.
    """
    L_A, L_B, R, r, H, L = design_mm[:6]
    line = np.linspace(-L, L, n)
    x, y, z = np.meshgrid(line, line, line, indexing="ij")
    edge = (np.abs(np.stack([x, y, z])) == L).any(axis=0)
    coarse = np.zeros_like(edge)
    coarse[::4, ::4, ::4] = True
    p = np.stack([x, y, z + H + L], axis=-1)[edge | coarse]
    rows, lean, reachable = [], 0.0, True
    for phi in np.radians([0.0, 120.0, 240.0]):
        u = p[:, 0] * np.cos(phi) + p[:, 1] * np.sin(phi)
        A, B = 2.0 * L_A * (R - r - u), -2.0 * L_A * p[:, 2]
        C = L_A**2 - L_B**2 + (R - r) ** 2 + (p * p).sum(axis=1) - 2.0 * (R - r) * u
        root = A * A + B * B - C * C
        reachable &= bool((root >= 0.0).all())
        # A cos + B sin + C = 0; of the two roots the one with the elbow farther out
        angles = [np.arctan2(-B * C - s * A * np.sqrt(root), -A * C + s * B * np.sqrt(root)) for s in (-1.0, 1.0)]
        theta = np.where(np.cos(angles[0]) > np.cos(angles[1]), angles[0], angles[1])
        assert np.abs(A * np.cos(theta) + B * np.sin(theta) + C).max() < 1e-9 * L_B**2  # rounding of squares of mm
        elbow = np.stack(
            [
                (R - r + L_A * np.cos(theta)) * np.cos(phi),
                (R - r + L_A * np.cos(theta)) * np.sin(phi),
                L_A * np.sin(theta),
            ],
            axis=-1,
        )
        rod = p - elbow
        moving = L_A * np.stack([-np.sin(theta) * np.cos(phi), -np.sin(theta) * np.sin(phi), np.cos(theta)], axis=-1)
        rows.append(rod / (rod * moving).sum(axis=1)[:, None])  # theta_dot = rows v
        aside = np.array([-np.sin(phi), np.cos(phi), 0.0])
        lean = max(lean, float(np.degrees(np.arcsin(np.abs(rod @ aside) / L_B)).max()))
    inverse = np.stack(rows, axis=1)  # 1 / mm
    torque = force * np.sqrt((np.linalg.inv(inverse) ** 2).sum(axis=1)).max() / 1000.0
    return Checked(float(np.linalg.cond(inverse).max()), float(torque), lean, reachable)
