"""Unequal chains against a solver that knows nothing of spheres, and against the equal ones."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import brentq, fsolve
from scipy.spatial.transform import Rotation

from delta_cad.mechanism import forward_kinematics, inverse_kinematics, jacobian
from delta_cad.mechanism.chains import (
    PARAMETERS,
    UnequalDelta,
    chain_angles,
    chain_derivatives,
    chain_positions,
    equal_chains,
    unequal,
)
from delta_cad.mechanism.geometry import DeltaGeometry

G = DeltaGeometry(0.031, 0.024, 0.091, 0.143196)
RNG = np.random.default_rng(7)
POINTS = np.array([0.0, 0.0, 0.108]) + RNG.uniform(-0.04, 0.04, (12, 3))
PLACED = DeltaGeometry(0.031, 0.024, 0.091, 0.143196, 0.006, float(np.cos(np.radians(113.0))))
DRAWN = pytest.mark.parametrize(("drawn", "phi_deg"), [(G, 120.0), (PLACED, 113.0)], ids=["symmetric", "placed"])


def made(seed: int, drawn: DeltaGeometry = G) -> UnequalDelta:
    table = equal_chains(drawn) + np.random.default_rng(seed).normal(0.0, 1e-3, (3, len(PARAMETERS)))
    return unequal(table, drawn.side_cosine)


def gaps(u: UnequalDelta, p: np.ndarray, theta: np.ndarray, phi_deg: float) -> np.ndarray:
    """How much longer than its forearm each chain's gap is, by rotations of solid links."""
    out = np.empty(3)
    for i in range(3):
        turn = Rotation.from_euler("z", (0.0, phi_deg, -phi_deg)[i], degrees=True)
        arm = Rotation.from_rotvec([0.0, -theta[i], 0.0]).apply([u.upper_arm_length[i], 0.0, 0.0])
        elbow = turn.apply(np.array([u.base_radius[i], u.side_offset[i], u.height_offset[i]]) + arm)
        wrist = p + turn.apply([u.platform_radius[i], 0.0, 0.0])
        out[i] = np.linalg.norm(wrist - elbow) - u.forearm_length[i]
    return out


@DRAWN
@pytest.mark.parametrize("seed", range(3))
def test_positions_close_the_chains_of_solid_links(seed: int, drawn: DeltaGeometry, phi_deg: float) -> None:
    u = made(seed, drawn)

    def open_(p: np.ndarray, theta: np.ndarray) -> np.ndarray:
        return gaps(u, p, theta, phi_deg)

    for p in POINTS:
        theta = [brentq(lambda t, i=i, p=p: open_(p, np.full(3, t))[i], -1.0, 1.2, xtol=1e-14) for i in range(3)]
        found = chain_positions(u, theta)
        np.testing.assert_allclose(found, fsolve(lambda x, t=theta: open_(x, t), p, xtol=1e-13), atol=1e-11)
        np.testing.assert_allclose(chain_angles(u, p), theta, atol=1e-11)


@pytest.mark.parametrize("drawn", [G, PLACED], ids=["symmetric", "placed"])
def test_equal_chains_are_the_drawn_mechanism(drawn: DeltaGeometry) -> None:
    u, theta = unequal(equal_chains(drawn), drawn.side_cosine), inverse_kinematics(drawn, POINTS)
    np.testing.assert_allclose(chain_angles(u, POINTS), theta, atol=1e-14)
    np.testing.assert_allclose(chain_positions(u, theta), forward_kinematics(drawn, theta), atol=1e-15)
    found, expected = chain_derivatives(u, theta, POINTS)[0], jacobian(drawn, POINTS)
    np.testing.assert_allclose(found, expected, rtol=1e-10)


def test_derivatives_are_those_of_differences() -> None:
    u, step = made(5, PLACED), 1e-6
    theta = chain_angles(u, POINTS)
    by_joint, by_length = chain_derivatives(u, theta, POINTS)
    table = np.column_stack([getattr(u, name) for name in PARAMETERS])
    for i in range(3):
        turn = step * np.eye(3)[i]
        moved = chain_positions(u, theta + turn) - chain_positions(u, theta - turn)
        np.testing.assert_allclose(moved / (2 * step), by_joint[..., i], atol=1e-8)
        for k in range(len(PARAMETERS)):
            change = np.zeros_like(table)
            change[i, k] = step
            ends = [chain_positions(unequal(table + sign * change, u.side_cosine), theta) for sign in (1.0, -1.0)]
            np.testing.assert_allclose((ends[0] - ends[1]) / (2 * step), by_length[..., i, k], atol=1e-7)


def test_out_of_reach_is_no_number() -> None:
    u = made(1)
    assert np.isnan(chain_angles(u, [0.0, 0.0, 0.5])).all()
    assert np.isnan(chain_positions(unequal(equal_chains(G) * [3, 1, 1, 0.2, 1, 1]), [0.0] * 3)).all()
