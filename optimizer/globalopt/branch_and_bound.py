"""Branch and bound over boxes of designs: which of them the witness points exclude, compiled.

The cube's half side and the thresholds are numbers here; a box is excluded when no design in it meets them. Boxes that
resist are contracted by every row, then halved. A design that all witnesses allow is handed out as a question: either
the cube has a point that refuses it, which becomes a witness, or it is better than what is asked for.

Importing this module loads numba.
"""

from __future__ import annotations

import numpy as np

from delta_cad.common.jit import compiled
from delta_cad.mechanism.proof.affine_form import ROUND
from optimizer.globalopt.affine_form import add, constant, subtract
from optimizer.globalopt.cutting_points import EXCLUDED, _store, lengths, witness_rows
from optimizer.globalopt.dual_simplex import SIZE, SYMBOLS, solve

WITNESSES = 128
"""Most witness points at once."""
ROWS = 19 * WITNESSES + 8
SMALLEST = 1e-11
"""m; a box this small is given up: the incumbent's own rounding is near."""
ENOUGH = 0.7
"""A contraction to less than this share of the volume is worth another look before the box is halved."""
PAD = 1e-13
"""Of a box's half width: more than the roundings of a contraction's few operations on numbers of 1."""
FOLD = 1.1547
"""Just below 2 / sqrt(3): as far from the axis the point above chain 1's shoulder may be, as a share of L."""
DONE, QUESTION, STUCK = 0, 1, 2


@compiled
def _whole_rows(k, box, whole, rows, n):
    """Rows in closed form, the same in the whole cube: outline, lean, and the fold above a shoulder.

    Args:
        k: `lengths`.
        box: (2, 4) the box, m.
        whole: L; largest L_A + a, or infinity; least L_B for the lean; m, each rounded outwards.
        rows: Room.
        n: How many rows there are.
    """
    if whole[1] < np.inf:
        n = _store(rows, n, subtract(constant(whole[1], 0.0), add(k[0], k[2])))
    if n != EXCLUDED and whole[2] > 0.0:
        n = _store(rows, n, subtract(k[1], constant(whole[2], 0.0)))
    if n != EXCLUDED and max(abs(box[0, 2]), abs(box[1, 2])) <= FOLD * whole[0]:
        n = _store(rows, n, add(k[3], subtract(k[0], k[1])))
        if n != EXCLUDED:
            n = _store(rows, n, add(k[3], subtract(k[1], k[0])))
    return n


@compiled
def _contract(rows, n, box):
    """Cuts off what a row alone refuses; the share of the volume that is left, 0 if that excludes the box."""
    share = 1.0
    for j in range(SYMBOLS):
        low, high = box[0, j], box[1, j]
        if low == high:
            continue
        c, r = 0.5 * (low + high), 0.5 * (high - low)
        left, right = -1.0, 1.0
        for i in range(n):
            s = rows[i, 1 + j]
            if s == 0.0:
                continue
            best = rows[i, 0] + rows[i, 5] + abs(rows[i, 1]) + abs(rows[i, 2]) + abs(rows[i, 3]) + abs(rows[i, 4])
            edge = (best - abs(s) + 4.0 * ROUND) / abs(s)  # rows have a magnitude of at most 1
            if s > 0.0:
                left = max(left, -edge)
            else:
                right = min(right, edge)
        if left > right + 2.0 * PAD:
            return 0.0
        error = ROUND * (abs(c) + r)
        if left > -1.0:
            box[0, j] = min(max(low, c + r * (left - PAD) - error), high)
        if right < 1.0:
            box[1, j] = max(min(high, c + r * (right + PAD) + error), low)
        share *= max(box[1, j] - box[0, j], SMALLEST * (high - low)) / (high - low)
    return share


@compiled
def _allowed(point, mask, points, count, numbers, whole, work, rows):
    """Whether no witness refuses a single design, a box of no size."""
    k = lengths(point)
    if _whole_rows(k, point, whole, rows, 0) == EXCLUDED:
        return False
    for i in range(count):  # noqa: SIM110  (compiled code has no generators)
        if mask[i] and witness_rows(points[i], k, numbers, work, rows, 0) == EXCLUDED:
            return False
    return True


@compiled
def search(boxes, masks, flags, state, points, count, hits, numbers, whole, candidate, budget):
    """Examines up to `budget` boxes, depth first.

    Args:
        boxes: (S, 2, 4) stack of boxes, m.
        masks: (S, WITNESSES) bytes: which witnesses a box does not yet meet as a whole.
        flags: (S,) 1 where the box's question was answered already.
        state: How many boxes are on the stack, and how many were examined.
        points: (WITNESSES, 3) witness points as x, y, height over the bottom face, m.
        count: How many witnesses there are.
        hits: (WITNESSES,) how often each excluded a box.
        numbers: (9,) `witness.NUMBERS`.
        whole: (3,) see `_whole_rows`.
        candidate: (4,) filled with the design of a question.
        budget: Boxes.

    Returns:
        `DONE`; `QUESTION`, the box being on top of the stack; `STUCK`, likewise.
    """
    rows, spare, work = np.empty((ROWS, 6)), np.empty((32, 6)), np.empty((6, 3))
    u, basis, weight = np.zeros(SYMBOLS), np.zeros(SIZE, dtype=np.int64), np.zeros(SIZE)
    matrix, right = np.empty((SIZE, SIZE)), np.empty((SIZE, 1))
    point = np.empty((2, SYMBOLS))
    order = np.argsort(-hits[:count])
    box, mask = np.empty((2, SYMBOLS)), np.empty(WITNESSES, dtype=np.uint8)
    while state[0] > 0 and budget > 0:
        budget -= 1
        state[1] += 1
        top = state[0] - 1
        box[:] = boxes[top]
        mask[:] = masks[top]
        k = lengths(box)
        n = _whole_rows(k, box, whole, rows, 0)
        for i in order:
            if n == EXCLUDED:
                break
            if mask[i] == 0:
                continue
            before = n
            n = witness_rows(points[i], k, numbers, work, rows, n)
            if n == EXCLUDED:
                hits[i] += 1
            elif n == before:
                mask[i] = 0
        u[:] = 0.0
        if n == EXCLUDED or (n > 0 and solve(rows, n, u, basis, weight, matrix, right)):
            state[0] -= 1
            continue
        if not flags[top]:
            for j in range(SYMBOLS):
                c, r = 0.5 * (box[0, j] + box[1, j]), 0.5 * (box[1, j] - box[0, j])
                candidate[j] = min(max(c + r * u[j], box[0, j]), box[1, j])
            point[0], point[1] = candidate, candidate
            if _allowed(point, mask, points, count, numbers, whole, work, spare):
                return QUESTION
        share = _contract(rows, n, box)
        if share == 0.0:
            state[0] -= 1
            continue
        axis = 0
        for j in range(1, SYMBOLS):
            if box[1, j] - box[0, j] > box[1, axis] - box[0, axis]:
                axis = j
        if box[1, axis] - box[0, axis] < SMALLEST:
            return STUCK
        boxes[top] = box
        masks[top] = mask
        flags[top] = 0
        if share < ENOUGH:
            continue
        boxes[top + 1] = box
        masks[top + 1] = mask
        flags[top + 1] = 0
        middle = 0.5 * (box[0, axis] + box[1, axis])
        boxes[top, 1, axis] = middle
        boxes[top + 1, 0, axis] = middle
        state[0] += 1
    return DONE
