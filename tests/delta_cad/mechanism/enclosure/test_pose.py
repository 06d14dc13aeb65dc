"""The numbers of a mechanism that the forms start from: rounded ones are within the error that is said."""

from fractions import Fraction

import numpy as np
from hypothesis import given

from delta_cad.mechanism.enclosure.pose import NUMBERS, SIN_60_ERROR, azimuth_numbers, lengths
from delta_cad.mechanism.geometry import SIN_60, THREE_FOLD
from tests.delta_cad.mechanism.oracles import PROPERTY, mechanisms, placed_mechanisms


@PROPERTY
@given(mechanisms() | placed_mechanisms())
def test_differences_are_within_the_error_that_is_said(g):
    numbers = lengths(g, 0.001)
    assert len(numbers) == NUMBERS
    a, a_error, la, lb, squares, error, tolerance, side, side_error, *_ = map(Fraction, numbers)
    big, small = Fraction(g.base_radius), Fraction(g.platform_radius)
    assert (la, lb, tolerance) == (*map(Fraction, (g.upper_arm_length, g.forearm_length)), Fraction(0.001))
    assert abs(big - small - a) <= a_error
    assert abs(big + Fraction(g.side_shift) - small - side) <= side_error
    assert g.side_shift != 0.0 or numbers[7:9] == numbers[:2]
    assert abs(la**2 - lb**2 - squares) <= error


def test_the_root_of_three_quarters_is_within_its_error():
    low, high = Fraction(SIN_60) - Fraction(SIN_60_ERROR), Fraction(SIN_60) + Fraction(SIN_60_ERROR)
    assert low**2 <= Fraction(3, 4) <= high**2
    assert azimuth_numbers(THREE_FOLD) == (-0.5, SIN_60, SIN_60_ERROR, 0.75, 0.0)


def test_the_sine_of_an_azimuth_is_within_its_error_which_is_no_more_than_three_times_what_it_can_be():
    rng, worst = np.random.default_rng(1), np.zeros(2)
    for cosine in (
        0.0,
        0.5,
        -0.75,
        -0.8660254037844386,
        1e-300,
        -0.5000000000000001,
        *rng.uniform(-0.866, 0.5, 20_000),
    ):
        c, s, error, square, square_error = map(Fraction, azimuth_numbers(float(cosine)))
        assert c == Fraction(float(cosine))
        exact = 1 - c**2
        assert (s - error) ** 2 <= exact <= (s + error) ** 2
        assert abs(square - exact) <= square_error
        # the root's own error to first order, its unit 2^-53
        own = abs(float((s**2 - exact) / (2 * s))), abs(float(square - exact))
        worst = np.maximum(worst, np.array(own) * 2.0**53)
    assert (worst > [1.0, 4.0 / 3.0]).all()
    assert (worst <= [3.0, 4.0]).all()
