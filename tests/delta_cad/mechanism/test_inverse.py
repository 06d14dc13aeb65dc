"""Inverse kinematics and the links' angles against the paper, vectors, symmetry, cases by hand and its own edge."""

import re

import numpy as np
import pytest
from hypothesis import assume, given

from delta_cad.mechanism import (
    BranchError,
    Cube,
    DeltaGeometry,
    GeometryError,
    UnreachableError,
    closure_margin,
    cube_surface,
    direct_margin,
    elbow_positions,
    forearm_angle,
    forearm_vectors,
    forward_kinematics,
    inverse_kinematics,
    joint_angles,
    platform_positions,
    reach_excess,
    rod_lean,
    wrist_positions,
)
from tests.delta_cad.mechanism.oracles import (
    BOTTOM,
    EPS,
    HALF,
    PROPERTY,
    PUBLISHED,
    edge_of_reach,
    mechanisms,
    paper_angles,
    paper_h,
    paper_residual,
    points,
    rotation,
)

MIRROR = np.array([1.0, -1.0, 1.0])
SAFE = 1e-6  # m^2: a margin of 1 mm^2, where roundings of 1e-17 m^2 turn the angle by 1e-13 rad at most


def check_symmetry(ik, g, p):
    """Turning the position by 120 deg hands each angle on to the next chain; y -> -y exchanges chains 1 and 2."""
    theta = ik(g, p)
    np.testing.assert_allclose(ik(g, rotation(120.0) @ p), np.roll(theta, 1), rtol=0, atol=1e-9)
    np.testing.assert_allclose(ik(g, p * MIRROR), theta[[0, 2, 1]], rtol=0, atol=1e-9)


def check_outward(ik, g, p):
    """Of the two roots of the paper's quadratic the elbow farther out is taken."""
    wanted = paper_angles(g, p)[:, 0]
    # half-angle tangents lose digits near pi; directions are compared, so that 2 pi does not matter
    np.testing.assert_allclose(np.exp(1j * ik(g, p)), np.exp(1j * wanted), rtol=0, atol=1e-9)


@PROPERTY
@given(mechanisms(), points())
def test_margin_is_the_papers_h(g, p):
    scale = 4 * g.upper_arm_length**2
    size = scale * (np.linalg.norm(p) + g.base_radius + g.platform_radius + g.forearm_length + g.upper_arm_length) ** 2
    # both are differences of squares of `size`: some tens of roundings of that
    np.testing.assert_allclose(-scale * closure_margin(g, p), paper_h(g, p), rtol=0, atol=100 * EPS * size * 4)


@PROPERTY
@given(mechanisms(), points())
def test_margin_and_reach_excess_agree(g, p):
    w2, excess = closure_margin(g, p), reach_excess(g, p)
    clear = np.abs(excess) > 1e-9  # m; nearer than a nanometre rounding may decide
    np.testing.assert_array_equal((w2 < 0)[clear], (excess > 0)[clear])


@PROPERTY
@given(mechanisms(), points())
def test_angles_close_the_paper_equation_and_keep_the_elbows_out(g, p):
    assume((paper_h(g, p) < -4 * g.upper_arm_length**2 * SAFE).all())
    theta = joint_angles(g, p)
    # m^2; lengths below 0.5 m squared, some tens of roundings
    np.testing.assert_allclose(paper_residual(g, theta, p), 0.0, atol=1e-14)
    check_outward(joint_angles, g, p)
    check_symmetry(joint_angles, g, p)
    masked = inverse_kinematics(g, p, off_branch="nan")
    on = p[2] > 0.0 and direct_margin(g, p) > 0.0
    np.testing.assert_array_equal(masked, theta if on else np.full(3, np.nan))


@PROPERTY
@given(mechanisms(), points())
def test_forearm_runs_from_elbow_to_wrist(g, p):
    assume((paper_h(g, p) < 0).all())
    s = forearm_vectors(g, p)
    between = wrist_positions(g, p) - elbow_positions(g, joint_angles(g, p))
    # m; sines and cosines go through the angle and back: some roundings of 0.3 m
    np.testing.assert_allclose(s, between, atol=1e-14)
    # at the edge w is the root of a rounding, 1e-9 m, and the length keeps w^2: 1e-14 m stands again
    np.testing.assert_allclose(np.linalg.norm(s, axis=-1), g.forearm_length, atol=1e-13)


@PROPERTY
@given(mechanisms(), points(), points(reach=0.6, top=0.9))
def test_close_to_the_edge_of_reach(g, p, far):
    assume((paper_h(g, p) < 0).all())
    assume((paper_h(g, far) > 0).any())
    edge = edge_of_reach(g, p, far)
    margin = closure_margin(g, edge).min()
    assert abs(margin) < 1e-14  # m^2: the edge of the paper's h is ours, to rounding
    step = 1e-6 * (p - edge) / np.linalg.norm(p - edge)  # a micrometre
    assume((paper_h(g, edge + step) < 0).all())
    theta = joint_angles(g, edge + step)
    np.testing.assert_allclose(paper_residual(g, theta, edge + step), 0.0, atol=1e-14)
    if (paper_h(g, edge - step) > 1e-15).any():  # m^4: beyond rounding
        with pytest.raises(UnreachableError):
            inverse_kinematics(g, edge - step)
        assert np.isnan(joint_angles(g, edge - step)).any()


def test_on_the_axis_by_hand():
    # R = r: shoulder, elbow, wrist in a vertical plane; 3-4-5 triangle: L_A 3, L_B 4, height 5 (times 20 mm)
    g = DeltaGeometry(0.05, 0.05, 0.06, 0.08)
    theta = inverse_kinematics(g, [0.0, 0.0, 0.10])
    # the right angle at the elbow: the upper arm's height is 3 * 3/5, its reach 3 * 4/5
    np.testing.assert_allclose(theta, np.arctan2(3.0, 4.0), rtol=1e-15 * 8)
    np.testing.assert_allclose(closure_margin(g, [0.0, 0.0, 0.10]), 0.08**2, rtol=1e-14)


def test_level_arms_by_hand():
    # level arms, vertical forearms: the platform in the centre at the forearm's height, wrists under the elbows
    g = DeltaGeometry(0.03, 0.03 + 0.08, 0.08, 0.12)
    np.testing.assert_allclose(joint_angles(g, [0.0, 0.0, 0.12]), 0.0, atol=1e-15)
    np.testing.assert_allclose(forearm_vectors(g, [0.0, 0.0, 0.12]), np.tile([0, 0, 0.12], (3, 1)), atol=1e-16)


def test_positive_angle_lifts_the_elbow_towards_the_platform():
    elbows = elbow_positions(PUBLISHED, np.full(3, 0.3))
    np.testing.assert_allclose(elbows[:, 2], 0.082 * np.sin(0.3), rtol=1e-15)
    np.testing.assert_allclose(elbows[0], [0.04 + 0.082 * np.cos(0.3), 0, 0.082 * np.sin(0.3)], rtol=1e-15)


def test_a_wrong_elbow_branch_is_caught():
    p = np.array([0.012, -0.02, 0.1])

    def inwards(g, position):
        return paper_angles(g, position)[:, 1]

    # it closes the chains and passes symmetry: those checks alone would let it through
    np.testing.assert_allclose(paper_residual(PUBLISHED, inwards(PUBLISHED, p), p), 0.0, atol=1e-14)
    check_symmetry(inwards, PUBLISHED, p)
    with pytest.raises(AssertionError):
        check_outward(inwards, PUBLISHED, p)
    with pytest.raises(AssertionError):  # one chain wrong is enough
        check_outward(lambda g, q: np.where([True, True, False], joint_angles(g, q), inwards(g, q)), PUBLISHED, p)


def test_a_wrong_azimuth_is_caught(monkeypatch):
    p = np.array([0.012, -0.02, 0.1])
    check_symmetry(inverse_kinematics, PUBLISHED, p)
    axes = [np.array([rotation(degrees)[:, k] for degrees in (0.0, 90.0, 240.0)]) for k in range(2)]
    monkeypatch.setattr("delta_cad.mechanism.geometry.directions", lambda _: axes)
    with pytest.raises(AssertionError):
        check_symmetry(inverse_kinematics, PUBLISHED, p)
    with pytest.raises(AssertionError):
        check_outward(inverse_kinematics, PUBLISHED, p)


def test_shoulder_range_of_the_published_design():
    axes = [np.linspace(-HALF, HALF, 41)] * 2 + [np.linspace(BOTTOM, BOTTOM + 2 * HALF, 41)]
    theta = np.degrees(inverse_kinematics(PUBLISHED, np.stack(np.meshgrid(*axes), axis=-1)))
    # figures of an independent CAD study, given to 0.1 deg
    assert theta.min() == pytest.approx(-39.2, abs=0.05)
    assert theta.max() == pytest.approx(65.5, abs=0.05)


def distance_to_elbow_circle(g, p, i):
    """Nearest distance of wrist i to its elbow's circle, by walking round the circle."""
    turn = np.linspace(-np.pi, np.pi, 200_001)
    elbows = elbow_positions(g, np.repeat(turn[:, None], 3, axis=1))[:, i]
    return np.linalg.norm(wrist_positions(g, p)[i] - elbows, axis=1)


def test_unreachable_says_which_chain_and_by_how_much():
    p = np.array([0.10, 0.0, 0.20])
    with pytest.raises(UnreachableError) as caught:
        inverse_kinematics(PUBLISHED, p)
    match = re.fullmatch(r"chain (\d) .* (\d+\.\d{3}) mm .*", str(caught.value))
    assert match
    away = distance_to_elbow_circle(PUBLISHED, p, int(match[1])).min() - PUBLISHED.forearm_length
    assert float(match[2]) == pytest.approx(away * 1000, abs=6e-4)  # printed to 0.001 mm


def test_too_near_is_unreachable_too():
    g = DeltaGeometry(0.04, 0.04, 0.05, 0.12)
    p = np.array([0.0, 0.0, 0.06])  # the fold needs 70 mm
    with pytest.raises(UnreachableError, match=r" 10\.000 mm "):
        inverse_kinematics(g, p)
    assert g.forearm_length - distance_to_elbow_circle(g, p, 0).max() == pytest.approx(0.010, abs=1e-9)


def test_a_batch_names_the_position():
    with pytest.raises(UnreachableError, match=r"\(0\.000, 0\.000, 300\.000\) mm"):
        inverse_kinematics(PUBLISHED, [[0, 0, 0.1], [0, 0, 0.3]])


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_a_position_that_is_not_finite_is_refused(value):
    with pytest.raises(UnreachableError, match=r"nan|inf"):
        inverse_kinematics(PUBLISHED, [[0, 0, 0.1], [0, value, 0.1]])


def test_wrist_on_the_shoulder_axis_has_no_definite_angle():
    g = DeltaGeometry(0.05, 0.05, 0.08, 0.08)
    with pytest.raises(BranchError):  # it lies in the base plane
        inverse_kinematics(g, [0.0, 0.0, 0.0])
    assert np.isnan(joint_angles(g, [0.0, 0.0, 0.0])).all()


# Lengths of a haptic device that other codes publish, with the position that they give it, z downwards
FALCON, DOWNWARDS = DeltaGeometry(0.0372338, 0.014, 0.060, 0.1025), [0.010, 0.020, -0.100]
OTHER_ASSEMBLY, BELOW = DeltaGeometry(0.056, 0.024, 0.099, 0.087), [0.0, 0.0, 0.040]


def test_a_position_of_another_convention_is_refused_by_its_frame():
    # forward kinematics of these angles is another position: (-9.0, -18.1, 86.7) mm
    theta = joint_angles(FALCON, DOWNWARDS)
    np.testing.assert_allclose(np.degrees(theta), [-169.9, -169.1, 178.6], atol=0.05)
    np.testing.assert_allclose(platform_positions(FALCON, theta), [-0.0090, -0.0181, 0.0867], atol=5e-5)
    with pytest.raises(BranchError, match=r"\(10\.000, 20\.000, -100\.000\) mm: z must be > 0.*base.*negate z"):
        inverse_kinematics(FALCON, DOWNWARDS)
    turned = np.abs(DOWNWARDS)
    np.testing.assert_allclose(forward_kinematics(FALCON, inverse_kinematics(FALCON, turned)), turned, atol=1e-15)


@pytest.mark.parametrize(
    ("g", "p", "named"),
    [
        (FALCON, DOWNWARDS, "z must be > 0"),
        (FALCON, [0.0, 0.0, 0.0], "z must be > 0"),
        (OTHER_ASSEMBLY, BELOW, "det S must be > 0"),
        # R = r, L_A 3, L_B 4: the wrist 7 over the shoulder is at the end of a straight arm
        (DeltaGeometry(0.05, 0.05, 3 * 2**-5, 4 * 2**-5), [0.0, 0.0, 7 * 2**-5], "folded"),
    ],
)
def test_what_is_off_the_branch_is_refused_by_its_index_or_masked(g, p, named):
    sound = [0.001, 0.002, 0.120]
    assert np.isfinite(inverse_kinematics(g, sound)).all()
    batch = np.array([[sound, sound, sound], [sound, sound, p]])
    with pytest.raises(BranchError, match=r"position p = \(.*\) mm: .*" + named):
        inverse_kinematics(g, p)
    with pytest.raises(BranchError, match=r"position p\[1, 2\] = \(.*\) mm: .*" + named):
        inverse_kinematics(g, batch)
    masked = inverse_kinematics(g, batch, off_branch="nan")
    off = np.zeros((2, 3), bool)
    off[1, 2] = True
    assert (np.isnan(masked).all(axis=-1) == off).all()
    np.testing.assert_array_equal(masked[~off], joint_angles(g, batch[~off]))


def test_out_of_reach_and_what_is_not_finite_is_masked_too():
    p = [[0.0, 0.0, 0.1], [0.0, 0.0, 0.3], [np.inf, 0.0, 0.1], [0.0, np.nan, 0.1]]
    masked = inverse_kinematics(PUBLISHED, p, off_branch="nan")
    assert np.isnan(masked).all(axis=-1).tolist() == [False, True, True, True]
    with pytest.raises(UnreachableError, match=r"p\[1\]"):
        inverse_kinematics(PUBLISHED, p[:2])


@pytest.mark.parametrize("function", [inverse_kinematics, forward_kinematics])
def test_another_word_for_what_is_off_the_branch_is_refused(function):
    with pytest.raises(GeometryError, match=r'off_branch is .*"raise" or "nan"'):
        function(PUBLISHED, [0.0, 0.0, 0.1], off_branch="ignore")


def between(a, b):
    return np.arctan2(np.linalg.norm(np.cross(a, b)), a @ b)


@PROPERTY
@given(mechanisms(), points())
def test_angles_between_the_links(g, p):
    assume((paper_h(g, p) < -1e-9).all())  # m^4: off the fold, where an arc cosine has half the digits
    theta = joint_angles(g, p)
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
