"""Spring and damper to a point."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated

from numpy.typing import ArrayLike

from delta_cad.common.jit import compiled
from haptics.rendering.law import ForceLaw, Law, columns, not_negative, spring_energy, vector
from haptics.rendering.states import force_function


@dataclass(frozen=True)
class SpringDamper(ForceLaw):
    """Spring and damper to a point, everywhere: `k (point - p) - b v`.

    Attributes:
        stiffness: k, N/m, at least 0.
        damping: b as applied, N s/m, at least 0.
        point: (3,) base frame, m.

    Raises:
        LawError: A parameter is out of its bounds.
    """

    stiffness: Annotated[float, not_negative("N/m")]
    damping: Annotated[float, not_negative("N s/m")]
    point: Annotated[ArrayLike, vector("m")]


STIFFNESS, DAMPING, POINT = columns(SpringDamper)


@compiled
def force(laws, i, px, py, pz, vx, vy, vz):
    """Force of a spring and damper."""
    qx, qy, qz = laws[i, POINT] - px, laws[i, POINT + 1] - py, laws[i, POINT + 2] - pz
    k, b = laws[i, STIFFNESS], laws[i, DAMPING]
    return k * qx - b * vx, k * qy - b * vy, k * qz - b * vz


@compiled
def energy(laws, i, px, py, pz):
    """Energy of a spring; 0 at its point."""
    qx, qy, qz = laws[i, POINT] - px, laws[i, POINT + 1] - py, laws[i, POINT + 2] - pz
    return spring_energy(laws[i, STIFFNESS], math.sqrt(qx * qx + qy * qy + qz * qz), math.inf)


LAW = Law(SpringDamper, force, energy)
spring_damper = force_function(LAW, SpringDamper)
