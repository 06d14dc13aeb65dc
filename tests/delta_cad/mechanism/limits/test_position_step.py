"""The position step against encoders that are read and haptics' figure."""

from __future__ import annotations

import math
from itertools import product

import numpy as np
import pytest

from delta_cad.design import Design
from delta_cad.dimensions.joint import known_joints
from delta_cad.mechanism import DeltaGeometry, forward_kinematics, inverse_kinematics, jacobian
from delta_cad.mechanism.limits.position_step import position_step
from haptics.feel.field import feel_at
from haptics.feel.sheet import joint_drive
from haptics.loop.assumptions import encoder_count
from tests.delta_cad.mechanism.oracles import PUBLISHED
from tests.haptics.scene_machine import scene_machine

COUNT = 3.8e-4
CORNERS = np.array(list(product((-0.5, 0.5), repeat=3)))


def test_positions_that_read_alike_are_no_farther_apart_and_two_of_them_are(best: Design) -> None:
    """The corners of the cell of joint angles that three counts make, by forward kinematics."""
    rng, g, cube = np.random.default_rng(3), best.geometry, best.workspace
    q = known_joints(best)["encoder_count"]
    for p in rng.uniform(cube.lower, cube.upper, (40, 3)):
        found = forward_kinematics(g, inverse_kinematics(g, p) + q * CORNERS)
        apart = np.linalg.norm(found[:, None] - found[None, :], axis=-1).max()
        assert apart == pytest.approx(position_step(g, p, q), rel=1e-4)  # of second order in the count: corners oppose


def test_no_turn_within_a_count_moves_the_handle_farther(best: Design) -> None:
    rng, g, cube = np.random.default_rng(5), best.geometry, best.workspace
    p, turns = rng.uniform(cube.lower, cube.upper, (100_000, 3)), COUNT * rng.uniform(-1.0, 1.0, (100_000, 3))
    turns[::2] = COUNT * np.sign(turns[::2])
    moved = np.linalg.norm((jacobian(g, p) @ turns[..., None])[..., 0], axis=-1)
    most = position_step(g, p, COUNT)
    assert (moved <= most * (1.0 + 1e-12)).all()
    assert (moved / most).max() == pytest.approx(1.0, rel=1e-12)


def test_it_is_made_of_the_count_and_the_jacobian_of_haptics(best: Design) -> None:
    machine = scene_machine(best)
    assert known_joints(best)["encoder_count"] == encoder_count(machine) == joint_drive(machine).count
    p = np.random.default_rng(7).uniform(best.workspace.lower, best.workspace.upper, (200, 3))
    alone = feel_at(machine, joint_drive(machine), p)["position_step"]  # one encoder's count, the others at rest
    step = position_step(best.geometry, p, encoder_count(machine))
    assert (alone <= step).all()
    assert (step <= 3.0 * alone).all()
    columns = encoder_count(machine) * jacobian(best.geometry, p)
    sums = np.linalg.norm(columns @ (2.0 * CORNERS).T, axis=-2)
    np.testing.assert_allclose(step, sums.max(axis=-1), rtol=1e-12)
    np.testing.assert_allclose(alone, np.linalg.norm(columns, axis=-2).max(axis=-1), rtol=1e-12)


def test_by_hand_on_the_axis() -> None:
    """`G_i = (a out_i, b)` there: turning alike moves by 1 / b along z, two against one by 4 / 3 a and 1 / 3 b."""
    g = DeltaGeometry(0.05, 0.03, 0.08, 0.12)
    q, z, la, lb = 0.02, 0.1, 0.08, 0.12
    flat = math.hypot(q, z)
    theta = math.atan2(z, -q) - math.acos((flat**2 + la**2 - lb**2) / (2.0 * la * flat))
    s = np.array([-q - la * math.cos(theta), z - la * math.sin(theta)])
    a, b = s / (la * (s @ [-math.sin(theta), math.cos(theta)]))
    expected = COUNT * max(1.0 / abs(b), math.hypot(4.0 / (3.0 * a), 1.0 / (3.0 * b)))
    assert position_step(g, np.array([0.0, 0.0, z]), COUNT) == pytest.approx(expected, rel=1e-12)


def test_at_a_direct_singularity_it_is_infinite_and_out_of_reach_not_a_number() -> None:
    g = DeltaGeometry(
        0.03, 0.09, 0.06, 0.12
    )  # level arms, forearms upright and alike: nothing holds the platform level
    assert position_step(g, np.array([0.0, 0.0, 0.12]), COUNT) > 1e9
    assert math.isnan(position_step(PUBLISHED, np.array([0.0, 0.0, 0.3]), COUNT))
