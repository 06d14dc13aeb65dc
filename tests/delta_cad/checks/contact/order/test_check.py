"""The order of assembly: that of the machine holds; faults planted in orders are refused by name."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import pytest

from delta_cad import catalogue
from delta_cad.assembly.machine import Assembly, Insertion, PathSegment, Step
from delta_cad.assembly.tessellation import MeshLibrary
from delta_cad.checks.contact.order.check import check_order
from delta_cad.checks.limits import CheckLimits
from delta_cad.checks.report import CheckResult
from delta_cad.dimensions import Dimensions
from delta_cad.solids.bought_parts import make_cap_screw
from delta_cad.solids.part import Consumable
from tests.delta_cad.checks.contact.order.blocks import (
    DOWN,
    UP,
    case,
    checked,
    lid,
    on_base,
    pin,
    plate,
    step,
    whole,
)
from tests.delta_cad.checks.machines import box, part, rod

GLUE = Consumable("glue", "glue", 1, "", 0.0, "", "", "")


def faults(a: Assembly) -> tuple[float | None, tuple[str, ...] | None, str]:
    result = checked(a)["assembly order"]
    assert result.passed is (result.value == 0.0)
    return result.value, result.worst_pair, result.detail


def test_no_order_no_check() -> None:
    assert checked(on_base(plate(), pin())) == {}


def test_plate_pin_and_lid_go_together_in_this_order_alone() -> None:
    plate_in, pin_in, lid_in = Insertion(("plate",)), Insertion(("pin",), DOWN), Insertion(("lid",), DOWN)
    parts = plate(), pin(), lid(20.0)
    assert faults(on_base(*parts, order=whole(step(plate_in), step(pin_in, lid_in))))[0] == 0.0
    value, names, detail = faults(on_base(*parts, order=whole(step(plate_in), step(lid_in, pin_in))))
    assert (value, names) == (1.0, ("pin",))
    assert "pin meets lid" in detail


def test_a_part_locked_in_by_another_is_refused_however_it_comes() -> None:
    parts = case(), part("inside", box((-3, -3, -3), (3, 3, 3)))
    for legs in (UP, DOWN, (PathSegment((1.0, 0.0, 0.0)), PathSegment((0.0, 0.0, 1.0), 5.0))):
        value, names, _ = faults(on_base(*parts, order=whole(step(Insertion(("case",)), Insertion(("inside",), legs)))))
        assert (value, names) == (1.0, ("inside",))


@pytest.mark.parametrize(
    ("brings", "words"),
    [
        ([Insertion(("plate",))], "pin comes in 0 times"),
        ([Insertion(("plate",)), Insertion(("pin",), DOWN), Insertion(("pin",), DOWN)], "pin comes in 2 times"),
        (
            [Insertion(("plate",)), Insertion(("pin",), DOWN), Insertion(("nut",), DOWN)],
            "nut is no part of the machine",
        ),
        ([Insertion(("plate",)), Insertion(("pin",))], "pin has no way"),
        ([Insertion(("plate",)), Insertion(("pin",), is_flexible=True)], "pin is not flexible"),
        ([Insertion(("plate",)), Insertion(("pin",), DOWN, units=("arm",))], "arm is not made yet"),
    ],
)
def test_an_order_with_a_fault_is_refused(brings: list[Insertion], words: str) -> None:
    value, _, detail = faults(on_base(plate(), pin(), order=whole(step(*brings))))
    assert value is not None
    assert value >= 1.0
    assert words in detail


def test_a_supply_that_no_step_uses_is_refused() -> None:
    brings = Insertion(("plate",)), Insertion(("pin",), DOWN)
    a = replace(on_base(plate(), pin(), order=whole(step(*brings))), supplies=(GLUE,))
    assert faults(a)[:2] == (1.0, ("glue",))
    assert faults(replace(a, order=whole(step(*brings, supplies=("glue",)))))[0] == 0.0
    assert faults(replace(a, order=whole(step(*brings, supplies=("glue", "tape")))))[:2] == (1.0, ("tape",))


def keyed(*over: Insertion, cover: float) -> CheckResult:
    """A screw with its head on a plate, and a cover so far over it, which comes in with it."""
    bored = part("plate", box((-15, -15, -10), (15, 15, 0)).cut(rod(1.5, (0, 0, -11), (0, 0, 1))))
    screw = make_cap_screw(catalogue.screw("M3"), 8.0)
    brings = Insertion(("plate",)), Insertion((screw.number,), DOWN), *over
    a = on_base(bored, screw, lid(cover), order=whole(step(*brings, tightened=(screw.number,)), step(*_left(over))))
    return checked(a)["assembly keys"]


def _left(over: tuple[Insertion, ...]) -> tuple[Insertion, ...]:
    return () if over else (Insertion(("lid",), DOWN),)


def test_a_screw_is_tightened_before_its_head_is_covered() -> None:
    assert keyed(cover=6.0).passed
    refused = keyed(Insertion(("lid",), DOWN), cover=6.0)
    assert (refused.passed, refused.value, refused.worst_pair) == (False, 0.0, ("screw_M3x8",))
    assert keyed(Insertion(("lid",), DOWN), cover=80.0).passed  # the short leg of a key for M3 is 20.5 mm


@pytest.fixture(scope="module")
def meshes(best_assembly: Assembly) -> MeshLibrary:
    return MeshLibrary(best_assembly.parts)


@pytest.fixture(scope="module")
def limits(best_dimensions: Dimensions) -> CheckLimits:
    cube = best_dimensions.design.cube
    return CheckLimits(cube.bottom_height_mm, cube.half_side_mm, 270.0, 220.0)


Change = Callable[[tuple[Step, ...]], tuple[Step, ...]]


def changed(a: Assembly, kind: str, change: Change) -> Assembly:
    """The machine with the steps of units of a kind changed, and of its order only what these need."""
    order = tuple(replace(unit, steps=change(unit.steps)) if unit.kind == kind else unit for unit in a.order)
    return replace(a, order=order)


def from_above(steps: tuple[Step, ...]) -> tuple[Step, ...]:
    """Every drive comes straight down on the plate."""
    return tuple(
        replace(
            s, insertions=tuple(replace(b, path=DOWN) if b.units and "drive" in b.units[0] else b for b in s.insertions)
        )
        for s in steps
    )


def without_knob(steps: tuple[Step, ...]) -> tuple[Step, ...]:
    return tuple(replace(s, insertions=tuple(b for b in s.insertions if b.names != ("knob",))) for s in steps)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "change", "words"),
    [
        ("drive", lambda steps: steps, ""),
        ("drive", lambda steps: tuple(reversed(steps)), "shoulder_shaft_0 meets encoder_board_0"),
        ("machine", from_above, "pinion_1 meets sector_0"),
        ("platform", without_knob, "knob comes in 0 times"),
    ],
)
def test_the_machine_goes_together_in_its_order_and_in_no_other(
    best_assembly: Assembly, meshes: MeshLibrary, limits: CheckLimits, kind: str, change: Change, words: str
) -> None:
    results = {r.name: r for r in check_order(changed(best_assembly, kind, change), limits, meshes)}
    assert results["assembly order"].passed is (words == "")
    assert words in results["assembly order"].detail
    if not words:
        assert results["assembly keys"].passed


def test_every_instance_of_the_machine_is_in_its_order_once(best_assembly: Assembly) -> None:
    """Counted without the check's help, from the records alone."""
    names = [name for unit in best_assembly.order for s in unit.steps for b in s.insertions for name in b.names]
    assert sorted(names) == sorted(o.name for o in best_assembly.occurrences)
    units = [unit for u in best_assembly.order for s in u.steps for b in s.insertions for unit in b.units]
    assert sorted(units) == sorted(u.name for u in best_assembly.order[:-1])
