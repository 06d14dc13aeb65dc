"""The mechanism over a box as a table of affine forms: the ground of every limit's enclosure, README (31)-(32).

The table has a row for each quantity, named below; three rows, one a chain, for most. Over a box of positions `fill`
makes it; the optimizer makes the same table over boxes of designs, so that a limit reads either.
"""

from __future__ import annotations

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
    multiply,
    put,
    root,
    scale,
    subtract,
)
from delta_cad.mechanism.geometry import SIN_60, DeltaGeometry

# First of three rows, one a chain: radial coordinate of the wrist, the one along the shoulder axis (m), w^2 (m^2), w,
# the forearm along the chain's radius and along z (m), the scalar product of the two other forearms, q^2 + t^2 + z^2.
Q, T, W2, W, RADIAL, VERTICAL, PRODUCT, SQUARE = range(0, 24, 3)
FOREARM = 24  # First of nine rows, x, y, z a chain: the forearm in the base frame, m.
# Height of the wrists (m), det S (m^3), L_A, L_A^2, L_B and L_B^2.
Z, DETERMINANT, UPPER_ARM, UPPER_ARM_2, FOREARM_LENGTH, FOREARM_2 = range(33, 39)
ROWS = 39

# How much of the table a limit reads: q, t, z and the lengths; also the closed chains; all.
COORDINATES, CHAINS, FOREARMS = 0, 1, 2

SIN_60_ERROR = 2.0**-54  # half a last place of a double in [1/2, 1); both operations round to nearest

NUMBERS = 6  # of `lengths`


def lengths(g: DeltaGeometry) -> tuple[float, ...]:
    """Gives the numbers of a mechanism that `fill` takes, those that are rounded with a bound of their error.

    Args:
        g: The mechanism.

    Returns:
        R - r and its error, L_A, L_B, L_A^2 - L_B^2 and its error; m, m^2.
    """
    la, lb = g.upper_arm_length, g.forearm_length
    return (
        *(g.radius_difference, ROUND * (abs(g.base_radius) + abs(g.platform_radius))),
        *(la, lb),
        *((la - lb) * (la + lb), ROUND * (la + lb) ** 2),
    )


def table() -> np.ndarray:
    """Makes room for the forms of one box, (rows, 6)."""
    return np.empty((ROWS, TERMS))


@compiled
def fill_coordinates(box, k, pose):
    """Fills coordinates and lengths.

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
    a = constant(k[0], k[1])
    turn = constant(SIN_60, SIN_60_ERROR)
    xc, yc, xs, ys = scale(-0.5, x), scale(-0.5, y), multiply(turn, x), multiply(turn, y)
    put(pose, T, y)
    put(pose, T + 1, subtract(yc, xs))
    put(pose, T + 2, add(yc, xs))
    put(pose, Z, z)
    put(pose, Q, x)
    put(pose, Q + 1, add(xc, ys))
    put(pose, Q + 2, subtract(xc, ys))
    square = add(add(multiply(x, x), multiply(y, y)), multiply(z, z))
    for i in range(3):
        u = at(pose, Q + i)
        put(pose, SQUARE + i, add(square, multiply(a, subtract(a, scale(2.0, u)))))
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
    z, closed = at(pose, Z), True
    for i in range(3):
        q, t, square = at(pose, Q + i), at(pose, T + i), at(pose, SQUARE + i)
        rho2 = subtract(square, multiply(t, t))
        m = multiply(half, add(square, difference))
        w2 = subtract(rho2, multiply(m, m))
        w = root(w2)
        part = multiply(constant(la, 0.0), inverse(rho2))
        left = subtract(constant(1.0, 0.0), multiply(m, part))
        across = multiply(w, part)
        put(pose, W2 + i, w2)
        put(pose, W + i, w)
        put(pose, RADIAL + i, subtract(multiply(q, left), multiply(z, across)))
        put(pose, VERTICAL + i, add(multiply(z, left), multiply(q, across)))
        closed = closed and lower(w2) > 0.0
    return closed


@compiled
def fill_forearms(pose):
    """Fills the forearms in the base frame, their scalar products and their determinant."""
    turn = constant(SIN_60, SIN_60_ERROR)
    for i in range(3):
        r, t = at(pose, RADIAL + i), at(pose, T + i)
        x, y = r, t
        if i > 0:
            rc, rs, tc, ts = scale(-0.5, r), multiply(turn, r), scale(-0.5, t), multiply(turn, t)
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
