"""Margins of every limit over a box, in the order of the registry: the quantities of the branch and bound."""

from __future__ import annotations

from typing import Any

import numpy as np

from delta_cad.common.jit import compiled, unrolled_dispatch
from delta_cad.mechanism.enclosure import pose as pose_table
from delta_cad.mechanism.enclosure.table import COLUMNS
from delta_cad.mechanism.geometry import DeltaGeometry
from delta_cad.mechanism.limits import POSE_LIMITS, Limits, PoseLimit

FIRST: dict[type[PoseLimit], int] = {}  # First row of a limit in the list of margins.
START: dict[type[PoseLimit], int] = {}  # Place of a limit's numbers behind those of the mechanism.
MARGINS, SIZE = 0, pose_table.NUMBERS
for _limit in POSE_LIMITS:
    FIRST[_limit], START[_limit] = MARGINS, SIZE
    MARGINS, SIZE = MARGINS + _limit.enclosure.rows, SIZE + _limit.enclosure.size
# A bit for each margin of a limit.
BITS = {limit: ((1 << limit.enclosure.rows) - 1) << FIRST[limit] for limit in POSE_LIMITS}


def _of_tier(*tiers: int) -> tuple[type[PoseLimit], ...]:
    return tuple(limit for limit in POSE_LIMITS if limit.enclosure.tier in tiers)


def _bits(*tiers: int) -> int:
    return sum(BITS[limit] for limit in _of_tier(*tiers))


def _enclosing(tier: int) -> Any:
    """Calls the enclosures of a tier whose margins are wanted, one after the other."""
    calls = [(limit.enclosure.margins, BITS[limit], START[limit], FIRST[limit]) for limit in _of_tier(tier)]
    return unrolled_dispatch("pose, k, needed, work, out", calls, "if needed & {1}: {0}(pose, k, {2}, work, out, {3})")


_by_coordinates, _by_chains, _by_forearms = (
    _enclosing(tier) for tier in (pose_table.COORDINATES, pose_table.CHAINS, pose_table.FOREARMS)
)
_CHAINS, _FOREARMS = _bits(pose_table.CHAINS, pose_table.FOREARMS), _bits(pose_table.FOREARMS)
# Margins that mean nothing where a chain is open.
_CLOSED = sum(
    BITS[limit] for limit in POSE_LIMITS if limit.enclosure.tier != pose_table.COORDINATES and not limit.always
)


def numbers(g: DeltaGeometry, limits: Limits, tolerance: float = 0.0) -> np.ndarray:
    """Gathers the numbers of a mechanism and of limits on it, for `margins`.

    Args:
        g: The mechanism.
        limits: The limits.
        tolerance: Of every length and offset of every chain, README (43), m.

    Returns:
        (n,) numbers; NaN for other limits.
    """
    out = np.full(SIZE, np.nan)
    out[: pose_table.NUMBERS] = pose_table.lengths(g, tolerance)
    for limit in limits:
        start = START[type(limit)]
        out[start : start + limit.enclosure.size] = limit.numbers()
    return out


def room() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Makes room for `margins`: the table of forms, space to work in, the list of margins."""
    return pose_table.table(), np.empty((24, 6)), np.full((MARGINS, COLUMNS), np.nan)


@compiled
def margins(box, k, needed, pose, work, out):
    """Encloses the margins of limits over a box.

    Args:
        box: (7,) centre (3), half sides (3), and a bound of the error of both, m; a point has four zeros.
        k: `numbers`.
        needed: Bits of the margins that are wanted; the others may be left as they are.
        pose: Room, as `work`.
        work: (24, 6) room.
        out: (n, 6) filled: `LOW`, `HIGH`, `CENTRE`, slopes; NaN where nothing can be said.
    """
    pose_table.fill_coordinates(box, k, pose)
    if k[pose_table.TOLERANCE] > 0.0:
        pose_table.widen_coordinates(k, pose)
    _by_coordinates(pose, k, needed, work, out)
    if not needed & _CHAINS:
        return
    if k[pose_table.TOLERANCE] > 0.0:  # the chains are those of the drawn machine, widened
        pose_table.fill_coordinates(box, k, pose)
        closed = pose_table.fill_chains(k, pose)
        pose_table.fill_forearms(pose)
        pose[pose_table.ROWS :] = pose[: pose_table.ROWS]
        closed = closed and pose_table.widen_chains(k, pose)
        pose_table.widen_coordinates(k, pose)
    else:
        closed = pose_table.fill_chains(k, pose)
    if not closed:
        for row in range(MARGINS):
            if (_CLOSED >> row) & 1:
                out[row, :] = np.nan
        needed &= ~_CLOSED
    _by_chains(pose, k, needed, work, out)
    if needed & _FOREARMS:
        pose_table.fill_forearms(pose)
        _by_forearms(pose, k, needed, work, out)
