"""Branch and bound over boxes of designs: which of them the cutting points exclude, compiled.

The cube's half side and the thresholds are numbers here; a box is excluded when no design in it meets them. Boxes that
resist are contracted by every cut, then halved. A design that all points allow is handed out as a question: either
the cube has a point that refuses it, which becomes a cutting point, or it is better than the target.
"""

from __future__ import annotations

import numpy as np

from delta_cad.common.jit import compiled, free
from delta_cad.mechanism.enclosure import pose as forms
from delta_cad.mechanism.enclosure.affine_form import ROUND, SYMBOLS, TERMS, add, at, constant, subtract
from delta_cad.mechanism.enclosure.table import EXCLUDED, keep
from optimizer.globalopt.cutting_points import HEIGHT, MOST, RADII, fill_lengths, point_cuts
from optimizer.globalopt.cutting_points import ROWS as TABLE
from optimizer.globalopt.dual_simplex import SIZE, highest, solve

POINTS = 128  # most cutting points at once
_CUTS = MOST * POINTS + 20
_SMALLEST = 1e-11  # a box this small, m, is given up: the incumbent's own rounding is near
_ENOUGH = 0.7  # a contraction to less than this share of the volume is worth another look before the box is halved
# Share of a box's half width that a contraction gives back: more than the roundings of a contraction's few operations
# on numbers of 1.
PAD = 1e-13
_FOLD = (
    1.1547  # just below 2 / sqrt(3): as far from the axis the point above chain 1's shoulder may be, as a share of L
)
DONE, QUESTION, _STUCK = 0, 1, 2


@compiled
def design_cuts(pose, box, cube_limits, cuts, count):
    """Adds what holds for the whole cube in closed form: outline, lean, and the fold above a shoulder.

    Args:
        pose: (`TABLE`, 6) forms of the box, with its lengths in it.
        box: (2, 4) the box, m.
        cube_limits: L; largest L_A + a, or infinity; least L_B for the lean; least L_A + a, or minus infinity; m, each
            rounded outwards.
        cuts: Room.
        count: How many cuts there are.
    """
    la, lb, height = at(pose, forms.UPPER_ARM), at(pose, forms.FOREARM_LENGTH), at(pose, HEIGHT)
    if cube_limits[1] < np.inf:
        count = keep(cuts, count, subtract(constant(cube_limits[1], 0.0), add(la, at(pose, RADII))))
    if count != EXCLUDED and cube_limits[3] > -np.inf:
        count = keep(cuts, count, subtract(add(la, at(pose, RADII)), constant(cube_limits[3], 0.0)))
    if count != EXCLUDED and cube_limits[2] > 0.0:
        count = keep(cuts, count, subtract(lb, constant(cube_limits[2], 0.0)))
    if count != EXCLUDED and max(abs(box[0, 2]), abs(box[1, 2])) <= _FOLD * cube_limits[0]:
        count = keep(cuts, count, add(height, subtract(la, lb)))
        if count != EXCLUDED:
            count = keep(cuts, count, add(height, subtract(lb, la)))
    return count


@compiled
def _contract(cuts, n, box):
    """Cuts off what a cut alone refuses; the share of the volume that is left, 0 if that excludes the box."""
    share = 1.0
    for j in range(SYMBOLS):
        low, high = box[0, j], box[1, j]
        if low == high:
            continue
        c, r = 0.5 * (low + high), 0.5 * (high - low)
        left, right = -1.0, 1.0
        for i in range(n):
            s = cuts[i, 1 + j]
            if s == 0.0:
                continue
            edge = (highest(cuts, i) - abs(s) + 4.0 * ROUND) / abs(s)  # cuts have a magnitude of at most 1
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
        share *= max(box[1, j] - box[0, j], _SMALLEST * (high - low)) / (high - low)
    return share


@compiled
def halved(box, cuts, n):  # noqa: ARG001
    """Chooses the edge of a box that is halved: the longest."""
    axis = 0
    for j in range(1, SYMBOLS):
        if box[1, j] - box[0, j] > box[1, axis] - box[0, axis]:
            axis = j
    return axis


@compiled
def _allowed(point, mask, points, count, numbers, cube_limits, pose, work, cuts):
    """Decides whether no cutting point refuses a single design, a box of no size."""
    fill_lengths(point, pose)
    if design_cuts(pose, point, cube_limits, cuts, 0) == EXCLUDED:
        return False
    for i in range(count):  # noqa: SIM110  (compiled code has no generators)
        if mask[i] and point_cuts(points, i, numbers, pose, work, cuts, 0) == EXCLUDED:
            return False
    return True


@compiled
def _by_use(hits, count):
    """Sorts cutting points, those first that excluded most; by insertion, for there are few."""
    order = np.empty(count, dtype=np.int64)
    for n in range(count):
        k = n
        while k > 0 and hits[order[k - 1]] < hits[n]:
            order[k] = order[k - 1]
            k -= 1
        order[k] = n
    return order


@free
def search(boxes, masks, flags, state, points, count, hits, numbers, cube_limits, candidate, budget):
    """Examines up to `budget` boxes, depth first.

    Args:
        boxes: (S, 2, 4) stack of boxes, m.
        masks: (S, POINTS) bytes: which cutting points a box does not yet meet as a whole.
        flags: (S,) 1 where the box's question was answered already.
        state: How many boxes are on the stack, and how many were examined.
        points: (POINTS, 3) cutting points as x, y, height over the bottom face, m.
        count: How many of them there are.
        hits: (POINTS,) how often each excluded a box.
        numbers: `cutting_points.numbers`.
        cube_limits: (4,) see `design_cuts`.
        candidate: (4,) filled with the design of a question.
        budget: Boxes.

    Returns:
        `DONE`; `QUESTION`, the box being on top of the stack; `_STUCK`, likewise.
    """
    cuts, margin, work = np.empty((_CUTS, TERMS)), np.empty((MOST + 20, TERMS)), np.empty((24, TERMS))
    pose, other = np.empty((TABLE, TERMS)), np.empty((TABLE, TERMS))
    u, basis, weight = np.zeros(SYMBOLS), np.zeros(SIZE, dtype=np.int64), np.zeros(SIZE)
    matrix, right = np.empty((SIZE, SIZE)), np.empty(SIZE)
    point = np.empty((2, SYMBOLS))
    order = _by_use(hits, count)
    box, mask = np.empty((2, SYMBOLS)), np.empty(POINTS, dtype=np.uint8)
    while state[0] > 0 and budget > 0:
        budget -= 1
        state[1] += 1
        top = state[0] - 1
        for j in range(SYMBOLS):
            box[0, j], box[1, j] = boxes[top, 0, j], boxes[top, 1, j]
        for i in range(POINTS):
            mask[i] = masks[top, i]
        fill_lengths(box, pose)
        n = design_cuts(pose, box, cube_limits, cuts, 0)
        for i in order:
            if n == EXCLUDED:
                break
            if mask[i] == 0:
                continue
            before = n
            n = point_cuts(points, i, numbers, pose, work, cuts, n)
            if n == EXCLUDED:
                hits[i] += 1
            elif n == before:
                mask[i] = 0
        u[:] = 0.0
        if n == EXCLUDED or (n > 0 and solve(cuts, n, u, basis, weight, matrix, right)):
            state[0] -= 1
            continue
        if not flags[top]:
            for j in range(SYMBOLS):
                c, r = 0.5 * (box[0, j] + box[1, j]), 0.5 * (box[1, j] - box[0, j])
                candidate[j] = min(max(c + r * u[j], box[0, j]), box[1, j])
                point[0, j] = point[1, j] = candidate[j]
            if _allowed(point, mask, points, count, numbers, cube_limits, other, work, margin):
                return QUESTION
        share = _contract(cuts, n, box)
        if share == 0.0:
            state[0] -= 1
            continue
        axis = halved(box, cuts, n)
        if box[1, axis] - box[0, axis] < _SMALLEST:
            return _STUCK
        _write(boxes, masks, flags, top, box, mask)
        if share < _ENOUGH:
            continue
        _write(boxes, masks, flags, top + 1, box, mask)
        middle = 0.5 * (box[0, axis] + box[1, axis])
        boxes[top, 1, axis] = middle
        boxes[top + 1, 0, axis] = middle
        state[0] += 1
    return DONE


@compiled
def _write(boxes, masks, flags, k, box, mask):
    """Writes a box to a place of the stack."""
    for j in range(SYMBOLS):
        boxes[k, 0, j], boxes[k, 1, j] = box[0, j], box[1, j]
    for i in range(POINTS):
        masks[k, i] = mask[i]
    flags[k] = 0
