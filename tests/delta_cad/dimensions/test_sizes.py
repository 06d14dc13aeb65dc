"""Sections that grow with loads and lengths: closed forms by hand, the least sizes, and machines from 40 to 250 mm."""

from __future__ import annotations

import re
from pathlib import Path
from time import process_time
from typing import Any

import pytest

from delta_cad.design import Design, design_from_dict
from delta_cad.dimensions import Dimensions, dimensions
from delta_cad.dimensions.joint import spring_range_N
from delta_cad.dimensions.sizes import bar_mm, growth, plate_mm, stem_mm
from delta_cad.structure.hardware.refusals import refusals
from delta_cad.structure.report import stiffness
from optimizer.problem.requirements import load_requirements
from tests.committed import ROOT, changed
from tests.delta_cad.catalogue.offered import DESK, machine

SIZES = ROOT / "tests" / "references" / "sizes"


def test_the_committed_machine_has_the_least_sizes(best_dimensions: Dimensions) -> None:
    d = best_dimensions
    assert growth(d.design) == 1.0
    thick = d.layers.arm_mm[1] - d.layers.arm_mm[0]
    assert (thick, d.forearm.bar_diameter_mm, d.platform.plate_mm, d.platform.stem_diameter_mm) == (6.0, 8.0, 5.0, 10.0)
    assert d.forearm.joint.preload_N == pytest.approx(8.38, abs=0.01)


@pytest.mark.parametrize(
    ("force", "stiffness_min", "arm", "expected"),
    [
        (3.0, 15.0, 95.0, 1.0),
        (3.0, 30.0, 95.0, 2.0),  # twice as stiff
        (3.0, None, 95.0, 1.0),  # 0.5 % of the arm under 3 N is 6.6 N/mm: the least sizes do
        (30.0, None, 95.0, 30.0 / (0.005 * 95.0) / 15.0),
        (30.0, None, 190.0, 8.0 * 30.0 / (0.005 * 190.0) / 15.0),
    ],
)
def test_second_moments_grow_with_stiffness_and_the_cube_of_lengths(
    best: Design, force: float, stiffness_min: float | None, arm: float, expected: float
) -> None:
    required = best.requirements.model_copy(
        update={"force_N": force, "peak_force_N": None, "stiffness_min_N_mm": stiffness_min}
    )
    mechanism = best.mechanism.model_copy(update={"upper_arm_length_mm": arm})
    design = best.model_copy(update={"requirements": required, "mechanism": mechanism})
    assert growth(design) == pytest.approx(expected)


def test_sizes_are_the_next_that_are_stiff_enough() -> None:
    assert (plate_mm(6.0, 1.0), bar_mm(8.0, 1.0), stem_mm(1.0)) == (6.0, 8.0, 10.0)
    assert plate_mm(6.0, 8.0) == 12.0  # t^3
    assert plate_mm(6.0, 8.1) == 12.5
    assert bar_mm(8.0, 16.0) == 16.0  # d^4
    assert (stem_mm(2.0), stem_mm(16.0), stem_mm(1e6)) == (12.0, 20.0, 30.0)
    assert spring_range_N(3.0) == (8.0, 13.0)
    assert spring_range_N(20.0) == pytest.approx((21.0, 34.125))


def test_a_force_of_30_N_makes_a_stronger_and_stiffer_machine_than_3() -> None:
    def of(force: float) -> Dimensions:
        wide: dict[str, Any] = {"requirements__force_N": force, "requirements__peak_force_N": None}
        wide |= {"requirements__stiffness_min_N_mm": None, "hardware__platform_thickness_mm": 16.0}
        wide |= {"mechanism__base_radius_mm": 40.0, "mechanism__platform_radius_mm": 32.0}
        return dimensions(design_from_dict(changed(**wide)))

    light, strong = of(3.0), of(30.0)
    assert strong.layers.arm_mm[1] > light.layers.arm_mm[1]
    assert strong.forearm.bar_diameter_mm > light.forearm.bar_diameter_mm
    assert strong.platform.plate_mm > light.platform.plate_mm
    assert strong.platform.stem_diameter_mm > light.platform.stem_diameter_mm
    assert strong.forearm.spigot_length_mm > light.forearm.spigot_length_mm
    assert strong.forearm.joint.preload_N > 2.0 * light.forearm.joint.preload_N
    low, high = (float(stiffness(d, 3).softest.stiffness_N_mm.min()) for d in (light, strong))
    assert high > 1.5 * low


POCKET: dict[str, Any] = {  # what `optimizer synthesize` makes of pocket-40.toml
    "mechanism": {
        "base_radius_mm": 42.0,
        "platform_radius_mm": 18.0,
        "upper_arm_length_mm": 60.0,
        "forearm_length_mm": 100.977,
        "parallelogram_width_mm": 38.0,
    },
    "cube": {"bottom_height_mm": 57.253, "half_side_mm": 20.0},
}
LARGE: dict[str, Any] = {  # and of large-250.toml
    "mechanism": {
        "base_radius_mm": 95.0,
        "platform_radius_mm": 55.0,
        "upper_arm_length_mm": 274.0,
        "forearm_length_mm": 441.911,
        "parallelogram_width_mm": 105.0,
    },
    "cube": {"bottom_height_mm": 208.127, "half_side_mm": 125.0},
}


def made(name: str, lengths: dict[str, Any], **task: float) -> Design:
    """The design that the lengths make with a requirements file's task, or another, and its hardware."""
    given = load_requirements(SIZES / f"{name}.toml")
    demand = given.requirements.model_dump(exclude_none=True) | task
    hardware = given.hardware_from(Path())
    return design_from_dict(changed(**lengths, requirements=demand, hardware=hardware, name=name))


def test_machines_of_40_150_and_250_mm_are_not_refused() -> None:
    """All were built, and passed all checks."""
    assert refusals(made("pocket-40", POCKET)) == ()
    assert refusals(machine({"hardware__motor": "maxon-re50-370354"} | DESK)) == ()
    assert load_requirements(SIZES / "desk-150.toml").requirements.force_N == 10.0
    assert refusals(made("large-250", LARGE)) == ()


def test_a_cube_of_250_mm_at_30_N_is_refused_at_once() -> None:
    """No motor of the catalogue gives 13 N m at such a ratio: told at once beside all that it would overload."""
    start = process_time()
    found = {
        reason.feature: reason for reason in refusals(made("large-250", LARGE, force_N=30.0, joint_torque_N_m=13.0))
    }
    assert process_time() - start < 3.0  # a third of it here; the bound is for a machine that is shared
    assert re.search(r"of 13 N m at the joint, continuous$", found["continuous torque"].message)
