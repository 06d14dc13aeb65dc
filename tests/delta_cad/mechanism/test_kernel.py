"""The compiled kernel against the NumPy functions, away from the singularities, near them and on them."""

import subprocess
import sys

import numpy as np
import pytest

from delta_cad.mechanism import (
    Cube,
    DeltaGeometry,
    closure_margin,
    conditioning,
    cube_grid,
    worst_joint_torque,
)
from delta_cad.mechanism.kernel import figures, figures_into
from tests.delta_cad.mechanism.oracles import BOTTOM, HALF, PUBLISHED

UP = np.array([0.0, 0.0, 1.0])


def mechanisms(n):
    rng = np.random.default_rng(11)
    for _ in range(n):
        g = DeltaGeometry(*rng.uniform([0.01, 0.01, 0.04, 0.05], [0.08, 0.08, 0.1, 0.2]))
        yield g, rng.uniform([-0.06, -0.06, 0.003], [0.06, 0.06, 0.2], (20_000, 3))


def test_figures_are_those_of_the_numpy_functions():
    for g, p in mechanisms(8):
        ours, kappa, torque = figures(g, p), conditioning(g, p), worst_joint_torque(g, p, 1.0)
        # w^2 is a difference of squares of lengths up to 0.3 m
        np.testing.assert_allclose(ours.closure_margin, closure_margin(g, p).min(axis=-1), rtol=1e-10, atol=1e-15)
        for figure in (ours.kappa, ours.torque_arms[:, 0]):
            np.testing.assert_array_equal(np.isnan(figure), np.isnan(kappa))
        regular = kappa < 1e3
        assert regular.any()
        np.testing.assert_allclose(ours.kappa[regular], kappa[regular], rtol=1e-10)
        np.testing.assert_allclose(ours.torque_arms[regular], torque[regular], rtol=1e-10)
        # near a singularity both lose a digit for each digit of kappa, and no more
        near = np.isfinite(kappa)
        assert (np.abs(ours.kappa / kappa - 1.0)[near] <= 1e-13 * kappa[near]).all()
        assert (np.abs(ours.torque_arms / torque - 1.0)[near] <= 1e-13 * kappa[near, None]).all()


def test_no_digit_is_lost_where_two_eigenvalues_meet():
    z = np.linspace(BOTTOM, BOTTOM + 2 * HALF, 200)
    for offset in (0.0, 1e-15, 1e-12, 1e-9, 1e-6):
        p = np.stack([np.full_like(z, offset), np.zeros_like(z), z], axis=-1)
        np.testing.assert_allclose(figures(PUBLISHED, p).kappa, conditioning(PUBLISHED, p), rtol=1e-14)
    # kappa is 1 somewhere on the axis of this mechanism: all three meet
    assert figures(PUBLISHED, [[0.0, 0.0, 0.0571]]).kappa[0] < 1.01


def test_room_that_is_used_again_gives_the_same():
    room = np.full((5, 20_000), np.nan)
    for g, p in mechanisms(2):
        ours, fresh = figures_into(g, np.ascontiguousarray(p.T), room), figures(g, p)
        assert all(np.shares_memory(figure, room) for figure in ours)
        for again, figure in zip(ours, fresh, strict=True):
            np.testing.assert_array_equal(again, figure)


def test_the_fold():
    g = DeltaGeometry(0.05, 0.03, 0.0625, 0.125)
    fold = np.array([0.02, 0.0, 0.0625])  # chain 0 folded upright, both lengths exact in binary
    ours = figures(g, fold)
    assert ours.closure_margin[0] == 0.0
    assert ours.kappa[0] == np.inf
    np.testing.assert_allclose(ours.torque_arms[0], worst_joint_torque(g, fold, 1.0), rtol=1e-14)
    p = fold + np.outer([1e-3, 1e-6, 1e-9, 1e-12], UP)
    np.testing.assert_allclose(figures(g, p).kappa, conditioning(g, p), rtol=1e-10)


def test_the_direct_singularity():
    g = DeltaGeometry(0.0625, 0.125, 0.0625, 0.125)  # level arms under their wrists, exact in binary
    p = np.array([0.0, 0.0, 0.125])
    ours = figures(g, p)
    assert (ours.torque_arms == np.inf).all()
    assert ours.kappa[0] == np.inf  # where the singular values end in a rounding and give 1e16
    near = p + np.outer([1e-2, 1e-3, 1e-4], UP)
    kappa = conditioning(g, near)
    # two singular values vanish together here, so det S is a rounding times the square of kappa
    assert (np.abs(figures(g, near).kappa / kappa - 1.0) <= 1e-15 * kappa**2).all()


def test_both_singularities_at_once_and_no_position():
    g = DeltaGeometry(0.0625, 0.0625, 0.0625, 0.125)
    ours = figures(g, [[0.0, 0.0, 0.0625]])
    assert (ours.torque_arms == np.inf).all()
    assert ours.kappa[0] == np.inf
    ours = figures(PUBLISHED, [[0.0, 0.0, 0.3], [np.nan, 0.0, 0.1], [0.0, 0.0, 0.1]])
    assert np.isnan(ours.kappa).tolist() == [True, True, False]
    assert np.isnan(ours.torque_arms).tolist() == [[True] * 3, [True] * 3, [False] * 3]
    assert ours.closure_margin[0] == pytest.approx(closure_margin(PUBLISHED, [0.0, 0.0, 0.3]).min())
    assert np.isnan(ours.closure_margin[1])


def test_mirrored_positions_score_the_same_to_the_last_bit():
    p = cube_grid(Cube(BOTTOM, HALF), 9)
    ours, mirror = figures(PUBLISHED, p), figures(PUBLISHED, p * [1.0, -1.0, 1.0])
    np.testing.assert_array_equal(ours.closure_margin, mirror.closure_margin)
    np.testing.assert_allclose(ours.torque_arms, mirror.torque_arms[:, [0, 2, 1]], rtol=1e-15)
    np.testing.assert_allclose(ours.kappa, mirror.kappa, rtol=1e-14)


def test_nothing_of_the_mechanism_loads_the_compiler_before_it_is_called():
    rooms = ("kernel", "limits", "enclosure.slope_pose", "proof.extremes", "proof.prove")
    code = f"import sys, {', '.join(f'delta_cad.mechanism.{room}' for room in rooms)}; sys.exit('numba' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code]).returncode == 0
