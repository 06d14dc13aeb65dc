"""Tolerances of a shoulder: each sum against all its extremes, and against what springs and bearings bear."""

from __future__ import annotations

from dataclasses import replace
from itertools import product
from math import pi, sqrt

import numpy as np
import pytest

from delta_cad import catalogue
from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.tolerances import (
    DOWEL_PLAY_MM,
    GRADES_UM,
    MANDREL_FIT,
    MANDREL_MM,
    NOMINAL_MM,
    RUN_OUT_MM,
    SEATS_MM,
    TILT_RAD,
    END_TORQUE_N_m,
    deviations_um,
    drilled_mm,
    minutes,
    preload_range_N,
    seat_tilt_rad,
    spring_height_mm,
    tip_mm,
    working_mm,
)
from delta_cad.structure.strength import allowables, screw_N


def test_the_preload_is_that_of_the_worst_stack(best_dimensions: Dimensions) -> None:
    """Faces laid off along the axis, every length at either end of its tolerance."""
    d = best_dimensions
    assert d.preload is not None
    layers, spring = d.layers, d.preload
    block = layers.motor_cheek_mm[0] - layers.encoder_cheek_mm[1]
    seats = d.bearing.width_mm, layers.encoder_cheek_mm[1] - layers.bearings_mm[0][0] + spring.work_height_mm
    arm = layers.arm_mm[1] - layers.bearings_mm[0][1]
    sector = layers.motor_cheek_mm[0] - layers.arm_mm[1]
    heights = []
    for off in product((-0.02, 0.02), repeat=5):
        for narrow in product((-0.12, 0.0), repeat=2):
            room = block + off[0] + seats[0] + off[1] + seats[1] + off[2]
            filled = arm + off[3] + sector + off[4] + 2 * d.bearing.width_mm + sum(narrow)
            heights.append(room - filled)
    assert spring_height_mm(spring) == pytest.approx((min(heights), max(heights)))
    assert spring.rate_N_mm is not None
    forces = [spring.force_N - spring.rate_N_mm * (h - spring.work_height_mm) for h in heights]
    assert preload_range_N(spring) == pytest.approx((min(forces), max(forces)))
    assert allowables(d).preload_N == pytest.approx(min(forces))


@pytest.mark.parametrize("spring", catalogue.wave_spring.rows.values(), ids=lambda row: row.id)
def test_every_wave_spring_works_within_its_limits(spring: catalogue.WaveSpring) -> None:
    (low, high), (flat, slack) = spring_height_mm(spring), working_mm(spring)
    assert spring.thickness_mm < flat < low < high < slack < spring.free_height_mm
    assert 0.0 < preload_range_N(spring)[0] < spring.force_N < preload_range_N(spring)[1]
    unrated = replace(spring, rate_N_mm=None)  # a spring whose rate no one tells is straight to its free height
    assert preload_range_N(unrated)[0] == pytest.approx(
        spring.force_N * (spring.free_height_mm - high) / (spring.free_height_mm - spring.work_height_mm)
    )


def test_the_seats_are_in_line_within_what_a_bearing_bears(best_dimensions: Dimensions) -> None:
    d, b = best_dimensions, best_dimensions.bracket
    assert seat_tilt_rad(b) < TILT_RAD
    near = replace(b, cheek_dowel_u_mm=(b.cheek_dowel_u_mm[0] + 7.5, b.cheek_dowel_u_mm[1] - 7.5))
    assert seat_tilt_rad(near) > TILT_RAD  # 18 mm apart, as they were
    assert f"by {minutes(seat_tilt_rad(b)):.0f}'" == "by 8'"
    # by hand: every dowel off by its play, the way that turns the cheeks apart most, seen at the shoulder's height
    play, apart = 0.004, b.cheek_dowel_u_mm[1] - b.cheek_dowel_u_mm[0]
    shifts = []
    for first, second in product(np.linspace(0.0, 2 * pi, 73), repeat=2):
        a, c = play * np.array([np.cos(first), np.sin(first)]), play * np.array([np.cos(second), np.sin(second)])
        turn = (c - a)[1] / apart
        shifts.append(np.hypot(*((a + c) / 2 + turn * np.array([b.cheek_screw_z_mm, 0.0]))))
    by_dowels = 30.0 * seat_tilt_rad(b) - (0.018 + 0.011 + 0.011 + 0.011) / 2
    assert 2 * max(shifts) <= by_dowels
    assert 2 * max(shifts) == pytest.approx(by_dowels, rel=0.2)  # lift and turn are not at their most together
    assert d.layers.bearings_mm[1][0] - d.layers.bearings_mm[0][0] == pytest.approx(30.0)


@pytest.mark.parametrize("size", END_TORQUE_N_m)
def test_the_torque_of_the_shaft_s_screw_is_that_of_its_clamping_force(size: str) -> None:
    row = catalogue.screw(size)
    flank = row.diameter_mm - 0.6495 * row.pitch_mm
    under_head = (row.head_diameter_mm + row.clearance_hole_mm) / 4
    torque = screw_N(row) * (0.16 * row.pitch_mm + 0.58 * flank * 0.14 + under_head * 0.14) / 1000.0
    assert END_TORQUE_N_m[size] == pytest.approx(torque, rel=0.1)


def test_grades_follow_the_formulas_of_the_standard() -> None:
    """ISO 286-1: i = 0.45 D^(1/3) + 0.001 D, 7, 10 and 16 times it; D^0.34 for G; rounded by hand in the tables."""
    for k, (low, high) in enumerate(zip((1.0, *NOMINAL_MM), NOMINAL_MM, strict=False)):
        mean = sqrt(low * high)
        unit = 0.45 * mean ** (1 / 3) + 0.001 * mean
        for grade, times in ((5, 7.0), (6, 10.0), (7, 16.0)):
            coarser = 1.5 if k == 0 else 1.0  # up to 3 mm the tables are rounded up
            assert GRADES_UM[grade][k] == pytest.approx(times * unit, abs=coarser)
        assert deviations_um("G7", high)[0] == pytest.approx(2.5 * mean**0.34, abs=1.1)


def test_deviations_as_printed() -> None:
    assert [deviations_um("H7", d) for d in (3.0, 3.01, 6.0, 8.0, 16.0, 30.0)] == [
        (0, 10), (0, 12), (0, 12), (0, 15), (0, 18), (0, 21),
    ]  # fmt: skip
    assert [deviations_um("G7", 8.0), deviations_um("H6", 16.0), deviations_um("h6", 8.0)] == [
        (5, 20),
        (0, 11),
        (-9, 0),
    ]
    assert [deviations_um("m6", d) for d in (3.0, 4.0)] == [(2, 8), (4, 12)]
    for fit, nominal in (("K7", 8.0), ("H8", 8.0), ("H", 8.0), ("", 8.0), ("H7", 0.0), ("H7", 121.0)):
        with pytest.raises(ValueError, match="known are G, H, h and m"):
            deviations_um(fit, nominal)


def test_the_seats_tolerances_are_those_of_their_fits() -> None:
    seat = 16.0
    assert (deviations_um("H7", seat)[1] / 1000, deviations_um("H6", seat)[1] / 1000) == SEATS_MM
    assert -deviations_um(MANDREL_FIT, seat)[0] / 1000 == MANDREL_MM
    assert (deviations_um("H7", 3.0)[1] - deviations_um("m6", 3.0)[0]) / 2000 == pytest.approx(DOWEL_PLAY_MM)


def test_a_blind_thread_has_its_run_out_and_its_tip() -> None:
    assert [drilled_mm("M4", 8.0), drilled_mm("M2.5", 8.0), drilled_mm("M3", 7.0)] == [10.5, 10.0, 9.0]
    assert tip_mm(10.0) == pytest.approx(3.0043, abs=1e-4)  # 0.3 of the diameter, as shops reckon
    assert tip_mm(10.0, 0.0) == 0.0
    for row in catalogue.screw.rows.values():
        assert drilled_mm(row.id, 5.0) - 5.0 >= RUN_OUT_MM[row.pitch_mm]
    for pitch, way in RUN_OUT_MM.items():
        assert 3.0 * pitch <= way <= 4.0 * pitch  # a tap's lead of form C, 2 to 3 turns, and one turn more
