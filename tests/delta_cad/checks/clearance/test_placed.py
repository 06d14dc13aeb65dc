"""Equal chains in places of their own: each pair is taken where it stands, against distances over a dense search.

The oracle places bodies by angles and vectors alone, about a cube of its own, and measures by trimesh.
"""

from __future__ import annotations

from itertools import product

import numpy as np
import pytest
import trimesh

from delta_cad.assembly.machine import Assembly
from delta_cad.assembly.tessellation import MeshLibrary
from delta_cad.checks.clearance.bodies import DistanceEngine
from delta_cad.checks.clearance.branch_and_bound import prove
from delta_cad.checks.clearance.joint_ranges import joint_ranges
from delta_cad.checks.clearance.pairing import clearance_pairs, spaces_of
from delta_cad.checks.clearance.sampled import Sampler
from delta_cad.mechanism import inverse_kinematics
from delta_cad.solids.part import Occurrence, Part
from tests.delta_cad.checks.machines import (
    L_A,
    L_B,
    PINION,
    PLACED,
    PLACED_LIMITS,
    RADIUS_PLATFORM,
    WIDTH,
    R,
    at,
    ball,
    box,
    machine,
    part,
    placement,
    rod,
)

AZIMUTHS = np.radians([0.0, 116.0, -116.0])
RADII = R, R + 6.0, R + 6.0
MIDDLE, HALF = np.array([6.0, 0.0, 94.0]), 33.0
DOMAINS = joint_ranges(PLACED, PLACED_LIMITS.centre_mm, PLACED_LIMITS.half_side_mm)
AHEAD = part("ahead", box((15, 0, -3), (45, 70, 3)))
BEHIND = part("behind", box((20, -65, -2), (40, 0, 5)))
POST = part("post", box((50, -20, -15), (60, 20, 10)))
ROOF = part("roof", box((60, -6, 75), (80, 6, 85)))
TUBE, KNOB = part("tube", rod(2.5, (12, 0, 0), (L_B - 12, 0, 0))), part("knob", ball(4))
WRIST = at(RADIUS_PLATFORM, 9.0, -8.0)


def place_of(i: int, out_mm: float) -> np.ndarray:
    """Frame at the azimuth of a chain, moved out by so much."""
    c, s = np.cos(AZIMUTHS[i]), np.sin(AZIMUTHS[i])
    return np.array([[c, -s, 0.0, c * out_mm], [s, c, 0.0, s * out_mm], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]])


def link_frame(link: str, p: np.ndarray) -> np.ndarray:
    """Frame of a link with the handle at p, mm."""
    kind, _, number = link.partition("_")
    if kind == "base":
        return np.eye(4)
    if kind == "platform":
        return at(*p)
    i = int(number.split("_")[-1] if kind == "upper" else number[0])
    if kind == "pinion":  # as a body of revolution
        return place_of(i, RADII[i] - R) @ at(PINION[0], 0.0, PINION[1])
    angle = float(inverse_kinematics(PLACED, p / 1000.0)[i])
    c, s = np.cos(angle), np.sin(angle)
    arm = place_of(i, RADII[i]) @ np.array([[c, 0, -s, 0], [0, 1, 0, 0], [s, 0, c, 0], [0, 0, 0, 1]])
    if kind == "upper":
        return arm
    across = place_of(i, 0.0)[:3, 1]
    aside = (int(number[-1]) - 0.5) * WIDTH * across
    elbow = (arm @ [L_A, 0.0, 0.0, 1.0])[:3]
    along = p + (place_of(i, RADIUS_PLATFORM))[:3, 3] - elbow
    along = along / np.linalg.norm(along)
    y = across - (across @ along) * along
    y = y / np.linalg.norm(y)
    frame = at(*(elbow + aside))
    frame[:3, :3] = np.stack([along, y, np.cross(along, y)], axis=1)
    return frame


def least_mm(a: Occurrence, b: Occurrence, meshes: MeshLibrary) -> float:
    """Least distance over the cube: a grid, then steps that halve around its three best positions."""
    manager = trimesh.collision.CollisionManager()
    for o in (a, b):
        mesh = meshes[o.part.number]
        manager.add_object(o.name, trimesh.Trimesh(mesh.vertices, mesh.faces, process=False))

    def apart(p: np.ndarray) -> float:
        for o in (a, b):
            manager.set_transform(o.name, link_frame(o.link, p) @ o.placement)
        return float(manager.min_distance_internal())

    grid = MIDDLE + HALF * np.array([*product(np.linspace(-1.0, 1.0, 7), repeat=3)])
    found = np.array([apart(p) for p in grid])
    best = float(found.min())
    around = np.array([*product((-1.0, 0.0, 1.0), repeat=3)])
    for k in np.argsort(found)[:3]:
        p, step = grid[k], HALF / 6.0
        for _ in range(9):
            near = np.clip(p + step * around, MIDDLE - HALF, MIDDLE + HALF)
            seen = [apart(q) for q in near]
            p, best, step = near[int(np.argmin(seen))], min(best, *seen), step / 2.0
    return best


def proven(a: Assembly, meshes: MeshLibrary, clearance_mm: float) -> bool:
    limits = type(PLACED_LIMITS)(**{**vars(PLACED_LIMITS), "clearance_min_mm": clearance_mm})
    spaces = spaces_of(clearance_pairs(a, limits, meshes), a.placement, DOMAINS, limits, 0.0)
    return not any(prove(space, DistanceEngine(), 4000).undecided for space in spaces)


BAR = part("bar", box((10, -4, -4), (80, 4, 4)))
Body = tuple[Part, str, np.ndarray]


def above(i: int) -> tuple[Body, Body]:
    """What stands over an arm, which that of another chain would meet."""
    return (ROOF, "base", place_of(i, RADII[i] - R + 20.0)), (BAR, f"upper_arm_{i}", np.eye(4))


def arms(i: int, j: int) -> tuple[Body, Body]:
    """Wings of two arms towards each other."""
    return (AHEAD, f"upper_arm_{i}", np.eye(4)), (BEHIND, f"upper_arm_{j}", np.eye(4))


def near(j: int, i: int) -> tuple[Body, Body]:
    """What stands with a chain, and the wing of another's arm towards it."""
    wing = BEHIND if (j + 1) % 3 == i else AHEAD
    return (POST, "base", place_of(j, RADII[j] - R)), (wing, f"upper_arm_{i}", np.eye(4))


def at_wrist(k: int, i: int, side: int) -> tuple[Body, Body]:
    """What the platform carries beside a wrist, and a rod."""
    return (KNOB, "platform", place_of(k, 0.0) @ WRIST), (TUBE, f"rod_{i}_{side}", np.eye(4))


def rods(i: int, j: int) -> tuple[Body, Body]:
    """Neighbouring rods of two chains."""
    return (TUBE, f"rod_{i}_1", np.eye(4)), (TUBE, f"rod_{j}_0", np.eye(4))


PAIRS: dict[str, tuple[Body, Body]] = {
    "above arm 0": above(0),
    "arms 1 and 2": arms(1, 2),
    "chain 1 beside arm 2": near(1, 2),
    "wrist 2 beside rod 0": at_wrist(2, 0, 0),
    "above arm 1": above(1),
    "arms 0 and 1": arms(0, 1),
    "arms 2 and 0": arms(2, 0),
    **{f"chain {j} beside arm {i}": near(j, i) for j, i in ((0, 1), (1, 0), (2, 1), (0, 2), (2, 0))},
    **{f"wrist {k} beside rod {i}": at_wrist(k, i, s) for k, i, s in ((0, 0, 1), (1, 1, 1), (0, 1, 0), (1, 2, 0))},
    **{f"rods {i} and {(i + 1) % 3}": rods(i, (i + 1) % 3) for i in range(3)},
}


@pytest.mark.quick(4)
@pytest.mark.parametrize("case", PAIRS)
def test_the_proof_finds_the_clearance_that_a_dense_search_does(case: str) -> None:
    """Its limit lies within 0.2 mm of what the search finds, beside what meshes are off."""
    first, second = (Occurrence(name, *o) for name, o in zip(("one", "other"), PAIRS[case], strict=True))
    a = Assembly("test", (first, second), (), (), placement(9.5, PLACED), MIDDLE)
    meshes = MeshLibrary(a.parts, 0.01, 0.2)
    found = least_mm(first, second, meshes)
    off = sum(meshes[o.part.number].deviation_mm for o in (first, second))
    assert found > 3.0
    assert proven(a, meshes, found - off - 0.2)
    assert not proven(a, meshes, found + 0.05)
    sampler = Sampler(a.placement, PLACED_LIMITS.clearance_poses_mm(), DistanceEngine())
    (sample,) = sampler.closest(clearance_pairs(a, PLACED_LIMITS, meshes))
    assert found - 1e-3 < sample.distance_mm < found + 3.0


@pytest.mark.quick(1)
@pytest.mark.parametrize("ratio", [9.5, 1.0])
def test_every_pair_of_bodies_is_proven_at_its_own_places_and_angles(ratio: float) -> None:
    """Each is found among the spaces' pairs: the same parts, as they stand, at the angles that its own chains take."""
    assembly = machine(ratio, geometry=PLACED)
    meshes = MeshLibrary(assembly.parts, 0.2, 0.6)
    pairs = clearance_pairs(assembly, PLACED_LIMITS, meshes)
    spaces = spaces_of(pairs, assembly.placement, DOMAINS, PLACED_LIMITS, 0.0)
    arms = [s for s in spaces if s.name.startswith("two arms")]
    assert len(arms) == 3
    rng = np.random.default_rng(5)
    p = MIDDLE + HALF * rng.uniform(-1.0, 1.0, (3, 3))
    theta = inverse_kinematics(PLACED, p / 1000.0)
    swings = [s for s in spaces if s.name.startswith("an arm")]
    for pair in pairs:
        links = sorted((pair.a.link, pair.b.link))
        moving = [int(link[-1]) for link in links if link.startswith("upper_arm")]
        if links[1].startswith("upper_arm") and links[0].startswith(("base", "pinion", "upper_arm")):
            first = moving[0] if len(moving) == 1 or (moving[0] + 1) % 3 == moving[1] else moving[1]
            variables = theta[:, [first]] if len(moving) == 1 else theta[:, [first, (first + 1) % 3]]
            assert any(covers(s, pair, variables, p) for s in (swings if len(moving) == 1 else arms)), (
                pair.a.name,
                pair.b.name,
            )


def covers(space, pair, variables: np.ndarray, p: np.ndarray) -> bool:
    """Whether a space holds a pair's pieces, within its range, as the pair stands at handle positions p."""
    (centre,), (half,) = space.root()
    if (np.abs(variables - centre) > half).any() or not space.reachable(variables, 0.0 * variables).all():
        return False
    frames, q = space.frames(variables), space.pairs
    for one, other in ((pair.a, pair.b), (pair.b, pair.a)):
        true = [
            np.linalg.inv(link_frame(one.link, at_) @ one.placement) @ link_frame(other.link, at_) @ other.placement
            for at_ in p
        ]
        for i, j in zip(q.first.tolist(), q.second.tolist(), strict=True):
            a, b = q.bodies[i], q.bodies[j]
            if not (a.key.startswith(one.key) and b.key.startswith(other.key)):
                continue
            of_a, of_b = (frames[:, space.links.index(x.link)] @ x.placement for x in (a, b))
            if np.abs(np.linalg.inv(of_a) @ of_b - true).max() < 1e-6:
                return True
    return False


def test_equal_parts_of_one_chain_are_proven_once() -> None:
    """Rods of a chain, and rods at their elbows: the same in all three, over the angles of all."""
    assembly = machine(9.5, geometry=PLACED)
    pairs = clearance_pairs(assembly, PLACED_LIMITS, MeshLibrary(assembly.parts, 0.2, 0.6))
    spaces = spaces_of(pairs, assembly.placement, DOMAINS, PLACED_LIMITS, 0.0)
    (rods,) = [s for s in spaces if s.name.startswith("the rods of a chain")]
    centre, half = rods.root()
    assert centre - half == pytest.approx(DOMAINS.lean[:, 0].min())
    assert centre + half == pytest.approx(DOMAINS.lean[:, 1].max())
    assert DOMAINS.lean[0] != pytest.approx(DOMAINS.lean[1], abs=1e-3)
    assert sum(s.name == "a rod and its arm" for s in spaces) == 1
