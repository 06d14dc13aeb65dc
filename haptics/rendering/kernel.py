"""Force laws as rows of a table: its layout and the one compiled kernel that turns it into the force on the handle.

A law is a row of 12 doubles, so that any combination of laws is one loop here and the same table in the C firmware.
The rows are made and checked by `rows`; the kernel trusts them, and trusts p and v to be finite (the supervisor sees to
it). A row of unknown kind gives no force. Importing this module loads numba.

| column | resistance | spring | constant | home | wall |
|---|---|---|---|---|---|
| KIND | 1 | 2 | 3 | 4 | 5 |
| ANCHOR, 3 columns | origin, m | point, m | force, N | origin, m | a point of the wall, m |
| STIFFNESS | k, N/m | k, N/m | | k, N/m | k, N/m |
| DAMPING | b, N s/m | b, N s/m | | b, N s/m | b, N s/m |
| FIRST | r0, m | | | speed limit, m/s | normal, x |
| SECOND | r1, m | | | | normal, y |
| THIRD | | | | | normal, z |
| BLEND | blend, m | | | | blend, m |
| (10) | | | | | |
| GAIN | factor of the whole row, 0 to 1, for all kinds | | | | |

With q = anchor - p, d = |q| and n the wall's normal, a unit vector towards the free side, before the gain:

    resistance  0 for d <= r0, else  k (min(d, r1) - r0) q / d - b min(1, (d - r0) / blend) v
    spring      k q - b v
    constant    the force
    home        min(k, b speed / d) q - b v
    wall        n max(0, k x - b min(1, x / blend) n . v)  for the depth x = n . q > 0, else 0

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

Source:
    [RCIM2018] eqs. (23), (24). Ours: both dampings fade in over `blend` where the paper's switch on; eq. (24) is
    the force on the wall, ours that on the handle; the home function is the paper's with a speed limit.
"""

from __future__ import annotations

import math

from delta_cad.common.jit import compiled

COLUMNS = 12
KIND, ANCHOR, STIFFNESS, DAMPING, FIRST, SECOND, THIRD, BLEND, GAIN = 0, 1, 4, 5, 6, 7, 8, 9, 11
RESISTANCE, SPRING, CONSTANT, HOME, WALL = 1, 2, 3, 4, 5
KINDS = (RESISTANCE, SPRING, CONSTANT, HOME, WALL)


@compiled
def _resistance(laws, i, qx, qy, qz, vx, vy, vz):
    d = math.sqrt(qx * qx + qy * qy + qz * qz)
    r0 = laws[i, FIRST]
    beyond = d - r0
    if not beyond > 0.0:  # also where d = 0 and the direction is not defined
        return 0.0, 0.0, 0.0
    pull = laws[i, STIFFNESS] * min(beyond, laws[i, SECOND] - r0) / d
    b = laws[i, DAMPING] * min(1.0, beyond / laws[i, BLEND])
    return pull * qx - b * vx, pull * qy - b * vy, pull * qz - b * vz


@compiled
def _home(laws, i, qx, qy, qz, vx, vy, vz):
    d = math.sqrt(qx * qx + qy * qy + qz * qz)
    b = laws[i, DAMPING]
    k = min(laws[i, STIFFNESS], b * laws[i, FIRST] / d)  # d = 0: the second is infinite
    return k * qx - b * vx, k * qy - b * vy, k * qz - b * vz


@compiled
def _wall(laws, i, qx, qy, qz, vx, vy, vz):
    nx, ny, nz = laws[i, FIRST], laws[i, SECOND], laws[i, THIRD]
    depth = nx * qx + ny * qy + nz * qz
    if not depth > 0.0:
        return 0.0, 0.0, 0.0
    leaving = nx * vx + ny * vy + nz * vz
    push = laws[i, STIFFNESS] * depth - laws[i, DAMPING] * min(1.0, depth / laws[i, BLEND]) * leaving
    push = max(0.0, push)
    return push * nx, push * ny, push * nz


@compiled
def total_force(laws, px, py, pz, vx, vy, vz):
    """Force of all laws on the handle.

    Args:
        laws: (n, COLUMNS) table.
        px: Position in the base frame, m; likewise py, pz.
        py: m.
        pz: m.
        vx: Velocity, m/s; likewise vy, vz.
        vy: m/s.
        vz: m/s.

    Returns:
        fx, fy, fz: N in the base frame, before saturation.
    """
    sx = sy = sz = 0.0
    for i in range(laws.shape[0]):
        kind = laws[i, KIND]
        ax, ay, az = laws[i, ANCHOR], laws[i, ANCHOR + 1], laws[i, ANCHOR + 2]
        qx, qy, qz = ax - px, ay - py, az - pz
        if kind == WALL:
            fx, fy, fz = _wall(laws, i, qx, qy, qz, vx, vy, vz)
        elif kind == RESISTANCE:
            fx, fy, fz = _resistance(laws, i, qx, qy, qz, vx, vy, vz)
        elif kind == SPRING:
            k, b = laws[i, STIFFNESS], laws[i, DAMPING]
            fx, fy, fz = k * qx - b * vx, k * qy - b * vy, k * qz - b * vz
        elif kind == HOME:
            fx, fy, fz = _home(laws, i, qx, qy, qz, vx, vy, vz)
        elif kind == CONSTANT:
            fx, fy, fz = ax, ay, az
        else:
            continue
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
        px: Position in the base frame, m; likewise py, pz.
        py: m.
        pz: m.

    Returns:
        J; 0 at the anchor of a resistance, spring or home, outside a wall, at the base's centre for a constant force.
    """
    energy = 0.0
    for i in range(laws.shape[0]):
        kind, k, gain = laws[i, KIND], laws[i, STIFFNESS], laws[i, GAIN]
        ax, ay, az = laws[i, ANCHOR], laws[i, ANCHOR + 1], laws[i, ANCHOR + 2]
        if kind == CONSTANT:
            energy -= gain * (ax * px + ay * py + az * pz)
            continue
        qx, qy, qz = ax - px, ay - py, az - pz
        # all others: a spring up to the turn `most`, a constant pull beyond it
        most = math.inf
        if kind == WALL:
            turn = max(0.0, laws[i, FIRST] * qx + laws[i, SECOND] * qy + laws[i, THIRD] * qz)
        else:
            turn = math.sqrt(qx * qx + qy * qy + qz * qz)
            if kind == RESISTANCE:
                most = laws[i, SECOND] - laws[i, FIRST]
                turn = max(0.0, turn - laws[i, FIRST])
            elif kind == HOME:
                most = laws[i, DAMPING] * laws[i, FIRST] / k
            elif kind != SPRING:
                continue
        stretch = min(turn, most)
        energy += gain * k * stretch * (turn - 0.5 * stretch)
    return energy


@compiled
def forces_into(laws, p, v, out):
    """Forces at many states; here, since the cache of compiled code looks at a function's own file only.

    Args:
        laws: (n, COLUMNS) table.
        p: (m, 3) positions, m.
        v: (m, 3) velocities, m/s.
        out: (m, 3) filled, N.
    """
    for j in range(p.shape[0]):
        out[j, 0], out[j, 1], out[j, 2] = total_force(laws, p[j, 0], p[j, 1], p[j, 2], v[j, 0], v[j, 1], v[j, 2])


@compiled
def energies_into(laws, p, out):
    """Stored energies at many positions.

    Args:
        laws: (n, COLUMNS) table.
        p: (m, 3) positions, m.
        out: (m,) filled, J.
    """
    for j in range(p.shape[0]):
        out[j] = total_energy(laws, p[j, 0], p[j, 1], p[j, 2])


@compiled
def fade(gain, target, step):
    """The gain of a row one tick later, so that a law that is switched on or off makes no step.

    Args:
        gain: Now.
        target: 1 to switch on, 0 to switch off.
        step: Largest change in a tick: the period over the time of the whole fade.

    Returns:
        The gain; the force of the row then changes in a tick by at most `step` times itself, besides what p and v do.
    """
    if gain < target:
        return min(target, gain + step)
    return max(target, gain - step)
