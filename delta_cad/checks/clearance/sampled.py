"""The smallest distance over many sampled positions, with measurements of only a few of them.

Every (position, pair) starts with a lower bound from bounding spheres and then from oriented boxes. The lowest bound
is measured; what was measured bounds the other positions of that pair in two ways. No point of a body leaves the
convex hull of its bounding box, so `distance >= measured - largest relative travel of the box's eight corners`. And
the convex hulls of the two bodies are at least as far apart as their extents along any direction, here the one
between the closest points. Of the platform a rod's body only reaches what is near its ball. An arm and what is fixed
are no closer than their profiles about the shoulder axis (`meridian`). It ends when no bound is below the smallest
distance found, so the result is the same as that of measuring everything, to `TOLERANCE_MM`. Pairs whose relative
position depends on one shoulder angle only are measured at `_SPREAD` of the positions, spread over that angle.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from delta_cad.checks.clearance.bodies import CollisionBody, DistanceEngine, boxes_gap
from delta_cad.checks.clearance.half_plane import HalfPlaneProfile, profile_gap
from delta_cad.checks.clearance.pairing import ClearancePair
from delta_cad.checks.clearance.segments import near
from delta_cad.checks.links import chain_of, clearance_frames, free_turn, swept_links, turn_about_x
from delta_cad.common.units import MM_PER_M
from delta_cad.mechanism.placement import CHAINS, LinkPlacement, chain_turn

TOLERANCE_MM = 0.01  # a fifth of a mesh deviation; lets a pair at constant distance stop early
_SPREAD = 49  # shoulder angles at which a pair is measured that depends on one of them: every 2 degrees
CORNERS = 8  # of the cube: the first positions
CHUNK = 64  # positions whose sphere distances are held in memory at once
_SIGNS = np.array(list(product((-1.0, 1.0), repeat=3)))


@dataclass(frozen=True)
class PairSample:
    """A measured pair.

    Attributes:
        pair: The pair.
        distance_mm: Distance of the two meshes, 0 where they intersect.
        pose: Index of the position.
    """

    pair: ClearancePair
    distance_mm: float
    pose: int

    @property
    def certain_mm(self) -> float:
        """Least distance of the exact bodies at that position, mm."""
        return self.distance_mm - self.pair.a.mesh.deviation_mm - self.pair.b.mesh.deviation_mm


class Sampler:
    """Distances of pairs at fixed handle positions.

    Args:
        placement: Placement of the links.
        poses_mm: (n, 3) handle positions, mm.
        engine: Distances of meshes.
        tilt_rad: Free tilt of the rods' sockets, see `free_tilt`.

    Attributes:
        frames: Link name -> (m, 4, 4) link frame to base frame, mm.
        poses_mm: (m, 3) handle positions of these frames, mm: the given ones and, where the rods have a free tilt, once
            more with all rods turned about themselves as far as they go, one way and the other.
    """

    def __init__(
        self, placement: LinkPlacement, poses_mm: np.ndarray, engine: DistanceEngine, tilt_rad: float = 0.0
    ) -> None:
        self._placement = placement
        self.frames = clearance_frames(placement, poses_mm)
        self.poses_mm, self._engine = poses_mm, engine
        self._profiles: dict[tuple[str, str], HalfPlaneProfile] = {}
        self._spread = [_spread(self.frames[f"upper_arm_{i}"][:, 2, 0]) for i in CHAINS]
        self._still = len(poses_mm)
        if tilt_rad:
            self.poses_mm = np.tile(poses_mm, (3, 1))
            across = placement.geometry.tangential
            self.frames = {name: _turned(name, frame, tilt_rad, across) for name, frame in self.frames.items()}

    def _arm_of(self, pair: ClearancePair) -> str | None:
        """The upper arm of a pair of an arm and something fixed, whose shoulder angle decides all."""
        arms = [b.link for b in (pair.a, pair.b) if b.link.startswith("upper_arm")]
        others = [b.link for b in (pair.a, pair.b) if not b.link.startswith("upper_arm")]
        swept = swept_links(self._placement)
        return arms[0] if len(arms) == 1 and (others[0] == "base" or others[0] in swept) else None

    def positions(self, pair: ClearancePair) -> np.ndarray:
        """Indices of the positions at which a pair is measured.

        Few where one shoulder angle decides all. A rod beside what it hangs on leans most in the cube's corners, which
        come first: elsewhere its running gap is left to the proof.
        """
        arm = self._arm_of(pair)
        if pair.running_gap and self._of_rods(pair):
            turns = range(len(self.poses_mm) // self._still)
            return np.concatenate([k * self._still + np.arange(CORNERS) for k in turns])
        count = len(self.poses_mm) if self._turns(pair) else self._still
        return np.arange(count) if arm is None else self._spread[chain_of(arm)]

    def _turns(self, pair: ClearancePair) -> bool:
        """Whether a rod of the pair is also measured turned about itself."""
        return len(self.poses_mm) > self._still and self._of_rods(pair)

    @staticmethod
    def _of_rods(pair: ClearancePair) -> bool:
        """Whether a body of the pair is of a rod."""
        return any(b.link.startswith("rod") for b in (pair.a, pair.b))

    def described(self, pair: ClearancePair) -> str:
        """At how many positions a pair is measured, as text."""
        count, total = len(self.positions(pair)), self._still
        if pair.running_gap and self._of_rods(pair):
            return "the cube's corners, the rods as they are and turned about themselves as far as they go either way"
        if self._arm_of(pair) is None:
            turned = ", the rods as they are and turned about themselves as far as they go either way"
            return f"{total} positions{turned if self._turns(pair) else ''}"
        return f"{count} positions spread over the shoulder angle, which alone decides, of {total}"

    def _always(self, pair: ClearancePair) -> float:
        """Lower bound of the meshes' distance at all positions, from their profiles about a shoulder axis, mm."""
        arm = self._arm_of(pair)
        if arm is None:
            return 0.0
        return profile_gap(*(self._profile(b, arm) for b in (pair.a, pair.b)))

    def _profile(self, b: CollisionBody, arm: str) -> HalfPlaneProfile:
        """Profile of a body about the shoulder axis of an arm, the same at every position."""
        if (b.name, arm) not in self._profiles:
            frame = np.linalg.inv(self.frames[arm][0]) @ self.frames[b.link][0] @ b.placement
            self._profiles[b.name, arm] = HalfPlaneProfile(b.mesh, frame)
        return self._profiles[b.name, arm]

    def closest(self, pairs: Sequence[ClearancePair], *, is_sorted: bool = False) -> list[PairSample]:
        """The closest pairs.

        Args:
            pairs: The pairs.
            is_sorted: Whether those that come closest are first: the sooner, the less is measured.

        Returns:
            The smallest sample of every pair that had to be measured, ascending; the first is the smallest of all
            samples of all pairs. Empty without pairs.
        """
        if not pairs:
            return []
        bounds = self._sphere_bounds(pairs)
        best = np.full(len(self.poses_mm), np.inf)
        samples: list[PairSample] = []

        def hear(_pose: int, mm: float) -> None:
            best[:] = min(best[0], mm)

        low = bounds.min(axis=1)
        for k in range(len(pairs)) if is_sorted else np.argsort(low, kind="stable"):
            if low[k] >= best[0] - TOLERANCE_MM:
                continue
            required = np.full(len(best), np.inf)
            poses = self.positions(pairs[k])
            required[poses] = bounds[k, poses]
            sample = self._smallest(pairs[k], required, best, hear)
            if sample is not None:
                samples.append(sample)
        return sorted(samples, key=lambda s: s.distance_mm)

    def least(self, pairs: Sequence[ClearancePair]) -> list[PairSample]:
        """The smallest sample of all pairs at each position, to `TOLERANCE_MM`.

        Args:
            pairs: The pairs, at least one, those that come closest first: the sooner, the less is measured.

        Returns:
            (n,) of the positions given, of the rods' turns the one with the least.
        """
        bounds = self._sphere_bounds(pairs)
        best = np.full(len(self.poses_mm), np.inf)
        found: dict[int, PairSample] = {}
        turned = np.arange(len(best)) >= self._still
        for pair, bound in zip(pairs, bounds, strict=True):
            if not (bound < best - TOLERANCE_MM).any():
                continue

            def hear(pose: int, mm: float, pair: ClearancePair = pair) -> None:
                if mm < best[pose]:
                    best[pose % self._still :: self._still] = mm
                    found[pose % self._still] = PairSample(pair, mm, pose)

            self._smallest(pair, bound if self._turns(pair) else np.where(turned, np.inf, bound), best, hear)
        return [found[k] for k in range(self._still)]

    def _sphere_bounds(self, pairs: Sequence[ClearancePair]) -> np.ndarray:
        """(pairs, n) lower bounds of the distances at all positions from bounding spheres, mm."""
        bodies = {b.name: b for pair in pairs for b in (pair.a, pair.b)}
        index = {name: k for k, name in enumerate(bodies)}
        middles = np.stack([self._middles(b) for b in bodies.values()]).astype(np.float32)
        radius = np.array([b.radius for b in bodies.values()], dtype=np.float32)
        first = np.array([index[p.a.name] for p in pairs], dtype=int)
        second = np.array([index[p.b.name] for p in pairs], dtype=int)
        bounds = np.empty((len(pairs), len(self.poses_mm)), dtype=np.float32)
        for start in range(0, len(pairs), CHUNK):
            part = slice(start, start + CHUNK)
            apart = middles[first[part]] - middles[second[part]]
            bounds[part] = np.sqrt(np.einsum("kpi,kpi->kp", apart, apart)) - 0.001  # single precision of 1 m is 1e-4 mm
        bounds -= (radius[first] + radius[second])[:, None]
        return bounds

    def middle(self, b: CollisionBody, pose: int) -> np.ndarray:
        """(3,) centre of a body's bounding box in the base frame at one position, mm."""
        f = self.frames[b.link][pose]
        return f[:3, :3] @ b.centre + f[:3, 3]

    def _middles(self, b: CollisionBody) -> np.ndarray:
        """(n, 3) centre of a body's bounding box in the base frame, mm."""
        f = self.frames[b.link]
        return f[:, :3, :3] @ b.centre + f[:, :3, 3]

    def _smallest(
        self, pair: ClearancePair, bound: np.ndarray, best: np.ndarray, hear: Callable[[int, float], None]
    ) -> PairSample | None:
        """The smallest of the pair's samples below `best`; None where the bounds say that there is none.

        Args:
            pair: The pair.
            bound: (n,) lower bound at every position; infinite where it is not asked.
            best: (n,) what a sample at each position is sought below, mm.
            hear: Told each sample, position and mm, as it is measured; lowers `best`.
        """
        poses = np.flatnonzero(bound < best - TOLERANCE_MM)
        low = np.maximum(bound[poses], self._ball_bounds(pair, poses))
        poses, low = _below(best, poses, low)
        low = np.maximum(low, self._box_bounds(pair, poses))
        poses, low = _below(best, poses, low)
        if not len(poses) or (local := self._near_the_wrist(pair, float(best[poses].max()))) is None:
            return None
        low = np.maximum(low, self._always(pair))
        one, other = local
        relative = np.linalg.inv(self.frames[pair.a.link][poses]) @ self.frames[pair.b.link][poses]
        corners = _homogeneous(pair.b.centre + (_SIGNS * pair.b.half) @ pair.b.axes.T)
        hull_a, hull_b = one.hull, other.hull
        result: PairSample | None = None
        while True:
            kept = low < best[poses] - TOLERANCE_MM
            poses, low, relative = poses[kept], low[kept], relative[kept]
            if not len(poses):
                return result if one is pair.a and other is pair.b else self._uncut(result)
            k = int(np.argmin(low))
            d, at_a, at_b = self._engine.closest_points(one, other, one.placement, relative[k] @ other.placement)
            if result is None or d < result.distance_mm:
                result = PairSample(pair, d, int(poses[k]))
            hear(int(poses[k]), d)
            moved = (relative - relative[k])[:, :3] @ corners
            low = np.maximum(low, d - np.sqrt((moved**2).sum(axis=1).max(axis=1)))
            low[k] = np.inf
            near = np.flatnonzero(low < best[poses] - TOLERANCE_MM)
            if d > 0.0 and len(near):
                normal = (at_b - at_a) / np.linalg.norm(at_b - at_a)
                reach = (normal @ relative[near, :3, :3]) @ hull_b.T
                apart = reach.min(axis=1) + relative[near, :3, 3] @ normal - (hull_a @ normal).max()
                low[near] = np.maximum(low[near], apart)

    def _uncut(self, sample: PairSample | None) -> PairSample | None:
        """A sample measured again between whole bodies: a segment represents the whole only below its bound."""
        if sample is None:
            return None
        a, b = sample.pair.a, sample.pair.b
        poses = (self.frames[x.link][sample.pose] @ x.placement for x in (a, b))
        return PairSample(sample.pair, self._engine.distance(a, b, *poses), sample.pose)

    def _near_the_wrist(self, pair: ClearancePair, best: float) -> tuple[CollisionBody, CollisionBody] | None:
        """The bodies of a pair, of the platform only what a body of a rod reaches; None where that is nothing.

        A rod turns about the centre of its ball, so its body stays within its lever of it, and what of the platform is
        farther than lever + `best` from there is farther than `best` from the body at every position. What is left is
        nearly convex where the platform is not, and its hull then says much more.
        """
        rods = [b for b in (pair.a, pair.b) if b.link.startswith("rod")]
        if not np.isfinite(best) or len(rods) != 1 or "platform" not in (pair.a.link, pair.b.link):
            return pair.a, pair.b
        (rod,), g, links = rods, self._placement.geometry, self.frames
        wrist = np.array([g.forearm_length * MM_PER_M, 0.0, 0.0])
        ball = (links[rod.link][0] @ np.append(wrist, 1.0))[:3] - links["platform"][0][:3, 3]  # it never turns
        reach = rod.lever(wrist) + best + max(pair.a.mesh.deviation_mm, pair.b.mesh.deviation_mm)
        chain = chain_turn(g, chain_of(rod.link))[:3, :3]
        samples = [b if b is rod else near(b, ball, reach, chain) for b in (pair.a, pair.b)]
        return None if samples[0] is None or samples[1] is None else (samples[0], samples[1])

    def _ball_bounds(self, pair: ClearancePair, poses: np.ndarray) -> np.ndarray:
        """(k,) lower bounds from the box of each body and the sphere of the other at some positions, mm."""
        out = np.full(len(poses), -np.inf)
        for one, other in ((pair.a, pair.b), (pair.b, pair.a)):
            f, h = self.frames[one.link][poses], self.frames[other.link][poses]
            apart = h[:, :3, :3] @ other.centre + h[:, :3, 3] - f[:, :3, :3] @ one.centre - f[:, :3, 3]
            inside = np.einsum("ni,nij,jk->nk", apart, f[:, :3, :3], one.axes)
            off = np.maximum(np.abs(inside) - one.half, 0.0)
            out = np.maximum(out, np.sqrt(np.einsum("ni,ni->n", off, off)) - other.radius)
        return out

    def _box_bounds(self, pair: ClearancePair, poses: np.ndarray) -> np.ndarray:
        """(k,) lower bounds of the distance from oriented bounding boxes at some positions, mm."""
        f, h = self.frames[pair.a.link][poses], self.frames[pair.b.link][poses]
        apart = h[:, :3, :3] @ pair.b.centre + h[:, :3, 3] - f[:, :3, :3] @ pair.a.centre - f[:, :3, 3]
        n = len(poses)
        return boxes_gap(
            apart,
            f[:, :3, :3] @ pair.a.axes,
            np.broadcast_to(pair.a.half, (n, 3)),
            h[:, :3, :3] @ pair.b.axes,
            np.broadcast_to(pair.b.half, (n, 3)),
        )


def _below(best: np.ndarray, poses: np.ndarray, low: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The positions, and their bounds, at which something below the best may be."""
    kept = low < best[poses] - TOLERANCE_MM
    return poses[kept], low[kept]


def _turned(link: str, frame: np.ndarray, tilt_rad: float, across: np.ndarray) -> np.ndarray:
    """(3 n, 4, 4) frames of a link, then again with the rods turned either way; `across` (3, 3) the shoulder axes."""
    if not link.startswith("rod"):
        return np.concatenate([frame] * 3)
    lean = np.arccos(np.clip(frame[:, :3, 1] @ across[chain_of(link)], -1.0, 1.0))
    turn = free_turn(tilt_rad, lean)
    return np.concatenate([frame, frame @ turn_about_x(turn), frame @ turn_about_x(-turn)])


def _spread(height: np.ndarray) -> np.ndarray:
    """Indices of at most `_SPREAD` positions whose elbows are spread evenly over their heights, extremes included."""
    order = np.argsort(height)
    levels = np.linspace(height.min(), height.max(), _SPREAD)
    return np.unique(order[np.clip(np.searchsorted(height[order], levels), 0, len(height) - 1)])


def _homogeneous(points: np.ndarray) -> np.ndarray:
    """(4, n) columns of homogeneous coordinates of points (n, 3)."""
    return np.concatenate([points.T, np.ones((1, len(points)))])
