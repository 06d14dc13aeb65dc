"""Products of few vectors: those of the array library."""

from __future__ import annotations

import numpy as np
import pytest

from delta_cad.common.vectors import cross, cross_length, cross_rows

RNG = np.random.default_rng(5)


def test_products_are_those_of_the_array_library() -> None:
    a, b = RNG.normal(size=(2, 50, 3))
    np.testing.assert_allclose(cross_rows(a, b), np.cross(a, b), rtol=1e-14, atol=1e-15)
    np.testing.assert_allclose(cross(a[0], b[0]), np.cross(a[0], b[0]), rtol=1e-14, atol=1e-15)
    assert cross_length(a[0], b[0]) == pytest.approx(np.linalg.norm(np.cross(a[0], b[0])), rel=1e-14)
    assert cross_rows(a[:0], b[:0]).shape == (0, 3)
