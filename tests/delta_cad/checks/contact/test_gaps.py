"""A running gap that may not get wider than its limit is held from that side too."""

from dataclasses import replace

import numpy as np
import pytest

from delta_cad.assembly.machine import Assembly
from delta_cad.assembly.tessellation import MeshLibrary
from delta_cad.checks.contact.gaps import check_largest_gaps
from delta_cad.design import Design
from delta_cad.solids.part import Fit
from tests.delta_cad.checks.machines import LIMITS, changed, machine

MACHINE = machine()


def largest(widest_mm: float | None) -> Assembly:
    fit = Fit("sector_0", "motor_0", "running gap", gap_mm=0.5, gap_max_mm=widest_mm, reason="side by side")
    return replace(MACHINE, fits=(fit,))


def test_a_gap_is_refused_where_it_is_wider_than_its_limit() -> None:
    meshes = MeshLibrary(MACHINE.parts)
    unsure = sum(meshes[n].deviation_mm for n in ("sector", "motor"))
    (good,) = check_largest_gaps(largest(4.0 + unsure + 1e-6), LIMITS, meshes)  # from 10 to 14 along the axis
    assert good.passed
    assert good.value == pytest.approx(4.0 + unsure)
    (bad,) = check_largest_gaps(largest(4.0 + unsure - 1e-6), LIMITS, meshes)
    assert not bad.passed
    assert bad.name == "largest gap sector_0 / motor_0"


def test_gaps_without_a_limit_are_left_to_the_clearance() -> None:
    assert check_largest_gaps(largest(None), LIMITS, MeshLibrary(MACHINE.parts)) == []


def test_the_encoder_magnet_is_within_its_range_and_a_shifted_shaft_is_refused(
    best: Design, best_assembly: Assembly
) -> None:
    cube = best.cube
    limits = replace(LIMITS, bottom_height_mm=cube.bottom_height_mm, half_side_mm=cube.half_side_mm)
    meshes = MeshLibrary(best_assembly.parts)
    pairs = [("encoder_magnet", "encoder_board"), ("sector", "pinion")]
    names = {f"largest gap {a}_{i} / {b}_{i}" for a, b in pairs for i in range(3)}
    results = check_largest_gaps(best_assembly, limits, meshes)
    assert {r.name for r in results} == names
    assert all(r.passed for r in results)
    shift = np.eye(4)
    shift[1, 3] = 1.5
    shifted = best_assembly
    for name in ("shoulder_shaft_0", "encoder_magnet_0"):
        placed = next(o for o in best_assembly.occurrences if o.name == name).placement
        shifted = changed(shifted, name, placement=placed @ shift)
    refused = [r.name for r in check_largest_gaps(shifted, limits, meshes) if not r.passed]
    assert refused == ["largest gap encoder_magnet_0 / encoder_board_0"]
