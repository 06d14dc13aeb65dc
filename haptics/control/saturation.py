"""Torque within its limits: gravity has priority, then the force, as far as its direction can be kept.

With g the torque that holds the device, f = J^T F that of the wanted force and l the limits, the torque is `g + c f`
with the largest c in [0, 1] for which `|g_i + c f_i| <= l_i`. Each joint allows `c <= (l_i - g_i) / f_i` for f_i > 0
and `c <= (l_i + g_i) / -f_i` for f_i < 0, so that

    c = min(1, min_i (l_i - sign(f_i) g_i) / |f_i|)

One factor for all joints keeps the direction of the force at the handle, since f is linear in F: c F is what is
applied. A joint that gravity alone takes beyond its limit leaves nothing to give away: gravity is clipped there and
c = 0. Importing this module loads numba.
"""

from __future__ import annotations

import math

from delta_cad.common.jit import compiled


@compiled
def saturate(gravity, force_torque, limit, out):
    """Computes the torques that hold the device and give as much of the wanted force as the joints can.

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
        elif abs(push) > 0.0:
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
