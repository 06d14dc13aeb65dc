"""The mechanism over boxes of positions in interval slopes: the second arithmetic, in which certificates are replayed.

Formulas are numbered as in the mechanism's README. Where the prover takes polynomials and bounds eigenvalues, this
takes quotients, cross products and the definiteness of matrices.
"""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from functools import cached_property

import numpy as np

from delta_cad.mechanism.enclosure.interval import DOWN, UP, Interval, Slopes, exactly, variables
from delta_cad.mechanism.geometry import DeltaGeometry

Vector = tuple[Slopes, Slopes, Slopes]
Symmetric = Mapping[tuple[int, int], Slopes]  # Entries (i, j), i <= j, of symmetric 3 x 3 matrices.


class SlopePose:
    """The mechanism over n boxes; each quantity is computed once, README (1)-(6).

    Args:
        g: The mechanism.
        lower: (n, 3) lower corners, m.
        upper: (n, 3) upper corners, m.
        tolerance: Of every length and offset of every chain, m, README (43): the forms are then functions of the
            position and of each chain's deviations, over all of them.

    Attributes:
        q: Radial coordinate of each chain's wrist, m.
        t: Coordinate along the shoulder axis, m.
        z: Height, m.
        w2: Closure margin, m^2.
        arm: Elbow arm w, m; NaN unless w^2 is positive throughout.
        forearm: Components of s in the base frame, m, by chain.
        elbow: Direction in which each elbow moves, in the base frame.
        azimuths: Cosine and sine of each chain's azimuth.
        cos: Cosine of the shoulder angle.
        sin: Sine of the shoulder angle.
        upper_arm: L_A of every chain, m.
        forearm_length: L_B of every chain, m.
    """

    def __init__(self, g: DeltaGeometry, lower: np.ndarray, upper: np.ndarray, tolerance: float = 0.0) -> None:
        first = exactly(g.base_radius) - exactly(g.platform_radius)
        side = first if g.side_shift == 0.0 else first + exactly(g.side_shift)  # where there is none, nothing is added
        la, lb = exactly(g.upper_arm_length), exactly(g.forearm_length)
        if tolerance == 0.0:
            x, y, z = variables(lower, upper)
            deviations = []
        else:
            most = np.tile(np.repeat([2.0 * tolerance, tolerance], [3, 2]), (len(lower), 3))
            x, y, z, *deviations = variables(np.hstack([lower, -most]), np.hstack([upper, most]))
        cosine, sine = exactly(g.side_cosine), _enclosing(1 - Fraction(g.side_cosine) ** 2).root()
        self.azimuths = (exactly(1.0), exactly(0.0)), (cosine, sine), (cosine, -sine)
        chains = []
        for i, ((c, s), a) in enumerate(zip(self.azimuths, (first, side, side), strict=True)):
            q, t, h = (x.times(c) + y.times(s)).plus(-a), y.times(c) - x.times(s), z
            arm: Slopes | Interval = la
            difference: Slopes | Interval = la.square() - lb.square()
            double: Slopes | Interval = la + la
            if deviations:
                along, adjacent, above, more, longer = deviations[5 * i : 5 * i + 5]
                q, t, h, arm = q + along, t + adjacent, z + above, more.plus(la)
                difference, double = arm.square() - longer.plus(lb).square(), arm + arm
            rho2 = q.square() + h.square()
            m = _by(_plus(rho2 + t.square(), difference), double.inverse())
            w2 = rho2 - m.square()
            w, inverse = w2.root(), rho2.inverse()
            cos, sin = (q * m + h * w) * inverse, (h * m - q * w) * inverse
            radial, height = q - _by(cos, arm), h - _by(sin, arm)
            forearm = (radial.times(c) - t.times(s), radial.times(s) + t.times(c), height)
            elbow = (sin.times(-c), sin.times(-s), cos)
            chains.append((q, t, w2, w, forearm, elbow, cos, sin, arm.inverse()))
        found = zip(*chains, strict=True)
        self.q, self.t, self.w2, self.arm, self.forearm, self.elbow, self.cos, self.sin, self._scale = found
        off = Interval(np.array(-tolerance), np.array(tolerance))
        self.z, self.upper_arm, self.forearm_length = (z, la, lb) if tolerance == 0.0 else (z, la + off, lb + off)

    @cached_property
    def determinant(self) -> Slopes:
        """The determinant of the forearms, m^3."""
        return dot(self.forearm[0], cross(self.forearm[1], self.forearm[2]))

    @cached_property
    def faces(self) -> tuple[Slopes, ...]:
        """The squares |s_j x s_k|^2 of the other two forearms, by chain, m^4."""
        return tuple(norm2(cross(self.forearm[i - 2], self.forearm[i - 1])) for i in range(3))

    @cached_property
    def couples(self) -> tuple[Vector, ...]:
        """The couples t_i x s_i about the platform's centre, t_i the direction of the shoulder axis, README (47), m."""
        return tuple(
            (up.times(c), up.times(s), x.times(-c) - y.times(s))
            for (x, y, up), (c, s) in zip(self.forearm, self.azimuths, strict=True)
        )

    @cached_property
    def rows(self) -> tuple[Vector, ...]:
        """The rows n_i = s_i / w_i of the inverse Jacobian times L_A."""
        rows = []
        for forearm, arm in zip(self.forearm, self.arm, strict=True):
            inverse = arm.inverse()
            rows.append((forearm[0] * inverse, forearm[1] * inverse, forearm[2] * inverse))
        return tuple(rows)

    @cached_property
    def inverse_jacobian(self) -> tuple[Vector, ...]:
        """The rows s_i / (L_A w_i), README (11)."""
        return tuple(
            (_by(row[0], scale), _by(row[1], scale), _by(row[2], scale))
            for row, scale in zip(self.rows, self._scale, strict=True)
        )

    @cached_property
    def _gram_vectors(self) -> np.ndarray:
        """(n, 3, 3) eigenvectors of the inverse Jacobian's Gram matrix at the centres, ascending."""
        middle = np.array([[centre_of(v) for v in row] for row in self.inverse_jacobian])  # (chain, axis, n)
        return eigenvectors(np.einsum("ian,jan->nij", middle, middle))

    def _turned(self, k: int) -> Vector:
        """Column k of V^T applied to the inverse Jacobian's rows: a vector of slope forms."""
        w, rows = [exactly(self._gram_vectors[:, i, k]) for i in range(3)], self.inverse_jacobian
        x, y, z = (rows[0][a].times(w[0]) + rows[1][a].times(w[1]) + rows[2][a].times(w[2]) for a in range(3))
        return x, y, z

    def gram_quotients(self) -> tuple[Interval, Interval]:
        """Rayleigh's quotients of the Gram matrix at the centres, for its smallest and its largest eigenvector."""
        small, large = (
            norm2(self._turned(k)).centre * exactly(self._gram_vectors[:, :, k].T).square().total().inverse()
            for k in (0, 2)
        )
        return small, large

    def gram_within(self, square: Interval) -> np.ndarray:
        """Decides whether all eigenvalues of the Gram matrix A lie within [mu, square mu] for a linear function mu.

        A - mu and square mu - A are positive definite if V^T (.) V is, for whatever regular V.

        Args:
            square: Largest quotient of two eigenvalues, or one a box.

        Returns:
            (n,) truth.
        """
        turned, weights = [self._turned(k) for k in range(3)], products(self._gram_vectors)
        b = {(k, m): dot(turned[k], turned[m]) if k < m else norm2(turned[k]) for k, m in weights}
        share = 0.5 / square.hi
        centre = 0.5 * middle_of(b[0, 0].centre) + share * middle_of(b[2, 2].centre)
        slope = 0.5 * middle_of(b[0, 0].slope) + share * middle_of(b[2, 2].slope)
        step = self.z.step
        range_ = exactly(centre) + (exactly(slope) * step).total()
        mu = Slopes(exactly(centre), range_, exactly(slope), step)
        above = {key: (form - mu.times(weights[key])).box for key, form in b.items()}
        below = {key: (mu.times(weights[key] * square) - form).box for key, form in b.items()}
        return definite(above, (2, 1, 0)) & definite(below, (0, 1, 2))

    @staticmethod
    def rounded(x: float) -> Interval:
        """A number that was rounded once to x, at most 1 in size."""
        return exactly(x) + Interval(np.array(-(2.0**-53)), np.array(2.0**-53))


def _enclosing(x: Fraction) -> Interval:
    """Encloses a fraction: by itself where a double is, else by the doubles around it."""
    near = np.float64(float(x))
    return exactly(near) if Fraction(float(near)) == x else Interval(np.nextafter(near, DOWN), np.nextafter(near, UP))


def _by(a: Slopes, b: Slopes | Interval) -> Slopes:
    """The product with a form or with a number."""
    return a * b if isinstance(b, Slopes) else a.times(b)


def _plus(a: Slopes, b: Slopes | Interval) -> Slopes:
    """The sum with a form or with a number."""
    return a + b if isinstance(b, Slopes) else a.plus(b)


def cross(a: Vector, b: Vector) -> Vector:
    """Computes the cross product."""
    return (a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])


def dot(a: Vector, b: Vector) -> Slopes:
    """Computes the scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def norm2(a: Vector) -> Slopes:
    """Computes the squared length."""
    return a[0].square() + a[1].square() + a[2].square()


def middle_of(x: Interval) -> np.ndarray:
    """Computes the middle of intervals."""
    return 0.5 * (x.lo + x.hi)


def centre_of(x: Slopes) -> np.ndarray:
    """Computes the middle of a form at the boxes' centres."""
    return middle_of(x.centre)


def eigenvectors(matrices: np.ndarray) -> np.ndarray:
    """Computes eigenvectors (n, 3, 3) of symmetric matrices, ascending; any for one that is not finite."""
    finite = np.asarray(np.isfinite(matrices).all(axis=(1, 2), keepdims=True))
    return np.linalg.eigh(np.where(finite, matrices, np.eye(3)))[1]


def products(v: np.ndarray) -> dict[tuple[int, int], Interval]:
    """Computes the scalar products of the columns of matrices (n, 3, 3)."""
    return {(k, m): (exactly(v[:, :, k].T) * exactly(v[:, :, m].T)).total() for k in range(3) for m in range(k, 3)}


def congruent(m: Symmetric, v: np.ndarray) -> dict[tuple[int, int], Slopes]:
    """Computes V^T M V for symmetric matrices of forms and matrices V (n, 3, 3) of numbers."""

    def at(i: int, j: int) -> Slopes:
        return m[min(i, j), max(i, j)]

    column = [[exactly(v[:, i, k]) for i in range(3)] for k in range(3)]
    turned = [
        [at(i, 0).times(column[k][0]) + at(i, 1).times(column[k][1]) + at(i, 2).times(column[k][2]) for i in range(3)]
        for k in range(3)
    ]
    return {
        (k, l): turned[l][0].times(column[k][0]) + turned[l][1].times(column[k][1]) + turned[l][2].times(column[k][2])
        for k in range(3)
        for l in range(k, 3)  # noqa: E741
    }


def definite(m: Mapping[tuple[int, int], Interval], order: tuple[int, int, int]) -> np.ndarray:
    """Decides whether symmetric matrices are positive definite: Gauss's pivots in an order, the smallest last."""
    i, j, k = order

    def at(a: int, b: int) -> Interval:
        return m[min(a, b), max(a, b)]

    first = at(i, i).inverse()
    second = at(j, j) - at(i, j).square() * first
    mixed = at(j, k) - at(i, j) * at(i, k) * first
    third = at(k, k) - at(i, k).square() * first - mixed.square() * second.inverse()
    return (at(i, i).lo > 0.0) & (second.lo > 0.0) & (third.lo > 0.0)
