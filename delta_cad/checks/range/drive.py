"""Motor and capstan: do they give the joint torque that is asked for?"""

from __future__ import annotations

from delta_cad.checks.report import CheckResult
from delta_cad.drive import DriveReport


def check_drive(drive: DriveReport) -> CheckResult:
    """Holds the torque of a drive against the joint torque that is required.

    The value is the torque for ever where that is enough, else the peak torque, N m.
    """
    detail = (
        f"{drive.motor}, {drive.drive} {drive.ratio:g}:1, {drive.verdict}: "
        f"{drive.continuous_torque_N_m:.3f} N m for ever, "
        f"{drive.peak_torque_N_m:.3f} N m for {drive.peak_time_s:g} s"
    )
    if drive.cable is not None:
        detail += (
            f"; cable safety {drive.cable_safety_factor:.1f} at the peak, bend ratio {drive.bend_ratio:.1f} "
            f"(makers advise {drive.bend_ratio_recommended:g} for long life)"
        )
    value = drive.continuous_torque_N_m if drive.verdict == "continuous" else drive.peak_torque_N_m
    passed = drive.verdict != "insufficient"
    return CheckResult("drive torque", passed, value, drive.required_torque_N_m, "N m", detail=detail)
