"""Keys at a motor: lengths by hand, directions against the pinion's turning, rules against borders that they name."""

from __future__ import annotations

from dataclasses import replace
from math import hypot, inf, pi, radians, tau
from typing import Any

import numpy as np
import pytest

from delta_cad import catalogue
from delta_cad.dimensions import DimensionError, Dimensions, preload_spring
from delta_cad.dimensions.bracket import require_room_for_board
from delta_cad.dimensions.capstan import cable_run, collar_mm, collar_off_mm
from delta_cad.dimensions.layers import KEYS_MM, cut_key_mm, handle_room_mm, motor_screw_mm, set_screws_rad
from delta_cad.dimensions.tolerances import preload_range_N
from delta_cad.structure.hardware.refusals import refusals
from delta_cad.structure.strength import tightening_N_m
from tests.delta_cad.catalogue.offered import machine


def test_a_screw_is_as_long_as_a_cut_key_lets_it_stand_out(best_dimensions: Dimensions) -> None:
    """M3 in the RE 30: 3.9 mm of thread; a key of 15 mm and half of 2.26 mm must pass the encoder's cheek.

    Of 5 mm 1.5 are under the head, 0.4 more than would fill the thread; one of 6 would meet the turns on the pinion.
    """
    d = best_dimensions
    web = d.layers.motor_face_mm - d.layers.motor_cheek_mm[0]
    assert motor_screw_mm(d.motor, d.layers) == (5.0, pytest.approx(web - 1.5))
    head = d.layers.motor_face_mm - 1.5 - 2.0
    assert 0.0 <= head - 3.5 - d.layers.turns_end_mm < 0.1  # drawn out, in whole tenths
    free = replace(d.layers, motor_pocket_mm=0.0, turns_end_mm=-inf)
    thick = replace(free, motor_cheek_mm=(13.8, 20.8))
    assert motor_screw_mm(d.motor, thick) == (8.0, pytest.approx(2.9))
    assert motor_screw_mm(d.motor, replace(free, motor_cheek_mm=(13.8, 20.2))) == (6.0, pytest.approx(4.3))
    narrow = replace(thick, encoder_cheek_mm=(-6.0, 0.0))  # the key of one of 8 mm would end at -1.6
    assert motor_screw_mm(d.motor, narrow) == (6.0, pytest.approx(4.9))


def test_what_is_left_of_a_cut_keys_handle_tightens_any_motors_screws_by_hand() -> None:
    """M3: 0.71 N m at 26 mm of the 52 that a key for it has; M4, the largest, 1.7 at 35."""
    assert cut_key_mm(2.0) == (pytest.approx(15.0), pytest.approx(26.0))
    screws = {row.mount_screw.id: row.mount_screw for row in catalogue.motor.rows.values()}
    keys = {size: row.socket_mm for size, row in screws.items() if row.socket_mm in KEYS_MM}
    pushed = {size: 1e3 * tightening_N_m(screws[size]) / cut_key_mm(key)[1] for size, key in keys.items()}
    assert {"M2.5", "low-M3", "low-M4"} <= set(pushed)
    assert pushed["low-M3"] == pytest.approx(710.0 / 26.0, rel=0.01)
    assert max(pushed.values()) <= 50.0


def test_the_base_lies_four_fifths_of_a_keys_long_leg_below_the_motor(best_dimensions: Dimensions) -> None:
    assert handle_room_mm(best_dimensions.motor) == pytest.approx(0.8 * 52.0)
    assert handle_room_mm(catalogue.motor("maxon-re50-370354")) == pytest.approx(0.8 * 58.5)


@pytest.mark.parametrize("slot", [-0.3, 0.0, 0.9])
@pytest.mark.parametrize("low", [-5.0, -1.0, 0.4])
@pytest.mark.parametrize("turn", [1.6, 3.0, 7.0])
def test_each_set_screw_comes_to_its_slot_as_the_pinion_turns(slot: float, low: float, turn: float) -> None:
    ways = set_screws_rad(slot, (low, low + turn))
    assert ways[1] - ways[0] == pytest.approx(pi / 2)
    turned = np.linspace(low, low + turn, 20001)
    for way in ways:
        off = np.abs((way + turned - slot + pi) % tau - pi)
        assert off.min() < 1e-3
    if turn > tau:
        assert ways == (0.0, pi / 2)


def test_a_pinion_that_turns_too_little_for_both_set_screws_is_refused() -> None:
    least = radians(88.0)
    set_screws_rad(0.2, (1.0, 1.0 + least + 1e-9))
    with pytest.raises(DimensionError, match=r"^pinion, set screws: .* turns by 44 deg; .* within 88$"):
        set_screws_rad(0.2, (1.0, 1.0 + least / 2))


def test_a_pinion_past_which_no_screw_is_drawn_out_is_refused_at_the_sector_that_would_do() -> None:
    """RE 30: screws on 22 mm with heads of 5.5; the crest lies a quarter of a cable inside the pitch circle."""
    changes: dict[str, Any] = {"hardware__capstan_ratio": 3.0, "requirements__joint_torque_N_m": 0.24}
    changes |= {"requirements__peak_torque_N_m": None, "requirements__peak_force_N": None, "requirements__force_N": 1.0}
    most = 3.0 * (11.0 - 2.75 - 0.2 + 0.54 / 4)
    for radius, is_refused in ((most - 1e-6, False), (most + 1e-6, True)):
        changes["hardware__sector_radius_mm"] = radius
        found = {reason.feature for reason in refusals(machine(changes))}
        assert ("beside the motor's screws" in found) == is_refused


def test_a_motor_at_the_boards_height_meets_it_on_a_narrow_base(best_dimensions: Dimensions) -> None:
    d = best_dimensions
    u, height = d.bracket.motor_axis_mm[0], -12.0

    def requested(radius: float) -> None:
        axis = u + radius - d.bracket.shoulder_u_mm, height
        require_room_for_board(radius, axis, d.layers, d.motor, d.encoder)

    low, high = d.bracket.shoulder_u_mm, d.bracket.shoulder_u_mm + 60.0
    with pytest.raises(DimensionError):
        requested(low)
    requested(high)
    require_room_for_board(d.bracket.shoulder_u_mm, (u, -60.0), d.layers, d.motor, d.encoder)  # below the board


def test_a_stronger_wave_spring_is_chosen_for_a_larger_force(best_dimensions: Dimensions) -> None:
    bearing = best_dimensions.bearing
    assert preload_spring(bearing) == preload_spring(bearing, 6.0) == best_dimensions.preload
    strong = preload_spring(bearing, 15.0)
    assert preload_range_N(strong)[0] >= 0.6 * 15.0 > preload_range_N(preload_spring(bearing))[0]
    assert preload_spring(bearing, 1e3) == strong  # the strongest there is; its load is refused then


@pytest.mark.parametrize("ratio", [4.8, 5.2, 5.6, 6.2, 9.4])
def test_a_collar_stands_off_the_rim_by_its_own_gap_and_its_screws(ratio: float, best_dimensions: Dimensions) -> None:
    """A set screw, drawn 2.5 mm thick in the middle of 4.6 mm, leaves 1.05 mm to the collar's end; 2 mm are asked."""
    d = best_dimensions
    run = cable_run(38.7, ratio, (-1.0, 0.9), d.cable)
    collar, off = collar_mm(d.motor), collar_off_mm(run, 0.54, d.motor)
    rim = 38.7 - 0.54 / 4  # and it lies farther in by as much again
    adjacent = max(run.centre_distance_mm - collar - rim, 0.0)
    assert hypot(max(off, 0.0), adjacent) >= 1.3
    assert hypot(off + 1.05, adjacent) >= 2.0
    shorter = off - 0.11  # would not do: it is no longer than it must be
    assert off == -0.6 or hypot(max(shorter, 0.0), adjacent) < 1.35 or hypot(shorter + 1.05, adjacent) < 2.1
