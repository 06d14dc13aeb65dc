"""The capstan's cable: its strands keep to the groove's helix over the stroke, its bend to its limit."""

from __future__ import annotations

from math import degrees

import numpy as np

from delta_cad.checks.report import CheckResult
from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.cable_run import FLEET_LIMIT_RAD
from delta_cad.drive import DriveReport, drive_torque

ANGLES = 201  # of the arm between its stops


def check_cable(d: Dimensions) -> list[CheckResult]:
    """Holds the fleet angle and the bend against what a cable bears, and both take-offs against the ends of the groove.

    Returns:
        `cable fleet angle`, the largest of both strands against the plane across the axes over the stroke, deg;
        `cable on its groove`, the least length of groove beyond a take-off, mm; `cable bend ratio`, the diameter of the
        groove over the cable's. None for a direct drive.
    """
    c = d.capstan
    if c is None:
        return []
    run, middle = c.run, c.middle_y_mm
    # the strand that grows longer with the run's angle leaves the end at the larger polar angle
    lugs = c.end_y_mm[0] - middle, c.end_y_mm[1] - middle
    turned = np.linspace(-0.5, 0.5, ANGLES) * (d.stops_rad[1] - d.stops_rad[0])
    angles = np.array([run.fleet_rad(float(t), lugs) for t in turned]) + run.lead_rad
    ends = np.array([run.take_off_mm(float(t)) for t in turned])
    worst, spare = float(np.abs(angles).max()), run.grooved_mm / 2 - float(np.abs(ends).max())
    told = (
        f"lugs {lugs[0]:+.2f} and {lugs[1]:+.2f} mm off the middle, {run.walk_mm:.2f} mm of walk along the pinion, "
        f"{run.wrap_rad / (2 * np.pi):.2f} turns, cable {c.cable_length_mm:.0f} mm"
    )
    limit = degrees(FLEET_LIMIT_RAD)
    return [
        CheckResult("cable fleet angle", worst <= FLEET_LIMIT_RAD, degrees(worst), limit, "deg", detail=told),
        CheckResult("cable on its groove", spare >= 0.0, spare, 0.0, "mm", detail=told),
        *_check_bend(drive_torque(d.design)),
    ]


def _check_bend(drive: DriveReport) -> list[CheckResult]:
    """Holds the pinion's diameter against the cable's; on the nose, which bends it more, it lies still."""
    ratio, least, life = drive.bend_ratio, drive.bend_ratio_least, drive.bend_life_share
    if ratio is None or least is None or life is None:
        return []
    told = (
        f"makers advise {drive.bend_ratio_recommended:g}; estimate: {100.0 * life:.0f} % of the bending life there "
        "(Sava: twice the diameter, up to 13 times the life), and below the limit it is short; it grows with "
        "hardware.sector_radius_mm, and with a smaller hardware.capstan_ratio or a thinner hardware.cable"
    )
    return [CheckResult("cable bend ratio", ratio >= least, ratio, least, "", detail=told)]
