"""Interval arithmetic on arrays and slopes over boxes: the arithmetic in which certificates are replayed.

It shares no code with the prover's affine forms. NumPy's +, -, *, / and square root are correctly rounded; each result
is moved outwards by one double. A slope form knows a function at a box's centre, over the box, and a slope a variable
with `f(p) - f(centre) = S . (p - centre)` for every p of the box (Krawczyk and Neumaier). The variables are the three
coordinates, and with a tolerance the deviations of every chain.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

UNIT = 2.0**-53 * (1.0 + 2.0**-52)  # relative error of rounding, and one double more
LEAST = 2.0**-1074  # least double above 0
_MANY = 400  # numbers from which on sums are faster than calls of nextafter
DOWN, UP = np.array(-np.inf), np.array(np.inf)  # as arrays: not made again for each call


@dataclass(slots=True)  # not frozen: made by the million, which takes three times as long frozen
class Interval:
    """Numbers between lo and hi, elementwise; NaN where nothing is known.

    Attributes:
        lo: Any shape.
        hi: The same shape.
    """

    lo: np.ndarray
    hi: np.ndarray

    def __add__(self, other: Interval) -> Interval:
        return _outward(self.lo + other.lo, self.hi + other.hi)

    def __sub__(self, other: Interval) -> Interval:
        return _outward(self.lo - other.hi, self.hi - other.lo)

    def __neg__(self) -> Interval:
        return Interval(-self.hi, -self.lo)

    def __mul__(self, other: Interval) -> Interval:
        low, high, least, most = self.lo, self.hi, other.lo, other.hi
        a, b, c, d = low * least, low * most, high * least, high * most
        return _outward(np.minimum(np.minimum(a, b), np.minimum(c, d)), np.maximum(np.maximum(a, b), np.maximum(c, d)))

    def inverse(self) -> Interval:
        """1 / x; NaN unless x is positive throughout."""
        good = self.lo > 0.0
        return _outward(1.0 / np.where(good, self.hi, np.nan), 1.0 / np.where(good, self.lo, np.nan))

    def root(self) -> Interval:
        """Square root; NaN unless x is positive throughout."""
        good = self.lo > 0.0
        return _outward(np.sqrt(np.where(good, self.lo, np.nan)), np.sqrt(np.where(good, self.hi, np.nan)))

    def square(self) -> Interval:
        """x^2, which is not x times another x."""
        a, b = self.lo * self.lo, self.hi * self.hi
        least = np.where((self.lo <= 0.0) & (self.hi >= 0.0), 0.0, np.minimum(a, b))
        return _outward(least, np.maximum(a, b))

    def within(self, other: Interval) -> Interval:
        """Intersection of two enclosures of the same number; NaN of one of them stays."""
        return Interval(np.maximum(self.lo, other.lo), np.minimum(self.hi, other.hi))

    def total(self) -> Interval:
        """Sum along the first axis."""
        found = self[0]
        for i in range(1, len(self.lo)):
            found = found + self[i]
        return found

    def __getitem__(self, i: int) -> Interval:
        return Interval(self.lo[i], self.hi[i])


def _outward(lo: np.ndarray, hi: np.ndarray) -> Interval:
    """Moves both ends outwards to the next double, or, where they are below 1e-307, by two at most.

    Of many numbers at once the processor makes several sums at a time, but calls `nextafter` for each.

    Source: Rump, Zimmermann, Boldo, Melquiond, Computing predecessor and successor in rounding to nearest, BIT 49
        (2009), algorithm 1.
    """
    if lo.size < _MANY:
        return Interval(np.nextafter(lo, DOWN), np.nextafter(hi, UP))
    return Interval(lo - (np.abs(lo) * UNIT + LEAST), hi + (np.abs(hi) * UNIT + LEAST))


def exactly(x: float | np.ndarray) -> Interval:
    """Encloses doubles by themselves."""
    x = np.asarray(x, dtype=float)
    return Interval(x, x)


@dataclass(slots=True)
class Slopes:
    """A function of m variables over n boxes.

    Attributes:
        centre: (n,) its value at the centres.
        box: (n,) its values over the boxes.
        slope: (m, n) its slopes between the centre and any point of the box.
        step: (m, n) the point less the centre, over the box.
    """

    centre: Interval
    box: Interval
    slope: Interval
    step: Interval

    def _narrowed(self, centre: Interval, box: Interval, slope: Interval) -> Slopes:
        """The form with its range cut down to what centre and slopes allow."""
        return Slopes(centre, box.within(centre + (slope * self.step).total()), slope, self.step)

    def __add__(self, other: Slopes) -> Slopes:
        return self._narrowed(self.centre + other.centre, self.box + other.box, self.slope + other.slope)

    def __sub__(self, other: Slopes) -> Slopes:
        return self._narrowed(self.centre - other.centre, self.box - other.box, self.slope - other.slope)

    def __mul__(self, other: Slopes) -> Slopes:
        # f g - f0 g0 = (f - f0) g + f0 (g - g0)
        slope = self.slope * other.box + self.centre * other.slope
        return self._narrowed(self.centre * other.centre, self.box * other.box, slope)

    def square(self) -> Slopes:
        """The square: f^2 - f0^2 = (f - f0)(f + f0)."""
        slope = self.slope * (self.box + self.centre)
        return self._narrowed(self.centre.square(), self.box.square(), slope)

    def times(self, k: Interval) -> Slopes:
        """The product with a number, or one number a box."""
        return Slopes(self.centre * k, self.box * k, self.slope * k, self.step)

    def plus(self, k: Interval) -> Slopes:
        """The sum with a number."""
        return Slopes(self.centre + k, self.box + k, self.slope, self.step)

    def root(self) -> Slopes:
        """Square root: the difference of the roots is that of the squares by their sum."""
        centre, box = self.centre.root(), self.box.root()
        return self._narrowed(centre, box, self.slope * (centre + box).inverse())

    def inverse(self) -> Slopes:
        """1 / f: 1/f - 1/f0 = -(f - f0) / (f f0)."""
        centre, box = self.centre.inverse(), self.box.inverse()
        return self._narrowed(centre, box, -(self.slope * (centre * box)))


def variables(lower: np.ndarray, upper: np.ndarray) -> list[Slopes]:
    """Makes the variables themselves over boxes.

    Args:
        lower: (n, m) lower corners.
        upper: (n, m) upper corners.

    Returns:
        One form for each of the m variables.
    """
    centre = np.clip(0.5 * (lower + upper), lower, upper)
    step = Interval(lower.T, upper.T) - exactly(centre.T)
    out = []
    for i in range(lower.shape[1]):
        unit = np.zeros_like(centre.T)
        unit[i] = 1.0
        out.append(Slopes(exactly(centre[:, i]), Interval(lower[:, i], upper[:, i]), exactly(unit), step))
    return out
