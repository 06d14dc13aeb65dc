"""A rod against the link that holds one of its balls: the space of the forearm's directions, and of its own turn."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from delta_cad.checks.clearance.configuration_spaces import (
    CUT_SHARE,
    ROUNDING,
    ConfigurationSpace,
    Falls,
    Pairs,
    X,
    Y,
    Z,
    bounds_of,
    sine,
)
from delta_cad.checks.clearance.joint_ranges import Raster
from delta_cad.checks.links import turn_about_x
from delta_cad.mechanism.placement import LinkPlacement, frames

_SLENDER = 4.0  # a box moves a body by so much more through one variable than through another at most


class RodAtJoint(ConfigurationSpace):
    """A rod against the link that holds one of its balls, in that link's frame turned to the chain.

    The variables are the direction of the forearm: its angle in the chain's plane and its lean. A change of the angle
    turns the rod about the shoulder's direction, a change of the lean about a line square to it. Where the sockets
    leave a free tilt, the third variable is the turn of the rod about the line through its balls. The angle between
    the axes of socket and stud has the cosine `cos(lean) cos(turn)`: it ends where the free tilt does.

    Args:
        name: For reports.
        pairs: The pairs; bodies of the rods on links "rod_0" and "rod_1", the others on "holder".
        centre_mm: (3,) middle of the two balls in the holder's frame, mm.
        ball_mm: x of the held ball in the rod's frame: 0 for the elbow, L_B for the wrist.
        width_mm: Distance of the two rods.
        rasters: The directions that occur.
        is_round: Whether the holders are bodies of revolution about the line through both balls: then the forearm's
            angle changes no distance, and is no variable.
        tilt_rad: Free tilt of the sockets; 0: the rod does not turn about itself.
    """

    def __init__(
        self,
        name: str,
        pairs: Pairs,
        centre_mm: np.ndarray,
        ball_mm: float,
        width_mm: float,
        rasters: Sequence[Raster],
        is_round: bool = False,
        tilt_rad: float = 0.0,
    ) -> None:
        super().__init__(name, pairs, ("holder", "rod_0", "rod_1"))
        self._is_round, self._tilt = is_round, tilt_rad
        self._balls = [centre_mm + side * width_mm * Y for side in (-0.5, 0.5)]
        self._ball, self._rasters = ball_mm, rasters
        self._lever, self._off_axis = (
            np.array([0.0 if b.link == "holder" else lever(b) for b in pairs.bodies])
            for lever in (lambda b: b.lever(ball_mm * X), lambda b: b.lever_about_x())
        )

    def root(self) -> tuple[np.ndarray, np.ndarray]:
        """The whole range as one box."""
        centre, half = bounds_of(self._rasters)
        half, turn = half * [not self._is_round, True], np.full((1, int(self._tilt > 0.0)), self._tilt)
        return np.append(centre, 0.0 * turn, axis=1), np.append(half, turn, axis=1)

    def frames(self, centres: np.ndarray) -> np.ndarray:
        """Frames of the links at the variables."""
        angle, lean = centres[:, :2].T[..., None]
        radial = np.cos(angle) * X + np.sin(angle) * Z
        along, across = np.cos(lean) * radial + np.sin(lean) * Y, np.cos(lean) * Y - np.sin(lean) * radial
        rods = [frames(along, across, ball - self._ball * along) for ball in self._balls]
        out = np.stack([np.broadcast_to(np.eye(4), rods[0].shape), *rods], axis=1)
        if self._tilt:
            out[:, 1:] = out[:, 1:] @ turn_about_x(centres[:, 2])[:, None]
        return out

    def motion(self, centres: np.ndarray, halves: np.ndarray) -> list[np.ndarray]:  # noqa: ARG002
        """Travel of every body in the boxes."""
        swing = np.linalg.norm(halves[:, :2], axis=1)[:, None] * self._lever
        return [swing + halves[:, 2:] * self._off_axis if self._tilt else swing]

    def along(
        self, centres: np.ndarray, halves: np.ndarray
    ) -> Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray]:
        """How much closer pairs come along directions: of each turn a direction sees what is square to its axis."""
        (motion,), first, second = self.motion(centres, halves), self.pairs.first, self.pairs.second

        def travel(box: np.ndarray, pair: np.ndarray, normal: np.ndarray) -> np.ndarray:
            whole = motion[box, first[pair]] + motion[box, second[pair]]
            return np.minimum(whole, self._turns(centres[box], halves[box], pair, normal).sum(axis=1))

        return travel

    def falls(self, centres: np.ndarray, halves: np.ndarray) -> Falls:
        """Each point by its own speed at the centre, `|n x u . v|` for a turn about u, and a bound on what bends it.

        Along a straight way of the variables by `a`, one angle about each axis, a point at v from the ball moves at
        `w x v`, `w = sum a_k u_k`, and its acceleration is at most `(|w|^2 + |dw|) |v|`. The shoulder's direction
        stands still, the lean's axis turns with the angle, the rod with both, and the first two are square.
        """
        change = np.pad(halves, ((0, 0), (0, 3 - halves.shape[1])))
        a, b, c = change.T
        bend = (a**2 + b**2 + c**2 + 3.0 * a * c + a * b + b * c) / 2.0
        axes = self._axes(centres)

        def fall(k: int, box: np.ndarray, direction: np.ndarray, frame: np.ndarray, points: np.ndarray) -> np.ndarray:
            if not self._lever[k]:
                return np.zeros((len(box), len(points)))
            v, stray = points - self._ball * X, self.pairs.bodies[k].mesh.deviation_mm
            across = np.cross(direction[:, None], axes[box]) @ frame[:, :3, :3]
            out = bend[box, None] * (np.linalg.norm(v, axis=1) + stray) + (halves[box].sum(axis=1) * stray)[:, None]
            for turn, seen in zip(halves[box].T, np.swapaxes(across, 0, 1), strict=True):
                out += turn[:, None] * np.abs(seen @ v.T)
            return out

        return fall

    def _axes(self, centres: np.ndarray) -> np.ndarray:
        """(n, d, 3) axes about which a change of each variable turns the rod; the third is the rod's own."""
        angle, lean = centres[:, :1], centres[:, 1:2]
        axes = [np.broadcast_to(Y, (len(centres), 3)), np.cos(angle) * Z - np.sin(angle) * X]
        if self._tilt:
            axes.append(np.cos(lean) * (np.cos(angle) * X + np.sin(angle) * Z) + np.sin(lean) * Y)
        return np.stack(axes, axis=1)

    def worth_cutting(
        self, centres: np.ndarray, halves: np.ndarray, box: np.ndarray, pair: np.ndarray, normal: np.ndarray
    ) -> np.ndarray:
        """Which variables move a body along its direction by at least half as much as the one that moves it most.

        What moves it much farther in other directions is cut, too: a distance that is measured sees all directions.
        """
        seen = self._turns(centres[box], halves[box], pair, np.where(np.isfinite(normal), normal, 0.0))
        whole = self._turns(centres[box], halves[box], pair, np.zeros_like(normal))
        wanted = seen >= CUT_SHARE * seen.max(axis=1, keepdims=True)
        wanted |= whole >= _SLENDER * np.where(wanted, whole, 0.0).max(axis=1, keepdims=True)
        cut = np.zeros(centres.shape, dtype=bool)
        np.logical_or.at(cut, box, wanted)
        return cut

    def _turns(self, centres: np.ndarray, halves: np.ndarray, pair: np.ndarray, normal: np.ndarray) -> np.ndarray:
        """(k, d) how far the change of each variable alone moves points of pairs (k,) along directions (k, 3).

        From the centre of a box the rod's own turn changes first, then the lean, about an axis square to the chain's
        plane at the centre's angle, then the angle, about the shoulder's direction. A turn by `a` about the unit axis
        u moves a point at v from the ball by `a n . (u x v) <= a |n x u| |v|` along n. A direction of no length stands
        for all.
        """
        ends = self.pairs.first[pair], self.pairs.second[pair]
        levers = [sum(lever[k] for k in ends) for lever in (self._lever, self._lever, self._off_axis)]
        seen = [sine(normal, axis) for axis in np.swapaxes(self._axes(centres), 0, 1)]
        return halves * np.stack(levers[: len(seen)], axis=1) * np.stack(seen, axis=1)

    def reachable(self, centres: np.ndarray, halves: np.ndarray) -> np.ndarray:
        """Whether the rasters have angles in the boxes, at any angle of the forearm where that changes nothing.

        And whether the sockets tilt enough for the least of lean and turn.
        """
        least = np.maximum(np.abs(centres[:, 1:]) - halves[:, 1:], 0.0)
        free = np.cos(least).prod(axis=1) >= np.cos(self._tilt) - ROUNDING if self._tilt else True
        centres, halves = centres[:, :2], halves[:, :2]
        if self._is_round:
            centre, half = bounds_of(self._rasters)
            centres = np.column_stack([np.full(len(centres), centre[0, 0]), centres[:, 1]])
            halves = np.column_stack([np.full(len(halves), half[0, 0]), halves[:, 1]])
        return free & np.any([r.touched(centres, halves) for r in self._rasters], axis=0)


class SpringAtJoint(RodAtJoint):
    """The springs of a pair of rods against the link that holds the rods' balls, in its frame turned to the chain.

    A spring is translated with its middle, a point of the frame that turns about the middle of both balls; all else
    that it does its body holds, see `sway_of`. So every point of it moves as that one does.

    Args:
        name, pairs, centre_mm, ball_mm, rasters: As `RodAtJoint` has them, springs on links "spring_0" and "spring_1".
        placement: The placement of the links.
    """

    def __init__(
        self,
        name: str,
        pairs: Pairs,
        centre_mm: np.ndarray,
        ball_mm: float,
        placement: LinkPlacement,
        rasters: Sequence[Raster],
    ) -> None:
        super().__init__(name, pairs, centre_mm, ball_mm, placement.parallelogram_width_mm, rasters)
        self.links, self._centre = ("holder", "spring_0", "spring_1"), centre_mm
        self._middles = [np.array([x - ball_mm, 0.0, z]) for x, z in placement.springs_mm]
        levers = {f"spring_{k}": float(np.linalg.norm(v)) for k, v in enumerate(self._middles)}
        self._lever = np.array([levers.get(b.link, 0.0) for b in pairs.bodies])

    def frames(self, centres: np.ndarray) -> np.ndarray:
        """Frames of the links at the variables."""
        rods = super().frames(centres)[:, 1, :3, :3]
        out = np.broadcast_to(np.eye(4), (len(centres), 3, 4, 4)).copy()
        for k, middle in enumerate(self._middles):
            out[:, 1 + k, :3, 3] = self._centre + rods @ middle
        return out

    def falls(self, centres: np.ndarray, halves: np.ndarray) -> Falls:
        """Every point moves as the middle does: by its own speed along the direction, and a bound on what bends it."""
        a, b = halves.T
        bend = (a**2 + b**2 + a * b) / 2.0
        axes, rods = self._axes(centres), super().frames(centres)[:, 1, :3, :3]

        def fall(k: int, box: np.ndarray, direction: np.ndarray, _: np.ndarray, points: np.ndarray) -> np.ndarray:
            if not self._lever[k]:
                return np.zeros((len(box), len(points)))
            middle = rods[box] @ self._middles[int(self.pairs.bodies[k].link[-1])]
            speed = np.abs((np.cross(direction[:, None], axes[box]) * middle[:, None]).sum(axis=-1))
            out = bend[box] * self._lever[k] + (halves[box] * speed).sum(axis=1)
            return np.broadcast_to(out[:, None], (len(box), len(points)))

        return fall
