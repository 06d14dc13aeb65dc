"""Ranges of the mechanism against their limits."""

from dataclasses import replace

import numpy as np
import pytest

from delta_cad.checks.range.ranges import check_ranges
from delta_cad.checks.report import CheckResult, all_passed
from delta_cad.mechanism import inverse_kinematics
from tests.delta_cad.checks.machines import GEOMETRY, LIMITS

GIVEN = replace(
    LIMITS,
    lean_max_rad=np.radians(28.0),
    shoulder_range_rad=(np.radians(-45.0), np.radians(80.0)),
    force_N=3.0,
    joint_torque_N_m=0.8,
)


def by_name(limits) -> dict[str, CheckResult]:
    return {r.name: r for r in check_ranges(GEOMETRY, limits)}


def test_the_design_keeps_its_ranges() -> None:
    found = by_name(GIVEN)
    assert set(found) == {"reach", "lean", "shoulder lowest", "shoulder highest", "torque"}
    assert all_passed(found.values())
    # figures of the feasibility study: -39.2..65.5 deg, lean 27.2 deg, 0.316 N m; ours on the grid with corners
    assert np.degrees([found["shoulder lowest"].value, found["shoulder highest"].value]) == pytest.approx(
        [-39.2, 65.5], abs=0.1
    )
    assert np.degrees(found["lean"].value) == pytest.approx(27.2, abs=0.05)
    assert found["torque"].value == pytest.approx(0.316, abs=0.001)


def test_only_what_is_given_is_checked() -> None:
    assert set(by_name(LIMITS)) == {"reach"}


@pytest.mark.parametrize(
    ("name", "changes"),
    [
        ("lean", {"lean_max_rad": np.radians(27.0)}),
        ("shoulder lowest", {"shoulder_range_rad": (np.radians(-39.0), 1.4)}),
        ("shoulder highest", {"shoulder_range_rad": (-0.8, np.radians(65.0))}),
        ("torque", {"joint_torque_N_m": 0.315}),
    ],
)
def test_what_exceeds_its_limit_is_refused(name: str, changes: dict[str, object]) -> None:
    failed = [r for r in by_name(replace(GIVEN, **changes)).values() if not r.passed]
    assert [r.name for r in failed] == [name]
    pose = np.array(failed[0].worst_pose_mm)
    assert (np.abs(pose - LIMITS.centre_mm) <= LIMITS.half_side_mm + 1e-9).all()
    assert np.isfinite(inverse_kinematics(GEOMETRY, pose / 1000.0)).all()


def test_an_unreachable_cube_ends_the_ranges() -> None:
    found = by_name(replace(GIVEN, half_side_mm=80.0))
    assert set(found) == {"reach"}
    assert not found["reach"].passed
