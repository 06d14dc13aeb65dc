"""Number of setups of a part: the directions from which its bores and sharp inner edges are machined."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from delta_cad.checks.dfm.bores import Finding, round_bores
from delta_cad.common.memoize import memoize
from delta_cad.solids.part import Part

MOST = 4.0  # each loses a hundredth of a millimetre, and costs as much as the cutting
_SAME = 1e-4  # sine of the angle between directions that one clamping has


def setups(part: Part) -> Iterator[Finding]:
    """The fewest clampings found from which a tool comes to every bore and every sharp inner edge."""
    count, reported = _fewest(part)
    yield Finding(part.number, float(count), MOST, f"{part.number}: {count}, {reported}")


@memoize
def _fewest(part: Part) -> tuple[int, str]:
    """How many clampings a part takes at least, and from where.

    A clamping is a direction of the tool, or all that are square to one axis: the part then turns on a rotary table.
    They are found one by one, each time the direction that most of what is left is made from; the least may be smaller.
    A bore that goes through is made from either end.
    """
    from delta_cad.solids.primitive import corner_ways  # loads the CAD kernel

    requested: list[list[np.ndarray]] = []
    for bore in round_bores(part):
        along = np.array(bore.direction)
        requested.append([-along, along] if bore.through else [-along])
    requested += [ways for corner, ways in corner_ways(part.solid) if ways and corner.is_straight]
    plain = _directions(requested)
    reported = f"{len(plain)} directions"
    count = len(plain)
    for axis in (*np.eye(3), *plain):
        rest = [ways for ways in requested if all(abs(float(way @ axis)) > _SAME for way in ways)]
        if len(rest) < len(requested) and (turned := 1 + len(_directions(rest))) < count:
            x, y, z = np.round(axis, 2) + 0.0
            count, reported = turned, f"{len(plain)} directions, a rotary table turns about ({x:g}, {y:g}, {z:g})"
    return max(count, 1), reported


def _directions(requested: list[list[np.ndarray]]) -> list[np.ndarray]:
    """Directions such that each requested feature has one of them."""
    if not requested:
        return []
    ways = np.array([way for one in requested for way in one])
    of = np.repeat(np.arange(len(requested)), [len(one) for one in requested])
    x, y, z = ways.T
    sine = np.sqrt(sum(np.subtract(np.outer(a, b), np.outer(b, a)) ** 2 for a, b in ((y, z), (z, x), (x, y))))
    starts = np.flatnonzero(np.diff(of, prepend=-1))
    has = np.logical_or.reduceat(
        (sine < _SAME) & (ways @ ways.T > 0.0), starts, axis=1
    )  # what is asked has a direction
    found: list[np.ndarray] = []
    left = np.ones(len(requested), dtype=bool)
    while left.any():
        best = int(np.where(left[of], has[:, left].sum(axis=1), -1).argmax())
        found.append(ways[best])
        left &= ~has[best]
    return found
