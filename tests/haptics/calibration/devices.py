"""Devices made with errors, and what a person measures of them; readings are found by bisection of the sensor's law."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from scipy.optimize import brentq

from delta_cad.design import Design
from delta_cad.mechanism.chains import chain_angles
from haptics.calibration.poses import COLUMNS, Poses
from haptics.calibration.unknowns import LENGTHS, ZERO, Unknowns, nominal

LENGTH, TURN, WAVE = 0.1e-3, math.radians(0.3), math.radians(0.1)


def made(design: Design, rng: np.random.Generator, turns: float = 1.0) -> Unknowns:
    """A device with 0.1 mm on every length and offset, 0.3 degrees on every zero, and waves, each normal."""
    drawn = nominal(design.geometry, turns)
    table = drawn.table.copy()
    table[:, :LENGTHS] += rng.normal(0.0, LENGTH, (3, LENGTHS))
    table[:, ZERO] += rng.normal(0.0, TURN, 3)
    table[:, ZERO + 1 :] += rng.normal(0.0, WAVE, (3, 4))
    return replace(drawn, table=table)


def readings(device: Unknowns, p: np.ndarray) -> np.ndarray:
    """(n, 3) what the encoders read at positions (n, 3), rad."""
    theta = chain_angles(device.mechanism, p)
    out = np.empty_like(theta)
    for n, row in enumerate(theta):
        for i, angle in enumerate(row):

            def off(reading: float, i: int = i, angle: float = angle) -> float:
                a = device.turns * reading
                zero, *waves = device.table[i, ZERO:]
                shapes = (math.cos(a), math.sin(a), math.cos(2 * a), math.sin(2 * a))
                return reading + zero + sum(w * s for w, s in zip(waves, shapes, strict=True)) - angle

            around = angle - device.table[i, ZERO]
            out[n, i] = brentq(off, around - 0.1, around + 0.1, xtol=1e-15)
    return out


def cube_points(design: Design, rng: np.random.Generator, count: int, share: float = 1.0) -> np.ndarray:
    """(count, 3) positions in the cube, m."""
    cube = design.workspace
    return cube.centre + share * cube.half_side * rng.uniform(-1.0, 1.0, (count, 3))


def measured(
    device: Unknowns, p: np.ndarray, rng: np.random.Generator, position: float = 0.02e-3, angle: float = 5e-5
) -> Poses:
    """Poses at positions with the noise of both; 5e-5 rad are 0.003 degrees."""
    noisy = readings(device, p) + rng.normal(0.0, angle, p.shape)
    return Poses(p + rng.normal(0.0, position, p.shape), noisy)


def poses_text(poses: Poses) -> str:
    """Poses as a table that the product reads."""
    lines = [",".join(COLUMNS)]
    for p, turns in zip(poses.positions * 1e3, np.degrees(poses.readings), strict=True):
        lines.append(",".join(f"{v:.9g}" for v in (*p, *turns)))
    return "\n".join(lines) + "\n"
