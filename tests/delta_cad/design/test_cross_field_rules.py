"""Lengths that cannot go together: which field is blamed, and that the bound named is the bound."""

from __future__ import annotations

import math
import re
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given
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


LENGTHS = (
    *(st.floats(20, 60), st.floats(20, 60), st.floats(50, 120), st.floats(50, 200)),
    *(st.floats(10, 150), st.floats(5, 60)),
)


def over_the_axes(g: DeltaGeometry, low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(n, 3) where each chain's plane enters and leaves the bottom face, and where it is over the shoulder axis, m.

    With the chain of each: of the others the rules say nothing there, they are necessary alone.
    """
    found, chains = [], []
    for i, (a, direction) in enumerate(zip(g.radius_differences, g.radial, strict=True)):
        lines = [bound / direction[k] for k in range(2) if direction[k] != 0.0 for bound in (low[k], high[k])]
        for u in (a, *lines):
            p = np.array([*(u * direction)[:2], low[2]])
            if (p >= low - 1e-12).all() and (p <= high + 1e-12).all():
                found.append(np.clip(p, low, high))
                chains.append(i)
    return np.array(found).reshape(-1, 3), np.array(chains, dtype=int)


@UNTIMED
@example(20.0, 20.0, 50.0, 72.0, 10.0, 9.0, (60.0, 33.0, 50.0))  # chain 1 does not reach where chain 0's plane enters
@given(*LENGTHS, st.none() | st.tuples(st.floats(60, 150), st.floats(20, 60), st.floats(-60, 60)))
def test_a_refused_cube_has_a_point_the_mechanism_cannot_reach(
    base: float,
    platform: float,
    arm: float,
    forearm: float,
    bottom: float,
    side: float,
    placed: tuple[float, float, float] | None,
) -> None:
    """Oracle: the inverse kinematics of the mechanism, which knows eq. (7) in another form."""
    data = minimal()
    data["mechanism"] |= {
        "base_radius_mm": base,
        "platform_radius_mm": platform,
        "upper_arm_length_mm": arm,
        "forearm_length_mm": forearm,
        "parallelogram_width_mm": 5.0,
    }
    data["cube"] = {"bottom_height_mm": bottom, "half_side_mm": side}
    data["hardware"] = {"ball_diameter_mm": 4.0}
    if placed is not None:
        azimuth, others, centre = placed
        data["mechanism"] |= {"azimuths_deg": [0.0, azimuth, -azimuth], "base_radii_mm": [base, others, others]}
        data["cube"]["centre_x_mm"] = centre
    azimuth, others, centre = placed or (120.0, base, 0.0)
    cosine = -0.5 if azimuth == 120.0 else math.cos(math.radians(azimuth))
    g = DeltaGeometry(base / 1e3, platform / 1e3, arm / 1e3, forearm / 1e3, (others - base) / 1e3, cosine)
    low, high = np.array([centre - side, -side, bottom]), np.array([centre + side, side, bottom + 2 * side])
    corners = np.stack(np.meshgrid(*np.array([low, high]).T), axis=-1).reshape(-1, 3) / 1e3
    over, chains = over_the_axes(g, low / 1e3, high / 1e3)
    try:
        design = design_from_dict(data)
    except DesignError:
        with pytest.raises(UnreachableError):
            inverse_kinematics(g, np.vstack([corners, over]))
    else:
        # the bounds carry a slack of 1e-12 relative, so margins (m^2) may be below zero by that much
        assert closure_margin(g, corners).min() >= -1e-12
        assert (closure_margin(g, over)[np.arange(len(over)), chains] >= -1e-12).all()
        assert contradictions(design) == []


def placed(**changes: Any) -> dict[str, Any]:
    """A design of the study, with other values of `mechanism` and `cube`."""
    data = minimal()
    data["mechanism"] = {
        "platform_radius_mm": 22.55,
        "upper_arm_length_mm": 94.4,
        "forearm_length_mm": 148.4,
        "parallelogram_width_mm": 50.0,
        "azimuths_deg": [0.0, 116.3, -116.3],
        "base_radii_mm": [31.19, 38.45, 38.45],
    }
    data["cube"] = {"bottom_height_mm": 75.8, "half_side_mm": 43.9, "centre_x_mm": 11.1}
    data["hardware"] = {"ball_diameter_mm": 6.0}
    for name, value in changes.items():
        data["cube" if name in data["cube"] else "mechanism"][name] = value
    return data


def test_the_fold_is_that_of_the_chain_whose_axis_the_cube_comes_nearest_to() -> None:
    """Where the axes are under the cube they fold alike; where they are beside it, that nearest to it counts."""
    bound = 148.4 - 94.4
    design_from_dict(placed(bottom_height_mm=bound + 1e-9))
    with pytest.raises(DesignError, match=r">= 54 mm") as caught:
        design_from_dict(placed(bottom_height_mm=bound - 1e-9))
    assert caught.value.field == "cube.bottom_height_mm"
    aside = {"half_side_mm": 10.0, "centre_x_mm": -20.0, "bottom_height_mm": 50.0}
    bound = math.sqrt(54.0**2 - 18.64**2)  # from x = -10 to chain 0's axis at 8.64; the planes of the others miss it
    with pytest.raises(DesignError, match=rf">= {bound:.6g} mm"):
        design_from_dict(placed(**aside))
    aside = {"half_side_mm": 4.0, "centre_x_mm": 0.0, "bottom_height_mm": 50.0}
    u = 4.0 / math.sin(math.radians(116.3))  # chain 1 leaves the face at y = 4, its axis is at 7.45; chain 0's at 57.45
    bound = math.sqrt(54.0**2 - (7.45 - u) ** 2)
    with pytest.raises(DesignError, match=rf">= {bound:.6g} mm"):
        design_from_dict(placed(**aside, base_radii_mm=[80.0, 30.0, 30.0]))


def test_the_corner_is_that_of_the_cube_where_it_stands() -> None:
    """Chain 0 is the farthest from the bottom face's corners at x = 11.1 - 43.9 and y = +-43.9."""
    away = np.array([11.1 - 43.9 - (31.19 - 22.55), 75.8 + 2 * 43.9])
    bound = math.hypot(43.9, math.hypot(*away) - 94.4)
    turn = np.exp(1j * math.radians(116.3))
    for x, y in ((11.1 - 43.9, 43.9), (11.1 + 43.9, -43.9), (11.1 + 43.9, 43.9)):
        seen = complex(x, y) / turn
        rho = math.hypot(seen.real - (38.45 - 22.55), 75.8 + 2 * 43.9)
        bound = max(bound, math.hypot(seen.imag, rho - 94.4))
    design_from_dict(placed(forearm_length_mm=bound + 1e-6))
    with pytest.raises(DesignError, match=rf">= {bound:.6g} mm for chain [12]") as caught:
        design_from_dict(placed(forearm_length_mm=bound - 1e-6))
    assert caught.value.field == "mechanism.forearm_length_mm"


@pytest.mark.parametrize("off", [100.0, 200.0, -100.0])
def test_a_cube_too_far_off_the_axis_may_move_back_as_far_as_its_corners_are_reached(off: float) -> None:
    """Oracle: the inverse kinematics at the eight corners."""
    with pytest.raises(DesignError) as caught:
        design_from_dict(placed(centre_x_mm=off))
    assert caught.value.field == "mechanism.forearm_length_mm"
    sense = "at most" if off > 0.0 else "at least"
    found = re.search(rf"; or cube\.centre_x_mm = {off:g} must be {sense} (\S+) mm$", caught.value.allowed)
    assert found is not None, caught.value.allowed
    bound = float(found[1])
    design = design_from_dict(placed(centre_x_mm=bound))

    def margin(x_mm: float) -> float:
        corners = np.array(np.meshgrid([x_mm - 43.9, x_mm + 43.9], [-43.9, 43.9], [75.8, 75.8 + 87.8]))
        return float(closure_margin(design.geometry, corners.reshape(3, -1).T / 1e3).min())

    assert margin(bound) >= 0.0 > margin(bound + math.copysign(2e-3, off))


def test_a_cube_out_of_reach_on_the_axis_too_is_no_matter_of_its_place() -> None:
    for change in ({"centre_x_mm": 60.0, "forearm_length_mm": 80.0}, {"centre_x_mm": 0.0, "forearm_length_mm": 80.0}):
        with pytest.raises(DesignError, match=r"forearm_length_mm = 80\.0: must be >= .* mm$") as caught:
            design_from_dict(placed(**change))
        assert "centre_x_mm" not in caught.value.allowed


def test_the_least_of_the_base_radii_is_what_a_platform_must_not_exceed() -> None:
    with pytest.raises(DesignError, match=r"< 112\.4 mm, the least of base_radii_mm \+ upper_arm") as caught:
        design_from_dict(placed(base_radii_mm=[31.19, 18.0, 18.0], platform_radius_mm=113.0))
    assert caught.value.field == "mechanism.platform_radius_mm"


def test_balls_meet_first_between_the_chains_that_stand_nearest() -> None:
    """At 140 degrees those of chains 1 and 2, 80 degrees apart: 2 (r sin 40 - L_c / 2 cos 40) = 6 mm."""
    bound = (2.0 * 22.55 * math.sin(math.radians(40.0)) - 6.0) / math.cos(math.radians(40.0))
    fine = {"azimuths_deg": [0.0, 140.0, -140.0], "bottom_height_mm": 75.8, "half_side_mm": 20.0}
    design_from_dict(placed(**fine, parallelogram_width_mm=bound - 1e-6))
    with pytest.raises(DesignError, match=rf"<= {bound:.6g} mm") as caught:
        design_from_dict(placed(**fine, parallelogram_width_mm=bound + 1e-6))
    assert caught.value.field == "mechanism.parallelogram_width_mm"


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
