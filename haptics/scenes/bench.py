"""Common parts of the scenes: the placed device, the guide, its permitted damping, its friction at the handle."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from itertools import product

import numpy as np

from delta_cad.mechanism import inverse_jacobian, inverse_kinematics
from delta_cad.mechanism.limits.friction import HandleFriction, friction
from haptics.gravity import gravity_torque
from haptics.loop.assumptions import (
    CURRENT_LAG,
    default_controller,
    default_estimator,
    encoder_count,
    joint_friction,
    nominal_plant,
)
from haptics.loop.choice import PAPER
from haptics.loop.discrete import DampingCap, bisect, damping_cap, linear_model
from haptics.loop.hardware import reading_age, real_plant, sensor_errors
from haptics.loop.linear import linearise
from haptics.loop.simulation import SimulatedRun, simulate, timing
from haptics.model.machine import MachineModel
from haptics.model.plant import Hand
from haptics.model.sensor import EXACT
from haptics.rendering import law_table
from haptics.rendering.laws.operating_resistance import OperatingResistance

PERIOD = 1e-3  # Period of the paper's loop, s
READY = 0.8  # Before a scene begins: the supervisor's ramp of half a second, and the handle at rest, s
# A slide that takes the handle along a path, as a person with a ruler does: stiff, so that the handle keeps to it.
GUIDE = Hand(mass=0.1, damping=40.0, stiffness=8000.0)
GRID = 9


@dataclass(frozen=True)
class Assumed:
    """Assumptions of a scene on the device and on the hand or guide, apart from the delay.

    Attributes:
        friction: Place of the joints' friction in its range: 0 least, 1 nominal, 2 largest.
        noise: Whether encoders have their noise, and readings their age.
        gives: Whether cable and structure give way, and end stops and current ripple are there.
        hand: Who leads the handle.
        damping: Most that is applied, N s/m.
    """

    friction: int = 1
    noise: bool = False
    gives: bool = False
    hand: Hand = GUIDE
    damping: float = math.inf


NOMINAL = Assumed()


def smallest_mass(machine: MachineModel) -> float:
    """Smallest effective mass in any direction anywhere in the cube, kg, on a grid of `GRID` points an edge."""
    par, half = nominal_plant(machine), machine.half_side
    axis, middle = np.linspace(-half, half, GRID), machine.centre
    return min(linearise(par, middle + np.array(step)).smallest_mass for step in product(axis, axis, axis))


def damping_limit(mass: float, delay: float, stiffness: float, period: float = PERIOD) -> DampingCap:
    """Largest stable damping in all directions together with a spring, without a hand.

    Args:
        mass: Effective mass, kg.
        delay: From reading to torque, s.
        stiffness: Stiffness of the spring, N/m.
        period: s.
    """
    estimator = linear_model(default_estimator(period))
    return damping_cap(mass, period, delay, estimator, current_lag=CURRENT_LAG, stiffness=stiffness)


def mass_for_damping(damping: float, delay: float, stiffness: float) -> float:
    """Effective mass with which a loop would be allowed a damping, kg, by bisection to 0.1 %.

    Args:
        damping: N s/m.
        delay: s.
        stiffness: N/m.
    """
    return bisect(lambda mass: damping_limit(mass, delay, stiffness).cap < damping, 1e-3, 1e3, ratio=1.001)[1]


def rendered(
    machine: MachineModel, setting: OperatingResistance, damping: float, delay: float, seed: int, start: np.ndarray,
    anchor: np.ndarray, held: np.ndarray | None = None, assumed: Assumed = NOMINAL,
) -> SimulatedRun:  # fmt: skip
    """Simulates the operating resistance about the cube's centre, with the handle in the guide.

    Args:
        machine: The device.
        setting: k, r0, r1.
        damping: b as applied, N s/m.
        delay: Time from reading to torque, s.
        seed: Seed of the places of the encoders' counts.
        start: (3,) position at rest at the beginning, m.
        anchor: (n, 3) where the guide wants the handle at each tick, m.
        held: (n,) whether the guide holds it at each tick; None for always.
        assumed: Of the device, and who holds the handle in the guide's place.
    """
    par, errors = joint_friction(machine).of(nominal_plant(machine), assumed.friction), EXACT
    if assumed.gives:
        par = real_plant(machine, PAPER, assumed.friction)
    if assumed.noise:
        errors, delay = sensor_errors(machine, PAPER), delay + reading_age(machine, PAPER)
    return simulate(
        par,
        default_controller(machine, PERIOD)._replace(force=machine.design.requirements.force_N),
        law_table(replace(setting, origin=machine.centre, damping=damping)),
        timing(PERIOD, delay),
        start,
        hand=assumed.hand,
        errors=errors,
        anchor=anchor,
        push=np.zeros_like(anchor),
        count=encoder_count(machine),
        seed=seed,
        held=held,
    )


def motors_force(machine: MachineModel, recording: SimulatedRun) -> np.ndarray:
    """(n, 3) force on the handle of what the motors give beyond the weight, N: `F = J^-T (torque - holding torque)`;
    NaN where a fault let the handle leave the mechanism's own branch.
    """
    g, force = machine.geometry, np.full(recording.position.shape, np.nan)
    inside = np.isfinite(inverse_kinematics(g, recording.position, off_branch="nan")).all(axis=-1)
    p = recording.position[inside]
    weight = gravity_torque(g, machine.masses, p, machine.design.requirements.gravity_m_s2)
    to_force = np.swapaxes(inverse_jacobian(g, p), -1, -2)
    force[inside] = (to_force @ (recording.applied[inside] - weight)[..., None])[..., 0]
    return force


def friction_force(machine: MachineModel, direction: np.ndarray) -> float:
    """Coulomb friction of the joints against a motion of the handle from the origin, N.

    Args:
        machine: The device, with nominal friction.
        direction: (3,) unit vector e.

    Returns:
        `coulomb sum |theta_dot_i| / |v| = coulomb sum |G_i . e|`, by virtual power.
    """
    rates = inverse_jacobian(machine.geometry, machine.centre) @ direction
    return joint_friction(machine).coulomb[1] * float(np.abs(rates).sum())


def friction_holds(machine: MachineModel) -> float:
    """Largest force on the handle at the origin that the joints' Coulomb friction can hold, N.

    Args:
        machine: The device, with nominal friction.

    Returns:
        Largest `|G^T torque|` over the torques within friction, which is that against a motion in the worst direction.
    """
    rubs = HandleFriction(joint_friction(machine).coulomb[1], 0.0, 0.0)
    return float(friction(machine.geometry, machine.centre, rubs))
