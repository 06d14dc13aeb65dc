"""Leaders set out so that one can follow them: none crosses another, none runs along an edge of the part."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from heapq import heappop, heappush
from itertools import combinations, count
from typing import TypeVar

import numpy as np

from delta_cad.export.drawings.sheet_io.sheet import Point
from delta_cad.export.drawings.views.marks import ARROW_MM

_ALONG_MM = 0.3  # from an edge, about half a wide line, nearer than which a leader cannot be told from it
_TOUCHING_MM2 = 1e-6
_SHIFTS_MM = 0.0, 7.0, -7.0, 14.0, -14.0  # by which a text may stand aside of where its leader would be level
_TRIES = 400  # orders and shifts of one band that are looked at

Drawn = TypeVar("Drawn")
Leader = tuple[Point, ...]
State = tuple[tuple[int, ...], tuple[int, ...]]
"""Indices of texts in their order along a band, and which of `_SHIFTS_MM` each has."""


def lines_cross(a: np.ndarray, b: np.ndarray) -> bool:
    """Decides whether two lines (2, 2) have a point in common that is inside of both."""

    def sides(line: np.ndarray, points: np.ndarray) -> float:
        way, off = line[1] - line[0], points - line[0]
        across = way[0] * off[:, 1] - way[1] * off[:, 0]
        return float(across[0] * across[1])

    return sides(a, b) < -_TOUCHING_MM2 and sides(b, a) < -_TOUCHING_MM2


def runs_along(line: np.ndarray, edges: np.ndarray) -> bool:
    """Decides whether a line (2, 2) lies on one of (n, 2, 2) edges for longer than its arrow's head."""
    way = line[1] - line[0]
    length = float(np.hypot(*way))
    if not length > 0.0:
        return False
    way = way / length
    off = edges - line[0]
    along, aside = off @ way, np.abs(off[..., 0] * way[1] - off[..., 1] * way[0])
    shared = np.minimum(along.max(axis=1), length) - np.maximum(along.min(axis=1), 0.0)
    return bool(((aside.max(axis=1) < _ALONG_MM) & (shared > ARROW_MM[0])).any())


def untangled(
    wanted: Sequence[float],
    leaders: Callable[[Sequence[int], Sequence[float]], Sequence[Leader]],
    edges: np.ndarray,
    others: Sequence[Leader] = (),
) -> tuple[list[int], list[float]]:
    """Finds an order of texts in a band, and where each would be, at which their leaders can be followed.

    Best first: of what was set out, that with the fewest faults is changed next, its texts at fault shifted or
    exchanged with another.

    Args:
        wanted: Where along the band each text would be.
        leaders: Indices of texts in their order and where each would be -> the leader of each, in that order.
        edges: (n, 2, 2) of the view.
        others: Leaders of other bands, which stay where they are.

    Returns:
        Indices in their order, and where each would be; that with the fewest faults where none is without.
    """
    set_out = [np.array(other) for other in others]

    def laid(state: State) -> tuple[list[int], list[float]]:
        order, shifts = state
        return list(order), [wanted[k] + _SHIFTS_MM[shifts[k]] for k in order]

    def faulty(state: State) -> list[int]:
        """Places in the order, once for each fault of the leader there."""
        lines = [np.array(leader) for leader in leaders(*laid(state))]
        astray = [n for n, one in enumerate(lines) if runs_along(one[-2:], edges)]
        astray += [n for n, one in enumerate(lines) for other in set_out if _tangled(one, other)]
        pairs = [pair for pair in combinations(range(len(lines)), 2) if _tangled(lines[pair[0]], lines[pair[1]])]
        return astray + [n for pair in pairs for n in pair]

    first: State = tuple(sorted(range(len(wanted)), key=lambda k: wanted[k])), (0,) * len(wanted)
    seen, tried = {first}, count(1)
    open_ = [(len(off := faulty(first)), 0, first, off)]
    best = open_[0]
    while open_ and best[0] and len(seen) < _TRIES:
        _, _, state, off = heappop(open_)
        for other in _changed(state, dict.fromkeys(off), wanted):
            if other not in seen and len(seen) < _TRIES:
                seen.add(other)
                one = len(off := faulty(other)), next(tried), other, off
                heappush(open_, one)
                best = min(best, one)
    return laid(best[2])


def _changed(state: State, places: Iterable[int], wanted: Sequence[float]) -> Iterator[State]:
    """What is a step from an order with its shifts: a text at one of the places shifted, or exchanged with another."""
    order, shifts = state
    for n in places:
        k = order[n]
        for shift in range(len(_SHIFTS_MM)):
            if shift != shifts[k]:
                moved = *shifts[:k], shift, *shifts[k + 1 :]
                yield tuple(sorted(order, key=lambda j: wanted[j] + _SHIFTS_MM[moved[j]])), moved
        for m in range(len(order)):
            if m != n:
                exchanged = list(order)
                exchanged[m], exchanged[n] = exchanged[n], exchanged[m]
                yield tuple(exchanged), shifts


def in_turn(bands: Sequence[Callable[[list[Leader]], Drawn]], turns: Iterable[Sequence[int]]) -> list[Drawn]:
    """Draws bands of texts one after the other, in the first turn in which no two leaders cross.

    Args:
        bands: Each takes the leaders that stand already, gives way to them and adds its own.
        turns: Orders in which the bands are drawn: where one cannot give way to those before it, they do in another.

    Returns:
        What was drawn, in the order of the bands; that with the fewest crossings where no turn is without.
    """
    tries = []
    for turn in turns:
        leaders: list[Leader] = []
        drawn = {k: bands[k](leaders) for k in turn}
        tries.append((crossings(leaders), [drawn[k] for k in range(len(bands))]))
        if not tries[-1][0]:
            break
    return min(tries, key=lambda one: one[0])[1]


def crossings(leaders: Sequence[Leader]) -> int:
    """Counts the pairs of leaders that cross."""
    lines = [np.array(leader) for leader in leaders]
    return sum(_tangled(one, other) for one, other in combinations(lines, 2))


def _tangled(one: np.ndarray, other: np.ndarray) -> bool:
    return any(lines_cross(a, b) for a in _lines(one) for b in _lines(other))


def _lines(leader: np.ndarray) -> np.ndarray:
    """(n, 2, 2) lines of a leader through (n + 1, 2) points."""
    return np.stack([leader[:-1], leader[1:]], axis=1)
