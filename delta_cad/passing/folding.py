"""Rods and springs of a direct drive beside what holds its own motor, which is round about the shoulder's axis."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product
from math import asin, cos, degrees, pi, sin, sqrt

import numpy as np

from delta_cad.common.units import MM_PER_M
from delta_cad.dimensions import Dimensions, Reason, link_placement
from delta_cad.dimensions.rules import up
from delta_cad.mechanism.placement import CHAINS, SIDES, chain_frame
from delta_cad.passing.moving import FAR_MM, FEW, Apart, nearest, rod_points, spring_points
from delta_cad.passing.shapes import off_all_mm
from delta_cad.passing.standing import cheeks, motor

ELBOW_FIELD = "requirements.elbow_angle_min_deg"


def beside_own_motor(d: Dimensions) -> Apart:
    """Gives how near rods and the springs across them come to their own chain's motor and its cheek, over positions."""
    moving = {"rod": rod_points(d.forearm), "spring": spring_points(d)}
    stands = [cheeks(d)[0], motor(d)]
    out = np.array([d.bracket.shoulder_u_mm, 0.0, 0.0])

    def apart(positions_mm: np.ndarray, rough: bool, only: int | None) -> np.ndarray:
        del rough, only
        placed = link_placement(d)(positions_mm)
        found = np.full(len(positions_mm), FAR_MM)
        for i, side, (link, (points, radii)) in product(CHAINS, SIDES, moving.items()):
            frame = placed[f"{link}_{i}_{side}"]
            turned = chain_frame(i)[:3, :3] if link == "spring" else frame[:, :3, :3]  # all that it strays is level
            at = points @ np.swapaxes(turned, -2, -1) + frame[:, None, :3, 3]
            off = off_all_mm(stands, at @ chain_frame(i)[:3, :3] - out) - radii
            found = np.minimum(found, off.min(axis=1))
        return found[:, None]

    return apart


def folded(d: Dimensions, least_mm: float) -> Iterator[Reason]:
    """Gives the reason why rods that fold onto their own motor are too near, with the height that is high enough.

    Off the shoulder's axis they are `L_A sin(elbow)`: what they lack there is what the angle is wider by.

    Args:
        d: The machine, of direct drives.
        least_mm: What is to be between them.
    """
    cube, long, forearm = d.design.cube, d.arm.length_mm, d.forearm.length_mm
    lacking = least_mm - nearest(beside_own_motor(d), cube.bottom_height_mm, cube.half_side_mm, FEW)
    if lacking <= 0.0:
        return
    sharpest = d.travel.forearm_angle_max
    fold, lowest = pi - sharpest.value, sharpest.position[2] * MM_PER_M
    needed = asin(min(sin(fold) + lacking / long, 1.0))
    # |AB|^2 = L_A^2 + L_B^2 - 2 L_A L_B cos(fold), of which a higher cube changes z^2 alone
    bottom = cube.bottom_height_mm
    bound = bottom + sqrt(lowest**2 + 2.0 * long * forearm * max(cos(fold) - cos(needed), 0.0)) - lowest
    message = (
        f"rods that fold to {degrees(fold):.1f} deg, or springs across them, come within {least_mm - lacking:.2f} mm "
        f"of what holds {d.motor.id}, at least {least_mm:.2f}: cube.bottom_height_mm = {bottom:g} must be at least "
        f"{up(bound)} mm, or hardware.motor smaller, or with {ELBOW_FIELD} = {degrees(needed):.1f} other lengths"
    )
    field, instead = "cube.bottom_height_mm", (ELBOW_FIELD, degrees(needed))
    yield Reason("rod_tube", "beside the motor", message, field, bottom, bound, instead=instead)
