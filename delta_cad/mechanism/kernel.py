"""Reach, torque and conditioning of many positions at once, compiled; what a search calls millions of times.

The formulas are those of README (1)-(7), (12)-(16); kappa is taken from the three invariants of the Gram matrix, each
a sum of squares, so that no digit is lost near a singularity, and from a discriminant that is a sum of squares too, so
that none is lost on the cube's axis, where two eigenvalues meet: README (23)-(26).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from delta_cad.common.jit import compiled, inlined
from delta_cad.mechanism.geometry import SIN_60, DeltaGeometry, positions

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


class PositionFigures(NamedTuple):
    """Figures of merit of n positions.

    Attributes:
        closure_margin: (n,) smallest w^2 of the three chains, m^2; negative where one cannot be closed.
        torque_arms: (n, 3 chains) worst torque over all directions of a unit force, m; infinite where det S = 0.
        kappa: (n,) condition number of the Jacobian; infinite at both singularities.
    """

    closure_margin: np.ndarray
    torque_arms: np.ndarray
    kappa: np.ndarray


def figures(g: DeltaGeometry, p: ArrayLike) -> PositionFigures:
    """Reach, torque and conditioning, as `closure_margin`, `worst_joint_torque` and `conditioning` give them.

    Args:
        g: The mechanism.
        p: (n, 3) platform centres in the base frame, m.

    Returns:
        The figures; the last two are NaN where a chain cannot be closed, all are NaN where a position is.
    """
    coordinates = np.ascontiguousarray(np.atleast_2d(positions(p)).T)
    return figures_into(g, coordinates, np.empty((5, coordinates.shape[1])))


def figures_into(g: DeltaGeometry, coordinates: np.ndarray, out: np.ndarray) -> PositionFigures:
    """The same for loops over designs: nothing is copied and no memory asked for, which takes longer than to compute.

    Args:
        g: The mechanism.
        coordinates: (3, n) x, y, z of the platform centres, m, contiguous.
        out: (5, n) room, contiguous.

    Returns:
        The figures, views of `out`.
    """
    x, y, z = coordinates
    closure, arm1, arm2, arm3, kappa = out
    _figures(x, y, z, g.radius_difference, g.upper_arm_length, g.forearm_length, closure, arm1, arm2, arm3, kappa)
    return PositionFigures(closure, out[1:4].T, kappa)


@inlined
def chain_closure(q, t, z, la, lb):
    """Closes a chain in its own plane: rho^2, m, w^2 and w, README (2), (3); w is NaN where it cannot be closed."""
    rho2 = q * q + z * z
    m = (rho2 + t * t + la * la - lb * lb) / (2.0 * la)
    w2 = rho2 - m * m
    return rho2, m, w2, math.sqrt(w2)


@inlined
def _chain(q, t, z, la, lb):
    """w^2, w and the forearm along the chain's radius and along z, README (2), (3), (5), (6)."""
    rho2, m, w2, w = chain_closure(q, t, z, la, lb)
    scale = la / rho2
    return w2, w, q - (q * m + z * w) * scale, z - (z * m - q * w) * scale


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
def _kappa(w1, w2, w3, g12, g13, g23, n1, n2, n3, det, lb2):
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


@compiled
def _figures(px, py, pz, a, la, lb, closure, arm1, arm2, arm3, kappa):
    """Fills closure margin, three torque arms and kappa, each (n,), from three coordinates, each (n,)."""
    lb2 = lb * lb
    for k in range(len(px)):
        x, y, z = px[k], py[k], pz[k]
        xc, yc, xs, ys = -0.5 * x, -0.5 * y, SIN_60 * x, SIN_60 * y
        w21, w1, r1, z1 = _chain(x - a, y, z, la, lb)
        w22, w2, r2, z2 = _chain(xc + ys - a, yc - xs, z, la, lb)
        w23, w3, r3, z3 = _chain(xc - ys - a, yc + xs, z, la, lb)
        x1, y1 = r1, y
        x2, y2 = -0.5 * r2 - SIN_60 * (yc - xs), SIN_60 * r2 - 0.5 * (yc - xs)
        x3, y3 = -0.5 * r3 + SIN_60 * (yc + xs), -SIN_60 * r3 - 0.5 * (yc + xs)
        fx, fy, fz = y2 * z3 - z2 * y3, z2 * x3 - x2 * z3, x2 * y3 - y2 * x3
        det = x1 * fx + y1 * fy + z1 * fz
        n1 = fx * fx + fy * fy + fz * fz
        fx, fy, fz = y3 * z1 - z3 * y1, z3 * x1 - x3 * z1, x3 * y1 - y3 * x1
        n2 = fx * fx + fy * fy + fz * fz
        fx, fy, fz = y1 * z2 - z1 * y2, z1 * x2 - x1 * z2, x1 * y2 - y1 * x2
        n3 = fx * fx + fy * fy + fz * fz
        g12, g13, g23 = x1 * x2 + y1 * y2 + z1 * z2, x1 * x3 + y1 * y3 + z1 * z3, x2 * x3 + y2 * y3 + z2 * z3
        lower = w21 if w21 < w22 else w22
        closure[k] = lower if lower < w23 else w23
        scale = math.inf if det == 0.0 else la / abs(det)
        arm1[k] = math.inf if det == 0.0 else scale * w1 * math.sqrt(n1)
        arm2[k] = math.inf if det == 0.0 else scale * w2 * math.sqrt(n2)
        arm3[k] = math.inf if det == 0.0 else scale * w3 * math.sqrt(n3)
        kappa[k] = _kappa(w1, w2, w3, g12, g13, g23, n1, n2, n3, det, lb2)
