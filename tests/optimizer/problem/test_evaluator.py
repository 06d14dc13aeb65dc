"""Figures over designs and points against the mechanism's own functions, and their continuation beyond the reach."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from delta_cad.mechanism import (
    Cube,
    DeltaGeometry,
    closure_margin,
    conditioning,
    cube_surface,
    direct_margin,
    joint_angles,
    worst_joint_torque,
)
from delta_cad.mechanism.limits import CoupleIndex, HandleInertia
from delta_cad.mechanism.limits.couple_index import couple_index
from delta_cad.mechanism.limits.effective_mass import effective_mass
from delta_cad.mechanism.limits.friction import HandleFriction
from optimizer.problem.evaluator import Figures, figures, fold_points, half_surface
from tests.optimizer.problem.figures_numpy import figures_numpy, rods
from tests.optimizer.tasks import sample_points

NAMES = Figures._fields[:6]
"""Of the figures; what they are the figures of stands behind them."""
DESIGNS = np.array([[82, 112.079, 40, 30, 57.112, 35], [82, 130, 40, 30, 48, 60], [70, 120, 45, 50, 60, 30]]) / 1000.0

FOLDED = np.array([[0.08, 0.1, 0.04, 0.04, 0.02, 0.01]])  # H = L_B - L_A


def absolute(design: np.ndarray, c: np.ndarray) -> tuple[DeltaGeometry, np.ndarray]:
    L_A, L_B, R, r, H, L = design
    return DeltaGeometry(R, r, L_A, L_B), np.stack([L * c[:, 0], L * c[:, 1], H + L * (1 + c[:, 2])], axis=-1)


@pytest.mark.parametrize("k", range(3))
def test_figures_are_those_of_the_mechanism(k: int) -> None:
    points = half_surface(7)
    f = figures(DESIGNS, points)
    g, p = absolute(DESIGNS[k], points)
    # two orders of the same sums: a few roundings of 1e-16, times the conditioning of the worst point (20)
    np.testing.assert_allclose(f.closure[k], closure_margin(g, p).min(axis=-1) / g.forearm_length**2, atol=1e-14)
    np.testing.assert_allclose(f.determinant[k], direct_margin(g, p), atol=1e-14)
    torque = 3.0 * f.moment[k] / np.abs(f.determinant[k])
    np.testing.assert_allclose(torque, worst_joint_torque(g, p, 3.0).max(axis=-1), rtol=1e-12)
    np.testing.assert_allclose(1.0 / f.quality[k], conditioning(g, p), rtol=1e-11)
    np.testing.assert_allclose(f.shoulder_min[k], joint_angles(g, p).min(axis=-1), atol=1e-14)
    np.testing.assert_allclose(f.shoulder_max[k], joint_angles(g, p).max(axis=-1), atol=1e-14)


def test_quality_carries_the_sign_of_the_determinant_and_can_be_left_out() -> None:
    # step 1's optimum of table 4 folds at the bottom centre and has the forearms' plane turned over at the top
    design = np.array([[82, 130, 40, 40, 48, 64]]) / 1000.0
    f = figures(design, half_surface(9))
    assert (f.determinant < 0).any()
    assert (np.sign(f.quality)[f.closure > 0] == np.sign(f.determinant)[f.closure > 0]).all()
    assert (figures(design, half_surface(9), conditioning=False).quality == 1.0).all()


@pytest.mark.parametrize("way", [figures, figures_numpy])
@pytest.mark.parametrize("conditioning", [True, False])
def test_angles_can_be_left_out_and_nothing_else_changes(way: Callable[..., Figures], conditioning: bool) -> None:
    points = sample_points(DESIGNS, 5)
    whole, some = way(DESIGNS, points, conditioning), way(DESIGNS, points, conditioning, angles=False)
    assert all(np.array_equal(a, b) for a, b in zip(whole[:4], some[:4], strict=True))
    assert (some.shoulder_min == 0.0).all()
    assert (some.shoulder_max == 0.0).all()


def test_half_the_surface_has_every_value_of_the_whole() -> None:
    n = 9
    *_, H, L = DESIGNS[0]
    whole = cube_surface(Cube(H, L), n)
    unit = np.column_stack([whole[:, :2] / L, (whole[:, 2] - H) / L - 1.0])
    half, full = figures(DESIGNS[:1], half_surface(n)), figures(DESIGNS[:1], unit)
    for a, b in zip(half[: len(NAMES)], full[: len(NAMES)], strict=True):
        # y and -y give the same figures up to the order in which chains 1 and 2 are summed
        np.testing.assert_allclose(np.unique(a.round(12)), np.unique(b.round(12)), atol=2e-12)
    assert len(half_surface(n)) < 0.6 * len(whole)


@pytest.mark.parametrize("variable", [1, 4])
def test_figures_are_finite_and_continuous_through_the_edge_of_reach(variable: int) -> None:
    """Raise L_B (or lower H) until the forearm folds at the bottom: no jump larger than a square root allows."""
    steps = np.linspace(0.0, 1.0, 2001)
    path = np.tile(np.array([82, 130, 40, 38, 48, 40]) / 1000.0, (len(steps), 1))
    path[:, variable] += 0.006 * (steps - 0.5) * (1 if variable == 1 else -1)
    f = figures(path, np.array([[0.05, 0.0, -1.0], [0.0, 0.0, -1.0], [1.0, 1.0, 1.0]]))
    assert (f.closure[:, 1] < 0).any()
    assert (f.closure[:, 1] > 0).any()
    lightness = f.mass_ratio(HandleInertia(carried_mass=0.08, elbow_mass=0.02, cross_mass=0.004, joint_inertia=2e-4))
    index = CoupleIndex(0.4).margin(f)
    for name, values in {**dict(zip(NAMES, f, strict=False)), "mass_ratio": lightness, "couple index": index}.items():
        assert np.isfinite(values).all(), name
        # sqrt(w^2) changes by sqrt(step) of 3 micrometres in 82 mm at most: 0.6 %, times slopes below 10
        assert np.abs(np.diff(values, axis=0)).max() < 0.06, name
    assert (lightness[f.closure < 0.0] == f.closure[f.closure < 0.0]).all()


def test_lightness_is_the_carried_mass_by_the_effective_mass() -> None:
    """500 random designs with masses of every proportion, also a rod that couples its ends negatively."""
    rng, points = np.random.default_rng(11), half_surface(4)
    low, high = np.array([60, 90, 35, 20, 20, 10]), np.array([90, 160, 45, 50, 90, 60])
    designs = (low + (high - low) * rng.random((500, 6))) / 1000.0
    compared = 0
    for design in designs:
        masses = HandleInertia(*(rng.uniform(0.05, 1.0, 4) * [0.2, 0.04, rng.choice([-0.004, 0.02]), 1e-3]))
        f = figures(design[None], points)
        found = f.mass_ratio(masses)[0]
        g, p = absolute(design, points)
        mass = effective_mass(g, p, masses)
        closed = f.closure[0] > 1e-9
        # eigenvalues of another order of the same sums: roundings of 1e-16, times 1 / w^2 near a fold
        np.testing.assert_allclose(found[closed], masses.carried_mass / mass[closed], rtol=1e-6)
        far = f.closure[0] > 1e-3
        np.testing.assert_allclose(found[far], masses.carried_mass / mass[far], rtol=1e-11)
        assert (found[f.closure[0] < 0.0] == f.closure[0][f.closure[0] < 0.0]).all()
        compared += int(far.sum())
    assert compared > 10_000


def test_the_margin_of_the_couple_index_is_that_of_the_mechanism() -> None:
    points = half_surface(4)
    for design in DESIGNS:
        f = figures(design[None], points)
        found = CoupleIndex(0.4).margin(f)[0]
        g, p = absolute(design, points)
        closed = f.closure[0] > 1e-9
        assert closed.any()
        np.testing.assert_allclose(found[closed], couple_index(g, p)[closed] - 0.4, atol=1e-12)


def test_lightness_is_one_where_nothing_else_moves_and_none_at_a_fold() -> None:
    points = sample_points(DESIGNS, 5)
    f = figures(DESIGNS, points)
    alone = f.mass_ratio(HandleInertia(carried_mass=0.1, elbow_mass=0.0, cross_mass=0.0, joint_inertia=0.0))
    assert (alone[f.closure >= 0.0] == 1.0).all()
    folded = figures(FOLDED, np.array([[0.0, 0.0, -1.0]]))
    assert abs(folded.closure[0, 0]) < 1e-15
    heavy = folded.mass_ratio(HandleInertia(carried_mass=0.1, elbow_mass=0.02, cross_mass=0.0, joint_inertia=2e-4))
    assert abs(heavy[0, 0]) < 1e-12


def test_a_wrist_on_its_shoulder_axis_gives_numbers() -> None:
    design = np.array([[80, 80, 40, 30, 10, 20]]) / 1000.0
    point = np.array([[0.5, 0.0, -1.5]])  # x = R - r, z = 0
    f: Figures = figures(design, point)
    assert all(np.isfinite(values).all() for values in f)


def test_fold_points_lie_above_the_shoulders_or_at_the_edge() -> None:
    foot = fold_points(np.array([[82, 112, 40, 30, 57, 35], [82, 112, 40, 90, 57, 35], [82, 112, 40, 45, 57, 0]]) / 1e3)
    np.testing.assert_allclose(foot[0], [[10 / 35, 0, -1], [-5 / 35, 5 * np.sqrt(3) / 35, -1]], atol=1e-15)
    np.testing.assert_allclose(foot[1], [[-1, 0, -1], [0.5, np.sqrt(3) / 2, -1]], atol=1e-15)
    assert np.isfinite(foot).all()


def test_reach_on_the_coarsest_sample_is_that_of_the_finest() -> None:
    """Corners and fold points decide reach alone, README (21): 500 random designs, none better on a fine grid."""
    rng = np.random.default_rng(3)
    low, high = np.array([60, 90, 35, 20, 20, 10]), np.array([90, 160, 45, 50, 90, 60])
    designs = (low + (high - low) * rng.random((500, 6))) / 1000.0
    designs[:, 1] = np.maximum(designs[:, 1], designs[:, 0])
    coarse = figures(designs, sample_points(designs, 3), conditioning=False).closure.min(axis=1)
    fine = figures(designs, half_surface(25), conditioning=False).closure.min(axis=1)
    assert ((coarse >= 0) <= (fine >= 0)).all()
    assert 50 < (coarse >= 0).sum() < 450


@pytest.mark.parametrize("conditioning", [True, False])
def test_compiled_figures_are_those_of_numpy(conditioning: bool) -> None:
    """Random designs, well placed, out of reach, folded and with the platform below its elbows."""
    rng = np.random.default_rng(8)
    low, high = np.array([40, 40, 30, 20, 5, 0]), np.array([120, 200, 60, 60, 150, 80])
    designs = np.concatenate([(low + (high - low) * rng.random((60, 6))) / 1000.0, DESIGNS])
    points = sample_points(designs, 5)
    a, b = figures(designs, points, conditioning), figures_numpy(designs, points, conditioning)
    assert (b.closure < 0).any()
    assert (b.determinant < 0).any()
    for name, x, y in zip(NAMES, a, b, strict=False):
        # sums of the same terms in another order; eigenvalues by another method: 1e-15 of the largest, square rooted
        # where the smallest is about 0
        close = np.isclose(x, y, rtol=1e-12, atol=1e-13 if name != "quality" else 1e-7)
        assert close.all(), (name, np.abs(x - y)[~close])


def test_compiled_feel_is_that_of_numpy() -> None:
    """Mass, friction and step felt, of designs within reach and beyond, up to a fold."""
    rng = np.random.default_rng(9)
    low, high = np.array([40, 40, 30, 20, 5, 0]), np.array([120, 200, 60, 60, 150, 80])
    designs = np.concatenate([(low + (high - low) * rng.random((60, 6))) / 1000.0, DESIGNS, FOLDED])
    points = np.concatenate(
        [sample_points(designs, 5), np.broadcast_to([[0.0, 0.0, -1.0]], (len(designs), 1, 3))], axis=1
    )
    f = figures_numpy(designs, points)
    masses = HandleInertia(carried_mass=0.09, elbow_mass=0.011, cross_mass=0.004, joint_inertia=2.9e-4)
    sources = HandleFriction(0.01, 0.12, 0.18)
    g = figures(designs, points)
    found = g.mass_ratio(masses), g.inverse_friction(sources), g.scaled_step()
    assert (f.closure < 0.0).any()
    for x, y in zip(found, (f.mass_ratio(masses), f.inverse_friction(sources), f.scaled_step()), strict=True):
        assert np.isfinite(y).all()
        np.testing.assert_allclose(x, y, rtol=1e-11, atol=1e-15)


def test_folds_are_the_angles_between_arms_and_rods_of_every_chain() -> None:
    """The law of cosines, against the chains' own directions."""
    low, high = np.array([70, 130, 30, 20, 50, 10]), np.array([100, 180, 50, 30, 100, 40])
    designs = (low + (high - low) * np.random.default_rng(3).random((40, 6))) / 1000.0
    f = figures(designs, sample_points(designs, 5))
    seen = rods(f.designs, f.points)
    closed = (seen.closure > 0.0).all(axis=-1)
    between = (seen.cos * seen.radial + seen.sin * seen.vertical).min(axis=-1)
    assert closed.mean() > 0.5
    np.testing.assert_allclose(f.folds()[closed], between[closed], rtol=0.0, atol=1e-13)
