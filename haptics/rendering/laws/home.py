"""Home function: brings the handle from anywhere to the origin, no faster than a speed limit."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated

from numpy.typing import ArrayLike

from delta_cad.common.jit import compiled
from haptics.rendering.law import ForceLaw, Law, columns, positive, spring_energy, vector
from haptics.rendering.states import force_function


@dataclass(frozen=True)
class Home(ForceLaw):
    """Home function: `min(k, b speed / d) (origin - p) - b v` at the distance d from the origin.

    It is damping against the difference to a wanted velocity, `F = b (w - v)`, where w points home and is
    `min(k d / b, speed)`: a spring whose pull ends at `b speed`. A free mass never gets faster than the limit, or than
    it was: while `|v|` exceeds it, `m d|v|^2/dt = 2 b (w . v - |v|^2) < 0`. The pull must exceed the friction of the
    joints for the handle to arrive. Switch it on by its gain (`table.fade`), then there is no step.

    Attributes:
        stiffness: k near the origin, N/m, positive.
        damping: b as applied, N s/m, positive.
        speed: Speed limit of the approach, m/s, positive.
        origin: (3,) base frame, m.

    Raises:
        LawError: A parameter is out of its bounds.

    Source:
        [RCIM2018], with a speed limit of ours.
    """

    stiffness: Annotated[float, positive("N/m")]
    damping: Annotated[float, positive("N s/m")]
    speed: Annotated[float, positive("m/s")]
    origin: Annotated[ArrayLike, vector("m")] = (0.0, 0.0, 0.0)


STIFFNESS, DAMPING, SPEED, ORIGIN = columns(Home)


@compiled
def force(laws, i, px, py, pz, vx, vy, vz):
    """Force of a home function."""
    qx, qy, qz = laws[i, ORIGIN] - px, laws[i, ORIGIN + 1] - py, laws[i, ORIGIN + 2] - pz
    d = math.sqrt(qx * qx + qy * qy + qz * qz)
    b = laws[i, DAMPING]
    k = min(laws[i, STIFFNESS], b * laws[i, SPEED] / d)  # d = 0: the second is infinite
    return k * qx - b * vx, k * qy - b * vy, k * qz - b * vz


@compiled
def energy(laws, i, px, py, pz):
    """Energy of a home function; 0 at its origin."""
    qx, qy, qz = laws[i, ORIGIN] - px, laws[i, ORIGIN + 1] - py, laws[i, ORIGIN + 2] - pz
    k = laws[i, STIFFNESS]
    return spring_energy(k, math.sqrt(qx * qx + qy * qy + qz * qz), laws[i, DAMPING] * laws[i, SPEED] / k)


LAW = Law(Home, force, energy)
home = force_function(LAW, Home)
