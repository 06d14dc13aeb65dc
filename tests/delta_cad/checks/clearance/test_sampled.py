"""What the sampling leaves away must be farther than what it looks for."""

import numpy as np
import pytest

from delta_cad.assembly.tessellation import MeshLibrary
from delta_cad.checks.clearance.bodies import DistanceEngine
from delta_cad.checks.clearance.pairing import by_several_joints, clearance_pairs
from delta_cad.checks.clearance.sampled import TOLERANCE_MM, Sampler
from tests.delta_cad.checks.machines import LIMITS, machine


def test_what_of_the_platform_is_near_a_ball_keeps_every_distance_below_the_bound() -> None:
    assembly, engine = machine(), DistanceEngine()
    sampler = Sampler(assembly.placement, LIMITS.clearance_poses_mm()[::40], engine)
    pairs = [
        p
        for p in clearance_pairs(assembly, LIMITS, MeshLibrary(assembly.parts, 0.2, 0.6))
        if "platform" in (p.a.link, p.b.link) and any(b.link.startswith("rod") for b in (p.a, p.b))
    ]
    smaller, below = 0, 0
    for pair in pairs:
        relative = np.linalg.inv(sampler.frames[pair.a.link]) @ sampler.frames[pair.b.link]
        whole = [engine.distance(pair.a, pair.b, pair.a.placement, r @ pair.b.placement) for r in relative]
        for best in (3.0, 12.0):
            local = sampler._near_the_wrist(pair, best)
            if local is None:
                assert min(whole) >= best
                continue
            one, other = local
            smaller += one is not pair.a or other is not pair.b
            for d, r in zip(whole, relative, strict=True):
                if d < best:
                    below += 1
                    assert abs(engine.distance(one, other, one.placement, r @ other.placement) - d) < 1e-6
        assert sampler._near_the_wrist(pair, np.inf) == (pair.a, pair.b)
    assert smaller
    assert below


def test_the_least_at_each_position_is_that_of_measuring_everything() -> None:
    assembly, engine, tilt = machine(), DistanceEngine(), 0.2
    positions = LIMITS.slices_mm(2)[::2].reshape(-1, 3)
    sampler = Sampler(assembly.placement, positions, engine, tilt)
    meshes = MeshLibrary(assembly.parts, 0.2, 0.6)
    pairs = [p for p in clearance_pairs(assembly, LIMITS, meshes) if by_several_joints(p, assembly.placement)]
    frames, least = sampler.frames, np.full(len(positions), np.inf)
    for k in range(len(sampler.poses_mm)):
        for p in pairs:
            if k < len(positions) or any(b.link.startswith("rod") for b in (p.a, p.b)):
                d = engine.distance(p.a, p.b, *(frames[b.link][k] @ b.placement for b in (p.a, p.b)))
                least[k % len(positions)] = min(d, least[k % len(positions)])
    before = engine.calls
    found = sampler.least(pairs)
    assert [one.distance_mm for one in found] == [pytest.approx(d, abs=TOLERANCE_MM) for d in least]
    assert [one.pose % len(positions) for one in found] == list(range(len(positions)))
    assert engine.calls - before < before / 5
    for one in found:
        a, b = one.pair.a, one.pair.b
        again = engine.distance(a, b, *(frames[x.link][one.pose] @ x.placement for x in (a, b)))
        assert again == pytest.approx(one.distance_mm, abs=1e-6)


def test_the_smallest_of_all_is_found_in_whichever_order_the_pairs_come() -> None:
    assembly, meshes = machine(), MeshLibrary(machine().parts, 0.2, 0.6)
    pairs = [p for p in clearance_pairs(assembly, LIMITS, meshes) if not p.running_gap]
    sampler = Sampler(assembly.placement, LIMITS.clearance_poses_mm()[::20], DistanceEngine(), 0.2)
    found = sampler.closest(pairs)
    for order in (pairs, pairs[::-1]):
        assert sampler.closest(order, is_sorted=True)[0].distance_mm == pytest.approx(
            found[0].distance_mm, abs=TOLERANCE_MM
        )


def test_several_joints_move_what_no_single_one_decides() -> None:
    assembly = machine()
    pairs = clearance_pairs(assembly, LIMITS, MeshLibrary(assembly.parts, 0.2, 0.6))
    found: dict[bool, set[frozenset[str]]] = {True: set(), False: set()}
    for p in pairs:
        found[by_several_joints(p, assembly.placement)].add(frozenset((p.a.link, p.b.link)))
    for links in (("base", "rod_0_1"), ("base", "platform"), ("rod_0_0", "rod_1_0"), ("upper_arm_0", "upper_arm_1")):
        assert frozenset(links) in found[True]
    assert {frozenset(("upper_arm_2", "platform")), frozenset(("pinion_0", "rod_0_1"))} <= found[True]
    for links in (("base", "upper_arm_0"), ("platform", "rod_0_0"), ("rod_0_0", "rod_0_1"), ("upper_arm_1", "rod_1_0")):
        assert frozenset(links) in found[False]
    assert not found[True] & found[False]
