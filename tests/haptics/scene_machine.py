"""The committed design with masses near those of its build, so that scenes need no build."""

from __future__ import annotations

from delta_cad.design import Design
from delta_cad.drive import drive_torque
from delta_cad.drive.masses import Masses
from haptics.model.machine import MachineModel

MASSES = Masses(0.074, 0.0013, -0.0003, 1.5e-4, 0.002, 0.00075, 0.002, 3.25e-4)


def scene_machine(best: Design) -> MachineModel:
    return MachineModel(best, MASSES, drive_torque(best))
