"""Declared bores against those of the solid: each way in which one may be elsewhere or otherwise is told."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import pytest

from delta_cad.assembly.machine import Assembly
from delta_cad.checks.dfm.located import location_faults
from delta_cad.solids.boring import along_z, blind, fitted, group, sunk, tapped, tool
from delta_cad.solids.making import made_part, material
from delta_cad.solids.part import Bore, Part
from delta_cad.solids.primitive import box, cut

DRILLED = blind(along_z(3.3, (10, 10), (20, 8)), 118.0)
THROUGH = along_z(4.5, (30, 10), (4, 20))
HEAD = sunk(along_z(8.0, (30, 10), (0, 4)))


def block(*declared: Bore) -> Part:
    """A block with three bores, of which what is given is declared."""
    solid = cut(box((0, 0, 0), (40, 20, 20)), [tool(bore) for bore in (DRILLED, THROUGH, HEAD)])
    holes = [group("a bore", [bore]) for bore in declared]
    return made_part("block", "block", solid, material("aluminium-6082"), (None, None, None), holes)


def test_bores_where_they_are_have_no_fault() -> None:
    assert location_faults(block(DRILLED, THROUGH, HEAD)) == []
    assert location_faults(block()) == []


WRONG: dict[str, tuple[Bore, dict[str, Any]]] = {
    "aside": (DRILLED, {"start_mm": (10.01, 10.0, 20.0)}),
    "askew": (DRILLED, {"direction": (1e-3, 0.0, -1.0)}),
    "from the other side": (DRILLED, {"direction": (0.0, 0.0, 1.0)}),
    "wider": (DRILLED, {"diameter_mm": 3.4}),
    "deeper": (DRILLED, {"depth_mm": 12.1}),
    "less deep": (DRILLED, {"depth_mm": 11.9}),
    "flat": (DRILLED, {"tip_deg": 0.0}),
    "of another tip": (DRILLED, {"tip_deg": 135.0}),
    "through": (DRILLED, {"through": True}),
    "begins higher": (DRILLED, {"start_mm": (10.0, 10.0, 20.1)}),
    "not through": (THROUGH, {"through": False}),
    "counterbore deeper": (HEAD, {"depth_mm": 4.1}),
    "counterbore through": (HEAD, {"depth_mm": 20.0, "through": True}),
}


@pytest.mark.parametrize("fault", WRONG)
def test_a_bore_that_is_otherwise_is_reported(fault: str) -> None:
    bore, change = WRONG[fault]
    others = [other for other in (DRILLED, THROUGH, HEAD) if other is not bore]
    (text,) = location_faults(block(replace(bore, **change), *others))
    assert "the bore of" in text


@pytest.mark.parametrize(
    ("bore", "callout", "wording"),
    [
        (replace(tapped(THROUGH, "M4"), thread="M5"), "M5 through", "whose core is 4.2 mm"),
        (replace(fitted(THROUGH, "H7"), fit="G7"), "4.5 G7 through", "specified as G7 with deviations (0"),
        (tapped(THROUGH, "M4"), "M5 through", "is M4, which its callout 'M5 through' does not say"),
        (fitted(THROUGH, "H7"), "4.5 through", "is H7, which its callout"),
    ],
    ids=["core", "fit", "thread's callout", "fit's callout"],
)
def test_a_bore_of_which_two_things_are_said_is_reported(bore: Bore, callout: str, wording: str) -> None:
    solid = cut(box((0, 0, 0), (40, 20, 20)), [tool(bore)])
    one = made_part("one", "one", solid, material("aluminium-6082"), (None, None, None), [group(callout, [bore])])
    (text,) = location_faults(one)
    assert wording in text


def test_every_bore_of_a_machine_is_found_and_declares_its_place(best_assembly: Assembly) -> None:
    for part in best_assembly.parts:
        if part.make:
            assert location_faults(part) == []
            assert [hole.callout for hole in part.holes if not hole.bores and not hole.is_slot] == []


def test_a_moved_bore_of_a_real_part_is_reported(best_assembly: Assembly) -> None:
    (plate,) = [part for part in best_assembly.parts if part.number == "base_plate"]
    hole = plate.holes[3]
    x, y, z = hole.bores[0].start_mm
    moved = replace(hole, bores=(replace(hole.bores[0], start_mm=(x + 0.05, y, z)), *hole.bores[1:]))
    (text,) = location_faults(replace(plate, holes=(moved,)))
    assert "is not there" in text
