"""Springs across pairs of rods: no bound or proof exceeds what dense sampling of positions and turns of rods finds."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from delta_cad.assembly.machine import Assembly
from delta_cad.assembly.tessellation import MeshLibrary
from delta_cad.checks.clearance.bodies import DistanceEngine
from delta_cad.checks.clearance.branch_and_bound import prove
from delta_cad.checks.clearance.joint_ranges import joint_ranges
from delta_cad.checks.clearance.pairing import clearance_pairs, spaces_of
from delta_cad.checks.links import free_tilt, free_turn, sway_of, turn_about_x
from delta_cad.checks.outline.envelope import DIRECTIONS, swept_outline
from delta_cad.mechanism.placement import LINKS, spring_sway
from delta_cad.solids.part import Occurrence
from tests.delta_cad.checks.machines import GEOMETRY, LIMITS, WIDTH, at, ball, box, machine, part, placement, rod

EYE, ASIDE, HALF = 0.8, 5.5, 20.0
CALLS = 3000
PLACEMENT = replace(placement(), springs_mm=((30.0, -ASIDE), (80.0, ASIDE)), eye_inside_mm=EYE)
MACHINE = replace(machine(), placement=PLACEMENT)
TILT = free_tilt(MACHINE)
DOMAINS = joint_ranges(GEOMETRY, LIMITS.centre_mm, LIMITS.half_side_mm)
SWAY = sway_of(PLACEMENT, TILT)


def surface(rng: np.random.Generator, count: int) -> np.ndarray:
    u = rng.uniform(-1, 1, (count, 3)) * rng.choice([1.0, 1.0, 50.0], (count, 3))
    return LIMITS.centre_mm + LIMITS.half_side_mm * np.clip(u, -1.0, 1.0)


def eyes(rng: np.random.Generator, i: int, k: int, p: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Eyes of a spring, its rods turned about themselves at random, each as far as its joints let it."""
    x, z = PLACEMENT.springs_mm[k]
    found = []
    for j in range(2):
        frame = PLACEMENT(p)[f"rod_{i}_{j}"]
        lean = np.arccos(np.clip(frame[:, :3, 1] @ GEOMETRY.tangential[i], -1.0, 1.0))
        share = rng.choice([-1.0, 0.0, 1.0], len(p)) * rng.uniform(0.0, 1.0, len(p)) ** 0.2
        turned = frame @ turn_about_x(share * free_turn(TILT, lean))
        found.append((turned @ np.array([x, EYE * (1 - 2 * j), z, 1.0]))[:, :3])
    return found[0], found[1]


def on_spring(rng: np.random.Generator, link: str, p: np.ndarray, along_mm: float) -> np.ndarray:
    """(n, 3) places on a spring's axis, so far from its middle."""
    one, other = eyes(rng, int(link[7]), int(link[9]), p)
    way = other - one
    return (one + other) / 2.0 + along_mm * way / np.linalg.norm(way, axis=1, keepdims=True)


def test_the_links_of_springs_are_where_their_eyes_are() -> None:
    p = surface(np.random.default_rng(1), 50)
    links = PLACEMENT(p)
    for i, (k, (x, z)) in ((i, spring) for i in range(3) for spring in enumerate(PLACEMENT.springs_mm)):
        ends = [(links[f"rod_{i}_{j}"] @ np.array([x, EYE * (1 - 2 * j), z, 1.0]))[:, :3] for j in range(2)]
        frame = links[f"spring_{i}_{k}"]
        np.testing.assert_allclose(frame[:, :3, 3], (ends[0] + ends[1]) / 2.0, atol=1e-10)
        length = np.linalg.norm(ends[1] - ends[0], axis=1, keepdims=True)
        np.testing.assert_allclose(frame[:, :3, 1], (ends[1] - ends[0]) / length, atol=1e-12)
        np.testing.assert_allclose(frame[:, :3, 2], links[f"rod_{i}_0"][:, :3, 2], atol=1e-12)
        np.testing.assert_allclose(np.linalg.det(frame[:, :3, :3]), 1.0)


def test_no_turn_of_the_rods_takes_a_spring_farther_than_it_may_sway() -> None:
    rng, worst = np.random.default_rng(2), np.zeros(3)
    p = surface(rng, 20_000)
    links = PLACEMENT(p)
    for i, k in ((0, 0), (1, 1), (2, 0)):
        one, other = eyes(rng, i, k, p)
        strays = (one + other) / 2.0 - links[f"spring_{i}_{k}"][:, :3, 3]
        along = strays @ GEOMETRY.tangential[i]
        across = np.linalg.norm(strays - along[:, None] * GEOMETRY.tangential[i], axis=1)
        way = (other - one) / np.linalg.norm(other - one, axis=1, keepdims=True)
        turn = np.arccos(np.clip(way @ GEOMETRY.tangential[i], -1.0, 1.0))
        worst = np.maximum(worst, [np.abs(along).max(), across.max(), turn.max()])
    allowed = np.array([SWAY.along_mm, SWAY.across_mm, SWAY.turn_rad])
    assert (worst <= allowed).all()
    assert (worst > 0.6 * allowed).all()


def test_springs_on_rods_that_neither_lean_nor_turn_stay_in_line() -> None:
    still = spring_sway(WIDTH, EYE, ASIDE, 1e-6)
    assert (still.along_mm, still.across_mm, still.turn_rad) == pytest.approx((0.0, 0.0, 0.0), abs=2e-5)
    # eyes on the axes of rods that only lean: the spring is as parallel to the shoulder axis as they are apart along it
    assert spring_sway(WIDTH, 0.0, 0.0, 0.5).turn_rad == 0.0


def random_pair(rng: np.random.Generator, one: str, other: str) -> tuple[Assembly, float]:
    """A ball on a spring's axis and one elsewhere, beside where the first comes; the least distance that is found."""
    radii, p = 0.5 * rng.uniform(1.0, 3.0, 2), np.concatenate([LIMITS.corners_mm, surface(rng, 2000)])
    frame = PLACEMENT(p)[other]
    for _ in range(200):
        along = rng.uniform(-HALF, HALF)
        place = on_spring(rng, one, p, along)
        k, way = rng.integers(len(p)), rng.normal(size=3)
        adjacent = place[k] + way / np.linalg.norm(way) * rng.uniform(12.0, 20.0)
        there = frame[k, :3, :3].T @ (adjacent - frame[k, :3, 3])
        if other.startswith("spring"):
            there = np.array([0.0, rng.uniform(-HALF, HALF), 0.0])
            places = on_spring(rng, other, p, float(there[1]))
        else:
            places = frame[:, :3, :3] @ there + frame[:, :3, 3]
        least = float(np.linalg.norm(place - places, axis=1).min() - radii.sum())
        if least > 8.0:
            break
    else:
        pytest.fail("no place that the spring leaves free")
    placed = (
        Occurrence("ball_0", part("ball_0", ball(radii[0])), one, at(0.0, along, 0.0)),
        Occurrence("ball_1", part("ball_1", ball(radii[1])), other, at(*there)),
    )
    return replace(MACHINE, occurrences=placed, fits=()), least


def proven(a: Assembly, clearance_mm: float) -> bool:
    limits = replace(LIMITS, clearance_min_mm=clearance_mm)
    pairs, engine = clearance_pairs(a, limits, MeshLibrary(a.parts, 0.02, 0.2)), DistanceEngine()
    return not any(prove(s, engine, CALLS).undecided for s in spaces_of(pairs, a.placement, DOMAINS, limits, TILT))


@pytest.mark.quick(3)
@pytest.mark.parametrize(
    ("one", "other"),
    [
        ("spring_0_0", "platform"),
        ("spring_2_1", "platform"),
        ("spring_1_0", "upper_arm_1"),
        ("spring_1_1", "upper_arm_2"),
        ("spring_2_0", "base"),
        ("spring_0_1", "rod_1_0"),
        ("spring_0_1", "spring_2_1"),
    ],
)
def test_no_proof_exceeds_what_sampled_springs_find(one: str, other: str) -> None:
    """A limit above a distance that occurs is never proven; one that is lower by what springs sway is."""
    a, least = random_pair(np.random.default_rng([LINKS.index(one), LINKS.index(other)]), one, other)
    assert not proven(a, least + 0.001)
    sway = SWAY.across_mm + SWAY.along_mm + HALF * SWAY.turn_rad
    both = 2 if other.startswith(("spring", "rod")) else 1  # a rod turns about itself, too
    assert proven(a, max(least - both * sway - 0.1 * least - 0.5, 0.01))


@pytest.mark.parametrize(("one", "other"), [("spring_0_0", "rod_0_1"), ("spring_1_1", "spring_1_0")])
def test_next_to_what_hangs_on_the_same_rods_a_spring_is_as_it_is_drawn(one: str, other: str) -> None:
    p, along, there = np.concatenate([LIMITS.corners_mm, surface(np.random.default_rng(3), 4000)]), 15.0, (30.0, 0, 0)
    places = [PLACEMENT(p)[link] @ np.array([*spot, 1.0]) for link, spot in ((one, (0.0, along, 0.0)), (other, there))]
    least = float(np.linalg.norm(places[0] - places[1], axis=1).min()) - 2.0
    placed = (
        Occurrence("ball_0", part("ball_0", ball(1.0)), one, at(0.0, along, 0.0)),
        Occurrence("ball_1", part("ball_1", ball(1.0)), other, at(*there)),
    )
    a = replace(MACHINE, occurrences=placed, fits=())
    assert not proven(a, least + 0.001)
    assert proven(a, least - 0.5)


def test_a_spring_next_to_the_thin_end_of_a_long_part_is_not_taken_for_in_it() -> None:
    """A head that is not round on a long spigot: the hull of both, at every turn of the rod, would hold the ball."""
    pin = box((-2, -12, -12), (4, 12, 12)).fuse(rod(2.0, (4, 0, 0), (56, 0, 0)))
    links = PLACEMENT(np.concatenate([LIMITS.corners_mm, surface(np.random.default_rng(5), 4000)]))
    seen = np.linalg.inv(links["rod_0_0"]) @ links["spring_0_0"] @ [0.0, -HALF, 0.0, 1.0]
    least = float(np.hypot(seen[:, 1], seen[:, 2]).min()) - 2.0 - 1.0
    placed = (
        Occurrence("pin", part("pin", pin), "rod_0_0", np.eye(4)),
        Occurrence("ball", part("ball", ball(1.0)), "spring_0_0", at(0.0, -HALF, 0.0)),
    )
    a = replace(MACHINE, occurrences=placed, fits=())
    assert proven(a, least - 0.3)
    assert not proven(a, least + 0.001)


@pytest.mark.parametrize("k", [0, 1])
def test_the_outline_holds_springs_wherever_they_sway(k: int) -> None:
    rng, along = np.random.default_rng(4), HALF
    spring = Occurrence("ball_0", part("ball_0", ball(1.5)), f"spring_1_{k}", at(0.0, along, 0.0))
    a = replace(MACHINE, occurrences=(spring,), fits=())
    bound = swept_outline(a, LIMITS, MeshLibrary(a.parts, 0.02, 0.2)).reach_mm
    p = np.concatenate([LIMITS.corners_mm, surface(rng, 20_000)])
    found = (on_spring(rng, f"spring_1_{k}", p, along) @ DIRECTIONS.T).max(axis=0) + 1.5
    assert (found <= bound).all()
    assert (bound <= found + 2.0 * (SWAY.across_mm + SWAY.along_mm + HALF * SWAY.turn_rad) + 0.1).all()
