"""Which joint angles occur in the cube: rigorous supersets, as ranges and as rasters of two angles."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from delta_cad.checks.clearance.motion import box_motion, cube_boxes
from delta_cad.common.units import MM_PER_M
from delta_cad.mechanism.geometry import DeltaGeometry
from delta_cad.mechanism.inverse import closure_margin

BOXES_PER_EDGE = 16
HALVINGS = 3  # of boxes that are too coarse
COARSE_RAD = 0.08  # a box over which an angle may change by more is halved: near a fold the angles change fast
BEYOND_RAD = np.radians(1.5)  # of what occurs, that a range may be too wide: stops stand 3 degrees beyond
ROUNDING_RAD = 1e-9  # angles are good to 1e-15; this keeps a point on the rim of a box inside its cells
OCTANTS = np.array(np.meshgrid([-1.0, 1.0], [-1.0, 1.0], [-1.0, 1.0])).reshape(3, -1).T
RASTER = 128  # cells along each angle of a raster


class FoldError(Exception):
    """The cube could not be proven free of positions at which a chain folds or cannot be closed."""


@dataclass(frozen=True)
class Raster:
    """A set of pairs of angles as marked cells of a grid.

    Attributes:
        low: (2,) lower corner of the grid, rad.
        high: (2,) upper corner, rad.
        total: (RASTER + 1, RASTER + 1) marked cells below and left of each grid node.
    """

    low: np.ndarray
    high: np.ndarray
    total: np.ndarray

    @classmethod
    def of_boxes(cls, centres: np.ndarray, halves: np.ndarray) -> Raster:
        """The cells that any of the given boxes touches.

        Args:
            centres: (n, 2) centres, rad.
            halves: (n, 2) half widths, rad.

        Returns:
            The raster.
        """
        halves = halves + ROUNDING_RAD
        low, high = (centres - halves).min(axis=0), (centres + halves).max(axis=0)
        first, last = _cells(centres - halves, low, high), _cells(centres + halves, low, high) + 1
        change = np.zeros((RASTER + 1, RASTER + 1))
        for x, y, sign in ((first, first, 1), (last, first, -1), (first, last, -1), (last, last, 1)):
            np.add.at(change, (x[:, 0], y[:, 1]), sign)
        marked = change.cumsum(axis=0).cumsum(axis=1)[:RASTER, :RASTER] > 0.5
        total = np.zeros((RASTER + 1, RASTER + 1))
        total[1:, 1:] = marked.cumsum(axis=0).cumsum(axis=1)
        return cls(low, high, total)

    def touched(self, centres: np.ndarray, halves: np.ndarray) -> np.ndarray:
        """Which boxes may hold a pair of angles of the set.

        Args:
            centres: (n, 2) centres, rad.
            halves: (n, 2) half widths, rad.

        Returns:
            (n,) bool, False only where the box certainly holds none.
        """
        first = _cells(centres - halves, self.low, self.high)
        last = _cells(centres + halves, self.low, self.high) + 1
        count = (
            self.total[last[:, 0], last[:, 1]]
            - self.total[first[:, 0], last[:, 1]]
            - self.total[last[:, 0], first[:, 1]]
            + self.total[first[:, 0], first[:, 1]]
        )
        outside = (centres + halves < self.low).any(axis=1) | (centres - halves > self.high).any(axis=1)
        return (count > 0.5) & ~outside


def _cells(points: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """(n, 2) grid cells of points, moved into the grid; rounding is the same for marking and for asking."""
    step = np.maximum(high - low, 1e-12) / RASTER
    return np.clip(np.floor((points - low) / step).astype(int), 0, RASTER - 1)


@dataclass(frozen=True)
class JointRanges:
    """Supersets of the joint angles over the cube.

    Attributes:
        theta: (3, 2) lowest and highest shoulder angle of each chain, rad.
        lean: (3, 2) lowest and highest lean, rad, exact.
        neighbours: Per chain i the raster of (theta_i, theta_(i + 1)).
        at_wrist: Per chain the raster of (angle of the forearm from radial towards +z, lean).
        at_elbow: Per chain the raster of (angle of the forearm from the upper arm, lean).
    """

    theta: np.ndarray
    lean: np.ndarray
    neighbours: tuple[Raster, ...]
    at_wrist: tuple[Raster, ...]
    at_elbow: tuple[Raster, ...]


def joint_ranges(g: DeltaGeometry, centre_mm: np.ndarray, half_side_mm: float) -> JointRanges:
    """Joint angles over the cube, enclosed box by box.

    Args:
        g: The mechanism.
        centre_mm: (3,) centre of the cube, mm.
        half_side_mm: Half its side, mm.

    Returns:
        The enclosures.

    Raises:
        FoldError: A chain folds or is open in the cube, or may be, at the finest subdivision.
    """
    x, y, z = centre_mm.tolist()
    return _joint_ranges(g, (x, y, z), float(half_side_mm))


@lru_cache(maxsize=4)  # outline, contacts and clearance ask for the same cube
def _joint_ranges(g: DeltaGeometry, centre_mm: tuple[float, float, float], half_side_mm: float) -> JointRanges:
    axis = half_side_mm * np.linspace(-1.0, 1.0, BOXES_PER_EDGE + 1)
    nodes = np.array(centre_mm) + np.stack(np.meshgrid(axis, axis, axis), axis=-1).reshape(-1, 3)
    open_ = (closure_margin(g, nodes / MM_PER_M) <= 0.0).any(axis=-1)
    if open_.any():
        x, y, z = nodes[int(np.argmax(open_))]
        raise FoldError(f"a chain folds in the cube, or cannot be closed, as at ({x:.3f}, {y:.3f}, {z:.3f}) mm")
    boxes = _fine_boxes(g, np.array(centre_mm), half_side_mm)
    motion = box_motion(g, *boxes)
    if not np.isfinite(motion.theta_change).all():
        finest = BOXES_PER_EDGE * 2**HALVINGS
        raise FoldError(f"a chain may fold in the cube: not excluded with {finest} boxes an edge")
    theta, spread = motion.theta, motion.theta_change
    lean, lean_half = (motion.lean_low + motion.lean_high) / 2.0, (motion.lean_high - motion.lean_low) / 2.0
    wrist_angle = theta + motion.elbow_angle
    elbow, elbow_half = (motion.elbow_low + motion.elbow_high) / 2.0, (motion.elbow_high - motion.elbow_low) / 2.0

    def raster(x: np.ndarray, dx: np.ndarray, y: np.ndarray, dy: np.ndarray) -> Raster:
        return Raster.of_boxes(np.stack([x, y], axis=1), np.stack([dx, dy], axis=1))

    return JointRanges(
        theta=_widest(g, boxes, theta, spread),
        lean=np.stack([motion.lean_low.min(axis=0), motion.lean_high.max(axis=0)], axis=1),
        neighbours=tuple(
            raster(theta[:, i], spread[:, i], theta[:, (i + 1) % 3], spread[:, (i + 1) % 3]) for i in range(3)
        ),
        at_wrist=tuple(raster(wrist_angle[:, i], motion.rotation[:, i], lean[:, i], lean_half[:, i]) for i in range(3)),
        at_elbow=tuple(raster(elbow[:, i], elbow_half[:, i], lean[:, i], lean_half[:, i]) for i in range(3)),
    )


def _widest(
    g: DeltaGeometry, boxes: tuple[np.ndarray, np.ndarray], theta: np.ndarray, spread: np.ndarray
) -> np.ndarray:
    """(3, 2) ranges of (n, 3) angles over boxes and what they change there, those boxes halved that reach too far."""
    centres, halves = boxes
    least, most = theta.min(axis=0), theta.max(axis=0)  # which occur
    ranges = np.stack([least, most], axis=1)
    for turn in range(HALVINGS + 1):
        low, high = theta - spread, theta + spread
        far = ((low < least - BEYOND_RAD) | (high > most + BEYOND_RAD)).any(axis=1)
        left = ~far if turn < HALVINGS else np.ones(len(far), dtype=bool)
        if left.any():
            ranges[:, 0] = np.minimum(ranges[:, 0], low[left].min(axis=0))
            ranges[:, 1] = np.maximum(ranges[:, 1], high[left].max(axis=0))
        if left.all():
            break
        centres, halves = _halved(centres[far], halves[far])
        motion = box_motion(g, centres, halves)
        theta, spread = motion.theta, motion.theta_change
        least, most = np.minimum(least, theta.min(axis=0)), np.maximum(most, theta.max(axis=0))
    return ranges


def _halved(centres: np.ndarray, halves: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The eight boxes that each of some is made of."""
    eighths = np.repeat(halves / 2.0, 8, axis=0)
    return np.repeat(centres, 8, axis=0) + eighths * np.tile(OCTANTS, (len(centres), 1)), eighths


def _fine_boxes(g: DeltaGeometry, centre_mm: np.ndarray, half_side_mm: float) -> tuple[np.ndarray, np.ndarray]:
    """(n, 3) centres and (n, 3) half sides of boxes that fill the cube, smaller where the angles change fast."""
    centres, halves = cube_boxes(centre_mm, half_side_mm, BOXES_PER_EDGE)
    kept = []
    for _ in range(HALVINGS):
        motion = box_motion(g, centres, halves)
        spread = np.maximum(motion.theta_change, motion.rotation).max(axis=1)
        coarse = ~(spread <= COARSE_RAD)
        kept.append((centres[~coarse], halves[~coarse]))
        centres, halves = _halved(centres[coarse], halves[coarse])
    kept.append((centres, halves))
    return np.concatenate([c for c, _ in kept]), np.concatenate([h for _, h in kept])
