"""Margins of every condition over a box of positions as affine forms, README (31)-(34).

A margin is not negative where its condition holds; there are 14, `FIRST` and `COUNT` say which are whose. Importing
this module loads numba.
"""

from __future__ import annotations

import math

import numpy as np

from delta_cad.common.jit import compiled
from delta_cad.mechanism.geometry import DeltaGeometry
from delta_cad.mechanism.proof.affine_form import (
    ROUND,
    UP,
    add,
    constant,
    inverse,
    lower,
    magnitude,
    multiply,
    root,
    scale,
    subtract,
    upper,
)
from delta_cad.mechanism.proof.limits import Limits, cosine_sine

FIRST = {"reach": 0, "singularity": 3, "torque": 4, "kappa": 7, "shoulder": 8, "lean": 11}
COUNT = {"reach": 3, "singularity": 1, "torque": 3, "kappa": 1, "shoulder": 3, "lean": 3}
"""Of a condition's margins in the list: the first, and how many: one a chain, or one."""
MARGINS = 14
_REACH, _SINGULARITY, _TORQUE, _KAPPA, _SHOULDER, _LEAN = FIRST.values()
_OTHERS = ~0b111 & ((1 << _LEAN) - 1)  # what needs the closed chains

_ROOT_3_4 = float(np.sqrt(3.0) / 2.0)
_HALF_ULP = 2.0**-54  # of a double in [1/2, 1), such as the root of 3/4: sqrt and the halving round to nearest
_NEARLY = 1e-12
"""How far the columns of the eigenvectors' matrix may be from orthonormal; Jacobi's rotations keep them to 1e-14."""
_SWEEPS = 4  # of Jacobi: convergence is quadratic; what is left off the diagonal only widens the bounds

LOW, HIGH, CENTRE = 0, 1, 2
"""Columns of the list of margins: both bounds, the form's centre, and from 3 on its slopes."""


def constants(g: DeltaGeometry, limits: Limits) -> np.ndarray:
    """The numbers of a design and its limits, for `margins`; each with a bound of its error where it was rounded.

    Args:
        g: The mechanism.
        limits: The conditions.

    Returns:
        (18,) numbers.
    """
    la, lb, a = g.upper_arm_length, g.forearm_length, g.radius_difference
    lever = 0.0 if limits.force is None or limits.torque_max is None else limits.force * la / limits.torque_max
    kappa = limits.kappa_max or 0.0
    low, high = limits.shoulder or (0.0, 0.0)
    cos_middle, sin_middle = cosine_sine(low, high)
    cos_half, _ = cosine_sine(high, -low)
    _, sin_lean = cosine_sine(limits.lean_max or 0.0, limits.lean_max or 0.0)
    return np.array(
        [
            *(a, ROUND * (abs(g.base_radius) + abs(g.platform_radius))),
            *(la, lb),
            *((la - lb) * (la + lb), ROUND * (la + lb) ** 2),
            *(limits.elbow_arm_min**2, ROUND * limits.elbow_arm_min**2),
            *(lever**2, ROUND * lever**2),
            *(kappa**2, ROUND * kappa**2),
            *(cos_middle, sin_middle, cos_half, ROUND),
            *(lb * sin_lean, ROUND * lb),
        ]
    )


@compiled
def _store(out, k, form):
    """Writes a margin that is one form."""
    out[k, 0], out[k, 1] = lower(form), upper(form)
    out[k, 2], out[k, 3], out[k, 4], out[k, 5] = form[0], form[1], form[2], form[3]


@compiled
def chain(q, t, z, square, k):
    """One chain, README (2), (3), (32).

    Args:
        q: Form of the wrist's radial coordinate, m.
        t: Form of the one along the shoulder axis, m.
        z: Form of its height, m.
        square: Form of q^2 + t^2 + z^2, m^2.
        k: The design's numbers.

    Returns:
        Forms of w^2 and of w, and of the forearm's components along the chain's radius and along z.
    """
    la = k[2]
    rho2 = subtract(square, multiply(t, t))
    m = multiply(constant(0.5 / la, ROUND / la), add(square, constant(k[4], k[5])))
    w2 = subtract(rho2, multiply(m, m))
    w = root(w2)
    part = multiply(constant(la, 0.0), inverse(rho2))
    left = subtract(constant(1.0, 0.0), multiply(m, part))
    across = multiply(w, part)
    radial = subtract(multiply(q, left), multiply(z, across))
    vertical = add(multiply(z, left), multiply(q, across))
    return w2, w, radial, vertical


@compiled
def scalar(s, r):
    """Scalar product of two vectors of forms."""
    return add(add(multiply(s[0], r[0]), multiply(s[1], r[1])), multiply(s[2], r[2]))


@compiled
def determinant(s, r, t):
    """Determinant of three vectors of forms."""
    x = subtract(multiply(r[1], t[2]), multiply(r[2], t[1]))
    y = subtract(multiply(r[2], t[0]), multiply(r[0], t[2]))
    z = subtract(multiply(r[0], t[1]), multiply(r[1], t[0]))
    return scalar(s, (x, y, z))


@compiled
def _eigenvectors(a, work):
    """Eigenvectors of a symmetric matrix by Jacobi's rotations, columns by falling eigenvalue.

    Args:
        a: The six numbers a11, a22, a33, a12, a13, a23.
        work: (6, 3) room: the matrix, then the vectors.

    Returns:
        Whether the columns are orthonormal to `_NEARLY`; they stand in work[3:].
    """
    work[0, 0], work[1, 1], work[2, 2] = a[0], a[1], a[2]
    work[0, 1], work[0, 2], work[1, 2] = a[3], a[4], a[5]
    work[1, 0], work[2, 0], work[2, 1] = a[3], a[4], a[5]
    for i in range(3):
        for j in range(3):
            work[3 + i, j] = 1.0 if i == j else 0.0
    for n in range(3 * _SWEEPS):
        i, j = (0, 1) if n % 3 == 0 else ((0, 2) if n % 3 == 1 else (1, 2))
        if work[i, j] == 0.0:
            continue
        tau = (work[j, j] - work[i, i]) / (2.0 * work[i, j])
        t = (1.0 if tau >= 0.0 else -1.0) / (abs(tau) + math.sqrt(1.0 + tau * tau))
        c = 1.0 / math.sqrt(1.0 + t * t)
        s = t * c
        for row in range(6):
            left, right = work[row, i], work[row, j]
            work[row, i], work[row, j] = c * left - s * right, s * left + c * right
        for column in range(3):
            left, right = work[i, column], work[j, column]
            work[i, column], work[j, column] = c * left - s * right, s * left + c * right
    for i, j in ((0, 1), (1, 2), (0, 1)):
        if work[i, i] < work[j, j]:
            work[i, i], work[j, j] = work[j, j], work[i, i]
            for row in range(3, 6):
                work[row, i], work[row, j] = work[row, j], work[row, i]
    worst = 0.0
    for i in range(3):
        for j in range(3):
            total = work[3, i] * work[3, j] + work[4, i] * work[4, j] + work[5, i] * work[5, j]
            worst = max(worst, abs(total - (1.0 if i == j else 0.0)))
    return 3.0 * worst + 1e-15 <= _NEARLY


@compiled
def _congruent(a, v, k, l):  # noqa: E741
    """Entry (k, l) of V^T A V for a matrix A of six forms; V's rows are v[3:]."""
    c = x = y = z = e = total = 0.0
    for n in range(6):
        i, j = (n, n) if n < 3 else ((0, n - 2) if n < 5 else (1, 2))
        f = v[3 + i, k] * v[3 + j, l]
        if i != j:
            f += v[3 + j, k] * v[3 + i, l]
        form = a[n]
        c, x, y, z = c + f * form[0], x + f * form[1], y + f * form[2], z + f * form[3]
        e += abs(f) * form[4]
        total += magnitude(form)
    # each factor is off by at most 3 roundings of at most 2, each sum by 7 more of the terms, at most 2 in factor
    return (c, x, y, z, (e + 2.0 * ROUND * total) * UP)


@compiled
def _excess(gap, coupling):
    """How far a coupling lifts the larger of two eigenvalues that are at least gap apart, README (33)."""
    half = 0.5 * gap
    distance = math.sqrt(half * half + coupling * coupling)
    return (coupling * coupling / (distance + half) if half > 0.0 else distance - half) * UP


@compiled
def _above(h11, h22, h33, h12, h13, h23):
    """How far the largest eigenvalue of a symmetric matrix of forms can be above its first entry, README (33)."""
    gap = min(lower(subtract(h11, h22)), lower(subtract(h11, h33))) - magnitude(h23) * UP
    m12, m13 = magnitude(h12), magnitude(h13)
    return _excess(gap, math.sqrt(m12 * m12 + m13 * m13) * UP)


@compiled
def _kappa(a, det, k, work, out):
    """Writes the margin of kappa, K^2 l3 - l1 of the Gram matrix, README (33); 0 where only (34) proves it.

    Args:
        a: Forms of the Gram matrix of the rows s_i / w_i: 11, 22, 33, 12, 13, 23.
        det: Form of the rows' determinant.
        k: The design's numbers.
        work: (6, 3) room.
        out: The list of margins.
    """
    out[_KAPPA, :] = math.nan
    if not _eigenvectors((a[0][0], a[1][0], a[2][0], a[3][0], a[4][0], a[5][0]), work):
        return
    h11, h22, h33 = _congruent(a, work, 0, 0), _congruent(a, work, 1, 1), _congruent(a, work, 2, 2)
    h12, h13, h23 = _congruent(a, work, 0, 1), _congruent(a, work, 0, 2), _congruent(a, work, 1, 2)
    above = _above(h11, h22, h33, h12, h13, h23)
    below = _above(scale(-1.0, h33), scale(-1.0, h22), scale(-1.0, h11), h23, h13, h12)
    square = constant(k[10], k[11])
    form = subtract(multiply(square, h33), h11)
    _store(out, _KAPPA, form)
    # columns that are not quite orthonormal change either eigenvalue by that factor
    bent = 3.0 * _NEARLY * (magnitude(h11) + above + 2.0 * k[10] * magnitude(h33))
    out[_KAPPA, 0] -= (above + (k[10] + k[11]) * below + bent) * UP
    out[_KAPPA, 1] += bent
    if out[_KAPPA, 0] >= 0.0:
        return
    c33, c22 = subtract(multiply(h11, h22), multiply(h12, h12)), subtract(multiply(h11, h33), multiply(h13, h13))
    c11 = subtract(multiply(h22, h33), multiply(h23, h23))
    c13, c23 = subtract(multiply(h12, h23), multiply(h13, h22)), subtract(multiply(h12, h13), multiply(h11, h23))
    lift = _above(c33, c22, c11, c23, c13, subtract(multiply(h13, h23), multiply(h12, h33)))
    volume = multiply(square, multiply(det, det))
    slack = lower(subtract(volume, multiply(h11, c33)))
    first, second = magnitude(h11) + above, magnitude(c33) + lift
    slack -= (magnitude(h11) * lift + magnitude(c33) * above + above * lift) * UP
    slack -= 10.0 * _NEARLY * (first * second + magnitude(volume))
    if slack >= 0.0:
        out[_KAPPA, 0] = 0.0


@compiled
def _lean(t, k, j, out):
    """Writes the margin of a chain's lean, L_B sin(lean_max) - |t|; linear but for t's sign."""
    side = -1.0 if t[0] > 0.0 else 1.0
    _store(out, j, add(constant(k[16], k[17]), scale(side, t)))
    out[j, 0] = min(out[j, 0], lower(subtract(constant(k[16], k[17]), scale(side, t))))
    out[j, 1] = min(out[j, 1], upper(constant(k[16], k[17])))


@compiled
def margins(box, k, sign, needed, work, out):
    """Margins of the conditions over a box.

    Args:
        box: Centre (3), half sides (3), and a bound of the error of both, m; a point has four zeros.
        k: `constants`.
        sign: Of det S at the reference point, 1.0 or -1.0.
        needed: Bits of the margins that are wanted; the others may be left as they are.
        work: (6, 3) room.
        out: (14, 6) filled: `LOW`, `HIGH`, `CENTRE`, slopes; NaN where nothing can be said.
    """
    x, y, z = (
        (box[0], box[3], 0.0, 0.0, box[6]),
        (box[1], 0.0, box[4], 0.0, box[6]),
        (box[2], 0.0, 0.0, box[5], box[6]),
    )
    a = constant(k[0], k[1])
    turn = constant(_ROOT_3_4, _HALF_ULP)
    xc, yc, xs, ys = scale(-0.5, x), scale(-0.5, y), multiply(turn, x), multiply(turn, y)
    u1, u2, u3 = x, add(xc, ys), subtract(xc, ys)
    t1, t2, t3 = y, subtract(yc, xs), add(yc, xs)
    if needed >> _LEAN:
        _lean(t1, k, _LEAN, out)
        _lean(t2, k, _LEAN + 1, out)
        _lean(t3, k, _LEAN + 2, out)
    if not needed & ((1 << _LEAN) - 1):
        return
    square = add(add(multiply(x, x), multiply(y, y)), multiply(z, z))
    s1 = add(square, multiply(a, subtract(a, scale(2.0, u1))))
    s2 = add(square, multiply(a, subtract(a, scale(2.0, u2))))
    s3 = add(square, multiply(a, subtract(a, scale(2.0, u3))))
    q1, q2, q3 = subtract(u1, a), subtract(u2, a), subtract(u3, a)
    v1, w1, r1, z1 = chain(q1, t1, z, s1, k)
    v2, w2, r2, z2 = chain(q2, t2, z, s2, k)
    v3, w3, r3, z3 = chain(q3, t3, z, s3, k)
    least = constant(k[6], k[7])
    _store(out, _REACH, subtract(v1, least))
    _store(out, _REACH + 1, subtract(v2, least))
    _store(out, _REACH + 2, subtract(v3, least))
    if not needed & _OTHERS:
        return
    if not (lower(v1) > 0.0 and lower(v2) > 0.0 and lower(v3) > 0.0):
        out[_SINGULARITY:_LEAN] = math.nan
        return
    if needed & (0b111 << _SHOULDER):
        # L_A times the margin, so that cos and sin need not be divided out
        c, s, h = constant(k[12], k[15]), constant(k[13], k[15]), multiply(constant(k[2], 0.0), constant(k[14], k[15]))
        m1 = add(multiply(c, subtract(q1, r1)), multiply(s, subtract(z, z1)))
        m2 = add(multiply(c, subtract(q2, r2)), multiply(s, subtract(z, z2)))
        m3 = add(multiply(c, subtract(q3, r3)), multiply(s, subtract(z, z3)))
        _store(out, _SHOULDER, subtract(m1, h))
        _store(out, _SHOULDER + 1, subtract(m2, h))
        _store(out, _SHOULDER + 2, subtract(m3, h))
    if not needed & ((1 << _SHOULDER) - (1 << _SINGULARITY)):
        return
    rc, rs, tc, ts = scale(-0.5, r2), multiply(turn, r2), scale(-0.5, t2), multiply(turn, t2)
    f1, f2 = (r1, t1, z1), (subtract(rc, ts), add(rs, tc), z2)
    rc, rs, tc, ts = scale(-0.5, r3), multiply(turn, r3), scale(-0.5, t3), multiply(turn, t3)
    f3 = (add(rc, ts), subtract(tc, rs), z3)
    det = determinant(f1, f2, f3)
    _store(out, _SINGULARITY, scale(sign, det))
    g12, g13, g23 = scalar(f1, f2), scalar(f1, f3), scalar(f2, f3)
    lb2 = multiply(constant(k[3], 0.0), constant(k[3], 0.0))
    if needed & (0b111 << _TORQUE):
        # det^2 - (F L_A / torque)^2 w_i^2 |s_j x s_k|^2
        lb4, det2, lever = multiply(lb2, lb2), multiply(det, det), constant(k[8], k[9])
        n1 = multiply(multiply(lever, v1), subtract(lb4, multiply(g23, g23)))
        n2 = multiply(multiply(lever, v2), subtract(lb4, multiply(g13, g13)))
        n3 = multiply(multiply(lever, v3), subtract(lb4, multiply(g12, g12)))
        _store(out, _TORQUE, subtract(det2, n1))
        _store(out, _TORQUE + 1, subtract(det2, n2))
        _store(out, _TORQUE + 2, subtract(det2, n3))
    if needed & (1 << _KAPPA):
        i1, i2, i3 = inverse(w1), inverse(w2), inverse(w3)
        gram = (
            multiply(lb2, inverse(v1)),
            multiply(lb2, inverse(v2)),
            multiply(lb2, inverse(v3)),
            multiply(g12, multiply(i1, i2)),
            multiply(g13, multiply(i1, i3)),
            multiply(g23, multiply(i2, i3)),
        )
        _kappa(gram, multiply(det, multiply(i1, multiply(i2, i3))), k, work, out)
