"""Proof of a least distance over a continuum of positions by adaptive subdivision.

A box of variables is proven for a pair when `distance at the centre - travel of both bodies inside the box` is at least
the limit. Three lower bounds of the distance are tried, cheapest first: bounding spheres, oriented bounding boxes, and
the FCL distance of the meshes less both deviations. What is not proven is cut in two along every variable, until
nothing is left or the travel in a box is below `SMALLEST_TRAVEL_MM`: then the pair is undecided, and that is a failure.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from delta_cad.checks.bodies import DistanceEngine, boxes_gap
from delta_cad.checks.spaces import Space

GUARD_MM = 1e-6  # roundings of doubles (1e-10) and of equal placements taken as one (1e-7)
SMALLEST_TRAVEL_MM = 0.004  # a pair this close to its limit is for the designer to widen
WORTH_MM = 2.0  # with more travel than this a distance call is left to the halves, unless the bounds give hope
OPEN_MAX = 200_000  # boxes times pairs held at once: 0.5 s and 100 MB
CALLS_MAX = 60_000  # distance calls for one space; 0.1-0.2 ms each


@dataclass
class Proof:
    """What the subdivision of one space came to.

    Attributes:
        space: Name of the space.
        boxes: Boxes looked at.
        calls: Distance calls.
        undecided: Pair names and the box at which the proof stopped, as text; empty when all is proven.
    """

    space: str
    boxes: int = 0
    calls: int = 0
    undecided: list[tuple[tuple[str, str], str]] = field(default_factory=list)


def prove(space: Space, engine: DistanceEngine, calls_max: int = CALLS_MAX) -> Proof:
    """Prove that every pair of a space keeps its limit at all reachable values of the variables.

    Args:
        space: The space and its pairs.
        engine: Distances of meshes.
        calls_max: Distance calls after which what is left counts as undecided.

    Returns:
        The outcome; proven when `undecided` is empty.
    """
    proof = Proof(space.name)
    pairs = space.pairs
    centres, halves = space.root()
    pair = np.flatnonzero(~(space.always_apart() >= pairs.limit + GUARD_MM))
    box = np.zeros(len(pair), dtype=int)
    while len(pair):
        proof.boxes += len(centres)
        allowed = engine.calls + calls_max - proof.calls
        before = engine.calls
        travel, open_, hopeless = _not_proven(space, centres, halves, box, pair, engine, allowed)
        proof.calls += engine.calls - before
        stuck = np.isin(open_, hopeless) | ~(travel[open_] >= SMALLEST_TRAVEL_MM)
        box, pair = box[open_], pair[open_]
        if proof.calls >= calls_max or len(open_) > OPEN_MAX:
            stuck[:] = True
        for k in np.unique(pair[stuck]):
            at = box[stuck][pair[stuck] == k][0]
            proof.undecided.append((pairs.names[k], _described(space, centres[at], halves[at])))
        keep = ~np.isin(pair, pair[stuck])
        centres, halves, box, pair = _halved(space, centres, halves, box[keep], pair[keep])
    return proof


def _not_proven(
    space: Space,
    centres: np.ndarray,
    halves: np.ndarray,
    box: np.ndarray,
    pair: np.ndarray,
    engine: DistanceEngine,
    calls_allowed: int,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(k,) travel of each (box, pair), the indices of those not proven, and of these the hopeless ones.

    Hopeless is what no smaller box can mend: at the box's centre, which may occur, the meshes are too close.
    """
    bodies, pairs = space.pairs.bodies, space.pairs
    a, b = pairs.first[pair], pairs.second[pair]
    frames = space.frames(centres)
    link = np.array([space.links.index(x.link) for x in bodies])
    travel = np.min([m[box, a] + m[box, b] for m in space.motion(centres, halves)], axis=0)
    need = pairs.limit[pair] + travel + GUARD_MM

    centre, radius = np.array([x.centre for x in bodies]), np.array([x.radius for x in bodies])
    turned = frames[:, link, :3, :3]
    middle = (turned @ centre[:, :, None])[..., 0] + frames[:, link][..., :3, 3]
    apart = middle[box, b] - middle[box, a]
    distance = np.linalg.norm(apart, axis=1)
    left = np.flatnonzero(~(distance - radius[a] - radius[b] >= need))

    axes, half = np.array([x.axes for x in bodies]), np.array([x.half for x in bodies])
    worth = left[distance[left] > need[left]]
    i, j = a[worth], b[worth]
    gap = np.full(len(distance), -np.inf)
    gap[worth] = boxes_gap(
        apart[worth], turned[box[worth], i] @ axes[i], half[i], turned[box[worth], j] @ axes[j], half[j]
    )
    left = left[~(gap[left] >= need[left])]

    deviation = np.array([x.mesh.deviation_mm for x in bodies])
    possible = space.reachable(centres, np.zeros_like(halves))
    open_: list[int] = []
    hopeless: list[int] = []
    for k in left[np.argsort(box[left], kind="stable")].tolist():
        one, other = bodies[int(a[k])], bodies[int(b[k])]
        if engine.calls >= calls_allowed or (not distance[k] > need[k] and travel[k] > WORTH_MM):
            open_.append(k)
            continue
        d = engine.distance(
            one, other, frames[box[k], link[a[k]]] @ one.placement, frames[box[k], link[b[k]]] @ other.placement
        )
        certain = d - deviation[a[k]] - deviation[b[k]]
        if not certain >= need[k]:
            open_.append(k)
            if certain < need[k] - travel[k] and possible[box[k]]:
                hopeless.append(k)
    return travel, np.array(open_, dtype=int), np.array(hopeless, dtype=int)


def _halved(
    space: Space, centres: np.ndarray, halves: np.ndarray, box: np.ndarray, pair: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """The boxes that still have pairs, cut in two along every variable; unreachable pieces dropped."""
    used, box = np.unique(box, return_inverse=True)
    d = centres.shape[1]
    signs = np.array(np.meshgrid(*[[-1.0, 1.0]] * d, indexing="ij")).reshape(d, -1).T if d else np.zeros((1, 0))
    half = np.repeat(halves[used] / 2.0, len(signs), axis=0)
    centre = np.repeat(centres[used], len(signs), axis=0) + half * np.tile(signs, (len(used), 1))
    child = (box[:, None] * len(signs) + np.arange(len(signs))).ravel()
    pair = np.repeat(pair, len(signs))
    reachable = space.reachable(centre, half)
    renumbered = np.cumsum(reachable) - 1
    kept = reachable[child]
    return centre[reachable], half[reachable], renumbered[child[kept]], pair[kept]


def _described(space: Space, centre: np.ndarray, half: np.ndarray) -> str:
    """A box as text: mm for handle positions, degrees for angles."""
    handle = len(centre) == 3
    unit, scale = ("mm", 1.0) if handle else ("deg", np.degrees(1.0))
    inner = ", ".join(f"{c * scale:.3f} +- {h * scale:.3f}" for c, h in zip(centre, half, strict=True))
    return f"{space.name}: ({inner}) {unit}" if len(centre) else space.name
