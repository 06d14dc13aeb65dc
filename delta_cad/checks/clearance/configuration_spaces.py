"""The few variables on which the relative position of two links depends, each as a space that can be
subdivided (configuration spaces).

| links | variables | why |
|---|---|---|
| base, swept pinions among themselves | none | all fixed |
| base or a swept pinion - upper arm i | theta_i | the arm only turns |
| upper arm i - upper arm k | theta_i, theta_k | |
| rod i 0 - rod i 1, springs between them | lean | the two stay parallel |
| rod i j or spring i k - platform | direction of the forearm | the platform does not turn |
| rod i j or spring i k - upper arm i | direction of the forearm seen from the arm | |
| all others | the handle's position | |

Where the variables are joint angles, pairs that are the same seen from where each chain stands are one pair, over the
union of the angles of these chains: equal shapes, equally placed to `EQUAL_MM`. Of a three-fold symmetric machine that
is the union over all three. Of another the parts of one chain among themselves are the same in all three, too; what
stands beside a chain is not, and no two arms stand to each other as any other two.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Self

import numpy as np

from delta_cad.checks.clearance.bodies import CollisionBody
from delta_cad.checks.clearance.half_plane import HalfPlaneProfile, profile_gap, rectangles_gap
from delta_cad.checks.clearance.joint_ranges import Raster
from delta_cad.checks.clearance.segments import cells_of
from delta_cad.mechanism.placement import LinkPlacement, frames

X, Y, Z = np.eye(3)
ROUNDING = 1e-12  # of cosines and their squares: a thousand roundings of doubles
_SLABS = 512  # directions of the slabs tried between what two arms sweep: 9 degrees apart
CELLS = 4  # halvings: 16 pieces need a third of the distances of a socket's ring or a sector, 32 save no more
_LARGE_MM = 10.0  # radius from which a body's pieces are worth their bounds
CUT_SHARE = 0.5  # of the largest travel: what moves less is left whole for the next time
GUARD_MM = 1e-6  # roundings of doubles (1e-10) and of equal placements taken as one (1e-7)
Falls = Callable[[int, np.ndarray, np.ndarray, np.ndarray, np.ndarray], np.ndarray]


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

    def cut(
        self,
        segments: Callable[[CollisionBody], Sequence[CollisionBody]],
        wanted: Callable[[CollisionBody, CollisionBody], bool] = lambda a, b: True,  # noqa: ARG005
    ) -> Pairs:
        """The pairs with their bodies cut into segments, of those for which that is wanted."""
        bodies = list(self.bodies)
        index: dict[int, list[int]] = {}
        equal: dict[tuple[str, str, bytes], Sequence[CollisionBody]] = {}  # those of all rods, of all arms
        cut_up: list[tuple[int, int, int]] = []
        for k, (a, b) in enumerate(zip(self.first.tolist(), self.second.tolist(), strict=True)):
            if not wanted(self.bodies[a], self.bodies[b]):
                cut_up.append((a, b, k))
                continue
            for i in (a, b):
                if i not in index:
                    made = same_pieces(self.bodies[i], segments, equal)
                    index[i] = [i] if len(made) == 1 else list(range(len(bodies), len(bodies) + len(made)))
                    bodies += made if len(made) > 1 else []
            cut_up += [(i, j, k) for i in index[a] for j in index[b]]
        *ends, origin = np.array(cut_up, dtype=int).reshape(-1, 3).T
        used, held = np.unique(ends, return_inverse=True)
        first, second = held.reshape(2, -1)
        names = [self.names[k] for k in origin]
        return Pairs([bodies[k] for k in used], first, second, self.limit[origin], names)


def same_pieces(
    b: CollisionBody,
    segments: Callable[[CollisionBody], Sequence[CollisionBody]],
    known: dict[tuple[str, str, bytes], Sequence[CollisionBody]],
) -> list[CollisionBody]:
    """The segments of a body, those of one that is equal on a link of the same kind taken over from what is known."""
    key = b.key, b.link.split("_")[0], b.placement.tobytes()
    if key not in known:
        known[key] = segments(b)
    return [replace(piece, name=b.name, link=b.link) for piece in known[key]]


class ConfigurationSpace(ABC):
    """Variables, their range, and the motion of the links over a box of them.

    Attributes:
        name: For reports.
        pairs: The pairs whose relative position depends on these variables only.
        links: Names of the links that `frames` places, in order.
        directions: (k, 3) directions of the common frame in which a gap is looked for before a distance is measured.
        in_mm: Whether the variables are positions, mm, and no angles, rad.
    """

    directions = np.eye(3)
    in_mm = False

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
        """Bound on the approach of pairs along directions while the variables stay in boxes.

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

    def falls(self, centres: np.ndarray, halves: np.ndarray) -> Falls | None:  # noqa: ARG002
        """How far each point of a body comes forward along directions while the variables stay in boxes, if known.

        Args:
            centres: (n, d) centres of the boxes.
            halves: (n, d) half widths.

        Returns:
            A function of a body, boxes (k,), unit directions (k, 3) of the common frame, frames (k, 4, 4) of the
            body's link at the boxes' centres and points (h, 3) of the link. It gives (k, h) bounds, mm, on how much
            `direction . point` falls from its value at the box's centre, convex in the points, so that hulls go by
            their corners; what the exact surface strays from the points is counted. None where only `along` is known.
        """
        return None

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

    def in_pieces(self, which: np.ndarray) -> Self:  # noqa: ARG002
        """The space of some pairs (m,) bool, bodies cut up where that makes the proof cheaper; otherwise itself."""
        return self

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


class _Arms(ConfigurationSpace):
    """Upper arms that turn about their own shoulder axes, each by its own variable, where the first's chain stands.

    Args:
        name: For reports.
        pairs: The pairs; what is on no link of an arm stands still.
        links: Links of the space.
        arms: Those of the arms among them, in the order of the variables.
        base_radius_mm: Of the shoulders where their chains stand.
        stands: (4, 4) of each arm where its chain stands, seen from the first.
    """

    def __init__(
        self,
        name: str,
        pairs: Pairs,
        links: Sequence[str],
        arms: Sequence[str],
        base_radius_mm: float,
        stands: Sequence[np.ndarray],
    ) -> None:
        super().__init__(name, pairs, links)
        self._radius, self._stands = base_radius_mm, stands
        self._levers = np.stack([[b.lever_about_y() if b.link == arm else 0.0 for b in pairs.bodies] for arm in arms])
        self._arm = np.array([arms.index(b.link) if b.link in arms else 0 for b in pairs.bodies])
        self._axes = np.stack([stand[:3, 1] for stand in stands])

    def frames(self, centres: np.ndarray) -> np.ndarray:
        """Frames of the links at the variables."""
        arms = [_arm_frames(self._radius, theta) for theta in centres.T]
        still = [np.broadcast_to(np.eye(4), arms[0].shape)] * (len(self.links) - len(arms))
        return np.stack([*still, *(stand @ arm for stand, arm in zip(self._stands, arms, strict=True))], axis=1)

    def motion(self, centres: np.ndarray, halves: np.ndarray) -> list[np.ndarray]:  # noqa: ARG002
        """Travel of every body in the boxes."""
        return [halves @ self._levers]

    def along(
        self, centres: np.ndarray, halves: np.ndarray
    ) -> Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray]:
        """Bound on the approach of pairs along directions; a rotation contributes its component normal to the axis."""
        (motion,), first, second = self.motion(centres, halves), self.pairs.first, self.pairs.second

        def travel(box: np.ndarray, pair: np.ndarray, n: np.ndarray) -> np.ndarray:
            ends = first[pair], second[pair]
            return np.sum([motion[box, k] * sine(n, self._axes[self._arm[k]]) for k in ends], axis=0)

        return travel

    def falls(self, centres: np.ndarray, halves: np.ndarray) -> Falls:  # noqa: ARG002
        """Each point by its own speed at the centre, and by what bends its way, see `_swung`."""

        def fall(k: int, box: np.ndarray, direction: np.ndarray, frame: np.ndarray, points: np.ndarray) -> np.ndarray:
            if not self._levers[:, k].any():
                return np.zeros((len(box), len(points)))
            turn, stray = halves[box, self._arm[k], None], self.pairs.bodies[k].mesh.deviation_mm
            return _swung(turn, direction, frame, points, stray)

        return fall


class Swing(_Arms):
    """A fixed link and an upper arm, where the arm's chain stands: theta."""

    def __init__(self, name: str, pairs: Pairs, base_radius_mm: float, theta: tuple[float, float]) -> None:
        super().__init__(name, pairs, ("fixed", "arm"), ("arm",), base_radius_mm, [np.eye(4)])
        self._theta = theta

    def root(self) -> tuple[np.ndarray, np.ndarray]:
        """The whole range as one box."""
        low, high = self._theta
        return np.array([[(low + high) / 2.0]]), np.array([[(high - low) / 2.0]])

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


class TwoSwings(_Arms):
    """The upper arms of chains i and i + 1 where chain i stands: theta_i, theta_(i + 1).

    Args:
        name, pairs, base_radius_mm: As of `_Arms`.
        rasters: The angles that occur.
        next_stand: (4, 4) where chain i + 1 stands, seen from where chain i does.
    """

    def __init__(
        self, name: str, pairs: Pairs, base_radius_mm: float, rasters: Sequence[Raster], next_stand: np.ndarray
    ) -> None:
        arms = "arm", "next_arm"
        super().__init__(name, pairs, arms, arms, base_radius_mm, [np.eye(4), next_stand])
        self._rasters = rasters
        halving = max(self._axes[0] + self._axes[1], self._axes[0] - self._axes[1], key=np.linalg.norm)
        halving = halving / np.linalg.norm(halving)
        self.directions = np.stack([*self._axes, halving, np.cross(Z, halving)])

    def root(self) -> tuple[np.ndarray, np.ndarray]:
        """The whole range as one box."""
        return bounds_of(self._rasters)

    def in_pieces(self, which: np.ndarray) -> TwoSwings:
        """The space of some pairs in pieces: a sector reaches round its hub, its hull is full."""
        pairs = self.pairs.chosen(which).cut(_in_cells)
        return TwoSwings(self.name, pairs, self._radius, self._rasters, self._stands[1])

    def always_apart(self) -> np.ndarray:
        """Widest slab between the bodies of revolution that the two arms' bodies sweep about their own shoulder axes.

        Each holds its body at every angle, and neither moves. A direction sees no body of revolution farther than its
        farthest circle about the axis.
        """
        bodies, pairs = self.pairs.bodies, self.pairs
        one, other = self.frames(np.zeros((1, 2)))[0]
        n = _directions(_SLABS)
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
    """The two rods of a chain and the springs between them in the frame of rod 0: the lean.

    A spring's middle goes half as far as rod 1 does; its direction, that of the width less both eyes, turns with the
    lean at most by `width / (width - 2 e)`.
    """

    def __init__(self, name: str, pairs: Pairs, placement: LinkPlacement, lean: tuple[float, float]) -> None:
        super().__init__(name, pairs, ("rod_0", "rod_1", "spring_0", "spring_1"))
        self._width, self._lean = placement.parallelogram_width_mm, lean
        self._eye, self._springs = placement.eye_inside_mm, placement.springs_mm
        rate = self._width / (self._width - 2.0 * self._eye)
        self._levers = np.array(
            [
                self._width / 2.0 + rate * b.lever(np.zeros(3))
                if b.link.startswith("spring")
                else self._width * (b.link == "rod_1")
                for b in pairs.bodies
            ]
        )

    def root(self) -> tuple[np.ndarray, np.ndarray]:
        """The whole range as one box."""
        low, high = self._lean
        return np.array([[(low + high) / 2.0]]), np.array([[(high - low) / 2.0]])

    def frames(self, centres: np.ndarray) -> np.ndarray:
        """Frames of the links at the variables."""
        out = np.broadcast_to(np.eye(4), (len(centres), 4, 4, 4)).copy()
        across = self._width * np.stack([np.sin(centres[:, 0]), np.cos(centres[:, 0]), np.zeros(len(centres))], axis=1)
        out[:, 1, :3, 3] = across
        between = across - 2.0 * self._eye * Y
        between = between / np.linalg.norm(between, axis=1, keepdims=True)
        for k, (x, z) in enumerate(self._springs):
            out[:, 2 + k] = frames(np.cross(between, Z), between, across / 2.0 + x * X + z * Z)
        return out

    def motion(self, centres: np.ndarray, halves: np.ndarray) -> list[np.ndarray]:  # noqa: ARG002
        """Travel of every body in the boxes."""
        return [halves * self._levers]


def _in_cells(b: CollisionBody) -> list[CollisionBody]:
    """A large body in pieces, whose hulls leave free what the body's own fills."""
    return cells_of(b, CELLS) if b.radius > _LARGE_MM else [b]


def _swung(
    turn: np.ndarray, direction: np.ndarray, frame: np.ndarray, points: np.ndarray, stray_mm: float
) -> np.ndarray:
    """How far points of an arm come forward while it turns about the y axis of its frame.

    A point at v from the axis has the speed `|n x y . v|` along n at the centre, and bends off by half the turn's
    square times its radius.

    Args:
        turn: (k, 1) most that the arm turns either way, rad.
        direction: (k, 3) the directions.
        frame: (k, 4, 4) frames of the arm at the centres.
        points: (h, 3) points of the arm, mm.
        stray_mm: What the exact surface strays from them.

    Returns:
        (k, h) mm.
    """
    axis = frame[:, :3, 1]
    speed = np.abs((np.cross(direction, axis)[:, None] @ frame[:, :3, :3])[:, 0] @ points.T)
    return turn * (speed + stray_mm) + turn**2 / 2.0 * (np.hypot(points[:, 0], points[:, 2]) + stray_mm)


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


def _arm_frames(base_radius_mm: float, theta: np.ndarray) -> np.ndarray:
    """(n, 4, 4) frames of an upper arm where its chain stands at shoulder angles (n,), mm."""
    angle = theta[:, None]
    return frames(np.cos(angle) * X + np.sin(angle) * Z, np.broadcast_to(Y, (len(theta), 3)), base_radius_mm * X)


def bounds_of(rasters: Sequence[Raster]) -> tuple[np.ndarray, np.ndarray]:
    """(1, 2) centre and (1, 2) half widths of the box that holds all rasters."""
    low = np.min([r.low for r in rasters], axis=0)
    high = np.max([r.high for r in rasters], axis=0)
    return ((low + high) / 2.0)[None], ((high - low) / 2.0)[None]
