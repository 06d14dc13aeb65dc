"""Every operation of the affine forms contains the exact result, rounding included; the oracle is rational."""

from decimal import Decimal, localcontext
from fractions import Fraction

from hypothesis import assume, given, settings
from hypothesis import strategies as st

from delta_cad.mechanism.proof import affine_form as affine

PROPERTY = settings(deadline=None, derandomize=True, max_examples=300)
NUMBER = st.one_of(
    st.floats(-4.0, 4.0, allow_subnormal=False), st.sampled_from([0.0, 0.1, -0.3, 1.0, 1e-8, 3e-160, 1e-300])
)
WIDTH = st.one_of(st.just(0.0), st.floats(0.0, 2.0, allow_subnormal=False))
FORM = st.tuples(NUMBER, WIDTH, NUMBER, st.just(0.0), WIDTH)
NOISE = st.one_of(st.sampled_from([-1.0, 0.0, 1.0]), st.floats(-1.0, 1.0))
NOISES = st.tuples(NOISE, NOISE, NOISE)


def value(form, noises, own):
    """The exact number that a form takes for one choice of its noises."""
    c, x, y, z, e = map(Fraction, form)
    u, v, w = map(Fraction, noises)
    return c + x * u + y * v + z * w + e * Fraction(own)


def contains(form, noises, exact):
    """Whether the form can take a value once the shared noises are chosen."""
    return abs(exact - value((*form[:4], 0.0), noises, 0.0)) <= Fraction(form[4])


def positive(form):
    return (abs(form[0]) + abs(form[1]) + abs(form[2]) + abs(form[4]) + 1e-3, *form[1:])


@PROPERTY
@given(FORM, FORM, NOISES, NOISE, NOISE)
def test_sum_difference_and_product(a, b, noises, own, other):
    p, q = value(a, noises, own), value(b, noises, other)
    assert contains(affine.add(a, b), noises, p + q)
    assert contains(affine.subtract(a, b), noises, p - q)
    assert contains(affine.multiply(a, b), noises, p * q)
    assert contains(affine.multiply(a, a), noises, p * p)


@PROPERTY
@given(NUMBER, FORM, NOISES, NOISE)
def test_product_with_a_number(k, a, noises, own):
    assert contains(affine.scale(k, a), noises, Fraction(k) * value(a, noises, own))


@PROPERTY
@given(FORM, NOISES, NOISE)
def test_bounds(a, noises, own):
    exact = value(a, noises, own)
    assert Fraction(affine.lower(a)) <= exact <= Fraction(affine.upper(a))
    assert abs(exact) <= Fraction(affine.magnitude(a))
    assert Fraction(affine.slope(a)) >= sum(abs(Fraction(x)) for x in a[1:4])


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
    with localcontext() as context:
        context.prec = 60
        root = (Decimal(exact.numerator) / Decimal(exact.denominator)).sqrt()
        # 60 digits against the 16 of the form: the root's own rounding cannot decide
        assert contains(affine.root(a), noises, Fraction(root))


@PROPERTY
@given(st.floats(0.01, 4.0), st.floats(0.01, 4.0))
def test_a_point_stays_nearly_one(a, b):
    # width of a few roundings: bounds that are safe but useless would decide nothing
    p, q = affine.constant(a, 0.0), affine.constant(b, 0.0)
    for form in (affine.add(p, q), affine.multiply(p, q), affine.inverse(p), affine.root(p)):
        assert affine.upper(form) - affine.lower(form) <= 1e-13 * affine.magnitude(form)


def test_a_linear_function_is_nearly_exact_and_a_square_second_order():
    form = affine.add((1.0, 0.1, 0.0, 0.0, 0.0), (2.0, -0.1, 0.2, 0.0, 0.0))
    assert form[:4] == (3.0, 0.0, 0.2, 0.0)
    assert form[4] < 1e-13
    for h in (1e-2, 1e-3):
        square = affine.multiply((1.0, h, 0.0, 0.0, 0.0), (1.0, h, 0.0, 0.0, 0.0))
        root, inverse = affine.root((1.0, h, 0.0, 0.0, 0.0)), affine.inverse((1.0, h, 0.0, 0.0, 0.0))
        # remainders of Chebyshev's approximations: h^2/2, h^2/16 and h^2/2 to leading order
        for form, leading in ((square, 0.5), (root, 0.0625), (inverse, 0.5)):
            assert 0.9 * leading * h * h < form[4] < 1.2 * leading * h * h


def test_no_root_and_no_inverse_of_what_may_not_be_positive():
    for form in ((1.0, 1.0, 0.0, 0.0, 0.0), (-1.0, 0.0, 0.0, 0.0, 0.0), (float("nan"), 0.0, 0.0, 0.0, 0.0)):
        for result in (affine.root(form), affine.inverse(form)):
            assert not affine.lower(result) >= 0.0
            assert not affine.upper(result) < 0.0
