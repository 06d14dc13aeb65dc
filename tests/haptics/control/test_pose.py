"""The controller's scalar pose against the mechanism's arrays, which were derived and tested on their own."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from delta_cad.drive.masses import Masses
from delta_cad.mechanism import (
    DeltaGeometry,
    closure_margin,
    forearm_vectors,
    forward_kinematics,
    inverse_kinematics,
    jacobian,
)
from haptics.control.pose import HOLDING, POSITION, ROWS, model, pose
from haptics.gravity import gravity_torque

GEOMETRY = DeltaGeometry(0.040, 0.030, 0.082, 0.112079)
MASSES = Masses(0.07, 0.0013, -0.0003, 1.5e-4, 0.002, 0.0008, 0.0021, 3.2e-4)
TILTED = (2.0, -3.0, -8.0)
KNOWN = model(GEOMETRY, MASSES, TILTED)

inside = st.tuples(st.floats(-0.0375, 0.0375), st.floats(-0.0375, 0.0375), st.floats(0.057112, 0.132112))


@given(inside)
@settings(deadline=None)  # the first call compiles
def test_it_is_what_the_mechanism_says(p: Any) -> None:
    theta, out = inverse_kinematics(GEOMETRY, p), np.full((ROWS, 3), 7.0)
    reach, volume = pose(KNOWN, theta, out)
    assert out[POSITION] == pytest.approx(forward_kinematics(GEOMETRY, theta), abs=1e-14)
    assert out[POSITION] == pytest.approx(np.array(p), abs=1e-13)
    J = jacobian(GEOMETRY, p)
    assert pytest.approx(J, abs=1e-11 * np.abs(J).max()) == out[:3].T
    assert out[HOLDING] == pytest.approx(gravity_torque(GEOMETRY, MASSES, p, TILTED), abs=1e-12)
    assert reach == pytest.approx(np.sqrt(closure_margin(GEOMETRY, p).min()), rel=1e-10)
    determinant = np.linalg.det(forearm_vectors(GEOMETRY, p))
    assert volume == pytest.approx(determinant / GEOMETRY.forearm_length**3, rel=1e-10)
    assert (out[4] == 7.0).all()


@pytest.mark.parametrize("theta", [(1.5, -1.5, -1.5), (np.nan, 0.0, 0.0), (0.0, np.inf, 0.0)])
def test_angles_without_a_position_give_nan_margins(theta: Any) -> None:
    if np.isfinite(theta).all():
        short = DeltaGeometry(0.3, 0.03, 0.082, 0.112079)  # the spheres are too far apart
        known = model(short, MASSES, TILTED)
    else:
        known = KNOWN
    reach, volume = pose(known, np.array(theta), np.empty((ROWS, 3)))
    assert np.isnan(reach)
    assert np.isnan(volume)
