"""Shapes contained in solids, and the signed distance of points to them, mm."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations
from math import cos, hypot, inf, sin, sqrt
from typing import Any, Protocol

import numpy as np

from delta_cad.common.jit import inlined, unrolled_dispatch
from delta_cad.dimensions.bracket import Circle

_DIRECTIONS = 180  # in which a hull's arcs are looked at: to 5 um of a circle of 30 mm; and along each straight side's
_NORMALS = np.array([f(np.linspace(0.0, 2.0 * np.pi, _DIRECTIONS, endpoint=False)) for f in (np.cos, np.sin)])
Points = tuple[np.ndarray, np.ndarray]
"""(n, 3) middles of balls that lie within a solid, and their radii (n)."""
_FIRST = 32  # points of many that are held against a hull first
TOGETHER = 8  # points of a row that are looked at by one ball first
_FAR_MM = 24.0  # more than the largest ball and what is looked at around it: beyond, a bound will do


class Shape(Protocol):
    """What points are held against."""

    def signed_distance(self, points: np.ndarray) -> np.ndarray:
        """Computes how far points (n, 3) in the shape's frame are off it, (n); not above 0 inside."""
        ...


@dataclass(frozen=True)
class Prism:
    """Hull of circles in the plane of x and z, from one y to another; beyond `_FAR_MM` a lower bound of the distance.

    Both its ends are bevelled, as its edges are broken.
    """

    circles: Sequence[Circle]
    y_mm: tuple[float, float]
    bevel_mm: float = 0.0

    def signed_distance(self, points: np.ndarray) -> np.ndarray:
        """As of `Shape`."""
        return _distances(_fill_prism, points, self._outline, *self.y_mm, self.bevel_mm, _FAR_MM)

    def lower_bound(self, points: np.ndarray) -> np.ndarray:
        """Bounds `signed_distance` of points (n, 3) from below by a box around the hull, (n)."""
        return _distances(_fill_prism, points, self._outline, *self.y_mm, self.bevel_mm, -inf)

    def across_mm(self, points: np.ndarray) -> np.ndarray:
        """Computes how far points (n, 3) are off the outline, in its plane, (n)."""
        return _distances(_fill_across, points, self._outline, *self.y_mm, _FAR_MM)

    @cached_property
    def _outline(self) -> np.ndarray:
        """(n, 3) directions, `_NORMALS` and those of the straight sides, and how far the outline reaches along each."""
        circles = np.array(self.circles)
        normals = np.hstack([_NORMALS, *(_tangents(a, b) for a, b in combinations(circles, 2))])
        reach = circles[:, :2] @ normals + circles[:, 2:]
        on_two = np.partition(reach, -2, axis=0)[-2] > reach.max(axis=0) - 1e-9 if len(circles) > 1 else False
        kept = (np.arange(normals.shape[1]) < _DIRECTIONS) | on_two
        return np.column_stack([normals[:, kept].T, reach.max(axis=0)[kept]])


@dataclass(frozen=True)
class Windowed:
    """Prism with a window through it, the hull of circles in the same plane."""

    whole: Prism
    window: Prism

    def signed_distance(self, points: np.ndarray) -> np.ndarray:
        """As of `Shape`."""
        inside = np.minimum(self.window.across_mm(points), 0.0)
        low, high = self.whole.y_mm
        along = np.maximum(low - points[:, 1], points[:, 1] - high)
        through = np.hypot(-inside, np.maximum(along, 0.0))
        return np.where(inside < 0.0, through, self.whole.signed_distance(points))


@dataclass(frozen=True)
class Beam:
    """Hull of two circles in the plane of x and z, about the origin and a length along x, from one y to another."""

    length_mm: float
    radii_mm: tuple[float, float]
    y_mm: tuple[float, float]

    def signed_distance(self, points: np.ndarray) -> np.ndarray:
        """As of `Shape`."""
        return _distances(_fill_beam, points, self.length_mm, *self.radii_mm, *self.y_mm)


@dataclass(frozen=True)
class Round:
    """Cylinder about an axis along y through (x, z)."""

    radius_mm: float
    y_mm: tuple[float, float]
    at_mm: tuple[float, float] = (0.0, 0.0)

    def signed_distance(self, points: np.ndarray) -> np.ndarray:
        """As of `Shape`."""
        return _distances(_fill_round, points, self.radius_mm, *self.at_mm, *self.y_mm)


@dataclass(frozen=True)
class Bar:
    """Cylinder from a point along a unit vector."""

    radius_mm: float
    length_mm: float
    from_mm: np.ndarray
    along: np.ndarray

    def signed_distance(self, points: np.ndarray) -> np.ndarray:
        """As of `Shape`."""
        return _distances(_fill_bar, points, self.radius_mm, self.length_mm, *self.from_mm, *self.along)


@dataclass(frozen=True)
class Ring:
    """Segment of a ring about y between two radii and two angles from x to z; as of `Prism` beyond `_FAR_MM`."""

    radii_mm: tuple[float, float]
    angles_rad: tuple[float, float]
    y_mm: tuple[float, float]

    def signed_distance(self, points: np.ndarray) -> np.ndarray:
        """As of `Shape`."""
        middle, half = sum(self.angles_rad) / 2.0, (self.angles_rad[1] - self.angles_rad[0]) / 2.0
        turns = cos(middle), sin(middle), cos(half), sin(half)
        return _distances(_fill_ring, points, *self.radii_mm, *turns, *self.y_mm)


@dataclass(frozen=True)
class Block:
    """Box along three axes, the columns of a matrix (3, 3), from a point; bevelled around its end along the last."""

    axes: np.ndarray
    from_mm: tuple[float, float, float]
    low_mm: tuple[float, float, float]
    high_mm: tuple[float, float, float]
    bevel_mm: float = 0.0

    def signed_distance(self, points: np.ndarray) -> np.ndarray:
        """As of `Shape`."""
        seen = (points - np.array(self.from_mm)) @ self.axes
        return _distances(_fill_block, seen, *self.low_mm, *self.high_mm, self.bevel_mm)


@dataclass(frozen=True)
class Placed:
    """Shape along other axes, the columns of a matrix (3, 3), from a point."""

    axes: np.ndarray
    shape: Shape
    from_mm: tuple[float, float, float] = (0.0, 0.0, 0.0)

    def signed_distance(self, points: np.ndarray) -> np.ndarray:
        """As of `Shape`."""
        return self.shape.signed_distance((points - np.array(self.from_mm)) @ self.axes)


def union_distance(shapes: Sequence[Shape], points: np.ndarray) -> np.ndarray:
    """Computes the signed distance of points (..., 3) to the union of several shapes, (...)."""
    flat = points.reshape(-1, 3)
    return np.min([shape.signed_distance(flat) for shape in shapes], axis=0).reshape(points.shape[:-1])


def least_distance(shapes: Sequence[Shape], points: np.ndarray) -> float:
    """Computes the least signed distance of points (..., 3) to the union of several shapes.

    It is that of `union_distance`: of a hull only points that a box around it leaves below the least so far are looked
    at, the nearest to the box first.
    """
    flat, least = points.reshape(-1, 3), inf
    for shape in shapes:
        left = flat
        if isinstance(shape, Prism) and len(flat) > _FIRST:
            bound = shape.lower_bound(flat)
            first = np.argpartition(bound, _FIRST)[:_FIRST]
            least = min(least, float(shape.signed_distance(flat[first]).min()))
            left = flat[bound < least]
        if len(left):
            least = min(least, float(shape.signed_distance(left).min()))
    return least


def collides(shapes: Sequence[Shape], rows: np.ndarray, radius_mm: float) -> np.ndarray:
    """Whether a ball at any point of rows of points (..., k, 3) meets one of several shapes, (...).

    Points that follow one another are looked at one by one only where a ball around `TOGETHER` of them meets it.
    """
    points, count = rows.reshape(-1, *rows.shape[-2:]), rows.shape[-2]
    runs = np.minimum(np.arange(0, count, TOGETHER)[:, None] + np.arange(TOGETHER), count - 1)  # (runs, TOGETHER)
    middles = (points[:, runs[:, 0]] + points[:, runs[:, -1]]) / 2.0
    around = np.linalg.norm(points[:, runs] - middles[:, :, None], axis=3).max(axis=2) + radius_mm
    found = np.zeros(len(points), dtype=bool)
    for shape in shapes:
        free = np.flatnonzero(~found)
        row, run = np.nonzero(
            shape.signed_distance(middles[free].reshape(-1, 3)).reshape(-1, len(runs)) <= around[free]
        )
        row = free[row]
        off = shape.signed_distance(points[row[:, None], runs[run]].reshape(-1, 3)).reshape(-1, TOGETHER)
        found[row[(off <= radius_mm).any(axis=1)]] = True
    return found.reshape(rows.shape[:-2])


def _tangents(one: np.ndarray, other: np.ndarray) -> np.ndarray:
    """(2, 2) normals of the outer tangents of two circles (x, z, radius), or (2, 0): one lies within the other."""
    (x, z), less = other[:2] - one[:2], one[2] - other[2]
    if hypot(x, z) <= abs(less):
        return np.zeros((2, 0))
    turns = np.arctan2(z, x) + np.array([-1.0, 1.0]) * np.arccos(less / hypot(x, z))
    return np.array([np.cos(turns), np.sin(turns)])


def _distances(fill: Callable[..., None], points: np.ndarray, *numbers: float | np.ndarray) -> np.ndarray:
    """Computes distances of points (n, 3), (n), by a function below that fills them."""
    out = np.empty(len(points))
    fill(np.ascontiguousarray(points, dtype=float), *numbers, out)
    return out


_LOOP = """for k in range(len(points)):
        out[k] = {0}(points[k, 0], points[k, 1], points[k, 2]{1})"""


def _of_points(distance: Any, *numbers: str) -> Any:
    """Compiles (points, numbers, out), which fills the distance of a point (x, y, z, numbers), for `_distances`."""
    given = "".join(f", {number}" for number in numbers)
    return unrolled_dispatch(f"points{given}, out", [(distance, given)], _LOOP)


@inlined
def _between(across, y, low, high):
    """Distance to what has an outline `across` and two flat ends."""
    along = max(low - y, y - high)
    return hypot(max(across, 0.0), max(along, 0.0)) + min(max(across, along), 0.0)


@inlined
def _bevelled(across, along, bevel):
    """Distance to the bevel between what is so far off a side and off an end."""
    return (across + along + bevel) / sqrt(2.0)


@inlined
def _across(x, y, z, outline, low, high, far):
    """Distance to an outline in its plane; where a box around it is beyond `far`, to that box."""
    quarter = _DIRECTIONS // 4
    east, north, west, south = outline[0, 2], outline[quarter, 2], outline[2 * quarter, 2], outline[3 * quarter, 2]
    across = max(max(x - east, -x - west), max(z - north, -z - south))
    if _between(across, y, low, high) < far:
        across = -inf
        for j in range(len(outline)):
            across = max(across, x * outline[j, 0] + z * outline[j, 1] - outline[j, 2])
    return across


@inlined
def _prism(x, y, z, outline, low, high, bevel, far):
    across = _across(x, y, z, outline, low, high, far)
    return max(_between(across, y, low, high), _bevelled(across, max(low - y, y - high), bevel))


@inlined
def _beam(x, y, z, length, root, end, low, high):
    lean = (root - end) / length  # sine of the sides' angle to the middle
    rise, z = sqrt(1.0 - lean**2), abs(z)
    along = x * rise - z * lean
    if along < 0.0:
        across = hypot(x, z) - root
    elif along > length * rise:
        across = hypot(x - length, z) - end
    else:
        across = x * lean + z * rise - root
    return _between(across, y, low, high)


@inlined
def _round(x, y, z, radius, at_x, at_z, low, high):
    return _between(hypot(x - at_x, z - at_z) - radius, y, low, high)


@inlined
def _bar(x, y, z, radius, length, from_x, from_y, from_z, along_x, along_y, along_z):
    x, y, z = x - from_x, y - from_y, z - from_z
    along = x * along_x + y * along_y + z * along_z
    x, y, z = x - along * along_x, y - along * along_y, z - along * along_z
    return _between(sqrt(x * x + y * y + z * z) - radius, along, 0.0, length)


@inlined
def _ring(x, y, z, inner, outer, cosine, sine, cos_half, sin_half, low, high):
    radius = hypot(x, z)
    across = max(inner - radius, radius - outer)  # off the whole ring
    ahead, aside = cosine * x + sine * z, abs(cosine * z - sine * x)  # of the middle
    if ahead < radius * cos_half and _between(across, y, low, high) < _FAR_MM:
        along, off = ahead * cos_half + aside * sin_half, aside * cos_half - ahead * sin_half  # of the nearer end
        across = hypot(along - min(max(along, inner), outer), off)
    return _between(across, y, low, high)


@inlined
def _block(x, y, z, low_x, low_y, low_z, high_x, high_y, high_z, bevel):
    a, b, c = max(low_x - x, x - high_x), max(low_y - y, y - high_y), max(low_z - z, z - high_z)
    out = max(a, 0.0), max(b, 0.0), max(c, 0.0)
    off = sqrt(out[0] * out[0] + out[1] * out[1] + out[2] * out[2]) + min(max(a, b, c), 0.0)
    return max(off, _bevelled(max(a, b), z - high_z, bevel))


_fill_across = _of_points(_across, "outline", "low", "high", "far")
_fill_prism = _of_points(_prism, "outline", "low", "high", "bevel", "far")
_fill_beam = _of_points(_beam, "length", "root", "end", "low", "high")
_fill_round = _of_points(_round, "radius", "at_x", "at_z", "low", "high")
_fill_bar = _of_points(_bar, "radius", "length", "from_x", "from_y", "from_z", "along_x", "along_y", "along_z")
_fill_ring = _of_points(_ring, "inner", "outer", "cosine", "sine", "cos_half", "sin_half", "low", "high")
_fill_block = _of_points(_block, "low_x", "low_y", "low_z", "high_x", "high_y", "high_z", "bevel")
