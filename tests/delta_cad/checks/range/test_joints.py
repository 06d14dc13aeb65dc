"""Joint frames that do not meet, and balls that tilt too far, are refused."""

from dataclasses import replace

import numpy as np
import pytest

from delta_cad.assembly.machine import Assembly
from delta_cad.checks.range.joints import check_joints
from delta_cad.mechanism import rod_lean
from delta_cad.solids.part import Joint
from tests.delta_cad.checks.machines import LIMITS, at, machine

MACHINE = machine()


def spoiled(name: str, **changes: object) -> Assembly:
    joints = tuple(replace(j, **changes) if j.name == name else j for j in MACHINE.joints)
    return replace(MACHINE, joints=joints)


def test_the_machine_closes() -> None:
    closure, tilt = check_joints(MACHINE, LIMITS)
    assert closure.passed
    assert closure.value is not None
    assert closure.value < 1e-9
    assert tilt.passed
    # oracle: the studs lie along the shoulder's direction, so the tilt is the lean, largest on a corner of the cube
    lean = np.abs(rod_lean(MACHINE.placement.geometry, LIMITS.corners_mm / 1000.0)).max()
    assert tilt.value == pytest.approx(np.degrees(lean), abs=1e-7)
    assert tilt.unit == "deg"


def test_frames_2_um_apart_are_refused() -> None:
    frame = next(j for j in MACHINE.joints if j.name == "wrist_1_0").frame_a
    closure, _ = check_joints(spoiled("wrist_1_0", frame_a=at(0.0, 0.0, 0.002) @ frame), LIMITS)
    assert not closure.passed
    assert closure.value == pytest.approx(0.002, rel=1e-6)
    assert closure.worst_pair == ("wrist_1_0",)


def test_a_revolute_axis_askew_by_2_um_over_its_lever_is_refused() -> None:
    turn = np.eye(4)
    turn[:2, :2] = [[1.0, -2e-3 / 60.0], [2e-3 / 60.0, 1.0]]
    closure, _ = check_joints(spoiled("shoulder_2", frame_b=turn), LIMITS)
    assert not closure.passed
    assert closure.value == pytest.approx(0.002, rel=1e-3)


def test_tilt_over_its_limit_is_refused() -> None:
    _, tilt = check_joints(spoiled("elbow_1_1", tilt_limit_rad=np.radians(20.0)), LIMITS)
    assert not tilt.passed
    assert tilt.limit == pytest.approx(20.0)
    assert tilt.worst_pair == ("elbow_1_1",)
    assert tilt.worst_pose_mm is not None


def test_an_assembly_without_joints_is_refused() -> None:
    (result,) = check_joints(replace(MACHINE, joints=()), LIMITS)
    assert not result.passed


def test_unknown_kinds_and_missing_limits_are_refused() -> None:
    with pytest.raises(ValueError, match="screw"):
        check_joints(spoiled("elbow_0_0", kind="screw"), LIMITS)
    with pytest.raises(ValueError, match="elbow_0_0"):
        check_joints(spoiled("elbow_0_0", tilt_limit_rad=None), LIMITS)


def test_revolute_joints_alone_give_no_tilt() -> None:
    joints: tuple[Joint, ...] = tuple(j for j in MACHINE.joints if j.kind == "revolute")
    (result,) = check_joints(replace(MACHINE, joints=joints), LIMITS)
    assert result.passed
