"""A delta of three equal chains by vectors of a textbook: no formula of the project, azimuths as angles, mm nowhere.

Positions are found by Newton's method on the three rods' lengths, angles by bisection, derivatives by differences.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.optimize import brentq, fsolve

from delta_cad.design import Design
from delta_cad.drive.masses import Masses

STEP = 1e-6
VERTICAL = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True)
class Textbook:
    """A delta.

    Attributes:
        azimuths: (3,) rad.
        radii: (3,) of the shoulders, m.
        platform: Radius of the wrists, m.
        arm: m.
        rod: m.
    """

    azimuths: np.ndarray
    radii: np.ndarray
    platform: float
    arm: float
    rod: float

    def outwards(self, i: int) -> np.ndarray:
        """(3,) from the base's centre to a shoulder."""
        return np.array([math.cos(self.azimuths[i]), math.sin(self.azimuths[i]), 0.0])

    def directions(self, i: int, angle: float) -> tuple[np.ndarray, np.ndarray]:
        """(3,) along an arm, and where its elbow moves."""
        out = self.outwards(i)
        return math.cos(angle) * out + math.sin(angle) * VERTICAL, math.cos(angle) * VERTICAL - math.sin(angle) * out

    def forearm(self, i: int, angle: float, p: np.ndarray) -> np.ndarray:
        """(3,) from the elbow to the wrist, m."""
        out = self.outwards(i)
        return p + self.platform * out - self.radii[i] * out - self.arm * self.directions(i, angle)[0]

    def position(self, angles: np.ndarray, near: np.ndarray) -> np.ndarray:
        """(3,) the platform's centre at angles, the solution near a position, m."""

        def off(p: np.ndarray) -> np.ndarray:
            rods = np.array([self.forearm(i, angles[i], p) for i in range(3)])
            return (rods**2).sum(axis=1) / self.rod**2 - 1.0

        found, _, ended, _ = fsolve(off, near, xtol=1e-15, full_output=True)
        assert np.abs(off(found)).max() < 1e-13, ended
        return found

    def angles(self, p: np.ndarray) -> np.ndarray:
        """(3,) shoulder angles at a position, elbows outwards, rad.

        The wrist seen from the shoulder is at some angle; the elbow outwards is below it, and at most half a turn.
        """
        found = []
        for i in range(3):
            wrist = p + (self.platform - self.radii[i]) * self.outwards(i)
            seen = math.atan2(wrist[2], wrist @ self.outwards(i))

            def off(angle: float, i: int = i) -> float:
                return float(np.linalg.norm(self.forearm(i, angle, p))) - self.rod

            found.append(brentq(off, seen - math.pi, seen, xtol=1e-15))
        return np.array(found)

    def jacobian(self, angles: np.ndarray, p: np.ndarray) -> np.ndarray:
        """(3, 3 joints) velocity of the platform by the rate of each joint, m/rad, by differences."""
        columns = []
        for e in STEP * np.eye(3):
            columns.append((self.position(angles + e, p) - self.position(angles - e, p)) / (2.0 * STEP))
        return np.stack(columns, axis=-1)

    def potential(self, masses: Masses, p: np.ndarray, gravity: np.ndarray) -> float:
        """Potential energy of platform, rods and arms at a position, J: zero with all of them at their shoulders."""
        angles, total = self.angles(p), -masses.at_wrists * float(p @ gravity)
        for i in range(3):
            along, across = self.directions(i, angles[i])
            moment = (masses.arm_along + masses.at_elbow * self.arm) * along + masses.arm_across * across
            total -= float(moment @ gravity)
        return total

    def kinetic(self, masses: Masses, p: np.ndarray, v: np.ndarray) -> float:
        """Kinetic energy of the bodies at a velocity, J, from differences of where arms and elbows are."""
        ahead, behind = self.angles(p + STEP * v), self.angles(p - STEP * v)
        rates = (ahead - behind) / (2.0 * STEP)
        total = 0.5 * masses.platform * v @ v + 0.5 * (masses.arm_inertia + masses.rotor_inertia) * rates @ rates
        for i in range(3):
            elbow = self.arm * (self.directions(i, ahead[i])[0] - self.directions(i, behind[i])[0]) / (2.0 * STEP)
            total += 0.5 * (masses.rod_elbow * elbow @ elbow + 2.0 * masses.rod_cross * elbow @ v)
            total += 0.5 * masses.rod_wrist * v @ v
        return float(total)


def textbook(design: Design) -> Textbook:
    """The delta of a design file's own numbers."""
    m = design.mechanism
    azimuths = np.radians([0.0, 120.0, -120.0] if m.azimuths_deg is None else m.azimuths_deg)
    radii = np.array([m.base_radius_mm] * 3 if m.base_radii_mm is None else m.base_radii_mm) / 1e3
    lengths = (m.platform_radius_mm, m.upper_arm_length_mm, m.forearm_length_mm)
    return Textbook(azimuths, radii, *(length / 1e3 for length in lengths))


def cube_points(design: Design, count: int, seed: int) -> np.ndarray:
    """(count, 3) positions in a design's cube, its corners first, m."""
    cube = design.cube
    half, middle = cube.half_side_mm / 1e3, (cube.centre_x_mm or 0.0, 0.0, cube.bottom_height_mm + cube.half_side_mm)
    corners = np.array(np.meshgrid(*3 * [[-1.0, 1.0]])).reshape(3, -1).T
    inside = np.random.default_rng(seed).uniform(-1.0, 1.0, (max(count - len(corners), 0), 3))
    return np.array(middle) / 1e3 + half * np.concatenate([corners, inside])[:count]
