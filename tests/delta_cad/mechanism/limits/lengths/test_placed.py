"""Closed forms over the lengths of placed machines against points and bars, turned about the base's axis one by one."""

from __future__ import annotations

import math

import numpy as np
import pytest

from delta_cad.mechanism.limits import BallClearance, ElbowOutside, Lean, Limit, Outline, WristClearance
from tests.delta_cad.mechanism.oracles import rotation

COUNT, WIDTH, OVERHEAD = 400, 48.0, (9.6, 13.2)  # of designs; mm
_RNG = np.random.default_rng(7)
PHI_DEG = _RNG.uniform(60.0, 150.0, COUNT)
LENGTHS = np.vstack(
    [
        _RNG.uniform([60, 90, 25, 15, 40, 10], [120, 180, 60, 40, 100, 60], (COUNT, 6)).T,
        _RNG.uniform(-20.0, 40.0, COUNT),
        np.cos(np.radians(PHI_DEG)),
        _RNG.uniform(-30.0, 30.0, COUNT),
    ]
)
"""(9, COUNT) L_A, L_B, R_0, r, H, L, R_1 - R_0, cos phi, x_c."""
LIMITS = [
    Outline(270.0, 220.0, WIDTH, OVERHEAD),
    Outline(270.0, 220.0, WIDTH, OVERHEAD, radius_max_mm=140.0),
    ElbowOutside(),
    WristClearance(2.0, 6.0, WIDTH),
    BallClearance(0.0, 6.0, WIDTH),
    Lean(0.5),
]


def margin(limit: Limit, lengths: np.ndarray) -> np.ndarray:
    found = limit.design_margin(lengths)
    assert found is not None
    return found


def turns(k: int) -> list[np.ndarray]:
    return [rotation(0.0), rotation(PHI_DEG[k]), rotation(-PHI_DEG[k])]


def bars(k: int, radii: np.ndarray) -> np.ndarray:
    """(3 chains, 2 ends, 3) bars of length L_c along the shoulder axes, so far out, mm."""
    ends = [[[radius, side * WIDTH, 0.0] for side in (-0.5, 0.5)] for radius in radii]
    return np.stack([np.array(pair) @ turn.T for pair, turn in zip(ends, turns(k), strict=True)])


def radii(k: int) -> np.ndarray:
    first, shift = LENGTHS[[2, 6], k]
    return np.array([first, first + shift, first + shift])


def test_the_outline_is_that_of_the_bars_at_the_elbows_of_level_arms() -> None:
    outline, turned, straight = LIMITS[0], 0, 0
    assert isinstance(outline, Outline)
    for k in range(COUNT):
        reach = LENGTHS[0, k] + radii(k)
        points = bars(k, reach).reshape(-1, 3)
        depth, width, _ = np.ptp(points, axis=0)
        found = outline.size_mm(reach[0], *LENGTHS[6:8, k])
        assert found == pytest.approx((width + OVERHEAD[0], depth + OVERHEAD[1]), rel=1e-13)
        rooms = [min((a - width - OVERHEAD[0]) / a, (b - depth - OVERHEAD[1]) / b) for a, b in ((270, 220), (220, 270))]
        assert margin(outline, LENGTHS[:, k : k + 1])[0] == pytest.approx(max(rooms), abs=1e-13)
        assert bool(outline.room(reach[0], *LENGTHS[6:8, k])[1]) == (rooms[1] > rooms[0])
        turned, straight = turned + (rooms[1] > rooms[0]), straight + (rooms[1] <= rooms[0])
        circle = margin(LIMITS[1], LENGTHS[:, k : k + 1])
        assert circle[0] == pytest.approx(1.0 - reach.max() / 140.0, abs=1e-14)
    assert min(turned, straight) > 0.1 * COUNT


@pytest.mark.parametrize("outline", LIMITS[:2], ids=["rectangle", "circle"])
def test_the_largest_reach_of_a_placement_leaves_no_room(outline: Outline) -> None:
    for shift, c in LENGTHS[6:8].T:
        largest = outline.largest_reach_mm(shift, c)
        assert outline.room(largest, shift, c)[0] == pytest.approx(0.0, abs=1e-14)
        assert outline.room(largest - 1.0, shift, c)[0] > 0.0


def test_the_nearest_wrists_are_those_that_stand_nearest() -> None:
    nearest = {(0, 1): 0, (1, 2): 0}
    for k in range(COUNT):
        r = LENGTHS[3, k]
        wrists = bars(k, np.full(3, r))
        distances = {
            pair: np.linalg.norm(wrists[pair[0]][:, None] - wrists[pair[1]][None], axis=-1).min() for pair in nearest
        }
        between = min(distances.values())
        found = margin(LIMITS[3], LENGTHS[:, k : k + 1])
        if found[0] * r + 8.0 > 0.0:  # else the bars cross
            nearest[min(distances, key=lambda pair: distances[pair])] += 1
            assert found[0] == pytest.approx((between - 8.0) / r, abs=1e-13)
        balls = LIMITS[4]
        assert isinstance(balls, BallClearance)
        widest = BallClearance(0.0, 6.0, balls.width_max_mm(r, LENGTHS[7, k]))
        assert margin(widest, LENGTHS[:, k : k + 1])[0] == pytest.approx(0.0, abs=1e-14)
    assert min(nearest.values()) > 0.1 * COUNT


def test_at_a_right_angle_the_wrists_of_the_side_chains_are_as_near_for_every_width() -> None:
    """At 90 degrees the rods of chains 1 and 2 lie along one line: what is between them does not depend on L_c."""
    lengths = LENGTHS[:, :1].copy()
    lengths[7] = 0.0
    r = lengths[3, 0]
    wide = BallClearance(0.0, 6.0, 1e-3)
    assert margin(wide, lengths)[0] == pytest.approx((np.sqrt(2.0) * r - np.sqrt(0.5) * 1e-3 - 6.0) / r)
    assert wide.width_max_mm(r, 0.0) == pytest.approx(2.0 * r - 6.0 * np.sqrt(2.0))


def test_every_elbow_is_outside_and_every_rod_leans_less_in_each_corner() -> None:
    for k in range(COUNT):
        L_A, L_B, _, r, H, L, _, _, centre = LENGTHS[:, k]
        outside = margin(LIMITS[2], LENGTHS[:, k : k + 1])
        assert outside[0] == pytest.approx(1.0 - r / (radii(k) + L_A).min() - 1e-6, abs=1e-14)
        corners = np.array([(centre + x, y, H + z) for x in (-L, L) for y in (-L, L) for z in (0.0, 2.0 * L)])
        along = np.abs([corners @ turn[:, 1] for turn in turns(k)]).max()
        assert margin(LIMITS[5], LENGTHS[:, k : k + 1])[0] == pytest.approx(np.sin(0.5) - along / L_B, abs=1e-13)


@pytest.mark.parametrize("limit", LIMITS, ids=lambda limit: limit.name)
def test_many_designs_at_once(limit: Limit) -> None:
    alone = [margin(limit, LENGTHS[:, k : k + 1])[0] for k in range(COUNT)]
    np.testing.assert_array_equal(margin(limit, LENGTHS), alone)


@pytest.mark.parametrize("limit", LIMITS, ids=lambda limit: limit.name)
def test_the_least_of_the_smooth_margins_is_the_margin(limit: Limit) -> None:
    parts = limit.smooth_margins(LENGTHS)
    assert parts is not None
    np.testing.assert_allclose(parts.min(axis=0), margin(limit, LENGTHS), rtol=0.0, atol=1e-15)


def test_a_symmetric_design_has_the_formulas_of_the_paper_to_the_last_bit() -> None:
    symmetric = LENGTHS.copy()
    symmetric[6:] = [[0.0], [-0.5], [0.0]]
    L_A, L_B, R, r, _, L = symmetric[:6]
    reach, root = R + L_A, math.sqrt(3.0)
    outline = LIMITS[0]
    assert isinstance(outline, Outline)
    width, depth = outline.size_mm(reach)
    np.testing.assert_array_equal(width, WIDTH * 0.5 + root * reach + OVERHEAD[0])
    np.testing.assert_array_equal(depth, WIDTH * root / 4.0 + 1.5 * reach + OVERHEAD[1])
    np.testing.assert_array_equal(margin(LIMITS[1], symmetric), (140.0 - reach) / 140.0)
    np.testing.assert_array_equal(margin(LIMITS[2], symmetric), 1.0 - r / reach - 1e-6)
    np.testing.assert_array_equal(margin(LIMITS[3], symmetric), (root * r - WIDTH / 2.0 - 6.0 - 2.0) / r)
    np.testing.assert_array_equal(margin(LIMITS[5], symmetric), math.sin(0.5) - (root + 1.0) / 2.0 * L / L_B)
