"""Affine forms over a box of up to four variables, compiled, with every rounding accounted for: README (28)-(30).

A form is six doubles (c, s1, s2, s3, s4, e) and stands for all values `c + s1 u1 + .. + s4 u4 + e d`, u in [-1, 1]^4
being the place in the box, shared by all forms over it, and d in [-1, 1] the form's own: it takes up what is not linear
and what is rounded away. Over a box of positions the fourth symbol is not used. An operation's result contains the
result of every choice of its arguments.
"""

from __future__ import annotations

import math

from delta_cad.common.jit import compiled

# A rounding is at most 2^-53 of its result. No operation here takes more than eight in a row to any of its numbers, so
# 2^-50 of the sum of all magnitudes bounds their sum; this is twice that.
ROUND = 2.0**-49
# Lifts an error term, a sum of at most 20 products of non-negative numbers, over its own roundings.
UP = 1.0 + 2.0**-48
TINY = 2.0**-960  # More than all that underflow can take from one operation.
SYMBOLS = 4
TERMS = SYMBOLS + 2  # Doubles of a form.
# m^2; least upper end of a range whose root is taken, far below what a rounding of any w^2 leaves.
FEASIBLE_ROOT_MIN = 1e-18


@compiled
def constant(value, error):
    """Gives any number within error of value."""
    return (value, 0.0, 0.0, 0.0, 0.0, error)


@compiled
def at(forms, i):
    """Takes a form out of a table of them, (n, 6)."""
    return (forms[i, 0], forms[i, 1], forms[i, 2], forms[i, 3], forms[i, 4], forms[i, 5])


@compiled
def put(forms, i, a):
    """Writes a form into a table of them, (n, 6)."""
    forms[i, 0], forms[i, 1], forms[i, 2] = a[0], a[1], a[2]
    forms[i, 3], forms[i, 4], forms[i, 5] = a[3], a[4], a[5]


@compiled
def slope(a):
    """Bounds half the width of the linear part from above."""
    return ((abs(a[1]) + abs(a[2])) + (abs(a[3]) + abs(a[4]))) * UP


@compiled
def lower(a):
    """Bounds a form from below."""
    r = slope(a) + a[5]
    return (a[0] - r) - ROUND * (abs(a[0]) + r)


@compiled
def upper(a):
    """Bounds a form from above."""
    r = slope(a) + a[5]
    return (a[0] + r) + ROUND * (abs(a[0]) + r)


@compiled
def magnitude(a):
    """Bounds the absolute value of a form."""
    return (abs(a[0]) + slope(a) + a[5]) * UP


@compiled
def add(a, b):
    """Adds two forms."""
    c, s1, s2, s3, s4 = a[0] + b[0], a[1] + b[1], a[2] + b[2], a[3] + b[3], a[4] + b[4]
    e = a[5] + b[5] + ROUND * (abs(c) + abs(s1) + abs(s2) + abs(s3) + abs(s4))
    return (c, s1, s2, s3, s4, e * UP)


@compiled
def negative(a):
    """Turns the sign of a form, without a rounding."""
    return (-a[0], -a[1], -a[2], -a[3], -a[4], a[5])


@compiled
def subtract(a, b):
    """Subtracts a form from another."""
    return add(a, negative(b))


@compiled
def scale(k, a):
    """Multiplies a form by a number that is exactly k."""
    c, s1, s2, s3, s4 = k * a[0], k * a[1], k * a[2], k * a[3], k * a[4]
    e = abs(k) * a[5] + ROUND * (abs(c) + abs(s1) + abs(s2) + abs(s3) + abs(s4)) + TINY
    return (c, s1, s2, s3, s4, e * UP)


@compiled
def multiply(a, b):
    """Multiplies two forms: u^2 lies in [0, 1], so half of each square's coefficient goes to the centre, README (29).

    Of the 25 products of (|c| + |s1| + ..) each is rounded at most 7 times on its way, so that 2^-49 of their sum
    covers the numbers and the cancelling pairs; e is a sum of 20 such products, within 2^-48 of its own roundings.
    """
    q1, q2, q3, q4 = 0.5 * (a[1] * b[1]), 0.5 * (a[2] * b[2]), 0.5 * (a[3] * b[3]), 0.5 * (a[4] * b[4])
    c = a[0] * b[0] + ((q1 + q2) + (q3 + q4))
    s1 = a[0] * b[1] + b[0] * a[1]
    s2 = a[0] * b[2] + b[0] * a[2]
    s3 = a[0] * b[3] + b[0] * a[3]
    s4 = a[0] * b[4] + b[0] * a[4]
    bent = ((abs(q1) + abs(q2)) + (abs(q3) + abs(q4))) + abs(a[1] * b[2] + a[2] * b[1])
    bent += abs(a[1] * b[3] + a[3] * b[1]) + abs(a[2] * b[3] + a[3] * b[2])
    bent += (abs(a[1] * b[4] + a[4] * b[1]) + abs(a[2] * b[4] + a[4] * b[2])) + abs(a[3] * b[4] + a[4] * b[3])
    ma, mb = abs(a[0]) + slope(a), abs(b[0]) + slope(b)
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
def _root(a, lo, hi):
    """The square root on [lo, hi]: sqrt(x) - k x is concave, 1/(4k) at its top for whatever k, smallest at an end."""
    rl, rh = math.sqrt(lo), math.sqrt(hi)
    k = 1.0 / (rl + rh)
    return _linear(a, k, min(rl - k * lo, rh - k * hi), 0.25 / k, ROUND * (rh + k * hi + 0.25 / k))


@compiled
def _inverse(a, lo, hi):
    """1 / a on [lo, hi]: 1/x + k x is convex, 2 sqrt(k) at its bottom for whatever k, largest at an end."""
    k = (1.0 / lo) / hi
    high = max(1.0 / lo + k * lo, 1.0 / hi + k * hi)
    return _linear(a, -k, 2.0 * math.sqrt(k), high, ROUND * (1.0 / lo + k * hi + high))


@compiled
def root(a):
    """Takes the square root; a form of NaN unless the argument has a positive lower bound, README (30)."""
    lo = lower(a)
    if not lo > 0.0:
        return (math.nan, 0.0, 0.0, 0.0, 0.0, math.inf)
    return _root(a, lo, upper(a))


@compiled
def root_where_feasible(a):
    """Takes the square root wherever the argument is not negative; elsewhere the form says nothing."""
    return _root(a, max(lower(a), 0.0), max(upper(a), FEASIBLE_ROOT_MIN))


@compiled
def inverse(a):
    """1 / a; a form of NaN unless the argument is bounded from below by a positive number, README (30)."""
    lo = lower(a)
    if not lo > 0.0:
        return (math.nan, 0.0, 0.0, 0.0, 0.0, math.inf)
    return _inverse(a, lo, upper(a))


@compiled
def inverse_above(a, least):
    """1 / a where a >= least > 0 is known beside the form."""
    lo = max(lower(a), least)
    return _inverse(a, lo, max(lo, upper(a)))
