"""Proof of a smallest distance over a continuum of positions by adaptive subdivision.

A box of variables is proven for a pair when `distance at the centre - travel of both bodies inside the box` is at least
the limit. Four lower bounds are tried, cheapest first: bounding spheres, oriented bounding boxes, a slab, and the FCL
distance of the meshes; the latter two less both deviations.

Slab: for a unit vector n and points p of one body and q of the other `|q - p| >= n . (q - p)`, and at the box's centre
`n . (q - p) >= min over q of n . q - max over p of n . p`, whose extremes are at vertices of the meshes' convex hulls.
So only the travel along n counts (`ConfigurationSpace.along`), which is much less than the travel where n looks across
a motion. Any n is right; the one between the closest points is good, and once measured it goes on to the boxes into
which this one is cut. What was never measured tries the directions that the space knows.

What is not proven is cut in two along the variables that move it most, until nothing is left or the travel in a box is
below `_SMALLEST_TRAVEL_MM`: then the pair is undecided, and that is a failure.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from delta_cad.checks.clearance.bodies import DistanceEngine, boxes_gap
from delta_cad.checks.clearance.configuration_spaces import GUARD_MM, ConfigurationSpace, Falls

_SMALLEST_TRAVEL_MM = 0.004  # a pair this close to its limit is for the designer to widen
_WORTH_MM = 2.0  # with more travel than this a distance call is left to the halves, unless the bounds give hope
HOPE = 0.5  # of the travel along a measured normal: with so much to spare most of the halves pass with that normal
_OPEN_MAX = 200_000  # boxes times pairs held at once: 0.5 s and 100 MB
_CORNERS_AT_ONCE = 1_000_000  # boxes times corners of a hull in one array: 8 MB, some of which stand beside one another
# Distance calls for one space, 0.1-0.2 ms each: sectors of 82 mm that pass one another 0.35 mm beyond the limit, along
# a whole line of angles, take 157 000.
CALLS_MAX = 200_000


@dataclass
class ClearanceProof:
    """What the subdivision of one space came to.

    Attributes:
        space: Name of the space.
        boxes: Boxes looked at.
        calls: Distance calls.
        undecided: Pair names and the box at which the proof stopped, as text; empty when all is proven.
        closest: Pair names -> how much more than its limit the pair is certain to keep where it was measured closest
            among the centres of boxes, mm. What was never measured was far enough apart without.
    """

    space: str
    boxes: int = 0
    calls: int = 0
    undecided: list[tuple[tuple[str, str], str]] = field(default_factory=list)
    closest: dict[tuple[str, str], float] = field(default_factory=dict)


def prove(space: ConfigurationSpace, engine: DistanceEngine, calls_max: int = CALLS_MAX) -> ClearanceProof:
    """Prove that every pair of a space keeps its limit at all reachable values of the variables.

    Args:
        space: The space and its pairs.
        engine: Distances of meshes.
        calls_max: Distance calls after which what is left counts as undecided.

    Returns:
        The outcome; proven when `undecided` is empty.
    """
    proof = ClearanceProof(space.name)
    left = ~(space.always_apart() >= space.pairs.limit + GUARD_MM)
    whole, space = space, space.in_pieces(left) if left.any() else space
    if space is not whole:
        left = ~(space.always_apart() >= space.pairs.limit + GUARD_MM)
    pairs, pair = space.pairs, np.flatnonzero(left)
    centres, halves = space.root()
    box = np.zeros(len(pair), dtype=int)
    normal = np.full((len(pair), 3), np.nan)  # from the first body to the second, in the common frame
    measured = np.zeros(len(pair), dtype=bool)  # whether the normal is that of the box from which this one was cut
    bounds = BoxBounds(space)
    while len(pair):
        proof.boxes += len(centres)
        allowed = engine.calls + calls_max - proof.calls
        before = engine.calls
        travel, open_, refuted, reserve = _not_proven(
            bounds, centres, halves, box, pair, normal, measured, engine, allowed
        )
        for k in np.flatnonzero(np.isfinite(reserve)).tolist():
            names = pairs.names[pair[k]]
            proof.closest[names] = min(float(reserve[k]), proof.closest.get(names, np.inf))
        proof.calls += engine.calls - before
        stuck = np.isin(open_, refuted) | ~(travel[open_] >= _SMALLEST_TRAVEL_MM)
        box, pair, normal, measured = box[open_], pair[open_], normal[open_], measured[open_]
        if proof.calls >= calls_max or len(open_) > _OPEN_MAX:
            stuck[:] = True
        for k in np.unique(pair[stuck]):
            at = box[stuck][pair[stuck] == k][0]
            proof.undecided.append((pairs.names[k], _described(space, centres[at], halves[at])))
        keep = ~np.isin(pair, pair[stuck])
        box, pair, normal, measured = box[keep], pair[keep], normal[keep], measured[keep]
        centres, halves, box, origin = _halved(space, centres, halves, box, pair, normal)
        pair, normal, measured = pair[origin], normal[origin], measured[origin]
    return proof


class BoxBounds:
    """What the bounds need to know of a space's bodies, as arrays."""

    def __init__(self, space: ConfigurationSpace) -> None:
        bodies = space.pairs.bodies
        self.space, self.bodies = space, bodies
        self.link = np.array([space.links.index(x.link) for x in bodies])
        self.centre, self.radius = np.array([x.centre for x in bodies]), np.array([x.radius for x in bodies])
        self.axes, self.half = np.array([x.axes for x in bodies]), np.array([x.half for x in bodies])
        self.deviation = np.array([x.mesh.deviation_mm for x in bodies])
        self._hulls: dict[int, np.ndarray] = {}
        self._spanned: dict[str, np.ndarray] = {}

    def hull(self, k: int) -> np.ndarray:
        """(n, 3) vertices of a body's convex hull in its link's frame."""
        if k not in self._hulls:
            b = self.bodies[k]
            if b.key not in self._spanned:
                self._spanned[b.key] = b.mesh.hull_points
            self._hulls[k] = self._spanned[b.key] @ b.placement[:3, :3].T + b.placement[:3, 3]
        return self._hulls[k]

    def hulls_gap(
        self,
        a: np.ndarray,
        b: np.ndarray,
        normal: np.ndarray,
        frame_a: np.ndarray,
        frame_b: np.ndarray,
        falls: Falls | None = None,
    ) -> np.ndarray:
        """Gap of the convex hulls of two bodies' meshes along a direction: they are nowhere closer.

        Args:
            a: (n,) one body.
            b: (n,) the other.
            normal: (n, 3) unit directions from a to b in the common frame.
            frame_a: (n, 4, 4) frame of a's link in the common frame.
            frame_b: (n, 4, 4) frame of b's link in the common frame.
            falls: What the hulls' corners travel against the directions, see `ConfigurationSpace.falls`, but that the
                index of what is asked stands for its box; None: nothing moves.

        Returns:
            (n,) gaps, mm; negative where the hulls overlap along the direction.
        """
        gap = np.zeros(len(normal))
        if not len(gap):
            return gap
        for bodies, frame, direction in ((a, frame_a, -normal), (b, frame_b, normal)):
            gap += (frame[:, :3, 3] * direction).sum(axis=1)
            seen = (direction[:, None, :] @ frame[:, :3, :3])[:, 0]
            order = np.argsort(bodies, kind="stable")
            names, starts = np.unique(bodies[order], return_index=True)
            for k, all_of in zip(names.tolist(), np.split(order, starts[1:]), strict=True):
                points = self.hull(k)
                for of in np.array_split(all_of, 1 + len(all_of) * len(points) // _CORNERS_AT_ONCE):
                    height = seen[of] @ points.T
                    if falls:
                        height -= falls(k, of, direction[of], frame[of], points)
                    gap[of] += height.min(axis=1)
        return gap


def _not_proven(
    bounds: BoxBounds,
    centres: np.ndarray,
    halves: np.ndarray,
    box: np.ndarray,
    pair: np.ndarray,
    normal: np.ndarray,
    measured: np.ndarray,
    engine: DistanceEngine,
    calls_allowed: int,
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """(k,) travel of each (box, pair), the indices of those not proven, of these the refuted, and (k,) what is spare.

    That is the certain distance less the limit at a box's centre, which may occur; infinite where none was measured.
    Hopeless is what no smaller box can mend: at the box's centre, which may occur, the meshes are too close. The
    normals are replaced by those between the closest points where these were measured, which `measured` then tells; a
    distance is put off by one halving where the last normal promises to do for most of the halves.
    """
    space, bodies, pairs = bounds.space, bounds.bodies, bounds.space.pairs
    a, b = pairs.first[pair], pairs.second[pair]
    frames, link_a, link_b = space.frames(centres), bounds.link[a], bounds.link[b]
    travel = np.min([m[box, a] + m[box, b] for m in space.motion(centres, halves)], axis=0)
    need = pairs.limit[pair] + travel + GUARD_MM

    middle_a, middle_b = (
        np.einsum("nij,nj->ni", f[:, :3, :3], bounds.centre[ends]) + f[:, :3, 3]
        for f, ends in ((frames[box, link_a], a), (frames[box, link_b], b))
    )
    apart = middle_b - middle_a
    distance = np.linalg.norm(apart, axis=1)
    left = np.flatnonzero(~(distance - bounds.radius[a] - bounds.radius[b] >= need))

    axes, half = bounds.axes, bounds.half
    worth = left[distance[left] > need[left]]
    i, j = a[worth], b[worth]
    gap = np.full(len(distance), -np.inf)
    gap[worth] = boxes_gap(
        apart[worth],
        frames[box[worth], link_a[worth], :3, :3] @ axes[i],
        half[i],
        frames[box[worth], link_b[worth], :3, :3] @ axes[j],
        half[j],
    )
    left = left[~(gap[left] >= need[left])]

    slabs = _Slabs(bounds, centres, halves, frames, box, pair)
    reserve = slabs.best(left, normal, apart)
    later = measured[left] & (reserve >= -HOPE * slabs.travel[left]) & (travel[left] >= _SMALLEST_TRAVEL_MM)
    measured[:] = False
    still = ~(reserve >= 0.0)
    left, later = left[still], later[still]

    b_in_a = np.linalg.inv(frames[box[left], link_a[left]]) @ frames[box[left], link_b[left]]
    possible = space.reachable(centres, np.zeros_like(halves))
    open_ = np.ones(len(left), dtype=bool)
    refuted: list[int] = []
    margin_there = np.full(len(pair), np.inf)
    for m in np.argsort(box[left], kind="stable").tolist():
        k = int(left[m])
        if later[m] or engine.calls >= calls_allowed or (not distance[k] > need[k] and travel[k] > _WORTH_MM):
            continue
        one, other = bodies[a[k]], bodies[b[k]]
        d, at_a, at_b = engine.closest_points(one, other, one.placement, b_in_a[m] @ other.placement)
        certain = d - bounds.deviation[a[k]] - bounds.deviation[b[k]]
        if possible[box[k]]:
            margin_there[k] = certain - pairs.limit[pair[k]]
        open_[m] = not certain >= need[k]
        if open_[m]:
            normal[k] = frames[box[k], link_a[k], :3, :3] @ ((at_b - at_a) / d) if d > 0.0 else np.nan
            measured[k] = d > 0.0
            if certain < need[k] - travel[k] and possible[box[k]]:
                refuted.append(k)
    new = np.flatnonzero(measured[left])
    open_[new] = ~(slabs.reserve(left[new], normal[left[new]]) >= 0.0)
    return travel, left[open_], np.array(refuted, dtype=int), margin_there


class _Slabs:
    """Pairs that a slab across a fixed direction separates at all positions of their boxes.

    Args:
        bounds: The bodies.
        centres: (n, d) centres of the boxes.
        halves: (n, d) half widths.
        frames: (n, links, 4, 4) frames of the links at the centres.
        box: (m,) box of each pair.
        pair: (m,) the pairs.

    Attributes:
        travel: (m,) travel along the direction last tried, mm; 0 where none was.
    """

    def __init__(
        self,
        bounds: BoxBounds,
        centres: np.ndarray,
        halves: np.ndarray,
        frames: np.ndarray,
        box: np.ndarray,
        pair: np.ndarray,
    ) -> None:
        self._bounds, self._frames, self._box, self._pair = bounds, frames, box, pair
        self._along, self._falls = bounds.space.along(centres, halves), bounds.space.falls(centres, halves)
        pairs = bounds.space.pairs
        self.travel = np.zeros(len(pair))
        self._a, self._b = pairs.first[pair], pairs.second[pair]
        self._least = pairs.limit[pair] + bounds.deviation[self._a] + bounds.deviation[self._b] + GUARD_MM

    def reserve(self, k: np.ndarray, normal: np.ndarray) -> np.ndarray:
        """(n,) by how much the hulls of pairs k (n,) are farther apart along (n, 3) directions than needed, mm."""
        a, b, box = self._a[k], self._b[k], self._box[k]
        frame_a, frame_b = (self._frames[box, self._bounds.link[ends]] for ends in (a, b))
        gap = self._bounds.hulls_gap(a, b, normal, frame_a, frame_b)
        travel = self._along(box, self._pair[k], normal)
        falls = self._falls
        if falls and len(near := np.flatnonzero(~(gap - self._least[k] - travel >= 0.0))):
            i, j, at = a[near], b[near], box[near]

            def fall(body: int, of: np.ndarray, *where: np.ndarray) -> np.ndarray:
                return falls(body, at[of], *where)

            there = self._bounds.hulls_gap(i, j, normal[near], frame_a[near], frame_b[near], fall)
            travel[near] = np.minimum(travel[near], gap[near] - there)
        self.travel[k] = travel
        return gap - self._least[k] - travel

    def best(self, k: np.ndarray, normal: np.ndarray, between: np.ndarray) -> np.ndarray:
        """(n,) what `reserve` gives for pairs k (n,): not negative where they are certainly far enough apart, mm.

        Along the pair's `normal` (m, 3) where it has one; otherwise along the direction `between` (m, 3) the middles of
        both and those that the space knows, of which the best becomes the pair's normal.
        """
        fresh = ~np.isfinite(normal[k, 0])
        reserve = np.full(len(k), -np.inf)
        reserve[~fresh] = self.reserve(k[~fresh], normal[k[~fresh]])
        new, best = k[fresh], reserve[fresh]
        middle = between[new] / np.maximum(np.linalg.norm(between[new], axis=1), 1e-9)[:, None]
        for n in (middle, *self._bounds.space.directions):
            facing = np.where(middle @ n < 0.0, -1.0, 1.0)[:, None] * n if n.ndim == 1 else n
            gain = self.reserve(new, facing)
            better = gain > best
            normal[new[better]], best = facing[better], np.fmax(best, gain)
        reserve[fresh] = best
        return reserve


def _halved(
    space: ConfigurationSpace,
    centres: np.ndarray,
    halves: np.ndarray,
    box: np.ndarray,
    pair: np.ndarray,
    normal: np.ndarray,
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """The boxes that still have pairs, cut in two along the variables for which it is worth it.

    Returns:
        centres, halves: The pieces, those dropped that are unreachable.
        box: (k,) piece of each of what is now to be proven.
        origin: (k,) what it comes from, an index of the given `box` and `pair`.
    """
    used, box = np.unique(box, return_inverse=True)
    centres, halves = centres[used], halves[used]
    d = centres.shape[1]
    signs = np.array(np.meshgrid(*[[-1.0, 1.0]] * d, indexing="ij")).reshape(d, -1).T if d else np.zeros((1, 0))
    cut = space.worth_cutting(centres, halves, box, pair, normal)
    half = np.where(cut, halves / 2.0, halves)[:, None] + 0.0 * signs
    centre = centres[:, None] + cut[:, None] * half * signs
    piece = np.all(cut[:, None] | (signs > 0.0), axis=2)  # along what is not cut there is one piece, not two
    piece[piece] &= space.reachable(centre[piece], half[piece])
    number = np.cumsum(piece).reshape(piece.shape) - 1
    origin, which = np.nonzero(piece[box])
    return centre[piece], half[piece], number[box[origin], which], origin


def _described(space: ConfigurationSpace, centre: np.ndarray, half: np.ndarray) -> str:
    """A box as text, in the unit of the space's variables."""
    unit, scale = ("mm", 1.0) if space.in_mm else ("deg", np.degrees(1.0))
    inner = ", ".join(f"{c * scale:.3f} +- {h * scale:.3f}" for c, h in zip(centre, half, strict=True))
    return f"{space.name}: ({inner}) {unit}" if len(centre) else space.name
