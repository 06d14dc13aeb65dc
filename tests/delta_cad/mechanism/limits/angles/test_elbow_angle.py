"""The elbow's angle against vectors and a triangle; proofs, both ways, and what a search sees of it."""

from __future__ import annotations

import math

import numpy as np
import pytest

from delta_cad.mechanism import Cube, DeltaGeometry, elbow_positions, joint_angles
from delta_cad.mechanism.geometry import THREE_FOLD
from delta_cad.mechanism.inverse import forearm_angle
from delta_cad.mechanism.limits import ElbowAngle
from optimizer.certify.replay import breaks
from tests.delta_cad.mechanism.limits.proving import poses, verdict
from tests.delta_cad.mechanism.oracles import BOTTOM, HALF, PUBLISHED
from tests.optimizer.problem.figures_numpy import figures_numpy


def angles(g: DeltaGeometry, p: np.ndarray) -> np.ndarray:
    """Angles between the elbows' ways to shoulder and wrist, (3,), from placed joints."""
    elbows = elbow_positions(g, joint_angles(g, p))
    shoulders, wrists = g.base_radii[:, None] * g.radial, p + g.platform_radius * g.radial
    a, b = shoulders - elbows, wrists - elbows
    return np.arctan2(np.linalg.norm(np.cross(a, b), axis=-1), (a * b).sum(axis=-1))


def test_it_is_the_angle_between_the_ways_to_shoulder_and_wrist() -> None:
    figure = ElbowAngle.figures[0]
    for g, p in (*poses(np.random.default_rng(2), 200), *poses(np.random.default_rng(3), 100, placed=True)):
        limit = ElbowAngle(0.1)
        np.testing.assert_allclose(figure.values(limit, g, p), angles(g, p), rtol=1e-9)


def test_a_right_angle_by_hand() -> None:
    """The wrist stands straight above the elbow of a level arm: 3 and 4 make 5."""
    g = DeltaGeometry(0.03, 0.06, 0.03, 0.04)
    p = np.array([0.0, 0.0, 0.04])
    assert np.hypot(g.platform_radius - g.base_radius, p[2]) == pytest.approx(0.05)
    np.testing.assert_allclose(joint_angles(g, p), 0.0, atol=1e-12)
    assert ElbowAngle.figures[0].worst(ElbowAngle(0.0), g, p) == pytest.approx(math.pi / 2)
    assert breaks(g, ElbowAngle(math.pi / 2 + 1e-9), p)
    assert not breaks(g, ElbowAngle(math.pi / 2 - 1e-9), p)


def test_the_closest_point_of_the_cube_to_a_shoulder_decides() -> None:
    """The distance of wrist and shoulder is least there, and with it the angle: no other point folds further."""
    g, cube = PUBLISHED, Cube(BOTTOM, HALF)
    grid = np.stack(np.meshgrid(*[np.linspace(-1.0, 1.0, 41)] * 3), axis=-1).reshape(-1, 3)
    p = np.array([0.0, 0.0, BOTTOM + HALF]) + HALF * grid
    shoulder = g.radius_differences[:, None] * g.radial
    closest = np.clip(shoulder, [-HALF, -HALF, BOTTOM], [HALF, HALF, BOTTOM + 2.0 * HALF])
    least = min(math.pi - forearm_angle(g, closest[i])[i] for i in range(3))
    assert (math.pi - forearm_angle(g, p)).min() >= least - 1e-12
    assert verdict(g, cube, ElbowAngle(least - 1e-9)).verdict == "proved"


def test_a_search_sees_the_cosines_apart() -> None:
    design = np.array([[0.082, 0.112079, 0.040, 0.030, BOTTOM, HALF, 0.0, THREE_FOLD, 0.0]])
    points = np.array([[1.0, 0.5, -1.0], [0.0, 0.0, 0.0]])
    p = np.array([0.0, 0.0, BOTTOM + HALF]) + HALF * points
    limit = ElbowAngle(0.7)
    found = limit.margin(figures_numpy(design, points))[0]
    expected = [math.cos(0.7) - max(np.cos(angles(PUBLISHED, one))) for one in p]
    np.testing.assert_allclose(found, expected, rtol=1e-9)
