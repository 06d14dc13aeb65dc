"""The kernel's condition number, as the searches call it, against NumPy: away from, near and on the singularities."""

import subprocess
import sys
from dataclasses import replace

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
from optimizer.problem import evaluator
from tests.delta_cad.mechanism.oracles import BOTTOM, HALF, PUBLISHED

UP = np.array([0.0, 0.0, 1.0])


def figures(g, p):
    """Smallest w^2 (m^2), largest torque arm (m) and kappa; of an open chain NaN in the place of kappa."""
    lengths = [g.upper_arm_length, g.forearm_length, g.base_radius, g.platform_radius, 0.0, 1.0]
    lengths += [g.side_shift, g.side_cosine, 0.0]
    f = evaluator.figures(np.array([lengths]), np.atleast_2d(p) - UP)  # a cube of 2 m on the base plane
    with np.errstate(divide="ignore", invalid="ignore"):
        kappa = np.where(f.closure >= 0.0, 1.0 / np.abs(f.quality), np.nan)
        arm = np.where(f.determinant == 0.0, np.inf, f.moment / np.abs(f.determinant))
    return (g.forearm_length**2 * f.closure)[0], arm[0], kappa[0]


def mechanisms(n, placed=False):
    rng = np.random.default_rng(11)
    for _ in range(n):
        g = DeltaGeometry(*rng.uniform([0.01, 0.01, 0.04, 0.05], [0.08, 0.08, 0.1, 0.2]))
        if placed:
            g = replace(g, side_shift=rng.uniform(0.01, 0.08) - g.base_radius, side_cosine=rng.uniform(-0.86, 0.5))
        yield g, (rng.uniform([-0.06, -0.06, 0.003], [0.06, 0.06, 0.2], (20_000, 3)) - UP) + UP  # exact in either


def test_figures_are_those_of_the_numpy_functions():
    for g, p in (*mechanisms(8), *mechanisms(4, placed=True)):
        kappa, torque = conditioning(g, p), worst_joint_torque(g, p, 1.0).max(axis=-1)
        closure, arms, own = figures(g, p)
        # w^2 is a difference of squares of lengths up to 0.3 m
        np.testing.assert_allclose(closure, closure_margin(g, p).min(axis=-1), rtol=1e-10, atol=1e-15)
        np.testing.assert_array_equal(np.isnan(own), np.isnan(kappa))
        regular = kappa < 1e3
        assert regular.any()
        np.testing.assert_allclose(own[regular], kappa[regular], rtol=1e-10)
        np.testing.assert_allclose(arms[regular], torque[regular], rtol=1e-10)
        # near a singularity both lose a digit for each digit of kappa, and no more: some 1,000 roundings
        near = np.isfinite(kappa)
        assert (np.abs(own / kappa - 1.0)[near] <= 2e-13 * kappa[near]).all()
        assert (np.abs(arms / torque - 1.0)[near] <= 2e-13 * kappa[near]).all()


def test_no_digit_is_lost_where_two_eigenvalues_meet():
    z = np.linspace(BOTTOM, BOTTOM + 2 * HALF, 200)
    for offset in (0.0, 1e-15, 1e-12, 1e-9, 1e-6):
        p = np.stack([np.full_like(z, offset), np.zeros_like(z), z], axis=-1)
        np.testing.assert_allclose(figures(PUBLISHED, p)[2], conditioning(PUBLISHED, p), rtol=1e-14)
    # kappa is 1 somewhere on the axis of this mechanism: all three meet
    assert figures(PUBLISHED, [[0.0, 0.0, 0.0571]])[2] < 1.01


def test_the_fold():
    g = DeltaGeometry(0.05, 0.03, 0.0625, 0.125)
    fold = np.array([0.02, 0.0, 0.0625])  # chain 0 folded upright, both lengths exact in binary
    closure, arm, kappa = figures(g, fold)
    assert closure == 0.0
    assert kappa == np.inf
    np.testing.assert_allclose(arm, worst_joint_torque(g, fold, 1.0).max(), rtol=1e-14)
    p = fold + np.outer([1e-3, 1e-6, 1e-9, 1e-12], UP)
    np.testing.assert_allclose(figures(g, p)[2], conditioning(g, (p - UP) + UP), rtol=1e-10)


def test_the_direct_singularity():
    g = DeltaGeometry(0.0625, 0.125, 0.0625, 0.125)  # level arms under their wrists, exact in binary
    p = np.array([0.0, 0.0, 0.125])
    _, arm, kappa = figures(g, p)
    assert arm == kappa == np.inf  # where the singular values end in a rounding and give 1e16
    near = (p + np.outer([1e-2, 1e-3, 1e-4], UP) - UP) + UP
    kappa = conditioning(g, near)
    # two singular values vanish together here, so det S is a rounding times the square of kappa
    assert (np.abs(figures(g, near)[2] / kappa - 1.0) <= 1e-15 * kappa**2).all()


def test_both_singularities_at_once_and_no_position():
    assert figures(DeltaGeometry(0.0625, 0.0625, 0.0625, 0.125), [[0.0, 0.0, 0.0625]])[2] == np.inf
    closure, _, kappa = figures(PUBLISHED, [[0.0, 0.0, 0.3], [0.0, 0.0, 0.1]])
    assert np.isnan(kappa).tolist() == [True, False]
    assert closure[0] == pytest.approx(closure_margin(PUBLISHED, [0.0, 0.0, 0.3]).min())


@pytest.mark.parametrize("g", [PUBLISHED, replace(PUBLISHED, side_shift=0.006, side_cosine=-0.45)])
def test_mirrored_positions_score_the_same_to_the_last_bit(g):
    p = cube_grid(Cube(BOTTOM, HALF), 9)
    (closure, arm, kappa), mirror = figures(g, p), figures(g, p * [1.0, -1.0, 1.0])
    np.testing.assert_array_equal(closure, mirror[0])
    np.testing.assert_allclose(arm, mirror[1], rtol=1e-15)
    np.testing.assert_allclose(kappa, mirror[2], rtol=1e-14)


def test_nothing_of_the_mechanism_loads_the_compiler_before_it_is_called():
    rooms = ("kernel", "limits", "enclosure.slope_pose", "proof.extremes", "proof.prove")
    code = f"import sys, {', '.join(f'delta_cad.mechanism.{room}' for room in rooms)}; sys.exit('numba' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code]).returncode == 0
