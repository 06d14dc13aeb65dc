"""Stops meet where they are stated: not a degree earlier, not a degree later, and deep enough."""

from bisect import bisect_left
from dataclasses import replace

import cadquery as cq
import numpy as np
import pytest

from delta_cad.assembly.machine import Assembly
from delta_cad.checks.contact.stops import check_stop_pressure, check_stops
from delta_cad.solids.part import location_of
from tests.delta_cad.checks.machines import STOP, at, machine


def test_both_ends_of_every_shoulder_are_met(best_assembly: Assembly) -> None:
    result = check_stops(best_assembly)
    assert result.passed, result.detail
    assert len(best_assembly.stops) == 6


@pytest.mark.parametrize("degrees", [-1.5, 1.5])
@pytest.mark.parametrize("end", [0, 1])
def test_a_stop_met_a_degree_and_a_half_off_is_refused(best_assembly: Assembly, degrees: float, end: int) -> None:
    stop = best_assembly.stops[end]
    moved = replace(stop, angle_rad=stop.angle_rad + np.radians(degrees))
    result = check_stops(replace(best_assembly, stops=(moved,)))
    assert not result.passed
    early = "meet more than a degree before" in result.detail
    assert early == (stop.sense * degrees > 0.0)


@pytest.mark.slow
def test_a_pin_drawn_back_and_a_pin_missing_are_refused(best_assembly: Assembly) -> None:
    def moved(y: float) -> Assembly:
        every = (
            replace(o, placement=at(0.0, y, 0.0) @ o.placement) if o.name == "stop_pin_0_0" else o
            for o in best_assembly.occurrences
        )
        return replace(best_assembly, occurrences=tuple(every))

    value = check_stops(best_assembly).value
    assert value is not None
    through = value * 1.8  # mm of the web's 3 that the pin reaches into; 1.8 are required

    def less(tenths: int) -> bool:  # and the farther it is drawn, the less
        left = check_stops(moved(0.1 * tenths)).value
        return left is None or left < value

    drawn = 0.1 * bisect_left(range(100), True, key=less)
    back = drawn - 0.1 + through
    assert check_stops(moved(back - 2.0)).passed
    result = check_stops(moved(back - 1.6))
    assert not result.passed
    assert "meet over 1.70 mm, 1.80 mm required" in result.detail
    kept = tuple(o for o in best_assembly.occurrences if o.name != "stop_pin_2_0")
    assert "stop_pin_2_0 is missing" in check_stops(replace(best_assembly, occurrences=kept)).detail


def test_an_arm_meets_the_edge_of_a_plate_where_geometry_says() -> None:
    assert check_stops(machine()).value == pytest.approx(8.0 / STOP.least_mm)


def test_a_stop_of_no_joint_is_refused() -> None:
    result = check_stops(replace(machine(), joints=()))
    assert not result.passed
    assert f"joint {STOP.joint} is missing" in result.detail


def test_a_machine_without_stops_is_refused(best_assembly: Assembly) -> None:
    assert not check_stops(replace(best_assembly, stops=())).passed


PEAK_N_m = 1.0


def pressure(assembly: Assembly, torque: float = PEAK_N_m) -> float:
    value = check_stop_pressure(assembly, torque).value
    assert value is not None
    return value


def by_hand(assembly: Assembly) -> float:
    """From the boxes of pin and cheek along the shoulder's axis, which of chain 0 is y: force by the pin's lever."""
    placed = {o.name: o for o in assembly.occurrences}
    pin, cheek = placed["stop_pin_0_0"], placed["motor_cheek_0"]
    own = pin.part.solid.moved(cq.Location(location_of(pin.placement))).BoundingBox()
    wall = cheek.part.solid.moved(cq.Location(location_of(cheek.placement))).BoundingBox()
    (joint,) = (joint for joint in assembly.joints if joint.name == "shoulder_0")
    x, _, z = own.center.x - joint.frame_a[0, 3], 0.0, own.center.z - joint.frame_a[2, 3]
    held = min(own.ymax, wall.ymax) - wall.ymin
    lever = held / 2 + wall.ymin - own.ymin
    return PEAK_N_m * 1000.0 / np.hypot(x, z) / (4.0 * held) * (1.0 + 6.0 * lever / held)


def test_pins_press_their_cheek_as_by_hand_and_no_more_than_it_bears(best_assembly: Assembly) -> None:
    assert check_stop_pressure(best_assembly, PEAK_N_m).passed
    # a dowel's ends are rounded, so that its last tenths are held by less than all of it
    assert pressure(best_assembly) == pytest.approx(by_hand(best_assembly), rel=0.02)
    assert pressure(best_assembly, 2 * PEAK_N_m) == pytest.approx(2 * pressure(best_assembly))


def test_more_torque_or_a_pin_held_by_less_is_refused(best_assembly: Assembly) -> None:
    most = PEAK_N_m * 125.0 / pressure(best_assembly)
    assert check_stop_pressure(best_assembly, 0.999 * most).passed
    assert not check_stop_pressure(best_assembly, 1.001 * most).passed

    def drawn(by_mm: float) -> Assembly:
        every = (
            replace(o, placement=at(0.0, -by_mm, 0.0) @ o.placement) if o.name == "stop_pin_0_0" else o
            for o in best_assembly.occurrences
        )
        return replace(best_assembly, occurrences=tuple(every))

    assert pressure(drawn(1.0)) > 1.5 * pressure(best_assembly)
    out = check_stop_pressure(drawn(30.0), PEAK_N_m)
    assert (out.passed, out.value, out.worst_pair) == (False, None, ("stop_pin_0_0",))
    loose = replace(best_assembly, contacts=tuple(c for c in best_assembly.contacts if c.a != "stop_pin_1_0"))
    assert "stop_pin_1_0 is held by nothing" in check_stop_pressure(loose, PEAK_N_m).detail
    assert not check_stop_pressure(replace(best_assembly, stops=()), PEAK_N_m).passed
