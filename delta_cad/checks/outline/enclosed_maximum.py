"""Largest value over a cube of handle positions, enclosed from both sides by cutting it into ever smaller boxes."""

from __future__ import annotations

from collections.abc import Callable
from itertools import product

import numpy as np

_CUTS = 14  # times that boxes are halved at most: 11 mm to 1 um, and rounding of doubles is far below
_MOST_BOXES = 20_000  # alive at once; beyond it the bound stays sound and is left as wide as it is
_SIGNS = np.array(list(product((-1.0, 1.0), repeat=3)))
_BoxBounds = Callable[[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]


def enclosed_maximum(
    bounds: _BoxBounds, centres: np.ndarray, halves: np.ndarray, gap: float, floor: float = -np.inf
) -> tuple[float, float]:
    """Encloses the maximum over boxes from above and below.

    Args:
        bounds: (n, 3) centres and (n, 3) half sides -> (n,) upper bounds over the boxes, (n,) values at the centres.
        centres: (n, 3) centres of the boxes at first.
        halves: (n, 3) their half sides.
        gap: How far the upper bound may stay above what is attained.
        floor: A value attained elsewhere: what stays below it is not looked into.

    Returns:
        bound: Upper bound on the maximum; within `gap` of `attained` where it exceeds the floor, unless more than
            `_MOST_BOXES` boxes or `_CUTS` cuts would be needed.
        attained: The larger of the floor and the values at all centres that were looked at.
    """
    settled, cut = -np.inf, 0
    while True:
        bound, value = bounds(centres, halves)
        floor = max(floor, float(value.max()))
        keep = bound > floor + gap
        count = int(keep.sum())
        if not count or 8 * count > _MOST_BOXES or cut == _CUTS:
            return max(settled, float(bound.max())), floor
        settled = max(settled, float(bound[~keep].max(initial=-np.inf)))
        halves = np.repeat(halves[keep] / 2.0, 8, axis=0)
        centres = np.repeat(centres[keep], 8, axis=0) + halves * np.tile(_SIGNS, (count, 1))
        cut += 1
