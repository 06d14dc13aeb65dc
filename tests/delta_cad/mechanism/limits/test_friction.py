"""Friction at the handle against what motions dissipate and haptics' ball joints."""

from __future__ import annotations

import math
from decimal import Decimal

import numpy as np
import pytest

from delta_cad.commands.inspection import inspection
from delta_cad.design import Design
from delta_cad.dimensions.joint import ball_preload_N, known_joints, sliding_torques_N_mm
from delta_cad.drive import drive_friction_N_m
from delta_cad.mechanism import Cube, DeltaGeometry, inverse_jacobian
from delta_cad.mechanism.enclosure.table import HIGH, LOW
from delta_cad.mechanism.limits import Friction, HandleFriction, Limits
from delta_cad.mechanism.limits.friction import friction
from delta_cad.mechanism.proof.ball_friction import CLOSE, ball_friction
from delta_cad.mechanism.proof.margins import BITS, FIRST, margins, numbers, room
from haptics.feel.field import worst_friction
from haptics.model.ball_joints import ball_friction_N
from tests.delta_cad.mechanism.limits.proving import poses, verdict
from tests.delta_cad.mechanism.oracles import PUBLISHED
from tests.delta_cad.mechanism.proof.exact_oracle import exact_margins
from tests.haptics.scene_machine import scene_machine

DRY = HandleFriction(0.01, 0.0, 0.0)
RUBS = HandleFriction(0.012, 0.05, 0.08)


def directions(rng: np.random.Generator, count: int) -> np.ndarray:
    v = rng.normal(size=(count, 3))
    return v / np.linalg.norm(v, axis=1, keepdims=True)


def within(cube: Cube, rng: np.random.Generator, count: int) -> np.ndarray:
    """Positions of the cube, half of them on its surface."""
    unit = rng.uniform(-1.0, 1.0, (count, 3))
    face = rng.integers(0, 3, count // 2)
    unit[np.arange(count // 2), face] = np.sign(unit[np.arange(count // 2), face])
    return np.clip((cube.lower + cube.upper) / 2.0 + cube.half_side * unit, cube.lower, cube.upper)


def test_it_is_the_most_that_any_direction_takes_and_one_takes_it() -> None:
    rng = np.random.default_rng(3)
    for g, p in poses(rng, 40, 1e-4):
        taken = DRY.drive * np.abs(inverse_jacobian(g, p) @ directions(rng, 4000).T).sum(axis=0)
        most = float(friction(g, p, DRY))
        assert taken.max() <= most * (1.0 + 1e-12)
        assert taken.max() == pytest.approx(most, rel=5e-3)  # 4000 directions lie within 0.06 rad of any


def test_by_hand_on_the_axis() -> None:
    """Level arms, forearms upright: each joint turns by v_z / L_A, none for a level motion."""
    g = DeltaGeometry(0.03, 0.09, 0.06, 0.12)
    p = np.array([0.0, 0.0, 0.12])
    assert friction(g, p, DRY) == pytest.approx(3.0 * DRY.drive / 0.06, rel=1e-14)
    assert friction(g, p, RUBS) == pytest.approx(math.hypot(3.0 * RUBS.drive / 0.06 + RUBS.upright, RUBS.level))


def test_in_the_centre_of_the_committed_cube_by_its_symmetry(best: Design) -> None:
    """There `G_i = (a out_i, b)`: all three add up to 3 b along z, two against one to b along z and 2 a aside."""
    g, centre = best.geometry, np.array([0.0, 0.0, (best.cube.bottom_height_mm + best.cube.half_side_mm) / 1000.0])
    q, z, la, lb = g.base_radius - g.platform_radius, centre[2], g.upper_arm_length, g.forearm_length
    flat = math.hypot(q, z)  # shoulder to wrist, whose radial part is -q
    theta = math.atan2(z, -q) - math.acos((flat**2 + la**2 - lb**2) / (2.0 * la * flat))
    s = np.array([-q - la * math.cos(theta), z - la * math.sin(theta)])
    a, b = s / (la * (s @ [-math.sin(theta), math.cos(theta)]))
    c = RUBS.drive
    one = math.hypot(3.0 * c * b + RUBS.upright, RUBS.level)
    other = math.hypot(c * b + RUBS.upright, 2.0 * c * abs(a) + RUBS.level)
    assert friction(g, centre, RUBS) == pytest.approx(max(one, other), rel=1e-12)


def test_at_a_fold_it_is_infinite_and_beyond_it_is_not_a_number() -> None:
    g = DeltaGeometry(0.05, 0.03, 0.0625, 0.125)
    fold = np.array([0.02, 0.0, 0.0625])  # chain 0 folded upright, both lengths exact in binary
    found = friction(g, fold + np.outer([-1e-6, 0.0, 1e-9, 1e-6, 1e-3], [0.0, 0.0, 1.0]), RUBS)
    assert np.isnan(found[0])
    assert found[1] == math.inf
    assert (np.diff(found[1:]) < 0.0).all()


# the ball joints


def test_the_ball_joints_of_haptics_are_within_the_bounds_and_reach_them(best: Design) -> None:
    sources, rng = known_joints(best)["friction"], np.random.default_rng(5)
    p, v = within(best.workspace, rng, 100_000), directions(rng, 100_000)
    assert (
        ball_friction_N(best, p, v) <= sources.upright * np.abs(v[:, 2]) + sources.level * np.hypot(v[:, 0], v[:, 1])
    ).all()
    up, level = np.tile([0.0, 0.0, 1.0], (len(p), 1)), v * [1.0, 1.0, 0.0]
    level /= np.linalg.norm(level, axis=1, keepdims=True)
    corners = within(best.workspace, rng, 20_000)
    corners[:, 2] = np.where(rng.random(20_000) < 0.5, best.workspace.lower[2], best.workspace.upper[2])
    assert sources.upright <= 1.002 * CLOSE * ball_friction_N(best, corners, up[:20_000]).max()
    assert sources.level <= 1.03 * CLOSE * ball_friction_N(best, p, level).max()  # eight directions: 2 %


def test_the_bounds_are_those_of_both_rods_and_grow_with_their_torques() -> None:
    cube = Cube(0.057112, 0.03)
    lean, turn = ball_friction(PUBLISHED, cube, 1e-3, 0.0), ball_friction(PUBLISHED, cube, 0.0, 1e-3)
    both = ball_friction(PUBLISHED, cube, 1e-3, 1e-3)
    for one, other, sum_ in zip(lean, turn, both, strict=True):
        assert max(one, other) <= sum_ <= (one + other) * 1.02
    assert max(ball_friction(PUBLISHED, cube, 0.0, 0.0)) < 1e-8
    assert ball_friction(PUBLISHED, Cube(0.057112, 0.06), 1e-3, 1e-3)[0] == math.inf  # out of reach


def test_of_rods_for_which_there_is_no_spring_nothing_is_known_and_inspect_says_so(best: Design) -> None:
    wide = {"mechanism": best.mechanism.model_copy(update={"parallelogram_width_mm": 300.0})}
    required = {"requirements": best.requirements.model_copy(update={"friction_max_N": 0.7})}
    design = best.model_copy(update=wide | required)
    assert known_joints(design) == known_joints(best) | {"friction": None}
    (row,) = (row for row in inspection(design) if row.quantity == "friction")
    assert (row.value, row.holds) == ("not known of these joints", None)


# the sum


def test_no_motion_of_the_machine_takes_more_and_the_bound_is_near(best: Design) -> None:
    sources, g, rng = known_joints(best)["friction"], best.geometry, np.random.default_rng(7)
    assert sources.drive == drive_friction_N_m(best)[1]
    p, v = within(best.workspace, rng, 100_000), directions(rng, 100_000)
    rows = inverse_jacobian(g, p)
    taken = sources.drive * np.abs(np.einsum("nia,na->ni", rows, v)).sum(axis=1) + ball_friction_N(best, p, v)
    figure = friction(g, p, sources)
    assert (taken <= figure).all()
    theirs = worst_friction(scene_machine(best), p, rows, sources.drive)  # the ball joints where the drives rub most
    assert (theirs <= figure).all()
    assert figure.max() <= 1.06 * theirs.max()
    dry = sources._replace(upright=0.0, level=0.0)
    lean, turn = sliding_torques_N_mm(best.hardware.ball_diameter_mm, np.array(ball_preload_N(best)))
    assert float(lean) > float(turn) > 0.0
    limit = Friction(figure.max() * 1.001, *sources)
    assert verdict(g, best.workspace, limit).verdict == "proved"
    assert friction(g, p, dry).max() < theirs.max()


def test_without_ball_joints_it_is_that_of_haptics(best: Design, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("haptics.feel.field.ball_friction_N", lambda _design, _p, v: np.zeros(v.shape[:-1]))
    p = within(best.workspace, np.random.default_rng(9), 1000)
    theirs = worst_friction(scene_machine(best), p, inverse_jacobian(best.geometry, p), DRY.drive)
    np.testing.assert_allclose(friction(best.geometry, p, DRY), theirs, rtol=1e-12)


def test_about_the_axis_what_a_bound_leaves_out_refutes_nothing() -> None:
    """There the part square to z vanishes, which no quotient by it bounds from below: the upper end must not fall."""
    limit = Friction(1.0, 0.012, 0.0, 0.5)
    for z in (0.06, 0.09, 0.12):
        pose, work, out = room()
        box = np.array([0.0, 0.0, z, 1e-3, 1e-3, 0.0, 0.0])
        margins(box, numbers(PUBLISHED, Limits.of(limit)), BITS[Friction], pose, work, out)
        found = exact_margins(PUBLISHED, Limits.of(limit), (0.0, 0.0, z))[Friction]
        for value, row in zip(found, out[FIRST[Friction] :], strict=False):
            assert value is not None
            assert Decimal(row[LOW]) <= value <= Decimal(row[HIGH])
