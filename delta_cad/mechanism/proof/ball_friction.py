"""Bounds of the ball joints' friction over a cube, README (56)-(57): proved, and rounded up to what one reads.

A cup leans on its ball with the rod and turns about its own axis. Which torque either takes is the caller's; how fast
they go for a motion of the handle is mathematics: interval slopes, over boxes that are halved where they tell little.
"""

from __future__ import annotations

import math
from functools import lru_cache
from itertools import product

import numpy as np

from delta_cad.mechanism.enclosure.interval import Interval, Slopes, exactly
from delta_cad.mechanism.enclosure.slope_pose import SlopePose
from delta_cad.mechanism.geometry import DeltaGeometry
from delta_cad.mechanism.inverse import closure_margin
from delta_cad.mechanism.workspace import Cube

_DIRECTIONS = 8  # over half a turn: what lies between two is at most 2 % more, which is added
CLOSE = 1.01  # of what some position has: a bound within it is good enough
_MOST_BOXES = 20_000
_FIRST = (8, 4, 8)  # boxes along x, y, z to begin with
LEAST = 1e-9  # N; the bounds where nothing rubs
_DIGITS = 4  # of the bounds: no last place of a double, which another machine may round otherwise


@lru_cache(maxsize=64)
def ball_friction(g: DeltaGeometry, cube: Cube, lean: float, turn: float) -> tuple[float, float]:
    """Bounds the friction of twelve ball joints at the handle over a cube.

    Args:
        g: The mechanism.
        cube: The cube.
        lean: Torque of both joints at one end of a pair of rods while they lean, N m.
        turn: The same while they turn about their cups' axes, N m.

    Returns:
        upright: For a motion along z, N.
        level: For any motion square to z, N. Infinite, as the other, where some chain is open.
    """
    if lean == turn == 0.0:
        return _up(0.0), _up(0.0)
    angles = np.pi * np.arange(_DIRECTIONS) / _DIRECTIONS
    flat = np.stack([np.cos(angles), np.sin(angles), np.zeros(_DIRECTIONS)], axis=-1)
    between = 1.0 / math.cos(math.pi / (2 * _DIRECTIONS)) * (1.0 + 1e-12)
    upright = _most(g, cube, lean, turn, np.array([[0.0, 0.0, 1.0]]))
    return _up(upright), _up(_most(g, cube, lean, turn, flat) * between)


def _most(g: DeltaGeometry, cube: Cube, lean: float, turn: float, v: np.ndarray) -> float:
    """Bounds the friction over the half y >= 0 of a cube and over some directions (n, 3); the other half mirrors it."""
    low, high = np.array([cube.lower[0], 0.0, cube.lower[2]]), cube.upper
    edges = [np.linspace(a, b, n + 1) for a, b, n in zip(low, high, _FIRST, strict=True)]
    lower = np.stack(np.meshgrid(*(e[:-1] for e in edges), indexing="ij"), axis=-1).reshape(-1, 3)
    upper = np.stack(np.meshgrid(*(e[1:] for e in edges), indexing="ij"), axis=-1).reshape(-1, 3)
    bound, known, examined = 0.0, 0.0, 0
    while len(lower):
        examined += len(lower)
        if (closure_margin(g, np.concatenate([lower, upper])) < 0.0).any():
            return math.inf
        over, at = _frictions(SlopePose(g, lower, upper), g, lean, turn, v)
        known = max(known, float(np.where(np.isnan(at), 0.0, at).max()))
        enough = over <= CLOSE * known  # never where nothing is known of a box
        if examined > _MOST_BOXES:
            return max(bound, float(np.where(np.isnan(over), np.inf, over).max()))
        bound = max(bound, float(over[enough].max(initial=0.0)))
        lower, upper = _eighths(lower[~enough], upper[~enough])
    return bound


def _frictions(
    pose: SlopePose, g: DeltaGeometry, lean: float, turn: float, v: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Bounds the friction over each box, and gives that of some position in it, for the worst direction of each."""
    lb, la, negative = exactly(g.forearm_length), exactly(g.upper_arm_length), exactly(-1.0)
    totals = {where: exactly(np.zeros((len(v), len(pose.z.box.lo)))) for where in ("box", "centre")}
    for i in range(3):
        c, s = pose.azimuths[i]
        x, y, z = pose.forearm[i]
        radial = x.times(c) + y.times(s)
        t2 = pose.t[i].square()
        across2 = t2.times(negative).plus(lb.square())  # L_B^2 cos^2 of the lean
        inverse = across2.inverse()
        along = radial * pose.cos[i] + z * pose.sin[i]
        n = pose.rows[i]
        rod = (
            (z.times(-c) - along * n[0]) * inverse,
            (z.times(-s) - along * n[1]) * inverse,
            (radial - along * n[2]) * inverse,
        )
        arm = [part.times(la.inverse()) for part in n]
        ends = rod, tuple(a - b for a, b in zip(rod, arm, strict=True))
        for where, total in totals.items():
            adjacent = _along((exactly(0.0) - s, c, exactly(0.0)), v).square() * _at(inverse, where)
            tilt = _at(t2, where) * lb.square().inverse()
            flat = _at(across2, where) * lb.square().inverse()
            for end in ends:
                rate = _along(tuple(_at(part, where) for part in end), v).square()
                total = total + exactly(lean) * _root(rate * tilt + adjacent) + exactly(turn) * _root(rate * flat)
            totals[where] = total
    return totals["box"].hi.max(axis=0), totals["centre"].lo.max(axis=0)


def _at(form: Slopes, where: str) -> Interval:
    return form.box if where == "box" else form.centre


def _along(vector: tuple[Interval, ...], v: np.ndarray) -> Interval:
    """The scalar products of vectors, one a box, with directions (n, 3): (n, boxes)."""
    parts = [vector[k] * exactly(v[:, k, None]) for k in range(3)]
    return parts[0] + parts[1] + parts[2]


def _root(square: Interval) -> Interval:
    """A root of what is not negative."""
    above = Interval(np.maximum(square.lo, 2.0**-1000), np.maximum(square.hi, 2.0**-1000)).root()
    return Interval(np.where(square.lo > 0.0, above.lo, np.where(np.isnan(square.lo), np.nan, 0.0)), above.hi)


def _eighths(lower: np.ndarray, upper: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Halves boxes along all three edges."""
    middle = 0.5 * (lower + upper)
    ends = [
        [np.stack(both, axis=-1) for both in ((lower[:, k], middle[:, k]), (middle[:, k], upper[:, k]))]
        for k in range(3)
    ]
    parts = [np.stack(part, axis=-1) for part in product(*ends)]  # (n, 2 ends, 3 axes)
    return np.concatenate([part[:, 0] for part in parts]), np.concatenate([part[:, 1] for part in parts])


def _up(x: float) -> float:
    """Rounds up to a few digits."""
    if x == math.inf:
        return x
    x = max(x, LEAST)
    places = _DIGITS - 1 - math.floor(math.log10(x))
    return math.ceil(x * 10.0**places * (1.0 + 1e-12)) / 10.0**places
