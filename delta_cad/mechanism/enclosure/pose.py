"""The mechanism over a box as a table of affine forms: the ground of every limit's enclosure, README (31)-(32).

The table has a row for each quantity, named below; three rows, one a chain, for most. Over a box of positions `fill`
makes it; the optimizer makes the same table over boxes of designs, so that a limit reads either.
"""

from __future__ import annotations

import math
from fractions import Fraction

import numpy as np

from delta_cad.common.jit import compiled
from delta_cad.mechanism.enclosure.affine_form import (
    ROUND,
    TERMS,
    add,
    at,
    constant,
    inverse,
    lower,
    magnitude,
    multiply,
    negative,
    put,
    root,
    scale,
    slope,
    subtract,
)
from delta_cad.mechanism.geometry import DeltaGeometry

# First of three rows, one a chain: radial coordinate of the wrist, the one along the shoulder axis (m), w^2 (m^2), w,
# the forearm along the chain's radius and along z (m), the scalar product of the two other forearms, q^2 + t^2 + z^2,
# the upper arm along the chain's radius and along z, L_A cos(theta) and L_A sin(theta) (m), and, where there is a
# tolerance, what it changes in s_i / (L_A w_i) at most (1 / m).
Q, T, W2, W, RADIAL, VERTICAL, PRODUCT, _SQUARE, ELBOW_RADIAL, ELBOW_VERTICAL, CHANGE = range(0, 33, 3)
FOREARM = 33  # First of nine rows, x, y, z a chain: the forearm in the base frame, m.
# Height of the wrists (m), det S (m^3), L_A, L_A^2, L_B and L_B^2; where there is a tolerance each form holds those of
# every chain.
Z, DETERMINANT, UPPER_ARM, UPPER_ARM_2, FOREARM_LENGTH, FOREARM_2 = range(42, 48)
# Cosine, sine and its square of the azimuth of chain 1; that of chain 2 mirrors it.
COSINE, SINE, SINE_2 = range(48, 51)
ROWS = 51

# How much of the table a limit reads: q, t, z and the lengths; also the closed chains; all.
COORDINATES, CHAINS, FOREARMS = 0, 1, 2

SIN_60_ERROR = 2.0**-54  # half a last place of a double in [1/2, 1); both operations round to nearest

TOLERANCE = 6  # place of it in `lengths`
_SIDE, _AZIMUTH, NUMBERS = 7, 9, 14  # in `lengths`: R_1 - r, what `azimuth_numbers` gives, and how many there are
_OFFSET = 2.0  # of the wrist against the shoulder in each direction, in tolerances: both ends are off by one
# Lifts a sum of some thirty products of non-negative numbers, with a root and quotients in it, over its roundings.
LIFT = 1.0 + 2.0**-40


def lengths(g: DeltaGeometry, tolerance: float = 0.0) -> tuple[float, ...]:
    """Gives the numbers of a mechanism that the table is filled from, rounded ones with a bound of their error.

    Args:
        g: The mechanism.
        tolerance: Of every length and offset of every chain, README (43), m.

    Returns:
        R_0 - r and its error, L_A, L_B, L_A^2 - L_B^2 and its error, the tolerance, R_1 - r and its error; m, m^2; and
        `azimuth_numbers`.
    """
    la, lb, (first, side, _) = g.upper_arm_length, g.forearm_length, g.radius_differences.tolist()
    return (
        *(first, ROUND * (abs(g.base_radius) + abs(g.platform_radius))),
        *(la, lb),
        *((la - lb) * (la + lb), ROUND * (la + lb) ** 2),
        tolerance,
        *(side, ROUND * (abs(g.base_radius) + abs(g.side_shift) + abs(g.platform_radius))),
        *azimuth_numbers(g.side_cosine),
    )


def azimuth_numbers(cosine: float) -> tuple[float, ...]:
    """Gives the numbers of an azimuth, whose cosine is exactly the one given.

    With u = 2^-53 each of 1 - c, 1 + c and their product is rounded by at most u of itself, so that the square of the
    sine is off by at most (1 + u)^3 - 1 < 3.1 u of itself, and its root by half of that and its own u: 2.6 u. Neither
    is more than 1. Where the square is exact, as at 120 degrees, the root of a number in [1/4, 1) is off by the half of
    a last place of a double in [1/2, 1).

    Args:
        cosine: Of the azimuth of chain 1.

    Returns:
        Cosine, sine and its error, the square of the sine and its error.
    """
    square = (1.0 - cosine) * (1.0 + cosine)
    exact = Fraction(square) == 1 - Fraction(cosine) ** 2
    near, error = (SIN_60_ERROR, 0.0) if exact else (3.0 * 2.0**-53, 4.0 * 2.0**-53)
    return cosine, math.sqrt(square), near, square, error


def table() -> np.ndarray:
    """Makes room for the forms of one box, and once more for those of the drawn machine alone, (2 rows, 6)."""
    return np.empty((2 * ROWS, TERMS))


@compiled
def put_azimuth(pose, cosine, sine, square):
    """Fills cosine, sine and its square of the azimuth of chain 1, each a form."""
    put(pose, COSINE, cosine)
    put(pose, SINE, sine)
    put(pose, SINE_2, square)


@compiled
def times(pose, row, a):
    """Multiplies a form by that of a row, which may be a number that is exact."""
    if pose[row, TERMS - 1] == 0.0 and slope(at(pose, row)) == 0.0:
        return scale(pose[row, 0], a)
    return multiply(at(pose, row), a)


@compiled
def put_wrists(pose, x, y, z):
    """Fills the coordinates, from which R_i - r is still to be taken off along the radii; reads the azimuth."""
    xc, yc, xs, ys = times(pose, COSINE, x), times(pose, COSINE, y), times(pose, SINE, x), times(pose, SINE, y)
    put(pose, T, y)
    put(pose, T + 1, subtract(yc, xs))
    put(pose, T + 2, add(yc, xs))
    put(pose, Z, z)
    put(pose, Q, x)
    put(pose, Q + 1, add(xc, ys))
    put(pose, Q + 2, subtract(xc, ys))


@compiled
def put_chain(pose, i, m, w2, w, part):
    """Fills a closed chain; part is L_A / rho^2."""
    q, z = at(pose, Q + i), at(pose, Z)
    left = subtract(constant(1.0, 0.0), multiply(m, part))
    across = multiply(w, part)
    put(pose, W2 + i, w2)
    put(pose, W + i, w)
    put(pose, RADIAL + i, subtract(multiply(q, left), multiply(z, across)))
    put(pose, VERTICAL + i, add(multiply(z, left), multiply(q, across)))
    put(pose, ELBOW_RADIAL + i, subtract(q, at(pose, RADIAL + i)))
    put(pose, ELBOW_VERTICAL + i, subtract(z, at(pose, VERTICAL + i)))


@compiled
def fill_coordinates(box, k, pose):
    """Fills azimuth, coordinates and lengths.

    Args:
        box: (7,) centre (3), half sides (3), and a bound of the error of both, m; a point has four zeros.
        k: `lengths`.
        pose: `table`.
    """
    x, y, z = (
        (box[0], box[3], 0.0, 0.0, 0.0, box[6]),
        (box[1], 0.0, box[4], 0.0, 0.0, box[6]),
        (box[2], 0.0, 0.0, box[5], 0.0, box[6]),
    )
    n = _AZIMUTH
    put_azimuth(pose, constant(k[n], 0.0), constant(k[n + 1], k[n + 2]), constant(k[n + 3], k[n + 4]))
    put_wrists(pose, x, y, z)
    square = add(add(multiply(x, x), multiply(y, y)), multiply(z, z))
    for i in range(3):
        u, a = at(pose, Q + i), constant(k[0], k[1]) if i == 0 else constant(k[_SIDE], k[_SIDE + 1])
        put(pose, _SQUARE + i, add(square, multiply(a, subtract(a, scale(2.0, u)))))
        put(pose, Q + i, subtract(u, a))
    la, lb = constant(k[2], 0.0), constant(k[3], 0.0)
    put(pose, UPPER_ARM, la)
    put(pose, UPPER_ARM_2, multiply(la, la))
    put(pose, FOREARM_LENGTH, lb)
    put(pose, FOREARM_2, multiply(lb, lb))


@compiled
def fill_chains(k, pose):
    """Fills the closed chains, README (2), (3), (32); whether all of them are closed in the whole box."""
    la = k[2]
    half, difference = constant(0.5 / la, ROUND / la), constant(k[4], k[5])
    closed = True
    for i in range(3):
        t, square = at(pose, T + i), at(pose, _SQUARE + i)
        rho2 = subtract(square, multiply(t, t))
        m = multiply(half, add(square, difference))
        w2 = subtract(rho2, multiply(m, m))
        put_chain(pose, i, m, w2, root(w2), multiply(constant(la, 0.0), inverse(rho2)))
        closed = closed and lower(w2) > 0.0
    return closed


@compiled
def _widen(pose, row, error):
    """Adds to a form's own error."""
    pose[row, TERMS - 1] = (pose[row, TERMS - 1] + error) * LIFT


@compiled
def widen_coordinates(k, pose):
    """Widens coordinates and lengths by what the tolerance can change."""
    d = k[TOLERANCE]
    for i in range(3):
        _widen(pose, Q + i, _OFFSET * d)
        _widen(pose, T + i, _OFFSET * d)
    _widen(pose, Z, _OFFSET * d)
    la, lb = constant(k[2], d), constant(k[3], d)
    put(pose, UPPER_ARM, la)
    put(pose, UPPER_ARM_2, multiply(la, la))
    put(pose, FOREARM_LENGTH, lb)
    put(pose, FOREARM_2, multiply(lb, lb))


@compiled
def _change(o, d, la, lb, a, m, t, w):
    """How far a row s / (L_A w) of the inverse Jacobian can be from that of the drawn machine, README (45).

    Args:
        o: Most that the wrist is off in each direction.
        d: Most that a length is off.
        la: L_A at least; of all that follows the most, of w the least.
        lb: L_B.
        a: Forearm along the upper arm.
        m: Wrist along the upper arm.
        t: Wrist along the shoulder axis.
        w: Elbow arm.
    """
    side = max(lb * lb - w * w, 0.0)  # square of the forearm's part across the elbow's motion
    bend = m * m * side / (w * w) + a * a
    turn = 1.0 / (la * w)
    plane = 1.0 + a * a * turn * (2.0 * m / w + bend * turn)
    across = math.sqrt(1.0 + t * t * turn * (2.0 * m / w + bend * turn))
    flat = math.sqrt(2.0 * (plane + (a * lb * turn) ** 2))
    return (o * (flat + across) + d * (math.sqrt(plane) + lb / la + lb * turn * math.sqrt(bend))) * turn * LIFT


@compiled
def widen_chains(k, pose):
    """Widens the closed chains by what the tolerance can change, README (44); whether all of them still are closed.

    The forms of the drawn machine are changed by no more than each derivative's bound over the box and over all chains
    within the tolerance, times the change of its length.
    """
    d, la, lb = k[TOLERANCE], k[2], k[3]
    half, difference = constant(0.5 / la, ROUND / la), constant(k[4], k[5])
    o, short, longest, closed = _OFFSET * d, (la - d) / LIFT, (lb + d) * LIFT, True
    z = magnitude(at(pose, Z)) + o
    for i in range(3):
        q, t = magnitude(at(pose, Q + i)) + o, magnitude(at(pose, T + i)) + o
        middle = multiply(half, add(at(pose, _SQUARE + i), difference))
        left = subtract(constant(1.0, 0.0), scale(2.0, multiply(half, middle)))
        m = magnitude(middle)
        change = (2.0 * o * (q + t + z) + 2.0 * d * (la + lb + d)) / (2.0 * short) + m * d / short
        f = magnitude(left) + change / short + m * d / (la * short)
        m += change
        part = 2.0 * o * (f * (q + z) + m * t / short) + 2.0 * d * m * (f + longest / short)
        _widen(pose, W2 + i, part)
        least = lower(at(pose, W2 + i))
        if not least > 0.0:
            closed = False
            continue
        w = math.sqrt(least) / LIFT
        _widen(pose, W + i, part / (2.0 * w))
        crude = (3.0 * o + 2.0 * d) * longest / w  # sine, cosine <= 1 and the forearm's parts <= its length
        r, v = magnitude(at(pose, RADIAL + i)) + crude, magnitude(at(pose, VERTICAL + i)) + crude
        cos = min((magnitude(at(pose, ELBOW_RADIAL + i)) + crude) / short, 1.0)
        sin = min((magnitude(at(pose, ELBOW_VERTICAL + i)) + crude) / short, 1.0)
        by_sine, by_cosine = d * (v + sin * longest), d * (r + cos * longest)
        _widen(pose, RADIAL + i, (o * ((cos + sin) * v + sin * t) + by_sine) / w)
        _widen(pose, VERTICAL + i, (o * ((cos + sin) * r + cos * t) + by_cosine) / w)
        _widen(pose, ELBOW_RADIAL + i, (o * sin * (r + t + v) + by_sine) / w)
        _widen(pose, ELBOW_VERTICAL + i, (o * cos * (r + t + v) + by_cosine) / w)
        put(pose, CHANGE + i, constant(0.0, _change(o, d, short, longest, f * (la + d), m, t, w)))
    return closed


@compiled
def along_radius(pose, i, radial):
    """Turns a form along a chain's radius into the base frame: its parts along x and y."""
    if i == 0:
        return radial, constant(0.0, 0.0)
    x, y = times(pose, COSINE, radial), times(pose, SINE, radial)
    return (x, y) if i == 1 else (x, negative(y))


@compiled
def fill_forearms(pose):
    """Fills the forearms in the base frame, their scalar products and their determinant; reads the azimuth."""
    for i in range(3):
        r, t = at(pose, RADIAL + i), at(pose, T + i)
        x, y = r, t
        if i > 0:
            rc, rs, tc, ts = times(pose, COSINE, r), times(pose, SINE, r), times(pose, COSINE, t), times(pose, SINE, t)
            x, y = (subtract(rc, ts), add(rs, tc)) if i == 1 else (add(rc, ts), subtract(tc, rs))
        put(pose, FOREARM + 3 * i, x)
        put(pose, FOREARM + 3 * i + 1, y)
        put(pose, FOREARM + 3 * i + 2, at(pose, VERTICAL + i))
    put(pose, PRODUCT + 2, scalar(pose, 0, 1))
    put(pose, PRODUCT + 1, scalar(pose, 0, 2))
    put(pose, PRODUCT, scalar(pose, 1, 2))
    total = at(pose, FOREARM)
    for axis in range(3):
        j, k = (axis + 1) % 3, (axis + 2) % 3
        minor = subtract(
            multiply(at(pose, FOREARM + 3 + j), at(pose, FOREARM + 6 + k)),
            multiply(at(pose, FOREARM + 3 + k), at(pose, FOREARM + 6 + j)),
        )
        part = multiply(at(pose, FOREARM + axis), minor)
        total = part if axis == 0 else add(total, part)
    put(pose, DETERMINANT, total)


@compiled
def scalar(pose, i, j):
    """Computes the scalar product of two forearms."""
    a, b = FOREARM + 3 * i, FOREARM + 3 * j
    x = multiply(at(pose, a), at(pose, b))
    y = multiply(at(pose, a + 1), at(pose, b + 1))
    return add(add(x, y), multiply(at(pose, a + 2), at(pose, b + 2)))
