"""Decides whether boxes tile a block exactly, in integers alone."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

_FINEST = 60  # halvings of an edge beyond which no box is looked at; a double's own resolution is coarser
Cell = tuple[int, int, int, int, int, int]  # kx, ix, ky, iy, kz, iz: the box [i, i + 1] / 2^k of each edge of the block


class TilingError(ValueError):
    """Boxes that do not cover the block, or cover a part of it twice."""


def check_tiling(cells: Sequence[Cell]) -> None:
    """Checks that every point of the block lies in a box, and no part of it in two.

    The volumes are summed; then the block is halved again and again between the boxes until each part is one box. A box
    is never cut, so a part that is a box and holds others as well shows an overlap, and an empty one a hole.

    Raises:
        TilingError: A box is not one of the block's, the volumes do not sum to the block's, or a part is empty,
            covered twice, or cannot be halved between the boxes.
    """
    for cell in cells:
        for k, i in zip(cell[::2], cell[1::2], strict=True):
            if not 0 <= k <= _FINEST or not 0 <= i < 2**k:
                raise TilingError(f"box {list(cell)} lies outside the cube")
    deepest = max((sum(cell[::2]) for cell in cells), default=0)
    volume = Fraction(sum(2 ** (deepest - sum(cell[::2])) for cell in cells), 2**deepest)
    if volume < 1:
        raise TilingError(f"a part of {float(1 - volume):.3g} of the cube is in no box: boxes are missing")
    if volume > 1:
        raise TilingError(f"the boxes cover {float(volume):.9g} times the cube: some overlap")
    parts: list[tuple[Cell, list[Cell]]] = [((0, 0, 0, 0, 0, 0), list(cells))]
    while parts:
        part, inside = parts.pop()
        if not inside:
            raise TilingError(f"the part {list(part)} of the cube is in no box")
        if part in inside:
            if len(inside) > 1:
                raise TilingError(f"box {list(part)} overlaps another")
            continue
        axis = next((a for a in range(3) if all(cell[2 * a] > part[2 * a] for cell in inside)), None)
        if axis is None:
            raise TilingError(f"the part {list(part)} of the cube cannot be halved between its boxes: some overlap")
        halves: tuple[list[Cell], list[Cell]] = ([], [])
        for cell in inside:
            halves[cell[2 * axis + 1] >> (cell[2 * axis] - part[2 * axis] - 1) & 1].append(cell)
        for side in (0, 1):
            half = list(part)
            half[2 * axis] += 1
            half[2 * axis + 1] = 2 * part[2 * axis + 1] + side
            parts.append(((half[0], half[1], half[2], half[3], half[4], half[5]), halves[side]))


def corners(
    cell: Cell, lower: Sequence[Fraction], upper: Sequence[Fraction]
) -> tuple[tuple[Fraction, ...], tuple[Fraction, ...]]:
    """Computes the exact corners of a box.

    Args:
        cell: The box.
        lower: (3) lower corner of the block.
        upper: (3) upper corner of the block.
    """
    low, high = [], []
    for k, i, a, b in zip(cell[::2], cell[1::2], lower, upper, strict=True):
        low.append(a + (b - a) * Fraction(i, 2**k))
        high.append(a + (b - a) * Fraction(i + 1, 2**k))
    return tuple(low), tuple(high)
