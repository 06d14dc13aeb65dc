"""What a design must meet at one point of its cube, as cuts over a box of designs.

Each cut is an affine form in L_A, L_B, a = R - r and H that is >= 0 for every design of the box that is feasible; a cut
that is negative in the whole box therefore excludes it. Cuts need not be sharp where a design is infeasible anyway, so
w is taken as a root of what is not negative, and every unit vector may stand for an eigenvector. The limits' own files
say what each cuts; README (5)-(9) beside this file has the derivations.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from delta_cad.common.jit import compiled, unrolled_dispatch
from delta_cad.mechanism.enclosure import pose as forms
from delta_cad.mechanism.enclosure.affine_form import (
    ROUND,
    add,
    at,
    constant,
    inverse_above,
    lower,
    multiply,
    put,
    root_where_feasible,
    scale,
    subtract,
)
from delta_cad.mechanism.enclosure.table import EXCLUDED, INSIDE
from delta_cad.mechanism.geometry import SIN_60, THREE_FOLD
from delta_cad.mechanism.limits import POSE_LIMITS, Limits, PoseLimit

# Rows behind those of a pose: 1 / (2 L_A), L_A^2 - L_B^2, a and H.
HALF, DIFFERENCE, RADII, HEIGHT, SIDE_RADII, OFFSET = range(forms.ROWS, forms.ROWS + 6)
ROWS = forms.ROWS + 6

_CUTTING = tuple(limit for limit in POSE_LIMITS if limit.enclosure.cut is not None)
_START: dict[type[PoseLimit], int] = {}  # place of a limit's numbers; the bits of those in play stand before them
_SIZE = 1
for _limit in _CUTTING:
    _START[_limit], _SIZE = _SIZE, _SIZE + _limit.enclosure.size
_BITS = {limit: 1 << n for n, limit in enumerate(_CUTTING)}
MOST = sum(limit.enclosure.cuts for limit in _CUTTING)  # most cuts of one point


def _cutting(tier: int) -> Any:
    calls = [(limit.enclosure.cut, _BITS[limit], _START[limit]) for limit in _CUTTING if limit.enclosure.tier == tier]
    line = "if limits & {1}:\n        count = {0}(pose, k, {2}, work, cuts, count)\n        if count < 0: return count"
    return unrolled_dispatch("pose, k, limits, work, cuts, count", calls, line, "return count")


_by_chains, _by_forearms = _cutting(forms.CHAINS), _cutting(forms.FOREARMS)
_FOREARMS = sum(_BITS[limit] for limit in _CUTTING if limit.enclosure.tier == forms.FOREARMS)


def numbers(limits: Limits) -> np.ndarray:
    """Gathers the numbers of limits for `point_cuts`.

    Args:
        limits: The limits; one that has a closed form over the cube is left out.

    Returns:
        (n,) numbers.
    """
    out, bits = np.zeros(_SIZE), 0
    for limit in limits:
        kind = type(limit)
        if kind in _BITS:
            bits |= _BITS[kind]
            out[_START[kind] : _START[kind] + kind.enclosure.size] = limit.numbers()
    out[0] = bits
    return out


@compiled
def fill_lengths(box, pose):
    """Fills the forms of the four variables over a box and of what all points share.

    Args:
        box: (2, 4) lower and upper ends of L_A, L_B, a, H, m.
        pose: (`ROWS`, 6) forms of one box.
    """
    la, lb = _between(box, 0), _between(box, 1)
    put(pose, forms.UPPER_ARM, la)
    put(pose, forms.FOREARM_LENGTH, lb)
    put(pose, RADII, _between(box, 2))
    put(pose, HEIGHT, _between(box, 3))
    put(pose, HALF, inverse_above(scale(2.0, la), box[0, 0]))
    put(pose, DIFFERENCE, multiply(subtract(la, lb), add(la, lb)))
    put(pose, forms.UPPER_ARM_2, multiply(la, la))
    put(pose, forms.FOREARM_2, multiply(lb, lb))
    forms.put_azimuth(pose, constant(THREE_FOLD, 0.0), constant(SIN_60, forms.SIN_60_ERROR), constant(0.75, 0.0))


@compiled
def _between(box, j):
    c, r = 0.5 * (box[0, j] + box[1, j]), 0.5 * (box[1, j] - box[0, j])
    e = ROUND * (abs(c) + r)
    if box[0, j] == box[1, j]:
        c, r, e = box[0, j], 0.0, 0.0
    return (c, r if j == 0 else 0.0, r if j == 1 else 0.0, r if j == 2 else 0.0, r if j == 3 else 0.0, e)


@compiled
def fill_chains(x_m, y_m, height, pose):
    """Fills the chains at a point; w and the forearms for designs that are closed."""
    z = add(at(pose, HEIGHT), constant(height, 0.0))
    forms.put_wrists(pose, constant(x_m, 0.0), constant(y_m, 0.0), z)
    zz, low = multiply(z, z), lower(z)
    la, half, difference = at(pose, forms.UPPER_ARM), at(pose, HALF), at(pose, DIFFERENCE)
    for i in range(3):
        q, t = subtract(at(pose, forms.Q + i), at(pose, RADII)), at(pose, forms.T + i)
        put(pose, forms.Q + i, q)
        rho2 = add(multiply(q, q), zz)
        m = multiply(half, add(add(rho2, multiply(t, t)), difference))
        w2 = subtract(rho2, multiply(m, m))
        part = multiply(la, inverse_above(rho2, low * low * INSIDE))
        forms.put_chain(pose, i, m, w2, root_where_feasible(w2), part)


@compiled
def point_cuts(points, n, k, pose, work, cuts, count):
    """Appends what designs must meet at one point.

    Args:
        points: (.., 3) x, y, and height over the cube's bottom face, m.
        n: Which of them.
        k: `numbers`.
        pose: (`ROWS`, 6) forms of one box, with its lengths in it.
        work: (24, 6) room.
        cuts: (.., 6) room for at most `MOST` more.
        count: How many cuts there are.

    Returns:
        How many there are now, or `EXCLUDED`.
    """
    limits = int(k[0])
    fill_chains(points[n, 0], points[n, 1], points[n, 2], pose)
    count = _by_chains(pose, k, limits, work, cuts, count)
    if count == EXCLUDED or not limits & _FOREARMS:
        return count
    forms.fill_forearms(pose)
    return _by_forearms(pose, k, limits, work, cuts, count)
