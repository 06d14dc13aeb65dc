"""The machine that the tests know with the masses of its build, so that scenes need no build."""

from __future__ import annotations

import math

from delta_cad.design import Design, design_from_dict, load_design
from delta_cad.drive import drive_torque
from delta_cad.drive.masses import Masses
from haptics.model.machine import MachineModel
from tests.committed import BEST, ROOT, changed

MASSES = Masses(0.06535, 0.002219, -3.489e-4, 1.828e-4, 0.003724, 0.001385, 0.003724, 7.922e-5)
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


def _placed(radii: tuple[float, float], azimuth: float, cube: tuple[float, float, float], *lengths: float) -> Design:
    base = {"base_radius_mm": radii[0], "base_radii_mm": [radii[0], radii[1], radii[1]]}
    base |= {"azimuths_deg": [0.0, azimuth, -azimuth], "parallelogram_width_mm": 54.0}
    names = ("platform_radius_mm", "upper_arm_length_mm", "forearm_length_mm")
    mechanism = base | dict(zip(names, lengths, strict=True))
    bottom, half, x = cube
    return design_from_dict(
        changed(
            name=f"placed-{round(azimuth)}",
            mechanism=mechanism,
            cube={"bottom_height_mm": bottom, "half_side_mm": half, "centre_x_mm": x},
        )
    )


PLACED = {
    "study": _placed((31.19, 38.45), 116.3, (75.8, 43.9, 11.1), 22.55, 94.4, 148.4),
    "apart": _placed((35.0, 39.0), 118.0, (66.4, 41.2, 3.0), 24.0, 91.0, 143.196),
    "close": _placed((35.0, 31.0), 122.0, (66.4, 41.2, -3.0), 24.0, 91.0, 143.196),
}
"""Designs whose chains do not stand alike: the mechanism of a study, and two that have stops; chains 1 and 2 farther
out than chain 0, and closer in."""


def placed_machine(name: str) -> MachineModel:
    """One of them with the masses of the tests' machine, which are of its size."""
    return MachineModel(PLACED[name], MASSES, drive_torque(PLACED[name]))
