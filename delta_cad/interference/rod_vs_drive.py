"""Clearance of rods and springs to their own drive: motor, cheeks, encoder board, and the arm with its sector."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import product
from math import cos, degrees, pi, radians, sqrt

import numpy as np

from delta_cad.common.units import MM_PER_M
from delta_cad.dimensions import Dimensions, Reason, link_placement
from delta_cad.dimensions.rules import ARM, BOTTOM, FOREARM, larger, smaller
from delta_cad.interference.moving_bodies import (
    FAR_MM,
    FEW,
    ROUGH,
    DistanceField,
    arm_alone,
    arm_shapes,
    nearest,
    rod_points,
    spring_points,
)
from delta_cad.interference.shapes import Shape, union_distance
from delta_cad.interference.static_obstacles import board, cheeks, motor
from delta_cad.mechanism.errors import UnreachableError
from delta_cad.mechanism.placement import CHAINS, SIDES, chain_frame

WIDEST_RAD = radians(60.0)  # at an elbow, that rods may be asked to keep off a drive by


def drive_clearances(d: Dimensions) -> tuple[DistanceField, DistanceField]:
    """Gives how near rods and the springs across them come to their own chain's drive, over positions.

    First to what stands, cheeks, motor and the encoder's board; then to the arm with its sector. Each is nearest
    somewhere else.
    """
    shoulder = np.eye(4)
    shoulder[0, 3] = d.bracket.shoulder_u_mm
    turns = arm_shapes(d, d.capstan) if d.capstan else arm_alone(d)
    return _beside(d, [*cheeks(d), motor(d), *board(d)], shoulder), _beside(d, turns, None)


def _beside(d: Dimensions, shapes: Sequence[Shape], shoulder: np.ndarray | None) -> DistanceField:
    """How near rods and springs come to shapes of their chain: in the shoulder's frame, or None: in the arm's."""
    moving = {"rod": rod_points(d.forearm), "spring": spring_points(d)}
    inside, outside = d.layers.encoder_board_mm[0], d.layers.motor_cheek_mm[1] + d.motor.length_mm
    pairs = [*product(CHAINS, SIDES, moving)]

    def apart(positions_mm: np.ndarray, rough: bool, only: int | None) -> np.ndarray:
        placed = link_placement(d)(positions_mm)
        some, off = slice(None, None, ROUGH if rough else 1), []
        for i, side, link in pairs if only is None else [pairs[only]]:
            points, radii = (held[some] for held in moving[link])
            level, frame = chain_frame(i), placed[f"{link}_{i}_{side}"]
            turned = level[:3, :3] if link == "spring" else frame[:, :3, :3]  # all that it strays is level
            at = points @ np.swapaxes(turned, -2, -1) + frame[:, None, :3, 3]
            beside = np.broadcast_to(radii, at.shape[:2])
            inverse = np.linalg.inv(placed[f"upper_arm_{i}"] if shoulder is None else level @ shoulder)
            seen = at @ np.swapaxes(inverse[..., :3, :3], -2, -1) + inverse[..., None, :3, 3]
            y, found = seen[..., 1], np.full(at.shape[:2], FAR_MM)
            near = np.maximum(inside - y, y - outside) - beside < FAR_MM
            if near.any():
                found[near] = np.minimum(union_distance(shapes, seen[near]) - beside[near], FAR_MM)
            off.append(found.min(axis=1))
        return np.stack(off, axis=1)

    return apart


def fold_interference(d: Dimensions, least_mm: float) -> Iterator[Reason]:
    """Gives the reason why rods that fold onto their own drive are too near.

    Args:
        d: The machine.
        least_mm: Least distance between them.
    """
    cube, long, forearm = d.design.cube, d.arm.length_mm, d.forearm.length_mm
    drive = drive_clearances(d)

    def lacks(bottom_mm: float) -> float:
        try:
            return least_mm - min(nearest(apart, bottom_mm, cube.half_side_mm, FEW) for apart in drive)
        except UnreachableError:  # so high does not fold
            return 0.0

    lacking = lacks(cube.bottom_height_mm)
    if lacking <= 0.0:
        return
    sharpest = d.travel.forearm_angle_max
    bottom, fold, lowest = cube.bottom_height_mm, pi - sharpest.value, sharpest.position[2] * MM_PER_M
    # |AB|^2 = L_A^2 + L_B^2 - 2 L_A L_B cos(fold), of which a higher cube changes z^2 alone
    opened = 2.0 * long * forearm * max(cos(fold) - cos(WIDEST_RAD), 0.0)
    if fold >= WIDEST_RAD or lacks(bottom + sqrt(lowest**2 + opened) - lowest) > 0.0:
        return  # no height parts them: it is not for the fold
    own = f"what holds {d.motor.id}, or their arm" if d.capstan is None else "their own drive, its arm or its sector"
    message = (
        f"rods that fold to {degrees(fold):.1f} deg, or springs across them, come within {least_mm - lacking:.2f} mm "
        f"of {own}; at least {least_mm:.2f}"
    )
    yield Reason("rod_tube", "beside the drive", message, (larger(BOTTOM), larger(FOREARM), smaller(ARM)))
