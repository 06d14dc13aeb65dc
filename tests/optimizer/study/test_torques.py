"""What a torque means where gravity takes its share, and which torques a front is drawn for."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from optimizer.study.front import Curve
from optimizer.study.trade import torque_levels, with_torque
from tests.optimizer.front_tasks import joystick


def test_gravity_s_share_comes_on_top_of_the_torque_for_the_force() -> None:
    """0.11 N m hold the machine, so 0.5 N m for the force are a joint's 0.61; nothing else changes."""
    given = joystick()
    assert given.limits.gravity_torque_N_m == 0.11
    less = with_torque(given, 0.5)
    assert less.requirements.joint_torque_N_m == pytest.approx(0.61)
    assert less.limits == given.limits
    same = {"joint_torque_N_m": given.requirements.joint_torque_N_m}
    assert less.requirements.model_copy(update=same) == given.requirements


def test_torques_lie_a_third_and_two_thirds_between_the_ends_of_a_front() -> None:
    points: Any = tuple(SimpleNamespace(torque=torque) for torque in (0.2, 0.31, 0.5))
    assert torque_levels(Curve(joystick(), "a", "a", points)) == [0.3, 0.4]
    near: Any = tuple(SimpleNamespace(torque=torque) for torque in (0.2, 0.2004))
    assert torque_levels(Curve(joystick(), "a", "a", near)) == []  # whole mN m
