"""What the drive gives: figures by hand, limits, energy, and the verdict at its borders."""

from __future__ import annotations

import math
from dataclasses import FrozenInstanceError
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from delta_cad import catalogue
from delta_cad.design import Design, design_from_dict, design_to_dict, load_design
from delta_cad.drive.report import CAPSTAN_EFFICIENCY, SLACK_N, drive_torque

BEST = load_design(Path(__file__).parents[3] / "examples" / "synthesized.json")


def design(torque: float = 0.8, peak: float | None = None, **hardware: Any) -> Design:
    """The committed design with other torques required, a peak only where one is given, or other hardware."""
    data = design_to_dict(BEST)
    del data["requirements"]["peak_torque_N_m"]
    data["requirements"]["joint_torque_N_m"] = torque
    if peak is not None:
        data["requirements"]["peak_torque_N_m"] = peak
    data["hardware"] |= hardware
    return design_from_dict(data)


def test_a_capstan_by_hand() -> None:
    """85 mN m and 3.33e-6 kg m^2 through 10:1 on a 40 mm sector, with 0.54 mm cable of 157 N, for 1.2 N m."""
    report = drive_torque(design(0.8, 1.2, capstan_ratio=10.0, sector_radius_mm=40.0))
    assert report.continuous_torque_N_m == pytest.approx(0.816, rel=1e-12)  # 0.085 x 10 x 0.96
    assert report.peak_torque_N_m == pytest.approx(2.448, rel=1e-12)
    assert report.reflected_inertia_kg_m2 == pytest.approx(3.33e-4, rel=1e-12)
    assert report.controlled_torque_N_m == 1.2
    force = 1.25 / 0.040  # N: 1.2 N m and what the cable loses, at the sector's rim
    assert report.cable_pretension_N == pytest.approx(4.0 + force / 2.0, rel=1e-12)  # 4 N are left of it
    assert report.cable_tension_N == pytest.approx(4.0 + force, rel=1e-12)
    assert report.cable_safety_factor == pytest.approx(157.0 / (4.0 + force), rel=1e-12)
    assert report.bend_ratio == pytest.approx((8.0 - 0.54) / 0.54, rel=1e-12)
    assert report.verdict == "continuous"
    assert (report.required_torque_N_m, report.required_peak_N_m) == (0.8, 1.2)


def test_the_controller_gives_what_is_requested_a_moment_or_what_the_drive_has() -> None:
    """2.448 N m are there; a peak that nobody asks for is what is asked for ever."""
    for torque, peak, required, controlled in (
        (0.5, None, 0.5, 0.5),
        (0.5, 0.5, 0.5, 0.5),
        (0.5, 2.4, 2.4, 2.4),
        (0.5, 3.0, 3.0, 2.448),
        (3.0, None, 3.0, 2.448),
    ):
        report = drive_torque(design(torque, peak, capstan_ratio=10.0, sector_radius_mm=40.0))
        assert (report.required_torque_N_m, report.required_peak_N_m) == (torque, required)
        assert report.controlled_torque_N_m == pytest.approx(controlled, rel=1e-12)
        force = controlled / 0.96 / 0.040
        assert report.cable_pretension_N == pytest.approx(4.0 + force / 2.0, rel=1e-12)
        assert report.cable_tension_N == pytest.approx(4.0 + force, rel=1e-12)


def test_a_direct_drive_by_hand() -> None:
    report = drive_torque(design(motor="maxon-ec60flat-625858", drive="direct"))
    assert (report.ratio, report.efficiency) == (1.0, 1.0)
    assert (report.continuous_torque_N_m, report.peak_torque_N_m) == (0.401, 1.203)
    assert report.reflected_inertia_kg_m2 == 8.1e-5
    assert report.verdict == "peak only"
    for name in (
        "cable",
        "cable_pretension_N",
        "cable_tension_N",
        "cable_safety_factor",
        "bend_ratio",
        "bend_ratio_recommended",
    ):
        assert getattr(report, name) is None


@pytest.mark.parametrize("key", [k for k in catalogue.family("motor") if "capstan" in catalogue.motor(k).drives])
def test_the_verdict_changes_at_the_limits(key: str) -> None:
    report = drive_torque(design(motor=key, capstan_ratio=9.0))
    for torque, verdict in (
        (report.continuous_torque_N_m, "continuous"),
        (math.nextafter(report.continuous_torque_N_m, math.inf), "peak only"),
        (report.peak_torque_N_m, "peak only"),
        (math.nextafter(report.peak_torque_N_m, math.inf), "insufficient"),
    ):
        assert drive_torque(design(torque, motor=key, capstan_ratio=9.0)).verdict == verdict
    for torque, peak, verdict in (  # a peak is judged by itself
        (report.continuous_torque_N_m, report.peak_torque_N_m, "continuous"),
        (math.nextafter(report.continuous_torque_N_m, math.inf), report.peak_torque_N_m, "peak only"),
        (report.continuous_torque_N_m, math.nextafter(report.peak_torque_N_m, math.inf), "insufficient"),
    ):
        assert drive_torque(design(torque, peak, motor=key, capstan_ratio=9.0)).verdict == verdict


def test_the_ratio_for_continuous_torque_is_the_one() -> None:
    report = drive_torque(design())
    ratio = report.ratio * report.required_torque_N_m / report.continuous_torque_N_m
    assert drive_torque(design(capstan_ratio=ratio * (1 + 1e-12))).verdict == "continuous"
    assert drive_torque(design(capstan_ratio=ratio * (1 - 1e-12))).verdict == "peak only"


@settings(deadline=None)  # nothing is timed in a test: the machine may be shared
@given(
    ratio=st.floats(4, 12),
    torque=st.floats(0.01, 6),
    sector=st.floats(53, 70),  # the thickest cable on the thickest shaft at 12:1 needs 52.8 mm
    motor=st.sampled_from([k for k in catalogue.family("motor") if "capstan" in catalogue.motor(k).drives]),
    cable=st.sampled_from(list(catalogue.family("cable"))),
)
def test_power_and_statics_hold_for_any_capstan(
    ratio: float, torque: float, sector: float, motor: str, cable: str
) -> None:
    report = drive_torque(design(torque, capstan_ratio=ratio, sector_radius_mm=sector, motor=motor, cable=cable))
    row, rope = catalogue.motor(motor), catalogue.cable(cable)
    rate = 1.7  # rad/s at the joint, any
    motor_power = row.nominal_torque_N_m * ratio * rate
    assert report.continuous_torque_N_m * rate == pytest.approx(CAPSTAN_EFFICIENCY * motor_power, rel=1e-12)
    kinetic = 0.5 * row.rotor_inertia_kg_m2 * (ratio * rate) ** 2
    assert 0.5 * report.reflected_inertia_kg_m2 * rate**2 == pytest.approx(kinetic, rel=1e-12)
    assert report.cable_tension_N is not None
    assert report.cable_pretension_N is not None
    assert report.cable_safety_factor is not None
    assert report.bend_ratio is not None
    slack = 2.0 * report.cable_pretension_N - report.cable_tension_N  # what the other side loses, this side gains
    pinion_radius = sector / 1000.0 / ratio
    at_the_motor = (report.cable_tension_N - slack) * pinion_radius
    assert at_the_motor * ratio * CAPSTAN_EFFICIENCY == pytest.approx(report.controlled_torque_N_m, rel=1e-9)
    assert report.controlled_torque_N_m == min(torque, report.peak_torque_N_m)
    assert at_the_motor <= row.peak_torque_N_m * (1.0 + 1e-9)  # a difference of tensions, as above
    assert slack == pytest.approx(SLACK_N, rel=1e-9)
    assert SLACK_N > 0.0
    assert report.cable_safety_factor * report.cable_tension_N == pytest.approx(rope.breaking_load_N, rel=1e-12)
    wrapped = (report.bend_ratio + 1.0) * rope.diameter_mm  # pitch diameter: groove and half a cable on each side
    assert wrapped == pytest.approx(2000.0 * pinion_radius, rel=1e-12)
    assert report.bend_ratio_recommended == rope.min_bend_ratio


def test_the_committed_design_gives_its_torque_for_ever_and_its_peak_and_spares_its_cable() -> None:
    report = drive_torque(BEST)
    assert report.verdict == "continuous"
    assert report.continuous_torque_N_m == pytest.approx(0.39168, rel=1e-12)  # 0.085 x 4.8 x 0.96, for 0.39 N m
    assert report.peak_torque_N_m == pytest.approx(1.17504, rel=1e-12)
    assert report.controlled_torque_N_m == report.required_peak_N_m == 0.8
    assert report.motor == BEST.hardware.motor
    assert report.cable_pretension_N == pytest.approx(4.0 + 0.8 / 0.96 / 0.0387 / 2.0, rel=1e-12)  # 14.8 N
    assert report.cable_safety_factor is not None
    assert report.cable_safety_factor > 6.0


def test_the_report_is_frozen() -> None:
    with pytest.raises(FrozenInstanceError):
        drive_torque(BEST).ratio = 1.0  # pyright: ignore[reportAttributeAccessIssue]
