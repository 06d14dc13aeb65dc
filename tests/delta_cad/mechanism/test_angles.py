"""Lean of the rods and the angle at the elbow, against vectors and published figures."""

import numpy as np
import pytest
from hypothesis import assume, given

from delta_cad.mechanism import (
    Cube,
    DeltaGeometry,
    cube_surface,
    elbow_positions,
    forearm_angle,
    inverse_kinematics,
    rod_lean,
    wrist_positions,
)
from tests.delta_cad.mechanism.oracles import BOTTOM, HALF, PROPERTY, PUBLISHED, mechanisms, paper_h, points, rotation


def between(a, b):
    return np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b)


@PROPERTY
@given(mechanisms(), points())
def test_angles_between_the_links(g, p):
    assume((paper_h(g, p) < -1e-9).all())  # m^4: off the fold, where an arc cosine has half the digits
    theta = inverse_kinematics(g, p)
    elbows, wrists = elbow_positions(g, theta), wrist_positions(g, p)
    for i in range(3):
        turn = rotation(120.0 * i)
        forearm = wrists[i] - elbows[i]
        upper_arm = elbows[i] - turn @ [g.base_radius, 0, 0]
        sideways = turn @ [0, 1, 0]
        # an arc cosine near its end has half the digits; off the fold by 1e-9 m^4 that leaves nine
        assert forearm_angle(g, p)[i] == pytest.approx(between(upper_arm, forearm), abs=1e-9)
        assert rod_lean(g, p)[i] == pytest.approx(np.pi / 2 - between(sideways, forearm), abs=1e-7)


def test_lean_by_hand():
    # sideways by half the forearm's length leans chain 0 by 30 deg
    assert rod_lean(PUBLISHED, [0.0, 0.112079 / 2, 0.08])[0] == pytest.approx(np.pi / 6, rel=1e-14)
    assert rod_lean(PUBLISHED, [0.0, -0.112079 / 2, 0.08])[0] == pytest.approx(-np.pi / 6, rel=1e-14)
    np.testing.assert_allclose(rod_lean(PUBLISHED, [0.0, 0.0, 0.1]), 0.0, atol=0)


def test_elbow_angle_by_hand():
    g = DeltaGeometry(0.05, 0.05, 0.06, 0.08)
    np.testing.assert_allclose(forearm_angle(g, [0, 0, 0.10]), np.pi / 2, rtol=1e-14)  # 3-4-5
    # 0.2 um from the ends the angle is the root of that: some mrad
    np.testing.assert_allclose(forearm_angle(g, [0, 0, 0.14 - 2e-7]), 0.0, atol=5e-3)  # stretched
    np.testing.assert_allclose(forearm_angle(g, [0, 0, 0.02 + 2e-7]), np.pi, atol=5e-3)  # folded back


def test_unreachable_is_nan():
    assert np.isnan(rod_lean(PUBLISHED, [0, 0, 0.3])).all()
    assert np.isnan(forearm_angle(PUBLISHED, [0, 0, 0.3])).all()


def test_figures_of_the_published_design():
    p = cube_surface(Cube(BOTTOM, HALF), 41)
    lean, angle = np.degrees(rod_lean(PUBLISHED, p)), np.degrees(forearm_angle(PUBLISHED, p))
    # figures of an independent CAD study: lean to 0.1 deg, elbow angles to 1 deg, spacing of the rods to 0.001
    assert np.abs(lean).max() == pytest.approx(27.2, abs=0.05)
    assert np.cos(np.radians(lean)).min() == pytest.approx(0.889, abs=1e-3)
    assert angle.min() == pytest.approx(83, abs=0.5)
    assert angle.max() == pytest.approx(151, abs=0.5)
