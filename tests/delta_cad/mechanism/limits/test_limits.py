"""Limits that are refused, and sines to the last bit."""

import math

import pytest
from delta_cad.mechanism.proof.limits import CONDITIONS, Limits, cosine_sine
from hypothesis import given, settings
from hypothesis import strategies as st

from delta_cad.mechanism import GeometryError


@pytest.mark.parametrize(
    ("given_limits", "message"),
    [
        ({"elbow_arm_min": -1e-3}, "elbow_arm_min is -0.001; it must be at least 0 m and finite"),
        ({"elbow_arm_min": math.inf}, "elbow_arm_min is inf"),
        ({"force": 3.0}, "force and torque_max belong together"),
        ({"torque_max": 3.0}, "force and torque_max belong together"),
        ({"force": 0.0, "torque_max": 0.8}, "force is 0.0; it must be within 1e-6 and 1e6 N"),
        ({"force": 3.0, "torque_max": math.nan}, "torque_max is nan; it must be within 1e-6 and 1e6 N m"),
        ({"kappa_max": 0.99}, "kappa_max is 0.99; it must be within 1 and 1e6"),
        ({"shoulder": (0.5, 0.5)}, "it must be rising, within -pi and pi rad"),
        ({"shoulder": (-4.0, 0.5)}, "it must be rising, within -pi and pi rad"),
        ({"lean_max": 0.0}, "lean_max is 0.0; it must be within 0 and pi/2 rad"),
        ({"lean_max": 1.6}, "lean_max is 1.6"),
    ],
)
def test_limits_that_mean_nothing_are_refused(given_limits, message):
    with pytest.raises(GeometryError, match=message.replace("(", r"\(")):
        Limits(**given_limits)


def test_what_is_asked():
    assert Limits().asked == ("reach", "singularity")
    assert Limits(singularity=False).asked == ("reach",)
    every = Limits(force=3.0, torque_max=0.8, kappa_max=2.0, shoulder=(-1.0, 1.0), lean_max=0.5)
    assert every.asked == CONDITIONS


@settings(deadline=None, derandomize=True)
@given(st.floats(-math.pi, math.pi), st.floats(-math.pi, math.pi))
def test_cosine_and_sine_of_half_a_sum(a, b):
    c, s = cosine_sine(a, b)
    half = (a + b) / 2
    # the library's functions and the rounded sum are each off by about one last place
    assert c == pytest.approx(math.cos(half), abs=1e-15)
    assert s == pytest.approx(math.sin(half), abs=1e-15)


def test_cosine_and_sine_at_known_angles():
    assert cosine_sine(0.0) == (1.0, 0.0)
    c, s = cosine_sine(math.pi, math.pi)
    # sin(pi as a double) is what pi's rounding leaves: 1.2246467991473532e-16
    assert (c, s) == (-1.0, pytest.approx(1.2246467991473532e-16, rel=1e-15))
