"""How hard a wall the loop bears at a pose: the closed form by which a tick holds every virtual wall down.

A sampled wall takes energy away by the device's friction and the wall's damping and gives some by what a sample costs,
half a period, delay and current lag: `b + B >= K (T / 2 + delay + lag)`, whatever hand holds it (`stability.walls`).
Friction at the handle along n is that of the joints over `q = |J^T n|^2`, and J is known at every tick, so

    K <= share (friction / q + B) / cost

Damping is rendered late, too, through the filter of the rates, and gives energy where little mass is behind it: it is
held to `HEAVIEST inertia / (q late)`, since at the frequencies where it turns round the knob swings on the structure
and only the joints are left. Up to that, at least the loop's own damping is given to each wall, within its blend.
Importing this module loads numba.
"""

from __future__ import annotations

from typing import NamedTuple

from delta_cad.common.jit import compiled
from haptics.rendering.law import GAIN, KIND
from haptics.rendering.laws import virtual_wall
from haptics.rendering.laws.virtual_wall import BLEND, DAMPING, NORMAL, STIFFNESS
from haptics.rendering.registry import LAWS, force_of

SHARE = 0.7  # of what is computed that is rendered: 3 dB, for hands, friction and delays that are not in the set
HEAVIEST = 0.08  # Virtual damping times its lag over the joints' mass; more makes the structure swing
WALL = next(kind for kind, law in LAWS.items() if law is virtual_wall.LAW)


class WallCap(NamedTuple):
    """What decides the wall that a loop bears; plain floats.

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
def borne(cap, jacobian, laws, i):
    """What of a wall is rendered at a pose.

    Args:
        cap: `WallCap`; of share 0 all that is asked for.
        jacobian: Rows 0 to 2 hold the columns of J, m/rad.
        laws: (n, COLUMNS) table.
        i: Row of the wall.

    Returns:
        Stiffness (N/m), damping (N s/m) and blend (m).
    """
    if not cap.share > 0.0:
        return laws[i, STIFFNESS], laws[i, DAMPING], laws[i, BLEND]
    q = 0.0
    for j in range(3):
        arm = (
            jacobian[j, 0] * laws[i, NORMAL]
            + jacobian[j, 1] * laws[i, NORMAL + 1]
            + jacobian[j, 2] * laws[i, NORMAL + 2]
        )
        q += arm * arm
    damping = min(max(laws[i, DAMPING], cap.damping), HEAVIEST * cap.inertia / (q * cap.late))
    stiffness = min(laws[i, STIFFNESS], cap.share * (cap.friction / q + damping) / cap.cost)
    return stiffness, damping, min(laws[i, BLEND], cap.blend)


@compiled
def borne_force(cap, jacobian, laws, px, py, pz, vx, vy, vz):
    """Force of all laws on the handle, walls held to what the loop bears, and whether one of them is touched.

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
    sx = sy = sz = touched = 0.0
    for i in range(laws.shape[0]):
        gain = laws[i, GAIN]
        if laws[i, KIND] == WALL:
            fx = fy = fz = 0.0
            depth = virtual_wall.depth_in(laws, i, px, py, pz)
            if depth > 0.0:
                stiffness, damping, blend = borne(cap, jacobian, laws, i)
                fx, fy, fz = virtual_wall.push(laws, i, depth, vx, vy, vz, stiffness, damping, blend)
                if gain > 0.0:
                    touched = 1.0
        else:
            fx, fy, fz = force_of(laws, i, px, py, pz, vx, vy, vz)
        sx += gain * fx
        sy += gain * fy
        sz += gain * fz
    return sx, sy, sz, touched
