"""Motor and capstan: do they give the joint torque that is asked for, for ever and for a moment?"""

from __future__ import annotations

from delta_cad.checks.report import CheckResult
from delta_cad.drive import DriveReport


def check_drive(drive: DriveReport) -> list[CheckResult]:
    """Holds both torques of a drive against the joint torques that are required, N m.

    The second check is there only where a peak is required.
    """
    detail = (
        f"{drive.motor}, {drive.drive} {drive.ratio:g}:1: {drive.continuous_torque_N_m:.3f} N m for ever, "
        f"{drive.peak_torque_N_m:.3f} N m for {drive.peak_time_s:g} s"
    )
    if drive.cable is not None:
        detail += (
            f"; cable {drive.cable_pretension_N:.1f} N, safety {drive.cable_safety_factor:.1f} at "
            f"{drive.controlled_torque_N_m:.3f} N m, bend ratio {drive.bend_ratio:.1f} "
            f"(makers advise {drive.bend_ratio_recommended:g} for long life)"
        )

    def held(name: str, value: float, limit: float) -> CheckResult:
        return CheckResult(name, value >= limit, value, limit, "N m", detail=detail)

    checks = [held("drive torque", drive.continuous_torque_N_m, drive.required_torque_N_m)]
    if drive.required_peak_N_m > drive.required_torque_N_m:
        checks.append(held("drive peak torque", drive.peak_torque_N_m, drive.required_peak_N_m))
    return checks
