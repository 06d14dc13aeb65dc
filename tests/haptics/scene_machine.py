"""The machine that the tests know with the masses of its build, so that scenes need no build."""

from __future__ import annotations

import math

from delta_cad.design import Design, load_design
from delta_cad.drive import drive_torque
from delta_cad.drive.masses import Masses
from haptics.model.machine import MachineModel
from tests.committed import BEST, ROOT

MASSES = Masses(0.0654, 0.0022, -3.707e-4, 1.845e-4, 0.003798, 0.001425, 0.003798, 7.998e-5)
"""Of the solids of `tests.committed.BEST` to three digits; `gravity.test_gravity` holds them to the build."""

WITHOUT_NOISE = {"repeats": math.inf, "all_repeat": math.inf}
"""Limits of a controller whose readings are exact in a test, and rightly repeat at rest."""

GALLERY = {
    "pocket-40": Masses(0.04474, 9.528e-4, -1.487e-4, 5.599e-5, 0.003102, 0.001190, 0.003102, 3.558e-5),
    "direct-83": Masses(0.04669, 2.281e-3, -5.4e-6, 1.677e-4, 0.004072, 0.001349, 0.004072, 8.1e-5),
    "desk-150": Masses(0.2405, 1.199e-2, -2.248e-3, 1.730e-3, 0.009043, 0.003057, 0.009043, 3.252e-3),
}
"""Likewise of the gallery, by `mass_report` of the solids on 2026-11-24; nothing holds them to a build."""


def gallery_machine(name: str) -> MachineModel:
    design = load_design(ROOT / "docs" / "gallery" / f"{name}.json")
    return MachineModel(design, GALLERY[name], drive_torque(design))


def scene_machine(best: Design) -> MachineModel:
    """That machine, with other hardware or limits where a test changes them; another machine has other masses."""
    known = load_design(BEST).mechanism
    if best.mechanism != known:
        raise ValueError(f"the masses are those of {BEST.name}, whose lengths are {known}, not {best.mechanism}")
    return MachineModel(best, MASSES, drive_torque(best))
