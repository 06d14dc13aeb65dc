"""Loads of every part for a unit wrench on the platform: below the knob the machine is statically determinate.

Shapes: positions p are (..., 3) in mm in the base frame; a wrench is (force, moment) about the platform's centre in the
base frame, N and N mm; the last axis of every result holds its six unit wrenches. Chains 3, rods of a chain 2.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from delta_cad.common.units import MM_PER_M
from delta_cad.mechanism.geometry import VERTICAL
from delta_cad.mechanism.inverse import arm_direction, forearm_vectors
from delta_cad.structure.beam_model import BeamModel


@dataclass(frozen=True)
class UnitLoads:
    """Loads for unit wrenches; tension is positive.

    Attributes:
        rods: (..., 3, 2, 6) force of each rod; side 0 lies towards -t, 1 towards +t of its chain.
        along: (..., 3, 3) unit vector from elbow to wrist, base frame.
        arms: (..., 3, 3, 3) the arm's axes x, y, z as rows, base frame.
        turned: (..., 3, 2) cosine and sine of the shoulder angle.
        elbows: (..., 3, 6, 6) wrench of both rods on the arm at the elbow's middle, arm's axes.
        wrists: (..., 3, 6, 6) wrench of the platform on both rods at the wrist's middle, chain's axes (u, t, z).
    """

    rods: np.ndarray
    along: np.ndarray
    arms: np.ndarray
    turned: np.ndarray
    elbows: np.ndarray
    wrists: np.ndarray


@np.errstate(divide="ignore", invalid="ignore")
def inverse(columns: np.ndarray) -> np.ndarray:
    """Computes the inverses of 3 x 3 matrices given by their columns.

    Args:
        columns: (..., 3, 3) the column's number first.

    Returns:
        (..., 3, 3) inverses; infinite or NaN where a matrix is singular.
    """
    a, b, c = columns[..., 0, :], columns[..., 1, :], columns[..., 2, :]
    rows = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=-2)
    return rows / (rows[..., 0, :] * a).sum(axis=-1)[..., None, None]


@np.errstate(divide="ignore", invalid="ignore")
def unit_loads(table: BeamModel, p_mm: np.ndarray) -> UnitLoads:
    """Computes what rods, elbows and wrists bear for six unit wrenches on the platform.

    The rods of a chain are parallel along n_i. Their sum S_i bears the force, `sum S_i n_i = f`; their difference D_i
    bears what couple the sums leave, `sum (L_c / 2) D_i t_i x n_i = m - sum S_i (b_i x n_i)` with b_i the wrist's
    middle: a constraint singularity where the t_i x n_i get dependent.

    Args:
        table: The machine.
        p_mm: (..., 3) platform's centre.

    Returns:
        The loads; infinite or NaN at a singularity or out of reach.

    Source:
        Equilibrium of the platform; own derivation. Joints are balls, so that rods bear no moment.
    """
    g = table.geometry
    p = np.asarray(p_mm, dtype=float)
    n = forearm_vectors(g, p / MM_PER_M) / g.forearm_length
    cosine, sine = arm_direction(g, p / MM_PER_M)
    shape = p.shape[:-1]
    radial, tangential = g.radial, g.tangential
    couples = np.cross(np.broadcast_to(tangential, n.shape), n)
    wrist = g.platform_radius * MM_PER_M * radial
    zeros = np.zeros((*shape, 3, 3))
    sums = np.concatenate([inverse(n), zeros], axis=-1)  # (..., 3 chains, 6)
    moments = np.concatenate([zeros, np.broadcast_to(np.eye(3), (*shape, 3, 3))], axis=-1)
    moments = moments - np.swapaxes(np.cross(np.broadcast_to(wrist, n.shape), n), -1, -2) @ sums
    half = table.width_mm / 2.0
    differences = inverse(couples) @ moments / half
    rods = np.stack([sums - differences, sums + differences], axis=-2) / 2.0
    x = cosine[..., None] * radial + sine[..., None] * VERTICAL
    y = np.broadcast_to(tangential, x.shape)
    arms = np.stack([x, y, np.cross(x, y)], axis=-2)
    chains = np.broadcast_to(np.stack([radial, tangential, np.broadcast_to(VERTICAL, (3, 3))], axis=-2), arms.shape)

    def wrench(axes: np.ndarray) -> np.ndarray:
        force = (axes @ n[..., None]) * sums[..., None, :]
        moment = half * (axes @ couples[..., None]) * differences[..., None, :]
        return np.concatenate([force, moment], axis=-2)

    turned = np.stack([cosine, sine], axis=-1)
    return UnitLoads(rods, n, arms, turned, wrench(arms), wrench(chains))


def at_knob(height_mm: float) -> np.ndarray:
    """Gives the wrenches on the platform of three unit forces at a height over the wrists, (6, 3)."""
    f = np.eye(3)
    return np.concatenate([f, np.cross([0.0, 0.0, height_mm], f, axisb=0, axisc=0)], axis=0)


def elbows_mm(table: BeamModel, unit: UnitLoads) -> np.ndarray:
    """Gives the middle of each elbow in the base frame, (..., 3, 3) mm."""
    g = table.geometry
    return MM_PER_M * (g.base_radii[:, None] * g.radial + g.upper_arm_length * unit.arms[..., 0, :])


def blocks_loads(to_blocks: np.ndarray, unit: UnitLoads) -> np.ndarray:
    """Gives what the three foot blocks bear for six unit wrenches on the platform, (..., 18, 6).

    Args:
        to_blocks: (..., 3, 6, 6) from a wrench on the elbow to the foot block's, see `Mounting.to_blocks`.
        unit: Loads of the elbows.
    """
    loads = to_blocks @ unit.elbows
    return loads.reshape(*loads.shape[:-3], 18, 6)


def shoulder_map(table: BeamModel) -> np.ndarray:
    """Moves a wrench from the elbow to the shoulder, arm's axes, (6, 6)."""
    moved = np.eye(6)
    length = table.geometry.upper_arm_length * MM_PER_M
    moved[4, 2], moved[5, 1] = -length, length
    return moved


def bearing_map(table: BeamModel, turned: np.ndarray) -> np.ndarray:
    """Computes how the bearings and the cable of a shoulder hold a wrench on the arm at the shoulder.

    Args:
        table: A machine with a capstan.
        turned: (..., 2) cosine and sine of the shoulder angle.

    Returns:
        (..., 6, 6): along x, z of the encoder's bearing, x, z of the motor's, y of both together, and the cable's
        difference, all forces on the arm; by the wrench, whose axes are the arm's.

    Source:
        Equilibrium of the arm; the cable pulls along the tangent at the pinion's direction.
    """
    assert table.shoulder is not None
    assert table.cable is not None
    y0, y1 = table.shoulder.y_mm
    c = table.cable
    cosine, sine = turned[..., 0], turned[..., 1]
    # the pinion's direction in the arm's frame; the tangent y cross it
    towards_x = np.cos(c.direction_rad) * cosine + np.sin(c.direction_rad) * sine
    towards_z = np.sin(c.direction_rad) * cosine - np.cos(c.direction_rad) * sine
    tangent_x, tangent_z = towards_z, -towards_x
    held = np.zeros((*cosine.shape, 6, 6))
    force_x, force_y, force_z, moment_x, moment_y, moment_z = np.eye(6)
    pull = -moment_y / c.radius_mm
    held[..., 5, :] = pull
    held[..., 4, :] = -force_y
    # the rest of forces and moments, the cable's included, is for the two bearings
    fx = force_x + tangent_x[..., None] * pull
    fz = force_z + tangent_z[..., None] * pull
    mx = moment_x + c.y_mm * tangent_z[..., None] * pull
    mz = moment_z - c.y_mm * tangent_x[..., None] * pull
    span = y1 - y0
    held[..., 0, :] = (-y1 * fx - mz) / span
    held[..., 2, :] = (y0 * fx + mz) / span
    held[..., 1, :] = (-y1 * fz + mx) / span
    held[..., 3, :] = (y0 * fz - mx) / span
    return held
