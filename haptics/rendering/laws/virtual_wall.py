"""Virtual wall in any plane: pushes back along its normal only while it is touched, and never pulls.

What the drives damp meanwhile is no force of the law: it drags at whoever leaves or slides.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from numpy.typing import ArrayLike

from delta_cad.common.jit import compiled
from haptics.rendering.law import (
    ForceLaw,
    Law,
    LawError,
    columns,
    direction,
    finite,
    not_negative,
    positive,
    spring_energy,
    vector,
)
from haptics.rendering.states import force_function

# Depth over which the damping of a wall fades in, m: what a hand of 3 N reaches in a wall of 6 N/mm.
WALL_BLEND = 0.5e-3
AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


@dataclass(frozen=True)
class VirtualWall(ForceLaw):
    """Virtual wall in any plane: `n max(0, K x - b s n . v)` at the depth x > 0, nothing outside.

    The damping fades in with the depth, s = min(1, x / blend), so that a touch-down at speed makes no step.

    Attributes:
        stiffness: K_e, N/m, at least 0.
        point: (3,) any point of the plane, base frame, m.
        normal: (3,) n towards the free side; any length but 0.
        damping: b as applied, N s/m, at least 0.
        blend: Depth over which the damping fades in, m, positive.

    Raises:
        LawError: A parameter is out of its bounds.

    Source:
        [RCIM2018] eq. (24), which is the force on the wall; this is that on the handle, with damping in contact.
    """

    stiffness: Annotated[float, not_negative("N/m")]
    point: Annotated[ArrayLike, vector("m")]
    normal: Annotated[ArrayLike, direction()]
    damping: Annotated[float, not_negative("N s/m")] = 0.0
    blend: Annotated[float, positive("m")] = WALL_BLEND


STIFFNESS, POINT, NORMAL, DAMPING, BLEND = columns(VirtualWall)


@compiled
def depth_in(laws, i, px, py, pz):
    """Depth of a position in a wall, m; negative outside."""
    qx, qy, qz = laws[i, POINT] - px, laws[i, POINT + 1] - py, laws[i, POINT + 2] - pz
    return laws[i, NORMAL] * qx + laws[i, NORMAL + 1] * qy + laws[i, NORMAL + 2] * qz


@compiled
def push(laws, i, depth, vx, vy, vz, stiffness, damping, blend):
    """Force of a virtual wall at a depth (m), stiffness (N/m), damping (N s/m) and blend (m) capped by the loop."""
    if not depth > 0.0:
        return 0.0, 0.0, 0.0
    nx, ny, nz = laws[i, NORMAL], laws[i, NORMAL + 1], laws[i, NORMAL + 2]
    leaving = nx * vx + ny * vy + nz * vz
    size = stiffness * depth - damping * min(1.0, depth / blend) * leaving
    size = max(0.0, size)
    return size * nx, size * ny, size * nz


@compiled
def force(laws, i, px, py, pz, vx, vy, vz):
    """Force of a virtual wall."""
    depth = depth_in(laws, i, px, py, pz)
    return push(laws, i, depth, vx, vy, vz, laws[i, STIFFNESS], laws[i, DAMPING], laws[i, BLEND])


@compiled
def energy(laws, i, px, py, pz):
    """Energy of a virtual wall; 0 outside."""
    return spring_energy(laws[i, STIFFNESS], max(0.0, depth_in(laws, i, px, py, pz)), math.inf)


LAW = Law(VirtualWall, force, energy)
virtual_wall = force_function(LAW, VirtualWall)


def axis_wall(
    met: str, position: float, *, stiffness: float, damping: float = 0.0, blend: float = WALL_BLEND
) -> VirtualWall:
    """Virtual wall across an axis of the base frame.

    Args:
        met: Direction of motion that meets the wall: "+x", "-x", "+y", "-y", "+z" or "-z".
        position: Coordinate of its face along that axis, m.
        stiffness: N/m, at least 0.
        damping: As applied, N s/m, at least 0.
        blend: m, positive.

    Raises:
        LawError: A parameter is out of its bounds, or the direction is none of the six.
    """
    if len(met) != 2 or met[0] not in "+-" or met[1] not in AXES:
        raise LawError(f'met is {met!r}; it must be "+x", "-x", "+y", "-y", "+z" or "-z"')
    axis = np.array(AXES[met[1]])
    normal, unit = (-axis if met[0] == "+" else axis), finite("m")
    point = axis * unit.checked("position", position, unit.unit)
    return VirtualWall(stiffness=stiffness, point=point, normal=normal, damping=damping, blend=blend)
