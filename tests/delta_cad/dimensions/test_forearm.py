"""Rods and their joints: closed forms against brute force, statics and the figures of a textbook's contact."""

from __future__ import annotations

from itertools import product
from math import asin, cos, hypot, pi, radians, sin, sqrt, tan
from typing import Any

import numpy as np
import pytest

from delta_cad import catalogue
from delta_cad.dimensions import DimensionError, Dimensions
from delta_cad.dimensions.forearm import (
    ForearmDimensions,
    eyes_mm,
    forearm_dimensions,
    tilt_N_mm2,
    wrist_radius_min_mm,
)
from delta_cad.dimensions.joint import POCKET_MM, chosen_spring, force_most_N, patch_angle_rad, sliding_torques_N_mm
from delta_cad.structure.rod_end import bond_tilt_N_mm2
from tests.delta_cad.dimensions.edited import edited


@pytest.mark.parametrize(("cup", "width", "clearance"), [(5.7, 54.0, 2.0), (4.7, 44.0, 1.0)])
def test_the_least_platform_radius_brings_neighbouring_cups_to_the_clearance(
    cup: float, width: float, clearance: float
) -> None:
    r = wrist_radius_min_mm(cup, width, clearance)
    balls = [
        (i, r * np.array([cos(a), sin(a)]) + s * width / 2 * np.array([-sin(a), cos(a)]))
        for i, s in product(range(3), (-1, 1))
        for a in (2 * pi * i / 3,)
    ]
    apart = min(float(np.linalg.norm(p - q)) for i, p in balls for j, q in balls if i != j)
    assert apart - 2 * cup == pytest.approx(clearance, abs=1e-9)


def test_the_joystick_s_hardware_goes_down_to_24_mm_of_platform_radius() -> None:
    assert edited(ball_diameter_mm=6.0).forearm.wrist_radius_min_mm <= 22.5
    assert edited(ball_diameter_mm=8.0).forearm.wrist_radius_min_mm <= 24.0


def test_the_contact_reaches_as_far_as_load_and_half_its_angle(best_dimensions: Dimensions) -> None:
    """Statics of one rod's end, either sign of the rod's force; the preload left brings the contact to the lip."""
    joint = best_dimensions.forearm.joint
    force, lean = np.array([0.0, 2.0, 5.0, 9.0, 9.0]), np.radians([0.0, 24.0, 3.0, 20.0, -20.0])
    worst = np.zeros(5)
    for sign in (-1.0, 1.0):
        across = sign * force + joint.preload_N * np.sin(lean)
        worst = np.maximum(worst, np.abs(np.arctan2(across, joint.preload_N * np.cos(lean))))
    half = joint.edge_rad(force, lean) - worst
    assert (half > np.radians(15.0)).all()
    assert (half < np.radians(28.0)).all()
    assert half[0] == half.min()
    left = joint.margin_preload_N(force, lean)
    assert left[0] == left.max()
    np.testing.assert_allclose(joint.edge_rad(force[1:], lean[1:], (joint.preload_N - left)[1:]), joint.wrap_rad)
    assert (joint.margin_preload_N(np.array(60.0), np.array(0.4)) < 0.0).all()


def test_a_contact_s_angle_is_that_of_the_textbook_s_two_limits() -> None:
    """By hand: Hertz where the plastic is thick, the sum of a thin layer's pressures over the dented cap elsewhere."""
    radius, clearance, pair, load = 3.0, 0.01, 6000.0, 12.0
    thick = float(patch_angle_rad(radius, np.array(load), pair, 1e9 * pair, clearance))
    assert thick < 1e-2  # a bed that nothing dents
    hertz = (0.75 * load * radius * (radius + clearance) / clearance / pair) ** (1 / 3)
    assert patch_angle_rad(radius, np.array(load), pair, 1.0, clearance) == pytest.approx(asin(hertz / radius))
    bed = 15e3
    half = float(patch_angle_rad(radius, np.array(load), pair, bed, clearance))
    at = (np.arange(20_000) + 0.5) / 20_000 * half
    deep = clearance * (np.cos(at) - cos(half))  # how far the ball goes into the plastic
    carried = float(np.sum(bed * deep * 2 * pi * radius**2 * np.sin(at) * np.cos(at)) * half / 20_000)
    assert carried == pytest.approx(load, rel=0.05)  # small angles


def test_the_joint_s_figures_are_those_of_the_published_example(best_dimensions: Dimensions) -> None:
    """Hertz by hand, in newtons and millimetres, and what the task asks: 500 N/mm either way, friction some N mm."""
    joint = best_dimensions.forearm.joint
    ball = best_dimensions.forearm.ball_diameter_mm / 2
    cup = ball + 0.0075
    modulus = 1.0 / ((1.0 - 0.35**2) / 5500.0 + (1.0 - 0.35**2) / 210000.0)
    relative = 1.0 / (1.0 / ball - 1.0 / cup)
    whole = (0.75 * joint.preload_N * relative / modulus) ** (1 / 3)
    edge = hypot(whole, POCKET_MM / 2)
    assert joint.pair_N_mm2 == pytest.approx(modulus, rel=1e-9)
    # what presses outside the pocket is the preload, and most at the pocket's edge
    r = (np.arange(100_000) + 0.5) / 100_000 * (edge - POCKET_MM / 2) + POCKET_MM / 2
    most = 2.0 * modulus * edge / (pi * relative)
    pressure = most * np.sqrt(1.0 - (r / edge) ** 2)
    step = (edge - POCKET_MM / 2) / 100_000
    assert (2 * pi * r * pressure).sum() * step == pytest.approx(joint.preload_N, rel=1e-4)
    lean, turn = sliding_torques_N_mm(2 * ball, np.array(joint.preload_N))
    assert turn == pytest.approx(0.08 * (2 * pi * r**2 * pressure).sum() * step, rel=1e-4)
    assert joint.stiffness_radial_N_mm >= joint.preload_N / joint.clearance_mm  # of a ball that rolls in a whole cup
    assert lean == pytest.approx(0.08 * joint.preload_N * ball)
    assert turn < lean / 4


def test_without_a_pocket_the_contact_is_the_textbook_s(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("delta_cad.dimensions.joint.POCKET_MM", 1e-9)
    joint = edited(ball_diameter_mm=6.0).forearm.joint
    relative = 3.0 * 3.0075 / 0.0075  # of ball and cup
    arm = 3.0 * pi / 16.0 * (0.75 * joint.preload_N * relative / joint.pair_N_mm2) ** (1 / 3)
    _, turn = sliding_torques_N_mm(6.0, np.array(joint.preload_N))
    assert turn == pytest.approx(0.08 * joint.preload_N * arm, rel=1e-6)
    rolling = joint.preload_N / joint.clearance_mm * (1.0 + joint.clearance_mm / joint.ball_radius_mm)
    assert joint.stiffness_radial_N_mm == pytest.approx(rolling, rel=1e-6)


@pytest.mark.parametrize("width", [36.0, 40.0, 48.0, 54.0, 60.0, 66.0])
def test_springs_give_their_preload_and_bear_the_lean(width: float) -> None:
    d = edited(parallelogram_width_mm=width, platform_radius_mm=40.0, half_side_mm=8.0, bottom_height_mm=75.0)
    f = d.forearm
    assert 8.0 <= f.joint.spring_N <= 13.0
    assert f.joint.spring_max_N <= f.spring.force_max_N


def test_preloads_of_elbow_and_wrist_balance_both_springs(best_dimensions: Dimensions) -> None:
    """A rod as a beam on its two balls, and a spring at each of its eyes."""
    f = best_dimensions.forearm
    forces = np.linalg.solve(
        [[1.0, 1.0], [0.0, f.length_mm]], [2 * f.joint.spring_N, f.joint.spring_N * sum(f.eyes_x_mm)]
    )
    assert sorted([f.joint.preload_N, f.joint.preload_max_N]) == pytest.approx(sorted(forces))
    held = f.joint.preload_N * (cos(radians(28.0)) * tan(f.joint.wrap_rad) - sin(radians(28.0)))  # at the cup's lip
    assert held >= 24.0  # what 3 N at the handle, gravity and 1 g ask of best.json


def test_springs_are_within_their_own_length(best_dimensions: Dimensions) -> None:
    f = best_dimensions.forearm
    longest = sqrt((f.width_mm * cos(radians(28.0)) - 1.6) ** 2 + (f.width_mm * sin(radians(28.0))) ** 2)
    assert f.spring.free_length_mm < f.between_eyes_mm < longest <= f.spring.length_max_mm
    assert chosen_spring(f.between_eyes_mm, f.eye_y_mm) is f.spring


def test_beyond_the_strongest_spring_none_is_chosen_at_any_width_and_below_it_one_is() -> None:
    most, widths = force_most_N(), np.linspace(5.0, 200.0, 1951).tolist()
    for width in widths:
        with pytest.raises(DimensionError, match=r"springs must give .* strongest give 44\.8$"):
            chosen_spring(width, 3.0, 1.001 * most)

    def fits(width: float) -> bool:
        try:
            return chosen_spring(width, 3.0, 0.999 * most).force_max_N >= most
        except DimensionError:
            return False

    assert any(map(fits, widths))


def forearm(d: Dimensions, **changes: Any) -> ForearmDimensions:
    """A parallelogram of 120 mm and 54 mm on balls of 8 mm for 3 N, or what is changed of it."""
    usual = {"length_mm": 120.0, "width_mm": 54.0, "ball_mm": 8.0, "boss_width_mm": 16.0, "fold_rad": 0.8}
    limits = {"force_N": 3.0, "lean_max_deg": 28.0, "clearance_mm": 2.0}
    return forearm_dimensions(**{"arm": d.arm, "tube": catalogue.tube("cfrp-5x3"), **usual, **limits, **changes})


def test_a_cross_bar_that_its_boss_does_not_leave_free_is_refused_with_its_bound(best_dimensions: Dimensions) -> None:
    """By hand: 7.1 mm of stand-off at either end, and 1 mm beside the boss."""
    forearm(best_dimensions, boss_width_mm=37.8 - 1e-9)
    with pytest.raises(DimensionError, match=r"^cross_bar, length: 54 mm .* 54\.2 mm$"):
        forearm(best_dimensions, boss_width_mm=38.0)


def test_a_cross_bar_is_bonded_over_its_boss_and_not_at_its_cones(best_dimensions: Dimensions) -> None:
    """A bar of 9 mm on a stud of 2.25 + 0.8 mm has cones of 1.45 mm; its boss of 38 mm takes what lies between."""
    least = 38.0 + 2 * (1.45 + 7.1)
    made = forearm(best_dimensions, width_mm=least, boss_width_mm=38.0, bar_mm=9.0)
    assert made.cone_mm == pytest.approx(1.45)
    assert made.bar_length_mm - 2 * made.cone_mm == pytest.approx(38.0)
    with pytest.raises(DimensionError, match=r"^cross_bar, length: .*; at least 55\.1 mm$"):
        forearm(best_dimensions, width_mm=least - 0.01, boss_width_mm=38.0, bar_mm=9.0)


@pytest.mark.parametrize(("fold", "lean"), [(0.3, 0.4), (0.6, 0.0), (1.2, 0.4), (1.57, 0.2), (2.4, 0.0)])
def test_springs_keep_their_distance_from_the_arm_next_to_which_rods_fold(
    best_dimensions: Dimensions, fold: float, lean: float
) -> None:
    """Brute force: circles whose hull the arm is; one spring outside the rod, one inside, at the fold and wider."""
    arm, aside = best_dimensions.arm, best_dimensions.forearm.eye_z_mm
    t = np.linspace(0.0, 1.0, 20_001)
    radius = arm.boss_radius_mm + (arm.beam_root_radius_mm - arm.boss_radius_mm) * t
    for eye, z in zip(eyes_mm(arm, fold, lean, 5.0, 60.0, 18.0), (aside, -aside), strict=True):
        x = eye * cos(lean)
        gaps = []
        for angle in np.linspace(fold, pi, 50):
            u, w = x * cos(angle) - z * sin(angle), x * sin(angle) + z * cos(angle)
            if eye < 60.0 - 18.0 or angle < pi / 2:
                gaps.append(float((np.hypot(u - t * arm.length_mm, w) - radius).min()))
        if gaps:
            assert min(gaps) >= 5.0 - 1e-3


@pytest.mark.parametrize("force", [3.0, 9.0, 30.0])
def test_the_bond_of_a_spigot_bears_five_times_the_worst_rod_force(best_dimensions: Dimensions, force: float) -> None:
    f = forearm(best_dimensions, length_mm=400.0, fold_rad=1.0, force_N=force)
    area = pi * f.spigot_diameter_mm * f.spigot_length_mm
    assert area * 2.0 >= 5.0 * 6.1 * force
    assert f.tube_bore_mm - f.spigot_diameter_mm == pytest.approx(0.2)  # 0.1 mm of glue around it
    assert f.tube_length_mm > 2 * f.spigot_length_mm


@pytest.mark.parametrize(("width", "peak"), [(54.0, 0.0), (107.4, 0.0), (50.0, 20.0)])
def test_the_bond_of_a_spigot_bears_what_its_springs_tilt_it_by(
    best_dimensions: Dimensions, width: float, peak: float
) -> None:
    """In the thinnest tube; 8 mm broke it, and a smaller force was asked for: the least springs are no weaker."""
    tube = catalogue.tube("cfrp-4x2.5")
    sizes = {"length_mm": 400.0, "width_mm": width, "ball_mm": 10.0, "fold_rad": 1.0}
    f = forearm(best_dimensions, **sizes, tube=tube, force_N=1.0, peak_N=peak)
    along = 2.0 * pi * f.spigot_diameter_mm * f.spigot_length_mm  # as much of the rod's force as its shear bears
    assert bond_tilt_N_mm2(f, np.array(along)) <= tilt_N_mm2()
    assert f.tube_length_mm > 2 * f.spigot_length_mm


def test_studs_bend_less_in_the_ball_and_at_the_bar_than_an_m3_would() -> None:
    """MPa per newton at the ball's centre, at the mouth of the ball's hole and at the bar; an M3 had 5.4 of 190 MPa."""
    for ball in (5.0, 6.0, 8.0, 10.0):
        f = edited(ball_diameter_mm=ball, parallelogram_width_mm=58.0, platform_radius_mm=40.0).forearm
        mouth = sqrt((ball / 2) ** 2 - (f.pin_diameter_mm / 2) ** 2)
        in_ball = 32 * mouth / (pi * f.pin_diameter_mm**3)
        at_bar = 32 * f.stand_off_mm / (pi * f.neck_diameter_mm**3)
        assert max(in_ball, at_bar) < 3.2
        assert 0.5 < in_ball / at_bar < 2.0
        assert asin(f.neck_diameter_mm / ball) < radians(36.0)
