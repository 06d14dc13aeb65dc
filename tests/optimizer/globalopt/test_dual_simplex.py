"""Sums of rows: never believed where they are not negative, and found where SciPy's linear program finds them."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from scipy.optimize import linprog

from optimizer.globalopt.dual_simplex import SIZE, SYMBOLS, excluded, solve


def room() -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    return (
        np.zeros(SYMBOLS),
        np.zeros(SIZE, dtype=np.int64),
        np.zeros(SIZE),
        np.empty((SIZE, SIZE)),
        np.empty(SIZE),
    )


def largest(rows: np.ndarray) -> float:
    """Largest t with `c + e + s u >= t` in the box, by SciPy."""
    matrix = np.column_stack([-rows[:, 1:5], np.ones(len(rows))])
    found = linprog([0, 0, 0, 0, -1], A_ub=matrix, b_ub=rows[:, 0] + rows[:, 5], bounds=[(-1, 1)] * 4 + [(None, None)])
    return float(found.x[4])


def systems(count: int) -> list[np.ndarray]:
    """Random systems near the edge of what is feasible; some symbols are idle, some rows are equal."""
    rng, out = np.random.default_rng(5), []
    for _ in range(count):
        n = int(rng.integers(1, 40))
        rows = rng.normal(size=(n, 6)) * 10.0 ** rng.uniform(-3, 0, (n, 1))
        rows[:, 5] = np.abs(rows[:, 5]) * 0.01
        rows[:, 1:5] *= rng.random(4) < 0.8
        rows[:, 0] += rng.uniform(-1.0, 2.0) * np.abs(rows[:, 1:5]).sum(axis=1)
        if n > 3:
            rows[1] = rows[0]
        out.append(rows)
    return out


def test_it_agrees_with_scipy_and_its_weights_are_a_proof_in_fractions() -> None:
    both = [0, 0]
    for rows in systems(400):
        u, basis, weight, matrix, right = room()
        found = solve(rows, len(rows), u, basis, weight, matrix, right)
        t = largest(rows)
        both[found] += 1
        if not found:
            assert t > -1e-9
            continue
        assert t < 0.0
        used = [(Fraction(max(f, 0.0)), rows[k]) for k, f in zip(basis, weight, strict=True) if k < len(rows)]
        c, *s, e = (sum(f * Fraction(row[j]) for f, row in used) for j in range(6))
        assert c + e + sum(abs(v) for v in s) < 0
    assert min(both) > 50  # both answers were given


def test_the_best_place_is_that_of_the_linear_program() -> None:
    for rows in systems(100):
        u, basis, weight, matrix, right = room()
        if not solve(rows, len(rows), u, basis, weight, matrix, right):
            assert (rows[:, 0] + rows[:, 5] + rows[:, 1:5] @ u).min() == pytest.approx(largest(rows), abs=1e-9)
            assert np.abs(u).max() <= 1.0


@pytest.mark.parametrize("margin", [0.0, 1e-17])
def test_rows_in_exact_balance_exclude_nothing(margin: float) -> None:
    """u >= 0 and u <= 0 leave u = 0; a shift by less than a rounding is no proof."""
    rows = np.array([[-margin, 1.0, 0, 0, 0, 0], [-margin, -1.0, 0, 0, 0, 0]])
    u, basis, weight, matrix, right = room()
    assert not solve(rows, 2, u, basis, weight, matrix, right)
    assert not excluded(rows, 2, np.array([0, 1, 2, 3, 4]), np.array([0.5, 0.5, 0, 0, 0]))
    rows[:, 0] = -1e-12
    assert excluded(rows, 2, np.array([0, 1, 2, 3, 4]), np.array([0.5, 0.5, 0, 0, 0]))


def test_negative_weights_count_nothing() -> None:
    rows = np.array([[1.0, 0, 0, 0, 0, 0], [1.0, 0, 0, 0, 0, 0]])
    assert not excluded(rows, 2, np.array([0, 1, 2, 3, 4]), np.array([-5.0, 0.5, 0, 0, 0]))


def test_a_sum_is_judged_by_itself_whatever_its_weights() -> None:
    """Random weights, shifted so that the exact sum is at zero, a rounding below it, or well away."""
    rng, answers = np.random.default_rng(6), [0, 0]
    for _ in range(2_000):
        rows = rng.normal(size=(5, 6)) * 10.0 ** rng.uniform(-6, 0, (5, 1))
        rows[:, 5] = np.abs(rows[:, 5]) * 0.1
        weight = rng.random(5)
        size = float(weight @ np.abs(rows).sum(axis=1))
        top = float(weight @ (rows[:, 0] + rows[:, 5]) + np.abs(weight @ rows[:, 1:5]).sum())
        rows[0, 0] -= (top + size * rng.choice([0.0, 1e-16, -1e-16, 1e-9, -1e-9, -0.1])) / weight[0]
        c, *s, e = (sum(Fraction(f) * Fraction(row[j]) for f, row in zip(weight, rows, strict=True)) for j in range(6))
        exact = c + e + sum(abs(v) for v in s)
        found = excluded(rows, 5, np.arange(5), weight)
        assert not found or exact < 0
        assert found or exact > -1e-13 * size
        answers[found] += 1
    assert min(answers) > 300
