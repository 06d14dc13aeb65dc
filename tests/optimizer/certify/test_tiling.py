"""Tilings that hold and tilings that do not."""

from fractions import Fraction

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from optimizer.certify.tiling import TilingError, check_tiling, corners
from tests.optimizer.messages import refuses


def halved(cells, n, axis):
    """Cell n replaced by its halves."""
    cell = cells[n]
    near, far = list(cell), list(cell)
    for half, side in ((near, 0), (far, 1)):
        half[2 * axis] += 1
        half[2 * axis + 1] = 2 * half[2 * axis + 1] + side
    return [*cells[:n], tuple(near), *cells[n + 1 :], tuple(far)]


@st.composite
def tilings(draw):
    cells = [(0, 0, 0, 0, 0, 0)]
    for _ in range(draw(st.integers(0, 25))):
        cells = halved(cells, draw(st.integers(0, len(cells) - 1)), draw(st.integers(0, 2)))
    return cells


@settings(deadline=None, derandomize=True)
@given(tilings(), st.randoms(use_true_random=False))
def test_every_subdivision_tiles(cells, random):
    random.shuffle(cells)
    check_tiling(cells)
    volume = Fraction(0)
    for cell in cells:
        low, high = corners(cell, [Fraction(-1), Fraction(0), Fraction(1, 3)], [Fraction(1), Fraction(1), Fraction(3)])
        edges = [b - a for a, b in zip(low, high, strict=True)]
        volume += edges[0] * edges[1] * edges[2]
    assert volume == 2 * Fraction(8, 3)


@settings(deadline=None, derandomize=True)
@given(tilings(), st.data())
def test_a_missing_a_doubled_and_a_moved_box_are_noticed(cells, data):
    n = data.draw(st.integers(0, len(cells) - 1))
    with pytest.raises(TilingError, match="missing"):
        check_tiling([*cells[:n], *cells[n + 1 :]])
    with pytest.raises(TilingError, match="overlap"):
        check_tiling([*cells, cells[n]])
    if len(cells) > 1:
        other = data.draw(st.integers(0, len(cells) - 1))
        if cells[n][::2] == cells[other][::2] and n != other:
            with pytest.raises(TilingError):
                check_tiling([*cells[:n], cells[other], *cells[n + 1 :]])


def test_the_right_volume_in_the_wrong_place():
    left, right = (1, 0, 0, 0, 0, 0), (1, 1, 0, 0, 0, 0)
    check_tiling([left, right])
    with refuses(TilingError, "1"):
        check_tiling([left, left])
    with pytest.raises(TilingError, match="overlap"):
        check_tiling([left, (0, 0, 1, 0, 0, 0)])
    with refuses(TilingError, "1", "0", "0"):
        check_tiling([(2, 0, 0, 0, 0, 0), (2, 1, 0, 0, 0, 0), (2, 0, 0, 0, 0, 0), (2, 1, 0, 0, 0, 0)])
    with pytest.raises(TilingError, match="overlap"):
        check_tiling([right, (2, 2, 0, 0, 0, 0), (2, 3, 0, 0, 0, 0)])


@pytest.mark.parametrize("cell", [(-1, 0, 0, 0, 0, 0), (1, 2, 0, 0, 0, 0), (0, -1, 0, 0, 0, 0), (10**9, 1, 0, 0, 0, 0)])
def test_boxes_outside_the_cube(cell):
    with pytest.raises(TilingError, match="outside"):
        check_tiling([cell])


def test_no_boxes():
    with refuses(TilingError, "1"):
        check_tiling([])
