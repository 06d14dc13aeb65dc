"""Largest stable wall at a pose: the closed form by which a tick limits every virtual wall.

A sampled wall takes energy away by the device's friction and the wall's damping and gives some by what a sample costs,
half a period, delay and current lag: `b + B >= K (T / 2 + delay + lag)`, whatever hand holds it (`loop.walls`).
Friction at the handle along n is that of the joints over `q = |J^T n|^2`, and J is known at every tick, so

    K <= share (friction / q + B) / cost

Damping is rendered late, too, through the filter of the rates, and gives energy where little mass is behind it: it is
held to `MAX_DAMPING_RATIO inertia / (q late)`, since at the frequencies where it turns round the knob swings on the
structure and only the joints are left. Up to that, at least the loop's own damping is given to each wall, within its
blend.

Simultaneous contacts share the joints' friction: with `m = J^T n` of each they are stable while no
eigenvalue of `sum (K cost - B) m m^T` is above it. That is 1 for orthogonal walls where J J^T is diagonal, as in the
cube's centre, and twice as much for two walls in one plane. All walls that are touched are scaled down by one factor so
that together they cost at most `MULTI_CONTACT_FACTOR` times what one alone may. Importing this module loads numba.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from delta_cad.common.jit import compiled
from haptics.rendering.law import GAIN, KIND
from haptics.rendering.laws import virtual_wall
from haptics.rendering.laws.virtual_wall import BLEND, DAMPING, NORMAL, STIFFNESS
from haptics.rendering.registry import LAWS, force_of

# Share of a stable wall that is rendered: 3 dB, for hands, friction and delays that are not in the set.
STABILITY_MARGIN = 0.7
MAX_DAMPING_RATIO = 0.08  # Virtual damping times its lag over the joints' mass; more makes the structure swing
# Stiffness of simultaneous contacts together over that of a single one, by what they cost the joints: 0.91 of what is
# computed.
MULTI_CONTACT_FACTOR = 1.3
WALL = next(kind for kind, law in LAWS.items() if law is virtual_wall.LAW)


class WallCap(NamedTuple):
    """Parameters of a loop's largest stable wall; plain floats.

    Attributes:
        share: Of the closed form, 0 to 1; 0 lets every wall through as it is asked for.
        friction: Least viscous friction of a joint while a wall is touched, N m s/rad.
        cost: T / 2 + largest delay + age of a reading + lag of the current loop, s.
        inertia: Of a joint, kg m^2.
        late: `cost` and the filter's time constant, s.
        damping: Least damping of a wall, N s/m.
        blend: Largest depth over which the damping fades in, m.
    """

    share: float
    friction: float
    cost: float
    inertia: float
    late: float
    damping: float
    blend: float


UNCAPPED = WallCap(0.0, 0.0, 1.0, 0.0, 1.0, 0.0, 1.0)


@compiled
def lever(jacobian, laws, i):
    """J^T n of a wall, joint by joint, m/rad; rows 0 to 2 of `jacobian` hold the columns of J."""
    nx, ny, nz = laws[i, NORMAL], laws[i, NORMAL + 1], laws[i, NORMAL + 2]
    a = jacobian[0, 0] * nx + jacobian[0, 1] * ny + jacobian[0, 2] * nz
    b = jacobian[1, 0] * nx + jacobian[1, 1] * ny + jacobian[1, 2] * nz
    c = jacobian[2, 0] * nx + jacobian[2, 1] * ny + jacobian[2, 2] * nz
    return a, b, c


@compiled
def stable_wall(cap, laws, i, q):
    """What of a wall is rendered at a pose.

    Args:
        cap: `WallCap`; of share 0 all that is asked for.
        laws: (n, COLUMNS) table.
        i: Row of the wall.
        q: |J^T n|^2, m^2/rad^2.

    Returns:
        Stiffness (N/m), damping (N s/m) and blend (m).
    """
    if not cap.share > 0.0:
        return laws[i, STIFFNESS], laws[i, DAMPING], laws[i, BLEND]
    damping = min(max(laws[i, DAMPING], cap.damping), MAX_DAMPING_RATIO * cap.inertia / (q * cap.late))
    stiffness = min(laws[i, STIFFNESS], cap.share * (cap.friction / q + damping) / cap.cost)
    return stiffness, damping, min(laws[i, BLEND], cap.blend)


@compiled
def largest(xx, yy, zz, xy, xz, yz):
    """The largest eigenvalue of a symmetric matrix that has no negative ones, or up to 7 % more.

    The sixteenth root of the sum of their sixteenth powers: exact for a single one, 3^(1/16) too much for three alike.
    """
    whole = xx + yy + zz
    if not whole > 0.0:
        return 0.0
    xx, yy, zz, xy, xz, yz = xx / whole, yy / whole, zz / whole, xy / whole, xz / whole, yz / whole
    for _ in range(4):
        xx, yy, zz, xy, xz, yz = (
            xx * xx + xy * xy + xz * xz,
            xy * xy + yy * yy + yz * yz,
            xz * xz + yz * yz + zz * zz,
            xx * xy + xy * yy + xz * yz,
            xx * xz + xy * yz + xz * zz,
            xy * xz + yy * yz + yz * zz,
        )
    return whole * math.sqrt(math.sqrt(math.sqrt(math.sqrt(xx + yy + zz))))


@compiled
def capped_force(cap, jacobian, laws, px, py, pz, vx, vy, vz):
    """Force of all laws on the handle, walls limited to what is stable, and whether one of them is touched.

    Args:
        cap: `WallCap`.
        jacobian: Rows 0 to 2 hold the columns of J, m/rad.
        laws: (n, COLUMNS) table.
        px: Position along x in the base frame, m.
        py: Along y, m.
        pz: Along z, m.
        vx: Velocity along x, m/s.
        vy: Along y, m/s.
        vz: Along z, m/s.

    Returns:
        fx, fy, fz: N in the base frame, before saturation; then 1 while a wall that is switched on is touched, else 0.
    """
    sx = sy = sz = wx = wy = wz = touched = 0.0
    xx = yy = zz = xy = xz = yz = 0.0  # what the touched walls cost the joints, N m s/rad
    for i in range(laws.shape[0]):
        gain = laws[i, GAIN]
        if laws[i, KIND] == WALL:  # exact: a kind is a whole number
            depth = virtual_wall.depth_in(laws, i, px, py, pz)
            if depth > 0.0 and gain > 0.0:
                a, b, c = lever(jacobian, laws, i)
                stiffness, damping, blend = stable_wall(cap, laws, i, a * a + b * b + c * c)
                fx, fy, fz = virtual_wall.push(laws, i, depth, vx, vy, vz, stiffness, damping, blend)
                wx += gain * fx
                wy += gain * fy
                wz += gain * fz
                touched += 1.0
                cost = gain * max(0.0, stiffness * cap.cost - damping)
                xx += cost * a * a
                yy += cost * b * b
                zz += cost * c * c
                xy += cost * a * b
                xz += cost * a * c
                yz += cost * b * c
        else:
            fx, fy, fz = force_of(laws, i, px, py, pz, vx, vy, vz)
            sx += gain * fx
            sy += gain * fy
            sz += gain * fz
    if touched > 1.0 and cap.share > 0.0:
        most, needed = MULTI_CONTACT_FACTOR * cap.share * cap.friction, largest(xx, yy, zz, xy, xz, yz)
        if needed > most:
            wx, wy, wz = wx * (most / needed), wy * (most / needed), wz * (most / needed)
    return sx + wx, sy + wy, sz + wz, min(touched, 1.0)
