"""Couple index: how well the rod pairs keep the platform from turning, README (47)-(52)."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from delta_cad.common.jit import compiled, inlined
from delta_cad.mechanism.enclosure import pose as forms
from delta_cad.mechanism.enclosure.affine_form import (
    ROUND,
    TERMS,
    TINY,
    UP,
    add,
    at,
    constant,
    magnitude,
    multiply,
    put,
    scale,
    subtract,
)
from delta_cad.mechanism.enclosure.interval import Interval, Slopes
from delta_cad.mechanism.enclosure.slope_pose import SlopePose, Vector, centre_of, definite, dot, norm2, products
from delta_cad.mechanism.enclosure.slope_pose import eigenvectors as slope_eigenvectors
from delta_cad.mechanism.enclosure.symmetric import NEARLY, above, eigenvectors
from delta_cad.mechanism.enclosure.table import EXCLUDED, HIGH, INSIDE, LOW, Enclosure, keep, store
from delta_cad.mechanism.geometry import SIN_60, DeltaGeometry, chain_coordinates, side_sine
from delta_cad.mechanism.inverse import arm_direction
from delta_cad.mechanism.limits.limit import Field, FigureOfMerit, ThresholdLimit

_RANGE = (0.0, 1.0)
THIRD = 2.0 * math.pi / 3.0
_TURNED = 6  # First of nine rows of the room to work in: S w of each eigenvector w, three parts each.


def couple_index(g: DeltaGeometry, p: np.ndarray) -> np.ndarray:
    """Computes the smallest singular value of the couples that the rod pairs can bear, README (47).

    Args:
        g: The mechanism.
        p: (..., 3) platform centre in the base frame, m.

    Returns:
        (...) between 0 and 1, without unit: 0 where the rod pairs no longer resist a turn of the platform about some
        axis; NaN where a chain is open.
    """
    q, _, z = chain_coordinates(g, p)
    cos, sin = arm_direction(g, p)
    L_A, L_B = g.upper_arm_length, g.forearm_length
    return least_singular_value((q - L_A * cos) / L_B, (z - L_A * sin) / L_B, g.side_cosine)


def least_singular_value(radial: np.ndarray, vertical: np.ndarray, side_cosine: float) -> np.ndarray:
    """Computes the smallest singular value of the couples from the rods' parts in their chains' planes, README (48).

    Args:
        radial: (..., 3 chains) part of n, the unit vector of the rods, along the chain's radius.
        vertical: (..., 3 chains) its part along z.
        side_cosine: Cosine of the azimuth of chain 1.

    Returns:
        (...) without unit; NaN where a part is.
    """
    parts = *np.moveaxis(radial, -1, 0), *np.moveaxis(vertical, -1, 0)
    return least_of.py_func(*parts, side_cosine, side_sine(side_cosine))


@inlined
def least_of(r1, r2, r3, v1, v2, v3, c, s):
    """Computes what `least_singular_value` does: of numbers where it is compiled, of arrays of one shape where not.

    c and s are cosine and sine of the azimuth of chain 1.
    """
    a12, a13 = r1 * r2 + c * v1 * v2, r1 * r3 + c * v1 * v3
    a23 = r2 * r3 + (2.0 * c * c - 1.0) * v2 * v3  # chains 1 and 2 are twice the azimuth apart
    b11, b22, b33 = r1 * r1 + v1 * v1, r2 * r2 + v2 * v2, r3 * r3 + v3 * v3
    mean = (b11 + b22 + b33) / 3.0
    b11, b22, b33 = b11 - mean, b22 - mean, b33 - mean  # B of README (25)
    s12, s13, s23 = a12 * a12, a13 * a13, a23 * a23
    square = (b11 * b11 + b22 * b22 + b33 * b33 + 2.0 * (s12 + s13 + s23)) / 6.0
    cosine = 0.5 * (b11 * (b22 * b33 - s23) - s12 * b33 - s13 * b22) + a12 * a13 * a23
    # B and B^2 without its trace, each as five parts whose squares add up alike; the sine by Lagrange's identity
    f1, f2, f3, f4, f5 = 0.5 * (b11 - b22), SIN_60 * b33, a12, a13, a23
    g1, g2 = 0.5 * (b11 * b11 + s13 - b22 * b22 - s23), SIN_60 * (b33 * b33 + s13 + s23 - 2.0 * square)
    g3, g4, g5 = a13 * a23 - a12 * b33, a12 * a23 - a13 * b22, a12 * a13 - a23 * b11
    minors = (f1 * g2 - f2 * g1) ** 2 + (f1 * g3 - f3 * g1) ** 2 + (f1 * g4 - f4 * g1) ** 2
    minors = minors + (f1 * g5 - f5 * g1) ** 2 + (f2 * g3 - f3 * g2) ** 2 + (f2 * g4 - f4 * g2) ** 2
    minors = minors + (f2 * g5 - f5 * g2) ** 2 + (f3 * g4 - f4 * g3) ** 2 + (f3 * g5 - f5 * g3) ** 2
    minors = minors + (f4 * g5 - f5 * g4) ** 2
    angle = np.arctan2(np.sqrt(minors) / 3.0, cosine) / 3.0
    size = 2.0 * np.sqrt(square)
    largest, middle = mean + size * np.cos(angle), mean + size * np.cos(angle - THIRD)
    others = np.sqrt(np.maximum(largest * middle, 0.0))
    determinant = s * np.abs(-2.0 * c * r1 * v2 * v3 + v1 * r2 * v3 + v1 * v2 * r3)
    return determinant * (others != 0.0) / (others + (others == 0.0))  # 0 where both are


@compiled
def _directions(pose, work):
    """Fills work[3:6] with the eigenvectors of S^T S at the box's middle; whether they are orthonormal."""
    r1, r2, r3 = pose[forms.RADIAL, 0], pose[forms.RADIAL + 1, 0], pose[forms.RADIAL + 2, 0]
    v1, v2, v3 = pose[forms.VERTICAL, 0], pose[forms.VERTICAL + 1, 0], pose[forms.VERTICAL + 2, 0]
    c = pose[forms.COSINE, 0]
    a = (
        r1 * r1 + v1 * v1,
        r2 * r2 + v2 * v2,
        r3 * r3 + v3 * v3,
        r1 * r2 + c * v1 * v2,
        r1 * r3 + c * v1 * v3,
        r2 * r3 + (2.0 * c * c - 1.0) * v2 * v3,
    )
    return eigenvectors(a, work)


@compiled
def _turn(pose, work, k):
    """Computes S w, w column k of work[3:6]: along x, along y by the sine of chain 1's azimuth, and along -z, m."""
    w1, w2, w3 = work[3, k], work[4, k], work[5, k]
    v2, v3 = scale(w2, at(pose, forms.VERTICAL + 1)), scale(w3, at(pose, forms.VERTICAL + 2))
    r2, r3 = scale(w2, at(pose, forms.RADIAL + 1)), scale(w3, at(pose, forms.RADIAL + 2))
    sides = forms.times(pose, forms.COSINE, add(v2, v3))
    put(work, _TURNED + 3 * k, add(scale(w1, at(pose, forms.VERTICAL)), sides))
    put(work, _TURNED + 3 * k + 1, subtract(v2, v3))
    put(work, _TURNED + 3 * k + 2, add(scale(w1, at(pose, forms.RADIAL)), add(r2, r3)))


@compiled
def _scalar(pose, work, k, l):  # noqa: E741
    """Computes the scalar product of S w_k and S w_l; at 120 degrees the square of the sine is exactly 3/4."""
    a, b = _TURNED + 3 * k, _TURNED + 3 * l
    along_y = forms.times(pose, forms.SINE_2, multiply(at(work, a + 1), at(work, b + 1)))
    flat = add(multiply(at(work, a), at(work, b)), along_y)
    return add(flat, multiply(at(work, a + 2), at(work, b + 2)))


@compiled
def _enclose(pose, k, n, work, out, row):
    """Computes the margin of one machine, or of the drawn one less what a tolerance can change, README (50)."""
    if not k[forms.TOLERANCE] > 0.0:
        _enclose_one(pose, k, n, work, out, row)
        return
    drawn = pose[forms.ROWS :]
    _enclose_one(drawn, k, n, work, out, row)
    lb, d, last, change = k[3], k[forms.TOLERANCE], TERMS - 1, 0.0
    for i in range(3):
        along = pose[forms.RADIAL + i, last] - drawn[forms.RADIAL + i, last]
        up = pose[forms.VERTICAL + i, last] - drawn[forms.VERTICAL + i, last]
        turned = (math.sqrt(along * along + up * up) + d) / (lb - d)
        change += turned * turned
    change = math.sqrt(change) * forms.LIFT
    least = math.sqrt((k[n] + k[n + 1]) * UP) * UP
    out[row, LOW] -= lb * lb * change * (2.0 * least + change) * forms.LIFT


@compiled
def _enclose_one(pose, k, n, work, out, row):
    """Computes L_B^2 times the square of the index less that of its least, README (49)."""
    out[row, :] = math.nan
    if not _directions(pose, work):
        return
    for column in range(3):
        _turn(pose, work, column)
    h11, h22, h33 = _scalar(pose, work, 0, 0), _scalar(pose, work, 1, 1), _scalar(pose, work, 2, 2)
    h12, h13, h23 = _scalar(pose, work, 0, 1), _scalar(pose, work, 0, 2), _scalar(pose, work, 1, 2)
    under = above(scale(-1.0, h33), scale(-1.0, h22), scale(-1.0, h11), h23, h13, h12)
    store(out, row, subtract(h33, multiply(constant(k[n], k[n + 1]), at(pose, forms.FOREARM_2))))
    # columns that are not quite orthonormal change the eigenvalue by that factor
    bent = 3.0 * NEARLY * (magnitude(h33) + under)
    out[row, LOW] -= (under + bent) * UP
    out[row, HIGH] += bent


@compiled
def _cut(pose, k, n, work, cuts, count):
    """Adds |S w|^2 >= (index L_B |w|)^2 for the two directions w in which it is smallest at the box's middle."""
    if not _directions(pose, work):
        return count
    least = multiply(constant(k[n], k[n + 1]), at(pose, forms.FOREARM_2))
    for column in (2, 1):
        _turn(pose, work, column)
        x, y, z = work[3, column], work[4, column], work[5, column]
        size = (x * x + y * y + z * z) * INSIDE
        count = keep(cuts, count, subtract(_scalar(pose, work, column, column), scale(size, least)))
        if count == EXCLUDED:
            return count
    return count


@dataclass(frozen=True)
class CoupleIndex(ThresholdLimit):
    """Least couple index, without unit."""

    couple_index_min: float

    name: ClassVar = "couple_index"
    fields_: ClassVar = (
        Field(
            "couple_index_min", "least rotational stiffness index: hold of the rod pairs against turning", gt=0, lt=1
        ),
    )
    keys: ClassVar = {"couple_index_min": "couple_index_min"}
    output_key: ClassVar = "min_couple_index"
    figures: ClassVar = (
        FigureOfMerit(
            "couple_index",
            "",
            lambda _, g, p: couple_index(g, p)[..., None],
            "couple_index_min",
            _RANGE,
            upper=False,
            relative=False,
        ),
    )
    enclosure: ClassVar = Enclosure(forms.CHAINS, 2, 1, _enclose, _cut, 2)

    def numbers(self) -> tuple[float, ...]:
        """Gives the square of the least index and its error."""
        square = self.couple_index_min**2
        return square, ROUND * square + TINY

    def _turned(self, pose: SlopePose) -> tuple[list[Vector], np.ndarray]:
        """The couples turned by the eigenvectors of their products at the boxes' centres, and these (n, 3, 3)."""
        middle = np.array([[centre_of(part) for part in couple] for couple in pose.couples])  # (chain, axis, n)
        v = slope_eigenvectors(np.einsum("ian,jan->nij", middle, middle))
        return [_sum(pose.couples, v[:, :, k]) for k in range(3)], v

    def _least(self, pose: SlopePose, exact: Callable[[float], Interval]) -> Interval:
        return (exact(self.couple_index_min) * pose.forearm_length).square()

    def proved_by_intervals(self, pose: SlopePose, exact: Callable[[float], Interval]) -> np.ndarray:
        """Proves that the products of the couples less the least are positive definite, README (51)."""
        turned, v = self._turned(pose)
        least = self._least(pose, exact)
        margins = {
            (k, m): (dot(turned[k], turned[m]) if k < m else norm2(turned[k])).plus(-(weight * least)).box
            for (k, m), weight in products(v).items()
        }
        return definite(margins, (2, 1, 0))

    def refuted_by_intervals(self, pose: SlopePose, exact: Callable[[float], Interval]) -> bool:
        """Shows three amounts whose sum of couples is too small."""
        turned, v = self._turned(pose)
        found = norm2(turned[0]).centre - products(v)[0, 0] * self._least(pose, exact)
        return bool(found.hi[0] < 0.0)

    def margin(self, f: Any) -> np.ndarray:
        """Computes the index less its least, that of the forearms where a chain is open."""
        return self.search_quantities(f)["index"] - self.couple_index_min

    def search_quantities(self, f: Any) -> dict[str, np.ndarray]:
        """Computes the index of the chains as they are continued beyond their reach."""
        return {"index": f.couple_index()}

    def extreme_value(self, least: Mapping[str, float]) -> float:
        """Gives the smallest index."""
        return least["index"]


def _sum(couples: tuple[Vector, ...], weights: np.ndarray) -> Vector:
    """The sum of vectors of forms, each times its column of weights (n, 3)."""
    w = [Interval(weights[:, i], weights[:, i]) for i in range(3)]

    def part(axis: int) -> Slopes:
        first, second, third = (couple[axis].times(by) for couple, by in zip(couples, w, strict=True))
        return first + second + third

    return part(0), part(1), part(2)
