"""Cuts that must all be >= 0 in a box, and the weighted sum of them that shows that they cannot.

A cut is an affine form: what a design has to meet at one cutting point of the cube. No single cut may exclude a box
around an optimum, where several are in balance; a sum with weights >= 0 does, to second order of the box's size. The
weights come from a linear program over the box, `max t: c_k + e_k + s_k u >= t, -1 <= u <= 1`, solved by the dual
simplex method in plain floating point; whatever they are, the sum of cuts with weights >= 0 is tested by itself, with
every rounding counted, so that nothing is believed of the solver.
"""

from __future__ import annotations

import numpy as np

from delta_cad.common.jit import compiled
from delta_cad.mechanism.enclosure.affine_form import ROUND, SYMBOLS, TERMS, UP

SIZE = SYMBOLS + 1
_ITERATIONS = 60  # exchanges of a row; 5 to 15 are usual
LEAST = 1e-13  # with cuts of magnitude 1, a smaller violation or step is a rounding of the elimination


@compiled
def highest(cuts, k):
    """Bounds a cut from above, but for roundings."""
    return cuts[k, 0] + cuts[k, 5] + abs(cuts[k, 1]) + abs(cuts[k, 2]) + abs(cuts[k, 3]) + abs(cuts[k, 4])


@compiled
def _eliminate(matrix, right):
    """Solves a system of 5 equations in place, with row exchange; False where it is singular."""
    for k in range(SIZE):
        p = k
        for i in range(k + 1, SIZE):
            if abs(matrix[i, k]) > abs(matrix[p, k]):
                p = i
        if abs(matrix[p, k]) < LEAST:
            return False
        if p != k:
            for j in range(SIZE):
                matrix[p, j], matrix[k, j] = matrix[k, j], matrix[p, j]
            right[p], right[k] = right[k], right[p]
        for i in range(k + 1, SIZE):
            f = matrix[i, k] / matrix[k, k]
            if f != 0.0:
                for j in range(k, SIZE):
                    matrix[i, j] -= f * matrix[k, j]
                right[i] -= f * right[k]
    for i in range(SIZE - 1, -1, -1):
        total = right[i]
        for j in range(i + 1, SIZE):
            total -= matrix[i, j] * right[j]
        right[i] = total / matrix[i, i]
    return True


@compiled
def _gradient(cuts, count, k, out):
    """Fills the gradient of constraint k in (u, t): that of a cut, or of one of the 8 sides of the box."""
    out[:] = 0.0
    if k < count:
        for j in range(SYMBOLS):
            out[j] = cuts[k, 1 + j]
        out[SYMBOLS] = -1.0
    else:
        j = (k - count) // 2
        out[j] = -1.0 if (k - count) % 2 == 0 else 1.0


@compiled
def excluded(cuts, count, basis, weight):
    """Decides whether the sum of cuts with these weights is negative in the whole box, every rounding counted.

    Args:
        cuts: (n, 6) forms.
        count: How many of them are cuts.
        basis: (5,) constraints; those from `count` on are sides of the box and left out.
        weight: (5,) weights; negative ones are left out.
    """
    c = s1 = s2 = s3 = s4 = e = total = 0.0
    for n in range(SIZE):
        k, f = basis[n], weight[n]
        if k >= count or not f > 0.0:
            continue
        c, s1, s2 = c + f * cuts[k, 0], s1 + f * cuts[k, 1], s2 + f * cuts[k, 2]
        s3, s4, e = s3 + f * cuts[k, 3], s4 + f * cuts[k, 4], e + f * cuts[k, 5]
        total += f * (abs(cuts[k, 0]) + abs(cuts[k, 1]) + abs(cuts[k, 2]) + abs(cuts[k, 3]) + abs(cuts[k, 4]))
    top = c + ((abs(s1) + abs(s2)) + (abs(s3) + abs(s4))) * UP + e * UP
    # five products and sums to each number: 10 roundings of the magnitudes, doubled by ROUND's 16
    return top + 2.0 * ROUND * (total + e) < 0.0


@compiled
def solve(cuts, count, u, basis, weight, matrix, right):
    """Solves the linear program until it shows that the cuts contradict each other, or to its optimum.

    Args:
        cuts: (n, 6) forms (c, s1..s4, e), each scaled to a magnitude near 1.
        count: How many of them are cuts, at least 1.
        u: (4,) filled with the best place in the box.
        basis: (5,) room: the constraints in balance.
        weight: (5,) room: their weights.
        matrix: (5, 5) room.
        right: (5,) room.

    Returns:
        Whether a sum of cuts excludes the box; only `excluded` decides that.
    """
    best, k0 = np.inf, 0
    for k in range(count):
        top = highest(cuts, k)
        if top < best:
            best, k0 = top, k
    basis[SYMBOLS] = k0
    for j in range(SYMBOLS):
        basis[j] = count + 2 * j + (0 if cuts[k0, 1 + j] >= 0.0 else 1)
    line = np.empty(SIZE)
    for _ in range(_ITERATIONS):
        # where all five are in balance
        for n in range(SIZE):
            k = basis[n]
            _gradient(cuts, count, k, matrix[n])
            right[n] = -(cuts[k, 0] + cuts[k, TERMS - 1]) if k < count else -1.0
        if not _eliminate(matrix, right):
            return False
        for j in range(SYMBOLS):
            u[j] = right[j]
        t = right[SYMBOLS]
        # their weights
        for n in range(SIZE):
            _gradient(cuts, count, basis[n], line)
            for j in range(SIZE):
                matrix[j, n] = line[j]
            right[n] = -1.0 if n == SYMBOLS else 0.0
        if not _eliminate(matrix, right):
            return False
        for n in range(SIZE):
            weight[n] = right[n]
        if t < 0.0 and excluded(cuts, count, basis, weight):
            return True
        # the constraint that is violated most
        worst, p = -LEAST, -1
        for k in range(count):
            value = cuts[k, 0] + cuts[k, TERMS - 1] - t
            for j in range(SYMBOLS):
                value += cuts[k, 1 + j] * u[j]
            if value < worst:
                worst, p = value, k
        for j in range(SYMBOLS):
            value = 1.0 - abs(u[j])
            if value < worst:
                worst, p = value, count + 2 * j + (0 if u[j] > 0.0 else 1)
        if p < 0:
            break
        _gradient(cuts, count, p, right)
        for n in range(SIZE):
            _gradient(cuts, count, basis[n], line)
            for j in range(SIZE):
                matrix[j, n] = line[j]
        if not _eliminate(matrix, right):
            return False
        leaving, least = -1, np.inf
        for n in range(SIZE):
            if right[n] > LEAST:
                ratio = max(weight[n], 0.0) / right[n]
                if ratio < least:
                    leaving, least = n, ratio
        if leaving < 0:
            break
        basis[leaving] = p
    for j in range(SYMBOLS):
        u[j] = min(max(u[j], -1.0), 1.0)
    return False
