"""One tick of the controller: angles in, torques out; compiled, without allocation.

The order is fixed: pose from the angles; the supervisor checks what was read; joint rates, and the handle's velocity by
`v = J theta_dot`; the force of all laws, walls held to what the loop bears at the pose; `torque = J^T F`, scaled by one
factor where the joints cannot give it beside gravity; the supervisor lets pass what is safe. The same tick drives the
simulation and a device in Python, and is what the C controller is held against. Importing this module loads numba.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from delta_cad.common.jit import compiled
from haptics.control.filters import Estimator, fresh_memory, velocity
from haptics.control.pose import HOLDING, POSITION, RATES, ROWS, Model, pose
from haptics.control.saturation import saturate
from haptics.control.supervisor.faults import State
from haptics.control.supervisor.limits import SafetyLimits
from haptics.control.supervisor.memory import STATE, reset_memory
from haptics.control.supervisor.supervisor import check, findings_left_out, left_out, limit
from haptics.control.wall_cap import UNCAPPED, WallCap, capped_force

# Rows of the work array after those of `pose`: handle velocity (m/s), wanted force (N), the torque of it that fits
# (N m), limit of each joint (N m).
VELOCITY, FORCE, RENDERED, CEILING = ROWS, ROWS + 1, ROWS + 2, ROWS + 3
WORK = (ROWS + 5, 3)
FACTOR = (ROWS + 4, 0)  # Where the share of the wanted force that the joints could give is left, 0 to 1
# Where it is left whether a wall is touched and rendered, 1 or 0: the drives then damp more. Off while no force is
# let in, disabled or after a fault: a handle that is let go of inside a wall is as free as anywhere.
TOUCHED = (ROWS + 4, 1)
_DISABLED, _FAULT = float(State.DISABLED), float(State.FAULT)


class Controller(NamedTuple):
    """Parameters of a controller, constant while it runs.

    Attributes:
        model: The device as the controller knows it.
        estimator: Estimator of the joint rates.
        limits: Limits of the supervisor.
        force: Largest force on the handle, N; what laws ask beyond is scaled down in its direction. May be infinite.
        walls: What walls the loop bears.
    """

    model: Model
    estimator: Estimator
    limits: SafetyLimits
    force: float
    walls: WallCap = UNCAPPED


class Memory(NamedTuple):
    """State of a controller between ticks, changed in place.

    Attributes:
        filters: (3, 3) of the estimator.
        supervisor: (m,) of the supervisor.
        work: WORK, the last tick's figures.
    """

    filters: np.ndarray
    supervisor: np.ndarray
    work: np.ndarray


def fresh(controller: Controller) -> Memory:
    """The memory of a controller that has just been switched on, disabled."""
    return Memory(fresh_memory(), reset_memory(controller.limits), np.zeros(WORK))


@compiled
def tick(controller, memory, laws, now, theta, readings, fresh, out):
    """Computes the torques of one period from the angles read.

    Args:
        controller: `Controller`.
        memory: `Memory`, moved on in place.
        laws: (n, COLUMNS) table of force laws.
        now: Time of the reading, s.
        theta: (3,) shoulder angles, rad.
        readings: (3,) of the encoders, rad: `theta` before a calibration.
        fresh: Bit i is set if the reading of joint i was taken since the last tick and its own check passed.
        out: (3,) filled with the torques, N m.

    Returns:
        The supervisor's bits.
    """
    if left_out(controller.limits, memory.supervisor, fresh, out):
        return findings_left_out(memory.supervisor)
    known, work = controller.model, memory.work
    reach, volume = pose(known, theta, work)
    check(controller.limits, memory.supervisor, now, theta, readings, work[POSITION], reach, volume)
    vx = vy = vz = 0.0
    for i in range(3):
        rate = velocity(controller.estimator, memory.filters[i], theta[i])
        work[RATES, i] = rate
        vx += work[i, 0] * rate
        vy += work[i, 1] * rate
        vz += work[i, 2] * rate
    work[VELOCITY, 0], work[VELOCITY, 1], work[VELOCITY, 2] = vx, vy, vz
    px, py, pz = work[POSITION, 0], work[POSITION, 1], work[POSITION, 2]
    fx, fy, fz, work[TOUCHED] = capped_force(controller.walls, work, laws, px, py, pz, vx, vy, vz)
    wanted = math.sqrt(fx * fx + fy * fy + fz * fz)
    if wanted > controller.force:
        scale = controller.force / wanted
        fx, fy, fz = scale * fx, scale * fy, scale * fz
    work[FORCE, 0], work[FORCE, 1], work[FORCE, 2] = fx, fy, fz
    for i in range(3):
        work[CEILING, i] = controller.limits.torque
        work[RENDERED, i] = work[i, 0] * fx + work[i, 1] * fy + work[i, 2] * fz
    work[FACTOR] = saturate(work[HOLDING], work[RENDERED], work[CEILING], out)
    for i in range(3):
        work[RENDERED, i] *= work[FACTOR]
    bits = limit(controller.limits, memory.supervisor, work[RENDERED], work[HOLDING], out)
    state = int(memory.supervisor[STATE])
    if state in (_DISABLED, _FAULT):
        work[TOUCHED] = 0.0
    return bits
