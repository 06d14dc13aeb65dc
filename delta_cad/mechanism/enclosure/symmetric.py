"""Eigenvalues of a symmetric 3 x 3 matrix of affine forms, bounded from both sides, README (33).

The matrix is turned by the eigenvectors at the box's centre; what is left beside the diagonal lifts the largest
eigenvalue above the first entry by a little, which is bounded. Six forms stand for a matrix: 11, 22, 33, 12, 13, 23.
"""

from __future__ import annotations

import math

from delta_cad.common.jit import compiled
from delta_cad.mechanism.enclosure.affine_form import ROUND, UP, add, constant, lower, magnitude, scale, subtract

# How far the columns of the eigenvectors' matrix may be from orthonormal; Jacobi's rotations keep them to 1e-14.
NEARLY = 1e-12
_SWEEPS = 4  # of Jacobi: convergence is quadratic; what is left off the diagonal only widens the bounds


@compiled
def eigenvectors(a, work):
    """Computes the eigenvectors of a symmetric matrix by Jacobi's rotations, columns by falling eigenvalue.

    Args:
        a: The six numbers a11, a22, a33, a12, a13, a23.
        work: (6, 3) room: the matrix, then the vectors.

    Returns:
        Whether the columns are orthonormal to `NEARLY`; they stand in work[3:].
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
    return 3.0 * worst + 1e-15 <= NEARLY


@compiled
def congruent(a, v, k, l):  # noqa: E741
    """Entry (k, l) of V^T A V for a matrix A of six forms; V's rows are v[3:]."""
    c = s1 = s2 = s3 = s4 = e = total = 0.0
    for n in range(6):
        i, j = (n, n) if n < 3 else ((0, n - 2) if n < 5 else (1, 2))
        f = v[3 + i, k] * v[3 + j, l]
        if i != j:
            f += v[3 + j, k] * v[3 + i, l]
        form = a[n]
        c, s1, s2 = c + f * form[0], s1 + f * form[1], s2 + f * form[2]
        s3, s4 = s3 + f * form[3], s4 + f * form[4]
        e += abs(f) * form[5]
        total += magnitude(form)
    # each factor is off by at most 3 roundings of at most 2, each sum by 7 more of the terms, at most 2 in factor
    return (c, s1, s2, s3, s4, (e + 2.0 * ROUND * total) * UP)


@compiled
def _excess(gap, coupling):
    """Bounds how far a coupling lifts the larger of two eigenvalues that are at least gap apart, README (33)."""
    half = 0.5 * gap
    distance = math.sqrt(half * half + coupling * coupling)
    return (coupling * coupling / (distance + half) if half > 0.0 else distance - half) * UP


@compiled
def above(h11, h22, h33, h12, h13, h23):
    """Bounds how far the largest eigenvalue of a symmetric matrix of forms is above its first entry, README (33)."""
    gap = min(lower(subtract(h11, h22)), lower(subtract(h11, h33))) - magnitude(h23) * UP
    m12, m13 = magnitude(h12), magnitude(h13)
    return _excess(gap, math.sqrt(m12 * m12 + m13 * m13) * UP)


@compiled
def quotient(a, v, k):
    """Computes Rayleigh's quotient of a matrix of six forms (11, 22, 33, 12, 13, 23) in column k of rows v[3:]."""
    x, y, z = v[3, k], v[4, k], v[5, k]
    f = 1.0 / (x * x + y * y + z * z)
    # each factor is within 8 roundings of that of the very vector, whose length is 1 to a few roundings
    squares = add(add(scale(f * x * x, a[0]), scale(f * y * y, a[1])), scale(f * z * z, a[2]))
    mixed = add(add(scale(2.0 * f * x * y, a[3]), scale(2.0 * f * x * z, a[4])), scale(2.0 * f * y * z, a[5]))
    total = magnitude(a[0]) + magnitude(a[1]) + magnitude(a[2])
    total += magnitude(a[3]) + magnitude(a[4]) + magnitude(a[5])
    return add(add(squares, mixed), constant(0.0, 4.0 * ROUND * total))
