"""The forms of the lengths hold their whole box of designs, in exact fractions."""

from __future__ import annotations

from fractions import Fraction

import numpy as np

from delta_cad.mechanism.enclosure.affine_form import SYMBOLS
from optimizer.globalopt.cutting_points import _between


def test_a_length_reaches_both_ends_of_its_range() -> None:
    rng = np.random.default_rng(4)
    for _ in range(500):
        low = rng.uniform(-0.02, 0.2, SYMBOLS)
        box = np.stack([low, low + 10.0 ** rng.uniform(-12.0, -1.5, SYMBOLS) * rng.integers(0, 2, SYMBOLS)])
        for j in range(SYMBOLS):
            c, *slopes, e = (Fraction(x) for x in _between(box, j))
            assert [k for k, s in enumerate(slopes) if s] in ([j], [])
            # each end, and so all between, is within the error of its own place
            assert abs(c - slopes[j] - Fraction(box[0, j])) <= e
            assert abs(c + slopes[j] - Fraction(box[1, j])) <= e
            assert e <= Fraction(1, 10**15)  # m; some roundings of 0.2
