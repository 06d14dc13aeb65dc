"""Worst torque, singular values, conditioning and the two margins, near and at both singularities."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from delta_cad.mechanism import (
    Cube,
    DeltaGeometry,
    closure_margin,
    conditioning,
    cube_grid,
    direct_margin,
    forearm_vectors,
    inverse_jacobian,
    jacobian,
    joint_angles,
    serial_margin,
    singular_values,
    worst_joint_torque,
)
from tests.delta_cad.mechanism.oracles import BOTTOM, HALF, PROPERTY, PUBLISHED, mechanisms, paper_h, points


def directions(n):
    """(n, 3) unit vectors, evenly over the sphere (golden spiral)."""
    k = np.arange(n) + 0.5
    height, turn = 1 - 2 * k / n, np.pi * (1 + 5**0.5) * k
    ring = np.sqrt(1 - height**2)
    return np.stack([ring * np.cos(turn), ring * np.sin(turn), height], axis=-1)


SPHERE = directions(20_000)
UP = np.array([0.0, 0.0, 1.0])


def inside(g, p, limit):
    assume((paper_h(g, p) < 0).all())
    assume(serial_margin(g, p).min() > limit)
    assume(abs(direct_margin(g, p)) > limit)


@PROPERTY
@given(mechanisms(), points(), st.floats(0.1, 10.0))
def test_worst_torque_over_many_directions(g, p, force):
    inside(g, p, 0.01)
    # joint torques from static balance of the platform: rod forces, then the lever about each shoulder
    s = forearm_vectors(g, p)
    along = np.linalg.solve(s.T, force * SPHERE.T)  # rod force per metre of rod, (3 chains, n)
    theta = joint_angles(g, p)
    brute = np.empty(3)
    for i in range(3):
        phi = np.radians(120.0 * i)
        move = [-np.sin(theta[i]) * np.cos(phi), -np.sin(theta[i]) * np.sin(phi), np.cos(theta[i])]
        brute[i] = np.abs(g.upper_arm_length * (s[i] @ move) * along[i]).max()
    worst = worst_joint_torque(g, p, force)
    assert (brute <= worst * (1 + 1e-9)).all()  # det 0.01 costs two digits, and some more
    # 20,000 directions are less than 0.02 rad apart; the cosine loses half the square of that
    assert (brute >= worst * (1 - 2e-4) - 1e-15).all()
    axes = np.concatenate([np.eye(3), -np.eye(3)]) * force
    assert (np.abs(axes @ jacobian(g, p)).max(axis=0) <= worst * (1 + 1e-12)).all()


def test_axis_directions_alone_understate_the_torque():
    p = cube_grid(Cube(BOTTOM, HALF), 9)
    axes_only = 3.0 * np.abs(jacobian(PUBLISHED, p)).max(axis=-2)
    assert (axes_only / worst_joint_torque(PUBLISHED, p, 3.0)).min() < 0.7


@PROPERTY
@given(mechanisms(), points())
def test_singular_values_are_those_of_the_jacobian(g, p):
    inside(g, p, 1e-3)
    values = singular_values(g, p)
    expected = np.linalg.svd(jacobian(g, p), compute_uv=False)
    # absolute error of one is a rounding of the largest, of the other a rounding of the smallest's inverse
    np.testing.assert_allclose(values, expected, rtol=1e-9)
    assert (np.diff(values) <= 0).all()
    kappa = np.linalg.cond(jacobian(g, p))
    assert conditioning(g, p) == pytest.approx(kappa, rel=1e-13 * kappa + 1e-9)
    assert conditioning(g, p) == pytest.approx(np.linalg.cond(inverse_jacobian(g, p)), rel=1e-12 * kappa)


@PROPERTY
@given(mechanisms(), points())
def test_torque_lies_between_the_singular_values(g, p):
    inside(g, p, 1e-3)
    torque, values = worst_joint_torque(g, p, 1.0), singular_values(g, p)
    assert torque.max() <= values[0] * (1 + 1e-9)
    assert torque.min() >= values[2] * (1 - 1e-9)
    assert (torque**2).sum() == pytest.approx((values**2).sum(), rel=1e-9)  # both are the Frobenius norm


@PROPERTY
@given(mechanisms(), points())
def test_margins_are_what_they_say(g, p):
    assume((paper_h(g, p) < 0).all())
    theta = joint_angles(g, p)
    for i in range(3):
        phi = np.radians(120.0 * i)
        move = [-np.sin(theta[i]) * np.cos(phi), -np.sin(theta[i]) * np.sin(phi), np.cos(theta[i])]
        cosine = forearm_vectors(g, p)[i] @ move / g.forearm_length
        assert serial_margin(g, p)[i] == pytest.approx(cosine, abs=1e-7)  # w is the root of a rounding at the fold
    units = forearm_vectors(g, p) / g.forearm_length
    assert direct_margin(g, p) == pytest.approx(np.linalg.det(units), abs=1e-12)
    np.testing.assert_allclose(serial_margin(g, p) ** 2 * g.forearm_length**2, closure_margin(g, p), atol=1e-17)


def test_kappa_grows_to_infinity_on_the_fold():
    g = DeltaGeometry(0.05, 0.03, 0.0625, 0.125)
    fold = np.array([0.02, 0.0, 0.0625])  # chain 0 folded upright, both lengths exact in binary
    kappa = [float(conditioning(g, fold + d * UP)) for d in (1e-3, 1e-5, 1e-7, 1e-9)]
    # w grows with the root of the distance: a hundredth of it makes kappa ten times as large
    np.testing.assert_allclose(np.diff(np.log10(kappa)), 1.0, atol=0.02)
    assert conditioning(g, fold) == np.inf
    values = singular_values(g, fold)
    assert values[2] == 0.0
    np.testing.assert_allclose(values[:2], np.linalg.svd(jacobian(g, fold), compute_uv=False)[:2], rtol=1e-12)
    np.testing.assert_allclose(values[:2], singular_values(g, fold + 1e-12 * UP)[:2], rtol=1e-4)
    # the fold looks excellent to a search for small torque alone
    assert worst_joint_torque(g, fold, 3.0)[0] == 0.0


def test_direct_singularity_gives_infinite_torque():
    g = DeltaGeometry(0.0625, 0.0625 + 0.0625, 0.0625, 0.125)  # level arms under their wrists, exact in binary
    p = np.array([0.0, 0.0, 0.125])
    assert direct_margin(g, p) == 0.0
    assert (worst_joint_torque(g, p, 3.0) == np.inf).all()
    assert conditioning(g, p) > 1e15  # one singular value of the inverse is zero to rounding
    # on the axis the forearms' tilt grows with the square of the distance, and kappa with its inverse
    kappa = [float(conditioning(g, p + d * UP)) for d in (-1e-3, -1e-4, 1e-4, 1e-3)]
    np.testing.assert_allclose([kappa[1] / kappa[0], kappa[2] / kappa[3]], 100.0, rtol=0.01)


def test_both_singularities_at_once():
    g = DeltaGeometry(0.0625, 0.0625, 0.0625, 0.125)
    p = np.array([0.0, 0.0, 0.0625])  # all arms hang straight down, all forearms stand straight up
    assert conditioning(g, p) == np.inf
    values = singular_values(g, p)
    assert values[0] == np.inf
    assert np.isnan(values[1])  # undefined: it depends on the way in
    assert values[2] == 0.0


def test_searches_get_numbers_or_nan_never_exceptions():
    p = np.array([[0.0, 0.0, 0.1], [0.0, 0.0, 0.3]])
    for figure in (lambda p: worst_joint_torque(PUBLISHED, p, 3.0), lambda p: singular_values(PUBLISHED, p)):
        assert np.isfinite(figure(p)[0]).all()
        assert np.isnan(figure(p)[1]).all()
    assert np.isnan(conditioning(PUBLISHED, p)).tolist() == [False, True]
    assert np.isnan(direct_margin(PUBLISHED, p)).tolist() == [False, True]
    assert (serial_margin(PUBLISHED, p)[1] < 0).all()  # continues through the edge


def test_torque_of_the_published_design():
    p = cube_grid(Cube(BOTTOM, HALF), 21)
    # N m at 3 N, a figure of an independent CAD study given to 0.001 (not the paper's 0.8, see the mechanism's README)
    assert worst_joint_torque(PUBLISHED, p, 3.0).max() == pytest.approx(0.316, abs=5e-4)
