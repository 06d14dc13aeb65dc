"""The bounds on what happens in a box of handle positions, against the placement itself at points of many boxes."""

from dataclasses import replace
from itertools import product

import numpy as np
import pytest

from delta_cad.assembly.machine import Assembly
from delta_cad.assembly.tessellation import MeshLibrary
from delta_cad.checks.clearance import branch_and_bound
from delta_cad.checks.clearance.bodies import CollisionBody, DistanceEngine
from delta_cad.checks.clearance.branch_and_bound import BoxBounds, prove
from delta_cad.checks.clearance.configuration_spaces import Swing, TwoSwings
from delta_cad.checks.clearance.handle import Handle
from delta_cad.checks.clearance.joint_ranges import joint_ranges
from delta_cad.checks.clearance.pairing import clearance_pairs, spaces_of
from delta_cad.checks.clearance.rod_at_joint import RodAtJoint
from delta_cad.checks.links import free_tilt
from delta_cad.mechanism import inverse_kinematics
from delta_cad.solids.part import Occurrence
from tests.delta_cad.checks.machines import GEOMETRY, L_B, LIMITS, at, ball, box, machine, part, rod

DOMAINS = joint_ranges(GEOMETRY, LIMITS.centre_mm, LIMITS.half_side_mm)
END = part("end", box((L_B - 5.0, -3.0, -2.0), (L_B + 2.0, 3.0, 2.0)))
RNG = np.random.default_rng(11)
CUBE = LIMITS.centre_mm[None], np.full((1, 3), LIMITS.half_side_mm)


def handle_space(assembly: Assembly) -> Handle:
    pairs = clearance_pairs(assembly, LIMITS, MeshLibrary(assembly.parts, 0.2, 0.6))
    (space,) = [s for s in spaces_of(pairs, assembly.placement, DOMAINS, LIMITS, 0.0) if isinstance(s, Handle)]
    return space


def with_fins() -> Assembly:
    """The machine with a fin at each end of a rod: what is not round makes the rod's own turn a variable."""
    m = machine()
    fins = [part(f"fin_{x}", box((x, -1.0, 0.0), (x + 4.0, 1.0, 7.0))) for x in (8.0, L_B - 12.0)]
    placed = tuple(Occurrence(fin.number, fin, "rod_0_0", np.eye(4)) for fin in fins)
    return replace(m, occurrences=(*m.occurrences, *placed))


def random_boxes(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Boxes of many sizes and shapes inside the cube, the largest as large as the cube."""
    halves = LIMITS.half_side_mm * RNG.uniform(0.01, 1.0, (count, 3)) * RNG.uniform(0.02, 1.0, (count, 1)) ** 2
    return LIMITS.centre_mm + RNG.uniform(-1, 1, (count, 3)) * (LIMITS.half_side_mm - halves), halves


def inside(centres: np.ndarray, halves: np.ndarray) -> np.ndarray:
    """A position in each box: in corners, on edges and faces, within."""
    step = RNG.uniform(-1.0, 1.0, centres.shape)
    return centres + np.where(RNG.uniform(size=step.shape) < 0.7, np.sign(step), step) * halves


def test_shoulder_angles_stay_in_their_range_which_is_little_wider_than_it_must_be() -> None:
    space = handle_space(machine())
    for centres, halves in (random_boxes(40), CUBE):
        whole, low, high = space.angles(centres, halves)
        assert (low <= whole.theta).all()
        assert (whole.theta <= high).all()
        seen = np.stack([inverse_kinematics(GEOMETRY, inside(centres, halves) / 1000.0) for _ in range(400)])
        assert (seen >= low - 1e-12).all()
        assert (seen <= high + 1e-12).all()
        assert ((high - low) <= 1.25 * np.ptp(seen, axis=0) + np.radians(2.0)).all()


@pytest.mark.quick(1)
@pytest.mark.parametrize("ratio", [9.5, 1.0])
def test_no_two_points_come_closer_along_a_direction_than_the_bound_says(ratio: float) -> None:
    space = handle_space(machine(ratio))
    pairs, bodies = space.pairs, space.pairs.bodies
    kinds = [
        {bodies[i].link[:3], bodies[j].link[:3]}
        for i, j in zip(pairs.first.tolist(), pairs.second.tolist(), strict=True)
    ]
    picked = np.concatenate(
        [
            RNG.choice([k for k, kind in enumerate(kinds) if kind == wanted], 60)
            for wanted in ({"bas", "rod"}, {"upp", "rod"}, {"rod"}, {"upp", "pla"}, {"bas", "pla"})
        ]
    )
    centres, halves = random_boxes(len(picked))
    box = np.arange(len(picked))
    link = np.array([space.links.index(b.link) for b in bodies])
    first, second = pairs.first[picked], pairs.second[picked]
    points = [np.stack([RNG.choice(bodies[k].vertices, 30) for k in index]) for index in (first, second)]
    normal = RNG.normal(size=(len(picked), 3))
    normal[::3] = space.directions[RNG.integers(len(space.directions), size=len(normal[::3]))]  # where it is sharp
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    bound, isotropic = space.along(centres, halves)(box, picked, normal), space.motion(centres, halves)

    def placed(positions: np.ndarray) -> list[np.ndarray]:
        frames = space.frames(positions)
        return [
            x @ np.swapaxes(f[:, :3, :3], 1, 2) + f[:, None, :3, 3]
            for x, f in zip(points, (frames[box, link[first]], frames[box, link[second]]), strict=True)
        ]

    start = placed(centres)
    before = np.einsum("kni,ki->kn", start[1] - start[0], normal)
    worst = np.full(len(picked), -np.inf)
    for _ in range(300):
        positions = inside(centres, halves)
        now = placed(positions)
        worst = np.maximum(worst, (before - np.einsum("kni,ki->kn", now[1] - now[0], normal)).max(axis=1))
        shift = (positions - centres)[:, None]
        for seen_from, travel in zip((0.0, 1.0), isotropic, strict=True):
            for k, index in enumerate((first, second)):
                gone = np.linalg.norm(now[k] - start[k] - seen_from * shift, axis=2).max(axis=1)
                assert (gone <= travel[box, index] + 1e-6).all()
    assert (worst <= bound + 1e-6).all()
    moving = bound > 0.1
    assert np.median(worst[moving] / bound[moving]) > 0.4  # a bound far above the truth passes, and stalls the proof
    assert (worst[moving] / bound[moving]).max() > 0.95
    least = np.min([m[box, first] + m[box, second] for m in isotropic], axis=0)
    assert np.median(bound[moving] / least[moving]) < 0.8  # what a direction is for


def test_every_space_bounds_the_fall_of_a_gap_of_hulls() -> None:
    assembly = with_fins()
    pairs = clearance_pairs(assembly, LIMITS, MeshLibrary(assembly.parts, 0.2, 0.6))
    sharper: dict[str, float] = {}
    for space in spaces_of(pairs, assembly.placement, DOMAINS, LIMITS, free_tilt(assembly)):
        bounds, pair = BoxBounds(space), RNG.integers(len(space.pairs.limit), size=40)
        middle, half = space.root()
        halves = np.repeat(half, 40, axis=0) * RNG.uniform(0.02, 0.4, (40, 1))
        centres = middle + RNG.uniform(-1, 1, halves.shape) * (half - halves)
        normal = RNG.normal(size=(40, 3))
        normal /= np.linalg.norm(normal, axis=1)[:, None]
        fall, falls = space.along(centres, halves)(np.arange(40), pair, normal), space.falls(centres, halves)
        a, b, k = space.pairs.first[pair], space.pairs.second[pair], np.arange(40)
        gaps = []
        for n in range(30):
            frames = space.frames(inside(centres, halves) if n else centres)[:, bounds.link]
            gaps.append(bounds.hulls_gap(a, b, normal, frames[k, a], frames[k, b]))
        truth = gaps[0] - np.min(gaps, axis=0)
        assert (truth <= fall + 1e-6).all(), space.name
        if falls:
            frames = space.frames(centres)[:, bounds.link]
            own = gaps[0] - bounds.hulls_gap(a, b, normal, frames[k, a], frames[k, b], falls)
            assert (truth <= own + 1e-6).all(), space.name
            moving = fall > 0.1
            sharper[space.name] = float(np.median(np.minimum(own, fall)[moving] / fall[moving]))
    assert (
        len(sharper) == 11
    )  # one swing and two, rods at both ends, as they are and turning, at what is round, the handle
    assert np.median(list(sharper.values())) < 0.95  # in boxes this large what bends a path counts most


@pytest.mark.parametrize("kind", [Swing, TwoSwings, RodAtJoint, Handle])
def test_no_corner_comes_forward_farther_than_it_is_reported_and_one_comes_nearly_as_far(kind: type) -> None:
    assembly = with_fins()
    pairs = clearance_pairs(assembly, LIMITS, MeshLibrary(assembly.parts, 0.2, 0.6))
    spaces = spaces_of(pairs, assembly.placement, DOMAINS, LIMITS, free_tilt(assembly))
    for space in (s for s in spaces if type(s) is kind):
        bounds, (middle, half), count = BoxBounds(space), space.root(), 80
        halves = half * RNG.uniform(0.02, 0.15, (count, 1)) * RNG.uniform(0.3, 1.0, (count, half.shape[1]))
        centres = middle + RNG.uniform(-1, 1, halves.shape) * (half - halves)
        normal = RNG.normal(size=(count, 3))
        normal /= np.linalg.norm(normal, axis=1)[:, None]
        falls, each = space.falls(centres, halves), np.arange(count)
        assert falls is not None
        corners = [centres + np.array(way) * halves for way in product((-1.0, 1.0), repeat=half.shape[1])]
        tried = [centres, *corners, *(inside(centres, halves) for _ in range(40))]
        frames = [space.frames(variables) for variables in tried]
        for k in np.unique(np.concatenate([space.pairs.first, space.pairs.second])).tolist():
            points = bounds.hull(k)
            stray = RNG.normal(size=points.shape)
            stray *= space.pairs.bodies[k].mesh.deviation_mm / np.linalg.norm(stray, axis=1)[:, None]
            heights = []
            for placed in frames:
                frame = placed[:, bounds.link[k]]
                along = np.einsum("nji,nj->ni", frame[:, :3, :3], normal)  # the direction in the body's own frame
                heights.append(along @ (points + stray).T + (frame[:, :3, 3] * normal).sum(axis=1)[:, None])
            frame = frames[0][:, bounds.link[k]]
            reported, gone = falls(k, each, normal, frame, points), heights[0] - np.min(heights, axis=0)
            assert (gone <= reported + 1e-9).all()
            if gone.max() > 0.1:
                moving = gone > 0.05
                assert np.median(gone[moving] / reported[moving]) > 0.6


def straying(b: CollisionBody, deviation_mm: float) -> CollisionBody:
    return replace(b, mesh=replace(b.mesh, deviation_mm=deviation_mm))


def next_to_a_rod(distance_mm: float, deviation_mm: float = 0.05) -> bool:
    """Whether a rod is proven clear of a ball on the base that is so far from it at one corner, farther elsewhere."""
    m = machine()
    seen = m.placement(inside(*[np.repeat(x, 3000, axis=0) for x in CUBE]))["rod_0_1"]
    in_corners = m.placement(LIMITS.corners_mm)["rod_0_1"]
    tried = product(in_corners, (0.5, 0.7, 0.85), np.linspace(0.0, 2.0 * np.pi, 36, endpoint=False))
    for frame, where, angle in tried:  # round the rod until the corner is the closest
        across = np.cos(angle) * frame[:3, 1] + np.sin(angle) * frame[:3, 2]
        middle = frame[:3, 3] + frame[:3, 0] * L_B * where + across * (5.5 + distance_mm)
        away = middle - seen[:, :3, 3]
        share = np.clip((away * seen[:, :3, 0]).sum(axis=1), 12.0, L_B - 12.0)
        if np.linalg.norm(away - share[:, None] * seen[:, :3, 0], axis=1).min() > 5.5 + distance_mm - 0.01:
            break
    else:
        pytest.fail("the rod passes on every side")
    tube, post = part("tube", rod(2.5, (12, 0, 0), (L_B - 12.0, 0, 0))), part("post", ball(3))
    placed = (Occurrence("tube", tube, "rod_0_1", np.eye(4)), Occurrence("post", post, "base", at(*middle)))
    a = replace(m, occurrences=placed, joints=(), fits=())
    pairs = clearance_pairs(a, LIMITS, MeshLibrary(a.parts, 0.05, 0.3))
    pairs = [replace(p, a=straying(p.a, deviation_mm), b=straying(p.b, deviation_mm)) for p in pairs]
    (space,) = spaces_of(pairs, a.placement, DOMAINS, LIMITS, 0.0)
    return not prove(space, DistanceEngine()).undecided


@pytest.mark.slow
@pytest.mark.parametrize("hope", [branch_and_bound.HOPE, 0.0, np.inf])
def test_what_comes_too_close_in_one_corner_is_refused_and_what_does_not_is_proven(
    monkeypatch: pytest.MonkeyPatch, hope: float
) -> None:
    """Whether no distance is put off or each that may be."""
    monkeypatch.setattr(branch_and_bound, "HOPE", hope)
    assert not next_to_a_rod(0.9)
    assert next_to_a_rod(1.3)
    assert not next_to_a_rod(1.3, deviation_mm=0.2)  # both may stray so far towards each other


def test_a_bound_that_is_too_small_would_be_noticed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Handle, "along", lambda *_: lambda box, *_: np.zeros(len(box)))
    assert next_to_a_rod(0.9)


def test_a_travel_that_is_not_a_number_proves_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Handle, "along", lambda *_: lambda box, *_: np.full(len(box), np.nan))
    assert not next_to_a_rod(0.9)


def test_bodies_about_two_wrists_never_come_closer_than_the_balls_that_hold_them() -> None:
    m = machine()
    ends = [Occurrence(f"end_{i}_{j}", END, f"rod_{i}_{j}", np.eye(4)) for i, j in product(range(3), range(2))]
    space = handle_space(replace(m, occurrences=(*m.occurrences, *ends)))
    pairs, always, engine = space.pairs, space.always_apart(), DistanceEngine()
    bodies = [(pairs.bodies[a], pairs.bodies[b]) for a, b in zip(pairs.first, pairs.second, strict=True)]
    wrists = [k for k, two in enumerate(bodies) if all(b.name.startswith("end") for b in two)]
    assert (always[wrists] > 0.0).any()
    for frames in space.frames(inside(*random_boxes(30))):
        for k in wrists:
            a, b = bodies[k]
            placed = [frames[space.links.index(x.link)] @ x.placement for x in (a, b)]
            assert engine.distance(a, b, *placed) >= always[k] - 1e-9


def at_two_wrists(margin_mm: float) -> Handle:
    """Two rods' ends, a ball and a spigot each, on neighbouring chains: the balls have so much more than they keep."""
    m, small = machine(), replace(LIMITS, half_side_mm=20.0, bottom_height_mm=LIMITS.centre_mm[2] - 20.0)
    end = part("end", ball(6.0, (L_B, 0, 0)).fuse(rod(2.5, (L_B - 45.0, 0, 0), (L_B, 0, 0))))
    placed = tuple(Occurrence(f"end_{link}", end, link, np.eye(4)) for link in ("rod_0_1", "rod_1_0"))
    frames = m.placement(LIMITS.centre_mm)
    apart = float(np.linalg.norm((frames["rod_0_1"] - frames["rod_1_0"]) @ [L_B, 0.0, 0.0, 1.0])) - 12.0
    small = replace(small, clearance_min_mm=apart - margin_mm)
    pairs = clearance_pairs(replace(m, occurrences=placed, joints=(), fits=()), small, MeshLibrary((end,), 0.02, 0.2))
    domains = joint_ranges(GEOMETRY, small.centre_mm, small.half_side_mm)
    (space,) = spaces_of(pairs, m.placement, domains, small, 0.0)
    assert isinstance(space, Handle)
    return space


def test_what_is_far_from_a_wrist_does_not_count_for_what_is_near_it() -> None:
    """Balls about their wrists stay as they are; whole bodies, whose spigots swing, take 4 600 distances."""
    found = prove(at_two_wrists(0.7), DistanceEngine(), 400)
    assert (found.undecided, found.calls > 0) == ([], True)
    assert prove(at_two_wrists(-0.01), DistanceEngine(), 400).undecided


def test_the_pieces_at_two_wrists_are_as_near_as_the_bodies() -> None:
    whole, engine = at_two_wrists(0.7), DistanceEngine()
    pieces = whole.in_pieces(np.array([True]))
    assert len(pieces.pairs.limit) > 4
    for frames in whole.frames(inside(*[np.repeat(x, 5, axis=0) for x in whole.root()])):

        def least(space: Handle, frames: np.ndarray = frames) -> float:
            p, at_link = space.pairs, dict(zip(whole.links, frames, strict=True))
            held = [(p.bodies[i], p.bodies[j]) for i, j in zip(p.first, p.second, strict=True)]
            return min(
                engine.distance(a, b, at_link[a.link] @ a.placement, at_link[b.link] @ b.placement) for a, b in held
            )

        assert least(pieces) == pytest.approx(least(whole), abs=1e-9)
