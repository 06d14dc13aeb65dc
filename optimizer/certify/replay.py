"""Second proof of each limit over given boxes, in interval slopes and NumPy; what `verify` believes."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from delta_cad.mechanism import DeltaGeometry
from delta_cad.mechanism.enclosure.interval import exactly
from delta_cad.mechanism.enclosure.slope_pose import SlopePose
from delta_cad.mechanism.limits import PoseLimit

_BATCH = 1_000  # boxes at a time: small enough to stay in the processor's cache
_FINEST = 45  # halvings of a box after which it is not tried again: its edges are then 2^-15 of what they were
_HOPEFUL = 4  # halvings from which on a box is left whose own middle, taken alone, is not proved
_MIDDLES = 64  # of those that are looked at


@np.errstate(all="ignore")
def breaks(g: DeltaGeometry, limit: PoseLimit, point: np.ndarray) -> bool:
    """Decides whether a position breaks a limit for certain.

    Args:
        g: The mechanism.
        limit: The limit.
        point: (3,) position, m.

    Returns:
        Truth only if the limit is broken in exact arithmetic.
    """
    return limit.refuted_by_intervals(SlopePose(g, point[None], point[None]), exactly)


@dataclass(frozen=True)
class _Unproved:
    """A box in which a condition could not be proved a second time.

    Attributes:
        condition: Name of the condition.
        lower: Lower corner, m.
        upper: Upper corner, m.
    """

    condition: str
    lower: tuple[float, ...]
    upper: tuple[float, ...]


@np.errstate(all="ignore")  # what overflows encloses nothing and so proves nothing
def replay(
    g: DeltaGeometry,
    limits: Sequence[PoseLimit],
    lower: np.ndarray,
    upper: np.ndarray,
    *,
    tolerance: float = 0.0,
    max_boxes: int = 2_000_000,
    progress: Callable[[int, float], object] | None = None,
) -> tuple[int, _Unproved | None]:
    """Proves limits over boxes, halving a box where this arithmetic is too coarse for it.

    Args:
        g: The mechanism.
        limits: Those to prove.
        lower: (n, 3) lower corners, m.
        upper: (n, 3) upper corners, m.
        tolerance: Of every length and offset of every chain, m: for all machines within it.
        max_boxes: Boxes after which the replay gives up.
        progress: Called with the boxes examined and the share of the given ones that is done.

    Returns:
        Boxes examined, and the first that could not be proved, if any.
    """
    examined = 0
    for start in range(0, len(lower), _BATCH):
        low, high = lower[start : start + _BATCH], upper[start : start + _BATCH]
        open_ = np.ones((len(low), len(limits)), dtype=bool)
        depth = np.zeros(len(low), dtype=int)
        while len(low):
            now = slice(max(0, len(low) - _BATCH), None)  # the last ones first, so that the list stays short
            p = SlopePose(g, low[now], high[now], tolerance)
            examined += len(low[now])
            still = open_[now].copy()
            for n, limit in enumerate(limits):
                if still[:, n].any():
                    still[:, n] &= ~limit.proved_by_intervals(p, exactly)
            failed = still.any(axis=1)
            stuck = failed & ((depth[now] >= _FINEST) | (examined >= max_boxes))
            doubtful = np.flatnonzero(failed & (depth[now] >= _HOPEFUL))[:_MIDDLES]
            if len(doubtful):
                middle = 0.5 * (low[now][doubtful] + high[now][doubtful])
                p = SlopePose(g, middle, middle, tolerance)
                for n, limit in enumerate(limits):
                    if still[doubtful, n].any():
                        stuck[doubtful] |= still[doubtful, n] & ~limit.proved_by_intervals(p, exactly)
            if stuck.any():
                k = int(np.argmax(stuck))
                name = limits[int(np.argmax(still[k]))].name
                return examined, _Unproved(name, tuple(low[now][k].tolist()), tuple(high[now][k].tolist()))
            parts = _halved(low[now][failed], high[now][failed])
            low, high = (np.concatenate([kept[: now.start], new]) for kept, new in zip((low, high), parts, strict=True))
            open_ = np.concatenate([open_[: now.start], still[failed], still[failed]])
            depth = np.concatenate([depth[: now.start], depth[now][failed] + 1, depth[now][failed] + 1])
        if progress is not None:
            progress(examined, min(1.0, (start + _BATCH) / len(lower)))
    return examined, None


def _halved(lower: np.ndarray, upper: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Halves boxes into (2 n, 3) lower and upper corners: first all near ones, then all far ones."""
    rows, axis = np.arange(len(lower)), np.argmax(upper - lower, axis=1)
    middle = 0.5 * (lower[rows, axis] + upper[rows, axis])
    near, far = upper.copy(), lower.copy()
    near[rows, axis] = middle
    far[rows, axis] = middle
    return np.concatenate([lower, far]), np.concatenate([near, upper])
