"""The cable's check against strands laid out by hand, and against machines whose lugs or groove are wrong."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import atan2, degrees, pi
from typing import Any

import pytest

from delta_cad.checks.range.cable import check_cable
from delta_cad.checks.report import CheckResult
from delta_cad.dimensions import Dimensions
from tests.delta_cad.dimensions.edited import edited


def found(d: Dimensions) -> dict[str, CheckResult]:
    return {result.name: result for result in check_cable(d)}


def test_strands_climb_as_the_groove_does(best_dimensions: Dimensions) -> None:
    """Zero against the helix, so that the angle is the helix's own: pitch over the pinion's circumference."""
    d, h = best_dimensions, best_dimensions.design.hardware
    results = found(d)
    assert all(result.passed for result in results.values())
    lead = atan2(0.7, 2 * pi * h.sector_radius_mm / h.capstan_ratio)
    assert results["cable fleet angle"].value == pytest.approx(degrees(lead), rel=1e-3)
    assert results["cable on its groove"].value == pytest.approx(0.7)  # a pitch is left at either end


def other(record: Any, name: str, value: Callable[[Any], Any]) -> Any:
    """A record that tells another figure under a name, made from its own."""
    kind = type(record)
    changed = type(kind.__name__, (kind,), {name: property(lambda self: value(kind.__dict__[name].__get__(self)))})
    return changed(**{field: getattr(record, field) for field in kind.__dataclass_fields__})


def moved(d: Dimensions, off_mm: float) -> Dimensions:
    """Both lugs nearer to the middle than they should be."""
    return replace(d, capstan=other(d.capstan, "end_y_mm", lambda y: (y[0] - off_mm, y[1] + off_mm)))


def test_lugs_in_the_middle_plane_are_refused(best_dimensions: Dimensions) -> None:
    d = best_dimensions
    assert d.capstan is not None
    run = d.capstan.run
    flat = found(moved(d, run.lug_mm))["cable fleet angle"]
    assert not flat.passed
    # at the stop where a strand is shortest: by hand, its take-off against the middle
    walked = run.walk_mm / 2
    worst = max(
        atan2(abs(run.spread_mm / 2 + sign * walked), length)
        for sign, length in ((1, run.shortest_mm), (-1, run.shortest_mm + run.sector_mm * run.stroke_rad))
    )
    assert flat.value == pytest.approx(degrees(worst), rel=0.05)
    near = found(moved(d, 0.9 * run.lug_tolerance_mm()))["cable fleet angle"]
    assert near.value is not None
    assert near.value < 2.5


def test_a_groove_too_short_is_refused(best_dimensions: Dimensions) -> None:
    c = best_dimensions.capstan
    assert c is not None
    short = replace(c, run=other(c.run, "grooved_mm", lambda whole: whole - 2.0))
    result = found(replace(best_dimensions, capstan=short))["cable on its groove"]
    assert not result.passed
    assert result.value == pytest.approx(0.7 - 1.0)


def test_a_direct_drive_has_no_cable() -> None:
    assert check_cable(edited(drive="direct", motor="maxon-ec60flat-625858")) == []
