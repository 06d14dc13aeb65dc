"""Forward kinematics against a root finder on the paper's equation, cases by hand and its degenerate ends."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from scipy.optimize import root

from delta_cad.mechanism import (
    BranchError,
    DeltaGeometry,
    SingularError,
    UnreachableError,
    closure_margin,
    direct_margin,
    forward_kinematics,
    inverse_kinematics,
    joint_angles,
    platform_positions,
)
from tests.delta_cad.mechanism.oracles import PROPERTY, PUBLISHED, mechanisms, paper_h, paper_residual, points, rotation

ANGLES = st.tuples(*[st.floats(-1.0, 1.3)] * 3).map(np.array)
NONE = np.full(3, np.nan)


def on_branch(g, theta, p):
    """Whether the position lies over the base and its own angles are those given: a round trip, not a sign of w."""
    assume(np.abs(closure_margin(g, p)).min() > 1e-9)  # m^2: not on the fold, where roundings rule
    assume(abs(p[2]) > 1e-9)
    assume(direct_margin(g, p) > 1e-9)
    return p[2] > 0.0 and np.abs(np.exp(1j * joint_angles(g, p)) - np.exp(1j * theta)).max() < 1e-6


@PROPERTY
@given(mechanisms(), ANGLES)
def test_position_closes_the_paper_equation_above_the_elbows(g, theta):
    p = platform_positions(g, theta)
    assume(np.isfinite(p).all())
    np.testing.assert_array_equal(forward_kinematics(g, theta, off_branch="nan"), p if on_branch(g, theta, p) else NONE)
    centres = np.array(
        [
            rotation(120 * i) @ [g.base_radius - g.platform_radius + g.upper_arm_length * np.cos(theta[i]), 0, 0]
            for i in range(3)
        ]
    )
    centres[:, 2] = g.upper_arm_length * np.sin(theta)
    normal = np.cross(centres[1] - centres[0], centres[2] - centres[0])
    height = (p - centres[0]) @ normal / np.linalg.norm(normal)
    assert height >= -1e-15  # m: zero to rounding at the direct singularity
    # m^2; a thin triangle of centres multiplies the rounding of its circumcentre
    thin = np.prod(np.linalg.norm(centres - np.roll(centres, 1, axis=0), axis=1)) / np.linalg.norm(normal) ** 1.5
    np.testing.assert_allclose(paper_residual(g, theta, p), 0.0, atol=1e-14 * max(1.0, thin) ** 2)


@PROPERTY
@given(points(reach=0.035, top=0.13))
def test_root_finder_arrives_at_the_same_position(p):
    assume((paper_h(PUBLISHED, p) < 0).all())
    theta = inverse_kinematics(PUBLISHED, p)
    assume(direct_margin(PUBLISHED, p) > 0.05)  # the other side belongs to the platform below the elbows

    def equations(q):  # scaled to lengths, so that the root finder's tolerance is one
        return paper_residual(PUBLISHED, theta, q) / PUBLISHED.forearm_length

    found = root(equations, p + np.array([0.004, -0.003, 0.005]), tol=1e-14)
    assume(np.linalg.norm(equations(found.x)) < 1e-13)
    # m; residuals of 1e-13 m over a determinant of 0.05
    np.testing.assert_allclose(forward_kinematics(PUBLISHED, theta), found.x, atol=1e-11)


@PROPERTY
@given(mechanisms(), points())
def test_round_trip_above_the_elbows(g, p):
    assume((paper_h(g, p) < -1e-8).all())  # m^4: not on the fold, where the angle is a root of a rounding
    det = direct_margin(g, p)
    assume(abs(det) > 1e-3)
    theta = joint_angles(g, p)
    back = platform_positions(g, theta)
    if det > 0:
        np.testing.assert_allclose(back, p, atol=1e-11)  # m; roundings over a determinant of 1e-3
        if p[2] > 0.0:
            np.testing.assert_array_equal(forward_kinematics(g, theta), back)
    else:
        assert np.linalg.norm(back - p) > 1e-6  # the other assembly is not taken for this one
        np.testing.assert_allclose(paper_residual(g, theta, back), 0.0, atol=1e-12)


def test_turning_the_angles_turns_the_position():
    theta = np.array([0.1, 0.4, -0.2])
    np.testing.assert_allclose(
        forward_kinematics(PUBLISHED, np.roll(theta, 1)),
        rotation(120) @ forward_kinematics(PUBLISHED, theta),
        atol=1e-16 * 8,
    )
    np.testing.assert_allclose(
        forward_kinematics(PUBLISHED, theta[[0, 2, 1]]),
        forward_kinematics(PUBLISHED, theta) * [1, -1, 1],
        atol=1e-16 * 8,
    )


def test_level_arms_by_hand():
    # centres on a circle of R - r + L_A = 92 mm
    p = forward_kinematics(PUBLISHED, np.zeros(3))
    np.testing.assert_allclose(p, [0, 0, np.sqrt(0.112079**2 - 0.092**2)], atol=1e-16 * 8)


def test_forearms_too_short_are_refused():
    g = DeltaGeometry(0.04, 0.03, 0.082, 0.090)  # level arms need 92 mm
    with pytest.raises(UnreachableError, match=r"2\.000 mm"):
        forward_kinematics(g, np.zeros(3))
    assert np.isnan(platform_positions(g, np.zeros(3))).all()


def test_collinear_or_coinciding_centres_are_refused():
    g = DeltaGeometry(0.03, 0.03 + 0.08, 0.08, 0.12)  # level arms put all three centres on the axis
    with pytest.raises(SingularError):
        forward_kinematics(g, np.zeros(3))
    assert np.isnan(platform_positions(g, np.zeros(3))).all()
    # two centres moved in to the axis at equal height, the third anywhere: two points make a line as well
    with pytest.raises(SingularError):
        forward_kinematics(g, np.array([0.0, 0.0, 0.3]))


@pytest.mark.parametrize("value", [np.nan])
def test_angles_that_are_not_numbers_are_refused(value):
    with pytest.raises(SingularError):
        forward_kinematics(PUBLISHED, [0.0, value, 0.0])


# a kinematics library's lengths; its users found other angles than they had given, beyond the fold at 91 deg
LIBRARY = DeltaGeometry(0.063, 0.035, 0.130, 0.400)


@pytest.mark.parametrize("degrees", [110.0, 200.0])
def test_arms_past_their_fold_are_refused_by_their_index_or_masked(degrees):
    past, sound = np.full(3, np.radians(degrees)), np.full(3, 0.3)
    back = np.degrees(joint_angles(LIBRARY, platform_positions(LIBRARY, past)))
    assert np.abs(back - degrees).min() > 30.0  # not the angles given
    if degrees == 110.0:
        assert back == pytest.approx(76.14, abs=5e-3)
    with pytest.raises(BranchError, match=rf"theta = \({degrees:.3f}, .*\) deg: .*past its fold"):
        forward_kinematics(LIBRARY, past)
    with pytest.raises(BranchError, match=rf"theta\[1\] = \({degrees:.3f}, "):
        forward_kinematics(LIBRARY, [sound, past, sound])
    masked = forward_kinematics(LIBRARY, [sound, past, sound], off_branch="nan")
    assert np.isnan(masked).all(axis=-1).tolist() == [False, True, False]
    np.testing.assert_array_equal(masked[0], forward_kinematics(LIBRARY, sound))


def test_arms_that_hang_hold_a_platform_below_the_base_which_is_refused():
    g, below_elbows = DeltaGeometry(0.03, 0.06, 0.10, 0.08), np.full(3, np.radians(-85.0))
    # elbows at a radius of 30 + 8.716 mm and a height of -99.619 mm; moved in by 60 mm the forearms meet over them
    height = np.sqrt(0.08**2 - (0.03 - 0.1 * np.cos(below_elbows[0])) ** 2)
    p = platform_positions(g, below_elbows)
    np.testing.assert_allclose(p, [0.0, 0.0, height + 0.1 * np.sin(below_elbows[0])], atol=1e-15)
    assert p[2] < 0.0
    np.testing.assert_allclose(joint_angles(g, p), below_elbows, atol=1e-12)  # all but z is as on the branch
    with pytest.raises(BranchError, match=r"\(-85\.000, .* deg: .*z <= 0"):
        forward_kinematics(g, below_elbows)


def test_what_does_not_meet_is_masked_too():
    g = DeltaGeometry(0.04, 0.03, 0.082, 0.090)
    theta = [np.zeros(3), np.full(3, 0.8), np.full(3, np.inf)]
    assert np.isnan(forward_kinematics(g, theta, off_branch="nan")).all(axis=-1).tolist() == [True, False, True]
