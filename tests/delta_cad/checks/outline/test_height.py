"""Height of a machine: that of its solids with the handle at the cube's top, its limit and the refusal beyond it."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from delta_cad.assembly.machine import Assembly
from delta_cad.checks.outline.height import check_height
from delta_cad.design import Design, DesignError, design_from_dict, design_hash, design_to_dict
from delta_cad.dimensions import Dimensions, dimensions
from delta_cad.structure.hardware.thresholds import refused
from tests.committed import changed
from tests.delta_cad.dimensions.paneled import of_panel


def limited(height_max_mm: float, **values: Any) -> Design:
    data = changed(**values)
    data["requirements"]["height_max_mm"] = height_max_mm
    return design_from_dict(data)


@pytest.mark.parametrize("which", ["best", "direct", "placed"])
def test_a_height_is_that_of_the_solids_with_the_handle_at_the_top(which: str, request: pytest.FixtureRequest) -> None:
    d: Dimensions = request.getfixturevalue(f"{which}_dimensions")
    assembly: Assembly = request.getfixturevalue(f"{which}_assembly")
    cube = d.design.cube
    top = np.array([cube.centre_x_mm or 0.0, 0.0, cube.bottom_height_mm + 2.0 * cube.half_side_mm])
    poses, ends = assembly.poses(top), list[float]()
    for occurrence in assembly.occurrences:
        if occurrence.name.startswith(("foot", "knob", "base_plate")) and not occurrence.name.startswith("foot_block"):
            box, pose = occurrence.part.solid.BoundingBox(), poses[occurrence.name]
            assert pose[2, 2] == pytest.approx(1.0)  # upright
            ends += [box.zmin + pose[2, 3], box.zmax + pose[2, 3]]
    assert check_height(d).value == pytest.approx(max(ends) - min(ends), abs=1e-3)


def test_without_a_limit_the_height_is_reported_and_nothing_else_changes(best_dimensions: Dimensions) -> None:
    result = check_height(best_dimensions)
    assert result.passed
    assert result.limit is None
    assert "height_max_mm" not in design_to_dict(best_dimensions.design)["requirements"]
    assert design_hash(best_dimensions.design) != design_hash(limited(400.0))


def test_a_limit_holds_to_the_height_itself(best_dimensions: Dimensions) -> None:
    height = best_dimensions.height_mm
    for most, holds in ((height, True), (height - 1e-6, False)):
        result = check_height(dimensions(limited(most)))
        assert (result.passed, result.limit) == (holds, most)


def test_a_machine_that_is_too_high_is_refused_with_changes_that_are_enough(best_dimensions: Dimensions) -> None:
    height = best_dimensions.height_mm
    (found,) = refused(limited(height - 5.0))
    assert (found.reason.part, found.reason.feature) == ("assembly", "height")
    changes = {field: value for one in found.thresholds for field, value in one.enough.items()}
    assert changes["requirements.height_max_mm"] == pytest.approx(height, abs=0.1)
    side = changes["cube.half_side_mm"]
    assert isinstance(side, float)
    assert not list(refused(limited(height - 5.0, cube__half_side_mm=side)))
    assert f"requirements.height_max_mm = {height - 5.0:g} must be at least" in str(found)
    assert not list(refused(limited(height)))


def test_a_knob_behind_a_panel_counts_from_the_mounting_surface() -> None:
    d = of_panel()
    assert d.panel is not None
    assert d.height_mm > d.panel.top_mm - d.floor_mm + 2.0 * d.design.cube.half_side_mm


@pytest.mark.parametrize("value", [0.0, -3.0, 5000.1, float("nan")])
def test_a_height_that_is_none_is_refused(value: float) -> None:
    with pytest.raises(DesignError, match=r"requirements\.height_max_mm.*must be"):
        limited(value)
