"""What the base stands on: feet and their threads, sleeves, neither; the order and the counts say the same."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest

from delta_cad.assembly.builder import AssemblyBuilder
from delta_cad.assembly.panel import place_panel, place_sleeves
from delta_cad.assembly.sequence import assembly_sequence
from delta_cad.assembly.supplies import mounts
from delta_cad.dimensions import Dimensions
from delta_cad.solids.base_plate import make_base_plate
from delta_cad.solids.panel import make_mount_sleeve
from tests.delta_cad.assembly.expected.parts import expected_parts
from tests.delta_cad.dimensions.paneled import of_panel


def placed_alone(d: Dimensions) -> AssemblyBuilder:
    """Sleeves and panel of a machine placed, and nothing else."""
    builder = AssemblyBuilder(d, lambda _: None)
    place_sleeves(builder)
    place_panel(builder)
    return builder


MOUNTINGS = [(None, 0, 0), ("feet", 3, 0), ("screws", 0, 0), ("both", 3, 6)]


@pytest.mark.parametrize(("mounting", "feet", "sleeves"), MOUNTINGS)
def test_what_stands_under_the_base_is_stated_and_has_its_holes(mounting: str | None, feet: int, sleeves: int) -> None:
    d = of_panel(hardware__mounting=mounting)
    counts = {row.names: row.count for row in expected_parts(d)}
    assert counts.get("foot_?", 0) == feet
    assert counts.get("mount_sleeve_?", 0) == sleeves
    builder = placed_alone(d)
    assert len([c for c in builder.contacts() if c.a.startswith("mount_sleeve")]) == sleeves
    callouts = " ".join(hole.callout for hole in make_base_plate(d).holes)
    assert ("M4" in callouts) == (feet > 0)  # a thread that holds nothing is a fault
    screwed = mounting != "feet"
    supplied = {supply.number: supply.quantity for supply in mounts(d)}
    assert supplied.get("mount_screw", 0) == (6 if screwed else 0)
    steps = [step for step in assembly_sequence(builder, mounts(d))[-1].steps if step.title == "Base screwed down"]
    assert len(steps) == int(screwed)
    assert [name for step in steps for insertion in step.insertions for name in insertion.names] == [
        f"mount_sleeve_{k}" for k in range(sleeves)
    ]


def test_a_sleeve_goes_over_its_hole_and_next_to_every_foot() -> None:
    d = of_panel()
    part = make_mount_sleeve(d)
    ring = pi / 4 * (10.0**2 - 5.5**2)
    assert part.solid.Volume() == pytest.approx(ring * 7.5, rel=1e-9)
    feet = d.base.foot_circle_mm / 2 * np.array([[np.cos(a), np.sin(a)] for a in (pi / 3, pi, 5 * pi / 3)])
    apart = np.linalg.norm(np.array(d.base.mounts_mm)[:, None] - feet, axis=-1).min()
    assert apart > (d.foot.diameter_mm + 10.0) / 2


def test_without_a_panel_nothing_comes_over_the_handle() -> None:
    d = of_panel(panel=None, hardware__mounting="feet")
    builder = placed_alone(d)
    assert builder.occurrences == builder.connections == []
    titles = {step.title for step in assembly_sequence(builder, ())[-1].steps}
    assert not titles & {"Panel over the handle", "Boot and bezel"}
    assert "Panel over the handle" in {step.title for step in assembly_sequence(placed_alone(of_panel()), ())[-1].steps}
    assert mounts(d) == ()
