"""Margins over a box as they are stored: the list of a proof's margins, and the list of cuts of a box of designs."""

from __future__ import annotations

import math
from typing import Any, NamedTuple

from delta_cad.common.jit import compiled, unrolled_dispatch
from delta_cad.mechanism.enclosure.affine_form import SYMBOLS, lower, slope, upper

# Columns of the list of margins: both bounds, the form's centre, and from 3 on its slopes in x, y, z.
LOW, HIGH, CENTRE = 0, 1, 2
COLUMNS = 6
EXCLUDED = -1  # stands in the place of a count of cuts where no design of the box meets one of them
INSIDE = 1.0 - 2.0**-50  # Shortens a normalised vector to a length of at most 1.


@compiled
def store(out, row, form):
    """Writes a margin that is one form into (n, 6) margins of a proof."""
    out[row, 0], out[row, 1] = lower(form), upper(form)
    out[row, 2], out[row, 3], out[row, 4], out[row, 5] = form[0], form[1], form[2], form[3]


@compiled
def keep(cuts, count, form):
    """Takes a cut in, scaled by a power of two, unless it is met in the whole box; `EXCLUDED` if nowhere.

    Args:
        cuts: (.., 6) room.
        count: How many cuts there are.
        form: Not negative for every feasible design of the box.

    Returns:
        How many there are now, or `EXCLUDED`.
    """
    if upper(form) < 0.0:
        return EXCLUDED
    if lower(form) >= 0.0:
        return count
    size = abs(form[0]) + slope(form) + form[SYMBOLS + 1]
    if not size < math.inf:
        return count
    f = math.ldexp(1.0, -math.frexp(size)[1])
    for i in range(SYMBOLS + 2):
        cuts[count, i] = f * form[i]
    return count + 1


class Enclosure(NamedTuple):
    """How a limit is decided over boxes: its compiled functions and what they read and fill.

    Attributes:
        tier: How much of the mechanism's table it reads, see `pose`.
        size: Numbers that it takes.
        rows: Margins that it fills.
        margins: (pose, k, n, work, out, row), fills its margins over a box; `k[n:]` are its numbers, row its first.
        cut: (pose, k, n, work, cuts, count) -> count: what a feasible design must meet at one position, as forms over a
            box of designs; `EXCLUDED` where none can. None where a closed form says it for the whole cube.
        cuts: Most forms that `cut` adds.
    """

    tier: int
    size: int
    rows: int
    margins: Any
    cut: Any = None
    cuts: int = 0


def enclosure_of(margin: Any, tier: int, size: int, rows: int = 3) -> Enclosure:
    """Compiles the enclosure of a limit whose cuts are its margins, one a chain as a rule.

    Args:
        margin: Compiled (pose, k, n, i) -> form, not negative where chain i keeps the limit.
        tier: How much of the mechanism's table it reads.
        size: Numbers that it takes.
        rows: Margins.
    """
    calls = [(margin, i) for i in range(rows)]
    form = "{0}(pose, k, n, {1})"
    cut = f"count = keep(cuts, count, {form})\n    if count < 0: return count"
    margins = unrolled_dispatch("pose, k, n, work, out, row", calls, f"store(out, row + {{1}}, {form})", store=store)
    cuts = unrolled_dispatch("pose, k, n, work, cuts, count", calls, cut, "return count", keep=keep)
    return Enclosure(tier, size, rows, margins, cuts, rows)
