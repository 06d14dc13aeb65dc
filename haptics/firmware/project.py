"""The folder of a board for a design: controller, start-up, hardware layer, ports and their guide."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numba import float64, int64, typeof

from delta_cad import catalogue
from delta_cad.common.files import whole_folder
from delta_cad.drive import encoder_count_rad, joint_counts_per_turn
from delta_cad.mechanism import forward_kinematics
from haptics.calibration.unknowns import Unknowns
from haptics.control.correction import correction
from haptics.firmware.generate import sources
from haptics.firmware.layout import prelude
from haptics.firmware.literals import initialiser, literal
from haptics.firmware.ports import files_of_ports
from haptics.firmware.precision import DOUBLE, MIXED
from haptics.firmware.templates import rendered
from haptics.firmware.translate import Translation
from haptics.loop.choice import LoopChoice, chosen_loop
from haptics.loop.hardware import board_controller, real_plant, sensor_errors
from haptics.loop.start_up import start_up
from haptics.loop.walls import proven_cap
from haptics.model.machine import MachineModel
from haptics.model.plant import FREE, STATES, advance, angles

# What ports know of a device beside its controller: figures for wires and encoders, and the device simulated in C.
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
        centre_x=literal(float(machine.centre[0])),
        centre_z=literal(float(machine.centre[2])),
        damping=literal(loop.drive_damping),
        contact=literal(loop.contact_damping),
        damps=int(max(loop.drive_damping, loop.contact_damping) > 0.0),
        constant=literal(motor.torque_constant_N_m_A),
        resistance=literal(motor.resistance_ohm),
        ratio=literal(drive.ratio),
    )
    return {"delta_device.h": header, "simulated/device.c": code}


STALE = 0.1  # Age of the host's last word at which force fades, s


def firmware(
    machine: MachineModel,
    rate_Hz: float,
    *,
    single: bool = False,
    stale: float = STALE,
    homing: bool = False,
    known: Unknowns | None = None,
) -> dict[str, str]:
    """The files.

    Args:
        machine: The device.
        rate_Hz: Of the tick.
        single: Single precision where it does no harm.
        stale: Age of the host's last word at which force fades, s; may be infinite.
        homing: Zeros from the lower stops at each start, also for encoders that have one.
        known: One made device as it was measured; None: as drawn.

    Returns:
        Path in the folder -> text.

    Raises:
        ValueError: The loop bears no wall somewhere, or the design has no stops.
    """
    loop = chosen_loop(machine.design, rate_Hz)
    start = start_up(machine, loop.period, absolute=False if homing else None)
    controller = board_controller(machine, loop, stale=stale)._replace(walls=proven_cap(machine, loop))
    made = None if known is None else correction(machine.geometry, known)
    written = sources(controller, machine.design.name, MIXED if single else DOUBLE, start, made)
    return {**written, **device_files(machine, loop), **files_of_ports()}


def write_firmware(files: dict[str, str], folder: Path) -> None:
    """Writes all files or none: beside the folder, then renamed; what stood there is replaced.

    Args:
        files: Path in the folder -> text.
        folder: Where to.

    Raises:
        OSError: The folder cannot be written, or holds what no run wrote.
    """
    with whole_folder(folder) as part:
        for name, text in files.items():
            path = part / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8")
