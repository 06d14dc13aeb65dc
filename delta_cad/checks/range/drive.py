"""Motor and capstan: continuous and peak torque at the joint, and the bend radius of the cable on the pinion."""

from __future__ import annotations

from delta_cad.checks.report import CheckResult
from delta_cad.drive import DriveReport


def check_drive(drive: DriveReport) -> list[CheckResult]:
    """Holds both torques of a drive against the joint torques that are required, N m.

    The second check is there only where a peak is required.
    """
    detail = (
        f"{drive.motor}, {drive.drive} {drive.ratio:g}:1: {drive.continuous_torque_N_m:.3f} N m continuous, "
        f"{drive.peak_torque_N_m:.3f} N m for {drive.peak_time_s:g} s"
    )
    if drive.cable is not None:
        detail += (
            f"; cable for {drive.controlled_torque_N_m:.3f} N m, bend ratio {drive.bend_ratio:.1f} "
            f"(makers advise {drive.bend_ratio_recommended:g} for long life)"
        )

    def held(name: str, value: float, limit: float) -> CheckResult:
        return CheckResult(name, value >= limit, value, limit, "N m", detail=detail)

    checks = [held("drive torque", drive.continuous_torque_N_m, drive.required_torque_N_m)]
    if drive.required_peak_N_m > drive.required_torque_N_m:
        checks.append(held("drive peak torque", drive.peak_torque_N_m, drive.required_peak_N_m))
    return checks


def check_bend(drive: DriveReport) -> list[CheckResult]:
    """Holds the diameter of the pinion's groove over the cable's against the one below which the cable's life is short.

    On the sector's nose, which bends it more, the cable lies still.

    Returns:
        `cable bend ratio`; nothing for a direct drive.
    """
    ratio, least, life = drive.bend_ratio, drive.bend_ratio_least, drive.bend_life_share
    if ratio is None or least is None or life is None:
        return []
    reported = (
        f"makers advise {drive.bend_ratio_recommended:g}; estimate: {100.0 * life:.0f} % of the bending life there "
        "(Sava: twice the diameter, up to 13 times the life), and below the limit it is short; it grows with "
        "hardware.sector_radius_mm, and with a smaller hardware.capstan_ratio or a thinner hardware.cable"
    )
    return [CheckResult("cable bend ratio", ratio >= least, ratio, least, "", detail=reported)]
