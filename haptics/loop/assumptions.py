"""Assumptions on a device that has not been built: friction, delay, motors, estimator, and the resulting plant.

None of these follows from the drawings. Each has a nominal value and, where results depend on it, a range; results that
matter are given over the range. Importing this module loads numba.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from delta_cad import catalogue
from delta_cad.drive import drive_friction_N_m, encoder_count_rad, idle_torque_N_m
from delta_cad.drive.friction import IDLE_SPEED
from haptics.control.controller import Controller
from haptics.control.filters import Estimator, low_pass
from haptics.control.pose import model
from haptics.control.supervisor.limits import safety_limits
from haptics.model.ball_joints import ball_friction
from haptics.model.machine import MachineModel
from haptics.model.plant import Plant, plant

# Least, nominal and largest share of the idle torque that grows with the speed; the nominal one and that of
# `drive.friction` add up to it.
_VISCOUS = (0.0, 0.4, 0.75)
# Turn of a joint by which cable, brushes and bearings give way before they slip, rad, softest first: half a degree of
# the motor, an eighth, a twentieth. A guess with a wide range, on which the stability of stiff walls under a soft grasp
# depends: the softest goes with the least friction, the stiffest with the largest.
_PRESLIDING = (1e-3, 3e-4, 1e-4)
# Share of critical damping with which a joint rings on an unslipped bristle, least, nominal, largest: none; wire rope
# and grease (a loss factor of 0.1); what friction models in the literature take at most. From memory.
_BRISTLE_RATIO = (0.0, 0.05, 0.2)
DELAY = (0.0, 0.5, 1.0)  # From reading to torque in periods: at once, half a period to compute and send, a whole one
CURRENT_LAG = 0.2e-3  # Time constant of a motor's current loop, s: a bandwidth of 0.8 kHz
# Cut-off frequency of the low-pass on the joint rates, Hz. An adaptive window would be quieter, but a loop bears an
# eighth of the damping with one of 16 periods; a count of 14 bits makes 0.06 rad/s of noise.
_CORNER = 100.0


@dataclass(frozen=True)
class Friction:
    """Friction of one joint; each least, nominal, largest.

    Attributes:
        coulomb: N m, of the drive and of the ball joints.
        drive: N m, the drive's share of that.
        viscous: N m s/rad.
        presliding: rad; the least friction is the softest.
        bristle_damping: N m s/rad.
    """

    coulomb: tuple[float, float, float]
    drive: tuple[float, float, float]
    viscous: tuple[float, float, float]
    presliding: tuple[float, float, float]
    bristle_damping: tuple[float, float, float]

    def of(self, par: Plant, place: int) -> Plant:
        """A plant with the friction at one place of the range: 0 least, 1 nominal, 2 largest."""
        return par._replace(
            coulomb=self.coulomb[place],
            viscous=self.viscous[place],
            presliding=self.presliding[place],
            bristle_damping=self.bristle_damping[place],
        )


def joint_friction(machine: MachineModel) -> Friction:
    """Friction of a joint: the motor's idle torque through the drive, and the ball joints of the rods.

    Args:
        machine: The device; the ball joints' share is that in the cube's centre.
    """
    ratio = machine.drive.ratio
    thin, usual, thick = _VISCOUS
    slope = ratio**2 * idle_torque_N_m(catalogue.motor.chosen(machine.design.hardware)) / IDLE_SPEED
    balls = ball_friction(machine.design, machine.centre)
    drive = drive_friction_N_m(machine.design)
    coulomb = (drive[0] + balls[0], drive[1] + balls[1], drive[2] + balls[2])
    inertia = machine.masses.arm_inertia + machine.masses.rotor_inertia
    parts = zip(_BRISTLE_RATIO, coulomb, _PRESLIDING, strict=True)
    least, nominal, largest = (2.0 * ratio * math.sqrt(c / turn * inertia) for ratio, c, turn in parts)
    return Friction(
        coulomb, drive, (thin * slope, usual * slope, thick * slope), _PRESLIDING, (least, nominal, largest)
    )


def encoder_count(machine: MachineModel) -> float:
    """Count of the encoder as an angle of the arm, rad: on the shoulder's shaft, or on the motor, through the ratio."""
    return encoder_count_rad(machine.design)


def default_estimator(period: float = 1e-3) -> Estimator:
    """Velocity estimator of the controller: backward difference and a low-pass.

    Args:
        period: s.
    """
    return low_pass(period, _CORNER)


def nominal_plant(machine: MachineModel) -> Plant:
    """The true device with nominal friction and motors."""
    gravity = machine.design.requirements.gravity_m_s2
    smooth = plant(machine.geometry, machine.masses, gravity, current_lag=CURRENT_LAG)
    return joint_friction(machine).of(smooth, 1)


def default_controller(
    machine: MachineModel, period: float = 1e-3, estimator: Estimator | None = None, **limits: float
) -> Controller:
    """The controller of a device, its supervisor included.

    Args:
        machine: The device.
        period: s.
        estimator: Estimator of the joint rates; None for `default_estimator`.
        **limits: Any of `SafetyLimits`, to replace what follows from the design.

    Raises:
        ValueError: A limit is unknown or refused.
    """
    known = model(machine.geometry, machine.masses, machine.design.requirements.gravity_m_s2)
    chosen = estimator if estimator is not None else default_estimator(period)
    return Controller(known, chosen, safety_limits(machine.design, period=period, **limits), math.inf)
