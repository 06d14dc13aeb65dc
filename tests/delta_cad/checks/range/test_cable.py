"""The cable's check against strands laid out by hand, and against machines whose lugs, groove or drums are off."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from math import atan, atan2, degrees, pi
from typing import Any

import numpy as np
import pytest

from delta_cad.assembly.machine import Assembly
from delta_cad.assembly.tessellation import MeshLibrary
from delta_cad.checks.range.cable import check_cable, check_cable_setting
from delta_cad.checks.report import CheckResult
from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.capstan import CapstanDimensions
from delta_cad.dimensions.tolerances.cable_setting import cable_setting
from delta_cad.mechanism.placement import LinkPlacement
from delta_cad.solids.capstan import make_pinion, make_sector
from delta_cad.solids.part import Part
from tests.delta_cad.checks.machines import at, box, part

Point = tuple[float, float, float]


def found(a: Assembly) -> dict[str, CheckResult]:
    return {result.name: result for result in check_cable(a)}


def capstan(d: Dimensions) -> CapstanDimensions:
    assert d.capstan is not None
    return d.capstan


def test_strands_climb_as_the_groove_does(best_assembly: Assembly, best_dimensions: Dimensions) -> None:
    """The angle is the helix's own, pitch over the pinion's circumference, but for what rounds the lugs."""
    h, c = best_dimensions.design.hardware, capstan(best_dimensions)
    results = found(best_assembly)
    assert all(result.passed for result in results.values())
    lead = 0.7 / (2 * pi * h.sector_radius_mm / h.capstan_ratio)
    lengths = c.run.shortest_mm, c.run.shortest_mm + c.run.sector_mm * c.run.stroke_rad
    steepest = lead + max((c.run.made_lug_mm - c.run.lug_mm) / length for length in lengths)
    assert results["cable fleet angle"].value == pytest.approx(degrees(atan(steepest)), rel=1e-3)
    assert results["cable on its groove"].value == pytest.approx(margin_mm(c), abs=1e-3)


def margin_mm(c: CapstanDimensions) -> float:
    """A pitch is left at either end of the groove, and what rounds its half up to a tenth: less than that."""
    low, high = c.pinion_y_mm  # the collar is at the end that is farther from the middle
    half = min(c.middle_y_mm - low, high - c.middle_y_mm) - 0.5  # of its shoulder
    rounded = half - c.run.grooved_mm / 2
    assert 0.0 <= rounded < 0.1
    return 0.7 + rounded


def other(record: Any, name: str, value: Callable[[Any], Any]) -> Any:
    """A record that tells another figure under a name, made from its own."""
    kind = type(record)
    changed = type(kind.__name__, (kind,), {name: property(lambda self: value(kind.__dict__[name].__get__(self)))})
    return changed(**{field: getattr(record, field) for field in kind.__dataclass_fields__})


def with_part(a: Assembly, name: str, part: Part) -> Assembly:
    """The machine with another solid in one place."""
    return replace(a, occurrences=tuple(replace(o, part=part) if o.name == name else o for o in a.occurrences))


def moved(a: Assembly, shifts: dict[str, np.ndarray]) -> Assembly:
    """The machine with occurrences shifted, (4, 4), in their links' frames."""
    return replace(
        a,
        occurrences=tuple(
            replace(o, placement=shifts[o.name] @ o.placement) if o.name in shifts else o for o in a.occurrences
        ),
    )


def lugs(d: Dimensions, inner_mm: float, outer_mm: float) -> Part:
    """A sector whose lugs are shifted along the shoulder's axis."""
    return make_sector(replace(d, capstan=other(d.capstan, "end_y_mm", lambda y: (y[0] + inner_mm, y[1] + outer_mm))))


@pytest.mark.parametrize(("inner_mm", "outer_mm"), [(-1.0, 0.0), (0.0, 1.0), (0.0, -1.0)])
def test_a_lug_shifted_by_a_millimetre_is_refused(
    best_assembly: Assembly, best_dimensions: Dimensions, inner_mm: float, outer_mm: float
) -> None:
    run = capstan(best_dimensions).run
    results = found(with_part(best_assembly, "sector_1", lugs(best_dimensions, inner_mm, outer_mm)))
    fleet = results["cable fleet angle"]
    assert not fleet.passed
    assert fleet.worst_pair == ("sector_1",)
    made = capstan(best_dimensions).run.made_lug_mm - run.lug_mm
    climbs = run.climb * run.shortest_mm + made  # by hand, where that strand is shortest: what it climbs, and the shift
    off = inner_mm - outer_mm  # inwards is towards the other lug for both
    assert fleet.value == pytest.approx(degrees(atan2(abs(climbs + off), run.shortest_mm)), rel=0.01)


def test_a_lug_shifted_by_less_than_its_tolerance_is_not(best_assembly: Assembly, best_dimensions: Dimensions) -> None:
    by = 0.9 * capstan(best_dimensions).run.lug_tolerance_mm()
    assert found(with_part(best_assembly, "sector_1", lugs(best_dimensions, by, 0.0)))["cable fleet angle"].passed


def test_lugs_in_the_middle_plane_are_refused(best_assembly: Assembly, best_dimensions: Dimensions) -> None:
    run = capstan(best_dimensions).run
    flat = found(with_part(best_assembly, "sector_0", lugs(best_dimensions, -run.lug_mm, run.lug_mm)))
    result = flat["cable fleet angle"]
    assert not result.passed
    # at the stop where a strand is shortest: by hand, its take-off against the middle
    walked = run.walk_mm / 2
    worst = max(
        atan2(abs(run.spread_mm / 2 + sign * walked), length)
        for sign, length in ((1, run.shortest_mm), (-1, run.shortest_mm + run.sector_mm * run.stroke_rad))
    )
    assert result.value == pytest.approx(degrees(worst), rel=0.05)


@pytest.mark.parametrize("by_mm", [-1.0, 1.0])
def test_a_sector_moved_along_its_axis_is_refused(best_assembly: Assembly, by_mm: float) -> None:
    result = found(moved(best_assembly, {"sector_2": at(y=by_mm)}))["cable fleet angle"]
    assert not result.passed
    assert result.worst_pair == ("sector_2",)


@pytest.mark.parametrize("by_mm", [-1.0, 1.0])
def test_a_pinion_moved_along_its_axis_is_refused(
    best_assembly: Assembly, best_dimensions: Dimensions, by_mm: float
) -> None:
    """Alone, its groove ends before the turns; with its turns, the strands lean."""
    alone = found(moved(best_assembly, {"pinion_1": at(y=by_mm)}))["cable on its groove"]
    assert not alone.passed
    assert alone.value == pytest.approx(margin_mm(capstan(best_dimensions)) - 1.0, abs=1e-3)
    turn = best_dimensions.turn(1)
    both = {"pinion_1": at(y=by_mm), "capstan_cable_1_turns": turn @ at(y=by_mm) @ np.linalg.inv(turn)}
    results = found(moved(best_assembly, both))
    assert results["cable on its groove"].passed
    assert not results["cable fleet angle"].passed


def test_a_pinion_moved_across_is_refused(best_assembly: Assembly) -> None:
    """Out of its turns, which then lie a millimetre off its axis."""
    result = found(moved(best_assembly, {"pinion_0": at(x=1.0)}))["cable on its groove"]
    assert not result.passed
    assert result.value == pytest.approx(-1.0, abs=0.14)  # from the crest, which is a quarter of the cable higher


def test_a_groove_too_short_is_refused(best_assembly: Assembly, best_dimensions: Dimensions) -> None:
    c = capstan(best_dimensions)
    assert not c.collar_at_motor
    short = replace(c, pinion_y_mm=(c.pinion_y_mm[0], c.pinion_y_mm[1] - 1.0))  # the groove has the same middle
    pinion = make_pinion(replace(best_dimensions, capstan=short))
    result = found(with_part(best_assembly, "pinion_2", pinion))["cable on its groove"]
    assert not result.passed
    assert result.value == pytest.approx(margin_mm(c) - 1.0, abs=1e-3)
    assert result.worst_pair == ("pinion_2",)


@pytest.mark.parametrize("name", ["sector_0", "pinion_1", "capstan_cable_2_turns"])
def test_a_part_that_is_missing_or_has_no_such_faces_is_refused(best_assembly: Assembly, name: str) -> None:
    block = next(p for p in best_assembly.parts if p.number == "foot_block")
    gone = replace(best_assembly, occurrences=tuple(o for o in best_assembly.occurrences if o.name != name))
    for spoiled in (gone, with_part(best_assembly, name, block)):
        results = found(spoiled)
        assert len(results) == 2
        assert not any(result.passed for result in results.values())


def test_a_direct_drive_has_no_cable(best_assembly: Assembly) -> None:
    where = best_assembly.placement
    direct = LinkPlacement(where.geometry, where.parallelogram_width_mm, where.pinion_centre_mm, 1.0)
    assert check_cable(replace(best_assembly, placement=direct)) == []


def setting_of(a: Assembly, d: Dimensions) -> CheckResult:
    (result,) = check_cable_setting(a, d, MeshLibrary(a.parts))
    return result


def blocked(a: Assembly, d: Dimensions, name: str, frame: np.ndarray, low: Point, high: Point) -> CheckResult:
    """The check of a machine in which a block in a frame of the base takes the place of a part."""
    (o,) = [one for one in a.occurrences if one.name == name]
    corners = np.array(
        [[x, y, z, 1.0] for x in (low[0], high[0]) for y in (low[1], high[1]) for z in (low[2], high[2])]
    )
    seen = (np.linalg.inv(a.poses(a.home_mm)[o.name]) @ frame @ corners.T)[:3]
    least, most = ((float(x), float(y), float(z)) for x, y, z in (seen.min(axis=1), seen.max(axis=1)))
    return setting_of(with_part(a, name, part(f"block for {name}", box(least, most))), d)


def test_hands_can_set_the_cables(best_assembly: Assembly, best_dimensions: Dimensions) -> None:
    result = setting_of(best_assembly, best_dimensions)
    assert (result.passed, result.value) == (True, 0)
    setting = cable_setting(best_dimensions)
    assert setting is not None
    assert f"stands at {setting.pull_N[0]:g} N, creeps before {setting.pull_N[1]:g} N" in result.detail
    (step,) = [s for unit in best_assembly.order if unit.name == "drive 0" for s in unit.steps if "Tension" in s.title]
    written = " ".join(step.words)
    assert f"Up to {setting.pull_N[0]:g} N the arm must stand; before {setting.pull_N[1]:g} N it must creep" in written
    assert f"the way in which it {'rises' if setting.rises else 'falls'}" in written


def test_what_is_before_the_balance_is_refused(best_assembly: Assembly, best_dimensions: Dimensions) -> None:
    """A block 30 mm from the elbow on the balance's way, of a part that stands; beside it, nothing is met."""
    d, setting = best_dimensions, cable_setting(best_dimensions)
    assert setting is not None
    angle = sum(d.stops_rad) / 2.0 + setting.arm_rad
    way = angle + (0.5 if setting.rises else -0.5) * pi
    x, z = 91.0 * np.cos(angle) + 30.0 * np.cos(way), 91.0 * np.sin(angle) + 30.0 * np.sin(way)
    shoulder = d.stand(1) @ at(d.bracket.shoulder_u_mm)
    for aside, passed in ((0.0, False), (40.0, True)):
        low, high = (x - 3.0, aside - 3.0, z - 3.0), (x + 3.0, aside + 3.0, z + 3.0)
        result = blocked(best_assembly, d, "foot_block_1", shoulder, low, high)
        assert result.passed is passed, result.detail
        assert passed or "drive 1: something is before the balance" in result.detail


def test_what_is_before_the_keys_is_refused(best_assembly: Assembly, best_dimensions: Dimensions) -> None:
    """A block that moves with the arm before its tension screw; one that stands where the set screws' key does."""
    d, c = best_dimensions, capstan(best_dimensions)
    frames = best_assembly.poses(best_assembly.home_mm)
    result = blocked(best_assembly, d, "sector_dowel_2_0", frames["tension_screw_2"], (-9, -9, 6), (9, 9, 12))
    assert not result.passed
    assert "the key of tension_screw_2 swings nowhere" in result.detail
    u, z = d.bracket.motor_axis_mm
    middle = sum(c.collar_y_mm) / 2.0
    low, high = (u + 8.0, middle - 3.0, z - 8.0), (u + 14.0, middle + 3.0, z + 8.0)
    result = blocked(best_assembly, d, "foot_block_0", d.stand(0), low, high)
    assert not result.passed
    assert "drive 0: no key stands in set_screw_0_" in result.detail


def test_a_step_that_is_missing_is_refused(best_assembly: Assembly, best_dimensions: Dimensions) -> None:
    units = [replace(u, steps=u.steps[:3]) if u.name == "drive 1" else u for u in best_assembly.order]
    result = setting_of(replace(best_assembly, order=tuple(units)), best_dimensions)
    assert not result.passed
    assert "drive 1: no step tightens its set screws" in result.detail


def test_a_pull_that_cable_or_key_does_not_bear_is_refused(
    best_assembly: Assembly, best_dimensions: Dimensions
) -> None:
    d = best_dimensions
    thin = replace(d, cable=d.cable.__class__(**{**vars(d.cable), "breaking_load_N": 60.0}))
    result = setting_of(best_assembly, thin)
    assert not result.passed
    assert "the bench by 20 N" in result.detail
    c = capstan(d)
    thick = replace(d, capstan=replace(c, run=replace(c.run, pinion_mm=30.0)))
    result = setting_of(best_assembly, thick)
    assert not result.passed
    assert "bend the key of 1.5 mm" in result.detail
