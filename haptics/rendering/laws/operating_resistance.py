"""Operating resistance of the paper: zero near the origin, then a spring towards it, then a constant pull."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated

from numpy.typing import ArrayLike

from delta_cad.common.jit import compiled
from haptics.rendering.law import (
    ForceLaw,
    Law,
    LawError,
    columns,
    finite,
    not_negative,
    positive,
    spring_energy,
    vector,
)
from haptics.rendering.states import force_function

RESISTANCE_BLEND = 1e-3  # Way beyond r0 over which the damping fades in, m; less than r1 - r0 of the paper's settings


@dataclass(frozen=True)
class OperatingResistance(ForceLaw):
    """Operating resistance: a dead zone, a spring to the origin, a constant pull beyond, and damping that fades in.

    With d the distance from the origin and e the unit vector towards it: 0 for d <= r0; `k (d - r0) e - b s v` up to
    r1; `k (r1 - r0) e - b s v` beyond; s = min(1, (d - r0) / blend).

    Attributes:
        stiffness: k, N/m, at least 0.
        damping: b as applied, N s/m, at least 0.
        dead_radius: r0, m, at least 0.
        full_radius: r1, m, more than r0.
        origin: (3,) base frame, m.
        blend: Way beyond r0 over which the damping fades in, m, positive.

    Raises:
        LawError: A parameter is out of its bounds.

    Source:
        [RCIM2018] eq. (23), where the damping switches on at r0: a step of b v.
    """

    stiffness: Annotated[float, not_negative("N/m")]
    damping: Annotated[float, not_negative("N s/m")]
    dead_radius: Annotated[float, not_negative("m")]
    full_radius: Annotated[float, finite("m")]
    origin: Annotated[ArrayLike, vector("m")] = (0.0, 0.0, 0.0)
    blend: Annotated[float, positive("m")] = RESISTANCE_BLEND

    def __post_init__(self) -> None:
        super().__post_init__()
        if not self.full_radius > self.dead_radius:
            raise LawError(
                f"full_radius is {self.full_radius!r} m; it must be greater than dead_radius, {self.dead_radius!r} m"
            )

    @property
    def plateau(self) -> float:
        """K (r1 - r0): force at and beyond r1 at rest, N, before saturation."""
        return self.stiffness * (self.full_radius - self.dead_radius)


STIFFNESS, DAMPING, DEAD_RADIUS, FULL_RADIUS, ORIGIN, BLEND = columns(OperatingResistance)


@compiled
def force(laws, i, px, py, pz, vx, vy, vz):
    """Force of an operating resistance."""
    qx, qy, qz = laws[i, ORIGIN] - px, laws[i, ORIGIN + 1] - py, laws[i, ORIGIN + 2] - pz
    d = math.sqrt(qx * qx + qy * qy + qz * qz)
    r0 = laws[i, DEAD_RADIUS]
    beyond = d - r0
    if not beyond > 0.0:  # also where d = 0 and the direction is not defined
        return 0.0, 0.0, 0.0
    pull = laws[i, STIFFNESS] * min(beyond, laws[i, FULL_RADIUS] - r0) / d
    b = laws[i, DAMPING] * min(1.0, beyond / laws[i, BLEND])
    return pull * qx - b * vx, pull * qy - b * vy, pull * qz - b * vz


@compiled
def energy(laws, i, px, py, pz):
    """Energy of an operating resistance; 0 in its dead zone."""
    qx, qy, qz = laws[i, ORIGIN] - px, laws[i, ORIGIN + 1] - py, laws[i, ORIGIN + 2] - pz
    beyond = max(0.0, math.sqrt(qx * qx + qy * qy + qz * qz) - laws[i, DEAD_RADIUS])
    return spring_energy(laws[i, STIFFNESS], beyond, laws[i, FULL_RADIUS] - laws[i, DEAD_RADIUS])


LAW = Law(OperatingResistance, force, energy)
operating_resistance = force_function(LAW, OperatingResistance)

# The two settings that [RCIM2018] measured with eq. (23). They rise to 3.4 N and 2.8 N: of the first it is the 3 N
# limit that decides, by saturation. At 1 kHz b = 500 N s/m is more than the sampled loop can hold; the damping applied
# is another number: `dataclasses.replace` sets it.
PAPER_SETTINGS = {
    "k0.4": OperatingResistance(stiffness=400.0, damping=500.0, dead_radius=1.5e-3, full_radius=10e-3),
    "k0.8": OperatingResistance(stiffness=800.0, damping=500.0, dead_radius=1.5e-3, full_radius=5e-3),
}
