"""The smallest radii that are told in closed form, against the exact solids."""

from __future__ import annotations

from itertools import product

import cadquery as cq
import numpy as np
import pytest

from delta_cad.assembly.machine import Assembly
from delta_cad.design import Design
from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.capstan import base_radius_min_mm, rim_y_mm
from delta_cad.mechanism.geometry import SIN_60
from tests.delta_cad.solids.measured import placed


def axis_of(assembly: Assembly, pose: np.ndarray, chain: int) -> cq.Edge:
    """A neighbour's shoulder axis, as long as its arm is thick."""
    frame = assembly.placement(pose)[f"upper_arm_{chain}"]
    ends = (frame @ np.array([0.0, y, 0.0, 1.0]) for y in (-3.0, 3.0))
    return cq.Edge.makeLine(*(cq.Vector(*end[:3]) for end in ends))


def to_axis_mm(R: float, tip_mm: float, outer_mm: float) -> float:
    """From the tip of a sector that swings inwards to the neighbour's shoulder axis."""
    return 1.5 * R - tip_mm / 2 - SIN_60 * outer_mm


@pytest.mark.slow
def test_a_sector_s_tip_passes_the_neighbour_s_axis_as_the_closed_form_says(
    best_assembly: Assembly, best_dimensions: Dimensions
) -> None:
    d, cube = best_dimensions, best_dimensions.design.cube
    assert d.capstan is not None
    sector = next(o for o in best_assembly.occurrences if o.name == "sector_0")
    middle = np.array([0.0, 0.0, cube.bottom_height_mm + cube.half_side_mm])
    gaps = []
    for corner in product((-1.0, 0.0, 1.0), repeat=3):
        pose = middle + cube.half_side_mm * np.array(corner)
        solid = placed(sector.part.solid, best_assembly.poses(pose)["sector_0"])
        gaps += [solid.distance(axis_of(best_assembly, pose, chain)) for chain in (1, 2)]
    assert min(gaps) == pytest.approx(
        to_axis_mm(d.design.mechanism.base_radius_mm, d.capstan.rim_radius_mm, d.layers.sector_mm[1]), abs=1e-6
    )


@pytest.mark.parametrize("beyond_mm", [-0.5, 0.0, 1.0])
def test_at_the_smallest_base_radius_flange_and_clearance_just_have_room(
    best: Design, best_dimensions: Dimensions, beyond_mm: float
) -> None:
    d, c = best_dimensions, best_dimensions.capstan
    assert c is not None
    clear = best.requirements.clearance_min_mm
    thickness = d.layers.arm_mm[1] - d.layers.arm_mm[0]
    least = base_radius_min_mm(c.run, c.cable_diameter_mm, thickness, d.arm.flange_radius_mm, clear)
    R, cable = least + beyond_mm, c.cable_diameter_mm
    outer = rim_y_mm(c.run, cable, thickness, R, clear)[1]
    room = to_axis_mm(R, c.run.sector_mm + cable / 2, outer) - d.arm.flange_radius_mm
    to_margin = room - clear - 2.0 * beyond_mm  # the rim gives way, too
    assert -1e-9 <= to_margin <= 0.1 * SIN_60 + 1e-9  # a rim lies on whole tenths
