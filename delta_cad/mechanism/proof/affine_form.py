"""Affine forms over a box, compiled, with every rounding accounted for: README (28)-(30).

A form is five doubles (c, x, y, z, e) and stands for all values c + x u + y v + z w + e d with u, v, w, d in [-1, 1]:
u, v, w are the box's own coordinates, shared by all forms over the box; d is the form's own and takes up what is not
linear and what is rounded away. An operation's result contains the result of every choice of its arguments.

Importing this module loads numba.
"""

from __future__ import annotations

import math

from delta_cad.common.jit import compiled

ROUND = 2.0**-49
"""A rounding is at most 2^-53 of its result. No operation here takes more than eight in a row to any of its numbers,
so 2^-50 of the sum of all magnitudes bounds their sum; this is twice that."""
UP = 1.0 + 2.0**-48
"""Lifts an error term, a sum of at most 14 products of non-negative numbers, over its own roundings."""
TINY = 2.0**-960
"""More than all that underflow can take from one operation."""


@compiled
def constant(value, error):
    """Any number within error of value."""
    return (value, 0.0, 0.0, 0.0, error)


@compiled
def slope(a):
    """Half the width of the linear part, rounded up."""
    return (abs(a[1]) + abs(a[2]) + abs(a[3])) * UP


@compiled
def lower(a):
    """A bound from below."""
    r = slope(a) + a[4]
    return (a[0] - r) - ROUND * (abs(a[0]) + r)


@compiled
def upper(a):
    """A bound from above."""
    r = slope(a) + a[4]
    return (a[0] + r) + ROUND * (abs(a[0]) + r)


@compiled
def magnitude(a):
    """A bound of the absolute value."""
    return (abs(a[0]) + slope(a) + a[4]) * UP


@compiled
def add(a, b):
    """The sum."""
    c, x, y, z = a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3]
    e = a[4] + b[4] + ROUND * (abs(c) + abs(x) + abs(y) + abs(z))
    return (c, x, y, z, e * UP)


@compiled
def subtract(a, b):
    """The difference."""
    return add(a, (-b[0], -b[1], -b[2], -b[3], b[4]))


@compiled
def scale(k, a):
    """The product with a number that is exactly k."""
    c, x, y, z = k * a[0], k * a[1], k * a[2], k * a[3]
    e = abs(k) * a[4] + ROUND * (abs(c) + abs(x) + abs(y) + abs(z)) + TINY
    return (c, x, y, z, e * UP)


@compiled
def multiply(a, b):
    """The product: u^2 lies in [0, 1], so half of each square's coefficient goes to the centre, README (29)."""
    ra, rb = slope(a), slope(b)
    xx, yy, zz = 0.5 * (a[1] * b[1]), 0.5 * (a[2] * b[2]), 0.5 * (a[3] * b[3])
    c = a[0] * b[0] + ((xx + yy) + zz)
    x = a[0] * b[1] + b[0] * a[1]
    y = a[0] * b[2] + b[0] * a[2]
    z = a[0] * b[3] + b[0] * a[3]
    bent = abs(xx) + abs(yy) + abs(zz) + abs(a[1] * b[2] + a[2] * b[1])
    bent += abs(a[1] * b[3] + a[3] * b[1]) + abs(a[2] * b[3] + a[3] * b[2])
    ma, mb = abs(a[0]) + ra, abs(b[0]) + rb
    e = bent + (ma * b[4] + mb * a[4] + a[4] * b[4]) + ROUND * (ma * mb) + TINY
    return (c, x, y, z, e * UP)


@compiled
def _linear(a, k, low, high, pad):
    """K a + g for a function g that lies in [low - pad, high + pad] over the range of a."""
    middle = 0.5 * (low + high)
    c = k * a[0] + middle
    x, y, z = k * a[1], k * a[2], k * a[3]
    e = abs(k) * a[4] + 0.5 * (high - low) + pad
    e += ROUND * (abs(k * a[0]) + abs(middle) + abs(x) + abs(y) + abs(z)) + TINY
    return (c, x, y, z, e * UP)


@compiled
def root(a):
    """The square root; a form of NaN unless the argument is bounded from below by a positive number, README (30)."""
    lo, hi = lower(a), upper(a)
    if not lo > 0.0:
        return (math.nan, 0.0, 0.0, 0.0, math.inf)
    rl, rh = math.sqrt(lo), math.sqrt(hi)
    k = 1.0 / (rl + rh)
    # sqrt(x) - k x is concave: 1/(4k) at its top for whatever k, smallest at an end
    return _linear(a, k, min(rl - k * lo, rh - k * hi), 0.25 / k, ROUND * (rh + k * hi + 0.25 / k))


@compiled
def inverse(a):
    """1 / a; a form of NaN unless the argument is bounded from below by a positive number, README (30)."""
    lo, hi = lower(a), upper(a)
    if not lo > 0.0:
        return (math.nan, 0.0, 0.0, 0.0, math.inf)
    k = (1.0 / lo) / hi
    # 1/x + k x is convex: 2 sqrt(k) at its bottom for whatever k, largest at an end
    high = max(1.0 / lo + k * lo, 1.0 / hi + k * hi)
    return _linear(a, -k, 2.0 * math.sqrt(k), high, ROUND * (1.0 / lo + k * hi + high))
