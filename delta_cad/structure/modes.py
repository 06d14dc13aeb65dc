"""First natural frequency of the handle with locked actuators."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from delta_cad.common.units import MM_PER_M
from delta_cad.drive.masses import rod_masses
from delta_cad.structure.beam_model import BeamModel
from delta_cad.structure.compliance import Compliance, compliance
from delta_cad.structure.mounting import Mounting
from delta_cad.structure.unit_loads import unit_loads


@dataclass(frozen=True)
class MovingBody:
    """A rigid body in its link's frame.

    Attributes:
        mass_kg: Mass.
        centre_mm: (3,) centre of mass.
        inertia_kg_mm2: (3, 3) inertia about the link's origin.
    """

    mass_kg: float
    centre_mm: np.ndarray
    inertia_kg_mm2: np.ndarray


@dataclass(frozen=True)
class Moving:
    """What moves, the chains alike.

    Attributes:
        platform: Platform with all it carries; origin in the wrists' plane.
        arm: Upper arm with all it carries; origin in the shoulder.
        rod: (elbow, cross, wrist) masses of one rod, kg, see `drive.masses`.
        base: All that stands on the base plate, and under it; None: what it is mounted on gives nothing.
    """

    platform: MovingBody
    arm: MovingBody
    rod: tuple[float, float, float]
    base: MovingBody | None = None

    @property
    def rod_kg(self) -> float:
        """Mass of one rod."""
        return self.rod[0] + 2.0 * self.rod[1] + self.rod[2]


def moving(bodies: Mapping[str, Any], forearm_length: float) -> Moving:
    """Reads what moves from the bodies of a mass report.

    Args:
        bodies: `bodies` of `mass_properties.json`.
        forearm_length: L_B, m.
    """

    def body(name: str) -> MovingBody:
        mass, centre = float(bodies[name]["mass_kg"]), np.array(bodies[name]["centre_m"])
        inertia = np.array(bodies[name]["inertia_kg_m2"]) + mass * (
            centre @ centre * np.eye(3) - np.outer(centre, centre)
        )
        return MovingBody(mass, centre * MM_PER_M, inertia * MM_PER_M**2)

    rod = bodies["rod_0_0"]
    across = float(np.array(rod["inertia_kg_m2"])[2][2])
    ends = rod_masses(float(rod["mass_kg"]), float(rod["centre_m"][0]), across, forearm_length)
    return Moving(body("platform"), body("upper_arm_0"), ends, body("base"))


def mass_matrix(table: BeamModel, what: Moving, p_mm: np.ndarray, given: Compliance) -> np.ndarray:
    """Computes the mass that the platform's six motions move, the elbows following as they give (Guyan).

    Args:
        table: The machine.
        what: What moves.
        p_mm: (..., 3) platform's centre, mm.
        given: The machine's flexibility there.

    Returns:
        (..., 6, 6) kg, kg mm, kg mm^2 about the wrists' plane's centre.

    Source:
        Guyan, Reduction of stiffness and mass matrices, AIAA Journal 3 (1965): motions of masses inside follow those
        of a load on what is kept; the frequency so found is not below the true one. The arm is taken as rigid about
        its shoulder, a rod as rigid between its balls.
    """
    p = np.asarray(p_mm, dtype=float)
    shape = p.shape[:-1]
    body = what.platform
    total = np.zeros((*shape, 6, 6))
    total += _rigid(body.mass_kg, body.centre_mm, body.inertia_kg_mm2)
    unit = unit_loads(table, p)
    stiffness = np.linalg.inv(given.platform)
    elbows = given.elbows @ stiffness[..., None, :, :]  # (..., 3, 6, 6) arm's axes by the platform's motion
    length = table.geometry.upper_arm_length * MM_PER_M
    inertia = what.arm.inertia_kg_mm2
    # the arm about its shoulder: the elbow's motions across it are turns, along it and about it as they are
    arm = np.diag([what.arm.mass_kg, inertia[2, 2] / length**2, inertia[1, 1] / length**2, inertia[0, 0], 0.0, 0.0])
    total += (np.swapaxes(elbows, -1, -2) @ arm @ elbows).sum(axis=-3)
    at_elbow, cross, at_wrist = what.rod
    g = table.geometry
    wrist = g.platform_radius * MM_PER_M * g.radial
    for i in range(3):
        for side in (-0.5, 0.5):
            start = np.concatenate([np.eye(3), _turning(side * table.width_mm * np.array([0.0, 1.0, 0.0]))], axis=-1)
            u = np.swapaxes(unit.arms[..., i, :, :], -1, -2) @ (start @ elbows[..., i, :, :])
            v = np.concatenate([np.eye(3), _turning(wrist[i] + side * table.width_mm * g.tangential[i])], axis=-1)
            mixed = np.swapaxes(u, -1, -2) @ v
            total += at_elbow * np.swapaxes(u, -1, -2) @ u + cross * (mixed + np.swapaxes(mixed, -1, -2))
            total += at_wrist * v.T @ v
    if what.base is not None and table.mounting is not None:
        carried = _rigid_of(table.mounting) @ given.blocks @ stiffness
        base = _rigid(what.base.mass_kg, what.base.centre_mm, what.base.inertia_kg_mm2)
        total += np.swapaxes(carried, -1, -2) @ base @ carried
    return total


def _rigid_of(mounting: Mounting) -> np.ndarray:
    """(6, 18) motion of the base about its origin, as a rigid body, that fits the motions of its foot blocks best."""
    rows = [np.block([[np.eye(3), _turning(at)], [np.zeros((3, 3)), np.eye(3)]]) for at in mounting.blocks_mm]
    weights = np.tile([1.0] * 3 + [float(np.linalg.norm(mounting.blocks_mm[0]))] * 3, 3)  # a turn as it moves a block
    return np.linalg.pinv(weights[:, None] * np.concatenate(rows)) * weights


def first_mode_Hz(table: BeamModel, what: Moving, p_mm: np.ndarray) -> np.ndarray:
    """Computes the first natural frequency, actuators held, (...) Hz.

    The least root of `K q = w^2 M q` with the 6 x 6 stiffness of the platform; the stem counts as rigid.

    Args:
        table: The machine.
        what: What moves.
        p_mm: (..., 3) platform's centre, mm.
    """
    given = compliance(table, p_mm)
    mass = mass_matrix(table, what, p_mm, given)
    root = np.linalg.cholesky(mass)
    most = np.linalg.eigvalsh(np.swapaxes(root, -1, -2) @ given.platform @ root)[..., -1]
    return np.sqrt(MM_PER_M / most) / (2.0 * np.pi)


def _turning(arm: np.ndarray) -> np.ndarray:
    """(3, 3) displacement of a point by a small turn: turn cross arm."""
    x, y, z = arm
    return np.array([[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]])


def _rigid(mass: float, centre: np.ndarray, inertia: np.ndarray) -> np.ndarray:
    """(6, 6) mass of a rigid body by the motion of its origin."""
    moved = mass * _turning(centre)
    return np.block([[mass * np.eye(3), moved], [moved.T, inertia]])
