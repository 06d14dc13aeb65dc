"""Affine forms of four symbols against exact fractions and 60 decimal digits."""

from __future__ import annotations

from decimal import Decimal, localcontext
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from optimizer.globalopt import affine_form as forms

number = st.floats(-1e3, 1e3).filter(lambda v: v == 0.0 or abs(v) > 1e-12)
small = st.floats(0.0, 1.0)
inside = st.floats(-1.0, 1.0)
form = st.tuples(number, number, number, number, number, small)
place = st.tuples(inside, inside, inside, inside)


def value(f: tuple[float, ...], u: tuple[float, ...], d: float) -> Fraction:
    """What a form stands for at a place, exactly."""
    linear = sum((Fraction(s) * Fraction(x) for s, x in zip(f[1:5], u, strict=True)), Fraction(f[0]))
    return linear + Fraction(f[5]) * Fraction(d)


def holds(f: tuple[float, ...], u: tuple[float, ...], exact: Fraction) -> bool:
    """Whether a form contains an exact value at a place."""
    return abs(exact - value(f, u, 0.0)) <= Fraction(f[5])


@settings(max_examples=300, deadline=None)
@given(form, form, place, inside, inside, number)
def test_sum_difference_and_products_contain_the_exact_result(
    a: tuple[float, ...], b: tuple[float, ...], u: tuple[float, ...], d: float, e: float, k: float
) -> None:
    x, y = value(a, u, d), value(b, u, e)
    assert holds(forms.add(a, b), u, x + y)
    assert holds(forms.subtract(a, b), u, x - y)
    assert holds(forms.multiply(a, b), u, x * y)
    assert holds(forms.scale(k, a), u, Fraction(k) * x)
    assert forms.lower(a) <= x <= forms.upper(a)
    assert abs(x) <= forms.magnitude(a)


@settings(max_examples=300, deadline=None)
@given(form, place, inside)
def test_root_and_inverse_contain_the_exact_result(a: tuple[float, ...], u: tuple[float, ...], d: float) -> None:
    x = value(a, u, d)
    if x >= 0 and forms.upper(a) >= 1e-15:  # below that the range's end is lifted, which contains all the more
        with localcontext() as context:
            context.prec = 60
            r = (Decimal(x.numerator) / Decimal(x.denominator)).sqrt()
            assert holds(forms.root(a), u, Fraction(r))
    if x > Fraction(1, 10**6):
        assert holds(forms.inverse(a, min(float(x), 1e3) * (1.0 - 1e-15)), u, 1 / x)


def test_a_form_whose_range_crosses_zero_has_the_roots_of_what_is_not_negative() -> None:
    a = (0.5, 1.0, 0.0, 0.0, 0.0, 0.0)
    r = forms.root(a)
    for u in np.linspace(-0.5, 1.0, 31):
        assert abs(np.sqrt(max(0.5 + u, 0.0)) - (r[0] + r[1] * u)) <= r[5]


@pytest.mark.parametrize(
    "pair", [((1.0, 0.1, 0, 0, 0, 0.0),) * 2, ((1.0, 0, 0.1, 0, 0, 0.0), (2.0, 0.1, 0.2, 0, 0.1, 0.0))]
)
def test_a_product_is_right_to_second_order(pair: tuple[tuple[float, ...], tuple[float, ...]]) -> None:
    """Halving the slopes leaves a quarter of the error."""
    widths = []
    for f in (1.0, 0.5):
        a, b = (tuple(v * (f if 1 <= i <= 4 else 1.0) for i, v in enumerate(one)) for one in pair)
        widths.append(forms.multiply(a, b)[5])
    assert widths[1] == pytest.approx(widths[0] / 4.0, rel=1e-9)
