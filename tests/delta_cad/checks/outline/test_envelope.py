"""The swept outline: closed forms, dense sampling from below, and machines that are too large."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from delta_cad.assembly.machine import Assembly
from delta_cad.assembly.tessellation import MeshLibrary
from delta_cad.checks.outline.envelope import DIRECTIONS, check_envelope, radial_range, swept_outline
from delta_cad.checks.outline.rod_reach import cosine_range
from delta_cad.checks.report import CheckResult
from delta_cad.mechanism import inverse_kinematics
from delta_cad.mechanism.placement import chain_turn
from tests.delta_cad.checks.machines import (
    GEOMETRY,
    LIMITS,
    PINION,
    PLACED,
    PLACED_LIMITS,
    at,
    ball,
    box,
    changed,
    machine,
    part,
    rod,
)

MACHINE = machine()


def check(a: Assembly, **changes: float) -> dict[str, CheckResult]:
    meshes = MeshLibrary(a.parts, 0.05, 0.35)
    return {r.name: r for r in check_envelope(a, replace(LIMITS, **changes), meshes)[0]}


def only(a: Assembly, *names: str) -> Assembly:
    return replace(a, occurrences=tuple(o for o in a.occurrences if o.name in names))


def sampled_reach(a: Assembly, meshes: MeshLibrary, middle: np.ndarray, half: float) -> np.ndarray:
    """(4,) reach of all bodies' meshes over corners and 3000 positions of a cube."""
    rng = np.random.default_rng(3)
    p = middle + half * np.concatenate([[*product((-1.0, 1.0), repeat=3)], rng.uniform(-1.0, 1.0, (3000, 3))])
    reach = np.full(4, -np.inf)
    poses = a.poses(p)
    for o in a.occurrences:
        frame, hull = poses[o.name], meshes[o.part.number].hull_points
        for k, d in enumerate(DIRECTIONS):
            along = ((d @ frame[:, :3, :3]) @ hull.T).max(axis=1) + frame[:, :3, 3] @ d
            reach[k] = max(reach[k], along.max())
    return reach


@pytest.mark.parametrize("placed", [False, True])
def test_the_outline_bounds_dense_sampling_and_exceeds_it_by_little(placed: bool) -> None:
    a, limits = (machine(geometry=PLACED), PLACED_LIMITS) if placed else (MACHINE, LIMITS)
    meshes = MeshLibrary(a.parts, 0.05, 0.35)
    outline = swept_outline(a, limits, meshes)
    middle = np.array([6.0, 0.0, 94.0]) if placed else limits.centre_mm
    reach = sampled_reach(a, meshes, middle, limits.half_side_mm)
    assert (outline.reach_mm >= reach).all()
    meshes_mm = outline.reach_mm - [b.mesh.deviation_mm for b in outline.bodies]
    assert (meshes_mm - reach).max() < 0.1  # gap 0.02, the rest is between the samples
    assert outline.reach_mm[2] == pytest.approx(outline.reach_mm[3], abs=0.1)  # the machine is its mirror image


@pytest.mark.parametrize("name", ["platform", "arm_0", "arm_1", "pinion_2", "socket_2_0_elbow", "motor_1"])
def test_each_body_of_a_placed_machine_reaches_as_far_as_it_does_where_it_stands(name: str) -> None:
    """About the cube's own middle, which is not the base's axis."""
    a = only(machine(geometry=PLACED), name)
    meshes = MeshLibrary(a.parts, 0.05, 0.35)
    outline = swept_outline(a, PLACED_LIMITS, meshes)
    reach = sampled_reach(a, meshes, np.array([6.0, 0.0, 94.0]), 33.0)
    over = outline.reach_mm - [b.mesh.deviation_mm for b in outline.bodies] - reach
    assert (over > -1e-9).all()
    assert over.max() < 0.3


def test_fits_in_one_orientation_and_says_which() -> None:
    found = check(MACHINE, envelope_width_mm=270.0, envelope_depth_mm=222.0)
    assert found["envelope width"].passed
    assert found["envelope depth"].passed
    assert "W lies along y" in found["envelope width"].detail
    turned = check(MACHINE, envelope_width_mm=222.0, envelope_depth_mm=270.0)
    assert turned["envelope width"].value == found["envelope depth"].value
    assert "W lies along x" in turned["envelope width"].detail


def test_an_envelope_1_mm_too_small_is_refused() -> None:
    sizes = {name: r.value or 0.0 for name, r in check(MACHINE).items()}
    large = {
        "envelope_width_mm": sizes["envelope width"] + 0.001,
        "envelope_depth_mm": sizes["envelope depth"] + 0.001,
    }
    assert all(r.passed for r in check(MACHINE, **large).values())
    for name in large:
        small = check(MACHINE, **{**large, name: large[name] - 1.0})
        assert not small[name.removesuffix("_mm").replace("_", " ")].passed


def test_a_motor_that_is_too_long_is_refused() -> None:
    long = part("long_motor", rod(15, (0, 14, 0), (0, 170, 0)))
    found = check(changed(MACHINE, "motor_0", part=long), envelope_width_mm=270.0, envelope_depth_mm=222.0)
    failed = [r for r in found.values() if not r.passed]
    assert failed
    assert any("motor_0" in (r.worst_pair or ()) for r in failed)
    assert any(r.value == pytest.approx(170 + 126.3, abs=1.0) for r in failed)


def test_platform_and_base_in_closed_form() -> None:
    found = check(only(MACHINE, "platform"))
    assert [r.value for r in found.values()] == pytest.approx([48.0 + 75.0] * 2, abs=0.15)
    base = check(only(MACHINE, "base_plate"))
    assert base["envelope width"].value == pytest.approx(120.0, abs=0.03)


def test_pinion_in_closed_form_whatever_its_angle() -> None:
    off_centre = part("pinion_tooth", box((6, 0, -1), (8, 1, 1)))
    found = check(only(changed(MACHINE, "pinion_0", part=off_centre), "pinion_0"))
    radius = np.hypot(8.0, 1.0)
    values = sorted(r.value or 0.0 for r in found.values())
    assert values[1] == pytest.approx(2 * radius, rel=3e-3)  # the polygon of revolution is 0.2 % large
    assert values[0] == pytest.approx(1.0, abs=1e-3)
    assert PINION[0] == 40.0


def test_arm_in_closed_form_and_an_elbow_ball_on_the_rod() -> None:
    """A ball at the elbow reaches R + L_A cos(theta) + radius, whichever link carries it."""
    theta = inverse_kinematics(GEOMETRY, LIMITS.poses_mm() / 1000.0)[:, 0]
    tip = part("tip", ball(2))
    for carrier, place in (("arm_0", at(82.0)), ("tube_0_0", at())):
        (x,) = [
            r
            for r in check(only(changed(MACHINE, carrier, part=tip, placement=place), carrier)).values()
            if r.detail.startswith("along x")
        ]
        assert theta.min() < 0.0 < theta.max()
        low = 40.0 + 82.0 * np.cos(theta).min() - 2.0
        assert x.value == pytest.approx(
            40.0 + 82.0 + 2.0 - low, abs=0.3
        )  # deviations 0.05 each side; the samples miss up to 0.004 rad of theta
        assert x.value >= 122.0 + 2.0 - low


def test_a_direct_drive_next_to_the_shoulder_turns_about_its_own_axis() -> None:
    assembly = machine(1.0)
    adjacent = replace(assembly.placement, pinion_centre_mm=(30.0, 0.0))
    stick = part("stick", box((0, 0, -0.5), (20, 1, 0.5)))
    found = check(only(changed(replace(assembly, placement=adjacent), "pinion_0", part=stick), "pinion_0"))
    assert any(f"to {50.0:.1f}" in r.detail for r in found.values() if r.detail.startswith("along x"))


def test_a_cube_with_a_fold_is_refused() -> None:
    found = check(only(MACHINE, "platform"), half_side_mm=80.0)
    assert not any(r.passed for r in found.values())
    assert all("fold" in r.detail for r in found.values())


def test_ranges_of_a_turning_point_and_of_the_cosine() -> None:
    rng = np.random.default_rng(2)
    for _ in range(200):
        point, radius = rng.normal(size=(1, 3)) * 30, rng.uniform(0, 50)
        theta = np.sort(rng.uniform(-3, 3, 2))
        fine = np.linspace(theta[0], theta[1], 2000)
        out = radius + point[0, 0] * np.cos(fine) - point[0, 2] * np.sin(fine)
        least, most = radial_range(point, radius, theta)
        assert (least[0], most[0]) == pytest.approx((out.min(), out.max()), abs=1e-4)  # 2000 steps of a 50 mm circle
        low, high = cosine_range(theta[:1], theta[1:])
        assert (low[0], high[0]) == pytest.approx((np.cos(fine).min(), np.cos(fine).max()), abs=1e-5)
    assert chain_turn(GEOMETRY, 0)[0, 0] == 1.0
