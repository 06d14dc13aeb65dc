"""Rows of witness points against the NumPy figures: the feasible meets every row, the excluded is infeasible."""

from __future__ import annotations

import math

import numpy as np
import pytest

from optimizer.globalopt.branch_and_bound import _contract, _whole_rows
from optimizer.globalopt.cutting_points import EXCLUDED, KAPPA, NUMBERS, SHOULDER, TORQUE, lengths, witness_rows
from optimizer.problem.evaluator import figures_numpy

FORCE = 3.0
LIMIT = 1e-9
"""Figures of 1 in doubles are good to 1e-13 away from a fold, where a root turns that into 1e-7 of w; margins this far
from 0 have a certain sign, and designs nearer to a fold than 1e-6 are left out."""


class Case:
    """A box of designs, a point of the cube, and limits near what the middle of the box needs."""

    def __init__(self, seed: int) -> None:
        rng = np.random.default_rng(seed)
        # most points in or on a cube over a mechanism that can reach it; L_A also free
        while True:
            middle = np.array([rng.uniform(0.05, 0.1), 0.0, rng.uniform(-0.02, 0.04), rng.uniform(0.02, 0.15)])
            middle[1] = rng.uniform(0.06, 0.25)
            self.side = rng.uniform(0.01, 0.07)
            self.unit = np.round(rng.uniform(-1.0, 1.0, 3) * 1.5).clip(-1, 1) * rng.choice([1.0, rng.random()])
            f = self.figures(middle[None])
            if f.closure[0, 0] > 10.0 ** rng.uniform(-6, -1) and f.determinant[0, 0] > 0.02:
                break
        width = middle * 10.0 ** rng.uniform(-5.0, -0.5) * rng.random(4) * (rng.random(4) < 0.85)
        self.box = np.stack([middle - np.abs(width), middle + np.abs(width)])
        slack = 1.0 + rng.uniform(-1.0, 1.0) * 10.0 ** rng.uniform(-6, -1)
        self.kappa = max(slack / abs(f.quality[0, 0]), 1.0)
        self.torque = FORCE * f.moment[0, 0] / f.determinant[0, 0] * slack
        self.shoulder = (f.shoulder_min[0, 0] - abs(slack - 1.0), f.shoulder_max[0, 0] + (slack - 1.0))
        if self.shoulder[0] >= self.shoulder[1]:
            self.shoulder = (self.shoulder[0], self.shoulder[0] + 0.1)

    def figures(self, points: np.ndarray) -> object:
        """Figures of (D, 4) reduced designs at the point, (D, 1) each."""
        la, lb, a, h = points.T
        designs = np.column_stack([la, lb, a + 0.05, np.full(len(a), 0.05), h, np.full(len(a), self.side)])
        return figures_numpy(designs, self.unit[None])

    def margins(self, points: np.ndarray) -> dict[int, np.ndarray]:
        """(D,) margins as `Problem.point_margins` has them, by the bit that asks for them; 0 is reach."""
        f = self.figures(points)
        low, high = self.shoulder
        return {
            0: f.closure[:, 0],
            TORQUE: f.determinant[:, 0] - FORCE / self.torque * f.moment[:, 0],
            KAPPA: f.quality[:, 0] - 1.0 / self.kappa,
            SHOULDER: np.minimum(f.shoulder_min[:, 0] - low, high - f.shoulder_max[:, 0]),
        }

    def rows(self, box: np.ndarray, bits: int) -> tuple[int, np.ndarray]:
        """How many rows, and the rows."""
        numbers, rows = np.zeros(NUMBERS), np.empty((40, 6))
        middle, half = sum(self.shoulder) / 2.0, (self.shoulder[1] - self.shoulder[0]) / 2.0
        numbers[:5] = (
            self.kappa**2,
            (FORCE / self.torque) ** 2,
            math.cos(middle),
            math.sin(middle),
            math.cos(half),
        )
        numbers[5], numbers[6], numbers[7], numbers[8] = 1e-15 * numbers[1], 1e-15, 1e-15 * numbers[0], bits
        point = self.unit * self.side + np.array([0.0, 0.0, self.side])
        return witness_rows(point, lengths(box), numbers, np.empty((6, 3)), rows, 0), rows

    def sample(self, count: int, seed: int) -> np.ndarray:
        """(count, 4) designs of the box, its corners among them."""
        rng = np.random.default_rng(seed)
        u = rng.uniform(-1.0, 1.0, (count, 4))
        u[:16] = np.array([[1.0 if k >> j & 1 else -1.0 for j in range(4)] for k in range(16)])
        return u


CASES = 500
ALL = (0, KAPPA, TORQUE, SHOULDER, KAPPA | TORQUE | SHOULDER)


@pytest.mark.parametrize("bits", ALL)
def test_every_feasible_design_meets_every_row(bits: int) -> None:
    """120,000 designs for each kind of condition, in boxes at the very edge of what is feasible."""
    excluded = feasible = 0
    for seed in range(CASES):
        case = Case(seed)
        n, rows = case.rows(case.box, bits)
        u = case.sample(240, seed)
        points = case.box.mean(axis=0) + u * (case.box[1] - case.box[0]) / 2.0
        margins = case.margins(points)
        allowed = margins[0] > 1e-12
        for bit in (KAPPA, TORQUE, SHOULDER):
            if bits & bit:
                allowed &= margins[bit] > LIMIT
        feasible += int(allowed.sum())
        if n == EXCLUDED:
            excluded += 1
            assert not allowed.any()
            continue
        values = rows[:n, 0, None] + rows[:n, 1:5] @ u[allowed].T + rows[:n, 5, None]
        assert (values >= -1e-14).all()  # rows have a magnitude of at most 1
    assert feasible > 15_000
    assert excluded > 20 or bits == 0


@pytest.mark.parametrize("bits", ALL)
def test_a_single_design_is_judged_as_the_figures_judge_it(bits: int) -> None:
    """Same thresholds, same meaning: a box of no size is excluded exactly where the margins say so."""
    sides = [0, 0]
    for seed in range(CASES):
        case = Case(seed)
        for u in case.sample(20, seed)[-4:]:
            point = case.box.mean(axis=0) + u * (case.box[1] - case.box[0]) / 2.0
            margins = case.margins(point[None])
            asked = [margins[0][0]] + [margins[bit][0] for bit in (KAPPA, TORQUE, SHOULDER) if bits & bit]
            if margins[0][0] < 1e-12 or min(abs(m) for m in asked) < LIMIT:
                continue
            refused = case.rows(np.stack([point, point]), bits)[0] == EXCLUDED
            assert refused == (min(asked) < 0.0)
            sides[refused] += 1
    assert sides[0] > 100
    assert sides[1] > 100 or bits == 0


def test_a_point_out_of_reach_excludes() -> None:
    case = Case(1)
    point = np.array([0.05, 0.06, 0.0, 0.3])
    assert case.rows(np.stack([point, point]), 0)[0] == EXCLUDED


def test_rows_close_in_on_the_margin_with_the_square_of_the_width() -> None:
    """The error of a row falls to a quarter when the box is halved: what makes a gap of 1e-5 cheap."""
    case = Case(7)
    middle, errors = case.box.mean(axis=0), []
    for width in (1e-3, 5e-4):
        n, rows = case.rows(np.stack([middle - width, middle + width]), KAPPA | TORQUE)
        assert n > 0
        errors.append(np.median(rows[:n, 5] / np.abs(rows[:n, 1:5]).sum(axis=1)))
    assert errors[1] < 0.6 * errors[0]  # relative to slopes that themselves halve


def test_whole_rows_are_outline_lean_and_the_fold() -> None:
    rng, kinds = np.random.default_rng(3), [0, 0]
    for _ in range(2_000):
        la, lb, a, h, side = rng.uniform([0.05, 0.06, -0.03, 0.02, 0.01], [0.1, 0.2, 0.03, 0.1, 0.05])
        sum_max, lean = rng.uniform(0.05, 0.12), rng.uniform(0.0, 0.15)
        box = np.array([[la, lb, a, h]] * 2)
        rows = np.empty((8, 6))
        found = _whole_rows(lengths(box), box, np.array([side, sum_max, lean]), rows, 0)
        # fold: the point of the bottom face above the shoulder of chain 0, or of chain 1, must be reached
        over = []
        for u in ([a / side, 0.0], [-a / side / 2.0, a / side * math.sqrt(0.75)]):
            if max(map(abs, u)) <= 1.0:
                design = np.array([[la, lb, a + 0.05, 0.05, h, side]])
                over.append(figures_numpy(design, np.array([[*u, -1.0]])).closure[0, 0])
        broken = la + a > sum_max or lb < lean or min(over, default=1.0) < 0.0
        assert (found == EXCLUDED) <= broken  # never a design that holds
        if found != EXCLUDED:
            near = abs(a) > 1.154 * side or h > abs(la - lb) - 1e-12
            assert near
            assert la + a <= sum_max + 1e-12
            assert lb >= lean - 1e-12
        kinds[found == EXCLUDED] += 1
    assert min(kinds) > 200


def test_contraction_never_cuts_off_what_meets_all_rows() -> None:
    rng, cut = np.random.default_rng(4), 0
    for _ in range(300):
        n = int(rng.integers(1, 6))
        rows = rng.normal(size=(n, 6))
        rows[:, 5] = np.abs(rows[:, 5]) * 0.05
        rows /= np.abs(rows).sum(axis=1, keepdims=True) * 1.01
        low = rng.uniform(0.01, 0.1, 4)
        box = np.stack([low, low + rng.uniform(0.0, 0.05, 4) * (rng.random(4) < 0.8)])
        before = box.copy()
        share = _contract(rows, n, box)
        u = rng.uniform(-1.0, 1.0, (3_000, 4))
        u[:1_000] = np.sign(u[:1_000])
        kept = (rows[:, 0, None] + rows[:, 5, None] + rows[:, 1:5] @ u.T >= 0.0).all(axis=0)
        points = (before.sum(axis=0) + u * (before[1] - before[0])) / 2.0
        if share == 0.0:
            assert not kept.any()
            continue
        assert (box[0] >= before[0]).all()
        assert (box[1] <= before[1]).all()
        assert (points[kept] >= box[0] - 1e-17).all()
        assert (points[kept] <= box[1] + 1e-17).all()
        cut += share < 0.9
    assert cut > 50
