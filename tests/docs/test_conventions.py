"""`how-to/conventions.md`: deltas as others state them, turned into our lengths and frame, where its cases come out.

The page has the rules, and the sources of the numbers.
"""

from __future__ import annotations

import re
from math import hypot, sqrt

import numpy as np
import pytest

from delta_cad.commands.kinematic import CollaredDelta
from delta_cad.mechanism import Cube, DeltaGeometry, forward_kinematics, inverse_kinematics
from delta_cad.mechanism.chains import chain_positions, equal_chains, unequal
from delta_cad.mechanism.workspace import cube_surface
from tests.committed import ROOT

# Base and platform are stated by the sides of their triangles. The shoulders are on the middles of the base's sides, at
# the radius of the inscribed circle, the wrists of the FlexPicker's notes on the platform's corners.
FLEXPICKER = DeltaGeometry(0.567 * sqrt(3.0) / 6.0, 0.076 * sqrt(3.0) / 3.0, 0.524, 1.244)
FIREPICK = DeltaGeometry(0.4573 / (2.0 * sqrt(3.0)), 0.115 / (2.0 * sqrt(3.0)), 0.112, 0.232)
FLEXPICKER_POSES = [
    ((0.0, 0.0, 0.0), (0.0, 0.0, -1064.4517)),
    ((10.0, 20.0, 30.0), (108.1354, -180.3484, -1243.5413)),
    ((-20.5, -20.5, -20.5), (0.0, 0.0, -900.3195)),
    ((47.5, -11.6, 21.4), (300.4598, 499.9385, -1099.8281)),
    ((0.0, 0.0, 60.0), (619.5159, -357.6777, -1040.1298)),
]


def from_z_down(p_mm: tuple[float, float, float]) -> np.ndarray:
    """Turns a position with z down and the first arm along -y into our frame, m."""
    x, y, z = p_mm
    return np.array([-y, x, -z]) / 1e3


@pytest.mark.parametrize(("angles_deg", "p_mm"), FLEXPICKER_POSES)
def test_the_flexpicker_with_z_down_comes_out_both_ways(
    angles_deg: tuple[float, float, float], p_mm: tuple[float, float, float]
) -> None:
    p, half_a_digit = from_z_down(p_mm), 0.6e-7  # m, of four decimals of a mm
    np.testing.assert_allclose(forward_kinematics(FLEXPICKER, np.radians(angles_deg)), p, rtol=0.0, atol=half_a_digit)
    # an arm of 524 mm turns by 1e-5 degrees as its end moves by 1e-7 m
    np.testing.assert_allclose(np.degrees(inverse_kinematics(FLEXPICKER, p)), angles_deg, rtol=0.0, atol=5e-5)


def test_the_flexpicker_s_inverse_as_published() -> None:
    found = np.degrees(inverse_kinematics(FLEXPICKER, from_z_down((500.0, 0.0, -1000.0))))
    np.testing.assert_allclose(found, (6.36, -23.26, 33.49), rtol=0.0, atol=0.006)


def test_the_firepick_with_level_arms() -> None:
    np.testing.assert_allclose(forward_kinematics(FIREPICK, np.zeros(3)) * 1e3, (0.0, 0.0, 96.859015), atol=5e-7)


def test_a_radius_where_the_side_was_meant_is_another_machine() -> None:
    wrong = DeltaGeometry(0.4573, 0.115, 0.112, 0.232)
    with pytest.raises(ValueError, match=r"222\.300 mm too short"):
        forward_kinematics(wrong, np.zeros(3))


@pytest.mark.parametrize("platform_mm", [5.0, 40.0, 90.0])
def test_only_the_difference_of_the_radii_counts(platform_mm: float) -> None:
    """Klipper's rotary delta states 33.9; by hand: three spheres of 320 about the ends of arms of 170."""
    g = DeltaGeometry((33.9 + platform_mm) / 1e3, platform_mm / 1e3, 0.170, 0.320)
    p = 1e3 * forward_kinematics(g, np.radians([10.0, 20.0, 30.0]))
    for azimuth, theta in zip(np.radians([0.0, 120.0, 240.0]), np.radians([10.0, 20.0, 30.0]), strict=True):
        out = 33.9 + 170.0 * np.cos(theta)
        elbow = np.array([out * np.cos(azimuth), out * np.sin(azimuth), 170.0 * np.sin(theta)])
        assert np.linalg.norm(p - elbow) == pytest.approx(320.0, abs=1e-9)
    assert p[2] > 0.0


def test_past_the_fold_two_angles_have_one_position() -> None:
    """Lengths of a pull request: the spheres meet at 110 degrees, where the machine's own arms stand at 76.14."""
    g = DeltaGeometry(0.063, 0.035, 0.130, 0.400)
    beyond = chain_positions(unequal(equal_chains(g)), np.radians([110.0] * 3))
    own = np.degrees(inverse_kinematics(g, beyond))
    np.testing.assert_allclose(own, [76.1429] * 3, atol=5e-5)
    np.testing.assert_allclose(forward_kinematics(g, np.radians(own)), beyond, atol=1e-12)


def test_collars_are_no_longer_forearm() -> None:
    """The Falcon's chain, b = 102.5 between two collars of 11.25, against a forearm of 125, 30 mm out of the plane."""
    aside, b, collars = 30.0, 102.5, 22.5
    true = collars + sqrt(b**2 - aside**2)
    assert hypot(true, aside) != pytest.approx(b + collars, abs=0.5)
    assert sqrt((b + collars) ** 2 - aside**2) - true == pytest.approx(0.84, abs=0.005)


def test_the_falcon_with_its_collars_is_as_the_page_says() -> None:
    """By differences of angles over the cube's corners and faces, which `test_kinematics` holds to the chains."""
    page = (ROOT / "docs" / "how-to" / "conventions.md").read_text(encoding="utf-8")
    (kappa,) = re.findall(
        r"with its collars .* kappa at most ([\d.]+) over a cube of 50 mm with its floor at 90 mm", page
    )
    delta = CollaredDelta(DeltaGeometry(0.03723, 0.014, 0.06, 0.1025), 0.0225)
    points, step = cube_surface(Cube(0.09, 0.025), 41), 1e-6
    slopes = [(delta.pose(points + w).theta - delta.pose(points - w).theta) / (2 * step) for w in step * np.eye(3)]
    values = np.linalg.svd(np.stack(slopes, axis=-1), compute_uv=False)
    assert (values[:, 0] / values[:, 2]).max() == pytest.approx(float(kappa), abs=0.005)
