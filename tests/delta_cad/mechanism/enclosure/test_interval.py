"""Interval slopes contain the exact results, rounding included; the oracle is rational arithmetic."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from delta_cad.mechanism.enclosure.interval import Interval, exactly, variables

PROPERTY = settings(deadline=None, derandomize=True, max_examples=200)
NUMBER = st.one_of(st.floats(-4.0, 4.0, allow_subnormal=False), st.sampled_from([0.0, 0.1, -0.3, 1e-8]))
PART = st.one_of(st.sampled_from([0.0, 0.5, 1.0]), st.floats(0.0, 1.0))


def between(a, b, part):
    """A double of [a, b], a <= b."""
    return min(max(a + part * (b - a), a), b)


def holds(interval, exact):
    return Fraction(float(interval.lo)) <= exact <= Fraction(float(interval.hi))


@PROPERTY
@given(NUMBER, NUMBER, NUMBER, NUMBER, PART, PART)
def test_intervals(a, b, c, d, u, v):
    x, y = Interval(*np.sort([a, b])), Interval(*np.sort([c, d]))
    p, q = (Fraction(float(between(i.lo, i.hi, w))) for i, w in ((x, u), (y, v)))
    for found, exact in ((x + y, p + q), (x - y, p - q), (x * y, p * q), (-x, -p), (x.square(), p * p)):
        assert holds(found, exact)
    z = x + exactly(9.0)
    assert holds(z.inverse(), 1 / (p + 9))
    root = z.root()
    assert Fraction(float(root.lo)) ** 2 <= p + 9 <= Fraction(float(root.hi)) ** 2


def test_results_are_moved_to_the_very_next_double():
    """By one, and by two at most where doubles end; adding 0 is exact, so that nothing else moves them."""
    rng = np.random.default_rng(0)
    powers = np.ldexp(1.0, np.arange(-1074, 1023))
    any_size = np.ldexp(rng.uniform(1.0, 2.0, 20_000), rng.integers(-1074, 1023, 20_000))
    x = np.concatenate([[0.0], powers, np.nextafter(powers, np.inf), np.nextafter(powers, 0.0), any_size])
    for signed in (x, -x):
        found = exactly(signed) + exactly(np.zeros_like(x))
        low, high = np.nextafter(signed, -np.inf), np.nextafter(signed, np.inf)
        usual = np.abs(signed) > 1e-307
        assert usual.sum() > 10_000
        np.testing.assert_array_equal(found.lo[usual], low[usual])
        np.testing.assert_array_equal(found.hi[usual], high[usual])
        assert ((np.nextafter(low, -np.inf) <= found.lo) & (found.lo <= low)).all()
        assert ((high <= found.hi) & (found.hi <= np.nextafter(high, np.inf))).all()


def test_no_root_and_no_inverse_of_what_may_not_be_positive():
    for x in (Interval(np.float64(0.0), np.float64(1.0)), Interval(np.float64(-1.0), np.float64(-0.5))):
        assert np.isnan(x.inverse().lo)
        assert np.isnan(x.root().hi)


CORNER = st.tuples(NUMBER, NUMBER, NUMBER)


@PROPERTY
@given(CORNER, CORNER, st.tuples(PART, PART, PART))
def test_slope_forms(a, b, parts):
    lower, upper = np.minimum(a, b), np.maximum(a, b)
    point = [Fraction(float(between(lo, hi, u))) for lo, hi, u in zip(lower, upper, parts, strict=True)]
    x, y, z = variables(lower[None], upper[None])
    p, q, r = point
    centre = [Fraction(float(v.centre.lo[0])) for v in (x, y, z)]
    third = exactly(1.0) * exactly(3.0).inverse()
    positive, exact_positive = (x.square() + y * z.square()).square().plus(exactly(0.5)), (p * p + q * r * r) ** 2
    exact_positive += Fraction(1, 2)
    centre_positive = (centre[0] ** 2 + centre[1] * centre[2] ** 2) ** 2 + Fraction(1, 2)
    cases = [
        (x + y, p + q, centre[0] + centre[1]),
        (x - z, p - r, centre[0] - centre[2]),
        (x * y, p * q, centre[0] * centre[1]),
        (x * x.square(), p**3, centre[0] ** 3),
        (y.times(third), q / 3, centre[1] / 3),
        (positive.inverse(), 1 / exact_positive, 1 / centre_positive),
        (positive.root() * positive.root(), exact_positive, centre_positive),
        (positive, exact_positive, centre_positive),
    ]
    for form, exact, at_centre in cases:
        assert Fraction(float(form.box.lo[0])) <= exact <= Fraction(float(form.box.hi[0]))
        assert Fraction(float(form.centre.lo[0])) <= at_centre <= Fraction(float(form.centre.hi[0]))
        low = high = Fraction(0)
        for i in range(3):
            ends = [Fraction(float(s)) * (point[i] - centre[i]) for s in (form.slope.lo[i, 0], form.slope.hi[i, 0])]
            low, high = low + min(ends), high + max(ends)
        rounding = Fraction(float(form.centre.hi[0])) - Fraction(float(form.centre.lo[0]))
        assert low - rounding <= exact - at_centre <= high + rounding


@pytest.mark.parametrize("h", [1e-1, 1e-2])
def test_slopes_make_the_error_second_order(h):
    x, _, _ = variables(np.array([[1.0 - h, 0.0, 0.0]]), np.array([[1.0 + h, 0.0, 0.0]]))
    form = x * x - x.times(exactly(2.0))  # (x - 1)^2 - 1: plain intervals give a width of 8 h
    assert (form.box.hi - form.box.lo)[0] < 5.0 * h * h
