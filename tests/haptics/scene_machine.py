"""The committed design with the masses of its build, so that scenes need no build."""

from __future__ import annotations

from delta_cad.design import Design
from delta_cad.drive import drive_torque
from delta_cad.drive.masses import Masses
from haptics.model.machine import MachineModel

MASSES = Masses(0.0654, 0.0022, -3.707e-4, 1.845e-4, 0.002744, 0.001145, 0.002744, 8.02e-5)
"""Of the committed design's solids to three digits; `gravity.test_gravity` holds them to the build."""


def scene_machine(best: Design) -> MachineModel:
    return MachineModel(best, MASSES, drive_torque(best))
