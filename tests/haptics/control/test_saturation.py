"""Saturation against linear programming and its four promises: limits, direction, the largest factor, gravity first."""

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import linprog

from delta_cad.mechanism import DeltaGeometry, inverse_jacobian, jacobian
from haptics.control.saturation import saturate
from haptics.rendering import force
from haptics.rendering.laws.operating_resistance import PAPER_SETTINGS

PROPERTY = settings(max_examples=300, deadline=None)
EPS = np.finfo(float).eps
GEOMETRY = DeltaGeometry(0.040, 0.030, 0.082, 0.112079)


class Saturated(NamedTuple):
    torque: np.ndarray
    factor: float


def saturated(gravity, push, limit):
    out = np.empty(3)
    given_ = (np.array(np.broadcast_to(a, 3), dtype=float) for a in (gravity, push, limit))
    return Saturated(factor=saturate(*given_, out), torque=out)


def triples(low, high):
    return st.tuples(*[st.floats(low, high, allow_subnormal=False)] * 3).map(np.array)


gravities = triples(-0.5, 0.5)
pushes = st.one_of(triples(-2.0, 2.0), triples(-1e-6, 1e-6), triples(-1e6, 1e6))
limits = triples(0.5, 1.0)


@PROPERTY
@given(triples(-2.0, 2.0), pushes, triples(0.0, 1.0))
def test_no_joint_exceeds_its_limit_whatever_is_required(gravity, push, limit):
    torque, factor = saturated(gravity, push, limit)
    assert (np.abs(torque) <= limit).all()
    assert 0.0 <= factor <= 1.0


@PROPERTY
@given(gravities, pushes, limits)
def test_direction_is_kept_and_the_factor_is_reported(gravity, push, limit):
    torque, factor = saturated(gravity, push, limit)
    # gravity is whole, and the rest is factor times what was asked: a sum and a product, each rounded
    np.testing.assert_allclose(torque - gravity, factor * push, rtol=0, atol=4 * EPS)


@PROPERTY
@given(gravities, pushes, limits)
def test_no_larger_factor_is_possible(gravity, push, limit):
    factor = saturated(gravity, push, limit).factor
    if factor < 1.0:
        more = gravity + factor * (1 + 1e-9) * push
        slack = 8 * EPS  # of the limit, 1 N m: where the force's part is less than 1e-7 of it, 1e-9 more is rounding
        assert (np.abs(more) > limit - slack).any()
    else:
        assert (np.abs(gravity + push) <= limit + 2 * EPS).all()


@settings(max_examples=60, deadline=None)
@given(gravities, st.tuples(*[st.integers(-2000, 2000)] * 3), limits)
def test_factor_is_that_of_the_linear_programme(gravity, push_mN_m, limit):
    push = np.array(push_mN_m) / 1e3  # whole mN m: the solver takes less than its own tolerance for nothing
    rows = np.concatenate([push, -push])[:, None]
    best = linprog([-1.0], A_ub=rows, b_ub=np.concatenate([limit - gravity, limit + gravity]), bounds=[(0, 1)])
    # the solver's feasibility is 1e-7, seen through the largest push
    assert saturated(gravity, push, limit).factor == pytest.approx(best.x[0], abs=1e-6 / max(1e-3, np.abs(push).max()))


def test_factor_by_hand():
    torque, factor = saturated((0.1, -0.2, 0.0), (1.4, 0.2, -0.4), (0.8, 0.8, 0.8))
    assert factor == pytest.approx(0.5, abs=EPS)  # the first joint: 0.8 = 0.1 + 0.5 * 1.4
    np.testing.assert_allclose(torque, (0.8, -0.1, -0.2), rtol=0, atol=2 * EPS)


def test_each_joint_has_its_own_limit():
    assert saturated((0, 0, 0), (1, 1, 1), (0.5, 0.25, 2.0)).factor == 0.25
    assert saturated((0, 0, 0), (1, 1, 1), 0.5).factor == 0.5


def test_force_that_relieves_gravity_may_be_larger_than_the_limit():
    torque, factor = saturated((0.7, 0, 0), (-1.5, 0, 0), 0.8)
    assert factor == 1.0
    assert torque[0] == pytest.approx(-0.8, abs=2 * EPS)


@pytest.mark.parametrize("push", [(-0.5, 0.1, 0.1), (0.5, 0.1, 0.1), (0, 0, 0)])
@pytest.mark.parametrize("sign", [1, -1])
def test_gravity_beyond_the_limit_is_clipped_and_leaves_no_force(push, sign):
    torque, factor = saturated((0.9 * sign, 0.3, 0), push, 0.8)
    assert factor == 0.0
    np.testing.assert_array_equal(torque, (0.8 * sign, 0.3, 0))


def test_gravity_at_the_limit_lets_only_relief_through():
    assert saturated((0.8, 0, 0), (0.1, 0.1, 0), 0.8).factor == 0.0
    assert saturated((0.8, 0, 0), (-0.1, 0.1, 0), 0.8).factor == 1.0


def test_no_torque_at_all():
    torque, factor = saturated((0, 0, 0), (0, 0, 0), 0.0)
    np.testing.assert_array_equal(torque, 0.0)
    assert factor == 1.0


def test_force_of_the_first_setting_is_cut_to_the_limit_in_its_direction():
    """Eq. (23) asks for 3.4 N; a torque limit that allows 3 N in this direction gives 3 N in this direction."""
    p = np.array([0.02, -0.01, 0.10])
    j = jacobian(GEOMETRY, p)
    wanted = force(replace(PAPER_SETTINGS["k0.4"], origin=(0, 0, 0.08)), p)
    allowed = 3.0 / 3.4 * np.abs(j.T @ wanted).max()
    torque, factor = saturated((0, 0, 0), j.T @ wanted, allowed)
    given_ = inverse_jacobian(GEOMETRY, p).T @ torque
    np.testing.assert_allclose(given_, wanted * 3.0 / 3.4, rtol=1e-12, atol=0)  # rounding through J and its inverse
    assert factor == pytest.approx(3.0 / 3.4, rel=1e-12)  # rounding
    assert np.linalg.norm(given_) == pytest.approx(3.0, rel=1e-12)  # rounding


@pytest.mark.parametrize("bad", [math.nan, math.inf, -math.inf])
@pytest.mark.parametrize("joint", range(3))
def test_kernel_gives_finite_torque_whatever_it_is_given(bad, joint):
    limit, out = np.full(3, 0.8), np.empty(3)
    gravity, push = np.array([0.1, 0.2, 0.3]), np.array([0.1, -0.1, 0.2])
    wrong = push.copy()
    wrong[joint] = bad
    assert saturate(gravity, wrong, limit, out) == 0.0
    np.testing.assert_array_equal(out, gravity)
    wrong = gravity.copy()
    wrong[joint] = bad
    assert saturate(wrong, push, limit, out) == 0.0
    expected = gravity.copy()
    expected[joint] = 0.0 if math.isnan(bad) else math.copysign(0.8, bad)
    np.testing.assert_array_equal(out, expected)


def test_kernel_may_write_over_its_arguments():
    limit = np.full(3, 0.8)
    for place in (0, 1):
        arguments = [np.array([0.1, 0.2, 0.3]), np.array([0.7, -3.0, 0.2])]
        expected = saturated(*arguments, limit)
        assert saturate(*arguments, limit, arguments[place]) == expected.factor
        np.testing.assert_array_equal(arguments[place], expected.torque)
