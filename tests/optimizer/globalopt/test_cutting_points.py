"""Cuts at points against the NumPy figures: the feasible meets every cut, the excluded is infeasible."""

from __future__ import annotations

import math
from fractions import Fraction
from functools import cache

import numpy as np
import pytest

from delta_cad.mechanism.enclosure.affine_form import add, constant, scale
from delta_cad.mechanism.enclosure.symmetric import quotient
from delta_cad.mechanism.enclosure.table import EXCLUDED
from delta_cad.mechanism.limits import (
    AssemblyMode,
    CoupleIndex,
    EffectiveMass,
    Friction,
    HandleFriction,
    HandleInertia,
    Kappa,
    Limits,
    PoseLimit,
    PositionStep,
    Shoulder,
    Torque,
)
from optimizer.globalopt.branch_and_bound import _contract, design_cuts
from optimizer.globalopt.cutting_points import MOST, ROWS, fill_lengths, numbers, point_cuts
from optimizer.problem.evaluator import Figures
from tests.optimizer.problem.figures_numpy import figures_numpy

Kinds = tuple[type[PoseLimit], ...]
FORCE, COUNT = 3.0, 3.8e-4
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
        low, high = f.shoulder_min[0, 0] - abs(slack - 1.0), f.shoulder_max[0, 0] + (slack - 1.0)
        # a rod's centre may be beyond its wrist, which couples its ends negatively
        self.masses = HandleInertia(*rng.uniform([0.03, 0.0, -0.005, 0.0], [0.2, 0.04, 0.02, 1e-3]))
        self.sources = HandleFriction(*rng.uniform([1e-3, 0.0, 0.0], [0.03, 0.1, 0.1]))
        self.limits: dict[type[PoseLimit], PoseLimit] = {
            Torque: Torque(FORCE, FORCE * f.moment[0, 0] / f.determinant[0, 0] * slack),
            Kappa: Kappa(max(slack / abs(f.quality[0, 0]), 1.0)),
            Shoulder: Shoulder(low, high if low < high else low + 0.1),
            EffectiveMass: EffectiveMass(
                self.masses.carried_mass / f.mass_ratio(self.masses)[0, 0] * slack, self.masses
            ),
            Friction: Friction(slack / f.inverse_friction(self.sources)[0, 0], *self.sources),
            PositionStep: PositionStep(slack * COUNT * f.scaled_step()[0, 0] / f.determinant[0, 0], COUNT),
            CoupleIndex: CoupleIndex(min(CoupleIndex(0.0).margin(f)[0, 0] / slack, 1.0)),
        }

    def figures(self, points: np.ndarray) -> Figures:
        """Figures of (D, 4) reduced designs at the point, (D, 1) each."""
        la, lb, a, h = points.T
        designs = np.column_stack([la, lb, a + 0.05, np.full(len(a), 0.05), h, np.full(len(a), self.side)])
        return figures_numpy(designs, self.unit[None])

    def margins(self, f: Figures, kinds: Kinds) -> np.ndarray:
        """(1 + kinds, D) margins as a search sees them, that of reach first."""
        return np.stack([f.closure[:, 0], *(self.limits[kind].margin(f)[:, 0] for kind in kinds)])

    def cuts(self, box: np.ndarray, kinds: Kinds) -> tuple[int, np.ndarray]:
        """How many cuts, and the cuts."""
        limits = [self.limits[kind] for kind in kinds]
        if any(kind.infinite_at_singularity for kind in kinds):  # as `Problem.pose_limits` does
            limits.append(AssemblyMode())
        required, room, pose = numbers(Limits.of(*limits)), np.empty((MOST, 6)), np.empty((ROWS, 6))
        fill_lengths(box, pose)
        point = self.unit * self.side + np.array([0.0, 0.0, self.side])
        return point_cuts(point[None], 0, required, pose, np.empty((24, 6)), room, 0), room

    def sample(self, count: int, seed: int) -> np.ndarray:
        """(count, 4) designs of the box, its corners among them."""
        rng = np.random.default_rng(seed)
        u = rng.uniform(-1.0, 1.0, (count, 4))
        u[:16] = np.array([[1.0 if k >> j & 1 else -1.0 for j in range(4)] for k in range(16)])
        return u

    def at(self, u: np.ndarray) -> np.ndarray:
        """(D, 4) designs of the box from -1 to 1."""
        return self.box.mean(axis=0) + u * (self.box[1] - self.box[0]) / 2.0


CASES = 500


@cache
def filled(seed: int) -> tuple[Case, np.ndarray, Figures]:
    """A case with 240 designs of its box and their figures, whatever limits are asked."""
    case = Case(seed)
    u = case.sample(240, seed)
    return case, u, case.figures(case.at(u))


@cache
def single(seed: int) -> tuple[Case, np.ndarray, Figures]:
    """A case with four designs of its box and their figures."""
    case = Case(seed)
    points = case.at(case.sample(20, seed)[-4:])
    return case, points, case.figures(points)


ALL: tuple[Kinds, ...] = (
    (),
    (Kappa,),
    (Torque,),
    (Shoulder,),
    (EffectiveMass,),
    (CoupleIndex,),
    (Friction,),
    (PositionStep,),
    (Kappa, Torque, Shoulder),
    (Kappa, Torque, Shoulder, EffectiveMass, CoupleIndex),
)


def named(kinds: Kinds) -> str:
    return " ".join(kind.name for kind in kinds) or "reach"


@pytest.mark.parametrize("kinds", ALL, ids=named)
def test_every_feasible_design_meets_every_cut(kinds: Kinds) -> None:
    """120,000 designs for each kind of limit, in boxes at the very edge of what is feasible."""
    excluded = feasible = 0
    for seed in range(CASES):
        case, u, figures = filled(seed)
        n, cuts = case.cuts(case.box, kinds)
        margins = case.margins(figures, kinds)
        allowed = (margins[0] > 1e-12) & (margins[1:] > LIMIT).all(axis=0)
        feasible += int(allowed.sum())
        if n == EXCLUDED:
            excluded += 1
            assert not allowed.any()
            continue
        values = cuts[:n, 0, None] + cuts[:n, 1:5] @ u[allowed].T + cuts[:n, 5, None]
        assert (values >= -1e-14).all()  # cuts have a magnitude of at most 1
    assert feasible > 15_000
    assert excluded > 20 or not kinds


@pytest.mark.parametrize("kinds", ALL, ids=named)
def test_a_single_design_is_judged_as_the_figures_judge_it(kinds: Kinds) -> None:
    """Same thresholds, same meaning: a box of no size is excluded exactly where the margins say so."""
    sides = [0, 0]
    for seed in range(CASES):
        case, points, figures = single(seed)
        for point, margins in zip(points, case.margins(figures, kinds).T, strict=True):
            if margins[0] < 1e-12 or np.abs(margins).min() < LIMIT:
                continue
            refused = case.cuts(np.stack([point, point]), kinds)[0] == EXCLUDED
            assert refused == (margins.min() < 0.0)
            sides[refused] += 1
    assert sides[0] > 100
    assert sides[1] > 100 or not kinds


def test_a_point_out_of_reach_excludes() -> None:
    case = Case(1)
    point = np.array([0.05, 0.06, 0.0, 0.3])
    assert case.cuts(np.stack([point, point]), ())[0] == EXCLUDED


@pytest.mark.parametrize("kinds", [(Kappa, Torque), *ALL[4:8]], ids=named)
def test_cuts_close_in_on_the_margin_with_the_square_of_the_width(kinds: Kinds) -> None:
    """The error of a cut falls to a quarter when the box is halved: what makes a gap of 1e-5 cheap."""
    case = Case(7)
    middle, errors = case.box.mean(axis=0), []
    for width in (1e-3, 5e-4):
        n, cuts = case.cuts(np.stack([middle - width, middle + width]), kinds)
        assert n > 0
        errors.append(np.median(cuts[:n, 5] / np.abs(cuts[:n, 1:5]).sum(axis=1)))
    assert errors[1] < 0.6 * errors[0]  # relative to slopes that themselves halve


def test_design_cuts_are_outline_lean_and_the_fold() -> None:
    rng, kinds = np.random.default_rng(3), [0, 0]
    for _ in range(2_000):
        la, lb, a, h, side = rng.uniform([0.05, 0.06, -0.03, 0.02, 0.01], [0.1, 0.2, 0.03, 0.1, 0.05])
        sum_max, sum_min, lean = rng.uniform(0.05, 0.12), rng.uniform(0.0, 0.08), rng.uniform(0.0, 0.15)
        box = np.array([[la, lb, a, h]] * 2)
        pose = np.empty((ROWS, 6))
        fill_lengths(box, pose)
        found = design_cuts(pose, box, np.array([side, sum_max, lean, sum_min]), np.empty((8, 6)), 0)
        # fold: the point of the bottom face above the shoulder of chain 0, or of chain 1, must be reached
        over = []
        for u in ([a / side, 0.0], [-a / side / 2.0, a / side * math.sqrt(0.75)]):
            if max(map(abs, u)) <= 1.0:
                design = np.array([[la, lb, a + 0.05, 0.05, h, side]])
                over.append(figures_numpy(design, np.array([[*u, -1.0]])).closure[0, 0])
        broken = not sum_min <= la + a <= sum_max or lb < lean or min(over, default=1.0) < 0.0
        assert (found == EXCLUDED) <= broken  # never a design that holds
        if found != EXCLUDED:
            near = abs(a) > 1.154 * side or h > abs(la - lb) - 1e-12
            assert near
            assert sum_min - 1e-12 <= la + a <= sum_max + 1e-12
            assert lb >= lean - 1e-12
        kinds[found == EXCLUDED] += 1
    assert min(kinds) > 200


def test_contraction_never_cuts_off_what_meets_all_cuts() -> None:
    rng, cut = np.random.default_rng(4), 0
    for _ in range(300):
        n = int(rng.integers(1, 6))
        cuts = rng.normal(size=(n, 6))
        cuts[:, 5] = np.abs(cuts[:, 5]) * 0.05
        cuts /= np.abs(cuts).sum(axis=1, keepdims=True) * 1.01
        low = rng.uniform(0.01, 0.1, 4)
        box = np.stack([low, low + rng.uniform(0.0, 0.05, 4) * (rng.random(4) < 0.8)])
        before = box.copy()
        share = _contract(cuts, n, box)
        u = rng.uniform(-1.0, 1.0, (3_000, 4))
        u[:1_000] = np.sign(u[:1_000])
        kept = (cuts[:, 0, None] + cuts[:, 5, None] + cuts[:, 1:5] @ u.T >= 0.0).all(axis=0)
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


def test_a_rayleigh_quotient_counts_eight_roundings_of_each_factor() -> None:
    """Beside what its products and sums count themselves; the exact quotient of constants lies inside."""
    rng = np.random.default_rng(8)
    for _ in range(50):
        vector = rng.normal(size=3)
        work = np.zeros((6, 1))
        work[3:, 0] = vector
        entries = rng.normal(size=6) * 10.0 ** rng.uniform(-4.0, 4.0, 6)
        matrix = tuple(constant(float(a), 0.0) for a in entries)
        found = quotient(matrix, work, 0)
        x, y, z = (Fraction(float(v)) for v in vector)
        products = [x * x, y * y, z * z, 2 * x * y, 2 * x * z, 2 * y * z]
        exact = sum(f * Fraction(float(a)) for f, a in zip(products, entries, strict=True)) / (x * x + y * y + z * z)
        assert abs(exact - Fraction(found[0])) <= Fraction(found[5])
        x, y, z = vector.tolist()
        f = 1.0 / (x * x + y * y + z * z)
        factors = (f * x * x, f * y * y, f * z * z, 2.0 * f * x * y, 2.0 * f * x * z, 2.0 * f * y * z)
        parts = [scale(k, a) for k, a in zip(factors, matrix, strict=True)]
        own = add(add(add(parts[0], parts[1]), parts[2]), add(add(parts[3], parts[4]), parts[5]))
        eight = Fraction(8, 2**53) * sum(abs(Fraction(a)) for a in entries.tolist())
        assert Fraction(found[5]) - Fraction(own[5]) >= eight
