"""A cable's sleeves on their ways to their seats: beside the arm, and beside the foot block below it."""

from __future__ import annotations

from math import cos, radians, sin

import numpy as np

from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.capstan import CRIMP_MM, SLEEVE_OVER_MM, CapstanDimensions, sleeve_frames
from delta_cad.interference.shapes import Beam, Round, Shape, union_distance
from delta_cad.interference.static_obstacles import foot

_POINTS = 5  # along a sleeve
_WAY_MM = np.arange(0.0, 60.0, 2.0)  # of the second sleeve, from beside its seat outwards
_WAYS_RAD = [radians(15.0 * n) for n in range(7)]  # which it may come: from outside, up to along the cable's end
_FOOT_OFF_MM = 1.0  # that it leaves the foot block where it can


def _first(c: CapstanDimensions, y_mm: float) -> np.ndarray:
    """Gives points of the first sleeve's axis, (n, 3) in the arm's frame, as it passes a height along the shoulder's.

    It comes along that, past the arm.
    """
    frame = sleeve_frames(c)[0]
    along = np.linspace(0.0, CRIMP_MM[1], _POINTS)[:, None] * np.array([0.0, 0.0, 1.0])
    passed = frame[:3, 3] + along @ frame[:3, :3].T
    passed[:, 1] = y_mm
    return passed


def _second(c: CapstanDimensions, way_rad: float) -> np.ndarray:
    """Gives points of the second sleeve's axis on its way over its carriage, (n, 3) in the arm's frame."""
    frame = sleeve_frames(c)[1]
    along = np.linspace(0.0, CRIMP_MM[1], _POINTS)[:, None] * np.array([0.0, 0.0, 1.0])
    over = frame[:3, 3] + along @ frame[:3, :3].T
    over[:, 1] -= SLEEVE_OVER_MM
    out = cos(way_rad) * frame[:3, 0] + sin(way_rad) * frame[:3, 2]
    return (_WAY_MM[:, None, None] * out + over).reshape(-1, 3)


def second_way_rad(d: Dimensions, c: CapstanDimensions) -> float:
    """Finds the way that the second sleeve comes in the home pose, from outside towards the cable's end, rad.

    That from outside, where it passes the foot block; else the first that does, or the one that passes it best.
    """

    def off(way_rad: float) -> float:
        x, y, z = _second(c, way_rad).T
        cosine, sine = cos(d.home_rad), sin(d.home_rad)
        seen = np.stack([cosine * x - sine * z, y, sine * x + cosine * z], axis=1)
        return min(float(foot(d).signed_distance(seen).min()) - CRIMP_MM[0] / 2, _FOOT_OFF_MM)

    return max(_WAYS_RAD, key=off)


def ferrule_clearance_mm(d: Dimensions, c: CapstanDimensions) -> float:
    """Computes how near a cable's sleeves come to the upper arm, or the first to the sector's hub, mm.

    Args:
        d: The machine.
        c: Its capstan.
    """
    low, high = d.layers.arm_mm
    arm: list[Shape] = [
        Beam(d.arm.length_mm, (d.arm.beam_root_radius_mm, d.arm.boss_radius_mm), (low, high)),
        Round(d.arm.flange_radius_mm, (low, high)),  # of the hub nothing stands out beside the arm's plate
    ]
    points = np.concatenate([_first(c, (low + high) / 2), _second(c, second_way_rad(d, c))])
    return float(union_distance(arm, points).min()) - CRIMP_MM[0] / 2
