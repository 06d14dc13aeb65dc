"""Whether the closed form by which a tick caps its walls holds over the whole cube: by the eigenvalues of the device.

The closed form knows friction, delay and damping; cable, structure, filter and the coupling of the axes are in the
eigenvalues. Where a device bears less than the form says, all its walls are scaled down by one figure before its
controller is written. Importing this module loads numba.
"""

from __future__ import annotations

from itertools import product

import numpy as np

from haptics.control.wall_cap import HEAVIEST, SHARE, WallCap
from haptics.model.machine import MachineModel
from haptics.model.plant import FREE
from haptics.simulation.hardware import wall_cap
from haptics.simulation.loops import BOARD, LoopChoice
from haptics.stability.walls import WallAt, centre_and_corners

# Shares of the closed form that are tried, the largest first; then the same with a half of the damping that a wall may
# ask for, and so on: drives that add no damping bear less of it on a large device. None of them: the loop is refused.
SCALES = (*(0.02 * k for k in range(50, 35, -1)), 0.7, 0.6, 0.5)
LAST_SCALES = (0.4, 0.3, 0.2, 0.1)
HEAVY = (1.0, 0.5, 0.25, 0.125, 0.0625)
PARTS = (0.05, 0.3, 0.6, 0.85, 1.0)  # Walls tried at a pose, as shares of the stiffest: a softer one must stand, too
NORMALS = np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]])
STRONG = 1e3  # A damping beyond all caps, N s/m


def closed_form(cap: WallCap, jacobian: np.ndarray, normal: np.ndarray, damping: float = 0.0) -> tuple[float, float]:
    """Stiffness (N/m) and damping (N s/m) that are borne across a direction, as `wall_cap.borne` has them."""
    q = float(np.square(jacobian.T @ normal).sum())
    kept = min(max(damping, cap.damping), HEAVIEST * cap.inertia / (q * cap.late))
    return cap.share * (cap.friction / q + kept) / cap.cost, kept


def rendered(cap: WallCap, jacobian: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The wall that a tick renders at most, across the direction in which it renders least.

    The closed form falls with `|J^T n|^2`, whose largest value is an eigenvalue of `J J^T`.

    Args:
        cap: What the loop bears.
        jacobian: (..., 3, 3) J, m/rad.

    Returns:
        Stiffness (...) N/m, damping (...) N s/m, and normal (..., 3).
    """
    values, vectors = np.linalg.eigh(jacobian @ np.swapaxes(jacobian, -1, -2))
    q = values[..., 2]
    damping = np.minimum(cap.damping, HEAVIEST * cap.inertia / (q * cap.late))
    return cap.share * (cap.friction / q + damping) / cap.cost, damping, vectors[..., 2]


def proven_cap(machine: MachineModel, loop: LoopChoice = BOARD) -> WallCap:
    """The cap of a loop, scaled so that every wall it lets through at full scale is stable let go of.

    Tried are the centre and the corners of the cube, three normals, least friction, largest delay, with the loop's
    damping and with the largest that is borne; what is rendered is `SHARE` of it.

    Args:
        machine: The device.
        loop: The loop.

    Returns:
        The cap, its share times `SHARE`, its inertia as far as the damping that a wall asks for is borne.

    Raises:
        ValueError: Even a tenth of the closed form is unstable somewhere.
    """
    tried = [
        WallAt(machine, loop, pose, normal, place=0, delay=loop.delays[2] * loop.period)
        for pose, normal in product(centre_and_corners(machine), NORMALS)
    ]
    whole = wall_cap(machine, loop, 1.0)
    for heavy, scale in (*product(HEAVY, SCALES), *product(HEAVY[-1:], LAST_SCALES)):
        cap = whole._replace(share=scale, inertia=heavy * whole.inertia)
        if all(_stands(at, cap) for at in tried):
            return cap._replace(share=SHARE * scale)
    raise ValueError(
        f"a loop of {1.0 / loop.period:g} Hz bears no wall at some pose, not even {LAST_SCALES[-1]:g} of its form"
    )


def _stands(at: WallAt, cap: WallCap) -> bool:
    """Whether the walls that a cap lets through are stable with nobody at the handle."""
    loop = at.here.joint_loop(at.normal, FREE, at.timing, at.estimator, at_motor=at.at_motor)
    for asked in (0.0, STRONG):
        stiffness, damping = closed_form(cap, at.here.jacobian, at.normal, asked)
        if any(loop.radius(part * stiffness, damping) >= 1.0 for part in PARTS):
            return False
    return True
