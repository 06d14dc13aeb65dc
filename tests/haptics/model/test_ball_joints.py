"""Friction of the ball joints against orientations by finite differences and powers of random motions."""

from __future__ import annotations

import numpy as np
import pytest

from delta_cad.design import Design
from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.joint import sliding_torques_N_mm
from delta_cad.mechanism import inverse_kinematics, jacobian
from delta_cad.mechanism.inverse import forearm_vectors
from delta_cad.mechanism.placement import chain_frame
from haptics.model.ball_joints import ball_friction, ball_friction_N, joint_rates

STEP = 1e-6


def cup(n: np.ndarray, t: np.ndarray) -> np.ndarray:
    """Axes of a cup as columns: along the rod, towards its neighbour, square to both."""
    y = t - (t @ n) * n
    y = y / np.linalg.norm(y)
    return np.stack([n, y, np.cross(n, y)], axis=1)


def spin(before: np.ndarray, after: np.ndarray, time: float) -> np.ndarray:
    """Angular velocity between two orientations, by the skew part of the turn."""
    turn = (after - before) @ ((after + before) / 2).T / time
    return np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]]) / 2


def test_rates_are_those_of_the_turning_cups(best: Design) -> None:
    g, random = best.geometry, np.random.default_rng(3)
    low, half = best.cube.bottom_height_mm / 1e3, best.cube.half_side_mm / 1e3
    for _ in range(20):
        p = random.uniform(-half, half, 3) + np.array([0.0, 0.0, low + half])
        v = random.normal(size=3)
        found = joint_rates(g, p, v)
        ends = [p - STEP * v, p + STEP * v]
        rods = [forearm_vectors(g, q) / g.forearm_length for q in ends]
        theta = [inverse_kinematics(g, q) for q in ends]
        for i in range(3):
            t = chain_frame(i)[:3, 1]
            middle = cup(forearm_vectors(g, p)[i] / g.forearm_length, t)
            rod = spin(cup(rods[0][i], t), cup(rods[1][i], t), 2 * STEP)
            arm = -(theta[1][i] - theta[0][i]) / (2 * STEP) * t  # positive towards +z is a turn about -t
            for end, stud in enumerate((arm, np.zeros(3))):
                about = float((rod - stud) @ middle[:, 1])
                aside = np.linalg.norm(rod - stud - about * middle[:, 1])
                assert found.turn[i, end] == pytest.approx(abs(about), rel=1e-4, abs=1e-6)
                assert found.lean[i, end] == pytest.approx(aside, rel=1e-4, abs=1e-6)


def test_the_handle_s_friction_is_their_power_over_its_speed(best: Design) -> None:
    """Orientations by finite differences, as above, at one position; the joints' torque takes the same in the mean."""
    g, p = best.geometry, np.array([0.0, 0.0, (best.cube.bottom_height_mm + best.cube.half_side_mm) / 1e3])
    least, nominal, largest = ball_friction(best, p)
    assert (least, largest) == pytest.approx((nominal * 5 / 8, nominal * 15 / 8))
    lean, turn = sliding_torques_N_mm(best.mechanism.parallelogram_width_mm, best.hardware.ball_diameter_mm)
    along = np.random.default_rng(4).normal(size=(4000, 3))
    along = along / np.linalg.norm(along, axis=1)[:, None]
    rates = joint_rates(g, np.broadcast_to(p, along.shape), along)
    power = 2e-3 * (lean * rates.lean + turn * rates.turn).sum(axis=(1, 2))
    np.testing.assert_allclose(ball_friction_N(best, np.broadcast_to(p, along.shape), along), power)
    turned = np.abs(np.linalg.solve(jacobian(g, p), along.T)).sum(axis=0)
    assert nominal * turned.mean() == pytest.approx(power.mean(), rel=0.01)
    assert power.max() < 0.2


def test_torques_are_those_of_the_joint_s_dimensions(best: Design, best_dimensions: Dimensions) -> None:
    """The preload of the joint is what is left of its spring by the lever; the torque about its axis goes by P^4/3."""
    joint = best_dimensions.forearm.joint
    lean, turn = sliding_torques_N_mm(best.mechanism.parallelogram_width_mm, best.hardware.ball_diameter_mm)
    assert lean == pytest.approx(joint.friction_lean_N_mm, rel=1e-12)
    share = (joint.spring_N / joint.preload_N) ** (4 / 3)
    assert turn == pytest.approx(joint.friction_turn_N_mm * share, rel=1e-9)
