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
from delta_cad.drive.report import CAPSTAN_EFFICIENCY, SLACK_RESERVE, drive_torque

BEST = load_design(Path(__file__).parents[3] / "best.json")


def design(torque: float = 0.8, **hardware: Any) -> Design:
    """The committed design with another requirement or other hardware."""
    data = design_to_dict(BEST)
    data["requirements"]["joint_torque_N_m"] = torque
    data["hardware"] |= hardware
    return design_from_dict(data)


def test_a_capstan_by_hand() -> None:
    """85 mN m and 3.33e-6 kg m^2 through 10:1 on a 40 mm sector, with 0.54 mm cable of 157 N."""
    report = drive_torque(design(capstan_ratio=10.0))
    assert report.continuous_torque_N_m == pytest.approx(0.816, rel=1e-12)  # 0.085 x 10 x 0.96
    assert report.peak_torque_N_m == pytest.approx(2.448, rel=1e-12)
    assert report.reflected_inertia_kg_m2 == pytest.approx(3.33e-4, rel=1e-12)
    force = 2.55 / 0.040  # N, peak motor torque through the ratio, no loss
    assert report.cable_pretension_N == pytest.approx(0.6 * force, rel=1e-12)
    assert report.cable_tension_N == pytest.approx(1.1 * force, rel=1e-12)
    assert report.cable_safety_factor == pytest.approx(157.0 / (1.1 * force), rel=1e-12)
    assert report.bend_ratio == pytest.approx((8.0 - 0.54) / 0.54, rel=1e-12)
    assert report.verdict == "continuous"
    assert report.required_torque_N_m == 0.8


def test_a_direct_drive_by_hand() -> None:
    report = drive_torque(design(motor="maxon-ec60flat-625858", drive="direct"))
    assert (report.ratio, report.efficiency) == (1.0, 1.0)
    assert (report.continuous_torque_N_m, report.peak_torque_N_m) == (0.401, 1.203)
    assert report.reflected_inertia_kg_m2 == 8.1e-5
    assert report.verdict == "peak only"
    assert report.ratio_for_continuous is None
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
        (math.nextafter(report.continuous_torque_N_m, 9.0), "peak only"),
        (report.peak_torque_N_m, "peak only"),
        (math.nextafter(report.peak_torque_N_m, 9.0), "insufficient"),
    ):
        assert drive_torque(design(torque, motor=key, capstan_ratio=9.0)).verdict == verdict


def test_the_ratio_for_continuous_torque_is_the_one() -> None:
    ratio = drive_torque(design()).ratio_for_continuous
    assert ratio is not None
    assert drive_torque(design(capstan_ratio=ratio * (1 + 1e-12))).verdict == "continuous"
    assert drive_torque(design(capstan_ratio=ratio * (1 - 1e-12))).verdict == "peak only"


@settings(deadline=None)  # nothing is timed in a test: the machine may be shared
@given(
    ratio=st.floats(4, 12),
    sector=st.floats(42, 60),  # the thickest cable on the thickest shaft at 12:1 needs 40.8 mm
    motor=st.sampled_from([k for k in catalogue.family("motor") if "capstan" in catalogue.motor(k).drives]),
    cable=st.sampled_from(list(catalogue.family("cable"))),
)
def test_power_and_statics_hold_for_any_capstan(ratio: float, sector: float, motor: str, cable: str) -> None:
    report = drive_torque(design(capstan_ratio=ratio, sector_radius_mm=sector, motor=motor, cable=cable))
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
    torque = (report.cable_tension_N - slack) * pinion_radius
    assert torque == pytest.approx(row.peak_torque_N_m, rel=1e-12)
    assert slack == pytest.approx((SLACK_RESERVE - 1.0) / 2.0 * torque / pinion_radius, rel=1e-9)  # a difference
    assert slack > 0.0
    assert report.cable_safety_factor * report.cable_tension_N == pytest.approx(rope.breaking_load_N, rel=1e-12)
    wrapped = (report.bend_ratio + 1.0) * rope.diameter_mm  # pitch diameter: groove and half a cable on each side
    assert wrapped == pytest.approx(2000.0 * pinion_radius, rel=1e-12)
    assert report.bend_ratio_recommended == rope.min_bend_ratio


def test_the_committed_design_gives_its_torque_at_least_as_a_peak_and_spares_its_cable() -> None:
    report = drive_torque(BEST)
    assert report.verdict in {"continuous", "peak only"}
    assert report.motor == BEST.hardware.motor
    assert report.cable_safety_factor is not None
    assert report.cable_safety_factor > 2.0


def test_the_report_is_frozen() -> None:
    with pytest.raises(FrozenInstanceError):
        drive_torque(BEST).ratio = 1.0  # pyright: ignore[reportAttributeAccessIssue]
