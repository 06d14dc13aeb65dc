"""The position step against encoders that are read, 50 digits and haptics' figure; proofs, both ways."""

from __future__ import annotations

import math
from decimal import Decimal
from functools import cache
from itertools import product

import numpy as np
import pytest

from delta_cad.design import Design
from delta_cad.dimensions.joint import known_joints
from delta_cad.mechanism import Cube, DeltaGeometry, closure_margin, forward_kinematics, inverse_kinematics, jacobian
from delta_cad.mechanism.enclosure.interval import exactly
from delta_cad.mechanism.enclosure.slope_pose import SlopePose
from delta_cad.mechanism.enclosure.table import HIGH, LOW
from delta_cad.mechanism.limits import Limits, PositionStep
from delta_cad.mechanism.limits.position_step import position_step
from delta_cad.mechanism.proof.margins import BITS, FIRST, margins, numbers, room
from delta_cad.mechanism.proof.prove import prove
from delta_cad.mechanism.statics import direct_margin
from delta_cad.mechanism.workspace import CubeSearch
from haptics.feel.field import feel_at
from haptics.feel.sheet import joint_drive
from haptics.loop.assumptions import encoder_count
from optimizer.certify.replay import breaks, replay
from tests.delta_cad.mechanism.limits.proving import leaves, poses, verdict
from tests.delta_cad.mechanism.oracles import PUBLISHED
from tests.delta_cad.mechanism.proof.exact_oracle import exact_margins, samples
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


@pytest.mark.parametrize("size", [0.0, 1e-6, 1e-4, 1e-3])
def test_bounds_contain_the_exact_margins(size: float) -> None:
    rng, told = np.random.default_rng(29), 0
    for g, p in poses(rng, 40):
        limit = PositionStep(rng.uniform(1e-5, 1e-4), COUNT)
        pose, work, out = room()
        margins(
            np.array([*p, size, size, size, 0.0]), numbers(g, Limits.of(limit)), BITS[PositionStep], pose, work, out
        )
        low, high = (out[FIRST[PositionStep] :, side][:4] for side in (LOW, HIGH))
        told += int(np.isfinite(low).all())
        for point in samples(np.array([*p, size, size, size]), rng, 10):
            found = exact_margins(g, Limits.of(limit), tuple(map(float, point)))[PositionStep]
            for value, least, most in zip(found, low, high, strict=True):
                assert value is None or math.isnan(least) or Decimal(least) <= value <= Decimal(most)
    assert told > 20


@cache
def designs() -> list[tuple[DeltaGeometry, Cube, float, np.ndarray]]:
    """Random designs, each with the position of its largest step."""
    rng, found = np.random.default_rng(41), []
    while len(found) < 20:
        a, lb, bottom, half = rng.uniform([-0.02, 0.06, 0.02, 0.01], [0.04, 0.25, 0.2, 0.06])
        g, cube = DeltaGeometry(a + 0.05, 0.05, 0.082, lb), Cube(bottom, half)
        search = CubeSearch(cube, 31)
        closed = search(lambda p, g=g: np.nan_to_num(closure_margin(g, p).min(axis=-1), nan=-1.0), 1.0)
        if closed.value > 1e-4 and search(lambda p, g=g: direct_margin(g, p), 1.0).value > 0.05:
            most = search(lambda p, g=g: position_step(g, p, COUNT), -1.0)
            found.append((g, cube, most.value, np.array(most.position)))
    return found


@pytest.mark.quick(4)
@pytest.mark.parametrize("n", range(20))
def test_random_designs_are_proved_just_above_and_refuted_just_below(n: int) -> None:
    g, cube, most, at = designs()[n]
    above, below = PositionStep(1.001 * most, COUNT), PositionStep(0.999 * most, COUNT)
    proof = prove(g, cube, Limits.of(above))
    assert next(f for f in proof.findings if f.condition == "position_step").verdict == "proved"
    found = verdict(g, cube, below)
    assert found.verdict == "refuted"
    assert below.step_max < found.value <= most * (1.0 + 1e-9)
    assert found.value == position_step(g, np.array(found.point), COUNT)
    assert breaks(g, below, np.array(found.point))
    assert breaks(g, below, at)
    assert not breaks(g, above, at)
    low, high = leaves(cube, proof.leaves)
    examined, unproved = replay(g, [above], low, high)
    assert unproved is None
    assert examined < 20 * len(low) + 1_000
    _, unproved = replay(g, [below], low, high, max_boxes=4_000)
    assert unproved is not None


def test_where_a_chain_is_open_the_second_arithmetic_says_nothing() -> None:
    limit, p = PositionStep(1e-3, COUNT), np.array([[0.0, 0.0, 0.3]])
    assert not limit.second_proof(SlopePose(PUBLISHED, p, p), exactly)[0]
    assert not limit.second_refutation(SlopePose(PUBLISHED, p, p), exactly)


def test_a_finer_count_is_another_machine() -> None:
    limit = PositionStep(1e-4, COUNT)
    assert PositionStep(1e-4, math.nextafter(COUNT, 0.0)).laxer(limit)
    assert not PositionStep(1e-4, math.nextafter(COUNT, 1.0)).laxer(limit)
