"""Friction of the rods' ball joints at the handle, and as torque at the motors' joints.

A cup is pressed on a ball whose stud lies along the shoulder axis: it leans with its rod and turns about its own axis.
What it takes from the hand is power, `sum T_lean |lean rate| + T_turn |turn rate|` over twelve joints. The torques
follow what presses the ball in its cup: the springs' preload, here alone, without the rod's force.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from delta_cad.common.units import MM_PER_M
from delta_cad.design import Design
from delta_cad.dimensions.joint import FRICTION_RANGE, ball_preload_N, sliding_torques_N_mm
from delta_cad.mechanism import DeltaGeometry, jacobian
from delta_cad.mechanism.geometry import VERTICAL
from delta_cad.mechanism.inverse import arm_direction, forearm_vectors

_COUNT = 500  # directions: the mean is within 0.1 %


@dataclass(frozen=True)
class _JointRates:
    """Rates in the rods' joints for one motion, by chain; both rods of a chain alike.

    Attributes:
        lean: (..., 3, 2) at elbow and wrist, rate by which the cup leans about its ball, rad/s.
        turn: (..., 3, 2) rate by which it turns about its own axis, rad/s.
    """

    lean: np.ndarray
    turn: np.ndarray


def joint_rates(g: DeltaGeometry, p: np.ndarray, v: np.ndarray) -> _JointRates:
    """Computes how fast the ball joints turn for a motion of the handle.

    Args:
        g: The mechanism.
        p: (..., 3) position, m.
        v: (..., 3) velocity, m/s.

    Returns:
        The rates; NaN at a fold.
    """
    n = forearm_vectors(g, p) / g.forearm_length
    cosine, sine = arm_direction(g, p)
    turned = np.linalg.solve(jacobian(g, p), v[..., None])[..., 0]  # of the arms, rad/s
    across = -sine[..., None] * g.radial + cosine[..., None] * VERTICAL
    moving = (v[..., None, :] - g.upper_arm_length * turned[..., None] * across) / g.forearm_length

    def part(vector: np.ndarray, axis: np.ndarray) -> np.ndarray:
        return (vector * axis).sum(axis=-1)

    lean = part(n, g.tangential)
    upright = np.sqrt(1.0 - lean**2)
    leaning = part(moving, g.tangential) / upright
    u, z = part(n, g.radial), n[..., 2]
    in_plane = (u * moving[..., 2] - z * part(moving, g.radial)) / upright**2
    about = np.stack([in_plane - turned, in_plane], axis=-1)  # against the arm's stud, against the platform's
    return _JointRates(np.hypot(about * lean[..., None], leaning[..., None]), np.abs(about * upright[..., None]))


def ball_friction_N(design: Design, p: np.ndarray, direction: np.ndarray) -> np.ndarray:
    """Computes the ball joints' friction at the handle, coefficient nominal, pressed by the preload alone, N.

    Args:
        design: Whose rods and springs these are.
        p: (..., 3) position, m.
        direction: (..., 3) of a steady motion, unit vectors.
    """
    rates = joint_rates(design.geometry, p, direction)
    torques = sliding_torques_N_mm(design.hardware.ball_diameter_mm, np.array(ball_preload_N(design)))
    lean, turn = (2.0 * float(torque) for torque in torques)  # both rods of a chain
    taken = lean * rates.lean + turn * rates.turn
    return taken.sum(axis=(-2, -1)) / MM_PER_M


def ball_friction(design: Design, p: np.ndarray) -> tuple[float, float, float]:
    """Computes the torque at the motors' joints that takes as much power as the ball joints, mean of all directions.

    Args:
        design: Whose rods and springs these are.
        p: (3,) position, m.

    Returns:
        With the least, nominal and largest coefficient of friction, N m.
    """
    along = _directions(_COUNT)
    power = ball_friction_N(design, np.broadcast_to(p, along.shape), along)
    turned = np.linalg.solve(jacobian(design.geometry, p), along.T)  # (3 motors, n)
    nominal = float(power.mean() / np.abs(turned).sum(axis=0).mean())
    low, middle, high = FRICTION_RANGE
    return nominal * low / middle, nominal, nominal * high / middle


def _directions(count: int) -> np.ndarray:
    """Gives (count, 3) unit vectors spread evenly over a sphere: heights in equal steps, turned by the golden angle."""
    z = 1.0 - (2.0 * np.arange(count) + 1.0) / count
    turn = np.pi * (3.0 - np.sqrt(5.0)) * np.arange(count)
    flat = np.sqrt(1.0 - z**2)
    return np.stack([flat * np.cos(turn), flat * np.sin(turn), z], axis=-1)
