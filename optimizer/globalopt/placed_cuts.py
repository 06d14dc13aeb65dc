"""Cuts of designs whose placement is free: what differs from those of three-fold symmetric ones, compiled.

A box has seven variables: L_A, L_B, a = R_0 - r, H, R_1 - R_0, the cosine c of the azimuth and x_c. README (13)-(15) of
this package.
"""

from __future__ import annotations

import numpy as np

from delta_cad.common.jit import compiled
from delta_cad.mechanism.enclosure import pose as forms
from delta_cad.mechanism.enclosure.affine_form import (
    ROUND,
    add,
    at,
    constant,
    inverse,
    inverse_above,
    lower,
    magnitude,
    multiply,
    put,
    root,
    root_where_feasible,
    scale,
    subtract,
)
from delta_cad.mechanism.enclosure.table import EXCLUDED, INSIDE, keep
from optimizer.globalopt import branch_and_bound, cutting_points, dual_simplex, forms_of_seven
from optimizer.globalopt.cutting_points import DIFFERENCE, HALF, HEIGHT, OFFSET, RADII, SIDE_RADII
from optimizer.globalopt.dual_simplex import SIZE
from optimizer.globalopt.forms_of_seven import of_seven

_SHIFT, _COSINE, _CENTRE = 4, 5, 6  # places of what is placed in a box
OUTWARDS = 1e-12
"""Share by which closed forms over a box, some twenty roundings of 1e-16, are moved outwards."""


@compiled
def _between(box, j):
    """The form of a variable over a box."""
    c, r = 0.5 * (box[0, j] + box[1, j]), 0.5 * (box[1, j] - box[0, j])
    e = ROUND * (abs(c) + r)
    if box[0, j] == box[1, j]:
        c, r, e = box[0, j], 0.0, 0.0
    return (
        c,
        r if j == 0 else 0.0,
        r if j == 1 else 0.0,
        r if j == 2 else 0.0,
        r if j == 3 else 0.0,
        r if j == 4 else 0.0,
        r if j == 5 else 0.0,
        r if j == 6 else 0.0,
        e,
    )


@compiled
def _fill_lengths(box, pose):
    """Fills the forms of the seven variables over a box and of what all points share."""
    la, lb, a, cosine = _between(box, 0), _between(box, 1), _between(box, 2), _between(box, _COSINE)
    put(pose, forms.UPPER_ARM, la)
    put(pose, forms.FOREARM_LENGTH, lb)
    put(pose, RADII, a)
    put(pose, HEIGHT, _between(box, 3))
    put(pose, SIDE_RADII, add(a, _between(box, _SHIFT)))
    put(pose, OFFSET, _between(box, _CENTRE))
    put(pose, HALF, inverse_above(scale(2.0, la), box[0, 0]))
    put(pose, DIFFERENCE, multiply(subtract(la, lb), add(la, lb)))
    put(pose, forms.UPPER_ARM_2, multiply(la, la))
    put(pose, forms.FOREARM_2, multiply(lb, lb))
    square = multiply(subtract(constant(1.0, 0.0), cosine), add(constant(1.0, 0.0), cosine))
    forms.put_azimuth(pose, cosine, root(square), square)


@compiled
def _fill_chains(x_m, y_m, height, pose):
    """Fills the chains at a point; w and the forearms for designs that are closed."""
    x, z = add(at(pose, OFFSET), constant(x_m, 0.0)), add(at(pose, HEIGHT), constant(height, 0.0))
    y = constant(y_m, 0.0)
    forms.put_wrists(pose, x, y, z)
    zz, low = multiply(z, z), lower(z)
    flat = add(add(multiply(x, x), multiply(y, y)), zz)
    la, half, difference = at(pose, forms.UPPER_ARM), at(pose, HALF), at(pose, DIFFERENCE)
    for i in range(3):
        a = at(pose, RADII) if i == 0 else at(pose, SIDE_RADII)
        u = at(pose, forms.Q + i)
        q = subtract(u, a)
        put(pose, forms.Q + i, q)
        rho2 = add(multiply(q, q), zz)
        square = add(flat, multiply(a, subtract(a, scale(2.0, u))))
        m = multiply(half, add(square, difference))
        w2 = subtract(rho2, multiply(m, m))
        part = multiply(la, inverse_above(rho2, low * low * INSIDE))
        forms.put_chain(pose, i, m, w2, root_where_feasible(w2), part)


@compiled
def _outline_cuts(pose, box, k, platform, cuts, count):
    """Adds that `R_0 = a + r` fits the outline, for an r that is at least a form.

    Args:
        pose: The table.
        box: (2, 7) the box.
        k: As of `_design_cuts`.
        platform: Least r; or, with a taken off, least R_0.
        cuts: Room.
        count: How many cuts there are.
    """
    c, s = at(pose, forms.COSINE), at(pose, forms.SINE)
    reach, shift = add(platform, at(pose, forms.UPPER_ARM)), subtract(at(pose, SIDE_RADII), at(pose, RADII))
    if k[6] < np.inf:
        count = keep(cuts, count, subtract(constant(k[6], ROUND * k[6]), reach))
        if count == EXCLUDED:
            return count
        return keep(cuts, count, subtract(constant(k[6], ROUND * k[6]), add(reach, shift)))
    if not k[3] < np.inf:
        return count
    level = constant(0.0, 0.0)  # |c| at least
    if box[1, _COSINE] <= 0.0:
        level = scale(-1.0, c)
    elif box[0, _COSINE] >= 0.0:
        level = c
    wide = add(scale(k[5], level), scale(2.0, multiply(s, add(reach, shift))))
    count = keep(cuts, count, subtract(constant(k[3], OUTWARDS * k[3]), wide))
    if count == EXCLUDED:
        return count
    deep = add(scale(0.5 * k[5], s), subtract(multiply(subtract(constant(1.0, 0.0), c), reach), multiply(c, shift)))
    return keep(cuts, count, subtract(constant(k[4], OUTWARDS * k[4]), deep))


@compiled
def _design_cuts(pose, box, k, cuts, count):
    """Adds what holds for the whole cube in closed form: outline, clearance, lean, level elbows, fold over a shoulder.

    Args:
        pose: The table, with the box's lengths in it.
        box: (2, 7) the box.
        k: L; of the wrists joint and clearance together, and L_c; width and depth allowed, and L_c of the outline;
            largest R_i + L_A; bounds of r and of R_0; sine of the largest lean; 0 where elbows have to be outside; m.
        cuts: Room.
        count: How many cuts there are.
    """
    la, lb, height, a = at(pose, forms.UPPER_ARM), at(pose, forms.FOREARM_LENGTH), at(pose, HEIGHT), at(pose, RADII)
    c, s, one, side = at(pose, forms.COSINE), at(pose, forms.SINE), constant(1.0, 0.0), k[0]
    error = ROUND * (k[8] + k[10])
    count = _outline_cuts(pose, box, k, constant(k[9], error), cuts, count)
    if count != EXCLUDED:
        count = _outline_cuts(pose, box, k, add(a, constant(k[7], error)), cuts, count)
    if count != EXCLUDED:
        count = keep(cuts, count, subtract(constant(k[10] - k[7], error), a))
    if count != EXCLUDED and k[1] > -np.inf:
        # of chains 0 and 1: sqrt(2 - 2 c) r >= joint + sqrt((1 + c) / 2) L_c
        near = multiply(
            add(constant(k[1], OUTWARDS * k[1]), scale(k[2], root(scale(0.5, add(one, c))))),
            inverse(root(scale(2.0, subtract(one, c)))),
        )
        count = _outline_cuts(pose, box, k, add(a, near), cuts, count)
        if count != EXCLUDED:
            count = keep(cuts, count, subtract(constant(k[8], error), near))
        if count != EXCLUDED:
            count = keep(cuts, count, subtract(subtract(constant(k[10], error), near), a))
        if count != EXCLUDED:  # of chains 1 and 2: 2 s r >= joint + |c| L_c
            level = constant(0.0, 0.0)
            if box[1, _COSINE] <= 0.0:
                level = scale(-1.0, c)
            elif box[0, _COSINE] >= 0.0:
                level = c
            back = multiply(add(constant(k[1], OUTWARDS * k[1]), scale(k[2], level)), inverse(scale(2.0, s)))
            count = _outline_cuts(pose, box, k, add(a, back), cuts, count)
            if count != EXCLUDED:
                count = keep(cuts, count, subtract(constant(k[8], error), back))
            if count != EXCLUDED:
                count = keep(cuts, count, subtract(subtract(constant(k[10], error), back), a))
    if count != EXCLUDED and k[12] == 0.0:
        count = keep(cuts, count, add(la, a))
        if count != EXCLUDED:
            count = keep(cuts, count, add(la, at(pose, SIDE_RADII)))
    if count != EXCLUDED and k[11] > 0.0:
        level, far = constant(0.0, 0.0), constant(0.0, 0.0)
        if box[1, _COSINE] <= 0.0:
            level = scale(-1.0, c)
        elif box[0, _COSINE] >= 0.0:
            level = c
        if box[0, _CENTRE] >= 0.0:
            far = at(pose, OFFSET)
        elif box[1, _CENTRE] <= 0.0:
            far = scale(-1.0, at(pose, OFFSET))
        across = add(scale(side, add(s, level)), multiply(s, far))
        count = keep(cuts, count, subtract(scale(k[11], lb), across))
    if count != EXCLUDED and _folds(pose, box, side):
        count = keep(cuts, count, add(height, subtract(la, lb)))
        if count != EXCLUDED:
            count = keep(cuts, count, add(height, subtract(lb, la)))
    return count


@compiled
def _folds(pose, box, side):
    """Whether a shoulder, moved in by r, is under the cube of every design of a box: there the chain can fold."""
    inside = side * (1.0 - OUTWARDS)
    first = max(abs(box[0, 2] - box[1, _CENTRE]), abs(box[1, 2] - box[0, _CENTRE]))
    if first <= inside:
        return True
    a = at(pose, SIDE_RADII)
    along = subtract(multiply(a, at(pose, forms.COSINE)), at(pose, OFFSET))
    across = multiply(a, at(pose, forms.SINE))
    return max(magnitude(along), magnitude(across)) <= inside


@compiled
def _halved(box, cuts, n):
    """Chooses the edge along which the cuts change most, for a cosine and a length have no common measure."""
    axis, most = 0, -1.0
    for j in range(7):
        change = 0.0
        for i in range(n):
            change += abs(cuts[i, 1 + j])
        if change > most and box[0, j] < box[1, j]:
            axis, most = j, change
    return axis


@compiled
def _highest(cuts, k):
    """As `dual_simplex.highest`."""
    total = cuts[k, 0] + cuts[k, 8]
    for j in range(1, 8):
        total += abs(cuts[k, j])
    return total


@compiled
def _excluded(cuts, count, basis, weight):
    """As `dual_simplex.excluded`."""
    c = s1 = s2 = s3 = s4 = s5 = s6 = s7 = e = total = 0.0
    for n in range(SIZE):
        k, f = basis[n], weight[n]
        if k >= count or not f > 0.0:
            continue
        c, s1, s2 = c + f * cuts[k, 0], s1 + f * cuts[k, 1], s2 + f * cuts[k, 2]
        s3, s4, s5 = s3 + f * cuts[k, 3], s4 + f * cuts[k, 4], s5 + f * cuts[k, 5]
        s6, s7, e = s6 + f * cuts[k, 6], s7 + f * cuts[k, 7], e + f * cuts[k, 8]
        for j in range(8):
            total += f * abs(cuts[k, j])
    top = c + (abs(s1) + abs(s2) + abs(s3) + abs(s4) + abs(s5) + abs(s6) + abs(s7)) + e
    # eight products and sums to each number, and eight more: 25 roundings of the magnitudes, covered by 64
    return top + 4.0 * ROUND * (total + e) < 0.0


forms_of_seven.number("SIZE", forms_of_seven.SYMBOLS + 1)
forms_of_seven.own(_between)
for _first, _own in (
    (cutting_points.fill_lengths, _fill_lengths),
    (cutting_points.fill_chains, _fill_chains),
    (branch_and_bound.design_cuts, _design_cuts),
    (branch_and_bound.halved, _halved),
    (dual_simplex.highest, _highest),
    (dual_simplex.excluded, _excluded),
):
    forms_of_seven.stands_for(_first, of_seven(_own))
search_placed = of_seven(branch_and_bound.search)
