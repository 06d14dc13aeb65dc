"""Mass, friction, resolution, force and gravity at the handle, over arrays of positions.

With `torque = J^T force`, `v = J theta_dot` and G the inverse Jacobian, rows G_i, joint rates of a motion n are
`G n`, and a torque of joint i is the force G_i at the handle. From that, exactly:

- Effective mass along n with the other directions free `1 / (n . M^-1 n)`: between the eigenvalues of M.
- Friction c of each joint against a steady motion along n: `c sum |G_i . n|`. It is largest along one of the four
  `sum +-G_i`, and smallest where only one joint turns, along a column of J: `c min 1 / |J_i|`.
- Forces that torques within +-l give beside gravity's h_i: those with `-l - h_i <= J_i . F <= l - h_i`, a
  parallelepiped. The ball about 0 in it has the radius of the nearest face, `min (l - |h_i|) / |J_i|`; its corners are
  `G^T (+-l - h)`, and the farthest is the most that any direction gets.
- Accelerations of the free handle that torques within +-l give beside gravity's: `tau_i = (M J_i) . a`, so that the
  ball about 0 has the radius `min (l - |h_i|) / |M J_i|`.
- Errors e_i of the joints' torques, whatever their signs, are a force of at most `max |sum +-e_i G_i|`: ripple, a share
  of each torque, and cogging.
- A step of one encoder moves the handle by `count |J_i|`; one of a torque changes the force by `step |G_i|`.

Source:
    [RCIM2018] eqs. (8)-(12) for J^T; the others follow.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import ArrayLike

from delta_cad.mechanism import inverse_jacobian, jacobian
from delta_cad.mechanism.limits.effective_mass import handle_inertia
from haptics.gravity import gravity_torque
from haptics.model.ball_joints import ball_friction_N
from haptics.model.machine import MachineModel

# (8, 3) corners of a cube of torques; the first four are enough where n and -n are the same.
_SIGNS = np.array(list(product((1.0, -1.0), repeat=3)))
# Steps of a current command from minus to plus the peak, assumed: 12 bits, the coarsest in use. The driver is no part
# of the design.
COMMAND_STEPS = 2**12


@dataclass(frozen=True)
class Drive:
    """Torques and friction of the joints, N m at the joint unless said.

    Attributes:
        continuous: Torque for ever, as far as the controller allows it.
        peak: Torque for a moment, as far as the controller allows it.
        motor: Torque for a moment, as far as the motor goes; no controller of this project asks for more than `peak`.
        coulomb: Friction of the drive; the ball joints' is added at the handle.
        count: Count of the encoder, rad.
        step: Step of the torque command.
        ripple: Largest deviation of a torque from its command, as a share.
        cogging: Largest torque without a command.
    """

    continuous: float
    peak: float
    motor: float
    coulomb: float
    count: float
    step: float
    ripple: float
    cogging: float


def feel_at(machine: MachineModel, drive: Drive, p: ArrayLike) -> dict[str, np.ndarray]:
    """Computes mass, friction, resolution and force at positions.

    Args:
        machine: The device.
        drive: What its joints do.
        p: (..., 3) platform centre, m.

    Returns:
        (...) of each of `summary.QUANTITIES` but the wall, by its name, SI. A mass along an axis is that with the
        others free; a force is negative where the joints cannot even hold the weight.

    Raises:
        UnreachableError: A position cannot be reached.
        SingularError: The forearms lie in one plane.
    """
    g, p = machine.geometry, np.asarray(p, dtype=float)
    columns = np.swapaxes(jacobian(g, p), -1, -2)  # (..., chain, axis): J_i
    rows = inverse_jacobian(g, p)  # (..., chain, axis): G_i
    reach, lever = np.linalg.norm(columns, axis=-1), np.linalg.norm(rows, axis=-1)
    mass = handle_inertia(g, p, machine.masses.handle_inertia)
    eigenvalues = np.linalg.eigvalsh(mass)
    gravity = gravity_torque(g, machine.masses, p, machine.design.requirements.gravity_m_s2)
    corners = drive.peak * _SIGNS - gravity[..., None, :]  # (..., 8, chain)
    continuous = inscribed_ball(columns, gravity, drive.continuous)
    friction = worst_friction(machine, p, rows, drive.coulomb)
    axes = 1.0 / np.diagonal(np.linalg.inv(mass), axis1=-2, axis2=-1)
    return {
        "mass_min": eigenvalues[..., 0],
        "mass_max": eigenvalues[..., 2],
        "isotropy": eigenvalues[..., 0] / eigenvalues[..., 2],
        "friction_min": _least_friction(machine, p, columns, drive.coulomb),
        "friction_max": friction,
        "position_step": drive.count * reach.max(axis=-1),
        "force_step": drive.step * lever.max(axis=-1),
        "force_continuous": continuous,
        "force_peak": inscribed_ball(columns, gravity, drive.peak),
        "force_peak_best": np.linalg.norm(corners @ rows, axis=-1).max(axis=-1),
        "force_motor": inscribed_ball(columns, gravity, drive.motor),
        "acceleration": inscribed_ball(columns @ mass, gravity, drive.peak),
        "dynamic_range": continuous / friction,
        "gravity": np.abs(gravity).max(axis=-1),
        "ripple_still": _in_phase(drive.ripple * np.abs(gravity) + drive.cogging, rows),
        "ripple_force": _in_phase(np.full(gravity.shape, drive.ripple * drive.continuous + drive.cogging), rows),
    } | {f"mass_{axis}": axes[..., k] for k, axis in enumerate("xyz")}


def _in_phase(errors: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Largest force (...) at the handle of torques (..., 3 chains) whose signs are not known, rows G_i."""
    return np.linalg.norm((_SIGNS[:4] * errors[..., None, :]) @ rows, axis=-1).max(axis=-1)


def _least_friction(machine: MachineModel, p: np.ndarray, columns: np.ndarray, coulomb: float) -> np.ndarray:
    """Friction at the handle along the motion that the drives rub least: one joint turns alone, `c / |J_i|`.

    Args:
        machine: The device, for its ball joints.
        p: (..., 3) m.
        columns: (..., 3 chains, 3) J_i, m/rad.
        coulomb: Friction of each joint's drive, N m.

    Returns:
        (...) N.
    """
    reach = np.linalg.norm(columns, axis=-1)
    longest = np.take_along_axis(columns, reach.argmax(axis=-1)[..., None, None], axis=-2)[..., 0, :]
    most = reach.max(axis=-1)
    return coulomb / most + ball_friction_N(machine.design, p, longest / most[..., None])


def worst_friction(machine: MachineModel, p: np.ndarray, rows: np.ndarray, coulomb: float) -> np.ndarray:
    """Friction at the handle against a steady motion in the worst direction: `c max |sum +-G_i|`, and the ball joints'.

    Args:
        machine: The device, for its ball joints.
        p: (..., 3) m.
        rows: (..., 3 chains, 3) G_i, rad/m.
        coulomb: Friction of each joint's drive, N m.

    Returns:
        (...) N.
    """
    corners = _SIGNS[:4] @ rows  # (..., 4, 3)
    strength = np.linalg.norm(corners, axis=-1)
    at = np.broadcast_to(p[..., None, :], corners.shape)
    return (coulomb * strength + ball_friction_N(machine.design, at, corners / strength[..., None])).max(axis=-1)


def inscribed_ball(columns: np.ndarray, gravity: np.ndarray, limit: float) -> np.ndarray:
    """Force that is there in every direction.

    Args:
        columns: (..., 3 chains, 3) J_i, m/rad; M J_i, kg m/rad, for accelerations in m/s^2.
        gravity: (..., 3 chains) torque that holds the weight, N m.
        limit: Limit of each joint, N m.

    Returns:
        (...) N; negative where a joint cannot hold the weight.
    """
    return ((limit - np.abs(gravity)) / np.linalg.norm(columns, axis=-1)).min(axis=-1)
