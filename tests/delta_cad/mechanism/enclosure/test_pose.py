"""The numbers of a mechanism that the forms start from: rounded ones are within the error that is said."""

from fractions import Fraction

from hypothesis import given

from delta_cad.mechanism.enclosure.pose import NUMBERS, SIN_60_ERROR, lengths
from delta_cad.mechanism.geometry import SIN_60
from tests.delta_cad.mechanism.oracles import PROPERTY, mechanisms


@PROPERTY
@given(mechanisms())
def test_differences_are_within_the_error_that_is_said(g):
    numbers = lengths(g, 0.001)
    assert len(numbers) == NUMBERS
    a, a_error, la, lb, squares, error, tolerance = map(Fraction, numbers)
    big, small = Fraction(g.base_radius), Fraction(g.platform_radius)
    assert (la, lb, tolerance) == (*map(Fraction, (g.upper_arm_length, g.forearm_length)), Fraction(0.001))
    assert abs(big - small - a) <= a_error
    assert abs(la**2 - lb**2 - squares) <= error


def test_the_root_of_three_quarters_is_within_its_error():
    low, high = Fraction(SIN_60) - Fraction(SIN_60_ERROR), Fraction(SIN_60) + Fraction(SIN_60_ERROR)
    assert low**2 <= Fraction(3, 4) <= high**2
