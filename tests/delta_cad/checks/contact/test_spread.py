"""What a base radius lacks for keys, where it can be told by hand, and that a machine that passes lacks nothing."""

from __future__ import annotations

from dataclasses import replace
from math import cos, pi, sqrt

import pytest

from delta_cad import catalogue
from delta_cad.assembly.machine import Assembly
from delta_cad.assembly.tessellation import MeshLibrary
from delta_cad.checks.contact.access import MARGIN_MM, MOST_MM, TOLERANCE_MM, missing_spread_mm
from delta_cad.checks.limits import CheckLimits
from delta_cad.dimensions import Dimensions
from delta_cad.solids.bought_parts import make_cap_screw
from delta_cad.solids.part import Occurrence, ToolAccess
from tests.delta_cad.checks.contact.order.blocks import on_base
from tests.delta_cad.checks.machines import box, part

FLATS_MM = 2.5  # of an M3's socket
LIMITS = CheckLimits(60.0, 20.0, 270.0, 220.0)


def walled(edge_mm: float, name: str) -> Assembly:
    """A screw of chain 0 along z, and a tall wall of another chain over it, up to x = edge."""
    screw = make_cap_screw(catalogue.screw("M3"), 8.0)
    wall = part("wall", box((-200.0, -200.0, 15.0), (edge_mm, 200.0, 300.0)))
    a = on_base(screw, wall)
    named = [Occurrence(n, o.part, o.link, o.placement) for n, o in zip(("screw_0", name), a.occurrences, strict=True)]
    return replace(a, occurrences=tuple(named), reached=(ToolAccess("screw_0", 1.0, "holds"),))


def missing(a: Assembly) -> float:
    return missing_spread_mm(a, LIMITS, MeshLibrary(a.parts))


def test_a_neighbour_over_a_screw_goes_off_it_by_one_and_a_half_times_the_radius() -> None:
    """Chains 0 and 1 go out at 120 degrees: along x they part by 1 + cos 60 deg times as much."""
    corner = FLATS_MM / sqrt(3.0)
    off = (3.0 + corner) / (1.0 + cos(pi / 3.0))
    found = missing(walled(3.0, "wall_1"))
    assert off - 0.1 <= found <= off + TOLERANCE_MM + 0.1


def test_what_a_neighbour_leaves_is_by_how_much_the_radius_may_be_shorter() -> None:
    corner = FLATS_MM / sqrt(3.0)
    off = (corner - 3.0) / (1.0 + cos(pi / 3.0))
    assert off - 0.1 <= missing(walled(-3.0, "wall_1")) <= off + TOLERANCE_MM + 0.1 < 0.0


def test_nothing_in_the_way_misses_nothing_and_what_goes_along_is_never_off() -> None:
    assert missing(walled(-20.0, "wall_1")) == -MARGIN_MM
    assert missing(walled(3.0, "wall_0")) == MOST_MM


@pytest.mark.slow
def test_the_machine_misses_nothing(best_assembly: Assembly, best_dimensions: Dimensions) -> None:
    cube = best_dimensions.design.cube
    limits = CheckLimits(cube.bottom_height_mm, cube.half_side_mm, 270.0, 220.0)
    assert missing_spread_mm(best_assembly, limits, MeshLibrary(best_assembly.parts)) <= 0.0
