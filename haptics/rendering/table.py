"""Tables of force laws: any combination of laws is one compiled loop, in Python and in C.

The loop trusts p and v to be finite (the supervisor sees to it). A row of unknown kind gives no force. Importing this
module loads numba.

Continuity. Between two states whose speeds do not exceed V each law obeys
`|F1 - F2| <= (k + b V / blend) |p1 - p2| + b |v1 - v2|`, without the middle term for spring and home. The pull of the
resistance is radial with a slope of 0 or k and, across, `k (min(d, r1) - r0) / d <= k`; home is the projection of k q
on the ball of radius b speed, which brings points no further apart; `s1 v1 - s2 v2 = s1 (v1 - v2) + (s1 - s2) v2` with
the slope 1 / blend of the fade s; and max(0, .) does not stretch. Six walls of a cube obey it as one does: opposite
walls are never touched together, and the others act along different axes.

Energy. The force at rest is minus the gradient of `total_energy`, and what v adds never does work on the hand:
`(F(p, v) - F(p, 0)) . v <= 0`, for the wall too, where the maximum can only take from the damping what would have
pulled. So with damping not negative no law gives in continuous time more than is stored. A gain that rises by dg gives
at most dg times the stored energy; that, and the home function's own store, is what a handle that is brought home gets.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from delta_cad.common.jit import compiled
from haptics.rendering.law import FIRST, GAIN, KIND, ForceLaw, LawError
from haptics.rendering.registry import COLUMNS, LAWS, energy_of, force_of
from haptics.rendering.states import AT_REST, flat, forces, vectors

_KIND_OF = {law.parameters: kind for kind, law in LAWS.items()}


@compiled
def total_force(laws, px, py, pz, vx, vy, vz):
    """Force of all laws on the handle.

    Args:
        laws: (n, COLUMNS) table.
        px: Position along x in the base frame, m.
        py: Along y, m.
        pz: Along z, m.
        vx: Velocity along x, m/s.
        vy: Along y, m/s.
        vz: Along z, m/s.

    Returns:
        fx, fy, fz: N in the base frame, before saturation.
    """
    sx = sy = sz = 0.0
    for i in range(laws.shape[0]):
        fx, fy, fz = force_of(laws, i, px, py, pz, vx, vy, vz)
        gain = laws[i, GAIN]
        sx += gain * fx
        sy += gain * fy
        sz += gain * fz
    return sx, sy, sz


@compiled
def total_energy(laws, px, py, pz):
    """Energy stored by all laws at a position: minus its gradient is `total_force` at rest.

    Args:
        laws: (n, COLUMNS) table.
        px: Position along x in the base frame, m.
        py: Along y, m.
        pz: Along z, m.

    Returns:
        J; each law's own text says where it is 0.
    """
    energy = 0.0
    for i in range(laws.shape[0]):
        energy += laws[i, GAIN] * energy_of(laws, i, px, py, pz)
    return energy


@compiled
def _forces_into(laws, p, v, out):
    for j in range(p.shape[0]):
        out[j, 0], out[j, 1], out[j, 2] = total_force(laws, p[j, 0], p[j, 1], p[j, 2], v[j, 0], v[j, 1], v[j, 2])


@compiled
def _energies_into(laws, p, out):
    for j in range(p.shape[0]):
        out[j] = total_energy(laws, p[j, 0], p[j, 1], p[j, 2])


@compiled
def fade(gain, target, step):
    """The gain of a law one tick later, so that a law that is switched on or off makes no step.

    Args:
        gain: Now.
        target: 1 to switch on, 0 to switch off.
        step: Largest change in a tick: the period over the time of the fade.

    Returns:
        The gain; the force of the law then changes in a tick by at most `step` times itself, besides what p and v do.
    """
    if gain < target:
        return min(target, gain + step)
    return max(target, gain - step)


def law_table(*laws: ForceLaw | ArrayLike) -> np.ndarray:
    """Table of laws, as the compiled loop takes it.

    Args:
        laws: Laws, at gain 1, and tables, (COLUMNS,) or (n, COLUMNS); none for no force.

    Returns:
        (n, COLUMNS) table, contiguous.

    Raises:
        LawError: A row has another length or kind, holds a number that is not finite, or a gain outside 0 to 1.
    """
    table = np.empty((0, COLUMNS))
    for given in laws:
        block = _row(given) if isinstance(given, ForceLaw) else np.asarray(given, dtype=float)
        block = np.atleast_2d(block)
        if block.ndim != 2 or block.shape[1] != COLUMNS:
            raise LawError(f"a row of laws has the shape {np.shape(given)}; it must be ({COLUMNS},) or (n, {COLUMNS})")  # pyright: ignore
        table = np.vstack([table, block])
    for i, row in enumerate(table):
        if not np.isfinite(row).all():
            raise LawError(f"law {i} holds {row[~np.isfinite(row)][0]!r}; its parameters must be finite")
        if row[KIND] not in LAWS:
            raise LawError(f"law {i} is of kind {row[KIND]:g}; it must be one of {', '.join(map(str, LAWS))}")
        if not 0.0 <= row[GAIN] <= 1.0:
            raise LawError(f"law {i} has gain {row[GAIN]!r}; it must be between 0 and 1")
    return np.ascontiguousarray(table)


def force(laws: ForceLaw | ArrayLike, p: ArrayLike, v: ArrayLike = AT_REST) -> np.ndarray:
    """Force of one law, or of a table of them, on the handle.

    Args:
        laws: A law, or an (n, COLUMNS) table.
        p: (..., 3) position in the base frame, m.
        v: (..., 3) velocity, m/s; p and v are broadcast.

    Returns:
        (..., 3) N in the base frame, before saturation.

    Raises:
        LawError: The table is refused, or p or v does not end in an axis of 3 or is not finite.
    """
    return forces(_forces_into, law_table(laws), p, v)


def stored_energy(laws: ForceLaw | ArrayLike, p: ArrayLike) -> np.ndarray:
    """Energy that one law, or a table of them, stores; minus its gradient is `force` at rest.

    Args:
        laws: A law, or an (n, COLUMNS) table.
        p: (..., 3) position in the base frame, m.

    Returns:
        (...) J; each law's own text says where it is 0.

    Raises:
        LawError: The table is refused, or p does not end in an axis of 3 or is not finite.
    """
    at = vectors("p", p)
    out = np.empty(at.shape[:-1])
    _energies_into(law_table(laws), flat(at), out.reshape(-1))
    return out


def _row(law: ForceLaw) -> np.ndarray:
    values, row = law.values(), np.zeros(COLUMNS)
    row[KIND], row[GAIN], row[FIRST : FIRST + len(values)] = _KIND_OF[type(law)], 1.0, values
    return row
