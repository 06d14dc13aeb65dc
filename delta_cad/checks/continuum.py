"""Proof of a least distance over a continuum of positions by adaptive subdivision.

A box of variables is proven for a pair when `distance at the centre - travel of both bodies inside the box` is at least
the limit. Four lower bounds of the distance are tried, cheapest first: bounding spheres, oriented bounding boxes, the
gap of the meshes' convex hulls along the direction between the points that were closest in the box from which this one
was cut, and the FCL distance of the meshes; the latter two less both deviations. The gap along any direction n is a
lower bound: `|q - p| >= n . (q - p) >= min over b of n . q - max over a of n . p` for |n| = 1, and the extremes are at
vertices of the hulls. What is not proven is cut in two along every variable, until nothing is left or the travel in a
box is below `SMALLEST_TRAVEL_MM`: then the pair is undecided, and that is a failure.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from delta_cad.checks.bodies import DistanceEngine, boxes_gap
from delta_cad.checks.spaces import GUARD_MM, Space

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
    pair = np.flatnonzero(~(space.always_apart(engine) >= pairs.limit + GUARD_MM))
    box = np.zeros(len(pair), dtype=int)
    normal = np.full((len(pair), 3), np.nan)  # from the first body to the second, in the frame of the first one's link
    bounds = Bounds(space)
    while len(pair):
        proof.boxes += len(centres)
        allowed = engine.calls + calls_max - proof.calls
        before = engine.calls
        travel, open_, hopeless = _not_proven(bounds, centres, halves, box, pair, normal, engine, allowed)
        proof.calls += engine.calls - before
        stuck = np.isin(open_, hopeless) | ~(travel[open_] >= SMALLEST_TRAVEL_MM)
        box, pair, normal = box[open_], pair[open_], normal[open_]
        if proof.calls >= calls_max or len(open_) > OPEN_MAX:
            stuck[:] = True
        for k in np.unique(pair[stuck]):
            at = box[stuck][pair[stuck] == k][0]
            proof.undecided.append((pairs.names[k], _described(space, centres[at], halves[at])))
        keep = ~np.isin(pair, pair[stuck])
        normal = np.repeat(normal[keep], 2 ** centres.shape[1], axis=0)
        centres, halves, box, pair, kept = _halved(space, centres, halves, box[keep], pair[keep])
        normal = normal[kept]
    return proof


class Bounds:
    """What the bounds need to know of a space's bodies, as arrays."""

    def __init__(self, space: Space) -> None:
        bodies = space.pairs.bodies
        self.space, self.bodies = space, bodies
        self.link = np.array([space.links.index(x.link) for x in bodies])
        self.centre, self.radius = np.array([x.centre for x in bodies]), np.array([x.radius for x in bodies])
        self.axes, self.half = np.array([x.axes for x in bodies]), np.array([x.half for x in bodies])
        self.deviation = np.array([x.mesh.deviation_mm for x in bodies])
        self._hulls: dict[int, np.ndarray] = {}

    def hull(self, k: int) -> np.ndarray:
        """(n, 3) vertices of a body's convex hull in its link's frame."""
        if k not in self._hulls:
            self._hulls[k] = self.bodies[k].hull
        return self._hulls[k]

    def hulls_gap(self, a: np.ndarray, b: np.ndarray, normal: np.ndarray, b_in_a: np.ndarray) -> np.ndarray:
        """Gap of the convex hulls of two bodies' meshes along a direction: they are nowhere closer.

        Args:
            a: (n,) one body.
            b: (n,) the other.
            normal: (n, 3) unit directions from a to b in the frame of a's link.
            b_in_a: (n, 4, 4) frame of b's link in the frame of a's link.

        Returns:
            (n,) gaps, mm; negative where the hulls overlap along the direction.
        """
        gap = (b_in_a[:, :3, 3] * normal).sum(axis=1)
        seen = (np.swapaxes(b_in_a[:, :3, :3], 1, 2) @ normal[..., None])[..., 0]
        for bodies, direction in ((a, -normal), (b, seen)):
            for k in np.unique(bodies):
                of = bodies == k
                gap[of] += np.einsum("ni,hi->nh", direction[of], self.hull(int(k))).min(axis=1)
        return gap


def _not_proven(
    bounds: Bounds,
    centres: np.ndarray,
    halves: np.ndarray,
    box: np.ndarray,
    pair: np.ndarray,
    normal: np.ndarray,
    engine: DistanceEngine,
    calls_allowed: int,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(k,) travel of each (box, pair), the indices of those not proven, and of these the hopeless ones.

    Hopeless is what no smaller box can mend: at the box's centre, which may occur, the meshes are too close. The
    normals are replaced by those between the closest points where these were measured.
    """
    space, bodies, pairs = bounds.space, bounds.bodies, bounds.space.pairs
    a, b = pairs.first[pair], pairs.second[pair]
    frames = space.frames(centres)[:, bounds.link]
    travel = np.min([m[box, a] + m[box, b] for m in space.motion(centres, halves)], axis=0)
    need = pairs.limit[pair] + travel + GUARD_MM

    turned = frames[..., :3, :3]
    middle = (turned @ bounds.centre[:, :, None])[..., 0] + frames[..., :3, 3]
    apart = middle[box, b] - middle[box, a]
    distance = np.linalg.norm(apart, axis=1)
    left = np.flatnonzero(~(distance - bounds.radius[a] - bounds.radius[b] >= need))

    axes, half = bounds.axes, bounds.half
    worth = left[distance[left] > need[left]]
    i, j = a[worth], b[worth]
    gap = np.full(len(distance), -np.inf)
    gap[worth] = boxes_gap(
        apart[worth], turned[box[worth], i] @ axes[i], half[i], turned[box[worth], j] @ axes[j], half[j]
    )
    left = left[~(gap[left] >= need[left])]

    strays = bounds.deviation[a] + bounds.deviation[b]
    b_in_a = np.linalg.inv(frames[box[left], a[left]]) @ frames[box[left], b[left]]
    known = np.isfinite(normal[left, 0])
    at = left[known]
    gap = np.full(len(left), -np.inf)
    gap[known] = bounds.hulls_gap(a[at], b[at], normal[at], b_in_a[known]) - strays[at]
    still = ~(gap >= need[left])
    b_in_a, left = b_in_a[still], left[still]

    possible = space.reachable(centres, np.zeros_like(halves))
    open_: list[int] = []
    hopeless: list[int] = []
    for m in np.argsort(box[left], kind="stable").tolist():
        k = int(left[m])
        if engine.calls >= calls_allowed or (not distance[k] > need[k] and travel[k] > WORTH_MM):
            open_.append(k)
            continue
        one, other = bodies[a[k]], bodies[b[k]]
        d, at_a, at_b = engine.closest_points(one, other, one.placement, b_in_a[m] @ other.placement)
        certain = d - strays[k]
        if not certain >= need[k]:
            open_.append(k)
            normal[k] = (at_b - at_a) / d if d > 0.0 else np.nan
            if certain < need[k] - travel[k] and possible[box[k]]:
                hopeless.append(k)
    return travel, np.array(open_, dtype=int), np.array(hopeless, dtype=int)


def _halved(
    space: Space, centres: np.ndarray, halves: np.ndarray, box: np.ndarray, pair: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """The boxes that still have pairs, cut in two along every variable; unreachable pieces dropped.

    Last are (k,) bool, which of the pairs' repetitions were kept.
    """
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
    return centre[reachable], half[reachable], renumbered[child[kept]], pair[kept], kept


def _described(space: Space, centre: np.ndarray, half: np.ndarray) -> str:
    """A box as text: mm for handle positions, degrees for angles."""
    handle = len(centre) == 3
    unit, scale = ("mm", 1.0) if handle else ("deg", np.degrees(1.0))
    inner = ", ".join(f"{c * scale:.3f} +- {h * scale:.3f}" for c, h in zip(centre, half, strict=True))
    return f"{space.name}: ({inner}) {unit}" if len(centre) else space.name
