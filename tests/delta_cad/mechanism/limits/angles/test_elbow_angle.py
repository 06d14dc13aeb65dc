"""The elbow's angle against vectors and a triangle; proofs, both ways, and what a search sees of it."""

from __future__ import annotations

import math
from decimal import Decimal

import numpy as np
import pytest

from delta_cad.mechanism import Cube, DeltaGeometry, closure_margin, elbow_positions, joint_angles
from delta_cad.mechanism.enclosure.table import HIGH, LOW
from delta_cad.mechanism.geometry import RADIAL
from delta_cad.mechanism.inverse import forearm_angle
from delta_cad.mechanism.limits import ElbowAngle, Limits
from delta_cad.mechanism.proof.margins import BITS, FIRST, margins, numbers, room
from delta_cad.mechanism.proof.prove import prove
from delta_cad.mechanism.workspace import CubeSearch
from optimizer.certify.replay import breaks, replay
from tests.delta_cad.mechanism.limits.proving import leaves, poses, verdict
from tests.delta_cad.mechanism.oracles import BOTTOM, HALF, PUBLISHED
from tests.delta_cad.mechanism.proof.exact_oracle import exact_margins, samples
from tests.optimizer.problem.figures_numpy import figures_numpy


def angles(g: DeltaGeometry, p: np.ndarray) -> np.ndarray:
    """Angles between the elbows' ways to shoulder and wrist, (3,), from placed joints."""
    elbows = elbow_positions(g, joint_angles(g, p))
    shoulders, wrists = g.base_radius * RADIAL, p + g.platform_radius * RADIAL
    a, b = shoulders - elbows, wrists - elbows
    return np.arctan2(np.linalg.norm(np.cross(a, b), axis=-1), (a * b).sum(axis=-1))


def test_it_is_the_angle_between_the_ways_to_shoulder_and_wrist() -> None:
    figure = ElbowAngle.figures[0]
    for g, p in poses(np.random.default_rng(2), 200):
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


@pytest.mark.parametrize("size", [0.0, 1e-4, 3e-3])
def test_enclosures_hold_the_margins_of_their_boxes(size: float) -> None:
    rng = np.random.default_rng(7)
    for g, p in poses(rng, 40):
        limit = ElbowAngle(rng.uniform(0.2, 2.5))
        pose, work, out = room()
        margins(np.array([*p, size, size, size, 0.0]), numbers(g, Limits.of(limit)), BITS[ElbowAngle], pose, work, out)
        low, high = (out[FIRST[ElbowAngle] :, side][:3] for side in (LOW, HIGH))
        for point in samples(np.array([*p, size, size, size]), rng, 10):
            found = exact_margins(g, Limits.of(limit), tuple(map(float, point)))[ElbowAngle]
            for value, least, most in zip(found, low, high, strict=True):
                assert value is None or math.isnan(least) or Decimal(least) <= value <= Decimal(most)


def test_random_designs_are_proved_just_above_and_refuted_just_below() -> None:
    tried = 0
    for g, p in poses(np.random.default_rng(11), 20, 4e-4):
        cube = Cube(p[2], 0.012)
        search = CubeSearch(cube, 21)
        if search(lambda p, g=g: closure_margin(g, p).min(axis=-1), 1.0).value < 1e-5:
            continue
        tried += 1
        least = search(lambda p, g=g: ElbowAngle.figures[0].worst(ElbowAngle(0.0), g, p), 1.0)
        below, above = ElbowAngle(least.value - 1e-3), ElbowAngle(least.value + 1e-3)
        proof = prove(g, cube, Limits.of(below))
        assert next(f for f in proof.findings if f.condition == "elbow_angle").verdict == "proved"
        found = verdict(g, cube, above)
        assert found.verdict == "refuted"
        assert least.value * (1.0 - 1e-9) <= found.value < above.angle_min
        assert breaks(g, above, np.array(found.point))
        low, high = leaves(cube, proof.leaves)
        assert replay(g, [below], low, high)[1] is None
        assert replay(g, [above], low, high, max_boxes=4_000)[1] is not None
    assert tried > 5


def test_the_closest_point_of_the_cube_to_a_shoulder_decides() -> None:
    """The distance of wrist and shoulder is least there, and with it the angle: no other point folds further."""
    g, cube = PUBLISHED, Cube(BOTTOM, HALF)
    grid = np.stack(np.meshgrid(*[np.linspace(-1.0, 1.0, 41)] * 3), axis=-1).reshape(-1, 3)
    p = np.array([0.0, 0.0, BOTTOM + HALF]) + HALF * grid
    shoulder = (g.base_radius - g.platform_radius) * RADIAL
    closest = np.clip(shoulder, [-HALF, -HALF, BOTTOM], [HALF, HALF, BOTTOM + 2.0 * HALF])
    least = min(math.pi - forearm_angle(g, closest[i])[i] for i in range(3))
    assert (math.pi - forearm_angle(g, p)).min() >= least - 1e-12
    assert verdict(g, cube, ElbowAngle(least - 1e-9)).verdict == "proved"


def test_a_search_sees_the_cosines_apart() -> None:
    design = np.array([[0.082, 0.112079, 0.040, 0.030, BOTTOM, HALF]])
    points = np.array([[1.0, 0.5, -1.0], [0.0, 0.0, 0.0]])
    p = np.array([0.0, 0.0, BOTTOM + HALF]) + HALF * points
    limit = ElbowAngle(0.7)
    found = limit.margin(figures_numpy(design, points))[0]
    expected = [math.cos(0.7) - max(np.cos(angles(PUBLISHED, one))) for one in p]
    np.testing.assert_allclose(found, expected, rtol=1e-9)
