"""The C library with a design's numbers, and its users, as a folder. Importing this module loads numba."""

from __future__ import annotations

import math
from functools import cache
from importlib import resources
from pathlib import Path

import numpy as np
from numba import typeof

from delta_cad.common.files import whole_folder
from delta_cad.design import design_hash
from haptics.control.pose import HOLDING, POSITION, ROWS, Model, model, pose
from haptics.firmware.layout import prelude
from haptics.firmware.precision import DOUBLE
from haptics.firmware.templates import rendered
from haptics.firmware.translate import Translation
from haptics.loop.choice import chosen_loop
from haptics.loop.walls import STABILITY_MARGIN, computed_wall
from haptics.model.machine import MachineModel

FILES = (
    "README.md",
    "c/delta_device.h",
    "c/delta_device.c",
    "chai3d/CDeltaHapticDevice.h",
    "chai3d/CDeltaHapticDevice.cpp",
    "ros2/delta_haptic_node.cpp",
    "ros2/CMakeLists.txt",
    "ros2/package.xml",
)
MACHINE, POSE = "c/delta_machine.h", "c/delta_pose.h"  # Written for a design; from the controller
_HOST_RATE_Hz = 1000.0  # at which programs on a host close the loop through a socket
_RAMP_S, _WATCHDOG_S, TIMEOUT_S = 0.5, 0.02, 0.1


def sources(machine: MachineModel) -> dict[str, str]:
    """Gives the files for a design: path -> text."""
    here = resources.files("haptics.interfaces")
    return {name: here.joinpath(name).read_text(encoding="utf-8") for name in FILES} | {
        POSE: _pose_header(),
        MACHINE: machine_header(machine),
    }


@cache
def _pose_header() -> str:
    """Gives the controller's forward kinematics, Jacobian and holding torques in C, translated."""
    translation, vector = Translation(), typeof(np.zeros(3))
    translation.add(pose, (typeof(Model(*len(Model._fields) * (0.0,))), vector, typeof(np.zeros((ROWS, 3)))))
    functions = "\n".join(translation.functions.values())
    return rendered(
        "pose.h",
        prelude=prelude(DOUBLE, functions),
        structs="\n".join(translation.structs.values()),
        functions=functions,
        position=POSITION,
        holding=HOLDING,
        rows=ROWS,
    )


def machine_header(machine: MachineModel) -> str:
    """Gives the header with the numbers of a design.

    Stiffness is what a wall in the middle of the cube may have with a loop of 1 kHz through a host: its force reaches
    the drives a period after its reading, and tells them of no wall.
    """
    design = machine.design
    known = model(machine.geometry, machine.masses, design.requirements.gravity_m_s2)
    loop = chosen_loop(design, _HOST_RATE_Hz).linked.untouched
    wall = STABILITY_MARGIN * min(computed_wall(machine, machine.centre, axis, loop) for axis in np.eye(3))
    config = (
        *(known.radius_difference, known.side_difference, known.side_cosine, known.side_sine),
        *(known.upper_arm_length, known.forearm_length),
        *(known.below_elbows, known.moment, known.across),
    )
    gravity = (known.gravity_x, known.gravity_y, known.gravity_z)
    force = max(design.requirements.force_N, design.requirements.peak_force_N or 0.0)
    rest = (machine.drive.controlled_torque_N_m, force, loop.corner, _RAMP_S, _WATCHDOG_S, TIMEOUT_S)
    numbers = [*map(_c, config), "{" + ", ".join(map(_c, gravity)) + "}", *map(_c, rest), "0"]
    lines = [
        f"/* {design.name}, design {design_hash(design)[:12]}: numbers for delta_device.h, SI. */",
        "#ifndef DELTA_MACHINE_H",
        "#define DELTA_MACHINE_H",
        "",
        f'#define DELTA_NAME "{design.name}"',
        f"#define DELTA_CENTRE_X {_c(machine.centre[0])} /* middle of the cube, m; its y is 0 */",
        f"#define DELTA_CENTRE_Z {_c(machine.centre[2])}",
        f"#define DELTA_HALF_SIDE {_c(machine.half_side)} /* of the cube, m */",
        f"#define DELTA_FORCE {_c(design.requirements.force_N)} /* for ever, N */",
        f"#define DELTA_STIFFNESS {_c(wall)} /* of a wall through a host at 1 kHz, N/m */",
        f"#define DELTA_DAMPING {_c(loop.damping)} /* in that wall, N s/m */",
        "#define DELTA_MACHINE { \\",
        *(f"    {number}, \\" for number in numbers[:-1]),
        f"    {numbers[-1]}}}",
        "",
        "#endif",
    ]
    return "\n".join(lines) + "\n"


def write_sources(machine: MachineModel, folder: Path) -> list[str]:
    """Writes the files for a design, whole or not at all.

    Returns:
        Their paths in the folder.

    Raises:
        OSError: They cannot be written.
    """
    files = sources(machine)
    with whole_folder(folder) as part:
        for name, text in files.items():
            (part / name).parent.mkdir(exist_ok=True)
            (part / name).write_text(text, encoding="utf-8")
    return sorted(files)


def _c(value: float) -> str:
    """A double that C reads back to the last bit."""
    assert math.isfinite(value)
    return repr(float(value))
