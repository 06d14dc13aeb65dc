"""Rods that turn about themselves: no proof exceeds what dense sampling of positions and turns finds."""

from dataclasses import replace

import numpy as np
import pytest

from delta_cad.assembly.machine import Assembly
from delta_cad.assembly.tessellation import MeshLibrary, tessellate
from delta_cad.checks.clearance.bodies import DistanceEngine, body, is_round, spun, turned_hull
from delta_cad.checks.clearance.branch_and_bound import prove
from delta_cad.checks.clearance.joint_ranges import joint_ranges
from delta_cad.checks.clearance.pairing import _Moved, clearance_pairs, spaces_of
from delta_cad.checks.links import free_tilt, free_turn, turn_about_x
from delta_cad.mechanism.placement import LINKS
from delta_cad.solids.part import Occurrence
from tests.delta_cad.checks.machines import GEOMETRY, L_B, LIMITS, at, ball, box, check_clearance, machine, part, rod

MACHINE = machine()
DOMAINS = joint_ranges(GEOMETRY, LIMITS.centre_mm, LIMITS.half_side_mm)
TILT = np.radians(30.0)
SPOTS = {  # where a second ball is put: link -> centre and spread
    "base": ((60.0, 0.0, 10.0), 30.0),
    "upper_arm": ((78.0, 0.0, 0.0), 18.0),
    "rod": ((50.0, 0.0, 0.0), 25.0),
    "platform": ((30.0, 0.0, 0.0), 25.0),
}


def turned_positions(rng: np.random.Generator, link: str, p: np.ndarray) -> np.ndarray:
    """(n, 4, 4) frames of a rod at handle positions, turned at random as far as the sockets' tilt lets it.

    The tilt is that of the joints' own axes: the socket's y axis against the stud's, which the platform never turns.
    """
    joint = next(j for j in MACHINE.joints if j.link_b == link and j.link_a == "platform")
    frame, stud = MACHINE.placement(p)[link], joint.frame_a[:3, 1]
    lean = np.arccos(np.clip(frame[:, :3, 1] @ stud, -1.0, 1.0))
    largest = free_turn(TILT, lean)
    turned = frame @ turn_about_x(rng.choice([-1.0, 1.0], len(p)) * rng.uniform(0.0, 1.0, len(p)) ** 0.1 * largest)
    assert np.arccos(np.clip(turned[:, :3, 1] @ stud, -1.0, 1.0)).max() <= max(TILT, lean.max()) + 1e-9
    return turned


def surface(rng: np.random.Generator, count: int) -> np.ndarray:
    u = rng.uniform(-1, 1, (count, 3)) * rng.choice([1.0, 1.0, 50.0], (count, 3))
    return LIMITS.centre_mm + LIMITS.half_side_mm * np.clip(u, -1.0, 1.0)


def slack(distance_mm: float) -> float:
    """What a proof must reach where a distance occurs: angles of all three chains count for each."""
    return distance_mm - max(0.4, 0.1 * distance_mm)


def random_pair(rng: np.random.Generator, one: str, other: str) -> tuple[Assembly, float, float]:
    """A ball beside a rod's axis and one elsewhere; their least distance with turns, and without."""
    radii, p = 0.5 * rng.uniform(1.0, 3.0, 2), np.concatenate([LIMITS.corners_mm, surface(rng, 4000)])
    links = dict(MACHINE.placement(p))
    frames = {name: turned_positions(rng, name, p) if name.startswith("rod") else links[name] for name in (one, other)}
    for _ in range(500):
        x, angle = L_B - 6.0 if other == "platform" else 6.0, rng.uniform(0.0, 2.0 * np.pi)
        spot = np.array([x, 8.0 * np.cos(angle), 8.0 * np.sin(angle)])
        middle, spread = next(v for k, v in SPOTS.items() if other.startswith(k))
        there = np.asarray(middle) + rng.uniform(-spread, spread, 3)

        def least(of: dict[str, np.ndarray], spot: np.ndarray = spot, there: np.ndarray = there) -> float:
            world = [of[k][:, :3, :3] @ v + of[k][:, :3, 3] for k, v in ((one, spot), (other, there))]
            return float(np.linalg.norm(world[0] - world[1], axis=1).min() - radii.sum())

        turned, still = least(frames), least(links)
        near = other.startswith(("platform", "upper"))
        if (slack(still) > turned + 0.05 and 1.0 < turned < 8.0) if near else (still > turned + 0.3 and turned > 4.0):
            break
    else:
        pytest.fail("no turn that matters")
    placed = (
        Occurrence("ball_0", part("ball_0", ball(radii[0])), one, at(*spot)),
        Occurrence("ball_1", part("ball_1", ball(radii[1])), other, at(*there)),
    )
    return replace(MACHINE, occurrences=placed, fits=()), turned, still


def proven(a: Assembly, clearance_mm: float, tilt: float) -> bool:
    limits = replace(LIMITS, clearance_min_mm=clearance_mm)
    pairs, engine = clearance_pairs(a, limits, MeshLibrary(a.parts, 0.02, 0.2)), DistanceEngine()
    return not any(prove(s, engine, 6000).undecided for s in spaces_of(pairs, a.placement, DOMAINS, limits, tilt))


@pytest.mark.quick(3)
@pytest.mark.parametrize(
    ("one", "other", "loss"),
    [
        ("rod_0_0", "platform", 1.5),
        ("rod_1_1", "upper_arm_1", 1.5),
        ("rod_2_0", "base", 3.5),
        ("rod_0_1", "rod_1_0", 12.0),
    ],
)
@pytest.mark.parametrize("seed", [1, 2])
def test_no_proof_exceeds_what_sampled_turns_find(one: str, other: str, loss: float, seed: int) -> None:
    """Beside its own holder a rod's lean takes of the turn; elsewhere a convex body stands for all turns."""
    rng = np.random.default_rng([seed, LINKS.index(one), LINKS.index(other)])
    a, turned, still = random_pair(rng, one, other)
    assert free_tilt(a) == pytest.approx(TILT)
    assert not proven(a, turned + 0.001, TILT)
    if turned > loss:
        assert proven(a, turned - loss, TILT)
    if other.startswith(("platform", "upper")):
        assert proven(a, slack(still), 0.0)  # what leaving the turn away would let pass


def test_the_check_finds_what_only_a_turned_rod_hits() -> None:
    """A fin along the rod's z, and a post on the platform that it passes by unless the rod turns."""
    fin = part("fin", box((L_B - 12.0, -1.0, 0.0), (L_B - 8.0, 1.0, 12.0)))
    links = MACHINE.placement(LIMITS.centre_mm)
    frame = np.linalg.inv(links["platform"]) @ links["rod_0_0"] @ turn_about_x(np.array(-TILT * 0.9))
    post = part("post", ball(1.0))
    placed = (
        Occurrence("fin", fin, "rod_0_0", np.eye(4)),
        Occurrence("post", post, "platform", at(*(frame @ [L_B - 10.0, 2.5, 11.0, 1.0])[:3])),
    )
    small = replace(LIMITS, bottom_height_mm=LIMITS.centre_mm[2] - 0.5, half_side_mm=0.5, clearance_min_mm=1.0)
    a = replace(MACHINE, occurrences=placed, fits=())
    for joints, passes in ((a.joints, False), ((), True)):
        turning = replace(a, joints=joints)
        found = {r.name: r for r in check_clearance(turning, small, MeshLibrary(a.parts, 0.02, 0.2))}
        assert all(r.passed for r in found.values()) == passes
        assert found["clearance exact"].passed


def test_what_holds_a_body_at_every_turn_does() -> None:
    rng = np.random.default_rng(3)
    solids = [box((3, -1, 2), (9, 4, 5)), rod(2.5, (5, 0, 0), (40, 0, 0)), ball(3, (0, 2, 1)).cut(ball(2))]
    for k, solid in enumerate(solids):
        b = body("b", f"b{k}", "rod", tessellate(solid, 0.05, 0.35), at(*rng.uniform(-3, 3, 3)) if k != 1 else at())
        assert is_round(b) == (k == 1)
        for holder, turn in ((spun(b), np.pi), (turned_hull(b, 0.5), 0.5)):
            planes = hull_planes(holder.vertices) if turn < 1.0 else None
            for angle in rng.uniform(-turn, turn, 30):
                points = b.vertices @ turn_about_x(angle)[:3, :3].T
                if planes is not None:
                    assert (points @ planes[:, :3].T + planes[:, 3]).max() <= 1e-9
                else:
                    radius = np.hypot(points[:, 1], points[:, 2])
                    outline = np.hypot(holder.vertices[:, 1], holder.vertices[:, 2])
                    for x, r in zip(points[:, 0], radius, strict=True):
                        adjacent = np.abs(holder.vertices[:, 0] - x)
                        assert outline[adjacent <= adjacent.min() + 1e-6].max() >= r - 1e-9


def test_slices_hold_a_long_body_that_is_not_round_at_every_turn() -> None:
    solid = box((-4, -3, 2), (6, 9, 5)).fuse(rod(2.0, (5, 0, 3), (58, 0, 3)))
    b = body("b", "b", "rod_0_0", tessellate(solid, 0.05, 0.35), at(1.0, -2.0, 0.5))
    pieces = _Moved(()).turning(b, TILT)
    assert len(pieces) > 2
    planes = [hull_planes(one.vertices) for one in pieces]
    for angle in np.random.default_rng(3).uniform(-TILT, TILT, 30):
        points = b.mesh.triangles.reshape(-1, 3) @ b.placement[:3, :3].T + b.placement[:3, 3]
        points = points @ turn_about_x(angle)[:3, :3].T
        off = np.array([(points @ p[:, :3].T + p[:, 3]).max(axis=1) for p in planes]).min(axis=0)
        assert off.max() <= 1e-9


def hull_planes(points: np.ndarray) -> np.ndarray:
    from scipy.spatial import ConvexHull

    return ConvexHull(points).equations


def test_free_turn_ends_where_the_tilt_does() -> None:
    lean = np.radians([0.0, 12.0, 25.0, 30.0, 31.0])
    turn = free_turn(TILT, lean)
    assert turn[0] == pytest.approx(TILT)
    assert turn[3:] == pytest.approx([0.0, 0.0], abs=1e-7)
    assert np.cos(turn[:3]) * np.cos(lean[:3]) == pytest.approx(np.cos(TILT), abs=1e-12)
    assert free_tilt(replace(MACHINE, joints=())) == 0.0
