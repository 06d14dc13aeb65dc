"""The device at rest at a pose, linearised for the discrete model, along one axis or in all three joints.

At rest the velocity terms of the equations of motion vanish in first order, which leaves `M(p) a = G^T torque - G^T
viscous G v + force`. Left out: the stiffness of gravity less that of its compensation, and what the change of J with
the pose makes of a standing force: off the centre and at 3 N they moved a limit of 6600 N/m by 16. Importing this
module loads numba.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from haptics.control.filters import low_pass
from haptics.loop.choice import LoopChoice
from haptics.loop.discrete import (
    LinearEstimator,
    Ports,
    SampledBody,
    SampledLoop,
    Timing,
    attached,
    held,
    linear_model,
    loaded,
    sampled_loop,
)
from haptics.loop.hardware import LOSS, reading_age, sensor_errors, structure_stiffness
from haptics.model.drive_train import STATES
from haptics.model.machine import MachineModel
from haptics.model.plant import Hand, Plant, motion

UNIT = 1e-9  # Deviation of a normal's length from 1 that rounding may cause


class Structure(NamedTuple):
    """Compliance between platform and knob.

    Attributes:
        stiffness: (3, 3) N/m.
        damping: (3, 3) N s/m.
    """

    stiffness: np.ndarray
    damping: np.ndarray


@dataclass(frozen=True)
class Linearised:
    """The device at a pose.

    Attributes:
        jacobian: (3 axes, 3 chains), m/rad: `v = J theta_dot`.
        mass: (3, 3) mass matrix of the platform's coordinates, kg, all of the device as if rigid, without a hand.
        plant: The device.
        structure: What gives way under the knob; None for the plant's, alike in all directions.
    """

    jacobian: np.ndarray
    mass: np.ndarray
    plant: Plant
    structure: Structure | None = None

    @property
    def viscous(self) -> float:
        """Friction of each joint, N m s/rad."""
        return self.plant.viscous

    @property
    def smallest_mass(self) -> float:
        """Smallest effective mass in any direction, kg: an eigenvalue of the mass matrix."""
        return float(np.linalg.eigvalsh(self.mass)[0])

    def effective_mass(self, normal: ArrayLike) -> float:
        """Mass felt along a direction with the others free, `1 / (n^T M^-1 n)`, kg.

        Args:
            normal: (3,) unit vector.

        Raises:
            ValueError: Not a unit vector.
        """
        n = _unit(normal)
        return float(1.0 / (n @ np.linalg.solve(self.mass, n)))

    def effective_friction(self, normal: ArrayLike) -> float:
        """Least viscous friction of a motion whose part along a direction is given: `viscous / |J^T n|^2`, N s/m.

        Args:
            normal: (3,) unit vector.

        Raises:
            ValueError: Not a unit vector.
        """
        return float(self.viscous / np.square(self.jacobian.T @ _unit(normal)).sum())

    def joint_loop(
        self, normal: ArrayLike, hand: Hand, timing: Timing, estimator: LinearEstimator, *, at_motor: bool = False
    ) -> SampledLoop:
        """A wall with all of the device behind it, in the joints, where velocity is estimated and commands arrive.

        `torque = -J^T n (K n^T J d theta + B n^T J theta_dot)`; gains in N/m and N s/m.

        Args:
            normal: (3,) unit normal of the wall.
            hand: Who holds the handle, alike in all directions.
            timing: Period, delay, lag.
            estimator: Estimator of each joint's rate.
            at_motor: Whether the encoders sit before the cable.

        Raises:
            ValueError: Not a unit vector.
        """
        n = _unit(normal)
        # the gains move the hand's mass too: that sets the range of the scan
        scale = self.effective_mass(n) + hand.mass
        body, _ = self.body(hand)
        return sampled_loop(body, timing, estimator, self.ports(n[:, None], len(body.mass), at_motor), scale)

    def ports(self, along: np.ndarray, coordinates: int, at_motor: bool = False) -> Ports:
        """Where forces along directions act on the coordinates of `body`, and what is read along them.

        Args:
            along: (3, m) directions.
            coordinates: Of the body.
            at_motor: Whether the encoders sit before the cable.
        """
        through = self.jacobian.T @ along
        on_arm, on_rotor = np.zeros((coordinates, along.shape[1])), np.zeros((coordinates, along.shape[1]))
        on_arm[:3] = through
        on_rotor[(slice(3, 6) if self.plant.cable_stiffness > 0.0 else slice(0, 3))] = through
        return Ports(on_rotor, on_rotor.T if at_motor else on_arm.T)

    def body(self, hand: Hand) -> tuple[SampledBody, np.ndarray]:
        """Device and hand: the arms' angles, then the rotors' where the cable gives way, the knob's place where the
        structure does, the arm's mass behind a grasp; kg m^2, N m s/rad, N m/rad, and kg, N s/m, N/m.

        Args:
            hand: Who holds it.

        Returns:
            The body, and (3, n) the place of what the hand holds.
        """
        j, par, structure = self.jacobian, self.plant, self.structure
        if structure is None:
            structure = Structure(par.structure_stiffness * np.eye(3), par.structure_damping * np.eye(3))
        arms = SampledBody(j.T @ self.mass @ j, np.zeros((3, 3)), np.zeros((3, 3)))
        body, place, rotor = loaded(arms, j, -par.knob), j, np.eye(3)
        body = loaded(body, rotor, -par.rotor_inertia)
        if par.cable_stiffness > 0.0:
            body, rotor = attached(body, rotor, par.rotor_inertia, par.cable_damping, par.cable_stiffness)
            place = np.hstack([place, np.zeros((3, 3))])
        body = loaded(body, rotor, damping=par.viscous)
        if structure.stiffness.any():
            body, place = attached(body, place, par.knob, structure.damping, structure.stiffness)
        held_body = held(body, place, hand)
        return held_body, np.pad(place, ((0, 0), (0, len(held_body.mass) - place.shape[1])))


class LinearLoop:
    """A device in a loop about a pose, linearised: from it follow eigenvalues, passivity and noise.

    Args:
        machine: The device.
        loop: The loop.
        here: The device at the pose.
        delay: From reading to torque, s; the loop's nominal one if left out. The age of a reading comes on top.
    """

    def __init__(
        self,
        machine: MachineModel,
        loop: LoopChoice,
        here: Linearised,
        delay: float | None = None,
    ) -> None:
        self.here, self.errors = here, sensor_errors(machine, loop)
        late = (loop.delay if delay is None else delay) + reading_age(machine, loop)
        self.timing = Timing(loop.period, late, loop.current_lag)
        self.at_motor = bool(self.errors.at_motor)
        self.estimator = linear_model(low_pass(loop.period, loop.corner))


def structure_at(machine: MachineModel, p: ArrayLike, loss: float = LOSS[1], share: float = 1.0) -> Structure:
    """Compliance under the knob at a position: as built, by direction, or as the design requires.

    Args:
        machine: The device.
        p: (3,) m.
        loss: Share of critical that each direction's own swing of the knob damps.
        share: Of the stiffness.
    """
    stiffness = share * structure_stiffness(machine, np.asarray(p, dtype=float))
    values, turns = np.linalg.eigh(stiffness)
    root = turns * np.sqrt(values) @ turns.T
    return Structure(stiffness, 2.0 * loss * math.sqrt(machine.masses.platform) * root)


def linearise(par: Plant, p: ArrayLike, structure: Structure | None = None) -> Linearised:
    """The device at rest at a pose.

    Args:
        par: The plant.
        p: (3,) platform centre, m.
        structure: What gives way under the knob; the plant's, alike in all directions, if left out.

    Returns:
        Its Jacobian, mass matrix and friction.

    Raises:
        ValueError: The pose cannot be reached, or its forearms lie in one plane.
    """
    state, work = np.zeros(STATES), np.zeros((6, 3))
    state[:3] = p
    m11, m22, m33, m12, m13, m23 = motion(par, 0.0, state, work)
    mass = np.array([[m11, m12, m13], [m12, m22, m23], [m13, m23, m33]])
    inverse = work[:3]
    mass += par.knob * np.eye(3) + par.rotor_inertia * inverse.T @ inverse
    if not (np.isfinite(mass).all() and np.linalg.cond(inverse) < 1e12):  # beyond, no digit of J would be left
        raise ValueError(f"the device cannot be linearised at {np.asarray(p).tolist()} m: out of reach, or singular")
    return Linearised(np.linalg.inv(inverse), mass, par, structure)


def _unit(normal: ArrayLike) -> np.ndarray:
    n = np.asarray(normal, dtype=float)
    if n.shape != (3,) or not abs(float(np.linalg.norm(n)) - 1.0) <= UNIT:
        raise ValueError(f"normal is {n.tolist()}; it must be a unit vector of 3")
    return n
