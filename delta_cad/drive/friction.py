"""What a joint's drive rubs with: the motor's idle torque through the ratio, less what grows with the speed."""

from __future__ import annotations

from delta_cad import catalogue
from delta_cad.design import Design
from delta_cad.drive.report import drive_torque

# Friction of a motor as a share of its continuous torque: no-load current over what is left of the continuous one, of
# the RE 30 as its row in the catalogue has them. Not known of the others; bearings and cable are inside the range.
_IDLE_SHARE = 0.16 / (3.44 - 0.16)
# Speed of a motor at its no-load current, rad/s: a small motor at its rated voltage, about 8600 turns a minute.
IDLE_SPEED = 900.0
# Least, nominal and largest share of that friction that does not depend on the speed: brushes, bearings, cable.
COULOMB = (0.25, 0.6, 1.0)


def idle_torque_N_m(motor: catalogue.Motor) -> float:
    """Computes the torque that a motor takes at its idle speed, N m at the motor."""
    return _IDLE_SHARE * motor.nominal_torque_N_m


def coulomb_N_m(motor: catalogue.Motor, ratio: float) -> tuple[float, float, float]:
    """Computes the Coulomb friction of a joint's drive: least, nominal and largest, N m at the joint.

    Args:
        motor: Row of the catalogue.
        ratio: Turns of the motor per turn of the arm.
    """
    torque = ratio * idle_torque_N_m(motor)
    low, middle, high = COULOMB
    return low * torque, middle * torque, high * torque


def drive_friction_N_m(design: Design) -> tuple[float, float, float]:
    """Computes the same for the drive of a design."""
    return coulomb_N_m(catalogue.motor.chosen(design.hardware), drive_torque(design).ratio)


def _viscous_N_m_s(design: Design) -> float:
    """Computes the damping of a joint by its drive, N m s/rad: what of the idle torque grows with the speed."""
    motor, ratio = catalogue.motor.chosen(design.hardware), drive_torque(design).ratio
    return (1.0 - COULOMB[1]) * ratio**2 * idle_torque_N_m(motor) / IDLE_SPEED


def joint_friction(design: Design) -> tuple[float, float]:
    """Gives the nominal Coulomb friction (N m) and damping (N m s/rad) of a joint's drive."""
    return drive_friction_N_m(design)[1], _viscous_N_m_s(design)
