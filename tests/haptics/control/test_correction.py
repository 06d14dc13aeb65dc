"""The map of a calibrated device against the calibration's own kinematics, which shares no code with it."""

from __future__ import annotations

import numpy as np

from delta_cad.design import Design
from delta_cad.mechanism import forward_kinematics, jacobian
from delta_cad.mechanism.chains import chain_positions
from haptics.control.correction import ANGLE, DRAWN, POSITION, ROWS, correct, correction, turned
from tests.haptics.calibration.devices import cube_points, made, readings


def test_position_angles_and_torques_are_those_of_the_made_device(best: Design) -> None:
    """A torque of the drawn device, turned, does the same work: by differences."""
    rng, step = np.random.default_rng(8), 1e-6
    for turns in (1.0, 4.8):
        device = made(best, rng, turns)
        known = correction(best.geometry, device)
        for read in readings(device, cube_points(best, rng, 6)):
            out = np.zeros((ROWS, 3))
            correct.py_func(known, read, out)
            angles = device.angles(read)
            np.testing.assert_allclose(out[ANGLE], angles, atol=1e-13)
            there = chain_positions(device.mechanism, angles[None])[0]
            np.testing.assert_allclose(out[POSITION], there, atol=1e-13)
            np.testing.assert_allclose(forward_kinematics(best.geometry, out[DRAWN]), there, atol=1e-12)
            wanted, torque = np.array([0.1, -0.2, 0.15]), np.zeros(3)
            turned.py_func(out, wanted, np.inf, torque)
            moves = step * np.eye(3)
            ahead, behind = (chain_positions(device.mechanism, angles + sign * moves) for sign in (1.0, -1.0))
            by_drawn = np.linalg.solve(jacobian(best.geometry, there), (ahead - behind).T / (2.0 * step))
            np.testing.assert_allclose(torque, by_drawn.T @ wanted, atol=1e-8)
