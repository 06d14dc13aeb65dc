"""Numbers with a unit: converted to the nearest double, or refused with what to write."""

from __future__ import annotations

import re
from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from optimizer.problem.quantity import KINDS, QuantityError, pattern, quantity

# Text, unit of the field, number; from the definitions of the units, not from our table.
UNDERSTOOD = [
    ("120 mm", "mm", 120.0),
    ("120mm", "mm", 120.0),
    (" 12 cm ", "mm", 120.0),
    ("0.12 m", "mm", 120.0),
    ("1.2e-1 m", "mm", 120.0),
    ("50 um", "mm", 0.05),
    ("50 µm", "mm", 0.05),
    ("50 μm", "mm", 0.05),
    ("4 in", "mm", 101.6),
    ("-.5 cm", "mm", -5.0),
    ("3 N", "N", 3.0),
    ("500 mN", "N", 0.5),
    ("0.003 kN", "N", 3.0),
    ("0.39 N m", "N m", 0.39),
    ("390 mNm", "N m", 0.39),
    ("39 N·cm", "N m", 0.39),
    ("390 N*mm", "N m", 0.39),
    ("15 N/mm", "N/mm", 15.0),
    ("15000 N/m", "N/mm", 15.0),
    ("15 kN/m", "N/mm", 15.0),
    ("0.015 N/um", "N/mm", 15.0),
    ("300 g", "kg", 0.3),
    ("28 deg", "deg", 28.0),
    ("28°", "deg", 28.0),
    ("9.81 m/s^2", "m/s^2", 9.81),
    ("9.81 m/s²", "m/s^2", 9.81),
    ("-9810 mm/s2", "m/s^2", -9.81),
    ("320 g cm^2", "kg m^2", 3.2e-5),
    ("32 kg mm²", "kg m^2", 3.2e-5),
]


@pytest.mark.parametrize(("text", "unit", "number"), UNDERSTOOD, ids=[t for t, _, _ in UNDERSTOOD])
def test_a_number_with_its_unit_is_the_nearest_double(text: str, unit: str, number: float) -> None:
    assert quantity(text, unit) == number
    assert re.fullmatch(pattern(unit), text)


def test_angles_may_be_radians() -> None:
    assert quantity("0.5 rad", "deg") == pytest.approx(28.64788975654116, rel=1e-15)  # 0.5 * 180 / pi, to 16 digits


@given(digits=st.integers(-(10**12), 10**12), places=st.integers(0, 12), unit=st.sampled_from(sorted(KINDS)))
def test_any_decimal_number_is_rounded_once(digits: int, places: int, unit: str) -> None:
    """Against exact fractions."""
    text = f"{digits}e-{places}"
    for name, factor in KINDS[unit][1].items():
        if factor:
            assert quantity(f"{text} {name}", unit) == float(Fraction(digits, 10**places) * Fraction(factor))


def test_what_begins_with_no_number_is_no_quantity() -> None:
    assert [quantity(text, "mm") for text in ("", "mm", "wide", "nan mm", "inf m", "٣ mm", "1" * 70 + " mm")] == [
        None
    ] * 7
    assert quantity("1e-400 m", "mm") == 0.0
    assert quantity("1e-999999999 m", "mm") == 0.0


def test_a_number_never_means_another_kind() -> None:
    """Each unit is of one kind."""
    for unit, (_, units) in KINDS.items():
        for other in KINDS:
            for name in units:
                if other != unit:
                    with pytest.raises(QuantityError):
                        quantity(f"1 {name}", other)
