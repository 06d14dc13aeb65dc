"""The start-up of a design's device: its stops, inertias and torques, with their tolerances.

Importing this module loads numba.
"""

from __future__ import annotations

import math

from delta_cad.dimensions.tolerances.zero import START_ZERO_DEG
from delta_cad.mechanism import inverse_kinematics
from haptics.control.pose import model
from haptics.control.startup.record import StartUp
from haptics.control.supervisor.limits import checked, safety_limits
from haptics.loop.assumptions import joint_friction
from haptics.loop.choice import chosen_loop
from haptics.loop.hardware import real_plant, sensor_limits, with_sensors
from haptics.model.machine import MachineModel

_WEAK = 0.5  # Share of a joint's torque that a start-up may use
_SLOW = 0.7  # Largest speed of the handle, m/s
_BEYOND = 0.15  # How far beyond a stop an angle may be read before it is a fault, rad
DAMPED = 0.6  # Of the hold, share of critical damping


def start_up(machine: MachineModel, period: float, *, absolute: bool | None = None) -> StartUp:
    """The parameters of a design's start-up.

    Args:
        machine: The device.
        period: Of the tick, s.
        absolute: Whether the encoders know their zero; None for whether they sit on the shoulders' shafts.

    Raises:
        ValueError: The design has no stops, because it cannot be built.
    """
    plant, design = real_plant(machine), machine.design
    if not (math.isfinite(plant.stop_low) and math.isfinite(plant.stop_high)):
        raise ValueError(f"{design.name} cannot be built and has no stops, on which a start-up begins")
    if absolute is None:
        absolute = design.hardware.encoder_at != "motor"  # all of the catalogue's for shafts are
    masses, arm = machine.masses, machine.geometry.upper_arm_length
    inertia = masses.arm_inertia + masses.rotor_inertia + (masses.rod_elbow + masses.rod_cross) * arm**2
    known = sensor_limits(machine, chosen_loop(design, 1.0 / period))
    plain = with_sensors(safety_limits(design, period=period), known)
    torque = _WEAK * plain.torque
    limits = plain._replace(
        theta_low=plant.stop_low - _BEYOND,
        theta_high=plant.stop_high + _BEYOND,
        frozen_turn=math.inf,
        frozen_torque=math.inf,
        edge_margin=1.0,
        edge_far=2.0,
        reach_min=1e-6,
        reach_low=2e-6,
        volume_min=1e-6,
        volume_low=2e-6,
        speed=_SLOW,
        velocity_lag=5e-3,
        torque=torque,
        slew=torque / 2e-3,
        gravity_slew=torque / 0.1,
        ramp=0.1,
        ramp_power=1.0,
        stale=math.inf,
    )
    friction, stiffness = joint_friction(machine), 2.0
    centre = inverse_kinematics(machine.geometry, machine.centre)  # chains 1 and 2 mirror each other there
    return StartUp(
        model=model(machine.geometry, masses, design.requirements.gravity_m_s2),
        limits=checked(limits),
        absolute=float(absolute),
        stop_low=plant.stop_low,
        stop_high=plant.stop_high,
        zero=math.radians(START_ZERO_DEG),
        turn=max(4.0 * limits.encoder_count, math.radians(0.2)),
        still=0.2,
        patience=3.0,
        slope=0.5 * torque,
        push=0.7 * torque,
        centre=float(centre[0]),
        side_centre=float(centre[1]),
        speed=0.8,
        stiffness=stiffness,
        damping=2.0 * DAMPED * math.sqrt(stiffness * inertia),
        lag=1e-3,
        lost=0.2,
        pulse=0.4 * torque,
        pulse_time=0.02,
        inertia=inertia,
        carried=masses.platform + 3.0 * (masses.rod_wrist + masses.rod_cross),
        gain=1.5,
        friction=friction.coulomb[1],
        stroke=0.15,
        share=0.3,
        range=math.radians(3.0),
    )
