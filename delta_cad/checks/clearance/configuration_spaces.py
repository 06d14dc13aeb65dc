"""The few variables on which the relative position of two links depends, each as a space that can be
subdivided (configuration spaces).

| links | variables | why |
|---|---|---|
| base, swept pinions among themselves | none | all fixed |
| base or a swept pinion - upper arm i | theta_i | the arm only turns |
| upper arm i - upper arm k | theta_i, theta_k | |
| rod i 0 - rod i 1 | lean | the two stay parallel |
| rod i j - platform | direction of the forearm | the platform does not turn |
| rod i j - upper arm i | direction of the forearm seen from the arm | |
| all others | the handle's position | |

Where the variables are joint angles, pairs that are the same after a turn by 120 degrees are one pair, over the union
of the angles of the three chains: equal shapes, equally placed to `EQUAL_MM`.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from delta_cad.checks.clearance.bodies import CollisionBody
from delta_cad.checks.clearance.half_plane import HalfPlaneProfile, profile_gap, rectangles_gap
from delta_cad.checks.clearance.joint_ranges import Raster
from delta_cad.checks.links import turn_about_x, turn_about_z
from delta_cad.mechanism.placement import frames

X, Y, Z = np.eye(3)
ROUNDING = 1e-12  # of cosines and their squares: a thousand roundings of doubles
SLENDER = 4.0  # a box moves a body by so much more through one variable than through another at most
CUT_SHARE = 0.5  # of the largest travel: what moves less is left whole for the next time
SLABS = 512  # directions of the slabs tried between what two arms sweep: 9 degrees apart
GUARD_MM = 1e-6  # roundings of doubles (1e-10) and of equal placements taken as one (1e-7)


@dataclass(frozen=True)
class Pairs:
    """Pairs of bodies to be held apart.

    Attributes:
        bodies: The bodies.
        first: (m,) index of one body of each pair.
        second: (m,) index of the other.
        limit: (m,) distance to be kept, mm.
        names: (m,) occurrence names of each pair. A body stands for all that are equal to it, so its own name may be
            that of another chain.
    """

    bodies: Sequence[CollisionBody]
    first: np.ndarray
    second: np.ndarray
    limit: np.ndarray
    names: Sequence[tuple[str, str]]

    def chosen(self, which: np.ndarray) -> Pairs:
        """The pairs (m,) bool of the same bodies."""
        names = [self.names[k] for k in np.flatnonzero(which).tolist()]
        return Pairs(self.bodies, self.first[which], self.second[which], self.limit[which], names)


class ConfigurationSpace(ABC):
    """Variables, their range, and the motion of the links over a box of them.

    Attributes:
        name: For reports.
        pairs: The pairs whose relative position depends on these variables only.
        links: Names of the links that `frames` places, in order.
        directions: (k, 3) directions of the common frame in which a gap is looked for before a distance is measured.
    """

    directions = np.eye(3)

    def __init__(self, name: str, pairs: Pairs, links: Sequence[str]) -> None:
        self.name, self.pairs, self.links = name, pairs, tuple(links)

    @abstractmethod
    def root(self) -> tuple[np.ndarray, np.ndarray]:
        """(1, d) centre and (1, d) half widths of the box that holds the whole range."""

    @abstractmethod
    def frames(self, centres: np.ndarray) -> np.ndarray:
        """(n, links, 4, 4) frames of the links in a common frame at the variables (n, d), mm."""

    @abstractmethod
    def motion(self, centres: np.ndarray, halves: np.ndarray) -> list[np.ndarray]:
        """Bounds on the travel of every body's points while the variables stay in a box.

        Args:
            centres: (n, d) centres of the boxes.
            halves: (n, d) half widths.

        Returns:
            One (n, bodies) array in mm for each frame of reference; a pair may use any one of them for both bodies.
        """

    def along(
        self, centres: np.ndarray, halves: np.ndarray
    ) -> Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray]:
        """How much closer pairs come along directions while the variables stay in boxes.

        Args:
            centres: (n, d) centres of the boxes.
            halves: (n, d) half widths.

        Returns:
            A function of boxes (k,), pairs (k,) and unit directions (k, 3) from the first body to the second, fixed in
            the common frame. It gives (k,) bounds, mm, on how much `n . (q - p)` falls, from its value at the box's
            centre, for any point p of the first and q of the second body.
        """
        motion, first, second = self.motion(centres, halves), self.pairs.first, self.pairs.second
        return lambda box, pair, _: np.min([m[box, first[pair]] + m[box, second[pair]] for m in motion], axis=0)

    def worth_cutting(
        self,
        centres: np.ndarray,  # noqa: ARG002
        halves: np.ndarray,
        box: np.ndarray,  # noqa: ARG002
        pair: np.ndarray,  # noqa: ARG002
        normal: np.ndarray,  # noqa: ARG002
    ) -> np.ndarray:
        """Which variables to cut the boxes along.

        Args:
            centres: (n, d) centres of the boxes.
            halves: (n, d) half widths.
            box: (k,) box of what is not proven, each box at least once.
            pair: (k,) its pair.
            normal: (k, 3) direction in which its gap is looked for, nan where there is none.

        Returns:
            (n, d) bool, at least one variable for each box.
        """
        return np.ones(halves.shape, dtype=bool)

    def always_apart(self) -> np.ndarray:
        """(m,) lower bound on each pair's distance for all variables at once, mm; -inf where none is known."""
        return np.full(len(self.pairs.limit), -np.inf)

    def reachable(self, centres: np.ndarray, halves: np.ndarray) -> np.ndarray:  # noqa: ARG002
        """(n,) False only for boxes that certainly hold no variables that occur in the cube."""
        return np.ones(len(centres), dtype=bool)


class Fixed(ConfigurationSpace):
    """Links that do not move against each other."""

    def root(self) -> tuple[np.ndarray, np.ndarray]:
        """The whole range as one box."""
        return np.zeros((1, 0)), np.zeros((1, 0))

    def frames(self, centres: np.ndarray) -> np.ndarray:
        """Frames of the links at the variables."""
        return np.broadcast_to(np.eye(4), (len(centres), len(self.links), 4, 4))

    def motion(self, centres: np.ndarray, halves: np.ndarray) -> list[np.ndarray]:  # noqa: ARG002
        """Travel of every body in the boxes."""
        return [np.zeros((len(centres), len(self.pairs.bodies)))]


class Swing(ConfigurationSpace):
    """A fixed link and an upper arm, in the frame of the arm's chain: theta."""

    def __init__(self, name: str, pairs: Pairs, base_radius_mm: float, theta: tuple[float, float]) -> None:
        super().__init__(name, pairs, ("fixed", "arm"))
        self._radius, self._theta = base_radius_mm, theta
        self._lever = np.array([b.lever_about_y() if b.link == "arm" else 0.0 for b in pairs.bodies])

    def root(self) -> tuple[np.ndarray, np.ndarray]:
        """The whole range as one box."""
        low, high = self._theta
        return np.array([[(low + high) / 2.0]]), np.array([[(high - low) / 2.0]])

    def frames(self, centres: np.ndarray) -> np.ndarray:
        """Frames of the links at the variables."""
        fixed = np.broadcast_to(np.eye(4), (len(centres), 4, 4))
        return np.stack([fixed, arm_frames(self._radius, centres[:, 0])], axis=1)

    def motion(self, centres: np.ndarray, halves: np.ndarray) -> list[np.ndarray]:  # noqa: ARG002
        """Travel of every body in the boxes."""
        return [halves * self._lever]

    def along(
        self, centres: np.ndarray, halves: np.ndarray
    ) -> Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray]:
        """How much closer pairs come along directions: of a turn about y a direction sees what is square to y."""
        (motion,), first, second = self.motion(centres, halves), self.pairs.first, self.pairs.second
        return lambda box, pair, n: (motion[box, first[pair]] + motion[box, second[pair]]) * sine(n, Y)

    def always_apart(self) -> np.ndarray:
        """Distance of the profiles about the shoulder axis, which no shoulder angle changes."""
        to_axis = np.eye(4)
        to_axis[0, 3] = -self._radius
        bodies, pairs = self.pairs.bodies, self.pairs
        profiles = [HalfPlaneProfile(b.mesh, b.placement if b.link == "arm" else to_axis @ b.placement) for b in bodies]
        deviation = np.array([b.mesh.deviation_mm for b in bodies])
        bounds = np.array([p.bounds for p in profiles])
        strays = deviation[pairs.first] + deviation[pairs.second]
        gap = rectangles_gap(bounds[pairs.first], bounds[pairs.second]) - strays
        for k in np.flatnonzero(gap < pairs.limit + GUARD_MM):
            gap[k] = profile_gap(profiles[pairs.first[k]], profiles[pairs.second[k]]) - strays[k]
        return gap


class TwoSwings(ConfigurationSpace):
    """The upper arms of chains i and i + 1 in the frame of chain i: theta_i, theta_(i + 1)."""

    def __init__(self, name: str, pairs: Pairs, base_radius_mm: float, rasters: Sequence[Raster]) -> None:
        super().__init__(name, pairs, ("arm", "next_arm"))
        self._radius, self._rasters = base_radius_mm, rasters
        lever = np.array([b.lever_about_y() for b in pairs.bodies])
        self._levers = np.stack([np.where([b.link == link for b in pairs.bodies], lever, 0.0) for link in self.links])
        self._turned = turn_about_z(2.0 * np.pi / 3.0)

    def root(self) -> tuple[np.ndarray, np.ndarray]:
        """The whole range as one box."""
        return bounds_of(self._rasters)

    def frames(self, centres: np.ndarray) -> np.ndarray:
        """Frames of the links at the variables."""
        one, other = (arm_frames(self._radius, centres[:, k]) for k in range(2))
        return np.stack([one, self._turned @ other], axis=1)

    def motion(self, centres: np.ndarray, halves: np.ndarray) -> list[np.ndarray]:  # noqa: ARG002
        """Travel of every body in the boxes."""
        return [halves @ self._levers]

    def always_apart(self) -> np.ndarray:
        """Widest slab between the bodies of revolution that the two arms' bodies sweep about their own shoulder axes.

        Each holds its body at every angle, and neither moves. A direction sees no body of revolution farther than its
        farthest circle about the axis.
        """
        bodies, pairs = self.pairs.bodies, self.pairs
        one, other = self.frames(np.zeros((1, 2)))[0]
        n = _directions(SLABS)
        beyond, before = (
            np.array([b.reach_about_y(way @ at[:3, :3]) for b in bodies]) for at, way in ((one, n), (other, -n))
        )
        gap = (n @ (other - one)[:3, 3] - beyond[pairs.first] - before[pairs.second]).max(axis=1)
        strays = np.array([b.mesh.deviation_mm for b in bodies])
        return gap - strays[pairs.first] - strays[pairs.second]

    def reachable(self, centres: np.ndarray, halves: np.ndarray) -> np.ndarray:
        """Whether the rasters have angles in the boxes."""
        return np.any([r.touched(centres, halves) for r in self._rasters], axis=0)


class ParallelRods(ConfigurationSpace):
    """The two rods of a chain in the frame of rod 0: the lean."""

    def __init__(self, name: str, pairs: Pairs, width_mm: float, lean: tuple[float, float]) -> None:
        super().__init__(name, pairs, ("rod_0", "rod_1"))
        self._width, self._lean = width_mm, lean
        self._moves = np.array([b.link == "rod_1" for b in pairs.bodies], dtype=float)

    def root(self) -> tuple[np.ndarray, np.ndarray]:
        """The whole range as one box."""
        low, high = self._lean
        return np.array([[(low + high) / 2.0]]), np.array([[(high - low) / 2.0]])

    def frames(self, centres: np.ndarray) -> np.ndarray:
        """Frames of the links at the variables."""
        out = np.broadcast_to(np.eye(4), (len(centres), 2, 4, 4)).copy()
        out[:, 1, 0, 3] = self._width * np.sin(centres[:, 0])
        out[:, 1, 1, 3] = self._width * np.cos(centres[:, 0])
        return out

    def motion(self, centres: np.ndarray, halves: np.ndarray) -> list[np.ndarray]:  # noqa: ARG002
        """Travel of every body in the boxes."""
        return [self._width * halves * self._moves]


class RodAtJoint(ConfigurationSpace):
    """A rod against the link that holds one of its balls, in that link's frame turned to the chain.

    The variables are the direction of the forearm: its angle in the chain's plane and its lean. A change of the angle
    turns the rod about the shoulder's direction, a change of the lean about a line square to it.

    Args:
        name: For reports.
        pairs: The pairs; bodies of the rods on links "rod_0" and "rod_1", the others on "holder".
        centre_mm: (3,) middle of the two balls in the holder's frame, mm.
        ball_mm: x of the held ball in the rod's frame: 0 for the elbow, L_B for the wrist.
        width_mm: Distance of the two rods.
        rasters: The directions that occur.
    """

    def __init__(
        self,
        name: str,
        pairs: Pairs,
        centre_mm: np.ndarray,
        ball_mm: float,
        width_mm: float,
        rasters: Sequence[Raster],
    ) -> None:
        super().__init__(name, pairs, ("holder", "rod_0", "rod_1"))
        self._balls = [centre_mm + side * width_mm * Y for side in (-0.5, 0.5)]
        self._ball, self._rasters = ball_mm, rasters
        self._lever = np.array([0.0 if b.link == "holder" else b.lever(ball_mm * X) for b in pairs.bodies])

    def root(self) -> tuple[np.ndarray, np.ndarray]:
        """The whole range as one box."""
        return bounds_of(self._rasters)

    def frames(self, centres: np.ndarray) -> np.ndarray:
        """Frames of the links at the variables."""
        angle, lean = centres.T[..., None]
        radial = np.cos(angle) * X + np.sin(angle) * Z
        along, across = np.cos(lean) * radial + np.sin(lean) * Y, np.cos(lean) * Y - np.sin(lean) * radial
        rods = [frames(along, across, ball - self._ball * along) for ball in self._balls]
        return np.stack([np.broadcast_to(np.eye(4), rods[0].shape), *rods], axis=1)

    def motion(self, centres: np.ndarray, halves: np.ndarray) -> list[np.ndarray]:  # noqa: ARG002
        """Travel of every body in the boxes."""
        return [np.linalg.norm(halves, axis=1)[:, None] * self._lever]

    def along(
        self, centres: np.ndarray, halves: np.ndarray
    ) -> Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray]:
        """How much closer pairs come along directions: of each turn a direction sees what is square to its axis."""
        (motion,), first, second = self.motion(centres, halves), self.pairs.first, self.pairs.second

        def travel(box: np.ndarray, pair: np.ndarray, normal: np.ndarray) -> np.ndarray:
            whole = motion[box, first[pair]] + motion[box, second[pair]]
            return np.minimum(whole, self._turns(centres[box], halves[box], pair, normal).sum(axis=1))

        return travel

    def worth_cutting(
        self, centres: np.ndarray, halves: np.ndarray, box: np.ndarray, pair: np.ndarray, normal: np.ndarray
    ) -> np.ndarray:
        """Which variables move a body along its direction by at least half as much as the one that moves it most.

        What moves it much farther in other directions is cut, too: a distance that is measured sees all directions.
        """
        seen = self._turns(centres[box], halves[box], pair, np.where(np.isfinite(normal), normal, 0.0))
        whole = self._turns(centres[box], halves[box], pair, np.zeros_like(normal))
        wanted = seen >= CUT_SHARE * seen.max(axis=1, keepdims=True)
        wanted |= whole >= SLENDER * np.where(wanted, whole, 0.0).max(axis=1, keepdims=True)
        cut = np.zeros(centres.shape, dtype=bool)
        np.logical_or.at(cut, box, wanted)
        return cut

    def _turns(self, centres: np.ndarray, halves: np.ndarray, pair: np.ndarray, normal: np.ndarray) -> np.ndarray:
        """(k, d) how far the change of each variable alone moves points of pairs (k,) along directions (k, 3).

        From the centre of a box the lean changes first, about an axis square to the chain's plane at the centre's
        angle, then the angle, about the shoulder's direction. A turn by `a` about the unit axis u moves a point at v
        from the ball by `a n . (u x v) <= a |n x u| |v|` along n. A direction of no length stands for all.
        """
        angle = centres[:, :1]
        lever = (self._lever[self.pairs.first[pair]] + self._lever[self.pairs.second[pair]])[:, None]
        return (
            halves[:, :2] * lever * np.stack([sine(normal, Y), sine(normal, np.cos(angle) * Z - np.sin(angle) * X)], 1)
        )

    def reachable(self, centres: np.ndarray, halves: np.ndarray) -> np.ndarray:
        """Whether the rasters have angles in the boxes."""
        return np.any([r.touched(centres, halves) for r in self._rasters], axis=0)


class TurningRodAtJoint(RodAtJoint):
    """A rod that turns about itself against the link that holds one of its balls.

    To the variables of `RodAtJoint` comes the turn of the rod about the line through its balls. The angle between the
    axes of socket and stud has the cosine `cos(lean) cos(turn)`: it ends where the free tilt does.

    Args:
        name, pairs, centre_mm, ball_mm, width_mm, rasters: As `RodAtJoint` has them.
        tilt_rad: Free tilt of the sockets.
    """

    def __init__(
        self,
        name: str,
        pairs: Pairs,
        centre_mm: np.ndarray,
        ball_mm: float,
        width_mm: float,
        rasters: Sequence[Raster],
        tilt_rad: float,
    ) -> None:
        super().__init__(name, pairs, centre_mm, ball_mm, width_mm, rasters)
        self._tilt = tilt_rad
        self._off_axis = np.array([0.0 if b.link == "holder" else b.lever_about_x() for b in pairs.bodies])

    def root(self) -> tuple[np.ndarray, np.ndarray]:
        """The whole range as one box."""
        centre, half = super().root()
        return np.append(centre, [[0.0]], axis=1), np.append(half, [[self._tilt]], axis=1)

    def frames(self, centres: np.ndarray) -> np.ndarray:
        """Frames of the links at the variables."""
        out = super().frames(centres[:, :2])
        out[:, 1:] = out[:, 1:] @ turn_about_x(centres[:, 2])[:, None]
        return out

    def motion(self, centres: np.ndarray, halves: np.ndarray) -> list[np.ndarray]:
        """Travel of every body in the boxes."""
        (swing,) = super().motion(centres[:, :2], halves[:, :2])
        return [swing + halves[:, 2:] * self._off_axis]

    def _turns(self, centres: np.ndarray, halves: np.ndarray, pair: np.ndarray, normal: np.ndarray) -> np.ndarray:
        """(k, 3) how far the change of each variable alone moves points along directions; the turn changes first."""
        angle, lean = centres[:, :1], centres[:, 1:2]
        axis = np.cos(lean) * (np.cos(angle) * X + np.sin(angle) * Z) + np.sin(lean) * Y
        turn = halves[:, 2] * (self._off_axis[self.pairs.first[pair]] + self._off_axis[self.pairs.second[pair]])
        return np.column_stack([super()._turns(centres, halves, pair, normal), turn * sine(normal, axis)])

    def reachable(self, centres: np.ndarray, halves: np.ndarray) -> np.ndarray:
        """Whether the rasters have angles in the boxes, and the sockets tilt enough for the least of lean and turn."""
        least = np.maximum(np.abs(centres[:, 1:]) - halves[:, 1:], 0.0)
        free = np.cos(least).prod(axis=1) >= np.cos(self._tilt) - ROUNDING
        return free & super().reachable(centres[:, :2], halves[:, :2])


def _directions(count: int) -> np.ndarray:
    """(count, 3) unit vectors spread evenly, on a spiral from pole to pole."""
    k = np.arange(count) + 0.5
    height, turn = 1.0 - 2.0 * k / count, np.pi * (1.0 + np.sqrt(5.0)) * k
    across = np.sqrt(1.0 - height**2)
    return np.stack([across * np.cos(turn), across * np.sin(turn), height], axis=1)


def sine(direction: np.ndarray, axis: np.ndarray) -> np.ndarray:
    """(n,) sine of the angle between directions (n, 3) and unit axes (n, 3) or (3,), a rounding too large at most.

    It is 1 for a direction of no length.
    """
    return np.sqrt(np.maximum(1.0 - (direction * axis).sum(axis=1) ** 2, 0.0) + ROUNDING)


def arm_frames(base_radius_mm: float, theta: np.ndarray) -> np.ndarray:
    """(n, 4, 4) frames of chain 0's upper arm at shoulder angles (n,), as `LinkPlacement` gives them, mm."""
    angle = theta[:, None]
    return frames(np.cos(angle) * X + np.sin(angle) * Z, np.broadcast_to(Y, (len(theta), 3)), base_radius_mm * X)


def bounds_of(rasters: Sequence[Raster]) -> tuple[np.ndarray, np.ndarray]:
    """(1, 2) centre and (1, 2) half widths of the box that holds all rasters."""
    low = np.min([r.low for r in rasters], axis=0)
    high = np.max([r.high for r in rasters], axis=0)
    return ((low + high) / 2.0)[None], ((high - low) / 2.0)[None]
