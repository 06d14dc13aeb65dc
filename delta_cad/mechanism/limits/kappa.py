"""Condition number of the Jacobian: how alike forces and motions are in all directions."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from delta_cad.common.jit import compiled
from delta_cad.mechanism.enclosure import pose as forms
from delta_cad.mechanism.enclosure.affine_form import (
    ROUND,
    UP,
    at,
    constant,
    inverse,
    lower,
    magnitude,
    multiply,
    scale,
    subtract,
)
from delta_cad.mechanism.enclosure.interval import Interval
from delta_cad.mechanism.enclosure.slope_pose import SlopePose
from delta_cad.mechanism.enclosure.symmetric import NEARLY, above, congruent, eigenvectors, quotient
from delta_cad.mechanism.enclosure.table import EXCLUDED, HIGH, LOW, Enclosure, keep, store
from delta_cad.mechanism.limits.limit import Field, FigureOfMerit, ThresholdLimit
from delta_cad.mechanism.statics import conditioning

_RANGE = (1.0, 1e6)


@compiled
def _enclose(pose, k, n, work, out, row):
    """Computes K^2 l3 - l1 of one machine, or of the drawn one less what a tolerance can change, README (45)."""
    if not k[forms.TOLERANCE] > 0.0:
        _enclose_one(pose, k, n, work, out, row)
        return
    least = _enclose_one(pose[forms.ROWS :], k, n, work, out, row)
    change = 0.0
    for i in range(3):
        change += magnitude(at(pose, forms.CHANGE + i)) ** 2
    largest = math.sqrt((k[n] + k[n + 1]) * UP) * UP
    out[row, LOW] -= 2.0 * largest * (largest + 1.0) * math.sqrt(change * least) * forms.LIFT


@compiled
def _enclose_one(pose, k, n, work, out, row):
    """Computes K^2 l3 - l1 of the Gram matrix of the rows s_i / (L_A w_i), README (33); 0 where only (34) proves it.

    Returns:
        A bound of l3 from above.
    """
    out[row, :] = math.nan
    la, la2 = at(pose, forms.UPPER_ARM), at(pose, forms.UPPER_ARM_2)
    i1, i2 = inverse(multiply(la, at(pose, forms.W))), inverse(multiply(la, at(pose, forms.W + 1)))
    i3 = inverse(multiply(la, at(pose, forms.W + 2)))
    lb2, det = at(pose, forms.FOREARM_2), at(pose, forms.DETERMINANT)
    a = (
        multiply(lb2, inverse(multiply(la2, at(pose, forms.W2)))),
        multiply(lb2, inverse(multiply(la2, at(pose, forms.W2 + 1)))),
        multiply(lb2, inverse(multiply(la2, at(pose, forms.W2 + 2)))),
        multiply(at(pose, forms.PRODUCT + 2), multiply(i1, i2)),
        multiply(at(pose, forms.PRODUCT + 1), multiply(i1, i3)),
        multiply(at(pose, forms.PRODUCT), multiply(i2, i3)),
    )
    if not eigenvectors((a[0][0], a[1][0], a[2][0], a[3][0], a[4][0], a[5][0]), work):
        return math.nan
    h11, h22, h33 = congruent(a, work, 0, 0), congruent(a, work, 1, 1), congruent(a, work, 2, 2)
    h12, h13, h23 = congruent(a, work, 0, 1), congruent(a, work, 0, 2), congruent(a, work, 1, 2)
    over = above(h11, h22, h33, h12, h13, h23)
    under = above(scale(-1.0, h33), scale(-1.0, h22), scale(-1.0, h11), h23, h13, h12)
    square = constant(k[n], k[n + 1])
    store(out, row, subtract(multiply(square, h33), h11))
    # columns that are not quite orthonormal change either eigenvalue by that factor
    bent = 3.0 * NEARLY * (magnitude(h11) + over + 2.0 * k[n] * magnitude(h33))
    out[row, LOW] -= (over + (k[n] + k[n + 1]) * under + bent) * UP
    out[row, HIGH] += bent
    least = magnitude(h33) * (1.0 + 3.0 * NEARLY) * UP
    if out[row, LOW] >= 0.0:
        return least
    c33, c22 = subtract(multiply(h11, h22), multiply(h12, h12)), subtract(multiply(h11, h33), multiply(h13, h13))
    c11 = subtract(multiply(h22, h33), multiply(h23, h23))
    c13, c23 = subtract(multiply(h12, h23), multiply(h13, h22)), subtract(multiply(h12, h13), multiply(h11, h23))
    lift = above(c33, c22, c11, c23, c13, subtract(multiply(h13, h23), multiply(h12, h33)))
    whole = multiply(det, multiply(i1, multiply(i2, i3)))
    volume = multiply(square, multiply(whole, whole))
    slack = lower(subtract(volume, multiply(h11, c33)))
    first, second = magnitude(h11) + over, magnitude(c33) + lift
    slack -= (magnitude(h11) * lift + magnitude(c33) * over + over * lift) * UP
    slack -= 10.0 * NEARLY * (first * second + magnitude(volume))
    if slack >= 0.0:
        out[row, LOW] = 0.0
    return least


@compiled
def _cut(pose, k, n, work, cuts, count):
    """Adds K^2 l3 >= l1 and its like, the eigenvalues as quotients of the Gram matrix of s_i w_j w_k: no division."""
    v1, v2, v3 = at(pose, forms.W2), at(pose, forms.W2 + 1), at(pose, forms.W2 + 2)
    w1, w2, w3 = at(pose, forms.W), at(pose, forms.W + 1), at(pose, forms.W + 2)
    lb2 = at(pose, forms.FOREARM_2)
    a = (
        multiply(lb2, multiply(v2, v3)),
        multiply(lb2, multiply(v1, v3)),
        multiply(lb2, multiply(v1, v2)),
        multiply(at(pose, forms.PRODUCT + 2), multiply(multiply(w1, w2), v3)),
        multiply(at(pose, forms.PRODUCT + 1), multiply(multiply(w1, w3), v2)),
        multiply(at(pose, forms.PRODUCT), multiply(multiply(w2, w3), v1)),
    )
    if not eigenvectors((a[0][0], a[1][0], a[2][0], a[3][0], a[4][0], a[5][0]), work):
        return count
    square = constant(k[n], k[n + 1])
    h1, h2, h3 = quotient(a, work, 0), quotient(a, work, 1), quotient(a, work, 2)
    count = keep(cuts, count, subtract(multiply(square, h3), h1))
    if count != EXCLUDED:
        count = keep(cuts, count, subtract(multiply(square, h3), h2))
    if count != EXCLUDED:
        count = keep(cuts, count, subtract(multiply(square, h2), h1))
    return count


@dataclass(frozen=True)
class Kappa(ThresholdLimit):
    """Largest condition number of the Jacobian."""

    kappa_max: float

    name: ClassVar = "kappa"
    evaluates: ClassVar = ("quality",)
    fields_: ClassVar = (Field("kappa_max", "largest condition number in the cube", ge=1, le=1e6),)
    keys: ClassVar = {"kappa_max": "kappa_max"}
    figures: ClassVar = (
        FigureOfMerit("kappa", "", lambda _, g, p: conditioning(g, p)[..., None], "kappa_max", _RANGE),
    )
    infinite_at_singularity: ClassVar = True
    output_key: ClassVar = "max_kappa"
    enclosure: ClassVar = Enclosure(forms.FOREARMS, 2, 1, _enclose, _cut, 3)

    def numbers(self) -> tuple[float, ...]:
        """Gives K^2 and its error."""
        return self.kappa_max**2, ROUND * self.kappa_max**2

    def proved_by_intervals(self, pose: SlopePose, exact: Callable[[float], Interval]) -> np.ndarray:
        """Proves that all eigenvalues of the Gram matrix A lie within [mu, K^2 mu] for a linear mu of the position.

        A - mu and K^2 mu - A are positive definite if V^T (.) V is, for whatever regular V.
        """
        return pose.gram_within(exact(self.kappa_max).square())

    def refuted_by_intervals(self, pose: SlopePose, exact: Callable[[float], Interval]) -> bool:
        """Shows that two quotients of the Gram matrix are too far apart at a position."""
        small, large = pose.gram_quotients()
        return bool((large - exact(self.kappa_max).square() * small).lo[0] > 0.0)

    def margin(self, f: Any) -> np.ndarray:
        """Computes 1 / kappa less its least."""
        return f.quality - 1.0 / self.kappa_max

    def search_quantities(self, f: Any) -> dict[str, np.ndarray]:
        """Computes 1 / kappa with the sign of the determinant."""
        return {"quality": f.quality}

    def extreme_value(self, least: Mapping[str, float]) -> float:
        """Computes the largest kappa; infinite where the determinant changes sign or a chain folds."""
        return 1.0 / least["quality"] if least["quality"] > 0.0 else math.inf
