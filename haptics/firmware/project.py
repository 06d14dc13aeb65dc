"""The folder of a board for a design: controller, start-up, hardware layer, ports and their guide."""

from __future__ import annotations

from pathlib import Path

from delta_cad.common.files import whole_folder
from haptics.calibration.unknowns import Unknowns
from haptics.control.correction import correction
from haptics.firmware.device import device_files
from haptics.firmware.generate import sources
from haptics.firmware.ports import files_of_ports
from haptics.firmware.precision import DOUBLE, MIXED
from haptics.loop.choice import chosen_loop
from haptics.loop.hardware import board_controller
from haptics.loop.start_up import start_up
from haptics.loop.walls import proven_cap
from haptics.model.machine import MachineModel

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
