"""Checks of tolerance chains: what decides, which side, and what is refused."""

from __future__ import annotations

from dataclasses import replace
from math import inf

import pytest

from delta_cad.checks.range.tolerances import check_chain, check_tolerances
from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.tolerances.chain import Chain, either_way


@pytest.mark.parametrize(
    ("bounds", "statistical", "value", "limit", "holds"),
    [
        ((4.0, inf), False, 4.3, 4.0, True),
        ((4.0, 5.6), False, 5.7, 5.6, False),
        ((4.0, 5.6), True, 5.5, 5.6, True),
        ((4.55, 9.0), True, 4.5, 4.55, False),
    ],
)
def test_the_nearer_end_is_reported(
    bounds: tuple[float, float], statistical: bool, value: float, limit: float, holds: bool
) -> None:
    links = (either_way("a", "x", "stated", 0.3), either_way("b", "y", "bought", 0.4))
    result = check_chain(Chain("c", "mm", 5.0, links, *bounds, "", statistical))
    assert (result.passed, result.limit, result.worst_pair) == (holds, limit, ("b",))
    assert result.value == pytest.approx(value)


def test_the_joystick_passes_and_one_of_a_finer_encoder_does_not(best_dimensions: Dimensions) -> None:
    results = {one.name: one for one in check_tolerances(best_dimensions)}
    assert [name for name, one in results.items() if not one.passed] == []
    assert results["tolerance general class"].value == 2.0
    assert results["tolerance of the lengths"].value == pytest.approx(0.301957, abs=1e-6)
    fine = replace(best_dimensions, encoder=replace(best_dimensions.encoder, centring_mm=0.1))
    failed = [one.name for one in check_tolerances(fine) if not one.passed]
    assert failed == ["tolerance encoder's centring", "tolerance general class"]
