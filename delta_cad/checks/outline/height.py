"""Height of the machine from what it stands on to the knob's top, with the handle at the cube's top."""

from __future__ import annotations

from delta_cad.checks.report import CheckResult
from delta_cad.dimensions import Dimensions


def check_height(d: Dimensions) -> CheckResult:
    """Holds the height against the limit of the design; where it states none the height is reported, not judged."""
    most, value = d.design.requirements.height_max_mm, d.height_mm
    cube = d.design.cube
    detail = (
        f"from the mounting surface, {-d.floor_mm:.2f} mm under the shoulder axes, to the knob's top, with the handle "
        f"at the cube's top, {cube.bottom_height_mm + 2.0 * cube.half_side_mm:.2f} mm over them"
    )
    return CheckResult("height", most is None or value <= most, value, most, "mm", detail=detail)
