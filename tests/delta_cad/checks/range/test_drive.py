"""Both torques of a drive against what is required of them, by hand and at their borders."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from delta_cad.checks.range.drive import check_bend, check_drive
from delta_cad.checks.report import CheckResult, all_passed
from delta_cad.design import Design
from delta_cad.drive import DriveReport, drive_torque
from tests.delta_cad.dimensions.edited import edited


@pytest.fixture
def drive(best: Design) -> DriveReport:
    """0.392 N m for ever and 1.175 N m for a moment; 0.39 and 0.8 N m are asked."""
    return drive_torque(best)


def by_name(drive: DriveReport) -> dict[str, CheckResult]:
    checks = check_drive(drive)
    found = {check.name: check for check in checks}
    assert len(found) == len(checks)
    return found


def test_the_committed_design_is_held_against_both(drive: DriveReport) -> None:
    found = by_name(drive)
    assert list(found) == ["drive torque", "drive peak torque"]
    assert all_passed(found.values())
    for_ever, peak = found.values()
    assert (for_ever.value, for_ever.limit) == (pytest.approx(0.39168, rel=1e-12), 0.39)
    assert (peak.value, peak.limit) == (pytest.approx(1.17504, rel=1e-12), 0.8)
    assert {check.unit for check in found.values()} == {"N m"}
    for number in ("0.392 N m", "1.175 N m", "2 s", "4.8:1", "cable for 0.800 N m"):
        assert number in for_ever.detail


def test_each_fails_alone_and_at_its_own_limit(drive: DriveReport) -> None:
    at = replace(drive, required_torque_N_m=drive.continuous_torque_N_m, required_peak_N_m=drive.peak_torque_N_m)
    assert all_passed(check_drive(at))
    more = replace(at, required_torque_N_m=math.nextafter(at.required_torque_N_m, 9.0))
    assert {name: check.passed for name, check in by_name(more).items()} == {
        "drive torque": False,
        "drive peak torque": True,
    }
    more = replace(at, required_peak_N_m=math.nextafter(at.required_peak_N_m, 9.0))
    assert {name: check.passed for name, check in by_name(more).items()} == {
        "drive torque": True,
        "drive peak torque": False,
    }


def test_without_a_peak_there_is_one_check(drive: DriveReport) -> None:
    """What is given for a moment alone is not enough for what is asked for ever."""
    same = replace(drive, required_peak_N_m=drive.required_torque_N_m)
    assert list(by_name(same)) == ["drive torque"]
    between = replace(drive, required_torque_N_m=0.8, required_peak_N_m=0.8)
    (only,) = check_drive(between)
    assert (only.passed, only.value, only.limit) == (False, drive.continuous_torque_N_m, 0.8)


def test_a_direct_drive_tells_of_no_cable(drive: DriveReport) -> None:
    direct = replace(drive, drive="direct", ratio=1.0, cable=None, cable_pretension_N=None)
    assert all("cable" in check.detail for check in check_drive(drive))
    assert not any("cable" in check.detail for check in check_drive(direct))


def test_the_bend_ratio_is_the_groove_s_and_life_grows_thirteenfold_with_twice_the_diameter(
    best: Design, drive: DriveReport
) -> None:
    h = best.hardware
    (result,) = check_bend(drive)
    assert result.name == "cable bend ratio"
    assert result.value == pytest.approx((2 * h.sector_radius_mm / h.capstan_ratio - 0.54) / 0.54)
    assert (result.passed, result.limit) == (True, 16.0)  # 7x7: 40 advised, short below 16
    assert "30 % of the bending life" in result.detail
    assert drive.bend_ratio_recommended is not None
    for ratio, share in ((40.0, 1.0), (20.0, 1 / 13), (80.0, 13.0), (-1.0, 0.0)):
        assert replace(drive, bend_ratio=ratio).bend_life_share == pytest.approx(share)


@pytest.mark.parametrize(("cable", "ratio", "holds"), [("7x7", 8.6, True), ("7x7", 8.8, False), ("7x19", 11.0, True)])
def test_a_pinion_too_thin_for_its_cable_is_refused(cable: str, ratio: float, holds: bool) -> None:
    """A sector of 40 mm: 16 diameters of a 7x7 are a ratio of 8.71; 10 of a 7x19, which bends more easily, 13.5."""
    thin = edited(cable=f"steel-0.54-{cable}", capstan_ratio=ratio, motor="maxon-re30-310009")
    (result,) = check_bend(drive_torque(thin.design))
    assert result.passed == holds
    assert result.limit == pytest.approx({"7x7": 16.0, "7x19": 10.0}[cable])


def test_a_direct_drive_bends_no_cable() -> None:
    assert check_bend(drive_torque(edited(drive="direct", motor="maxon-ec60flat-625858").design)) == []
