"""Ranges of the mechanism against their limits."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from delta_cad.checks.range.ranges import check_ranges
from delta_cad.checks.report import CheckResult, all_passed
from delta_cad.mechanism import DeltaGeometry, direct_margin, inverse_kinematics
from delta_cad.mechanism.limits import EffectiveMass, HandleInertia
from delta_cad.mechanism.limits.effective_mass import effective_mass
from tests.delta_cad.checks.machines import GEOMETRY, LIMITS
from tests.delta_cad.mechanism.asked import limits as asked

ASKED = {
    "force": 3.0,
    "torque_max": 0.8,
    "lean_max": np.radians(28.0),
    "shoulder": (np.radians(-45.0), np.radians(80.0)),
    "kappa_max": 2.3,
}
MASSES = HandleInertia(0.1, 0.02, 0.005, 500e-6)
GIVEN = replace(LIMITS, pose=asked(**ASKED).with_(EffectiveMass(0.6, MASSES)))


def by_name(limits) -> dict[str, CheckResult]:
    return {r.name: r for r in check_ranges(GEOMETRY, limits)}


def test_the_design_keeps_its_ranges() -> None:
    found = by_name(GIVEN)
    assert list(found) == [
        *("reach", "assembly mode", "torque", "kappa", "lean", "shoulder min", "shoulder max", "effective mass"),
    ]
    assert all_passed(found.values())
    # figures of the feasibility study: -39.2..65.5 deg, lean 27.2 deg, 0.316 N m, kappa 2.268
    angles = [found["shoulder min"].value, found["shoulder max"].value]
    assert angles == pytest.approx([-39.2, 65.5], abs=0.1)
    assert found["lean"].value == pytest.approx(27.2, abs=0.05)
    assert found["torque"].value == pytest.approx(0.316, abs=0.001)
    assert found["kappa"].value == pytest.approx(2.268, abs=0.001)
    assert [found[name].unit for name in ("reach", "lean", "torque", "effective mass")] == ["mm", "deg", "N m", "kg"]


def test_the_effective_mass_is_that_of_its_worst_position() -> None:
    found = by_name(GIVEN)["effective mass"]
    at = effective_mass(GEOMETRY, GIVEN.poses_mm() / 1000.0, MASSES).max()
    assert at < found.value < at * (1.0 + 3e-3)  # between two positions of a grid of 11 along an edge
    assert effective_mass(GEOMETRY, np.array(found.worst_pose_mm) / 1000.0, MASSES) == pytest.approx(found.value)


def test_only_what_is_given_is_checked() -> None:
    assert set(by_name(LIMITS)) == {"reach"}


@pytest.mark.parametrize(
    ("name", "changes"),
    [
        ("lean", {"lean_max": np.radians(27.0)}),
        ("shoulder min", {"shoulder": (np.radians(-39.0), 1.4)}),
        ("shoulder max", {"shoulder": (-0.8, np.radians(65.0))}),
        ("torque", {"torque_max": 0.315}),
        ("kappa", {"kappa_max": 2.26}),
    ],
)
def test_what_exceeds_its_limit_is_refused(name: str, changes: dict[str, Any]) -> None:
    failed = [r for r in by_name(replace(GIVEN, pose=asked(**ASKED | changes))).values() if not r.passed]
    assert [r.name for r in failed] == [name]
    pose = np.array(failed[0].worst_pose_mm)
    assert (np.abs(pose - LIMITS.centre_mm) <= LIMITS.half_side_mm + 1e-9).all()
    assert np.isfinite(inverse_kinematics(GEOMETRY, pose / 1000.0)).all()


def test_a_platform_below_the_elbows_is_a_singular_machine() -> None:
    # the mirror image below the base plane's elbows: det S has the other sign there
    below = DeltaGeometry(0.082, 0.030, 0.060, 0.0605)
    limits = replace(LIMITS, bottom_height_mm=20.0, half_side_mm=1.0, pose=asked())
    found = {r.name: r for r in check_ranges(below, limits)}
    assert found["reach"].passed
    assert found["assembly mode"].passed == (direct_margin(below, limits.poses_mm() / 1000.0).min() > 0.0)


def test_an_unreachable_cube_ends_the_ranges() -> None:
    found = by_name(replace(GIVEN, half_side_mm=80.0))
    assert set(found) == {"reach"}
    assert not found["reach"].passed
    assert found["reach"].value < 0.0  # how far it is out of reach
