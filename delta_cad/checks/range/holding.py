"""Torque of each joint that holds the machine up, of its placed solids; the limit on it is `HoldingTorque`.

The torque that holds the moving bodies at p is minus the torque of gravity, that is the gradient of their potential
energy in the joint angles: `J^T dU/dp` with `v = J theta_dot`. U is summed over the links of the placement, with masses
and centres from the solids; its gradient is taken by central differences, so no formula of the dynamics enters.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from delta_cad.assembly.machine import Assembly
from delta_cad.common.units import MM_PER_M
from delta_cad.mechanism import jacobian

_STEP_MM = 1e-2  # error of the central difference: step^2 / 6 times the third derivative, below 1e-8 of the torque


def potential_energy(
    assembly: Assembly, bodies: Mapping[str, tuple[float, np.ndarray]], p_mm: np.ndarray, gravity_m_s2: np.ndarray
) -> np.ndarray:
    """Computes the potential energy of the moving bodies, J.

    Args:
        assembly: The machine.
        bodies: Link -> (mass in kg, centre of mass (3,) in the link's frame in mm), without the base.
        p_mm: (..., 3) handle positions, mm.
        gravity_m_s2: (3,) acceleration of gravity in the base frame.
    """
    links = assembly.placement(p_mm)
    energy = np.zeros(np.shape(p_mm)[:-1])
    for link, (mass, centre) in bodies.items():
        at = links[link][..., :3, :3] @ centre + links[link][..., :3, 3]
        energy = energy - mass * (at @ gravity_m_s2) / MM_PER_M
    return energy


def moving_bodies(masses: Mapping[str, Any]) -> dict[str, tuple[float, np.ndarray]]:
    """Gathers what `potential_energy` takes of a machine from the result of `mass_report`."""
    bodies = masses["bodies"].items()
    return {link: (one["mass_kg"], np.array(one["centre_m"]) * MM_PER_M) for link, one in bodies if link != "base"}


def holding_torque(
    assembly: Assembly, bodies: Mapping[str, tuple[float, np.ndarray]], p_mm: np.ndarray, gravity_m_s2: np.ndarray
) -> np.ndarray:
    """Computes the torque of each joint that holds the bodies of `potential_energy` at p, (..., 3) N m."""
    p = np.asarray(p_mm, dtype=float)
    steps = _STEP_MM * np.eye(3)

    def energy(at_mm: np.ndarray) -> np.ndarray:
        return potential_energy(assembly, bodies, at_mm, gravity_m_s2)

    gradient = np.stack([energy(p + s) - energy(p - s) for s in steps], axis=-1) / (2.0 * _STEP_MM / MM_PER_M)
    to_joints = np.swapaxes(jacobian(assembly.placement.geometry, p / MM_PER_M), -1, -2)
    return (to_joints @ gradient[..., None])[..., 0]
