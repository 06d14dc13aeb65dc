"""Formulas of one position in plain doubles, compiled into their callers: searches and the simulation.

Kappa is taken from the three invariants of the Gram matrix, each a sum of squares, so that no digit is lost near a
singularity, and from a discriminant that is a sum of squares too, so that none is lost on the cube's axis, where two
eigenvalues meet: README (23)-(26).
"""

from __future__ import annotations

import math

import numpy as np

from delta_cad.common.jit import inlined
from delta_cad.mechanism.geometry import SIN_60

_ROOT_3 = float(np.sqrt(3.0))
_C = tuple(
    np.polynomial.Chebyshev.interpolate(lambda c: np.cos(np.arccos(np.clip(c, -1.0, 1.0)) / 3.0), 7, [0.0, 1.0])
    .convert(kind=np.polynomial.Polynomial)
    .coef.tolist()
)
"""cos(acos(c) / 3) on [0, 1] to 2e-8, so that one Newton step ends in the last digit."""
_SEPARATED = 0.01
"""(l2 - l3)^2 / (l2 + l3)^2 above which the quadratic's discriminant keeps all but two digits; below it the sum of
squares takes over, whose error is a rounding of the largest eigenvalue."""


@inlined
def azimuth(i, c, s):
    """Gives cosine and sine of a chain's azimuth; c and s are those of chain 1."""
    return (1.0, 0.0) if i == 0 else ((c, s) if i == 1 else (c, -s))


@inlined
def wrist(x, y, a, c, s):
    """Computes a wrist's q and t, README (1); a is R_i - r, c and s are cosine and sine of the chain's azimuth."""
    return c * x + s * y - a, c * y - s * x


@inlined
def chain_closure(q, t, z, la, lb):
    """Closes a chain in its own plane: rho^2, m and w^2, README (2), (3); negative where it cannot be closed."""
    rho2 = q * q + z * z
    m = (rho2 + t * t + la * la - lb * lb) / (2.0 * la)
    return rho2, m, rho2 - m * m


@inlined
def arm(q, z, rho2, m, w):
    """Computes cosine and sine of the shoulder angle, elbows outwards, README (5)."""
    return (q * m + z * w) / rho2, (z * m - q * w) / rho2


@inlined
def in_base(radial, along, c, s):
    """Turns a vector along a chain's radius and shoulder axis into the base frame: its parts along x and y.

    c and s are cosine and sine of the chain's azimuth.
    """
    return c * radial - s * along, s * radial + c * along


@inlined
def add_inertia(m, turning, cross, n, e):
    """Adds a chain's part of the handle's inertia, README (39).

    Args:
        m: 11, 22, 33, 12, 13, 23 so far, kg.
        turning: What goes with `n n^T`.
        cross: What goes with `n e^T + e n^T`.
        n: Row of the inverse Jacobian, in the unit that the two above ask for.
        e: Direction in which the elbow moves.
    """
    (nx, ny, nz), (ex, ey, ez) = n, e
    return (
        m[0] + (2.0 * cross * ex * nx + turning * nx * nx),
        m[1] + (2.0 * cross * ey * ny + turning * ny * ny),
        m[2] + (2.0 * cross * ez * nz + turning * nz * nz),
        m[3] + (cross * (ex * ny + nx * ey) + turning * nx * ny),
        m[4] + (cross * (ex * nz + nx * ez) + turning * nx * nz),
        m[5] + (cross * (ey * nz + ny * ez) + turning * ny * nz),
    )


@inlined
def largest_eigenvalue(a11, a22, a33, a12, a13, a23):
    """Computes the largest eigenvalue of a symmetric matrix and the difference of the others, README (25), (26)."""
    # deviator B, its determinant, and B^2 less its mean
    mean = (a11 + a22 + a33) / 3.0
    b11, b22, b33 = a11 - mean, a22 - mean, a33 - mean
    s12, s13, s23 = a12 * a12, a13 * a13, a23 * a23
    p2 = (b11 * b11 + b22 * b22 + b33 * b33 + 2.0 * (s12 + s13 + s23)) / 6.0
    cos3 = 0.5 * (b11 * (b22 * b33 - s23) - s12 * b33 + 2.0 * a12 * a13 * a23 - s13 * b22)
    u1, u2 = 0.5 * (b11 - b22), SIN_60 * b33
    c11, c22, c33 = b11 * b11 + s12 + s13, b22 * b22 + s12 + s23, b33 * b33 + s13 + s23 - 2.0 * p2
    d1, d2 = 0.5 * (c11 - c22), SIN_60 * c33
    c12 = a13 * a23 - a12 * b33
    c13 = a12 * a23 - a13 * b22
    c23 = a12 * a13 - a23 * b11
    square = (u1 * d2 - u2 * d1) ** 2 + (u1 * c12 - a12 * d1) ** 2 + (u1 * c13 - a13 * d1) ** 2
    square += (u1 * c23 - a23 * d1) ** 2 + (u2 * c12 - a12 * d2) ** 2 + (u2 * c13 - a13 * d2) ** 2
    square += (u2 * c23 - a23 * d2) ** 2 + (a12 * c13 - a13 * c12) ** 2 + (a12 * c23 - a23 * c12) ** 2
    square += (a13 * c23 - a23 * c13) ** 2
    sin3 = math.sqrt(square) / 3.0
    size = math.sqrt(cos3 * cos3 + square / 9.0)  # p^3
    invert = 1.0 / (size if size > 0.0 else 1.0)
    c, s = abs(cos3) * invert, sin3 * invert
    x = _C[0] + c * (_C[1] + c * (_C[2] + c * (_C[3] + c * (_C[4] + c * (_C[5] + c * (_C[6] + c * _C[7]))))))
    x -= (x * (4.0 * x * x - 3.0) - c) / (12.0 * x * x - 3.0)
    y = _ROOT_3 * s / (4.0 * x * x - 1.0)
    p = math.sqrt(p2)
    top_alone = cos3 >= 0.0
    return mean + p * (2.0 * x if top_alone else x + y), p * (2.0 * y if top_alone else 3.0 * x - y)


@inlined
def kappa(w1, w2, w3, g12, g13, g23, n1, n2, n3, det, lb2):
    """Condition number from the forearms' products, README (23)-(26).

    w1, w2, w3 are the elbow arms (m); g12, g13, g23 the scalar products of the forearms (m^2); n1, n2, n3 the squares
    |s_2 x s_3|^2 and so on (m^4); det is det S (m^3); lb2 is L_B^2 (m^2).
    """
    v1, v2, v3 = w2 * w3, w1 * w3, w1 * w2
    i2 = n3 * (v1 * v2) ** 2 + n2 * (v1 * v3) ** 2 + n1 * (v2 * v3) ** 2
    i3 = (det * v1 * v2 * v3) ** 2
    largest, difference = largest_eigenvalue(
        lb2 * v1 * v1, lb2 * v2 * v2, lb2 * v3 * v3, g12 * v1 * v2, g13 * v1 * v3, g23 * v2 * v3
    )
    product = i3 / largest
    total = (i2 - product) / largest
    square = total * total - 4.0 * product
    split = math.sqrt(square) if square > _SEPARATED * total * total else difference
    kappa = math.sqrt(0.5 * largest * (total + split) / product)
    return math.inf if i3 == 0.0 else kappa
