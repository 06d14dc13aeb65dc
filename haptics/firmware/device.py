"""Device data for ports, besides the controller: figures for wires and encoders, and the simulated device in C."""

from __future__ import annotations

import numpy as np
from numba import float64, int64, typeof

from delta_cad import catalogue
from delta_cad.drive import encoder_count_rad, joint_counts_per_turn
from delta_cad.mechanism import forward_kinematics
from haptics.firmware.layout import prelude
from haptics.firmware.literals import initialiser, literal
from haptics.firmware.precision import DOUBLE
from haptics.firmware.templates import rendered
from haptics.firmware.translate import Translation
from haptics.loop.choice import LoopChoice
from haptics.loop.hardware import real_plant, sensor_errors
from haptics.model.machine import MachineModel
from haptics.model.plant import FREE, STATES, advance, angles

STEPS = 4  # Of the integrator in a period of an eighth of a millisecond


def device_files(machine: MachineModel, loop: LoopChoice) -> dict[str, str]:
    """The figures of a device, and the device itself for a port without one.

    Args:
        machine: The device; it must have stops.
        loop: How its drives damp.

    Returns:
        File name -> text.
    """
    motor, drive = catalogue.motor.chosen(machine.design.hardware), machine.drive
    errors = sensor_errors(machine, loop)
    par, vector = real_plant(machine, loop), typeof(np.zeros(3))
    translation = Translation(DOUBLE)
    room = typeof(np.zeros((13, STATES)))
    hand = (typeof(FREE), vector, vector, vector)
    translation.add(advance, (typeof(par), *hand, float64, int64, vector, room))
    translation.add(angles, (typeof(par), vector, vector))
    functions = "\n".join(translation.functions.values())
    rest = forward_kinematics(machine.geometry, np.full(3, par.stop_low + 1e-3))
    code = rendered(
        "device.c",
        prelude=prelude(DOUBLE, functions),
        structs="\n".join(translation.structs.values()),
        plant=initialiser(par, typeof(par), 0, DOUBLE),
        touched=initialiser(par.in_contact, typeof(par), 0, DOUBLE),
        hand=initialiser(FREE, typeof(FREE), 0, DOUBLE),
        functions=functions,
        states=STATES,
        steps=STEPS,
        centre=", ".join(literal(float(value)) for value in machine.centre),
        rest=", ".join(literal(float(value)) for value in rest),
    )
    header = rendered(
        "device.h",
        name=machine.design.name,
        ampere=literal(1.0 / (motor.torque_constant_N_m_A * drive.ratio * drive.efficiency)),
        counts=round(joint_counts_per_turn(machine.design)),
        count=literal(encoder_count_rad(machine.design)),
        noise=literal(errors.noise),
        kept=literal(errors.kept),
        centre=literal(float(machine.centre[2])),
        damping=literal(loop.drive_damping),
        contact=literal(loop.contact_damping),
        damps=int(max(loop.drive_damping, loop.contact_damping) > 0.0),
        constant=literal(motor.torque_constant_N_m_A),
        resistance=literal(motor.resistance_ohm),
        ratio=literal(drive.ratio),
    )
    return {"delta_device.h": header, "simulated/device.c": code}
