"""Leaders set out so that one can follow them: none crosses another, none runs along an edge of the part."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import combinations

import numpy as np

from delta_cad.export.drawings.paper.sheet import Point
from delta_cad.export.drawings.views.marks import ARROW_MM

ALONG_MM = 0.3  # from an edge, about half a wide line, nearer than which a leader cannot be told from it
TOUCHING_MM2 = 1e-6
SHIFTS_MM = 0.0, 7.0, -7.0, 14.0, -14.0  # by which a text may stand aside of where its leader would be level
TRIES = 40

Leader = tuple[Point, ...]


def lines_cross(a: np.ndarray, b: np.ndarray) -> bool:
    """Decides whether two lines (2, 2) have a point in common that is inside of both."""

    def sides(line: np.ndarray, points: np.ndarray) -> float:
        way, off = line[1] - line[0], points - line[0]
        across = way[0] * off[:, 1] - way[1] * off[:, 0]
        return float(across[0] * across[1])

    return sides(a, b) < -TOUCHING_MM2 and sides(b, a) < -TOUCHING_MM2


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
    return bool(((aside.max(axis=1) < ALONG_MM) & (shared > ARROW_MM[0])).any())


def untangled(
    wanted: Sequence[float],
    leaders: Callable[[Sequence[int], Sequence[float]], Sequence[Leader]],
    edges: np.ndarray,
    others: Sequence[Leader] = (),
) -> tuple[list[int], list[float]]:
    """Finds an order of texts in a band, and where each would be, at which their leaders can be followed.

    Args:
        wanted: Where along the band each text would be.
        leaders: Indices of texts in their order and where each would be -> the leader of each, in that order.
        edges: (n, 2, 2) of the view.
        others: Leaders of other bands, which stay where they are.

    Returns:
        Indices in their order, and where each would be; the first that was tried where none is without fault.
    """
    shifts = [0] * len(wanted)
    order = sorted(range(len(wanted)), key=lambda k: wanted[k])
    swapped: set[tuple[int, int]] = set()
    first, set_out = (order, [wanted[k] for k in order]), [np.array(other) for other in others]

    def astray(leader: np.ndarray) -> bool:
        return runs_along(leader[-2:], edges) or any(_tangled(leader, other) for other in set_out)

    for _ in range(TRIES):
        places = [wanted[k] + SHIFTS_MM[shifts[k]] for k in order]
        lines = [np.array(leader) for leader in leaders(order, places)]
        off = next((n for n, one in enumerate(lines) if astray(one)), None)
        if off is not None and shifts[order[off]] + 1 < len(SHIFTS_MM):
            shifts[order[off]] += 1
            order.sort(key=lambda k: wanted[k] + SHIFTS_MM[shifts[k]])
            swapped.clear()
            continue
        pair = next(((m, n) for m, n in combinations(range(len(lines)), 2) if _tangled(lines[m], lines[n])), None)
        if pair is None:
            return (order, places) if off is None else first
        m, n = pair
        if (order[m], order[n]) in swapped:
            return first
        swapped |= {(order[m], order[n]), (order[n], order[m])}
        order[m], order[n] = order[n], order[m]
    return first


def _tangled(one: np.ndarray, other: np.ndarray) -> bool:
    return any(lines_cross(a, b) for a in _lines(one) for b in _lines(other))


def _lines(leader: np.ndarray) -> np.ndarray:
    """(n, 2, 2) lines of a leader through (n + 1, 2) points."""
    return np.stack([leader[:-1], leader[1:]], axis=1)
