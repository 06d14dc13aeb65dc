"""Affine forms over a box of designs, compiled, with every rounding accounted for.

As in `delta_cad.mechanism.proof`, with four symbols instead of three: a form (c, s1, s2, s3, s4, e) is all values
`c + s1 u1 + .. + s4 u4 + e d`, u in [-1, 1]^4 being the place of the design in its box (L_A, L_B, a = R - r, H), shared
by all forms, and d in [-1, 1] the form's own. An operation's result contains the result of every choice of arguments.

Importing this module loads numba.
"""

from __future__ import annotations

import math

from delta_cad.common.jit import compiled
from delta_cad.mechanism.proof.affine_form import ROUND, TINY, UP

FEASIBLE_ROOT_MIN = 1e-18
"""m^2; least upper end of a range whose root is taken, far below what a rounding of any w^2 leaves."""


@compiled
def constant(value, error):
    """Any number within error of value."""
    return (value, 0.0, 0.0, 0.0, 0.0, error)


@compiled
def slope(a):
    """Half the width of the linear part, rounded up."""
    return ((abs(a[1]) + abs(a[2])) + (abs(a[3]) + abs(a[4]))) * UP


@compiled
def lower(a):
    """A bound from below."""
    r = slope(a) + a[5]
    return (a[0] - r) - ROUND * (abs(a[0]) + r)


@compiled
def upper(a):
    """A bound from above."""
    r = slope(a) + a[5]
    return (a[0] + r) + ROUND * (abs(a[0]) + r)


@compiled
def magnitude(a):
    """A bound of the absolute value."""
    return (abs(a[0]) + slope(a) + a[5]) * UP


@compiled
def add(a, b):
    """The sum."""
    c, s1, s2, s3, s4 = a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3], a[4] + b[4]
    e = a[5] + b[5] + ROUND * (abs(c) + abs(s1) + abs(s2) + abs(s3) + abs(s4))
    return (c, s1, s2, s3, s4, e * UP)


@compiled
def subtract(a, b):
    """The difference."""
    return add(a, (-b[0], -b[1], -b[2], -b[3], -b[4], b[5]))


@compiled
def scale(k, a):
    """The product with a number that is exactly k."""
    c, s1, s2, s3, s4 = k * a[0], k * a[1], k * a[2], k * a[3], k * a[4]
    e = abs(k) * a[5] + ROUND * (abs(c) + abs(s1) + abs(s2) + abs(s3) + abs(s4)) + TINY
    return (c, s1, s2, s3, s4, e * UP)


@compiled
def multiply(a, b):
    """The product: u^2 lies in [0, 1], so half of each square's coefficient goes to the centre.

    Of the 25 products of (|c| + |s1| + ..) each is rounded at most 7 times on its way, so that 2^-49 of their sum
    covers the numbers and the cancelling pairs; e is a sum of 20 such products, within 2^-48 of its own roundings.
    """
    ra, rb = slope(a), slope(b)
    q1, q2, q3, q4 = 0.5 * (a[1] * b[1]), 0.5 * (a[2] * b[2]), 0.5 * (a[3] * b[3]), 0.5 * (a[4] * b[4])
    c = a[0] * b[0] + ((q1 + q2) + (q3 + q4))
    s1 = a[0] * b[1] + b[0] * a[1]
    s2 = a[0] * b[2] + b[0] * a[2]
    s3 = a[0] * b[3] + b[0] * a[3]
    s4 = a[0] * b[4] + b[0] * a[4]
    bent = (abs(q1) + abs(q2)) + (abs(q3) + abs(q4))
    bent += (abs(a[1] * b[2] + a[2] * b[1]) + abs(a[1] * b[3] + a[3] * b[1])) + abs(a[1] * b[4] + a[4] * b[1])
    bent += (abs(a[2] * b[3] + a[3] * b[2]) + abs(a[2] * b[4] + a[4] * b[2])) + abs(a[3] * b[4] + a[4] * b[3])
    ma, mb = abs(a[0]) + ra, abs(b[0]) + rb
    e = bent + (ma * b[5] + mb * a[5] + a[5] * b[5]) + ROUND * (ma * mb) + TINY
    return (c, s1, s2, s3, s4, e * UP)


@compiled
def _linear(a, k, low, high, pad):
    """K a + g for a function g that lies in [low - pad, high + pad] over the range of a."""
    middle = 0.5 * (low + high)
    c = k * a[0] + middle
    s1, s2, s3, s4 = k * a[1], k * a[2], k * a[3], k * a[4]
    e = abs(k) * a[5] + 0.5 * (high - low) + pad
    e += ROUND * (abs(k * a[0]) + abs(middle) + abs(s1) + abs(s2) + abs(s3) + abs(s4)) + TINY
    return (c, s1, s2, s3, s4, e * UP)


@compiled
def root(a):
    """The square root wherever the argument is not negative; what holds elsewhere is not said.

    On [lo, hi], lo >= 0, `sqrt(x) - k x` is concave: at most 1 / (4 k) for whatever k > 0, smallest at an end.
    """
    lo, hi = max(lower(a), 0.0), max(upper(a), FEASIBLE_ROOT_MIN)
    rl, rh = math.sqrt(lo), math.sqrt(hi)
    k = 1.0 / (rl + rh)
    return _linear(a, k, min(rl - k * lo, rh - k * hi), 0.25 / k, ROUND * (rh + k * hi + 0.25 / k))


@compiled
def inverse(a, least):
    """1 / a where a >= least > 0 is known beside the form; `1/x + k x` is convex, 2 sqrt(k) at its bottom."""
    lo, hi = max(lower(a), least), upper(a)
    hi = max(lo, hi)
    k = (1.0 / lo) / hi
    high = max(1.0 / lo + k * lo, 1.0 / hi + k * hi)
    return _linear(a, -k, 2.0 * math.sqrt(k), high, ROUND * (1.0 / lo + k * hi + high))
