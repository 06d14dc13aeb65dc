"""Contraction of a box of designs by rows, held to exact fractions: nothing allowed is cut off, little else left."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from delta_cad.mechanism.enclosure.affine_form import ROUND
from optimizer.globalopt.branch_and_bound import PAD, _contract

AXES = 4
CASES = 400


def exact_interval(rows: np.ndarray, box: np.ndarray, axis: int) -> tuple[Fraction, Fraction]:
    """What the rows allow of one length, the others at their best: sides of an interval, empty if they cross."""
    low, high = (Fraction(float(box[side, axis])) for side in (0, 1))
    centre, half = (low + high) / 2, (high - low) / 2
    left, right = Fraction(-1), Fraction(1)
    for row in rows:
        constant, *slopes, error = (Fraction(float(value)) for value in row)
        slope = slopes[axis]
        if slope != 0:
            others = constant + error + sum(abs(s) for k, s in enumerate(slopes) if k != axis)
            edge = -others / slope
            left, right = (max(left, edge), right) if slope > 0 else (left, min(right, edge))
    return centre + half * left, centre + half * right


def random_case(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Rows of magnitude 1 at most, each cutting one length, by small slopes too; a box of centimetres to nanometres."""
    rows = np.zeros((rng.integers(1, 6), 6))
    for row in rows:
        slopes = rng.uniform(-1.0, 1.0, AXES) * 10.0 ** rng.uniform(-4.0, 0.0, AXES)
        cut, error = rng.integers(AXES), 10.0 ** rng.uniform(-16.0, -13.0)
        others = np.abs(slopes).sum() - abs(slopes[cut])
        row[:] = [abs(slopes[cut]) * rng.uniform(-1.02, 1.0) - others - error, *slopes, error]
        row /= 2.0 * max(others, 0.5)
    low = rng.uniform(0.01, 0.2, AXES)
    return rows, np.stack([low, low + 10.0 ** rng.uniform(-8.0, -1.5, AXES)])


@pytest.mark.parametrize("seed", range(4))
def test_no_allowed_design_is_cut_off(seed: int) -> None:
    rng, cut, empty = np.random.default_rng(seed), 0, 0
    for _ in range(CASES):
        rows, box = random_case(rng)
        contracted = box.copy()
        share = _contract(rows, len(rows), contracted)
        exact = [exact_interval(rows, box, axis) for axis in range(AXES)]
        if share == 0.0:  # then one axis at least has nothing left
            assert any(left > right for left, right in exact)
            empty += 1
            continue
        for axis, (left, right) in enumerate(exact):
            if left > right:
                continue  # within the padding of empty
            # two paddings, and the roundings of a row, which count the more the smaller its slope
            room = (2.0 * PAD + 16.0 * ROUND / np.abs(rows[:, 1 + axis]).min()) * abs(box[:, axis]).max()
            assert Fraction(contracted[0, axis]) <= left <= Fraction(contracted[0, axis] + room)
            assert Fraction(contracted[1, axis] - room) <= right <= Fraction(contracted[1, axis])
            cut += bool((contracted[:, axis] != box[:, axis]).any())
    assert min(cut, empty) > CASES // 10  # both happen


def test_a_row_that_almost_allows_is_kept() -> None:
    """Two rows that leave a single value of the first length: what is left must hold it."""
    for value in (0.3, 1.0 / 3.0, -0.7):
        rows = np.array([[-value, 1.0, 0.0, 0.0, 0.0, 0.0], [value, -1.0, 0.0, 0.0, 0.0, 0.0]]) / 2.0
        box = np.array([[0.1, 0.1, 0.1, 0.1], [0.2, 0.1, 0.1, 0.1]])
        (left, right), before = exact_interval(rows, box, 0), box.copy()
        share = _contract(rows, 2, box)
        assert left == right
        assert Fraction(box[0, 0]) <= left <= Fraction(box[1, 0])
        assert share > 0.0
        assert np.ptp(box[:, 0]) < PAD  # of a tenth of a metre: ten paddings
        assert (box[:, 1:] == before[:, 1:]).all()
