"""What the base stands on: feet and their threads, sleeves, neither; the order and the counts say the same."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest

from delta_cad.assembly.builder import AssemblyBuilder
from delta_cad.assembly.panel import place_bench, place_panel, place_sleeves
from delta_cad.assembly.sequence import assembly_sequence
from delta_cad.assembly.supplies import mounts
from delta_cad.dimensions import Dimensions
from delta_cad.solids.base_plate import make_base_plate, make_bench_plate
from delta_cad.solids.panel import make_mount_sleeve
from tests.delta_cad.assembly.expected.parts import expected_parts
from tests.delta_cad.dimensions.paneled import of_panel


def placed_alone(d: Dimensions) -> AssemblyBuilder:
    """Sleeves and panel of a machine placed, and nothing else."""
    builder = AssemblyBuilder(d, lambda _: None)
    place_sleeves(builder)
    place_bench(builder)
    place_panel(builder)
    return builder


MOUNTINGS = [(None, 0, 0), ("feet", 3, 0), ("screws", 0, 0), ("both", 3, 6), ("plate", 0, 0)]


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
    screwed = mounting not in ("feet", "plate")
    supplied = {supply.number: supply.quantity for supply in mounts(d)}
    assert supplied.get("mount_screw", 0) == (6 if screwed else 0)
    steps = [step for step in assembly_sequence(builder, mounts(d))[-1].steps if step.title == "Base screwed down"]
    assert len(steps) == int(screwed)
    assert [name for step in steps for insertion in step.insertions for name in insertion.names] == [
        f"mount_sleeve_{k}" for k in range(sleeves)
    ]


def test_a_machine_on_its_bench_plate_brings_plate_pads_and_screws() -> None:
    d = of_panel(hardware__mounting="plate")
    builder = placed_alone(d)
    (step,) = (one for one in assembly_sequence(builder, mounts(d))[-1].steps if one.title == "Bench plate")
    names = {name for insertion in step.insertions for name in insertion.names}
    assert names == {"bench_plate", *(f"bench_pad_{k}" for k in range(4)), *(f"mount_screw_{k}" for k in range(6))}
    assert f"A pull of {1.5 * 6.0:.0f} N" in " ".join(step.checks)


def test_the_bench_plate_weighs_what_it_was_sized_by_and_takes_every_screw() -> None:
    d = of_panel(hardware__mounting="plate")
    bench, part = d.bench, make_bench_plate(d)
    assert bench is not None
    made = part.solid.Volume() * 7850e-9
    assert made == pytest.approx(bench.mass_kg, rel=0.01)  # corners, chamfers and threads
    assert made < bench.mass_kg
    (x, y, z) = part.extent_mm or ()
    assert z == (-d.base.thickness_mm + d.base.top_mm - bench.thickness_mm, d.base.top_mm - d.base.thickness_mm)
    assert (x, y) == (bench.x_mm, bench.y_mm)
    for one, callout in ((part, "6.6 through"), (make_base_plate(d), "M5 through")):
        (found,) = (hole for hole in one.holes if callout in hole.callout)
        at = sorted((bore.start_mm[0], bore.start_mm[1]) for bore in found.bores)
        assert np.array(at) == pytest.approx(np.array(sorted(d.base.mounts_mm)))
    inside = np.array(bench.pads_mm) - np.array([bench.x_mm[0], bench.y_mm[0]])
    near = np.minimum(inside, np.array(bench.size_mm) - inside)
    assert near == pytest.approx(np.full((4, 2), 3.0 + 15.0))  # each pad lies whole on the plate, with a rim of 3 mm
    assert bench.thickness_mm < bench.screw_mm <= d.base.thickness_mm + bench.thickness_mm


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
