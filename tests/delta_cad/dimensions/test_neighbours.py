"""What runs beside a motor, against sampled outlines and placed joints; the bounds that are named are the bounds."""

from __future__ import annotations

from dataclasses import replace
from math import pi

import numpy as np
import pytest
from scipy.spatial import ConvexHull

from delta_cad.dimensions import DimensionError, Dimensions
from delta_cad.dimensions.bracket import BOARD_EDGE_MM, Circle, require_room_for_boss
from delta_cad.dimensions.rules import RUNNING_GAP_MM, STOP_MARGIN_RAD
from delta_cad.mechanism import elbow_positions, inverse_kinematics
from tests.delta_cad.dimensions.edited import edited

DIRECT: dict[str, float | str] = {"drive": "direct", "motor": "maxon-ec60flat-625858", "arm_thickness_mm": 14.0}
NARROW: dict[str, float | str] = DIRECT | {"arm_thickness_mm": 9.0, "base_radius_mm": 45.0}


def room_mm(d: Dimensions, length_mm: float) -> float:
    """Least distance of an elbow's boss between its stops from both cheeks, by points all around their circles."""
    half = d.encoder.hole_spacing_width_mm / 2, d.encoder.hole_spacing_length_mm / 2
    board = [(sx * half[0], sz * half[1], BOARD_EDGE_MM) for sx in (-1, 1) for sz in (-1, 1)]
    encoder: list[Circle] = [(0.0, 0.0, d.bracket.head_radius_mm), *board, *d.bracket.foot_circles_mm]
    turns = np.linspace(0.0, 2.0 * pi, 4000)
    low, high = d.extremes.shoulder_min.value - STOP_MARGIN_RAD, d.extremes.shoulder_max.value + STOP_MARGIN_RAD
    angles = np.linspace(low, high, 500)
    elbows = length_mm * np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    found = []
    for circles in (d.bracket.motor_cheek_circles_mm, encoder):
        points = np.concatenate([[[x + r * np.cos(a), z + r * np.sin(a)] for a in turns] for x, z, r in circles])
        hull = points[ConvexHull(points).vertices]
        ways = np.roll(hull, -1, axis=0) - hull
        share = np.clip(((elbows[:, None] - hull) * ways).sum(-1) / (ways**2).sum(-1), 0.0, 1.0)
        found.append(np.linalg.norm(elbows[:, None] - hull - share[..., None] * ways, axis=-1).min())
    return min(found) - d.arm.boss_radius_mm


def test_the_arm_of_a_direct_drive_is_as_long_as_its_cheeks_ask() -> None:
    d = edited(**NARROW)
    assert d.layers.elbow_boss_mm[1] > d.layers.motor_cheek_mm[0]
    half = d.encoder.hole_spacing_width_mm / 2, d.encoder.hole_spacing_length_mm / 2
    shoulder = d.extremes.shoulder_min.value, d.extremes.shoulder_max.value
    short = replace(d.arm, length_mm=40.0)
    with pytest.raises(DimensionError) as refused:
        require_room_for_boss(short, d.bracket, shoulder, d.layers, (*half, BOARD_EDGE_MM))
    (reason,) = refused.value.reasons
    assert reason.field == "mechanism.upper_arm_length_mm"
    low, high = 40.0, 80.0
    for _ in range(9):
        middle = (low + high) / 2.0
        low, high = (low, middle) if room_mm(d, middle) >= RUNNING_GAP_MM else (middle, high)
    require_room_for_boss(replace(d.arm, length_mm=high), d.bracket, shoulder, d.layers, (*half, BOARD_EDGE_MM))
    with pytest.raises(DimensionError):
        require_room_for_boss(
            replace(d.arm, length_mm=low - 0.05), d.bracket, shoulder, d.layers, (*half, BOARD_EDGE_MM)
        )
    assert room_mm(d, 40.0) < 0.0


def test_rods_come_no_closer_to_the_shoulders_axis_than_their_angle_says() -> None:
    """At the position of the sharpest elbow, in the chain's plane: the line through elbow and wrist."""
    d = edited(**DIRECT, base_radius_mm=45.0)
    g, e = d.design.geometry, d.extremes.forearm_angle_max
    p = np.array(e.position)
    elbow = elbow_positions(g, inverse_kinematics(g, p))[0] - [g.base_radius, 0.0, 0.0]
    wrist = p + np.array([g.platform_radius - g.base_radius, 0.0, 0.0])
    a, b = elbow[[0, 2]], wrist[[0, 2]]
    off = abs((b - a)[0] * a[1] - (b - a)[1] * a[0]) / np.linalg.norm(b - a)
    assert off == pytest.approx(g.upper_arm_length * np.sin(pi - e.value), rel=1e-2)
