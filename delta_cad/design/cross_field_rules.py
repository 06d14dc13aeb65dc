"""Closed-form conditions between the numbers of a design that no build can mend, each naming a field and its bound.

Those that the variables of a synthesis can break are limits of `delta_cad.mechanism.limits`, which a search asks by the
same margin. They are necessary, not sufficient: reach over the whole cube is proven elsewhere. For chain i, with
a = R_i - r and u and v the radial and tangential coordinates of the platform, its wrist lies at v out of the plane in
which the upper arm turns and at rho = |(u - a, z)| from the shoulder axis in it. The forearm closes the chain if and
only if `v^2 + (rho - L_A)^2 <= L_B^2 <= v^2 + (rho + L_A)^2`, which is eq. (7) of [RCIM2018] factored.
"""

from __future__ import annotations

from itertools import product
from math import ceil, copysign, hypot, inf, sqrt
from typing import NamedTuple

import numpy as np

from delta_cad import catalogue
from delta_cad.design.record import Design, Hardware
from delta_cad.mechanism.limits import BallClearance, ElbowOutside, Limit

_SLACK = 1e-12
"""Share within which a reach is met: what lies exactly at it carries a few roundings of 1e-16."""
_STEP_MM = 1e-3  # to which a cube's place is stated
_MET = -1e-9
"""Margin of a limit at which it is met, as a search ends with it: `optimizer.search.active_set.ROUNDING`."""


class _Contradiction(NamedTuple):
    """A number that cannot go with the others: its dotted path, its value, the bound in words and as a number."""

    field: str
    value: float
    allowed: str
    bound: float


def contradictions(design: Design, kinematics: bool = False) -> list[_Contradiction]:
    """Gives every condition that a design with each field within its own bounds breaks, none for a sound one.

    Args:
        design: The design.
        kinematics: Whether to leave out what needs its hardware.
    """
    conditions = (_shoulder_range, _peaks, _platform_size, _fold, _farthest_corner)
    found = [condition(design) for condition in conditions]
    if not kinematics:
        found += [_clashing_wrists(design), pinion_contradiction(design.hardware), _panel(design)]
    return [fault for fault in found if fault is not None]


def _shoulder_range(design: Design) -> _Contradiction | None:
    low, high = design.requirements.shoulder_min_deg, design.requirements.shoulder_max_deg
    if low is None or high is None or low < high:
        return None
    return _Contradiction("requirements.shoulder_max_deg", high, f"must be > shoulder_min_deg = {low:g} deg", low)


def _peaks(design: Design) -> _Contradiction | None:
    r = design.requirements
    for field, peak, least, unit in (
        ("peak_force_N", r.peak_force_N, r.force_N, "force_N = {:g} N"),
        ("peak_torque_N_m", r.peak_torque_N_m, r.joint_torque_N_m, "joint_torque_N_m = {:g} N m"),
    ):
        if peak is not None and peak < least:
            words = f"must be >= {unit.format(least)}, the continuous one"
            return _Contradiction(f"requirements.{field}", peak, words, least)
    return None


def _platform_size(design: Design) -> _Contradiction | None:
    if _margin(design, ElbowOutside()) >= _MET:
        return None
    m = design.mechanism
    bound = min(_base_radii(design)) + m.upper_arm_length_mm
    radius = "base_radius_mm" if m.base_radii_mm is None else "the least of base_radii_mm"
    return _Contradiction(
        "mechanism.platform_radius_mm",
        m.platform_radius_mm,
        f"must be < {bound:g} mm, {radius} + upper_arm_length_mm, or no elbow can stand outside its wrist",
        bound,
    )


def _base_radii(design: Design) -> tuple[float, float, float]:
    """R of each chain, mm."""
    m = design.mechanism
    return m.base_radii_mm or (m.base_radius_mm, m.base_radius_mm, m.base_radius_mm)


def _margin(design: Design, limit: Limit) -> float:
    """The margin of a limit that a closed form of the lengths decides, without unit."""
    m, cube, (first, side, _) = design.mechanism, design.cube, _base_radii(design)
    lengths = m.upper_arm_length_mm, m.forearm_length_mm, m.base_radius_mm, m.platform_radius_mm
    placement = side - first, design.geometry.side_cosine, cube.centre_x_mm or 0.0
    found = limit.design_margin(np.array([[*lengths, cube.bottom_height_mm, cube.half_side_mm, *placement]]).T)
    assert found is not None
    return float(found[0])


def _fold(design: Design) -> _Contradiction | None:
    """The lowest reachable height over the points of the bottom face nearest to the shoulder axes (v = 0)."""
    m, cube = design.mechanism, design.cube
    side, middle = cube.half_side_mm, cube.centre_x_mm or 0.0
    stretch, bound = abs(m.forearm_length_mm - m.upper_arm_length_mm), 0.0
    for (c, s, _), radius in zip(design.geometry.radial, _base_radii(design), strict=True):
        a, low, high = radius - m.platform_radius_mm, -inf, inf
        for along, least, most in ((c, middle - side, middle + side), (s, -side, side)):
            if along != 0.0:
                low, high = max(low, min(least / along, most / along)), min(high, max(least / along, most / along))
            elif not least <= 0.0 <= most:
                high = -inf
        if low <= high:  # else the chain's plane does not meet the face
            bound = max(bound, sqrt(max(0.0, stretch**2 - (min(max(a, low), high) - a) ** 2)))
    if cube.bottom_height_mm >= bound - _SLACK * (m.upper_arm_length_mm + m.forearm_length_mm):
        return None
    return _Contradiction(
        "cube.bottom_height_mm",
        cube.bottom_height_mm,
        f"must be >= {bound:.6g} mm, where upper arm and forearm fold in line "
        f"(|forearm_length_mm - upper_arm_length_mm| = {stretch:.6g} mm)",
        bound,
    )


def _farthest_corner(design: Design) -> _Contradiction | None:
    m, middle = design.mechanism, design.cube.centre_x_mm or 0.0
    if (beyond := _corner_beyond(design, middle)) is None:
        return None
    sign, bound, chain, corner = beyond
    place = ", ".join(f"{value:g}" for value in corner)
    return _Contradiction(
        "mechanism.forearm_length_mm",
        m.forearm_length_mm,
        f"must be {sign} {bound:.6g} mm for chain {chain} to reach the cube's corner ({place}) mm"
        f"{_nearer_the_axis(design, middle)}",
        bound,
    )


def _corner_beyond(design: Design, middle_mm: float) -> tuple[str, float, int, tuple[float, float, float]] | None:
    """What a forearm must be for the corner it reaches least, were the cube's middle at an x: sign, bound, chain."""
    m, cube, g, radii = design.mechanism, design.cube, design.geometry, _base_radii(design)
    arm, side, bottom = m.upper_arm_length_mm, cube.half_side_mm, cube.bottom_height_mm
    low, high = (0.0, 0, (0.0, 0.0, 0.0)), (inf, 0, (0.0, 0.0, 0.0))
    xs = middle_mm - side, middle_mm + side
    for i, x, y, z in product(range(3), xs, (-side, side), (bottom, bottom + 2.0 * side)):
        c, s, _ = g.radial[i].tolist()
        u, v = x * c + y * s, y * c - x * s
        rho = hypot(u - (radii[i] - m.platform_radius_mm), z)
        low = max(low, (hypot(v, rho - arm), i, (x, y, z)))
        high = min(high, (hypot(v, rho + arm), i, (x, y, z)))
    slack = _SLACK * (arm + m.forearm_length_mm)
    if m.forearm_length_mm < low[0] - slack:
        return ">=", *low
    if m.forearm_length_mm > high[0] + slack:
        return "<=", *high
    return None


def _nearer_the_axis(design: Design, middle_mm: float) -> str:
    """The other change that lets every corner be reached: how far off the axis the cube may stand, if it may at all."""
    sign = copysign(_STEP_MM, middle_mm)
    near, far = 0, ceil(abs(middle_mm) / _STEP_MM)
    if far == near or _corner_beyond(design, 0.0) is not None:
        return ""
    while far - near > 1:
        middle = (near + far) // 2
        near, far = (near, middle) if _corner_beyond(design, sign * middle) else (middle, far)
    sense = "at most" if middle_mm > 0.0 else "at least"
    return f"; or cube.centre_x_mm = {middle_mm:g} must be {sense} {sign * near:.6g} mm"


def _clashing_wrists(design: Design) -> _Contradiction | None:
    """The balls of neighbouring chains must fit between their centres at the platform."""
    m = design.mechanism
    limit = BallClearance(0.0, design.hardware.ball_diameter_mm, m.parallelogram_width_mm)
    if _margin(design, limit) >= _MET:
        return None
    bound = limit.width_max_mm(m.platform_radius_mm, design.geometry.side_cosine)
    return _Contradiction(
        "mechanism.parallelogram_width_mm",
        m.parallelogram_width_mm,
        f"must be <= {bound:.6g} mm, or the balls of neighbouring chains meet at the platform",
        bound,
    )


def pinion_contradiction(h: Hardware) -> _Contradiction | None:
    """Finds a capstan whose pinion has no metal left between its cable's groove and the motor's shaft.

    Args:
        h: The hardware of a design.
    """
    if h.drive != "capstan":
        return None
    shaft = catalogue.motor.chosen(h).shaft_diameter_mm
    bound = 2.0 * h.sector_radius_mm / (shaft + catalogue.cable.chosen(h).diameter_mm)
    if h.capstan_ratio < bound:
        return None
    return _Contradiction(
        "hardware.capstan_ratio",
        h.capstan_ratio,
        f"must be < {bound:.6g}, or the pinion's groove (sector_radius_mm = {h.sector_radius_mm:g}) cuts into the "
        f"motor's {shaft:g} mm shaft",
        bound,
    )


def _panel(design: Design) -> _Contradiction | None:
    """In the cube the stem keeps the clearance from the bezel, and no handle goes below the shoulders' plane."""
    panel, least = design.panel, design.requirements.clearance_min_mm
    if panel is None:
        return None
    if panel.limit_mm <= least:
        words = f"must be > clearance_min_mm = {least:g} mm, which the stem keeps from the bezel in the cube"
        return _Contradiction("panel.limit_mm", panel.limit_mm, words, least)
    if panel.limit_mm < design.cube.bottom_height_mm:
        return None
    words = f"must be < bottom_height_mm = {design.cube.bottom_height_mm:g} mm"
    return _Contradiction("panel.limit_mm", panel.limit_mm, words, design.cube.bottom_height_mm)
