"""The device at rest at a pose, linearised: what the discrete model takes, along one axis or in all three joints.

At rest the velocity terms of the equations of motion vanish in first order, which leaves `M(p) a = G^T torque - G^T
viscous G v + force`. Left out: the stiffness of gravity less that of its compensation, and what the change of J with
the pose makes of a standing force: off the centre and at 3 N they moved a limit of 6600 N/m by 16. Importing this
module loads numba.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from haptics.model.plant import STATES, Hand, Plant, motion
from haptics.stability.discrete import SampledBody, SampledLoop, Timing, sampled_loop
from haptics.stability.estimator_models import LinearEstimator

UNIT = 1e-9  # Deviation of a normal's length from 1 that rounding may cause


@dataclass(frozen=True)
class Linearised:
    """The device at a pose.

    Attributes:
        jacobian: (3 axes, 3 chains), m/rad: `v = J theta_dot`.
        mass: (3, 3) mass matrix of the platform's coordinates, kg, without a hand.
        viscous: Friction of each joint, N m s/rad.
    """

    jacobian: np.ndarray
    mass: np.ndarray
    viscous: float

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

    def joint_loop(self, normal: ArrayLike, hand: Hand, timing: Timing, estimator: LinearEstimator) -> SampledLoop:
        """A wall with all of the device behind it, in the joints, where velocity is estimated and commands arrive.

        `torque = -J^T n (K n^T J d theta + B n^T J theta_dot)`; gains in N/m and N s/m.

        Args:
            normal: (3,) unit normal of the wall.
            hand: Who holds the handle, alike in all directions.
            timing: Period, delay, lag.
            estimator: Estimator of each joint's rate.

        Raises:
            ValueError: Not a unit vector.
        """
        n = _unit(normal)
        through = self.jacobian.T @ n
        # the gains move the hand's mass too: that sets the range of the scan
        scale = self.effective_mass(n) + hand.mass
        return sampled_loop(self.body(hand), timing, estimator, np.outer(through, through), scale)

    def body(self, hand: Hand) -> SampledBody:
        """Device and hand in joint coordinates: kg m^2, N m s/rad, N m/rad."""
        j = self.jacobian
        return SampledBody(
            mass=j.T @ (self.mass + hand.mass * np.eye(3)) @ j,
            damping=self.viscous * np.eye(3) + hand.damping * (j.T @ j),
            stiffness=hand.stiffness * (j.T @ j),
        )


def linearise(par: Plant, p: ArrayLike) -> Linearised:
    """The device at rest at a pose.

    Args:
        par: The plant.
        p: (3,) platform centre, m.

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
    if not (np.isfinite(mass).all() and np.linalg.cond(inverse) < 1e12):  # beyond, no digit of J would be left
        raise ValueError(f"the device cannot be linearised at {np.asarray(p).tolist()} m: out of reach, or singular")
    return Linearised(np.linalg.inv(inverse), mass, par.viscous)


def _unit(normal: ArrayLike) -> np.ndarray:
    n = np.asarray(normal, dtype=float)
    if n.shape != (3,) or not abs(float(np.linalg.norm(n)) - 1.0) <= UNIT:
        raise ValueError(f"normal is {n.tolist()}; it must be a unit vector of 3")
    return n
