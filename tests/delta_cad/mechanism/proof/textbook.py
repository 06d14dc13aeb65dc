"""A placed machine at one position, by textbook: homogeneous transforms, bisection, linear algebra; no package formula.

Each chain is a base turn about z, a move out to its shoulder, a turn about the shoulder axis and a move along the arm.
The shoulder angle is bisected until the rod fits; all else follows from the vectors between the joints' places.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import product
from typing import NamedTuple

import numpy as np

UP = np.array([0.0, 0.0, 1.0])
SENSES = np.array(list(product((1.0, -1.0), repeat=3)))


class Machine(NamedTuple):
    """Lengths in m, azimuths in rad, of chains 0, 1, 2."""

    azimuths: tuple[float, float, float]
    base_radii: tuple[float, float, float]
    platform_radius: float
    upper_arm: float
    forearm: float


class Loads(NamedTuple):
    """What moves and rubs, SI units, in the words of the limits."""

    force: float
    carried: float
    at_elbow: float
    between: float
    joint: float
    gravity: tuple[float, float, float]
    held: float
    along_arm: float
    across_arm: float
    loose_mass: float
    loose_moment: float
    drive: float
    upright: float
    level: float
    encoder_count: float


def turned(axis: int, angle: float) -> np.ndarray:
    """(4, 4) turn about y or z."""
    c, s = np.cos(angle), np.sin(angle)
    m = np.eye(4)
    j, k = (0, 1) if axis == 2 else (2, 0)
    m[j, j], m[j, k], m[k, j], m[k, k] = c, -s, s, c
    return m


def moved(x: float, y: float = 0.0) -> np.ndarray:
    """(4, 4) move along x and y."""
    m = np.eye(4)
    m[:2, 3] = x, y
    return m


def bisected(of, low: float, high: float) -> float:
    """Where a function changes sign, between two places of opposite sign."""
    sign = np.sign(of(low))
    for _ in range(200):
        middle = 0.5 * (low + high)
        if np.sign(of(middle)) == sign:
            low = middle
        else:
            high = middle
    return 0.5 * (low + high)


@dataclass(frozen=True)
class Pose:
    """The joints' places and what follows from them.

    Attributes:
        theta: (3,) shoulder angles, rad.
        shoulders: (3, 3), m.
        elbows: (3, 3), m.
        wrists: (3, 3), m.
        rates: (3, 3) velocity of each elbow for a rate of 1 of its joint, m/rad.
        axes: (3, 3) unit vectors along the shoulder axes.
        jacobian: (3, 3) handle's velocity, one column a joint, m/rad.
        p: (3,) the platform's centre, m.
    """

    theta: np.ndarray
    shoulders: np.ndarray
    elbows: np.ndarray
    wrists: np.ndarray
    rates: np.ndarray
    axes: np.ndarray
    jacobian: np.ndarray
    p: np.ndarray

    @property
    def rods(self) -> np.ndarray:
        """(3, 3) from elbow to wrist, m."""
        return self.wrists - self.elbows


def pose(m: Machine, p: np.ndarray) -> Pose:
    """Closes a machine at a position, elbows outwards.

    Raises:
        ValueError: A chain cannot be closed.
    """
    places = []
    for azimuth, radius in zip(m.azimuths, m.base_radii, strict=True):
        shoulder = turned(2, azimuth) @ moved(radius)
        wrist = np.eye(4)
        wrist[:3, 3] = p
        wrist = (wrist @ turned(2, azimuth) @ moved(m.platform_radius))[:, 3]

        def elbow(angle: float, shoulder: np.ndarray = shoulder) -> np.ndarray:
            return (shoulder @ turned(1, -angle) @ moved(m.upper_arm))[:, 3]

        def excess(angle: float, wrist: np.ndarray = wrist, elbow=elbow) -> float:
            return float(np.linalg.norm(wrist - elbow(angle)) - m.forearm)

        x, _, z, _ = np.linalg.solve(shoulder, wrist)
        towards = float(np.arctan2(z, x))
        if excess(towards) > 0.0 or excess(towards - np.pi) < 0.0:
            raise ValueError
        theta = bisected(excess, towards - np.pi, towards)  # an arm that leads the wrist is more level than its bearing
        rate = shoulder[:3, :3] @ (m.upper_arm * np.array([-np.sin(theta), 0.0, np.cos(theta)]))
        places.append((theta, shoulder[:3, 3], elbow(theta)[:3], wrist[:3], rate, shoulder[:3, 1]))
    theta, shoulders, elbows, wrists, rates, axes = (np.array(column) for column in zip(*places, strict=True))
    # a rod keeps its length: its part of the wrist's velocity is its part of the elbow's
    jacobian = np.linalg.solve(wrists - elbows, np.diag(((wrists - elbows) * rates).sum(axis=1)))
    return Pose(theta, shoulders, elbows, wrists, rates, axes, jacobian, np.asarray(p))


def inertia(at: Pose, load: Loads) -> np.ndarray:
    """(3, 3) the handle's inertia from the energies of three velocities and their sums, kg."""
    inverse = np.linalg.inv(at.jacobian)

    def twice_energy(v: np.ndarray) -> float:
        joints = inverse @ v
        elbows = joints[:, None] * at.rates
        total = load.carried * v @ v + load.at_elbow * (elbows**2).sum() + load.joint * joints @ joints
        return float(total + 2.0 * load.between * (elbows @ v).sum())

    unit = np.eye(3)
    both = np.array([[twice_energy(a + b) for b in unit] for a in unit])
    alone = np.diag(both) / 4.0
    return (both - alone[:, None] - alone) / 2.0


def figures(m: Machine, at: Pose, load: Loads) -> dict[str, float]:
    """The worst chain's figures, by the names of the limits' figures, SI units."""
    rods, jacobian = at.rods, at.jacobian
    inverse = np.linalg.inv(jacobian)
    n = rods / np.linalg.norm(rods, axis=1)[:, None]
    along = (at.elbows - at.shoulders) / m.upper_arm
    direction = at.rates / m.upper_arm
    between = np.arccos((-along * n).sum(axis=1))
    # a pull in one rod of a pair and a push in the other, 1 N each and 1 m apart: a couple about the platform's centre
    couples = []
    for wrist, axis, unit in zip(at.wrists, at.axes, n, strict=True):
        ends = (wrist + 0.5 * axis - at.p, 1.0), (wrist - 0.5 * axis - at.p, -1.0)
        couples.append(sum(np.cross(arm, pull * unit) for arm, pull in ends))
    gx, gy, gz = load.gravity
    size, plane = np.sqrt(gx * gx + gy * gy + gz * gz), np.array([gx, 0.0, gz])
    power = load.held * plane @ jacobian + (load.along_arm * direction - load.across_arm * along) @ plane
    columns = np.linalg.norm(jacobian, axis=0)
    force = load.force + size * load.loose_mass + gy * load.held
    held = force * columns + np.abs(power) + size * load.loose_moment + gy * np.hypot(load.along_arm, load.across_arm)
    # the direction of most, for each sense in which the joints turn: along what all of them brake together
    brakes = load.drive * SENSES @ inverse
    felt = np.hypot(np.abs(brakes[:, 2]) + load.upright, np.hypot(brakes[:, 0], brakes[:, 1]) + load.level)
    singular = np.linalg.svd(jacobian, compute_uv=False)
    return {
        "": float(np.linalg.det(n)),
        "reach": float((rods * direction).sum(axis=1).min()),
        "torque": float(load.force * columns.max()),
        "torque_with_gravity": float(held.max()),
        "kappa": float(singular[0] / singular[2]),
        "lean": float(np.abs(np.arcsin((n * at.axes).sum(axis=1))).max()),
        "shoulder_min": float(at.theta.min()),
        "shoulder_max": float(at.theta.max()),
        "elbow_angle": float(between.min()),
        "effective_mass": float(np.linalg.eigvalsh(inertia(at, load))[2]),
        "friction": float(felt.max()),
        "position_step": float(load.encoder_count * np.linalg.norm(SENSES @ jacobian.T, axis=1).max()),
        "couple_index": float(np.linalg.svd(np.array(couples), compute_uv=False)[2]),
    }
