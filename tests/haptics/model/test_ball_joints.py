"""Friction of the ball joints against orientations by finite differences and powers of random motions."""

from __future__ import annotations

import numpy as np
import pytest

from delta_cad.design import Design
from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.joint import preload_N, sliding_torques_N_mm
from delta_cad.mechanism import inverse_kinematics, jacobian
from delta_cad.mechanism.inverse import forearm_vectors
from haptics.model.ball_joints import ball_friction, ball_friction_N, joint_rates
from tests.haptics.model.textbook import textbook
from tests.haptics.scene_machine import PLACED

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


@pytest.mark.parametrize("placed", [None, *PLACED])
def test_rates_are_those_of_the_turning_cups(best: Design, placed: str | None) -> None:
    design, random = best if placed is None else PLACED[placed], np.random.default_rng(3)
    g, cube, azimuths = design.geometry, design.workspace, textbook(design).azimuths
    for _ in range(20):
        p = random.uniform(-cube.half_side, cube.half_side, 3) + cube.centre
        v = random.normal(size=3)
        found = joint_rates(g, p, v)
        ends = [p - STEP * v, p + STEP * v]
        rods = [forearm_vectors(g, q) / g.forearm_length for q in ends]
        theta = [inverse_kinematics(g, q) for q in ends]
        for i in range(3):
            t = np.array([-np.sin(azimuths[i]), np.cos(azimuths[i]), 0.0])
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
    preload = preload_N(best.mechanism.parallelogram_width_mm)
    lean, turn = sliding_torques_N_mm(best.hardware.ball_diameter_mm, np.array(preload))
    along = np.random.default_rng(4).normal(size=(4000, 3))
    along = along / np.linalg.norm(along, axis=1)[:, None]
    rates = joint_rates(g, np.broadcast_to(p, along.shape), along)
    power = 2e-3 * (lean * rates.lean + turn * rates.turn).sum(axis=(1, 2))
    np.testing.assert_allclose(ball_friction_N(best, np.broadcast_to(p, along.shape), along), power)
    turned = np.abs(np.linalg.solve(jacobian(g, p), along.T)).sum(axis=0)
    assert nominal * turned.mean() == pytest.approx(power.mean(), rel=0.01)
    assert power.max() < 0.2


def test_torques_follow_what_presses(best: Design, best_dimensions: Dimensions) -> None:
    joint = best_dimensions.forearm.joint
    assert preload_N(best.mechanism.parallelogram_width_mm) == pytest.approx(joint.spring_N, rel=1e-12)
    # both follow what presses; the arm of a turning ball grows with the contact
    leans, turns = sliding_torques_N_mm(best.hardware.ball_diameter_mm, joint.spring_N * np.array([1.0, 2.0]))
    assert leans[1] == pytest.approx(2.0 * leans[0])
    assert 2.0 < turns[1] / turns[0] < 2.0 * 2.0 ** (1 / 3)
