"""Which joint angles occur in the cube: rigorous supersets, as ranges and as rasters of two angles."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, lru_cache, partial

import numpy as np

from delta_cad.checks.clearance.motion import BoxMotion, box_motion, cube_boxes
from delta_cad.common.units import MM_PER_M
from delta_cad.mechanism.geometry import DeltaGeometry
from delta_cad.mechanism.inverse import closure_margin

BOXES_PER_EDGE = 16
HALVINGS = 3  # of boxes that are too coarse
_COARSE_RAD = 0.08  # a box over which an angle may change by more is halved: near a fold the angles change fast
_BEYOND_RAD = np.radians(1.5)  # of what occurs, that a range may be too wide: stops stand 3 degrees beyond
_ROUNDING_RAD = 1e-9  # angles are good to 1e-15; this keeps a point on the rim of a box inside its cells
_OCTANTS = np.array(np.meshgrid([-1.0, 1.0], [-1.0, 1.0], [-1.0, 1.0])).reshape(3, -1).T
BOXES_MOST = 100_000  # that rasters are made of: beyond, those that are too coarse stay so
_RASTER = 128  # cells along each angle of a raster
_NEAR_CELLS, _FILLED_CELLS = 1, 8  # that a box may reach beyond what occurs, and half of a gap in that, of no meaning


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
        halves = halves + _ROUNDING_RAD
        low, high = (centres - halves).min(axis=0), (centres + halves).max(axis=0)
        first, last = _cells(centres - halves, low, high), _cells(centres + halves, low, high) + 1
        change = np.zeros((_RASTER + 1, _RASTER + 1))
        for x, y, sign in ((first, first, 1), (last, first, -1), (first, last, -1), (last, last, 1)):
            np.add.at(change, (x[:, 0], y[:, 1]), sign)
        return cls(low, high, _totals(change.cumsum(axis=0).cumsum(axis=1)[:_RASTER, :_RASTER] > 0.5))

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
        count = _counted(self.total, first, last)
        outside = (centres + halves < self.low).any(axis=1) | (centres - halves > self.high).any(axis=1)
        return (count > 0) & ~outside


def _cells(points: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """(n, 2) grid cells of points, moved into the grid; rounding is the same for marking and for asking."""
    step = np.maximum(high - low, 1e-12) / _RASTER
    return np.clip(np.floor((points - low) / step).astype(int), 0, _RASTER - 1)


@dataclass(frozen=True)
class JointRanges:
    """Supersets of the joint angles over the cube.

    Attributes:
        theta: (3, 2) lowest and highest shoulder angle of each chain, rad.
        lean: (3, 2) lowest and highest lean, rad, exact.
        pairs: Gives what `_tight_pairs` does, for the rasters.
    """

    theta: np.ndarray
    lean: np.ndarray
    pairs: Callable[[], tuple[np.ndarray, np.ndarray]]

    @cached_property
    def _rasters(self) -> tuple[Raster, ...]:
        return tuple(Raster.of_boxes(*one) for one in zip(*self.pairs(), strict=True))

    @property
    def neighbours(self) -> tuple[Raster, ...]:
        """Per chain i the raster of (theta_i, theta_(i + 1))."""
        return self._rasters[:3]

    @property
    def at_wrist(self) -> tuple[Raster, ...]:
        """Per chain the raster of (angle of the forearm from radial towards +z, lean)."""
        return self._rasters[3:6]

    @property
    def at_elbow(self) -> tuple[Raster, ...]:
        """Per chain the raster of (angle of the forearm from the upper arm, lean)."""
        return self._rasters[6:]


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
    return JointRanges(
        theta=_widest(g, boxes, motion.theta, motion.theta_change),
        lean=np.stack([motion.lean_low.min(axis=0), motion.lean_high.max(axis=0)], axis=1),
        pairs=partial(_tight_pairs, g, boxes, motion, nodes),
    )


def _pairs_of_angles(motion: BoxMotion) -> tuple[np.ndarray, np.ndarray]:
    """(9, n, 2) centres and half widths of the rasters' angles over boxes, in the order of `JointRanges`."""
    lean, lean_half = (motion.lean_low + motion.lean_high) / 2.0, (motion.lean_high - motion.lean_low) / 2.0
    elbow, elbow_half = (motion.elbow_low + motion.elbow_high) / 2.0, (motion.elbow_high - motion.elbow_low) / 2.0
    theta, spread = motion.theta, motion.theta_change
    pairs = (
        ((theta, np.roll(theta, -1, axis=1)), (spread, np.roll(spread, -1, axis=1))),
        ((theta + motion.elbow_angle, lean), (motion.rotation, lean_half)),
        ((elbow, lean), (elbow_half, lean_half)),
    )
    centres, halves = (np.concatenate([np.stack(one[k], axis=-1) for one in pairs], axis=1) for k in (0, 1))
    return np.swapaxes(centres, 0, 1), np.swapaxes(halves, 0, 1)


def _tight_pairs(
    g: DeltaGeometry, boxes: tuple[np.ndarray, np.ndarray], motion: BoxMotion, nodes: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """(9, n, 2) the same over boxes that fill the cube, those halved that reach far beyond what occurs.

    Args:
        g: The mechanism.
        boxes: (n, 3) centres and half sides, mm.
        motion: Over these.
        nodes: (m, 3) positions of the cube, those on its sides among them, mm.
    """
    occurring, _ = _pairs_of_angles(box_motion(g, nodes, np.zeros_like(nodes)))
    beyond = [_Beyond(points) for points in occurring]
    kept: list[tuple[np.ndarray, np.ndarray]] = []
    count = 0
    for turn in range(HALVINGS + 1):
        centres, halves = _pairs_of_angles(motion)
        far = np.any([one(*pair) for one, *pair in zip(beyond, centres, halves, strict=True)], axis=0)
        count += int((~far).sum())
        if turn == HALVINGS or count + 8 * far.sum() > BOXES_MOST:
            far[:] = False
        kept.append((centres[:, ~far], halves[:, ~far]))
        if not far.any():
            break
        boxes = _halved(boxes[0][far], boxes[1][far])
        motion = box_motion(g, *boxes)
    return np.concatenate([c for c, _ in kept], axis=1), np.concatenate([h for _, h in kept], axis=1)


class _Beyond:
    """Whether boxes of two angles reach beyond what occurs: what they take of a grid around that is counted.

    Args:
        points: (m, 2) pairs of angles that occur, so densely that gaps of less than two times `_FILLED_CELLS` are none.
    """

    def __init__(self, points: np.ndarray) -> None:
        rim = _FILLED_CELLS + _NEAR_CELLS + 1
        low, high = points.min(axis=0), points.max(axis=0)
        self._step = np.maximum(high - low, 1e-12) / _RASTER
        self._low, self._count = low - rim * self._step, _RASTER + 2 * rim
        marked = np.zeros((self._count, self._count), dtype=bool)
        marked[tuple(self._cells(points).T)] = True
        filled = ~_grown(~_grown(marked, _FILLED_CELLS), _FILLED_CELLS)
        self._total = _totals(~_grown(filled, _NEAR_CELLS))

    def _cells(self, points: np.ndarray) -> np.ndarray:
        return np.clip(np.floor((points - self._low) / self._step), 0, self._count - 1).astype(int)

    def __call__(self, centres: np.ndarray, halves: np.ndarray) -> np.ndarray:
        """(n,) of boxes by centres and half widths (n, 2), rad."""
        return _counted(self._total, self._cells(centres - halves), self._cells(centres + halves) + 1) > 0


def _totals(marked: np.ndarray) -> np.ndarray:
    """Marked cells below and left of each node of a grid."""
    return np.pad(marked.astype(int).cumsum(axis=0).cumsum(axis=1), ((1, 0), (1, 0)))


def _counted(total: np.ndarray, first: np.ndarray, last: np.ndarray) -> np.ndarray:
    """(n,) marked cells from cells `first` (n, 2) to before cells `last`."""
    return (
        total[last[:, 0], last[:, 1]]
        - total[first[:, 0], last[:, 1]]
        - total[last[:, 0], first[:, 1]]
        + total[first[:, 0], first[:, 1]]
    )


def _grown(marked: np.ndarray, cells: int) -> np.ndarray:
    """The marked cells of a grid and those at most so many beside them; what lies outside is not marked."""
    size = np.array(marked.shape)
    at = np.stack(np.meshgrid(*map(np.arange, size), indexing="ij"), axis=-1).reshape(-1, 2)
    first, last = np.maximum(at - cells, 0), np.minimum(at + cells + 1, size)
    return (_counted(_totals(marked), first, last) > 0).reshape(size)


def _widest(
    g: DeltaGeometry, boxes: tuple[np.ndarray, np.ndarray], theta: np.ndarray, spread: np.ndarray
) -> np.ndarray:
    """(3, 2) ranges of (n, 3) angles over boxes and what they change there, those boxes halved that reach too far."""
    centres, halves = boxes
    least, most = theta.min(axis=0), theta.max(axis=0)  # which occur
    ranges = np.stack([least, most], axis=1)
    for turn in range(HALVINGS + 1):
        low, high = theta - spread, theta + spread
        far = ((low < least - _BEYOND_RAD) | (high > most + _BEYOND_RAD)).any(axis=1)
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
    return np.repeat(centres, 8, axis=0) + eighths * np.tile(_OCTANTS, (len(centres), 1)), eighths


def _fine_boxes(g: DeltaGeometry, centre_mm: np.ndarray, half_side_mm: float) -> tuple[np.ndarray, np.ndarray]:
    """(n, 3) centres and (n, 3) half sides of boxes that fill the cube, smaller where the angles change fast."""
    centres, halves = cube_boxes(centre_mm, half_side_mm, BOXES_PER_EDGE)
    kept = []
    for _ in range(HALVINGS):
        motion = box_motion(g, centres, halves)
        spread = np.maximum(motion.theta_change, motion.rotation).max(axis=1)
        coarse = ~(spread <= _COARSE_RAD)
        kept.append((centres[~coarse], halves[~coarse]))
        centres, halves = _halved(centres[coarse], halves[coarse])
    kept.append((centres, halves))
    return np.concatenate([c for c, _ in kept]), np.concatenate([h for _, h in kept])
