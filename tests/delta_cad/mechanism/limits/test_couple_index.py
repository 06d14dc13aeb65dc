"""The couple index against rods that are turned and singular values."""

from __future__ import annotations

import math
from functools import cache

import numpy as np
import pytest
from hypothesis import assume, given

from delta_cad.design.file import load_design
from delta_cad.mechanism import (
    Cube,
    DeltaGeometry,
    closure_margin,
    conditioning,
    direct_margin,
    elbow_positions,
    joint_angles,
    wrist_positions,
)
from delta_cad.mechanism.geometry import THREE_FOLD
from delta_cad.mechanism.limits import CoupleIndex
from delta_cad.mechanism.limits.couple_index import couple_index, least_singular_value
from delta_cad.mechanism.workspace import CubeSearch, cube_grid
from optimizer.certify.replay import breaks
from tests.committed import BEST
from tests.delta_cad.mechanism.limits.proving import verdict
from tests.delta_cad.mechanism.oracles import PROPERTY, mechanisms, placed_mechanisms, points

WIDTH = 0.05  # m, of the parallelograms that are turned
TURN = 1e-6  # rad; the error is its square


def rods_apart(g: DeltaGeometry, p: np.ndarray) -> np.ndarray:
    """(chain, axis) what a chain's one rod gets longer than the other where the platform turns, by width and angle."""
    elbows, wrists = elbow_positions(g, joint_angles(g, p)), wrist_positions(g, p)
    out = np.empty((3, 3))
    for axis in range(3):
        lengths = []
        for angle in (TURN, -TURN):
            c, s = math.cos(angle), math.sin(angle)
            j, k = (axis + 1) % 3, (axis + 2) % 3
            rotation = np.eye(3)
            rotation[j, j], rotation[j, k], rotation[k, j], rotation[k, k] = c, -s, s, c
            for side in (0.5, -0.5):
                ends = wrists + side * WIDTH * g.tangential
                turned = p + (ends - p) @ rotation.T
                lengths.append(np.linalg.norm(turned - elbows - side * WIDTH * g.tangential, axis=-1))
        out[:, axis] = (lengths[0] - lengths[1] - lengths[2] + lengths[3]) / (2.0 * TURN * WIDTH)
    return out


def six_rods(g: DeltaGeometry, p: np.ndarray) -> np.ndarray:
    """(6, 6) how fast each rod would lengthen with each velocity and turn of the platform, lengths by L_B."""
    elbows, wrists, rows = elbow_positions(g, joint_angles(g, p)), wrist_positions(g, p), []
    for i in range(3):
        n = (wrists[i] - elbows[i]) / g.forearm_length
        for side in (0.5, -0.5):
            arm = (wrists[i] + side * WIDTH * g.tangential[i] - p) / g.forearm_length
            rows.append([*n, *np.cross(arm, n)])
    return np.array(rows)


@PROPERTY
@given(mechanisms() | placed_mechanisms(), points())
def test_it_is_the_hold_of_rods_that_are_turned(g: DeltaGeometry, p: np.ndarray) -> None:
    assume((closure_margin(g, p) > 1e-7).all())
    hold = np.linalg.svd(rods_apart(g, p), compute_uv=False)[2]
    # central differences: the square of the angle, and roundings of 1e-16 m by width and angle
    assert couple_index(g, p) == pytest.approx(hold, abs=1e-8)


@PROPERTY
@given(mechanisms() | placed_mechanisms(), points())
def test_it_is_the_smallest_singular_value_of_the_couples(g: DeltaGeometry, p: np.ndarray) -> None:
    assume((closure_margin(g, p) > 1e-7).all())
    n = (wrist_positions(g, p) - elbow_positions(g, joint_angles(g, p))) / g.forearm_length
    values = np.linalg.svd(np.cross(g.tangential, n), compute_uv=False)
    # where both smaller ones vanish a rounding of the middle eigenvalue is all there is
    assert couple_index(g, p) == pytest.approx(values[2], abs=1e-13 / max(values[1], 1e-6))


def test_closed_form_at_random_at_double_values_and_at_zero() -> None:
    rng = np.random.default_rng(3)
    r, v = rng.normal(size=(2, 4_000, 3))
    r[:500], v[:500] = r[:500, :1], v[:500, :1]  # alike in all chains: two singular values meet
    r[500:1000] *= 1e-4
    v[1000:1500] *= 1e-4
    for phi in (95.0, 110.0, 120.0, 137.0):
        c = THREE_FOLD if phi == 120.0 else math.cos(math.radians(phi))
        slopes = r[1500:2000, :2] / v[1500:2000, :2]
        r[1500:2000, 2] = -v[1500:2000, 2] * (-2.0 * c * slopes[:, 0] + slopes[:, 1])  # README (48): det M = 0
        azimuth = np.radians([0.0, phi, -phi])
        couples = np.stack([v * np.cos(azimuth), v * np.sin(azimuth), -r], axis=-2)
        check_closed_form(r, v, c, np.linalg.svd(couples, compute_uv=False))
    assert least_singular_value(np.zeros(3), np.zeros(3), THREE_FOLD) == 0.0
    assert np.isnan(least_singular_value(np.array([np.nan, 1.0, 1.0]), np.ones(3), THREE_FOLD))


def check_closed_form(r: np.ndarray, v: np.ndarray, c: float, values: np.ndarray) -> None:
    found = least_singular_value(r, v, c)
    # the closed form's middle eigenvalue is off by roundings of the largest, 1e-16 l1, and divides the determinant
    allowed = 1e-14 * values[:, 0] + 1e-15 * values[:, 2] * (values[:, 0] / values[:, 1]) ** 2
    assert (np.abs(found - values[:, 2]) <= allowed).all()
    assert (found[1500:2000] < 1e-13 * values[1500:2000, 0] ** 3 / values[1500:2000, 1]).all()


def test_by_hand_on_the_axis() -> None:
    """All chains alike: 3 r^2 about z and 3/2 v^2 about x and y."""
    g = DeltaGeometry(0.03, 0.09, 0.06, 0.12)  # level arms at z = 0.12: rods upright
    assert couple_index(g, np.array([0.0, 0.0, 0.12])) == pytest.approx(0.0, abs=1e-15)
    g = DeltaGeometry(0.06, 0.048, 0.06, 0.12)  # level arms: wrists 0.072 = 0.6 L_B inside, 0.096 = 0.8 L_B up
    found = couple_index(g, np.array([[0.0, 0.0, 0.096], [0.0, 0.0, 0.3]]))
    assert found[0] == pytest.approx(math.sqrt(1.5) * 0.8, rel=1e-14)
    assert np.isnan(found[1])


def least_in_a_corner_of_the_floor(g: DeltaGeometry, cube: Cube) -> tuple[float, float]:
    """The least index on a grid, which a corner of the cube's floor must have, and that of the centre."""
    p = cube_grid(cube, 41).reshape(-1, 3)
    index = couple_index(g, p)
    np.testing.assert_allclose(np.abs(p[index.argmin()] - [0.0, 0.0, cube.bottom_height]), [*[cube.half_side] * 2, 0.0])
    centre = np.array([0.0, 0.0, cube.bottom_height + cube.half_side])
    return float(index.min()), float(couple_index(g, centre))


def test_the_optimum_of_the_former_task_holds_a_ninth_in_a_corner_of_the_floor() -> None:
    """0.115 at the worst and about 0.8 at the centre in a study by another program."""
    g, cube = DeltaGeometry(0.040, 0.030, 0.082, 0.122347), Cube(0.04773, 0.042047)
    assert least_in_a_corner_of_the_floor(g, cube) == pytest.approx((0.1153, 0.8125), abs=1e-4)


def test_the_committed_design_holds_what_is_required_and_no_more_in_a_corner_of_the_floor() -> None:
    """The limit decides its size: rounding to whole micrometres leaves some 2e-5."""
    design = load_design(BEST)
    cube = Cube(design.cube.bottom_height_mm / 1e3, design.cube.half_side_mm / 1e3)
    required = design.requirements.couple_index_min
    assert required == 0.4
    worst, middle = least_in_a_corner_of_the_floor(design.geometry, cube)
    assert required <= worst < required + 1e-4
    assert middle == pytest.approx(0.8934, abs=1e-4)


def test_what_conditioning_and_assembly_mode_do_not_see() -> None:
    """A cube with kappa below 20 and det S > 0 in which the six rods lose their hold of the platform."""
    seen = 0
    for g, cube, worst in designs():
        p = cube_grid(cube, 9).reshape(-1, 3)
        if worst.value > 1e-6 or direct_margin(g, p).min() < 0.0 or conditioning(g, p).max() > 20.0:
            continue
        seen += 1
        at = np.array(worst.position)
        assert np.linalg.cond(six_rods(g, at)) > 1e6 > 1e3 * conditioning(g, at)
        point = np.array(verdict(g, cube, CoupleIndex(1e-3)).point)
        assert breaks(g, CoupleIndex(1e-3), point)
    assert seen >= 2


@cache
def designs():
    """Random designs with the place of the smallest index that a search of the cube finds."""
    rng, found = np.random.default_rng(41), []
    while len(found) < 40:
        a, lb, bottom, half = rng.uniform([-0.02, 0.06, 0.02, 0.01], [0.04, 0.25, 0.2, 0.06])
        g, cube = DeltaGeometry(a + 0.05, 0.05, 0.082, lb), Cube(bottom, half)
        closed = closure_margin(g, cube_grid(cube, 9))
        if closed.min() > 1e-4:  # w > 10 mm: closer to a fold a proof takes seconds
            found.append((g, cube, CubeSearch(cube, 31)(lambda p, g=g: couple_index(g, p), 1.0)))
    return found
