"""What a start-up expects of a torque, against the inverse of the joints' mass matrix."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from haptics.control.startup.steps import _mobility


@pytest.mark.parametrize("joint", range(3))
def test_the_mobility_is_the_inverse_mass_matrix_s(joint: int) -> None:
    """1/(kg m^2); rows of the work are the velocity of the handle by each joint, so that M = I + m W W^T."""
    rng, par = np.random.default_rng(4), SimpleNamespace(inertia=2.1e-4, carried=0.09)
    for work in rng.normal(0.0, 0.08, (20, 3, 3)):
        expected = np.linalg.inv(2.1e-4 * np.eye(3) + 0.09 * work @ work.T)[joint, joint]
        assert _mobility.py_func(par, work, joint) == pytest.approx(expected, rel=1e-9)
