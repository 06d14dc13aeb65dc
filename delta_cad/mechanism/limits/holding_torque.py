"""Torque with gravity: every joint holds a force on the handle in its worst direction and what the machine weighs.

Per unit rate of joint i, with `J_i` the platform's velocity (column i of J), `e_i` the direction in which the elbow
moves and `a_i` that of the upper arm, in whose plane both lie, all that moves falls with the power

    gamma . (M J_i + S e_i - Z a_i),

M being what moves with the wrists, S and Z the first moments of what turns about the shoulder, along the upper arm and
square to it. A force F in any direction takes at most `F |J_i|` more. What is known only in size, because it may lie
anywhere about a line, takes at most `g (m |J_i| + s)`, and so much is required.

A proof is made over the half y >= 0 of the cube, of which the other is the mirror image: gravity may lie in the plane
of x and z; of a component along y only the size is used. The moments are those of all chains, the spread among them in
s. Of a machine beyond its direct singularity nothing is said but that it is there.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar, Self

import numpy as np

from delta_cad.common.jit import compiled
from delta_cad.mechanism.enclosure import pose as forms
from delta_cad.mechanism.enclosure.affine_form import (
    ROUND,
    add,
    at,
    constant,
    inverse,
    lower,
    multiply,
    root,
    scale,
    subtract,
)
from delta_cad.mechanism.enclosure.interval import Interval, Slopes
from delta_cad.mechanism.enclosure.slope_pose import SlopePose, cross
from delta_cad.mechanism.enclosure.table import HIGH, Enclosure, store
from delta_cad.mechanism.geometry import DeltaGeometry
from delta_cad.mechanism.inverse import arm_direction
from delta_cad.mechanism.jacobian import velocity_map
from delta_cad.mechanism.limits.limit import FigureOfMerit, Values
from delta_cad.mechanism.limits.numbers import Masses
from delta_cad.mechanism.limits.torque import RANGE, HeldForce
from delta_cad.mechanism.statics import worst_joint_torque

_SIGNS = (1.0, -1.0)
_UPWARDS = 1.0 + 2.0**-48  # lifts a sum of a few products of doubles over its own roundings


@dataclass(frozen=True)
class HeldMasses(Masses):
    """What of the moving bodies' masses gravity acts on; the same for the three chains.

    Attributes:
        gravity_x: Component of the acceleration along the base's x axis, m/s^2.
        gravity_y: Size of that along y.
        gravity_z: That along z, negative where it pulls the platform upon the arms.
        carried_mass: M, kg.
        arm_moment: S, kg m.
        cross_moment: Z, kg m.
        loose_mass: m, kg.
        loose_moment: s, kg m.
    """

    gravity_x: float
    gravity_y: float
    gravity_z: float
    carried_mass: float
    arm_moment: float
    cross_moment: float
    loose_mass: float
    loose_moment: float

    keys: ClassVar = {
        "gravity_x": "gravity_x_m_s2",
        "gravity_y": "gravity_y_m_s2",
        "gravity_z": "gravity_z_m_s2",
        "carried_mass": "carried_mass_kg",
        "arm_moment": "arm_moment_kg_m",
        "cross_moment": "cross_moment_kg_m",
        "loose_mass": "loose_mass_kg",
        "loose_moment": "loose_moment_kg_m",
    }
    signed: ClassVar = ("gravity_x", "gravity_z", "arm_moment", "cross_moment")

    @property
    def aside(self) -> tuple[float, float]:
        """What takes torque in any direction: N to a joint's `|J_i|`, and N m; rounded up."""
        size = math.hypot(self.gravity_x, self.gravity_y, self.gravity_z)
        turning = math.hypot(self.arm_moment, self.cross_moment)
        force = size * self.loose_mass + self.gravity_y * self.carried_mass
        return force * _UPWARDS, (size * self.loose_moment + self.gravity_y * turning) * _UPWARDS


def gravity_torque(g: DeltaGeometry, p: np.ndarray, masses: HeldMasses) -> np.ndarray:
    """Computes the largest torque that gravity may ask of each joint, whatever is known only in size.

    Args:
        g: The mechanism.
        p: (..., 3) platform centre in the base frame, m.
        masses: What moves.

    Returns:
        (..., 3 chains) N m, not negative; NaN where a chain is open or at a direct singularity.
    """
    m, (force, torque) = masses, masses.aside
    cos, sin = arm_direction(g, p)
    gravity = np.array([m.gravity_x, 0.0, m.gravity_z])
    radial = g.radial @ gravity
    arm = m.arm_moment * (cos * m.gravity_z - sin * radial) - m.cross_moment * (cos * radial + sin * m.gravity_z)
    carried = m.carried_mass * np.einsum("a,...ai->...i", gravity, velocity_map(g, p))
    return np.abs(carried + arm) + worst_joint_torque(g, p, force) + torque


def _torques(limit: HoldingTorque, g: DeltaGeometry, p: np.ndarray) -> np.ndarray:
    return worst_joint_torque(g, p, limit.force) + gravity_torque(g, p, limit.masses)


@compiled
def _enclose(pose, k, n, work, out, row):
    """Computes `det (T - s + gravity on the arm) - w_i L_A (M gamma . (s_j x s_k) + F |s_j x s_k|)`, either sign.

    Each joint has two margins, for the two senses in which it turns. That one is negative says that the limit is broken
    only where det is positive.
    """
    lb2, det, la = at(pose, forms.FOREARM_2), at(pose, forms.DETERMINANT), at(pose, forms.UPPER_ARM)
    allowed, force = constant(k[n], k[n + 1]), constant(k[n + 2], k[n + 3])
    for i in range(3):
        c = 1.0 if i == 0 else pose[forms.COSINE, 0]  # exact in a proof; its two roundings are in the error
        product = at(pose, forms.PRODUCT + i)
        face = root(subtract(multiply(lb2, lb2), multiply(product, product)))
        j, h = forms.FOREARM + 3 * ((i + 1) % 3), forms.FOREARM + 3 * ((i + 2) % 3)
        x = subtract(multiply(at(pose, j + 1), at(pose, h + 2)), multiply(at(pose, j + 2), at(pose, h + 1)))
        z = subtract(multiply(at(pose, j), at(pose, h + 1)), multiply(at(pose, j + 1), at(pose, h)))
        fall = add(multiply(constant(k[n + 4], k[n + 5]), x), multiply(constant(k[n + 6], k[n + 7]), z))
        along = multiply(constant(k[n + 8] - c * k[n + 9], k[n + 12]), at(pose, forms.ELBOW_RADIAL + i))
        up = multiply(constant(-c * k[n + 10] - k[n + 11], k[n + 12]), at(pose, forms.ELBOW_VERTICAL + i))
        arm = multiply(add(along, up), inverse(la))
        lever = multiply(at(pose, forms.W + i), la)
        most = multiply(force, face)
        for sense in range(2):
            sign = 1.0 - 2.0 * sense
            left = multiply(det, subtract(allowed, scale(sign, arm)))
            store(out, row + 2 * i + sense, subtract(left, multiply(lever, add(scale(sign, fall), most))))
            if not lower(det) > 0.0:
                out[row + 2 * i + sense, HIGH] = math.inf


@dataclass(frozen=True)
class HoldingTorque(HeldForce):
    """Largest torque of every joint for a force in any direction on the handle and gravity together, N m and N."""

    masses: HeldMasses

    name: ClassVar = "holding_torque"
    keys: ClassVar = {
        "force": "holding_force_N",
        "torque_max": "holding_torque_max_N_m",
        "masses": "held_masses",
    }
    figures: ClassVar = (FigureOfMerit("torque_with_gravity", "N m", _torques, "torque_max", RANGE),)
    with_: ClassVar = " with gravity"
    needs: ClassVar = "held_masses"
    mass_kinds: ClassVar = {"masses": HeldMasses}
    enclosure: ClassVar = Enclosure(forms.FOREARMS, 13, 6, _enclose)

    @classmethod
    def stated(cls, values: Values, strict: bool = False) -> Self | None:
        """Makes the limit where the masses that gravity acts on are known."""
        del strict
        masses = values.get("held_masses")
        return None if masses is None else cls(values["force_N"], values["joint_torque_N_m"], masses)

    def describe(self, values: Values) -> str:
        """Says what is required."""
        del values
        return f"{self.torque_max:g} N m for {self.force:g} N and gravity (requirements.joint_torque_N_m)"

    def numbers(self) -> tuple[float, ...]:
        """Gives torque and force left, M gamma, and the arms' moments by gravity along z and x, with their errors."""
        m, (force, torque) = self.masses, self.masses.aside
        left, total = self.torque_max - torque, self.force + force
        carried = m.carried_mass * m.gravity_x, m.carried_mass * m.gravity_z
        size = (abs(m.gravity_x) + abs(m.gravity_z)) * (abs(m.arm_moment) + abs(m.cross_moment))
        return (
            *(left, 4.0 * ROUND * (self.torque_max + torque)),
            *(total, 4.0 * ROUND * total),
            *(carried[0], ROUND * abs(carried[0])),
            *(carried[1], ROUND * abs(carried[1])),
            *(m.arm_moment * m.gravity_z, m.cross_moment * m.gravity_x),
            *(m.arm_moment * m.gravity_x, m.cross_moment * m.gravity_z),
            2.0 * ROUND * size,
        )

    def interval_margins(self, pose: SlopePose, exact: Callable[[float], Interval]) -> list[Slopes]:
        """Computes the same margins from cross products, sines and cosines."""
        m = self.masses
        gravity = exact(m.gravity_x), exact(m.gravity_y), exact(m.gravity_z)
        size = (gravity[0].square() + gravity[1].square() + gravity[2].square() + exact(2.0**-1000)).root()
        arm, off = exact(m.arm_moment), exact(m.cross_moment)
        turning = (arm.square() + off.square() + exact(2.0**-1000)).root()
        force = exact(self.force) + size * exact(m.loose_mass) + gravity[1] * exact(m.carried_mass)
        left = exact(self.torque_max) - size * exact(m.loose_moment) - gravity[1] * turning
        margins = []
        for i in range(3):
            x, _, z = cross(pose.forearm[(i + 1) % 3], pose.forearm[(i + 2) % 3])
            lever = pose.arm[i].times(pose.upper_arm)
            fall = (x.times(gravity[0]) + z.times(gravity[2])).times(exact(m.carried_mass))
            most = pose.faces[i].root().times(force)
            e, (c, _s) = pose.elbow[i], pose.azimuths[i]
            moved = e[0].times(gravity[0]) + e[2].times(gravity[2])
            lifted = pose.cos[i].times(c * gravity[0]) + pose.sin[i].times(gravity[2])
            turned = moved.times(arm) - lifted.times(off)
            for sign in _SIGNS:
                held = turned.times(exact(-sign)).plus(left)
                margins.append(pose.determinant * held - lever * (fall.times(exact(sign)) + most))
        return margins

    def refuted_by_intervals(self, pose: SlopePose, exact: Callable[[float], Interval]) -> bool:
        """Decides whether a position breaks the limit; nothing is said at and beyond the direct singularity."""
        return bool(pose.determinant.centre.lo[0] > 0.0) and super().refuted_by_intervals(pose, exact)

    def less_strict_than(self, than: Any) -> bool:
        """Compares torque and force; with other masses it is about another machine, and so less strict."""
        return self.torque_max > than.torque_max or self.force < than.force or self.masses != than.masses
