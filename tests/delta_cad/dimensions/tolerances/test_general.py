"""General tolerances and grades against the standards' tables as workshops print them."""

from __future__ import annotations

import pytest

from delta_cad.dimensions.tolerances.general import coarsest_grade, flat_mm, general_mm


@pytest.mark.parametrize(
    ("length", "fine", "medium", "coarse"),
    [
        (2.5, 0.05, 0.1, 0.2),
        (3.0, 0.05, 0.1, 0.2),
        (3.1, 0.05, 0.1, 0.3),
        (30.0, 0.1, 0.2, 0.5),
        (91.0, 0.15, 0.3, 0.8),
    ],
)
def test_general_tolerances(length: float, fine: float, medium: float, coarse: float) -> None:
    assert [general_mm(length, name) for name in "fmc"] == [fine, medium, coarse]


def test_flatness() -> None:
    assert [flat_mm(144.0, name) for name in "fmc"] == [0.2, 0.4, 0.8]


@pytest.mark.parametrize(("length", "name"), [(0.0, "m"), (2001.0, "m"), (10.0, "v"), (float("nan"), "m")])
def test_what_no_table_has_is_refused(length: float, name: str) -> None:
    with pytest.raises(ValueError, match="known are f, m, c"):
        general_mm(length, name)


def test_the_coarsest_grade_of_a_zone() -> None:
    assert coarsest_grade(0.04, 17.3) == 8  # IT8 of 10 to 18 mm is 27 um, IT9 43
    assert coarsest_grade(0.043, 17.3) == 9
    assert coarsest_grade(1.0, 17.3) == 12
    assert coarsest_grade(0.001, 17.3) is None
