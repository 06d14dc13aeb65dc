"""Keys reach the screws of a motor and it comes off; machines in which they do not, or it does not, are refused."""

from __future__ import annotations

import sys
from dataclasses import replace
from math import pi, tau
from typing import Any

import cadquery as cq
import numpy as np
import pytest

from delta_cad import catalogue
from delta_cad.assembly.assemble import assemble
from delta_cad.assembly.machine import Assembly
from delta_cad.assembly.tessellation import MeshLibrary
from delta_cad.checks.contact import access
from delta_cad.checks.contact.access import check_access, up_and_down
from delta_cad.checks.limits import CheckLimits
from delta_cad.checks.report import CheckResult
from delta_cad.common.units import MM_PER_M
from delta_cad.dimensions import Dimensions, dimensions
from delta_cad.dimensions.bracket import motor_pattern_rad
from delta_cad.dimensions.layers import KEYS_MM
from delta_cad.interference.static_obstacles import motor
from delta_cad.mechanism import DeltaGeometry, inverse_kinematics
from delta_cad.mechanism.placement import LinkPlacement
from delta_cad.solids.part import Removal, ToolAccess
from tests.delta_cad.catalogue.offered import machine
from tests.delta_cad.checks.machines import at, box, changed, part, rod


def found(a: Assembly, d: Dimensions, names: tuple[str, ...] = ()) -> dict[str, CheckResult]:
    """Results of a machine, of the screws and motors with some names where any are given."""
    cube = d.design.cube
    limits = CheckLimits(cube.bottom_height_mm, cube.half_side_mm, 270.0, 220.0)
    if names:
        reached = tuple(r for r in a.reached if r.screw in names)
        a = replace(a, reached=reached, removals=tuple(r for r in a.removals if r.name in names))
    return {r.name: r for r in check_access(a, limits, MeshLibrary(a.parts))}


@pytest.mark.slow
def test_every_motor_of_the_machine_can_be_exchanged(best_assembly: Assembly, best_dimensions: Dimensions) -> None:
    assert len(best_assembly.reached) == 3 * (5 + 2)  # a motor's screws, and its pinion's
    results = found(best_assembly, best_dimensions)
    assert all(result.passed for result in results.values()), results
    value = results["tool access"].value
    assert value is not None
    assert value >= 60.0


@pytest.mark.slow
def test_a_screw_behind_the_sector_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    """A motor with four holes, all of which have screws, one on the line of centres."""
    rows, key = catalogue.motor.rows, "maxon-re30-310007"
    monkeypatch.setitem(catalogue.motor.__dict__, "rows", {**rows, key: replace(rows[key], mount_count=4)})
    d = dimensions(machine({"hardware__motor": key}))
    d = replace(d, bracket=replace(d.bracket, motor_screws_rad=d.bracket.motor_holes_rad))
    names = ("motor_screw_1_0", "motor_screw_1_1")
    result = found(assemble(d), d, names)["tool access"]
    assert not result.passed
    assert result.value == 0.0
    assert result.worst_pair == ("motor_screw_1_0",)
    assert result.detail.startswith("1 fail")


def test_a_cut_handle_passes_the_neighbours_of_a_base_that_is_too_short_for_a_whole_one(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A ratio of 4.86: the motor and its screws lie further in than at 5, between the cheeks of its neighbours."""
    changes: dict[str, Any] = {
        "mechanism__base_radius_mm": 30.91,
        "mechanism__platform_radius_mm": 21.304,
        "mechanism__upper_arm_length_mm": 92.498,
        "mechanism__forearm_length_mm": 143.013,
        "mechanism__parallelogram_width_mm": 50.0,
        "cube__bottom_height_mm": 74.598,
        "cube__half_side_mm": 41.55,
        "requirements__joint_torque_N_m": 0.3965,
        "hardware__capstan_ratio": 4.86,
        "hardware__sector_radius_mm": 39.7,
    }
    d = dimensions(machine(changes))
    a, names = assemble(d), ("motor_screw_0_1",)
    monkeypatch.setattr(access, "HEIGHTS", 5)  # what stands in its way stands at any
    monkeypatch.setattr(access, "TURN_RAD", 10.0)
    assert found(a, d, names)["tool access"].passed
    monkeypatch.setattr(
        sys.modules["delta_cad.dimensions.layers"],
        "cut_key_mm",
        lambda flats: (0.8 * KEYS_MM[flats][1], KEYS_MM[flats][0]),
    )
    result = found(a, d, names)["tool access"]
    assert not result.passed
    assert result.value is not None
    assert 0.0 <= result.value < 60.0


def test_no_turn_of_a_pinion_is_passed_over_between_two_positions() -> None:
    """Forearms of 407 mm above arms of 48: near the top of the cube the arms turn twice as fast as in its middle.

    Heights a like distance apart had the pinion turn by 3 degrees there, past the two that a slot leaves a key.
    """
    geometry = DeltaGeometry(
        base_radius=0.05318, platform_radius=0.01799, upper_arm_length=0.0485, forearm_length=0.4067
    )
    placement = LinkPlacement(geometry, 38.4, (0.0, 0.0), 9.0)
    limits = CheckLimits(410.6, 20.0, 270.0, 220.0)
    poses = up_and_down(placement, limits)
    assert poses[0] == pytest.approx([0.0, 0.0, 430.6])
    assert (np.diff(np.abs(poses[:, 2] - 430.6)) >= 0.0).all()
    up = poses[np.argsort(poses[:, 2])]
    assert up[[0, -1], 2] == pytest.approx([410.6, 450.6])
    angles = inverse_kinematics(geometry, up / MM_PER_M)[:, 0]
    assert 9.0 * np.abs(np.diff(angles)).max() <= access.TURN_RAD * 1.001


@pytest.mark.slow
def test_set_screws_behind_a_plug_between_the_cheeks_are_refused(
    best_assembly: Assembly, best_dimensions: Dimensions
) -> None:
    """Their key comes from outside, between arm and sector: the cheek has no slot, and what fills that way is met.

    The pinion turns by more than a turn over the cube's height: the plug is a ring, or the key comes beside it.
    """
    cheek = next(p for p in best_assembly.parts if p.number == "motor_cheek")
    assert not any(hole.is_slot for hole in cheek.holes)
    c, y0 = best_dimensions.capstan, best_dimensions.layers.motor_cheek_mm[0]
    assert c is not None
    assert c.collar_y_mm[1] < c.middle_y_mm
    x, z = motor(best_dimensions).at_mm
    ring = box((-16.0, c.collar_y_mm[0], -16.0), (16.0, y0, 16.0)).cut(rod(12.0, (0, -50, 0), (0, 50, 0)))
    plug = ring.translate(cq.Vector(x, 0, z))
    closed = replace(cheek, solid=cheek.solid.fuse(plug).Solids()[0])
    one = changed(best_assembly, "motor_cheek_0", part=replace(closed, number="closed"))
    result = found(one, best_dimensions, ("set_screw_0_0",))["tool access"]
    assert not result.passed
    assert result.value == 0.0


@pytest.mark.slow
def test_a_motor_behind_a_wall_does_not_come_off(best_assembly: Assembly, best_dimensions: Dimensions) -> None:
    u, z = best_dimensions.bracket.motor_axis_mm
    wall = part("wall", box((-5.0, 0.0, -5.0), (5.0, 2.0, 5.0)))
    behind = replace(best_assembly.occurrences[0], name="wall", part=wall, placement=at(u + 14.0, 95.0, z))
    spoiled = replace(best_assembly, occurrences=(*best_assembly.occurrences, behind))
    result = found(spoiled, best_dimensions, ("motor_0", "motor_1"))["parts come off"]
    assert result.value == 1
    assert result.worst_pair == ("motor_0",)
    assert "meets wall" in result.detail


def test_what_is_missing_is_neither_reached_nor_drawn_off(best_assembly: Assembly, best_dimensions: Dimensions) -> None:
    a = replace(
        best_assembly, reached=(ToolAccess("no_screw", 1.0, ""),), removals=(Removal("none", (0, 1, 0), (), ""),)
    )
    results = found(a, best_dimensions)
    assert results["tool access"].value == 0.0
    assert not results["parts come off"].passed


@pytest.mark.parametrize(("count", "screws"), [(2, 2), (3, 3), (4, 3), (5, 4), (6, 5)])
def test_at_least_three_screws_hold_a_motor_and_none_lies_towards_the_shoulder(count: int, screws: int) -> None:
    holes, used = motor_pattern_rad(count, -2.0)
    assert len(holes) == count
    assert len(used) == screws
    assert set(used) <= set(holes)
    np.testing.assert_allclose(np.diff(holes), tau / count)
    nearest = min(abs((a - (-2.0 + pi) + pi) % tau - pi) for a in used)
    assert nearest >= pi / 3 - 1e-9
    assert motor_pattern_rad(count, None)[1] == motor_pattern_rad(count, None)[0]


def test_screws_of_a_direct_drive_turn_out_of_the_way_of_stop_pins_as_far_as_they_can() -> None:
    square, _ = motor_pattern_rad(4, None)
    assert motor_pattern_rad(4, None, (0.0, pi), 0.4)[0] == square  # nothing is in the way
    pins = (pi / 4 + 0.1, -pi / 4 - 0.3)
    holes, used = motor_pattern_rad(4, None, pins, 0.4)
    off = [min(abs((a - pin + pi) % tau - pi) for a in used) for pin in pins]
    assert holes == used
    np.testing.assert_allclose(off, [(pi / 2 - 0.4) / 2, (pi / 2 - 0.4) / 2], atol=1e-12)
    turns = np.linspace(0.0, tau / 4, 1001)
    best = max(min(abs((phase - pin + pi / 4) % (pi / 2) - pi / 4) for pin in pins) for phase in turns)
    assert off[0] == pytest.approx(best, abs=2e-3)
