r"""Pairs that depend on the whole handle position: their frames, and bounds on the travel of bodies within a box.

A point of a rod at the share f of the way from elbow to wrist and at v square to the rod lies at `E + f (W - E) + R v`;
elbow and wrist are translated with the arm's end and with the handle. While the handle goes from c to p it travels

    (1 - f) dE + f dp + dR v,    |dR v| <= min(rotation, 2) |v|,

so its travel along a unit vector n is at most `(1 - f) T + f B + min(rotation, 2) |v|`, with
`B = sum_k |n_k| h_k >= |n . dp|` and T the travel of the elbow along n. Of two bodies with shares f and g only the
difference of the shares of dp counts: `(1 - f) T + (1 - g) T' + |f - g| B`, convex in f and g, so it is largest at the
ends of both ranges. What the platform carries has f = 1 and no elbow, what an arm or the base carries has f = 0. A
spring is translated with its middle, a point at the share f of the way and at v square to it, in its pair's middle.

T: the elbow goes round a circle, `n . E = const + L_A s cos(theta - alpha)`, with s and alpha the length and the angle
of n in the chain's plane. Over a range of theta the lowest cosine is -1 if the range holds alpha + pi, otherwise that
at one of its ends. A point of an arm stays in a plane parallel to the chain's and travels `lever |dtheta|` at most, of
which n sees the part s. A direction across the chain's plane therefore sees nothing of a chain that swings.

Range of theta: the box is cut into parts, and each holds theta at its centre -+ the bound of `motion` there, whose
slack falls as the square of the size; the range over the cube bounds all. The parts together fill the box, so the
smallest range that holds theirs holds the box's.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from delta_cad.checks.clearance.bodies import CollisionBody
from delta_cad.checks.clearance.configuration_spaces import ConfigurationSpace, Falls, Pairs
from delta_cad.checks.clearance.motion import BoxMotion, box_motion
from delta_cad.checks.clearance.segments import segments_of
from delta_cad.checks.links import chain_of, clearance_frames
from delta_cad.common.units import MM_PER_M
from delta_cad.mechanism.geometry import VERTICAL
from delta_cad.mechanism.placement import LinkPlacement

_PARTS = 8192  # of all boxes together: 20 ms, against 1 s of distances that the sharper angles save
_ROTATION_MAX = 2.0  # no rotation moves a unit vector farther: the diameter of its circle


class Handle(ConfigurationSpace):
    """All links in the base frame: the handle's position in the cube.

    Args:
        name: For reports.
        pairs: The pairs.
        placement: The placement of the links.
        centre_mm: (3,) centre of the cube, mm.
        half_mm: Half its side, mm.
        theta: (3, 2) lowest and highest shoulder angle of each chain, rad.
    """

    in_mm = True

    def __init__(
        self,
        name: str,
        pairs: Pairs,
        placement: LinkPlacement,
        centre_mm: np.ndarray,
        half_mm: float,
        theta: np.ndarray,
    ) -> None:
        super().__init__(name, pairs, sorted({b.link for b in pairs.bodies}))
        self._theta = theta
        self._known: tuple[np.ndarray, np.ndarray, tuple[BoxMotion, np.ndarray, np.ndarray]] | None = None
        self._placement, self._centre, self._half = placement, centre_mm, half_mm
        g, count = placement.geometry, len(pairs.bodies)
        self._radial, self.directions = g.radial, np.concatenate([g.tangential, VERTICAL[None]])
        self._arm = g.upper_arm_length * MM_PER_M
        self._chain = np.array([max(chain_of(b.link), 0) for b in pairs.bodies])
        self._spring = np.array([b.link.startswith("swaying") for b in pairs.bodies])
        self._rod = self._spring | np.array([b.link.startswith("rod") for b in pairs.bodies])
        self._lever, self._off_axis, self._share = np.zeros(count), np.zeros(count), np.zeros((count, 2))
        for k, b in enumerate(pairs.bodies):
            if b.link.startswith("upper_arm") or (b.link.startswith("pinion") and placement.drive_ratio == 1.0):
                self._lever[k] = b.lever_about_y()
            elif self._spring[k]:
                x, z = placement.springs_mm[int(b.link[-1])]
                self._share[k], self._off_axis[k] = x / (g.forearm_length * MM_PER_M), abs(z)
            elif self._rod[k]:
                self._share[k], self._off_axis[k] = _rod_levers(b, g.forearm_length * MM_PER_M)
            elif b.link == "platform":
                self._share[k] = 1.0

    def root(self) -> tuple[np.ndarray, np.ndarray]:
        """The whole range as one box."""
        return self._centre[None], np.full((1, 3), self._half)

    def frames(self, centres: np.ndarray) -> np.ndarray:
        """Frames of the links at the variables."""
        links = clearance_frames(self._placement, centres)
        return np.stack([links[name] for name in self.links], axis=1)

    def angles(self, centres: np.ndarray, halves: np.ndarray) -> tuple[BoxMotion, np.ndarray, np.ndarray]:
        """Shoulder angles in boxes.

        Args:
            centres: (n, 3) centres of the boxes, mm.
            halves: (n, 3) half sides, mm.

        Returns:
            The bounds of `box_motion`, and the (n, 3) lowest and highest shoulder angles in the boxes, rad.
        """
        if self._known and self._known[0] is centres and self._known[1] is halves:
            return self._known[2]
        g, count = self._placement.geometry, max(int((_PARTS / len(centres)) ** (1.0 / 3.0)), 1)
        step = (2.0 * np.arange(count) + 1.0) / count - 1.0
        steps = np.stack(np.meshgrid(step, step, step, indexing="ij"), axis=-1).reshape(-1, 3)
        inside = centres[:, None] + steps * halves[:, None]
        size = np.broadcast_to(halves[:, None] / count, inside.shape)
        part = box_motion(g, inside.reshape(-1, 3), size.reshape(-1, 3))
        low = np.fmax(part.theta - part.theta_change, self._theta[:, 0]).reshape(len(centres), -1, 3).min(axis=1)
        high = np.fmin(part.theta + part.theta_change, self._theta[:, 1]).reshape(len(centres), -1, 3).max(axis=1)
        self._known = (centres, halves, (box_motion(g, centres, halves), low, high))
        return self._known[2]

    def motion(self, centres: np.ndarray, halves: np.ndarray) -> list[np.ndarray]:
        """Travel of every body in the boxes, seen from the base and seen from the platform."""
        bounds, low, high = self.angles(centres, halves)
        change = np.maximum(high - bounds.theta, bounds.theta - low)[:, self._chain]
        spin = self._off_axis * np.fmin(bounds.rotation, _ROTATION_MAX)[:, self._chain]
        handle, forearm = np.linalg.norm(halves, axis=1)[:, None], bounds.forearm[:, self._chain]
        elbow, swing = self._rod * self._arm * change, self._lever * change
        near, far = np.abs(self._share).T
        before, behind = np.abs(1.0 - self._share).T
        from_base = np.maximum(before * elbow + near * handle, behind * elbow + far * handle)
        # seen from the platform the elbow travels as the vector s changes
        from_wrist = np.maximum(before, behind) * np.where(self._rod, np.fmin(forearm, elbow + handle), handle)
        return [swing + spin + from_base, swing + spin + from_wrist]

    def along(
        self, centres: np.ndarray, halves: np.ndarray
    ) -> Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray]:
        """Bound on the approach of pairs along directions while the handle stays in the boxes."""
        bounds, low, high = self.angles(centres, halves)
        theta, rotation = bounds.theta, np.fmin(bounds.rotation, _ROTATION_MAX)

        def travel(box: np.ndarray, pair: np.ndarray, normal: np.ndarray) -> np.ndarray:
            own, elbow, share = np.zeros(len(pair)), [], []
            for k, n in ((self.pairs.first[pair], -normal), (self.pairs.second[pair], normal)):
                i = self._chain[k]
                at, lowest, highest = theta[box, i], low[box, i], high[box, i]
                size = np.hypot((n * self._radial[i]).sum(axis=1), n[:, 2])
                turn = np.maximum(highest - at, at - lowest)
                own += self._lever[k] * size * turn + self._off_axis[k] * rotation[box, i]
                elbow.append(self._rod[k] * self._elbow_fall(i, n, at, lowest, highest))
                share.append(self._share[k].T)
            handle = (np.abs(normal) * halves[box]).sum(axis=1)
            ends = [
                np.abs(1.0 - f) * elbow[0] + np.abs(1.0 - g) * elbow[1] + np.abs(f - g) * handle
                for f in share[0]
                for g in share[1]
            ]
            return own + np.max(ends, axis=0)

        return travel

    def _elbow_fall(
        self,
        chain: np.ndarray | int,
        direction: np.ndarray,
        theta: np.ndarray,
        lowest: np.ndarray,
        highest: np.ndarray,
    ) -> np.ndarray:
        """(k,) how far elbows come down along directions (k, 3) from where they are, while theta stays in a range."""
        radial = (direction * self._radial[chain]).sum(axis=1)
        size, ahead = np.hypot(radial, direction[:, 2]), np.arctan2(direction[:, 2], radial)
        back = (lowest - ahead - np.pi) % (2.0 * np.pi) + highest - lowest >= 2.0 * np.pi
        least = np.where(back, -1.0, np.minimum(np.cos(lowest - ahead), np.cos(highest - ahead)))
        return self._arm * size * (np.cos(theta - ahead) - least)

    def falls(self, centres: np.ndarray, halves: np.ndarray) -> Falls:
        """Each point by its own share of the way, radius about its arm's axis and distance from its rod's."""
        bounds, low, high = self.angles(centres, halves)
        theta, rotation = bounds.theta, np.fmin(bounds.rotation, _ROTATION_MAX)
        turn = np.maximum(high - theta, theta - low)
        forearm = self._placement.geometry.forearm_length * MM_PER_M

        def fall(k: int, box: np.ndarray, direction: np.ndarray, _: np.ndarray, points: np.ndarray) -> np.ndarray:
            i, stray = self._chain[k], self.pairs.bodies[k].mesh.deviation_mm
            handle = (np.abs(direction) * halves[box]).sum(axis=1)[:, None]
            if self._rod[k]:
                elbow = self._elbow_fall(i, direction, theta[box, i], low[box, i], high[box, i])[:, None]
                share, off = points[:, 0] / forearm, np.hypot(points[:, 1], points[:, 2])
                if self._spring[k]:
                    share, off = np.full(len(points), self._share[k, 0]), np.full(len(points), self._off_axis[k])
                spin = rotation[box, i][:, None] * (off + stray)
                return np.abs(1.0 - share) * elbow + np.abs(share) * handle + spin + stray / forearm * (elbow + handle)
            if self._lever[k]:
                size = np.hypot((direction * self._radial[i]).sum(axis=1), direction[:, 2])
                return (size * turn[box, i])[:, None] * (np.hypot(points[:, 0], points[:, 2]) + stray)
            return np.broadcast_to(handle * self._share[k, 0], (len(box), len(points)))

        return fall

    def in_pieces(self, which: np.ndarray) -> Handle:
        """The space of some pairs, the ends of two rods at their wrists cut across, see `segments_of`."""
        length = self._placement.geometry.forearm_length * MM_PER_M
        wrist = np.array([length, 0.0, 0.0])

        def at_wrist(b: CollisionBody) -> bool:
            return b.link.startswith("rod") and float(np.linalg.norm(b.centre - wrist)) < b.radius

        pairs = self.pairs.chosen(which)
        pairs = pairs.cut(lambda b: segments_of(b, length), lambda a, b: at_wrist(a) and at_wrist(b))
        return Handle(self.name, pairs, self._placement, self._centre, self._half, self._theta)

    def always_apart(self) -> np.ndarray:
        """What lies between two bodies whatever the position.

        The height of what the platform carries over what an arm or the base carries; and of two bodies on rods that
        of the balls about their wrists in which they stay, for the platform does not turn the wrists.
        """
        bodies, gap = self.pairs.bodies, super().always_apart()
        heights = [self._heights(b) for b in bodies]
        length = self._placement.geometry.forearm_length * MM_PER_M
        wrist, frames = np.array([length, 0.0, 0.0]), self.frames(self._centre[None])[0]
        rods = {k: frames[self.links.index(b.link)] for k, b in enumerate(bodies) if b.link.startswith("rod")}
        ball = {k: (frame[:3, :3] @ wrist + frame[:3, 3], bodies[k].lever(wrist)) for k, frame in rods.items()}
        for k, (i, j) in enumerate(zip(self.pairs.first.tolist(), self.pairs.second.tolist(), strict=True)):
            (low_i, high_i), (low_j, high_j) = heights[i], heights[j]
            gap[k] = max(low_i - high_j, low_j - high_i)
            if i in ball and j in ball:
                (at, reach), (other, further) = ball[i], ball[j]
                gap[k] = float(np.linalg.norm(at - other)) - reach - further
        return gap

    def _heights(self, b: CollisionBody) -> tuple[float, float]:
        """Lowest and highest z of a body's exact surface over the cube, mm; infinite for rods and pinions."""
        points, extra = b.vertices, b.mesh.deviation_mm
        if b.link == "base":
            low, high = points[:, 2].min(), points[:, 2].max()
        elif b.link == "platform":
            low = points[:, 2].min() + self._centre[2] - self._half
            high = points[:, 2].max() + self._centre[2] + self._half
        elif b.link.startswith("upper_arm"):
            low, high = _swung(points, self._theta[int(b.link[-1])])
        else:
            return -np.inf, np.inf
        return float(low) - extra, float(high) + extra


def _swung(points: np.ndarray, theta: np.ndarray) -> tuple[float, float]:
    """Lowest and highest z of points (n, 3) of an arm while it turns through the angles (lowest, highest)."""
    radius, start = np.hypot(points[:, 0], points[:, 2]), np.arctan2(points[:, 2], points[:, 0])
    ends = radius * np.sin(start + theta[:, None])  # x sin(theta) + z cos(theta)
    top, bottom = (
        (start + theta[0] - peak) % (2.0 * np.pi) + np.ptp(theta) >= 2.0 * np.pi for peak in (0.5 * np.pi, 1.5 * np.pi)
    )
    low, high = np.where(bottom, -radius, ends.min(axis=0)), np.where(top, radius, ends.max(axis=0))
    return float(low.min()), float(high.max())


def _rod_levers(b: CollisionBody, forearm_mm: float) -> tuple[tuple[float, float], float]:
    """Lowest and highest share of the way from elbow to wrist, and largest distance from the rod's axis, mm."""
    points, extra = b.vertices, b.mesh.deviation_mm
    low, high = points[:, 0].min() - extra, points[:, 0].max() + extra
    off_axis = float(np.hypot(points[:, 1], points[:, 2]).max()) + extra
    return (low / forearm_mm, high / forearm_mm), off_axis
