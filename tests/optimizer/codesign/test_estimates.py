"""Estimates of refusals that share a part: each has the field that ends it."""

from __future__ import annotations

from delta_cad.design import load_design
from delta_cad.structure.hardware.thresholds import changed
from optimizer.codesign.estimates import estimates
from tests.committed import ROOT


def test_a_platform_that_is_too_thin_becomes_thicker_though_a_thicker_one_meets_its_hub() -> None:
    small = {"hardware.platform_thickness_mm": 10.0, "mechanism.platform_radius_mm": 15.0}
    design = changed(load_design(ROOT / "docs" / "gallery" / "desk-150.json"), small)
    assert design is not None
    found = {one.reason.key: (one.field, one.bound) for one in estimates(design) if one.part == "platform"}
    assert found["platform", "wrist boss"] == ("hardware.platform_thickness_mm", 13.5)
    field, bound = found["platform", "hub"]
    assert field == "mechanism.platform_radius_mm"
    assert bound is not None
    assert 18.0 <= bound < 25.0


def test_a_platform_whose_hub_fits_only_while_it_is_too_thin_becomes_thicker() -> None:
    small = {"hardware.platform_thickness_mm": 10.0, "mechanism.platform_radius_mm": 18.5}
    design = changed(load_design(ROOT / "docs" / "gallery" / "desk-150.json"), small)
    assert design is not None
    found = {one.reason.key: (one.field, one.bound) for one in estimates(design) if one.part == "platform"}
    assert ("platform", "hub") not in found
    assert found["platform", "wrist boss"] == ("hardware.platform_thickness_mm", 13.5)
