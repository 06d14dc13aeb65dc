"""Limits that are refused, and sines to the last bit."""

import math
import re

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from delta_cad.mechanism import GeometryError
from delta_cad.mechanism.limits import (
    POSE_LIMITS,
    CoupleIndex,
    EffectiveMass,
    ElbowAngle,
    Friction,
    HandleFriction,
    HandleInertia,
    HeldMasses,
    Kappa,
    Lean,
    Limits,
    PositionStep,
    Reach,
    Shoulder,
    Torque,
)
from delta_cad.mechanism.limits.numbers import cosine_sine, strict_radians
from tests.delta_cad.mechanism.stated_limits import limits

INERTIA = HandleInertia(0.06, 0.01, 0.004, 2e-4)


@pytest.mark.parametrize(
    ("kind", "thresholds", "message"),
    [
        (Reach, (-1e-3,), "elbow_arm_min is -0.001; it must be within 0 and 10"),
        (Reach, (math.inf,), "elbow_arm_min is inf"),
        (Reach, (math.nan,), "elbow_arm_min is nan"),
        (Torque, (0.0, 0.8), "force is 0.0; it must be within 1e-06 and 1e+06 N"),
        (Torque, (3.0, math.nan), "torque_max is nan; it must be within 1e-06 and 1e+06 N m"),
        (Kappa, (0.99,), "kappa_max is 0.99; it must be within 1 and 1e+06"),
        (Kappa, (2e6,), "kappa_max is 2000000.0"),
        (Shoulder, (0.5, 0.5), "shoulder is (0.5, 0.5); it must be rising, within -pi and pi rad"),
        (Shoulder, (-4.0, 0.5), "it must be rising, within -pi and pi rad"),
        (Shoulder, (0.0, math.nan), "it must be rising"),
        (Lean, (0.0,), "lean_max is 0.0; it must be within 0 and pi/2 rad"),
        (Lean, (1.6,), "lean_max is 1.6"),
        (ElbowAngle, (-1e-9,), "angle_min is -1e-09; it must be at least 0, less than pi rad"),
        (ElbowAngle, (math.nan,), "angle_min is nan"),
        (ElbowAngle, (math.pi,), "it must be at least 0, less than pi rad"),
        (EffectiveMass, (0.0, INERTIA), "mass_max is 0.0; it must be within 1e-06 and 1e+06"),
        (EffectiveMass, (1.1e6, INERTIA), "mass_max is 1100000.0"),
        (EffectiveMass, (math.nan, INERTIA), "mass_max is nan"),
        (CoupleIndex, (-1e-9,), "couple_index_min is -1e-09; it must be within 0 and 1"),
        (CoupleIndex, (1.1,), "couple_index_min is 1.1"),
        (CoupleIndex, (math.nan,), "couple_index_min is nan"),
        (Friction, (0.0, 0.01, 0.0, 0.0), "friction_max is 0.0; it must be within 1e-06 and 1e+06"),
        (Friction, (0.5, math.inf, 0.0, 0.0), "drive is inf; it must be finite"),
        (Friction, (0.5, 0.01, -1e-9, 0.0), "upright is -1e-09; it must be within 0 and 1e6"),
        (Friction, (0.5, 0.01, 0.0, math.nan), "level is nan"),
        (PositionStep, (0.0, 1e-3), "step_max is 0.0; it must be within 1e-09 and 1000"),
        (PositionStep, (1e-4, 0.0), "count is 0.0; it must be within 1e-9 and 10 rad"),
        (PositionStep, (1e-4, math.nan), "count is nan"),
        (HandleInertia, (-1e-9, 0.01, 0.0, 0.0), "carried_mass is -1e-09; it must be within 0 and 1e6"),
        (HandleInertia, (0.1, math.inf, 0.0, 0.0), "elbow_mass is inf; it must be within 0 and 1e6"),
        (HandleInertia, (0.1, 0.01, -2e6, 0.0), "cross_mass is -2000000.0; it must be within -1e+06 and 1e6"),
        (HandleInertia, (0.1, 0.01, 0.0, math.nan), "joint_inertia is nan; it must be within 0 and 1e6"),
    ],
)
def test_limits_that_mean_nothing_are_refused(kind, thresholds, message):
    with pytest.raises(GeometryError, match=re.escape(message)):
        kind(*thresholds)


@pytest.mark.parametrize(
    ("data", "message"),
    [
        ({"force_N": 3.0}, "force_N and torque_max_N_m belong together"),
        ({"torque_max_N_m": 3.0}, "force_N and torque_max_N_m belong together"),
        ({"effective_mass_max_kg": 0.2}, "effective_mass_max_kg and inertia belong together"),
        ({"inertia": {"carried_mass_kg": 0.1}}, "effective_mass_max_kg and inertia belong together"),
        (
            {"friction_max_N": 0.5},
            "friction_max_N and joint_friction_N_m and .* belong",
        ),
        ({"encoder_count_rad": 1e-3}, "position_step_max_m and encoder_count_rad belong together"),
        (
            {"effective_mass_max_kg": 0.2, "inertia": {"carried_mass_kg": 0.1}},
            "inertia must have carried_mass_kg, elbow_mass_kg, cross_mass_kg, joint_inertia_kg_m2",
        ),
        ({"effective_mass_max_kg": 0.2, "inertia": 0.1}, "inertia must have carried_mass_kg"),
    ],
)
def test_numbers_of_a_certificate_that_belong_together(data, message):
    with pytest.raises(GeometryError, match=message):
        Limits.from_record(data)


def test_an_effective_mass_is_required_only_where_the_masses_are_known():
    with pytest.raises(GeometryError, match=re.escape("effective_mass_max_kg needs the masses of what moves")):
        EffectiveMass.stated({"effective_mass_max_kg": 0.2})
    assert EffectiveMass.stated({"inertia": INERTIA}) is None
    assert EffectiveMass.stated({"effective_mass_max_kg": 0.2, "inertia": INERTIA}) == EffectiveMass(0.2, INERTIA)


def test_what_is_felt_of_the_joints_is_required_only_where_they_are_known():
    sources = HandleFriction(0.01, 0.02, 0.03)
    with pytest.raises(GeometryError, match="friction_max_N needs what sources"):
        Friction.stated({"friction_max_N": 0.5})
    with pytest.raises(GeometryError, match="position_step_max_mm needs the count"):
        PositionStep.stated({"position_step_max_mm": 0.05, "friction": sources})
    assert Friction.stated({"friction": sources}) is PositionStep.stated({"encoder_count": 1e-3}) is None
    assert Friction.stated({"friction_max_N": 0.5, "friction": sources}) == Friction(0.5, *sources)
    assert PositionStep.stated({"position_step_max_mm": 0.05, "encoder_count": 1e-3}) == PositionStep(5e-5, 1e-3)


def test_what_is_required():
    assert limits().names == ("reach", "assembly_mode")
    assert limits(assembly_mode=False).names == ("reach",)
    every = limits(
        force=3.0,
        torque_max=0.8,
        kappa_max=2.0,
        shoulder=(-1.0, 1.0),
        lean_max=0.5,
        mass_max=0.2,
        inertia=INERTIA,
        couple_index_min=0.4,
        held=(3.0, 0.8, HeldMasses(0.0, 0.0, -9.81, 0.1, 0.0, 0.0, 0.0, 0.0)),
        friction=(0.5, HandleFriction(0.01, 0.02, 0.03)),
        step=(5e-5, 1e-3),
        elbow_angle_min=0.5,
    )
    assert every.names == tuple(kind.name for kind in POSE_LIMITS)
    assert every["lean"] == Lean(0.5)
    with pytest.raises(KeyError):
        limits()["lean"]


def test_of_two_of_a_kind_the_later_one_counts():
    assert Limits.of(Kappa(2.0), None, Kappa(3.0)).get(Kappa) == Kappa(3.0)
    assert limits(kappa_max=2.0).with_(Kappa(3.0)) == limits(kappa_max=3.0)


@settings(deadline=None, derandomize=True)
@given(st.floats(-180.0, 180.0))
def test_degrees_become_radians_on_the_strict_side(degrees):
    assert strict_radians(degrees, -math.inf) < math.radians(degrees) < strict_radians(degrees, math.inf)
    assert strict_radians(degrees, math.inf) - strict_radians(degrees, -math.inf) <= 4 * math.ulp(math.pi)


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
