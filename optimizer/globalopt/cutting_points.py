"""What a design must meet at one point of its cube, as rows over a box of designs.

Each row is an affine form of `affine_form` that is >= 0 for every design of the box that is feasible; a row that is
negative in the whole box therefore excludes it. Rows need not be sharp where a design is infeasible anyway, so w is
taken as a root of what is not negative, and every unit vector may stand for an eigenvector. README (5)-(9) beside this
file has the derivations.

Importing this module loads numba.
"""

from __future__ import annotations

import math

import numpy as np

from delta_cad.common.jit import compiled
from delta_cad.mechanism.proof.affine_form import ROUND
from delta_cad.mechanism.proof.enclosure import _eigenvectors
from optimizer.globalopt.affine_form import (
    add,
    constant,
    inverse,
    lower,
    magnitude,
    multiply,
    root,
    scale,
    slope,
    subtract,
    upper,
)

ROOT_3_4 = float(np.sqrt(3.0) / 2.0)
HALF_ULP = 2.0**-54
"""Of a double in [1/2, 1), such as the root of 3/4: sqrt and the halving round to nearest."""
INSIDE = 1.0 - 2.0**-50
"""Shortens a normalised vector to a length of at most 1."""
EXCLUDED = -1
KAPPA, TORQUE, SHOULDER = 1, 2, 4
"""Bits of what is asked beside the reach."""
NUMBERS = 9
"""Length of the list of numbers: K^2, (F / torque)^2, cos and sin of the shoulder's middle, cos of half its range;
errors of the second, of the last three, and of the first; and the bits."""


@compiled
def _store(rows, n, form):
    """Takes a row in, scaled by a power of two, unless it is met in the whole box; `EXCLUDED` if nowhere."""
    if upper(form) < 0.0:
        return EXCLUDED
    if lower(form) >= 0.0:
        return n
    size = abs(form[0]) + slope(form) + form[5]
    if not size < math.inf:
        return n
    f = math.ldexp(1.0, -math.frexp(size)[1])
    rows[n, 0], rows[n, 1], rows[n, 2] = f * form[0], f * form[1], f * form[2]
    rows[n, 3], rows[n, 4], rows[n, 5] = f * form[3], f * form[4], f * form[5]
    return n + 1


@compiled
def lengths(box):
    """Forms of the four variables over a box and of what all chains share.

    Args:
        box: (2, 4) lower and upper ends of L_A, L_B, a, H, m.

    Returns:
        L_A, L_B, a, H, 1 / (2 L_A), L_A^2 - L_B^2, L_A^2, L_B^2.
    """
    la = _between(box, 0)
    lb = _between(box, 1)
    a = _between(box, 2)
    h = _between(box, 3)
    half = inverse(scale(2.0, la), box[0, 0])
    return la, lb, a, h, half, multiply(subtract(la, lb), add(la, lb)), multiply(la, la), multiply(lb, lb)


@compiled
def _between(box, j):
    c, r = 0.5 * (box[0, j] + box[1, j]), 0.5 * (box[1, j] - box[0, j])
    e = ROUND * (abs(c) + r)
    if box[0, j] == box[1, j]:
        c, r, e = box[0, j], 0.0, 0.0
    return (c, r if j == 0 else 0.0, r if j == 1 else 0.0, r if j == 2 else 0.0, r if j == 3 else 0.0, e)


@compiled
def _chain(q, z, zz, t2, k):
    """w^2, w, and the forearm along the chain's radius and along z; the last three for designs that are closed."""
    la = k[0]
    rho2 = add(multiply(q, q), zz)
    m = multiply(k[4], add(add(rho2, t2), k[5]))
    w2 = subtract(rho2, multiply(m, m))
    w = root(w2)
    low = lower(z)
    part = multiply(la, inverse(rho2, low * low * INSIDE))
    left = subtract(constant(1.0, 0.0), multiply(m, part))
    across = multiply(w, part)
    radial = subtract(multiply(q, left), multiply(z, across))
    vertical = add(multiply(z, left), multiply(q, across))
    return w2, w, radial, vertical


@compiled
def _far(q, z, t, k, rows, n):
    """Not too far: `L_A + sqrt(L_B^2 - t^2) - rho >= 0` is concave; its tangent at the middle has no error."""
    size = math.sqrt(q[0] * q[0] + z[0] * z[0])
    nq, nz = q[0] / size * INSIDE, z[0] / size * INSIDE
    t0 = max(abs(t[0]) - t[5], 0.0)
    b = max(k[1][0], 1.001 * t0)
    f = max(b / math.sqrt(b * b - t0 * t0), 1.0)
    g = math.sqrt(max(f * f - 1.0, 0.0))
    # l <= f L_B - t sqrt(f^2 - 1) for every f >= 1; g's rounding is that of f^2 - 1
    room = subtract(add(k[0], scale(f, k[1])), constant(t0 * g, ROUND * t0 * (f * f / max(g, 1e-9) + g)))
    return _store(rows, n, subtract(room, add(scale(nq, q), scale(nz, z))))


@compiled
def _scalar(s, r):
    return add(add(multiply(s[0], r[0]), multiply(s[1], r[1])), multiply(s[2], r[2]))


@compiled
def _determinant(s, r, t):
    x = subtract(multiply(r[1], t[2]), multiply(r[2], t[1]))
    y = subtract(multiply(r[2], t[0]), multiply(r[0], t[2]))
    z = subtract(multiply(r[0], t[1]), multiply(r[1], t[0]))
    return _scalar(s, (x, y, z))


@compiled
def _quotient(a, v, k):
    """Rayleigh's quotient of a matrix of six forms (11, 22, 33, 12, 13, 23) in column k of rows v[3:]."""
    x, y, z = v[3, k], v[4, k], v[5, k]
    f = 1.0 / (x * x + y * y + z * z)
    # each factor is within 8 roundings of that of the very vector, whose length is 1 to a few roundings
    squares = add(add(scale(f * x * x, a[0]), scale(f * y * y, a[1])), scale(f * z * z, a[2]))
    mixed = add(add(scale(2.0 * f * x * y, a[3]), scale(2.0 * f * x * z, a[4])), scale(2.0 * f * y * z, a[5]))
    total = magnitude(a[0]) + magnitude(a[1]) + magnitude(a[2])
    total += magnitude(a[3]) + magnitude(a[4]) + magnitude(a[5])
    return add(add(squares, mixed), constant(0.0, 4.0 * ROUND * total))


@compiled
def witness_rows(point, k, numbers, work, rows, n):
    """Appends what designs must meet at one point.

    Args:
        point: (3,) x, y, and height over the cube's bottom face, m.
        k: `lengths` of the box.
        numbers: (9,) see `NUMBERS`.
        work: (6, 3) room.
        rows: (.., 6) room for at most 19 more.
        n: How many rows there are.

    Returns:
        How many there are now, or `EXCLUDED`.
    """
    x, y = constant(point[0], 0.0), constant(point[1], 0.0)
    turn = constant(ROOT_3_4, HALF_ULP)
    z = add(k[3], constant(point[2], 0.0))
    zz = multiply(z, z)
    xc, yc, xs, ys = scale(-0.5, x), scale(-0.5, y), multiply(turn, x), multiply(turn, y)
    t1, t2, t3 = y, subtract(yc, xs), add(yc, xs)
    q1, q2, q3 = subtract(x, k[2]), subtract(add(xc, ys), k[2]), subtract(subtract(xc, ys), k[2])
    v1, w1, r1, z1 = _chain(q1, z, zz, multiply(t1, t1), k)
    v2, w2, r2, z2 = _chain(q2, z, zz, multiply(t2, t2), k)
    v3, w3, r3, z3 = _chain(q3, z, zz, multiply(t3, t3), k)
    for v in (v1, v2, v3):
        n = _store(rows, n, v)
        if n == EXCLUDED:
            return n
    for q, t in ((q1, t1), (q2, t2), (q3, t3)):
        n = _far(q, z, t, k, rows, n)
        if n == EXCLUDED:
            return n
    bits = int(numbers[8])
    if bits & SHOULDER:
        c, s = constant(numbers[2], numbers[6]), constant(numbers[3], numbers[6])
        h = multiply(k[0], constant(numbers[4], numbers[6]))
        for q, r, v in ((q1, r1, z1), (q2, r2, z2), (q3, r3, z3)):
            m = add(multiply(c, subtract(q, r)), multiply(s, subtract(z, v)))
            n = _store(rows, n, subtract(m, h))
            if n == EXCLUDED:
                return n
    if not bits & (KAPPA | TORQUE):
        return n
    rc, rs, tc, ts = scale(-0.5, r2), multiply(turn, r2), scale(-0.5, t2), multiply(turn, t2)
    f1, f2 = (r1, t1, z1), (subtract(rc, ts), add(rs, tc), z2)
    rc, rs, tc, ts = scale(-0.5, r3), multiply(turn, r3), scale(-0.5, t3), multiply(turn, t3)
    f3 = (add(rc, ts), subtract(tc, rs), z3)
    det = _determinant(f1, f2, f3)
    n = _store(rows, n, det)
    if n == EXCLUDED:
        return n
    g12, g13, g23 = _scalar(f1, f2), _scalar(f1, f3), _scalar(f2, f3)
    lb2 = k[7]
    if bits & TORQUE:
        # det^2 - (F L_A / torque)^2 w_i^2 |s_j x s_k|^2
        lb4, det2 = multiply(lb2, lb2), multiply(det, det)
        lever = multiply(k[6], constant(numbers[1], numbers[5]))
        for v, g in ((v1, g23), (v2, g13), (v3, g12)):
            n = _store(rows, n, subtract(det2, multiply(multiply(lever, v), subtract(lb4, multiply(g, g)))))
            if n == EXCLUDED:
                return n
    if bits & KAPPA:
        # Gram matrix of s_i w_j w_k: no division, and at a fold as good as elsewhere
        a = (
            multiply(lb2, multiply(v2, v3)),
            multiply(lb2, multiply(v1, v3)),
            multiply(lb2, multiply(v1, v2)),
            multiply(g12, multiply(multiply(w1, w2), v3)),
            multiply(g13, multiply(multiply(w1, w3), v2)),
            multiply(g23, multiply(multiply(w2, w3), v1)),
        )
        if not _eigenvectors((a[0][0], a[1][0], a[2][0], a[3][0], a[4][0], a[5][0]), work):
            return n
        square = constant(numbers[0], numbers[7])
        h1, h2, h3 = _quotient(a, work, 0), _quotient(a, work, 1), _quotient(a, work, 2)
        n = _store(rows, n, subtract(multiply(square, h3), h1))
        if n != EXCLUDED:
            n = _store(rows, n, subtract(multiply(square, h3), h2))
        if n != EXCLUDED:
            n = _store(rows, n, subtract(multiply(square, h2), h1))
    return n
