"""Estimates that the design search goes on from are thresholds of the refusals themselves, by hand where one can."""

from __future__ import annotations

from delta_cad.design import Design, design_from_dict
from delta_cad.dimensions import dimensions
from delta_cad.structure.hardware.refusals import least_outline_mm
from optimizer.codesign.estimates import Estimate, estimates
from tests.committed import changed


def estimated(design: Design) -> dict[tuple[str, str], Estimate]:
    return {one.reason.key: one for one in estimates(design)}


def test_a_thickness_is_estimated_at_what_the_bar_in_it_needs() -> None:
    """By hand: 1 mm around a bar of 8 mm."""
    one = estimated(design_from_dict(changed(hardware__platform_thickness_mm=9.0)))["platform", "wrist boss"]
    assert (one.field, one.value, one.bound) == ("hardware.platform_thickness_mm", 9.0, 10.0)


def test_an_outline_is_estimated_at_what_elbows_and_motors_take_to_a_tenth(best: Design) -> None:
    tight = design_from_dict(changed(requirements__envelope_width_mm=230.0, requirements__envelope_depth_mm=220.0))
    one, size = estimated(tight)["assembly", "envelope width"], float(least_outline_mm(dimensions(best)).max())
    assert one.field == "requirements.envelope_width_mm"
    assert one.bound is not None
    assert size <= one.bound <= size + 0.1


def test_loads_alone_tell_what_is_borne_of_them() -> None:
    found = estimates(design_from_dict(changed(requirements__peak_force_N=12.0, hardware__platform_thickness_mm=11.0)))
    margins = {one.reason.key: one.reason.margin for one in found}
    assert ("motor shaft", "load") in margins
    for (_, feature), margin in margins.items():
        assert (margin is not None) == (feature == "load")
        assert margin is None or 0.0 < margin < 1.0
