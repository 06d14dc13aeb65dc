"""Default limits of feel, against figures computed by hand."""

import math

import pytest

from delta_cad.design.feel_defaults import ACCELERATION_M_S2, feel_defaults
from optimizer.problem.brief import FEEL


@pytest.mark.parametrize(("force", "mass", "friction"), [(1.0, 0.25, 0.2), (3.0, 0.6, 0.6), (10.0, 2.0, 2.0)])
def test_they_grow_with_the_continuous_force(force: float, mass: float, friction: float) -> None:
    """A handle is light, or accelerated by the force at 5 m/s^2; a fifth of the force is friction."""
    expected = {"effective_mass_max_kg": mass, "friction_max_N": friction, "couple_index_min": 0.4}
    assert feel_defaults(force) == pytest.approx(expected)


def test_each_is_a_field_of_the_requirements() -> None:
    """A user replaces each in `[feel]`."""
    assert set(feel_defaults(3.0)) <= set(FEEL)


def test_the_acceleration_is_that_of_a_reach_of_minimum_jerk() -> None:
    """The quintic profile x = 10 s^3 - 15 s^4 + 6 s^5 of a reach of 140 mm in 0.4 s accelerates by as much at most."""
    most = max(60 * s - 180 * s**2 + 120 * s**3 for s in (k / 10_000 for k in range(10_001)))
    assert most == pytest.approx(10.0 / math.sqrt(3.0), rel=1e-6)
    assert pytest.approx(most * 0.14 / 0.4**2, rel=0.02) == ACCELERATION_M_S2
