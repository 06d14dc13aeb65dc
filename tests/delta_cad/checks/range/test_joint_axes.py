"""Solids that are not centred on the joints they belong to are refused."""

from dataclasses import replace

import numpy as np
import pytest

from delta_cad.assembly.machine import Assembly
from delta_cad.checks.range.joint_axes import check_joint_axes
from delta_cad.mechanism.placement import chain_turn
from tests.delta_cad.checks.machines import GEOMETRY, at, changed, machine

MACHINE = machine()


def test_the_machine_is_centred_on_its_joints() -> None:
    result = check_joint_axes(MACHINE)
    assert result.passed
    assert result.value is not None
    assert result.value < 1e-9
    assert "30 seats of 15 joints" in result.detail


@pytest.mark.parametrize(
    ("name", "frame", "joint"),
    [
        ("bearing_1", chain_turn(GEOMETRY, 1) @ at(40.002), "shoulder_1"),
        ("shaft_2", at(0.0, 0.0, -0.002), "shoulder_2"),
        ("socket_0_1_elbow", at(0.002), "elbow_0_1"),
        ("stud_1_0_wrist", chain_turn(GEOMETRY, 1) @ at(30.0, -27.002) @ np.diag([-1.0, -1.0, 1.0, 1.0]), "wrist_1_0"),
    ],
)
def test_a_seat_displaced_by_2_um_is_refused(name: str, frame: np.ndarray, joint: str) -> None:
    result = check_joint_axes(changed(MACHINE, name, placement=frame))
    assert not result.passed
    assert result.value == pytest.approx(0.002, rel=1e-6)
    assert result.worst_pair == (joint, name)
    assert name in result.detail


def test_an_askew_bearing_is_refused() -> None:
    turn = np.eye(4)
    turn[:2, :2] = [[1.0, -1e-4], [1e-4, 1.0]]
    result = check_joint_axes(changed(MACHINE, "bearing_0", placement=chain_turn(GEOMETRY, 0) @ at(40.0) @ turn))
    assert not result.passed
    assert result.value == pytest.approx(60.0 * 1e-4, rel=1e-3)


def without(*names: str) -> Assembly:
    return replace(MACHINE, occurrences=tuple(o for o in MACHINE.occurrences if o.name not in names))


def test_without_a_contact_any_part_of_the_link_may_hold_the_axis() -> None:
    bare = replace(without("bearing_0"), fits=())
    assert check_joint_axes(bare).passed  # the bracket's own bore, and the arm's
    assert not check_joint_axes(
        changed(bare, "bracket_0", placement=chain_turn(GEOMETRY, 0) @ at(0.0, 0.0, 0.002))
    ).passed


def test_a_link_without_parts_or_balls_is_refused() -> None:
    result = check_joint_axes(replace(without("socket_0_0_elbow", "socket_0_0_wrist"), fits=()))
    assert not result.passed
    assert result.value is None
    bare = tuple(o for o in MACHINE.occurrences if o.link != "upper_arm_0")
    result = check_joint_axes(replace(MACHINE, occurrences=bare, fits=()))
    assert not result.passed
    assert "a link without parts" in result.detail


def test_an_assembly_without_joints_is_refused() -> None:
    assert not check_joint_axes(replace(MACHINE, joints=())).passed
