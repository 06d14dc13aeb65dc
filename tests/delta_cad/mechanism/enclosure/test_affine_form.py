"""Every operation of the affine forms contains the exact result, rounding included; the oracle is rational."""

from decimal import Decimal, localcontext
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from delta_cad.mechanism.enclosure import affine_form as affine
from delta_cad.mechanism.enclosure.affine_form import FEASIBLE_ROOT_MIN, SYMBOLS, TERMS

PROPERTY = settings(deadline=None, derandomize=True, max_examples=300)
NUMBER = st.one_of(
    st.floats(-4.0, 4.0, allow_subnormal=False), st.sampled_from([0.0, 0.1, -0.3, 1.0, 1e-8, 3e-160, 1e-300])
)
WIDTH = st.one_of(st.just(0.0), st.floats(0.0, 2.0, allow_subnormal=False))
FORM = st.tuples(NUMBER, WIDTH, NUMBER, st.one_of(st.just(0.0), NUMBER), NUMBER, WIDTH)
NOISE = st.one_of(st.sampled_from([-1.0, 0.0, 1.0]), st.floats(-1.0, 1.0))
NOISES = st.tuples(NOISE, NOISE, NOISE, NOISE)
# as boxes of designs have them: numbers of any size, none of them so small that a product of two underflows
LARGE = st.floats(-1e3, 1e3).filter(lambda v: v == 0.0 or abs(v) > 1e-12)
LARGE_FORM = st.tuples(LARGE, LARGE, LARGE, LARGE, LARGE, st.floats(0.0, 1.0))


def value(form, noises, own):
    """The exact number that a form takes for one choice of its noises."""
    c, *slopes, e = map(Fraction, form)
    return c + sum(s * Fraction(u) for s, u in zip(slopes, noises, strict=True)) + e * Fraction(own)


def contains(form, noises, exact):
    """Whether the form can take a value once the shared noises are chosen."""
    return abs(exact - value((*form[:-1], 0.0), noises, 0.0)) <= Fraction(form[-1])


def square_root(x):
    """To 60 digits, against the 16 of a form: the root's own rounding cannot decide."""
    with localcontext() as context:
        context.prec = 60
        return Fraction((Decimal(x.numerator) / Decimal(x.denominator)).sqrt())


def positive(form):
    return (abs(form[0]) + sum(abs(s) for s in form[1:]) + 1e-3, *form[1:])


def test_a_form_is_a_centre_four_slopes_and_an_error():
    assert (SYMBOLS, TERMS) == (4, 6)
    assert affine.constant(2.5, 1e-3) == (2.5, 0.0, 0.0, 0.0, 0.0, 1e-3)


def test_a_table_gives_back_what_was_put_into_it():
    table = np.full((3, TERMS), np.nan)
    form = (1.0, 2.0, 3.0, 4.0, 5.0, 6.0)
    affine.put(table, 1, form)
    assert affine.at(table, 1) == form
    assert np.isnan(table[[0, 2]]).all()


@PROPERTY
@given(st.one_of(FORM, LARGE_FORM), st.one_of(FORM, LARGE_FORM), NOISES, NOISE, NOISE)
def test_sum_difference_and_product(a, b, noises, own, other):
    p, q = value(a, noises, own), value(b, noises, other)
    assert contains(affine.add(a, b), noises, p + q)
    assert contains(affine.subtract(a, b), noises, p - q)
    assert contains(affine.multiply(a, b), noises, p * q)
    assert contains(affine.multiply(a, a), noises, p * p)


@PROPERTY
@given(st.one_of(NUMBER, LARGE), st.one_of(FORM, LARGE_FORM), NOISES, NOISE)
def test_product_with_a_number(k, a, noises, own):
    assert contains(affine.scale(k, a), noises, Fraction(k) * value(a, noises, own))


@PROPERTY
@given(st.one_of(FORM, LARGE_FORM), NOISES, NOISE)
def test_bounds(a, noises, own):
    exact = value(a, noises, own)
    assert Fraction(affine.lower(a)) <= exact <= Fraction(affine.upper(a))
    assert abs(exact) <= Fraction(affine.magnitude(a))
    assert Fraction(affine.slope(a)) >= sum(abs(Fraction(x)) for x in a[1:-1])


@PROPERTY
@given(FORM, NOISES, NOISE)
def test_inverse(a, noises, own):
    a = positive(a)
    exact = value(a, noises, own)
    assume(exact > 0)
    assert contains(affine.inverse(a), noises, 1 / exact)


@PROPERTY
@given(FORM, NOISES, NOISE)
def test_root(a, noises, own):
    a = positive(a)
    exact = value(a, noises, own)
    assert contains(affine.root(a), noises, square_root(exact))


@PROPERTY
@given(LARGE_FORM, NOISES, NOISE)
def test_root_and_inverse_where_they_have_a_meaning(a, noises, own):
    """The range of the form may go below zero; what the form takes where it does not is contained."""
    exact = value(a, noises, own)
    if exact >= 0 and affine.upper(a) >= FEASIBLE_ROOT_MIN:  # below that the end is lifted: contained all the more
        assert contains(affine.root_where_feasible(a), noises, square_root(exact))
    if exact > Fraction(1, 10**6):
        assert contains(affine.inverse_above(a, min(float(exact), 1e3) * (1.0 - 1e-15)), noises, 1 / exact)


@pytest.mark.parametrize("symbol", range(1, 5))
def test_a_form_whose_range_crosses_zero_has_the_roots_of_what_is_not_negative(symbol):
    a = [0.5, 0.0, 0.0, 0.0, 0.0, 0.0]
    a[symbol] = 1.0
    r = affine.root_where_feasible(tuple(a))
    for u in np.linspace(-0.5, 1.0, 31):
        assert abs(np.sqrt(max(0.5 + u, 0.0)) - (r[0] + r[symbol] * u)) <= r[5]


@PROPERTY
@given(st.floats(0.01, 4.0), st.floats(0.01, 4.0))
def test_a_point_stays_nearly_one(a, b):
    # width of a few roundings: bounds that are safe but useless would decide nothing
    p, q = affine.constant(a, 0.0), affine.constant(b, 0.0)
    for form in (affine.add(p, q), affine.multiply(p, q), affine.inverse(p), affine.root(p)):
        assert affine.upper(form) - affine.lower(form) <= 1e-13 * affine.magnitude(form)


def test_a_linear_function_is_nearly_exact():
    form = affine.add((1.0, 0.1, 0.0, 0.0, -0.4, 0.0), (2.0, -0.1, 0.2, 0.0, 0.1, 0.0))
    assert form[:-1] == (3.0, 0.0, 0.2, 0.0, pytest.approx(-0.3, rel=1e-15))
    assert form[-1] < 1e-13


@pytest.mark.parametrize("symbol", range(1, 5))
def test_square_root_and_inverse_are_right_to_second_order_in_every_symbol(symbol):
    for h in (1e-2, 1e-3):
        one = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0]
        one[symbol] = h
        square, root, inverse = (
            affine.multiply(tuple(one), tuple(one)),
            affine.root(tuple(one)),
            affine.inverse(tuple(one)),
        )
        # remainders of Chebyshev's approximations: h^2/2, h^2/16 and h^2/2 to leading order
        for form, linear, leading in ((square, 2.0, 0.5), (root, 0.5, 0.0625), (inverse, -1.0, 0.5)):
            assert form[symbol] == pytest.approx(linear * h, rel=h)
            assert 0.9 * leading * h * h < form[-1] < 1.2 * leading * h * h


@pytest.mark.parametrize(
    "pair",
    [
        ((1.0, 0.1, 0.0, 0.0, 0.0, 0.0),) * 2,
        ((1.0, 0.0, 0.0, 0.0, 0.1, 0.0),) * 2,
        ((1.0, 0.0, 0.1, 0.0, 0.0, 0.0), (2.0, 0.1, 0.2, 0.0, 0.1, 0.0)),
    ],
)
def test_halving_the_slopes_of_a_product_leaves_a_quarter_of_the_error(pair):
    widths = []
    for f in (1.0, 0.5):
        a, b = ((c, *(f * s for s in slopes), e) for c, *slopes, e in pair)
        widths.append(affine.multiply(a, b)[-1])
    assert widths[1] == pytest.approx(widths[0] / 4.0, rel=1e-9)


@pytest.mark.parametrize("symbol", range(1, 6))
def test_no_root_and_no_inverse_of_what_may_not_be_positive(symbol):
    wide = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0]
    wide[symbol] = 1.0
    for form in (tuple(wide), (-1.0, 0.0, 0.0, 0.0, 0.0, 0.0), (float("nan"), 0.0, 0.0, 0.0, 0.0, 0.0)):
        for result in (affine.root(form), affine.inverse(form)):
            assert not affine.lower(result) >= 0.0
            assert not affine.upper(result) < 0.0
