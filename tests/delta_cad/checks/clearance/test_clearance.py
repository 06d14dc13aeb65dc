"""Clearance: known-bad machines are refused, known distances are met, and no proof exceeds dense sampling."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import cadquery as cq
import numpy as np
import pytest

from delta_cad.assembly.machine import Assembly
from delta_cad.assembly.tessellation import MeshLibrary
from delta_cad.checks.clearance.bodies import DistanceEngine
from delta_cad.checks.clearance.branch_and_bound import ClearanceProof, _described, prove
from delta_cad.checks.clearance.clearance import (
    _proof,
    exact_distance,
    handle_proofs,
    mesh_clearance,
)
from delta_cad.checks.clearance.fast_fail import check_moving
from delta_cad.checks.clearance.joint_ranges import joint_ranges
from delta_cad.checks.clearance.pairing import clearance_pairs, spaces_of
from delta_cad.checks.clearance.sampled import TOLERANCE_MM, Sampler
from delta_cad.checks.limits import CheckLimits
from delta_cad.checks.links import free_tilt
from delta_cad.checks.report import CheckResult
from delta_cad.mechanism import closure_margin, rod_lean
from delta_cad.mechanism.placement import LINKS
from delta_cad.solids.part import Fit, Occurrence, Part
from tests.delta_cad.checks.machines import (
    GEOMETRY,
    L_B,
    LIMITS,
    WIDTH,
    at,
    ball,
    box,
    changed,
    check_clearance,
    machine,
    part,
    placement,
    rod,
)

MACHINE = machine()
MESHES = MeshLibrary(MACHINE.parts, 0.1, 0.5)
DOMAINS = joint_ranges(GEOMETRY, LIMITS.centre_mm, LIMITS.half_side_mm)


def assembly(*occurrences: tuple[str, Part, str, np.ndarray], fits: tuple[Fit, ...] = ()) -> Assembly:
    placed = tuple(Occurrence(*o) for o in occurrences)
    return Assembly("test", placed, (), fits, placement(), LIMITS.centre_mm)


def check(a: Assembly, limits: CheckLimits = LIMITS, **options: int) -> dict[str, CheckResult]:
    meshes = MeshLibrary(a.parts, 0.1, 0.5)
    return {r.name: r for r in check_clearance(a, limits, meshes, **options)}


def proven(a: Assembly, clearance_mm: float) -> bool:
    """Whether the proof alone, without the samples, finds the clearance."""
    limits = replace(LIMITS, clearance_min_mm=clearance_mm)
    pairs = clearance_pairs(a, limits, MeshLibrary(a.parts, 0.02, 0.2))
    engine = DistanceEngine()
    return not any(
        prove(s, engine, 3000).undecided for s in spaces_of(pairs, a.placement, DOMAINS, limits, free_tilt(a))
    )


@pytest.mark.quick(1)
@pytest.mark.parametrize("ratio", [9.5, 1.0])
def test_the_machine_is_clear_and_proven(ratio: float) -> None:
    wording: list[str] = []
    found = {r.name: r for r in check_clearance(machine(ratio), LIMITS, MESHES, wording.append)}
    assert all(r.passed for r in found.values()), [r for r in found.values() if not r.passed]
    assert found["clearance"].value > 1.0
    assert found["clearance"].worst_pair is not None
    assert "proved minimum clearance >= 1 mm" in found["clearance proof"].detail
    # the rotor of a direct drive is fixed to its arm: its running gap to the sector is none
    assert sum(name.startswith("running gap") for name in found) == (6 if ratio > 1.0 else 3)
    assert wording


@pytest.mark.slow
def test_shifted_part_is_refused() -> None:
    shifted = changed(MACHINE, "socket_1_0_wrist", placement=at(L_B + 3.0, 2.0, 0.0))
    found = check(shifted)
    assert not found["clearance"].passed
    assert "socket_1_0_wrist" in str(found["clearance"].worst_pair)
    assert not found["clearance proof"].passed


def test_arm_that_hits_the_base_is_refused() -> None:
    raised = changed(MACHINE, "base_plate", placement=at(0.0, 0.0, 32.0))
    found = check(raised)
    assert not found["clearance"].passed
    assert "base_plate" in str(found["clearance"].worst_pair)
    assert found["clearance"].worst_pose_mm is not None


def test_contained_part_is_refused() -> None:
    platform = part("ball", ball(40))
    inside = part("core", ball(3))
    core = at(0.0, 0.0, 94.612)
    small = replace(LIMITS, half_side_mm=10.0, bottom_height_mm=84.612)
    found = check(assembly(("ball", platform, "platform", np.eye(4)), ("core", inside, "base", core)), small)
    assert not found["containment"].passed
    assert found["containment"].worst_pair == ("ball", "core")
    # the surfaces themselves stay 19 mm apart and more: nothing else would notice
    assert found["clearance"].passed
    assert found["clearance proof"].passed


def test_a_part_in_a_cavity_is_not_contained() -> None:
    shell = part("shell", ball(40).cut(ball(30)))
    core = part("core", ball(3))
    small = replace(LIMITS, half_side_mm=10.0, bottom_height_mm=84.612)
    found = check(assembly(("shell", shell, "platform", np.eye(4)), ("core", core, "base", at(0, 0, 94.612))), small)
    assert all(r.passed for r in found.values())


def test_thin_wall_passed_through_between_two_positions_is_refused_by_the_proof_alone() -> None:
    pin = part("pin", ball(3))
    wall = part("wall", box((18.7, -5, 90), (18.8, 5, 100)))
    found = check(
        assembly(("pin", pin, "platform", np.eye(4)), ("wall", wall, "base", np.eye(4))),
        replace(LIMITS, grid=3, random_poses=0),
    )
    assert found["clearance"].passed  # the grid steps over the wall
    proof = found["clearance proof"]
    assert not proof.passed
    assert proof.worst_pair is not None
    assert set(proof.worst_pair) == {"pin", "wall"}
    assert "undecided in handle position: (" in proof.detail
    assert proof.value is not None
    assert -0.5 < proof.value < 0.0  # both touch; what meshes may be off is left away


def test_an_exhausted_budget_is_a_failure_that_names_the_box() -> None:
    found = check(MACHINE, calls_max=3)
    assert found["clearance"].passed
    assert not found["clearance proof"].passed
    assert found["clearance proof"].value is None
    assert "undecided in" in found["clearance proof"].detail


def test_a_proof_takes_as_many_distances_as_large_sectors_need_and_no_more() -> None:
    """Of a quick one, each distance counts as many: the whole as those of sectors that pass, or as just too many."""

    class Counted(DistanceEngine):
        each = 1

        def _placed(self, *given: Any) -> Any:
            self.calls += self.each - 1
            return super()._placed(*given)

    x, y, z = LIMITS.centre_mm
    small = replace(LIMITS, half_side_mm=10.0, bottom_height_mm=z - 10.0)
    inner, outer = (box((x - r, y - r, z - r), (x + r, y + r, z + r)) for r in (15.0, 20.0))
    pin, cage = part("pin", ball(3)), part("cage", outer.cut(inner))
    two = assembly(("cage", cage, "base", np.eye(4)), ("pin", pin, "platform", np.eye(4)))
    pairs = clearance_pairs(two, small, MeshLibrary(two.parts, 0.1, 0.5))
    ranges = joint_ranges(GEOMETRY, small.centre_mm, small.half_side_mm)
    (space,) = spaces_of(pairs, two.placement, ranges, small, 0.0)
    engine, taken = Counted(), prove(space, DistanceEngine()).calls
    for calls, decided in ((157_000, True), (205_000, False)):
        engine.each = calls // taken
        assert (prove(space, engine).undecided == []) == decided


def test_of_the_undecided_the_pair_with_the_least_margin_is_reported_first() -> None:
    """What the calls did not suffice for was told before what is truly too close; `design` mended another length."""
    room = box((-42, -42, 52), (42, 42, 138))
    cage = part("cage", box((-50, -50, 45), (50, 50, 145)).cut(room))  # clear, but only many calls show it
    pin, wall = part("pin", ball(3)), part("wall", box((18.7, -5, 90), (18.8, 5, 100)))
    three = (
        ("cage", cage, "base", np.eye(4)),
        ("pin", pin, "platform", np.eye(4)),
        ("wall", wall, "base", np.eye(4)),
    )
    proof = check(assembly(*three), replace(LIMITS, grid=3, random_poses=0), calls_max=2000)["clearance proof"]
    assert proof.detail.startswith("2 pairs undecided")
    assert proof.worst_pair is not None
    assert set(proof.worst_pair) == {"pin", "wall"}


def test_a_cube_that_may_hold_a_fold_is_not_proven() -> None:
    small = assembly(("pin", part("pin", ball(3)), "platform", np.eye(4)))
    # reachable at every sampled position, but a chain is stretched out within a hair of one of them
    low, high = 37.5, 80.0
    while high - low > 1e-6:
        half = (low + high) / 2.0
        limits = replace(LIMITS, half_side_mm=half, grid=3, random_poses=0)
        reachable = closure_margin(GEOMETRY, limits.poses_mm() / 1000.0).min() > 0.0
        low, high = (half, high) if reachable else (low, half)
    limits = replace(limits, half_side_mm=low)
    found = {r.name: r for r in check_clearance(small, limits, MeshLibrary(small.parts, 0.1, 0.5))}
    assert not found["clearance proof"].passed
    assert "fold" in found["clearance proof"].detail


def test_running_gap_is_held_to_its_own_limit_in_samples_and_proof() -> None:
    pins = (("a", part("a", ball(3)), "base", at(0, 0, 50.0)), ("b", part("b", ball(3)), "platform", np.eye(4)))
    gap = LIMITS.bottom_height_mm - 56.0  # 1.112 mm at the middle of the cube's bottom
    for limit, passes in ((0.6, True), (1.2, False)):  # the facets of two balls cost up to 0.4 mm
        found = check(assembly(*pins, fits=(Fit("a", "b", "running gap", gap_mm=limit),)))
        result = found["running gap a / b"]
        assert result.passed == passes
        assert result.value == pytest.approx(gap, abs=0.42)
        assert found["clearance proof"].passed == passes
        assert found["clearance"].passed  # no other pair


def test_contacts_are_left_to_the_fits() -> None:
    pins = (("a", part("a", ball(3)), "base", at(0, 0, 94.0)), ("b", part("b", ball(3)), "platform", np.eye(4)))
    assert not check(assembly(*pins))["clearance"].passed
    assert check(assembly(*pins, fits=(Fit("a", "b", "contact"),)))["clearance proof"].passed


def test_mesh_and_exact_distances_must_agree(monkeypatch: pytest.MonkeyPatch) -> None:
    pins = (("a", part("a", ball(3)), "base", at(0, 0, 40.0)), ("b", part("b", ball(3)), "platform", np.eye(4)))
    exact = check(assembly(*pins))["clearance exact"]
    assert exact.passed
    measured = DistanceEngine.closest_points

    def too_far(self: DistanceEngine, *args):  # type: ignore[no-untyped-def]
        d, p, q = measured(self, *args)
        return d + 0.5, p, q

    monkeypatch.setattr(DistanceEngine, "closest_points", too_far)
    assert not check(assembly(*pins))["clearance exact"].passed


def test_exact_distance_of_balls_and_of_a_ball_inside_a_ball() -> None:
    assert exact_distance(ball(3), ball(2), at(0, 0, 9)) == pytest.approx(4.0, abs=1e-6)
    assert exact_distance(ball(5), ball(2), at(1)) == 0.0


def test_ball_on_the_platform_against_a_ball_on_the_base_in_closed_form() -> None:
    centre = np.array([12.0, -55.0, 40.0])
    a = assembly(("a", part("a", ball(4)), "base", at(*centre)), ("b", part("b", ball(3)), "platform", at(0, 0, 2)))
    raised = np.array([0.0, 0.0, 2.0])
    low, high = LIMITS.corners_mm.min(axis=0) + raised, LIMITS.corners_mm.max(axis=0) + raised
    exact = np.linalg.norm(np.clip(centre, low, high) - centre) - 7.0
    assert proven(a, exact - 0.15)
    assert not proven(a, exact + 0.001)


def test_what_another_process_proves_is_part_of_the_whole() -> None:
    """A ball of the platform that only the handle's position moves against one of the base, 1 mm too near."""
    centre = np.array([12.0, -55.0, 40.0])
    a = assembly(("a", part("a", ball(4)), "base", at(*centre)), ("b", part("b", ball(3)), "platform", at(0, 0, 2)))
    raised = np.array([0.0, 0.0, 2.0])
    low, high = LIMITS.corners_mm.min(axis=0) + raised, LIMITS.corners_mm.max(axis=0) + raised
    near = float(np.linalg.norm(np.clip(centre, low, high) - centre)) - 7.0 + 1.0
    limits = replace(LIMITS, clearance_min_mm=near, envelope_width_mm=1e3, envelope_depth_mm=1e3)
    meshes = MeshLibrary(a.parts, 0.02, 0.2)
    (proof,) = handle_proofs(a, limits, meshes, 3000)
    assert proof.undecided
    found = {r.name: r.passed for r in check_moving(a, limits, meshes, lambda _: None).results}
    assert (found["clearance"], found["clearance proof"]) == (False, False)
    there = mesh_clearance(a, limits, meshes, calls_max=3000, handle=lambda: [proof])
    here = mesh_clearance(a, limits, meshes, calls_max=3000)
    assert [r.passed for r in there.results] == [r.passed for r in here.results]
    far = replace(limits, clearance_min_mm=near - 1.2)
    moved, whole = (
        {r.name: r for r in found}
        for found in (check_moving(a, far, meshes, lambda _: None).results, check_clearance(a, far, meshes))
    )
    assert whole["clearance proof"].passed
    assert moved["clearance proof"] == whole["clearance proof"]  # as many boxes and distance calls among the rest


def test_parallel_rods_in_closed_form() -> None:
    tube = part("tube", rod(2.5, (12, 0, 0), (100, 0, 0)))
    a = assembly(("tube_0", tube, "rod_1_0", np.eye(4)), ("tube_1", tube, "rod_1_1", np.eye(4)))
    lean = np.abs(rod_lean(GEOMETRY, LIMITS.corners_mm / 1000.0)).max()
    exact = WIDTH * np.cos(lean) - 5.0  # the lean is extreme on a corner: it is the arcsine of a linear function
    assert proven(a, exact - 0.1)
    assert not proven(a, exact + 0.001)
    found = check(a)
    deviation = 2 * MeshLibrary(a.parts, 0.1, 0.5)["tube"].deviation_mm
    assert exact - deviation - 1e-9 <= found["clearance"].value <= exact + 1e-9


PLACES = {
    "base": ((60, 0, -20), 30),
    "upper_arm": ((60, 0, 0), 25),
    "rod": ((56, 0, 0), 40),
    "platform": ((0, 0, 0), 30),
}


def random_pair(rng: np.random.Generator, one: str, other: str) -> tuple[Assembly, float]:
    """Two balls on two links, and their least distance over many positions, in closed form at each."""
    radii = rng.uniform(1.0, 3.0, 2)
    corners = LIMITS.corners_mm
    p = np.concatenate([corners, LIMITS.centre_mm + 37.5 * surface(rng, 30000)])
    links = placement()(p)
    while True:
        spots = []
        for link in (one, other):
            kind = next(kind for kind in PLACES if link.startswith(kind))
            middle, spread = PLACES[kind]
            spots.append(np.asarray(middle) + rng.uniform(-spread, spread, 3))
        world = [
            links[link][:, :3, :3] @ spot + links[link][:, :3, 3]
            for link, spot in zip((one, other), spots, strict=True)
        ]
        least = float(np.linalg.norm(world[0] - world[1], axis=1).min() - radii.sum())
        if least > 1.0:
            break
    a = assembly(
        *((f"ball_{k}", part(f"ball_{k}", ball(radii[k])), link, at(*spots[k])) for k, link in enumerate((one, other)))
    )
    return a, least


def surface(rng: np.random.Generator, count: int) -> np.ndarray:
    """Points of the cube [-1, 1]^3, four of five of them on its faces and edges, where extremes lie."""
    u = rng.uniform(-1, 1, (count, 3))
    grown = u * rng.choice([1.0, 1.0, 50.0], (count, 3))
    return np.clip(grown, -1.0, 1.0)


@pytest.mark.quick(6)
@pytest.mark.parametrize(
    ("one", "other"),
    [
        ("base", "upper_arm_1"),
        ("upper_arm_0", "upper_arm_1"),
        ("upper_arm_2", "upper_arm_0"),
        ("rod_1_0", "rod_1_1"),
        ("rod_2_1", "platform"),
        ("rod_0_0", "upper_arm_0"),
        ("base", "rod_1_1"),
        ("rod_2_0", "upper_arm_1"),
        ("rod_0_0", "rod_2_1"),
        ("base", "platform"),
        ("platform", "upper_arm_2"),
    ],
)
@pytest.mark.parametrize("seed", [1, 2])
def test_no_proof_exceeds_what_dense_sampling_finds(one: str, other: str, seed: int) -> None:
    """Adversarial: a limit a micrometre above a distance that occurs must never be proven, one a little below must."""
    a, least = random_pair(np.random.default_rng([seed, LINKS.index(one), LINKS.index(other)]), one, other)
    assert not proven(a, least + 0.001)
    assert proven(a, least - max(0.4, 0.1 * least))


def test_the_sampler_finds_what_measuring_everything_finds() -> None:
    poses = LIMITS.poses_mm()[::7]
    engine = DistanceEngine()
    sampler = Sampler(MACHINE.placement, poses, engine)
    wanted = ("socket_0_0_wrist", "wrist_bar_0", "arm_0", "sector_1", "bracket_1", "tube_2_0", "platform", "pinion_1")
    pairs = [p for p in clearance_pairs(MACHINE, LIMITS, MESHES) if p.a.name in wanted and p.b.name in wanted]
    closest = sampler.closest(pairs)
    calls = engine.calls
    brute = {
        (pair.a.name, pair.b.name): min(
            engine.distance(
                pair.a,
                pair.b,
                sampler.frames[pair.a.link][k] @ pair.a.placement,
                sampler.frames[pair.b.link][k] @ pair.b.placement,
            )
            for k in range(len(poses))
        )
        for pair in pairs
    }
    least = min(brute, key=lambda names: brute[names])
    assert (closest[0].pair.a.name, closest[0].pair.b.name) == least
    assert closest[0].distance_mm == pytest.approx(brute[least], abs=TOLERANCE_MM)
    assert calls < 0.1 * len(pairs) * len(poses)


def test_an_assembly_of_one_link_has_nothing_to_hold_apart() -> None:
    found = check(assembly(("pin", part("pin", ball(3)), "platform", np.eye(4))))
    assert all(r.passed for r in found.values())
    assert found["clearance"].value is None


def test_non_convex_bodies_are_measured_as_they_are() -> None:
    """A ring around a pin: bounding boxes and hulls overlap, the bodies do not."""
    ring = part("ring", rod(60, (0, 0, -3), (0, 0, 3)).cut(rod(50, (0, 0, -3), (0, 0, 3))))
    pin = part("pin", rod(4, (0, 0, 40), (0, 0, 150)))
    small = replace(LIMITS, half_side_mm=20.0, bottom_height_mm=74.612)
    found = check(assembly(("ring", ring, "platform", np.eye(4)), ("pin", pin, "base", np.eye(4))), small)
    assert all(r.passed for r in found.values())
    exact = 50.0 - 4.0 - 20.0 * np.sqrt(2.0)
    assert found["clearance"].value == pytest.approx(exact, abs=0.4)
    assert found["clearance"].value <= exact


def test_distances_over_rotated_frames_match_the_kernel() -> None:
    """The third opinion on FCL: exact distances of facetted solids, whose meshes are exact."""
    rng = np.random.default_rng(5)
    one, other = box((0, 0, 0), (4, 2, 9)), cq.Solid.makeBox(3, 8, 1).cut(cq.Solid.makeBox(1, 3, 1)).Solids()[0]
    a = assembly(("a", part("a", one), "base", np.eye(4)), ("b", part("b", other), "platform", np.eye(4)))
    pair = clearance_pairs(a, LIMITS, MeshLibrary(a.parts, 0.1, 0.5))[0]
    engine = DistanceEngine()
    for _ in range(60):
        q, _r = np.linalg.qr(rng.normal(size=(3, 3)))
        pose = at(*rng.uniform(-9, 9, 3))
        pose[:3, :3] = q * np.sign(np.linalg.det(q))
        d, p, s = engine.closest_points(pair.a, pair.b, np.eye(4), pose)
        assert d == pytest.approx(exact_distance(one, other, pose), abs=1e-6)
        if d > 0.0:
            assert np.linalg.norm(p - s) == pytest.approx(d, abs=1e-9)


def test_the_proof_names_what_is_missing_most_and_how_much() -> None:
    def sample(a: str, b: str, certain_mm: float, limit_mm: float) -> Any:
        pair = SimpleNamespace(a=SimpleNamespace(name=a), b=SimpleNamespace(name=b), limit_mm=limit_mm)
        return SimpleNamespace(pair=pair, certain_mm=certain_mm)

    gave_up = ClearanceProof("s", undecided=[(("e", "f"), "a box")])
    close = ClearanceProof("s", undecided=[(("c", "d"), "a box")], closest={("c", "d"): -0.01})
    near, nearer = sample("a", "b", 1.99, 2.0), sample("g", "h", 0.05, 0.3)
    for proofs, refuted, pair, value in (
        ([gave_up], [], ("e", "f"), None),
        ([gave_up, close], [], ("c", "d"), 1.99),
        ([gave_up], [near, nearer], ("g", "h"), 1.75),
        ([close], [nearer], ("g", "h"), 1.75),
    ):
        found = _proof(2.0, proofs, refuted, [], "")
        assert found.worst_pair == pair
        assert found.value == (value and pytest.approx(value))


@pytest.mark.parametrize(("in_mm", "wording"), [(True, "s: (1.000 +- 0.100, "), (False, "s: (57.296 +- 5.730, ")])
def test_a_box_is_reported_in_the_unit_of_its_variables(in_mm: bool, wording: str) -> None:
    """A rod that turns about itself has three angles, as a handle has three positions."""
    space = cast(Any, SimpleNamespace(name="s", in_mm=in_mm))
    assert _described(space, np.ones(3), np.full(3, 0.1)).startswith(wording)
