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
from delta_cad.drive import drive_torque
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


def test_the_bend_ratio_is_the_groove_s_and_life_grows_thirteenfold_with_twice_the_diameter(
    best_dimensions: Dimensions,
) -> None:
    h = best_dimensions.design.hardware
    result = found(best_dimensions)["cable bend ratio"]
    assert result.value == pytest.approx((2 * h.sector_radius_mm / h.capstan_ratio - 0.54) / 0.54)
    assert (result.passed, result.limit) == (True, 16.0)  # 7x7: 40 advised, short below 16
    assert "30 % of the bending life" in result.detail
    drive = drive_torque(best_dimensions.design)
    assert drive.bend_ratio_recommended is not None
    for ratio, share in ((40.0, 1.0), (20.0, 1 / 13), (80.0, 13.0), (-1.0, 0.0)):
        assert replace(drive, bend_ratio=ratio).bend_life_share == pytest.approx(share)


@pytest.mark.parametrize(("cable", "ratio", "holds"), [("7x7", 8.6, True), ("7x7", 8.8, False), ("7x19", 11.0, True)])
def test_a_pinion_too_thin_for_its_cable_is_refused(cable: str, ratio: float, holds: bool) -> None:
    """A sector of 40 mm: 16 diameters of a 7x7 are a ratio of 8.71; 10 of a 7x19, which bends more easily, 13.5."""
    result = found(edited(cable=f"steel-0.54-{cable}", capstan_ratio=ratio, motor="maxon-re30-310009"))[
        "cable bend ratio"
    ]
    assert result.passed == holds
    assert result.limit == pytest.approx({"7x7": 16.0, "7x19": 10.0}[cable])
