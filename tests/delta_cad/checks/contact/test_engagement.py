"""Engaged lengths and areas against closed forms; a shaft that ends too early, a seat too wide, a tube too short."""

from __future__ import annotations

from dataclasses import replace

import cadquery as cq
import numpy as np
import pytest

from delta_cad.assembly.machine import Assembly
from delta_cad.checks.contact.engagement import (
    cable_length,
    check_contacts,
    common_area,
    cylinder_length,
    end_area,
    seat_area,
)
from delta_cad.checks.contact.features import features
from delta_cad.solids.part import Part
from tests.delta_cad.checks.machines import at, ball, box, rod


def length(inner: cq.Shape, outer: cq.Shape, frame: np.ndarray | None = None, gap: float = 0.02) -> float:
    return cylinder_length(features(inner), features(outer), np.eye(4) if frame is None else frame, gap)


PLATE = box((-10, -10, 0), (10, 10, 6)).cut(rod(4.01, (0, 0, -1), (0, 0, 7)))
SHAFT = rod(4.0, (0, 0, -3), (0, 0, 20))


@pytest.mark.parametrize("end", [0.2, 2.5, 6.0])
def test_a_shaft_is_engaged_as_far_as_it_reaches_into_the_bore(end: float) -> None:
    assert length(rod(4.0, (0, 0, -20), (0, 0, end)), PLATE) == pytest.approx(end, abs=1e-9)


def test_a_shaft_off_its_axis_askew_too_thin_or_too_thick_is_not_engaged() -> None:
    assert length(SHAFT, PLATE) == pytest.approx(6.0)
    assert length(SHAFT, PLATE, at(0.015)) == pytest.approx(6.0)
    assert length(SHAFT, PLATE, at(0.03)) == 0.0
    askew = np.eye(4)
    askew[:3, :3] = [[np.cos(0.01), 0, np.sin(0.01)], [0, 1, 0], [-np.sin(0.01), 0, np.cos(0.01)]]
    assert length(SHAFT, PLATE, askew) == 0.0
    assert length(rod(3.9, (0, 0, -3), (0, 0, 20)), PLATE) == 0.0
    assert length(rod(4.1, (0, 0, -3), (0, 0, 20)), PLATE) == 0.0


def test_a_groove_of_less_than_half_a_turn_holds_nothing_and_two_lands_hold_their_sum() -> None:
    assert length(SHAFT, PLATE.cut(box((-10, -10, -1), (10, 0.5, 7)))) == 0.0
    assert length(SHAFT, PLATE.cut(rod(5.0, (0, 0, 2), (0, 0, 3.5)))) == pytest.approx(4.5)


def test_two_squares_share_the_rectangle_where_they_overlap() -> None:
    lower, upper = features(box((0, 0, 0), (10, 10, 2))), features(box((0, 0, 2), (10, 10, 4)))
    assert common_area(upper, lower, at(4.0, 3.0), 0.02) == pytest.approx(6.0 * 7.0)
    assert common_area(upper, lower, at(4.0, 3.0, 0.015), 0.02) == pytest.approx(6.0 * 7.0)
    assert common_area(upper, lower, at(4.0, 3.0, 0.025), 0.02) == 0.0
    assert common_area(upper, lower, at(12.0), 0.02) == 0.0


def test_a_ball_lies_in_the_zone_of_its_seat() -> None:
    half = 2.0
    socket = rod(8.0, (0, 0, -half), (0, 0, half)).cut(ball(5.02))
    zone = 2.0 * np.pi * 5.02 * 2.0 * half  # Archimedes: a zone's area goes with its height
    assert seat_area(features(ball(5.0)), features(socket), np.eye(4), 0.05) == pytest.approx(zone, rel=1e-6)
    assert seat_area(features(ball(5.0)), features(socket), at(0.04), 0.05) == pytest.approx(zone, rel=1e-6)
    assert seat_area(features(ball(5.0)), features(socket), at(0.06), 0.05) == 0.0
    assert seat_area(features(ball(4.9)), features(socket), np.eye(4), 0.05) == 0.0


@pytest.mark.parametrize("turn", [90.0, 180.0, 250.0])
def test_a_cable_lies_on_a_drum_as_far_as_both_go_round(turn: float) -> None:
    def ring(middle: float, radius: float, angle: float) -> cq.Shape:
        profile = cq.Wire.makeCircle(radius, cq.Vector(middle, 0, 0), cq.Vector(0, 1, 0))
        return cq.Solid.revolve(profile, [], angle, cq.Vector(0, 0, 0), cq.Vector(0, 0, 1))

    drum, cable = rod(20.0, (0, 0, -2), (0, 0, 2)), ring(20.25, 0.25, turn)
    assert cable_length(features(cable), features(drum), np.eye(4), 0.02) == pytest.approx(20.25 * np.radians(turn))
    assert cable_length(features(cable), features(drum), at(z=3.0), 0.02) == 0.0
    assert cable_length(features(cable), features(rod(19.9, (0, 0, -2), (0, 0, 2))), np.eye(4), 0.02) == 0.0


@pytest.mark.parametrize(("lead", "meets"), [(0.0, True), (0.0214, True), (0.043, True), (0.05, False)])
def test_a_cable_goes_on_at_its_helix_lead_up_to_the_fleet_limit(lead: float, meets: bool) -> None:
    """0.0214 is a rope of 0.8 mm on a pinion of 7.4 mm."""
    straight, on = rod(0.4, (-5, 0, 0), (0, 0, 0)), rod(0.4, (0, 0, 0), (5 * np.cos(lead), 5 * np.sin(lead), 0))
    found = end_area(features(straight), features(on), np.eye(4), 0.03)
    assert found == pytest.approx(np.pi / 4 * 0.8**2 if meets else 0.0)
    assert end_area(features(straight), features(on), at(0.04), 0.03) == 0.0


def remade(a: Assembly, number: str, solid: cq.Shape) -> Assembly:
    """The machine with all parts of a number made as another solid."""
    (one,) = solid.Solids()
    (old,) = (p for p in a.parts if p.number == number)
    new: Part = replace(old, solid=one)
    return replace(a, occurrences=tuple(replace(o, part=new) if o.part is old else o for o in a.occurrences))


def solid_of(a: Assembly, number: str) -> cq.Solid:
    return next(p.solid for p in a.parts if p.number == number)


def refusal(a: Assembly) -> str:
    result = check_contacts(a)
    assert not result.passed
    assert result.value is not None
    assert result.value < 1.0
    return result.detail


def test_the_committed_machine_holds_everywhere(best_assembly: Assembly) -> None:
    result = check_contacts(best_assembly)
    assert result.passed, result.detail


def test_a_motor_shaft_that_ends_just_beyond_the_pilot_is_refused(best_assembly: Assembly) -> None:
    motor = solid_of(best_assembly, "motor")
    pilot = min(c.start_mm + c.point[1] for c in features(motor).cylinders if c.radius_mm > 4.0)
    short = motor.cut(box((-20, -50, -20), (20, min(pilot, -2.0) - 0.2, 20)))
    assert "pinion on the motor's shaft" in refusal(remade(best_assembly, "motor", short))


def test_bearings_of_10_mm_bore_on_an_8_mm_shaft_are_refused(best_assembly: Assembly) -> None:
    wide = solid_of(best_assembly, "bearing").cut(rod(5.0, (0, -1, 0), (0, 30, 0)))
    assert "shaft in the bearing's bore" in refusal(remade(best_assembly, "bearing", wide))


def test_balls_of_7_mm_in_cups_of_8_mm_are_refused(best_assembly: Assembly) -> None:
    hole = rod(1.725, (0, -1.1, 0), (0, 9, 0))
    assert "ball in its cup" in refusal(remade(best_assembly, "joint_ball", ball(3.5).cut(hole)))


def test_a_tube_8_mm_too_short_is_refused(best_assembly: Assembly) -> None:
    tube = solid_of(best_assembly, "rod_tube")
    end = tube.BoundingBox().xmax
    detail = refusal(remade(best_assembly, "rod_tube", tube.cut(box((end - 8.0, -9, -9), (end + 1, 9, 9)))))
    assert "tube on the cup's shoulder" in detail


def test_contacts_of_a_part_that_is_not_there_and_no_contacts_at_all_are_refused(best_assembly: Assembly) -> None:
    kept = tuple(o for o in best_assembly.occurrences if o.name != "foot_block_1")
    assert "foot_block_1 is missing" in refusal(replace(best_assembly, occurrences=kept))
    bare = check_contacts(replace(best_assembly, contacts=()))
    assert not bare.passed
    assert "declares no contact" in bare.detail
