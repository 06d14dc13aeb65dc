"""Forces on the handle at many states at once; every formula is that of the compiled kernel in `laws`.

The functions are for figures, maps and tests; the loop calls `laws.total_force` on a table of rows. Forces are before
saturation. Importing this module loads numba.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from haptics.rendering.kernel import energies_into, forces_into
from haptics.rendering.laws import (
    RESISTANCE_BLEND,
    WALL_BLEND,
    LawError,
    constant_row,
    home_row,
    law_table,
    resistance_row,
    spring_row,
    wall_row,
)

AT_REST = (0.0, 0.0, 0.0)
"""No velocity, m/s."""


def force(laws: ArrayLike, p: ArrayLike, v: ArrayLike = AT_REST) -> np.ndarray:
    """Force of a combination of laws on the handle.

    Args:
        laws: (n, 12) table, or one (12,) row.
        p: (..., 3) position in the base frame, m.
        v: (..., 3) velocity, m/s; p and v are broadcast.

    Returns:
        (..., 3) N in the base frame.

    Raises:
        LawError: The table is refused, or p or v does not end in an axis of 3 or is not finite.
    """
    table = law_table(laws)
    at, moving = np.broadcast_arrays(_vectors("p", p), _vectors("v", v))
    out = np.empty(at.shape)
    forces_into(table, _flat(at), _flat(moving), out.reshape(-1, 3))
    return out


def stored_energy(laws: ArrayLike, p: ArrayLike) -> np.ndarray:
    """Energy that a combination of laws stores; minus its gradient is `force` at rest.

    Args:
        laws: (n, 12) table, or one (12,) row.
        p: (..., 3) position in the base frame, m.

    Returns:
        (...) J; see `laws.total_energy` for its zero.

    Raises:
        LawError: The table is refused, or p does not end in an axis of 3 or is not finite.
    """
    table, at = law_table(laws), _vectors("p", p)
    out = np.empty(at.shape[:-1])
    energies_into(table, _flat(at), out.reshape(-1))
    return out


def operating_resistance(
    p: ArrayLike,
    v: ArrayLike = AT_REST,
    *,
    stiffness: float,
    damping: float,
    dead_radius: float,
    full_radius: float,
    origin: ArrayLike = (0.0, 0.0, 0.0),
    blend: float = RESISTANCE_BLEND,
) -> np.ndarray:
    """Operating resistance: nothing near the origin, then a spring towards it that becomes a constant pull.

    With d the distance from the origin and e the unit vector towards it: 0 for d < r0; `k (d - r0) e - b s v` up to r1;
    `k (r1 - r0) e - b s v` beyond; s = min(1, (d - r0) / blend).

    Args:
        p: (..., 3) position in the base frame, m.
        v: (..., 3) velocity, m/s; p and v are broadcast.
        stiffness: k, N/m, at least 0.
        damping: b as applied, N s/m, at least 0.
        dead_radius: r0, m, at least 0.
        full_radius: r1, m, more than r0.
        origin: (3,) base frame, m.
        blend: Way beyond r0 over which the damping fades in, m, positive.

    Returns:
        (..., 3) N on the handle.

    Raises:
        LawError: A figure is out of its bounds, or p or v does not end in an axis of 3 or is not finite.

    Source:
        [RCIM2018] eq. (23), where the damping switches on at r0: a step of b v.
    """
    row = resistance_row(
        stiffness=stiffness,
        damping=damping,
        dead_radius=dead_radius,
        full_radius=full_radius,
        origin=origin,
        blend=blend,
    )
    return force(row, p, v)


def spring_damper(
    p: ArrayLike, v: ArrayLike = AT_REST, *, stiffness: float, damping: float, point: ArrayLike
) -> np.ndarray:
    """Spring and damper to a point: `k (point - p) - b v`.

    Args:
        p: (..., 3) position in the base frame, m.
        v: (..., 3) velocity, m/s; p and v are broadcast.
        stiffness: k, N/m, at least 0.
        damping: b as applied, N s/m, at least 0.
        point: (3,) base frame, m.

    Returns:
        (..., 3) N on the handle.

    Raises:
        LawError: A figure is out of its bounds, or p or v does not end in an axis of 3 or is not finite.
    """
    return force(spring_row(stiffness=stiffness, damping=damping, point=point), p, v)


def constant_force(p: ArrayLike, constant: ArrayLike) -> np.ndarray:
    """The same force everywhere.

    Args:
        p: (..., 3) position in the base frame, m; only its shape counts.
        constant: (3,) N on the handle.

    Returns:
        (..., 3) N on the handle.

    Raises:
        LawError: The force is not three finite numbers, or p does not end in an axis of 3 or is not finite.
    """
    return force(constant_row(constant), p)


def home(
    p: ArrayLike,
    v: ArrayLike = AT_REST,
    *,
    stiffness: float,
    damping: float,
    speed: float,
    origin: ArrayLike = (0.0, 0.0, 0.0),
) -> np.ndarray:
    """Home function: brings the handle to the origin, no faster than the speed limit; derived in `rows.home_row`.

    Args:
        p: (..., 3) position in the base frame, m.
        v: (..., 3) velocity, m/s; p and v are broadcast.
        stiffness: k near the origin, N/m, positive.
        damping: b as applied, N s/m, positive.
        speed: Speed limit, m/s, positive.
        origin: (3,) base frame, m.

    Returns:
        (..., 3) N on the handle; at rest at most `b speed`.

    Raises:
        LawError: A figure is out of its bounds, or p or v does not end in an axis of 3 or is not finite.
    """
    return force(home_row(stiffness=stiffness, damping=damping, speed=speed, origin=origin), p, v)


def virtual_wall(
    p: ArrayLike,
    v: ArrayLike = AT_REST,
    *,
    stiffness: float,
    point: ArrayLike,
    normal: ArrayLike,
    damping: float = 0.0,
    blend: float = WALL_BLEND,
) -> np.ndarray:
    """Virtual wall in any plane: `n max(0, K x - b s n . v)` at the depth x > 0, nothing outside.

    The damping fades in with the depth, s = min(1, x / blend), so that a touch-down at speed makes no step.

    Args:
        p: (..., 3) position in the base frame, m.
        v: (..., 3) velocity, m/s; p and v are broadcast.
        stiffness: K_e, N/m, at least 0.
        point: (3,) any point of the plane, base frame, m.
        normal: (3,) n towards the free side; any length but 0.
        damping: b as applied, N s/m, at least 0.
        blend: Depth over which the damping fades in, m, positive.

    Returns:
        (..., 3) N on the handle, never towards the wall.

    Raises:
        LawError: A figure is out of its bounds, or p or v does not end in an axis of 3 or is not finite.

    Source:
        [RCIM2018] eq. (24), which is the force on the wall, with damping in contact.
    """
    row = wall_row(stiffness=stiffness, damping=damping, point=point, normal=normal, blend=blend)
    return force(row, p, v)


def _vectors(field: str, value: ArrayLike) -> np.ndarray:
    array = np.asarray(value, dtype=float)
    if array.ndim == 0 or array.shape[-1] != 3:
        raise LawError(f"{field} has the shape {array.shape}; its last axis must be 3")
    if not np.isfinite(array).all():
        raise LawError(f"{field} holds {array[~np.isfinite(array)][0]!r}; it must be finite")
    return array


def _flat(array: np.ndarray) -> np.ndarray:
    return np.array(array, order="C").reshape(
        -1, 3
    )  # a copy: broadcast arrays are not writeable, another type to numba
