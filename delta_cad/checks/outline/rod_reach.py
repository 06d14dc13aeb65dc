"""Reach of a body on a rod along a direction over the cube, by branch and bound with first-order bounds.

Over a box of handle positions, along a direction d,
    the elbow's ball E reaches `outwards (R_i + L_A cos(theta)) + side`, exact over the enclosed range of theta;
    the wrist's ball W is exact, the handle moves along straight lines;
    a vector h fixed in the rod turns by at most the rotation phi of the rod's whole frame, so from its place at the
        box's centre, at the angle alpha from d, it reaches `|h| cos(alpha - phi)`, or |h| once phi >= alpha.
    a rod with two ball joints turns about the line through its balls until its sockets have no tilt left: by `turn` at
        the least lean of the box. That takes h round an arc about the rod, and alpha is then its least on the arc;
A point of the body is `E + h`, and also `W + h`, and also `(1 - f) E + f W + h` with f its share of the way and h
square to the rod: the least of the three bounds it. All are exact for a box of no size and err by its size, so that
cutting the boxes closes the gap.
"""

from __future__ import annotations

from dataclasses import replace
from functools import partial

import numpy as np

from delta_cad.assembly.tessellation import Mesh
from delta_cad.checks.clearance.bodies import CollisionBody
from delta_cad.checks.clearance.motion import box_motion, cube_boxes
from delta_cad.checks.limits import CheckLimits
from delta_cad.checks.links import chain_of, free_turn
from delta_cad.checks.outline.enclosed_maximum import enclosed_maximum
from delta_cad.common.units import MM_PER_M
from delta_cad.mechanism.placement import LinkPlacement, chain_turn

BOXES = 7  # boxes along an edge of the cube at first, 11 mm: most bodies are told apart with these
GAP_MM = 0.02  # what the bound may leave above an attained reach; less than a mesh's deviation


class RodReach:
    """Reach of the bodies on the rods over the cube.

    Args:
        placement: Placement of the links.
        limits: The cube.
        theta: (3, 2) enclosed range of the shoulder angles over the cube, rad.
        tilt_rad: Free tilt of the rods' sockets, see `free_tilt`.
    """

    def __init__(self, placement: LinkPlacement, limits: CheckLimits, theta: np.ndarray, tilt_rad: float = 0.0) -> None:
        self._tilt = tilt_rad
        self._placement, self._geometry, self._theta = placement, placement.geometry, theta
        self._start = _Boxes(placement, *cube_boxes(limits.centre_mm, limits.half_side_mm, BOXES))

    def roughest(self, body: CollisionBody, direction: np.ndarray) -> float:
        """Bounds the reach by how far the balls reach and how far from them the body does: most stay behind others.

        Args:
            body: A body on a rod.
            direction: (3,) unit vector in the base plane.

        Returns:
            Bound on the reach of its mesh, mm.
        """
        elbow, wrist = self._balls(body, direction, self._start)
        ends = zip((elbow, wrist), (0.0, self._geometry.forearm_length * MM_PER_M), strict=True)
        points = body.vertices
        return min(float(at[1].max() + np.linalg.norm(points - [x, 0, 0], axis=1).max()) for at, x in ends)

    def coarse(self, body: CollisionBody, direction: np.ndarray) -> float:
        """Bounds the reach from the first boxes alone, arguments and result as of `roughest`."""
        return float(self.bounds(body, direction, self._start.centres, self._start.halves)[0].max())

    def refined(self, body: CollisionBody, direction: np.ndarray, floor_mm: float) -> tuple[float, float]:
        """Bounds the reach closely where it exceeds a floor.

        Args:
            body: A body on a rod.
            direction: (3,) unit vector in the base plane.
            floor_mm: A reach that something else attains: what stays below it is not looked into.

        Returns:
            bound: On the reach of the body's mesh, mm; close where it exceeds the floor.
            attained: The larger of the floor and the reach at the best box's centre, mm.
        """
        bounds = partial(self.bounds, body, direction)
        return enclosed_maximum(bounds, self._start.centres, self._start.halves, GAP_MM, floor_mm)

    def bounds(
        self, body: CollisionBody, direction: np.ndarray, centres: np.ndarray, halves: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        """Bounds the reach over boxes of handle positions.

        Args:
            body: A body on a rod.
            direction: (3,) unit vector in the base plane.
            centres: (n, 3) centres of the boxes, mm.
            halves: (n, 3) their half sides, mm.

        Returns:
            bound: (n,) on the reach of the body's mesh while the handle is in the box, mm.
            at_centre: (n,) reach with the handle at the box's centre and the rod turned for it, mm.
        """
        boxes = self._start if centres is self._start.centres else _Boxes(self._placement, centres, halves)
        d, i = direction, chain_of(body.link)
        g, motion = self._geometry, boxes.motion
        elbow, wrist = self._balls(body, d, boxes)
        frame = boxes.links[body.link]
        axes, origin = d @ frame[:, :3, :3], frame[:, :3, 3] @ d
        points, length = body.hull, g.forearm_length * MM_PER_M
        least = np.maximum(np.maximum(motion.lean_low[:, i], -motion.lean_high[:, i]), 0.0)
        turn, turn_there = (free_turn(self._tilt, lean)[:, None] for lean in (least, motion.lean[:, i]))
        at_centre = turned_reach(axes, points, turn_there).max(axis=1) + origin
        phi = np.minimum(motion.rotation[:, i], np.pi)[:, None]
        share = points[:, 0] / length
        ends = _at_most(1.0 - share, elbow) + _at_most(share, wrist)
        bound = np.minimum(
            elbow[1] + _turned(axes, points, turn, phi), wrist[1] + _turned(axes, points - [length, 0, 0], turn, phi)
        )
        return np.minimum(bound, ends + _turned(axes, points * [0, 1, 1], turn, phi)).max(axis=1), at_centre

    def _balls(self, body: CollisionBody, d: np.ndarray, boxes: _Boxes) -> tuple[np.ndarray, np.ndarray]:
        """(2, n, 1) least and most reach along a direction of the elbow's and of the wrist's ball of a body's rod."""
        i, j = (int(word) for word in body.link.split("_")[1:])
        g, motion = self._geometry, boxes.motion
        low = np.maximum(motion.theta[:, i] - motion.theta_change[:, i], self._theta[i, 0])
        high = np.minimum(motion.theta[:, i] + motion.theta_change[:, i], self._theta[i, 1])
        outwards = float(d @ g.radial[i])
        side = (j - 0.5) * self._placement.parallelogram_width_mm * float(d @ g.tangential[i])
        swing = np.sort(outwards * g.upper_arm_length * MM_PER_M * np.stack(cosine_range(low, high)), axis=0)
        elbow = outwards * g.base_radii[i] * MM_PER_M + side + swing[..., None]
        middle = boxes.centres @ d + outwards * g.platform_radius * MM_PER_M + side
        wrist = (middle + np.stack([-1.0, 1.0])[:, None] * (boxes.halves @ np.abs(d)))[..., None]
        return elbow, wrist


class SpringReach:
    """Reach over the cube of the springs across the pairs: of their middles, and of their bodies about these.

    A middle reaches as the same place on rod 0 does, half the parallelogram's width further along the shoulder axis;
    the body about it, see `sway_of`, keeps its chain's axes.

    Args:
        placement: Placement of the links.
        limits: The cube.
        theta: (3, 2) enclosed range of the shoulder angles over the cube, rad.
    """

    def __init__(self, placement: LinkPlacement, limits: CheckLimits, theta: np.ndarray) -> None:
        self._placement, self._rods = placement, RodReach(placement, limits, theta)

    def roughest(self, body: CollisionBody, direction: np.ndarray) -> float:
        """Bounds the reach, arguments as `coarse`."""
        return self.coarse(body, direction)

    def coarse(self, body: CollisionBody, direction: np.ndarray) -> float:
        """Bounds the reach from the first boxes alone, arguments and result as of `RodReach`."""
        return self._rods.coarse(self._middle(body), direction) + self._beyond(body, direction)

    def refined(self, body: CollisionBody, direction: np.ndarray, floor_mm: float) -> tuple[float, float]:
        """Bounds the reach closely where it exceeds a floor, arguments and results as of `RodReach`."""
        beyond = self._beyond(body, direction)
        bound, attained = self._rods.refined(self._middle(body), direction, floor_mm - beyond)
        return bound + beyond, attained + beyond

    def _middle(self, body: CollisionBody) -> CollisionBody:
        """The place of a spring's middle along and beside rod 0, as a body of one point."""
        i, k = (int(word) for word in body.link.split("_")[1:])
        x, z = self._placement.springs_mm[k]
        point = Mesh(np.array([[x, 0.0, z]]), np.zeros((1, 3), dtype=int), 0.0)
        return replace(body, link=f"rod_{i}_0", mesh=point, placement=np.eye(4))

    def _beyond(self, body: CollisionBody, direction: np.ndarray) -> float:
        """How far a spring's body reaches along a direction from the place on rod 0, mm."""
        turn = chain_turn(self._placement.geometry, chain_of(body.link))[:3, :3]
        aside = self._placement.parallelogram_width_mm / 2.0 * float(direction @ turn[:, 1])
        return aside + float((body.vertices @ (direction @ turn)).max())


def _at_most(factor: np.ndarray, between: np.ndarray) -> np.ndarray:
    """(n, k) largest product of factors (k,) with numbers in ranges (2, n, 1)."""
    return np.maximum(factor, 0.0) * between[1] + np.minimum(factor, 0.0) * between[0]


def turned_reach(axes: np.ndarray, vectors: np.ndarray, turn: np.ndarray) -> np.ndarray:
    """Farthest reach of vectors that may turn about x.

    Args:
        axes: (n, 3) components of the direction along which they reach.
        vectors: (k, 3) the vectors.
        turn: (n, 1) largest turn about x either way, rad.

    Returns:
        (n, k) reach, in the unit of the vectors.
    """
    if not turn.any():
        return axes @ vectors.T
    apart = np.arctan2(axes[:, 2], axes[:, 1])[:, None] - np.arctan2(vectors[:, 2], vectors[:, 1])
    apart = np.abs(np.remainder(apart + np.pi, 2.0 * np.pi) - np.pi)
    across = np.hypot(axes[:, 1], axes[:, 2])[:, None] * np.hypot(vectors[:, 1], vectors[:, 2])
    return axes[:, :1] * vectors[:, 0] + across * np.cos(np.maximum(apart - turn, 0.0))


def _turned(axes: np.ndarray, vectors: np.ndarray, turn: np.ndarray, phi: np.ndarray) -> np.ndarray:
    """(n, k) farthest reach of (k, 3) vectors that turn about x by up to (n, 1) turn, then with their frame.

    The frame turns by any rotation up to (n, 1) phi in [0, pi]. The axes (n, 3) are the components, in the frame before
    it turns, of the direction along which they reach.
    """
    size, along = np.linalg.norm(vectors, axis=1), turned_reach(axes, vectors, turn)
    c = np.cos(phi)
    square = np.sqrt(np.maximum(size**2 - along**2, 0.0))
    return np.where(along >= size * c, size, along * c + square * np.sin(phi))


class _Boxes:
    """Boxes of handle positions, the links at their centres and bounds on what moves inside them."""

    def __init__(self, placement: LinkPlacement, centres: np.ndarray, halves: np.ndarray) -> None:
        self.centres, self.halves = centres, halves
        self.motion = box_motion(placement.geometry, centres, halves)
        self.links = placement(centres)


def cosine_range(low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Encloses the cosine over ranges of angles within (-2 pi, 2 pi), each (n,)."""
    ends = np.stack([np.cos(low), np.cos(high)])
    most = np.where((low <= 0.0) & (high >= 0.0), 1.0, ends.max(axis=0))
    over = (low <= -np.pi) & (high >= -np.pi) | (low <= np.pi) & (high >= np.pi)
    return np.where(over, -1.0, ends.min(axis=0)), most
