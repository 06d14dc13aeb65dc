"""Torque within its limits: gravity is served first, then the force as far as its direction can be kept.

With g the torque that holds the device, f = J^T F that of the wanted force and l the limits, the torque is `g + c f`
with the largest c in [0, 1] for which `|g_i + c f_i| <= l_i`. Each joint allows `c <= (l_i - g_i) / f_i` for f_i > 0
and `c <= (l_i + g_i) / -f_i` for f_i < 0, so that

    c = min(1, min_i (l_i - sign(f_i) g_i) / |f_i|)

One factor for all joints scales the force at the handle as a whole, since f is linear in F: c F is what is applied. A
joint that gravity alone takes beyond its limit leaves nothing to give away: gravity is clipped there and c = 0.
Importing this module loads numba.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from delta_cad.common.jit import compiled


class Saturated(NamedTuple):
    """Torque within the limits.

    Attributes:
        torque: (..., 3 chains) N m.
        factor: (...) share of the wanted force that is applied, 0 to 1.
    """

    torque: np.ndarray
    factor: np.ndarray


@compiled
def saturate(gravity, force_torque, limit, out):
    """One state.

    Args:
        gravity: (3,) torque that holds the device, N m.
        force_torque: (3,) J^T F, N m.
        limit: (3,) largest torque of each joint, peak or continuous, N m, not negative.
        out: (3,) filled with the torque, N m; may be `gravity` or `force_torque`.

    Returns:
        The factor of the force, 0 to 1. It is 0 where gravity alone exceeds a limit (gravity is clipped there), and
        where a torque is not a number or a force torque not finite; a gravity torque that is not a number counts as 0.
    """
    factor = 1.0
    served = True
    for i in range(3):
        hold, push, top = gravity[i], force_torque[i], limit[i]
        if not (abs(hold) <= top and math.isfinite(push)):
            served = False
        elif push != 0.0:
            room = top - hold if push > 0.0 else top + hold
            factor = min(factor, room / abs(push))
    if not served:
        factor = 0.0
    for i in range(3):
        torque = 0.0 if math.isnan(gravity[i]) else gravity[i]
        if factor > 0.0:
            torque += factor * force_torque[i]
        out[i] = min(max(torque, -limit[i]), limit[i])  # of the sum's rounding, where gravity is within its limit
    return factor


@compiled
def _saturate_all(gravity, force_torque, limit, out, factor):
    for j in range(out.shape[0]):
        factor[j] = saturate(gravity[j], force_torque[j], limit[j], out[j])


def saturated(gravity: ArrayLike, force_torque: ArrayLike, limit: ArrayLike) -> Saturated:
    """Torque that holds the device and gives as much of the wanted force as the joints can, in its direction.

    Args:
        gravity: (..., 3 chains) torque that holds the device, N m.
        force_torque: (..., 3 chains) J^T F of the wanted force, N m.
        limit: (..., 3 chains) or one figure for all: largest torque of a joint, peak or continuous, N m.

    Returns:
        Torque and factor; the three arguments are broadcast.

    Raises:
        ValueError: A torque is not finite, a limit is not finite or negative, or the last axis is not 3.
    """
    fields = {"gravity": gravity, "force_torque": force_torque, "limit": limit}
    arrays = {name: np.asarray(value, dtype=float) for name, value in fields.items()}
    for name, array in arrays.items():
        bad = ~np.isfinite(array) | ((array < 0.0) if name == "limit" else False)
        if bad.any():
            rule = "finite and not negative" if name == "limit" else "finite"
            raise ValueError(f"{name} holds {float(array[bad][0])!r} N m; it must be {rule}")
        if array.shape[-1:] != (3,) and not (name == "limit" and array.ndim == 0):
            raise ValueError(f"{name} has the shape {array.shape}; its last axis must be the 3 chains")
    shape = np.broadcast_shapes(*(array.shape for array in arrays.values()))
    g, f, top = (np.array(np.broadcast_to(a, shape), order="C").reshape(-1, 3) for a in arrays.values())
    out, factor = np.empty(shape), np.empty(shape[:-1])
    _saturate_all(g, f, top, out.reshape(-1, 3), factor.reshape(-1))
    return Saturated(out, factor)
