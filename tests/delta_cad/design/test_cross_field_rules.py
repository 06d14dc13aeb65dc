"""Lengths that cannot go together: which field is blamed, and that the bound named is the bound."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from delta_cad.design import DesignError, design_from_dict
from delta_cad.design.cross_field_rules import contradictions
from delta_cad.mechanism import DeltaGeometry, UnreachableError, closure_margin, inverse_kinematics
from tests.designs import UNTIMED, changed, minimal


def test_a_cube_under_the_fold_is_refused_with_the_height_of_the_fold() -> None:
    bound = 112.079 - 82.0  # a = R - r = 10 lies inside the cube's half side: the fold is straight above it
    design_from_dict(changed("cube.bottom_height_mm", bound + 1e-9))
    with pytest.raises(DesignError, match=r">= 30\.079 mm") as caught:
        design_from_dict(changed("cube.bottom_height_mm", bound - 1e-9))
    assert caught.value.field == "cube.bottom_height_mm"


@UNTIMED
@given(
    st.floats(20, 60), st.floats(20, 60), st.floats(50, 120), st.floats(50, 200), st.floats(10, 150), st.floats(5, 60)
)
def test_a_refused_cube_has_a_point_the_mechanism_cannot_reach(
    base: float, platform: float, arm: float, forearm: float, bottom: float, side: float
) -> None:
    """Oracle: the inverse kinematics of the mechanism, which knows eq. (7) in another form."""
    data = minimal()
    data["mechanism"] |= {
        "base_radius_mm": base,
        "platform_radius_mm": platform,
        "upper_arm_length_mm": arm,
        "forearm_length_mm": forearm,
        "parallelogram_width_mm": 10.0,
    }
    data["cube"] = {"bottom_height_mm": bottom, "half_side_mm": side}
    g = DeltaGeometry(base / 1e3, platform / 1e3, arm / 1e3, forearm / 1e3)
    corners = np.array([(x, y, z) for x in (-side, side) for y in (-side, side) for z in (bottom, bottom + 2 * side)])
    nearest = np.array([np.clip(base - platform, -side, side), 0.0, bottom])
    points = np.vstack([corners, nearest]) / 1e3
    try:
        design = design_from_dict(data)
    except DesignError:
        with pytest.raises(UnreachableError):
            inverse_kinematics(g, points)
    else:
        # the bounds carry a slack of 1e-12 relative, so margins (m^2) may be below zero by that much
        assert closure_margin(g, points).min() >= -1e-12
        assert contradictions(design) == []


def test_a_forearm_too_long_for_a_corner_is_refused() -> None:
    """With R - r outside the cube a corner is nearer to shoulder 1 than any point is to shoulder 0."""
    data = minimal()
    data["mechanism"] |= {"base_radius_mm": 100.0, "platform_radius_mm": 20.0, "forearm_length_mm": 153.0}
    data["mechanism"]["parallelogram_width_mm"] = 20.0
    data["cube"] = {"bottom_height_mm": 20.0, "half_side_mm": 10.0}
    u, v = (
        10.0 * (math.cos(math.pi / 3) + math.sin(math.pi / 3)),
        10.0 * (math.sin(math.pi / 3) - math.cos(math.pi / 3)),
    )
    bound = math.hypot(v, math.hypot(u - 80.0, 20.0) + 82.0)  # 151.33 mm
    with pytest.raises(DesignError, match=rf"<= {bound:.6g} mm") as caught:
        design_from_dict(data)
    assert caught.value.field == "mechanism.forearm_length_mm"
    data["mechanism"]["forearm_length_mm"] = bound - 1e-6
    design_from_dict(data)


def test_the_balls_meet_where_the_bound_says() -> None:
    """Oracle: the wrist centres themselves, placed by rotation."""
    bound = 87.923048  # 2 sqrt(3) 30 - 2 x 8
    r, half = 30.0, bound / 2.0
    turn = np.exp(2j * np.pi / 3.0)
    distance = abs((r + 1j * half) - turn * (r - 1j * half))
    assert distance == pytest.approx(8.0, abs=1e-6)  # the bound is written to 1e-6 mm
    design_from_dict(changed("mechanism.parallelogram_width_mm", bound - 1e-6))


def test_a_pinion_bound_does_not_concern_a_direct_drive() -> None:
    hardware = {"drive": "direct", "motor": "maxon-ec60flat-625858", "capstan_ratio": 30.0}
    assert design_from_dict(minimal() | {"hardware": hardware}).hardware.drive == "direct"


def test_the_shoulder_range_must_not_be_empty() -> None:
    data = minimal()
    data["requirements"] |= {"shoulder_min_deg": 10.0, "shoulder_max_deg": 10.0}
    with pytest.raises(DesignError, match="> shoulder_min_deg = 10 deg") as caught:
        design_from_dict(data)
    assert caught.value.field == "requirements.shoulder_max_deg"


@pytest.mark.parametrize(("peak", "lasting"), [("peak_force_N", "force_N"), ("peak_torque_N_m", "joint_torque_N_m")])
def test_a_peak_is_no_less_than_what_holds_for_ever(peak: str, lasting: str) -> None:
    least = minimal()["requirements"][lasting]
    assert getattr(design_from_dict(changed(f"requirements.{peak}", least)).requirements, peak) == least
    with pytest.raises(DesignError, match=f">= {lasting} = {least:g}") as caught:
        design_from_dict(changed(f"requirements.{peak}", math.nextafter(least, 0.0)))
    assert caught.value.field == f"requirements.{peak}"
