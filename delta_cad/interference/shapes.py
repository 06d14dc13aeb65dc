"""Shapes contained in solids, and the signed distance of points to them, mm."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from itertools import combinations
from math import cos, hypot, inf, sin, sqrt
from typing import Protocol

import numpy as np

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
        return self._distance(self.across_mm(points), points[:, 1])

    def lower_bound(self, points: np.ndarray) -> np.ndarray:
        """Bounds `signed_distance` of points (n, 3) from below by a box around the hull, (n)."""
        return self._distance(self._across_box(points), points[:, 1])

    def _distance(self, across: np.ndarray, y: np.ndarray) -> np.ndarray:
        along = np.maximum(self.y_mm[0] - y, y - self.y_mm[1])
        return np.maximum(_adjacent(across, y, self.y_mm), _bevelled(across, along, self.bevel_mm))

    def _across_box(self, points: np.ndarray) -> np.ndarray:
        (east, north, west, south), (x, _, z) = self._outline[1][: _DIRECTIONS : _DIRECTIONS // 4], points.T
        return np.maximum(np.maximum(x - east, -x - west), np.maximum(z - north, -z - south))

    def across_mm(self, points: np.ndarray) -> np.ndarray:
        """Computes how far points (n, 3) are off the outline, in its plane, (n)."""
        across, (normals, support) = self._across_box(points), self._outline
        near = _adjacent(across, points[:, 1], self.y_mm) < _FAR_MM
        if near.any():
            across[near] = (points[near][:, [0, 2]] @ normals - support).max(axis=1)
        return across

    @cached_property
    def _outline(self) -> tuple[np.ndarray, np.ndarray]:
        """(2, n) directions, `_NORMALS` and those of the straight sides, and how far the outline reaches along each."""
        circles = np.array(self.circles)
        normals = np.hstack([_NORMALS, *(_tangents(a, b) for a, b in combinations(circles, 2))])
        reach = circles[:, :2] @ normals + circles[:, 2:]
        on_two = np.partition(reach, -2, axis=0)[-2] > reach.max(axis=0) - 1e-9 if len(circles) > 1 else False
        kept = (np.arange(normals.shape[1]) < _DIRECTIONS) | on_two
        return normals[:, kept], reach.max(axis=0)[kept]


@dataclass(frozen=True)
class Windowed:
    """Prism with a window through it, the hull of circles in the same plane."""

    whole: Prism
    window: Prism

    def signed_distance(self, points: np.ndarray) -> np.ndarray:
        """As of `Shape`."""
        inside = np.minimum(self.window.across_mm(points), 0.0)
        through = _adjacent(-inside, points[:, 1], self.whole.y_mm)
        return np.where(inside < 0.0, through, self.whole.signed_distance(points))


@dataclass(frozen=True)
class Beam:
    """Hull of two circles in the plane of x and z, about the origin and a length along x, from one y to another."""

    length_mm: float
    radii_mm: tuple[float, float]
    y_mm: tuple[float, float]

    def signed_distance(self, points: np.ndarray) -> np.ndarray:
        """As of `Shape`."""
        (root, end), long = self.radii_mm, self.length_mm
        lean = (root - end) / long  # sine of the sides' angle to the middle
        rise = np.sqrt(1.0 - lean**2)
        x, z = points[:, 0], np.abs(points[:, 2])
        along = x * rise - z * lean
        side = np.where(along > long * rise, np.hypot(x - long, z) - end, x * lean + z * rise - root)
        return _adjacent(np.where(along < 0.0, np.hypot(x, z) - root, side), points[:, 1], self.y_mm)


@dataclass(frozen=True)
class Round:
    """Cylinder about an axis along y through (x, z)."""

    radius_mm: float
    y_mm: tuple[float, float]
    at_mm: tuple[float, float] = (0.0, 0.0)

    def signed_distance(self, points: np.ndarray) -> np.ndarray:
        """As of `Shape`."""
        apart = np.hypot(points[:, 0] - self.at_mm[0], points[:, 2] - self.at_mm[1])
        return _adjacent(apart - self.radius_mm, points[:, 1], self.y_mm)


@dataclass(frozen=True)
class Bar:
    """Cylinder from a point along a unit vector."""

    radius_mm: float
    length_mm: float
    from_mm: np.ndarray
    along: np.ndarray

    def signed_distance(self, points: np.ndarray) -> np.ndarray:
        """As of `Shape`."""
        out = points - self.from_mm
        along = out @ self.along
        aside = np.linalg.norm(out - along[:, None] * self.along, axis=1)
        return _adjacent(aside - self.radius_mm, along, (0.0, self.length_mm))


@dataclass(frozen=True)
class Ring:
    """Segment of a ring about y between two radii and two angles from x to z; as of `Prism` beyond `_FAR_MM`."""

    radii_mm: tuple[float, float]
    angles_rad: tuple[float, float]
    y_mm: tuple[float, float]

    def signed_distance(self, points: np.ndarray) -> np.ndarray:
        """As of `Shape`."""
        inner, outer = self.radii_mm
        radius = np.hypot(points[:, 0], points[:, 2])
        across = np.maximum(inner - radius, radius - outer)  # off the whole ring
        near = _adjacent(across, points[:, 1], self.y_mm) < _FAR_MM
        middle, half = sum(self.angles_rad) / 2.0, (self.angles_rad[1] - self.angles_rad[0]) / 2.0
        (cosine, sine), (cos_half, sin_half) = ((cos(angle), sin(angle)) for angle in (middle, half))
        x, z = points[near, 0], points[near, 2]
        ahead, aside = cosine * x + sine * z, np.abs(cosine * z - sine * x)  # of the middle
        along, off = ahead * cos_half + aside * sin_half, aside * cos_half - ahead * sin_half  # of the nearer end
        beyond = np.hypot(along - np.minimum(np.maximum(along, inner), outer), off)
        across[near] = np.where(ahead >= radius[near] * cos_half, across[near], beyond)
        return _adjacent(across, points[:, 1], self.y_mm)


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
        over = seen - np.array(self.high_mm)
        off = np.maximum(np.array(self.low_mm) - seen, over)
        adjacent = np.linalg.norm(np.maximum(off, 0.0), axis=1) + np.minimum(off.max(axis=1), 0.0)
        return np.maximum(adjacent, _bevelled(off[:, :2].max(axis=1), over[:, 2], self.bevel_mm))


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


def _bevelled(across: np.ndarray, along: np.ndarray, bevel_mm: float) -> np.ndarray:
    """Distance to the bevel between what is so far off a side and off an end."""
    return (across + along + bevel_mm) / sqrt(2.0)


def _adjacent(across: np.ndarray, y: np.ndarray, ends: tuple[float, float]) -> np.ndarray:
    """Distance to what has an outline `across` and two flat ends."""
    along = np.maximum(ends[0] - y, y - ends[1])
    return np.hypot(np.maximum(across, 0.0), np.maximum(along, 0.0)) + np.minimum(np.maximum(across, along), 0.0)
