"""A joint's drive as it is: friction, torque that ripples, a cable that gives way, and the arm's stops; compiled.

The rotor, seen at the joint, turns by the arm's angle and the cable's twist. Where the cable gives way,

    rotor_inertia phi'' = motor - viscous phi' - friction(phi) - cable
    cable = stiffness twist + damping (phi' - theta')

and the arm gets the cable's torque less what rubs behind it; where it is rigid, the arm gets the motor's less all
friction. The motor gives `(1 + ripple sin(..)) torque + cogging sin(..)` over its angle. A stop is a spring and damper
that only pushes. Importing this module loads numba.

Source:
    Torque ripple and cogging as lines over the rotor's angle: any text on motors; the figures are assumptions of
    `loop/hardware.py`.
"""

from __future__ import annotations

import math

from delta_cad.common.jit import inlined

# Places in the state, three numbers each: p (m), v (m/s), bristles of the drive (1), torque of the motors at the joints
# (N m), bristles behind the cable (1), twist of the cables (rad), rate of the rotors at the joints (rad/s), the knob's
# way from the platform (m) and its velocity (m/s), the hand's way from the knob (m) and its velocity (m/s).
POSITION, SPEED, BRISTLES, MOTOR, ARM_BRISTLES, TWIST, ROTOR_RATE = 0, 3, 6, 9, 12, 15, 18
KNOB, KNOB_SPEED, GRASP, HAND_SPEED = 21, 24, 27, 30
STATES = 33
PHASE = 2.1  # Between the waves of two motors, rad: they were not mounted in step


@inlined
def bristle(before, turn, presliding):
    """Deflection of a bristle after a turn without reversal.

    Args:
        before: Deflection before it, between -1 and 1.
        turn: rad.
        presliding: rad.
    """
    return min(max(before + turn / presliding, -1.0), 1.0)


@inlined
def _stop_torque(par, angle, rate):
    """Torque of the stops on an arm, N m; 0 between them.

    Args:
        par: The plant.
        angle: Shoulder angle, rad.
        rate: rad/s.
    """
    if angle > par.stop_high:
        return min(par.stop_stiffness * (par.stop_high - angle) - par.stop_damping * rate, 0.0)
    if angle < par.stop_low:
        return max(par.stop_stiffness * (par.stop_low - angle) - par.stop_damping * rate, 0.0)
    return 0.0


@inlined
def motor_torque(par, i, current, angle):
    """Torque of a motor at the joint, N m.

    Args:
        par: The plant.
        i: Chain.
        current: Torque that its current stands for, N m.
        angle: Of the rotor at the joint, rad.
    """
    torque = current
    if par.ripple > 0.0:
        torque += par.ripple * current * math.sin(par.ripple_per_rad * angle + PHASE * i)
    if par.cogging > 0.0:
        torque += par.cogging * math.sin(par.cogging_per_rad * angle + PHASE * i)
    return torque


@inlined
def drive_torque(par, i, command, state, began, angle, rate, out):
    """Torque on the arm of one chain.

    Args:
        par: The plant.
        i: Chain.
        command: Torque commanded of its motor, N m.
        state: (STATES,) state.
        began: (3,) angles at which the step began, rad; (6,) with the twists where the cable gives way.
        angle: Shoulder angle, rad.
        rate: rad/s.
        out: (STATES,) derivative, its places of this drive filled.

    Returns:
        N m.
    """
    out[BRISTLES + i] = out[MOTOR + i] = out[ARM_BRISTLES + i] = 0.0
    current = state[MOTOR + i] if par.current_lag > 0.0 else command
    stops = _stop_torque(par, angle, rate)
    if par.cable_stiffness <= 0.0:
        out[TWIST + i] = out[ROTOR_RATE + i] = 0.0
        torque = motor_torque(par, i, current, angle) - par.viscous * rate
        if par.coulomb > 0.0:
            bent = bristle(state[BRISTLES + i], angle - began[i], par.presliding)
            torque -= par.coulomb * bent + par.bristle_damping * (1.0 - bent * bent) * rate
        return torque + stops
    twist, turning = state[TWIST + i], state[ROTOR_RATE + i]
    cable = par.cable_stiffness * twist + par.cable_damping * (turning - rate)
    torque = motor_torque(par, i, current, angle + twist) - par.viscous * turning - cable
    if par.coulomb > 0.0:
        turned = angle - began[i] + twist - began[3 + i]
        bent = bristle(state[BRISTLES + i], turned, par.presliding)
        torque -= par.coulomb * bent + par.bristle_damping * (1.0 - bent * bent) * turning
    out[TWIST + i] = turning - rate
    out[ROTOR_RATE + i] = torque / par.rotor_inertia
    if par.arm_coulomb > 0.0:
        cable -= par.arm_coulomb * bristle(state[ARM_BRISTLES + i], angle - began[i], par.presliding)
    return cable + stops


@inlined
def rotor_energy(par, i, state):
    """Kinetic energy of a rotor behind a cable that gives way, and the cable's own, J; 0 where it is rigid."""
    if par.cable_stiffness <= 0.0:
        return 0.0, 0.0
    turning, twist = state[ROTOR_RATE + i], state[TWIST + i]
    return 0.5 * par.rotor_inertia * turning * turning, 0.5 * par.cable_stiffness * twist * twist
