"""Every machine consists of what its design must have, and each difference is named."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from delta_cad.assembly.assemble import assemble
from delta_cad.assembly.machine import Assembly
from delta_cad.design import load_design
from delta_cad.dimensions import Dimensions, dimensions
from delta_cad.export.bom import bill_of_materials
from tests.committed import ROOT
from tests.delta_cad.assembly.expected.anchors import anchor_faults
from tests.delta_cad.assembly.expected.comparing import make_faults, part_faults
from tests.delta_cad.assembly.expected.materials import expected_makes
from tests.delta_cad.assembly.expected.parts import expected_parts


def put(a: Assembly, name: str, **changes: object) -> Assembly:
    every = tuple(replace(o, **changes) if o.name == name else o for o in a.occurrences)  # type: ignore[arg-type]
    assert any(o.name == name for o in a.occurrences)
    return replace(a, occurrences=every)


def test_parts_and_bill_of_materials_are_as_expected(best_assembly: Assembly, best_dimensions: Dimensions) -> None:
    assert part_faults(best_assembly, best_dimensions) == []
    assert make_faults(best_assembly, best_dimensions) == []
    rows = bill_of_materials(best_assembly, dict.fromkeys((p.number for p in best_assembly.parts), 0.0))
    expected = sum(row.count for row in expected_parts(best_dimensions))
    pieces = sum(bool(o.part.piece_of) for o in best_assembly.occurrences)  # that a cable is drawn in
    assert pieces == 18
    supplied = sum(supply.quantity for supply in best_assembly.supplies)
    assert expected == len(best_assembly.occurrences) == sum(row.quantity for row in rows) - supplied + pieces
    makes = expected_makes(best_dimensions)
    assert len({make.number for make in makes}) == len(makes)


@pytest.mark.parametrize(
    "design",
    [
        "docs/gallery/direct-83.json",
        pytest.param("docs/gallery/pocket-40.json", marks=pytest.mark.slow),
        pytest.param("docs/gallery/desk-150.json", marks=pytest.mark.slow),
        pytest.param("examples/dashboard-panel.json", marks=pytest.mark.slow),
    ],
)
def test_other_machines_consist_of_what_is_expected(design: str) -> None:
    d = dimensions(load_design(ROOT / design))
    assembly = assemble(d)
    assert part_faults(assembly, d) == []
    assert make_faults(assembly, d) == []
    assert anchor_faults(assembly, d) == []


@pytest.mark.parametrize(
    "name", ["motor_1", "bearing_1_e", "capstan_cable_2_turns", "base_dowel_0_1", "knob", "joint_ball_2_1_wrist"]
)
def test_a_missing_part_is_named(best_assembly: Assembly, best_dimensions: Dimensions, name: str) -> None:
    kept = tuple(o for o in best_assembly.occurrences if o.name != name)
    assert len(kept) == len(best_assembly.occurrences) - 1
    (fault,) = part_faults(replace(best_assembly, occurrences=kept), best_dimensions)
    assert name.rsplit("_", 1)[0] in fault


SPOILED: dict[str, tuple[Callable[[Assembly], Assembly], str]] = {
    "doubled": (
        lambda a: replace(a, occurrences=(*a.occurrences, replace(a.occurrences[0], name="a_copy"))),
        "a_copy (base_plate) is not expected",
    ),
    "two of one name": (
        lambda a: replace(a, occurrences=(*a.occurrences, a.occurrences[0])),
        "base_plate is there 2 times",
    ),
    "on another chain's link": (lambda a: put(a, "sector_0", link="upper_arm_1"), "sector_0 is on upper_arm_1"),
    "another kind": (lambda a: put(a, "knob", part=a.occurrences[0].part), "knob is a base_plate"),
    "two parts of one number": (
        lambda a: put(a, "bearing_2_m", part=replace(next(p for p in a.parts if p.number == "bearing"), holes=())),
        "another part of the number bearing",
    ),
    "no adhesive": (
        lambda a: replace(a, supplies=tuple(s for s in a.supplies if s.number != "tube_adhesive")),
        "tube_adhesive is bought in 0 lines",
    ),
    "too few cords": (
        lambda a: replace(
            a, supplies=tuple(replace(s, quantity=5) if s.number == "rod_cord" else s for s in a.supplies)
        ),
        "5 rod_cord are bought, expected are 6",
    ),
    "another adhesive": (
        lambda a: replace(
            a, supplies=tuple(replace(s, order_code="glue") if s.number == "bar_adhesive" else s for s in a.supplies)
        ),
        "bar_adhesive is ordered as glue",
    ),
    "more than is expected": (
        lambda a: replace(a, supplies=(*a.supplies, replace(a.supplies[0], number="tape"))),
        "tape is bought, but not expected",
    ),
}


@pytest.mark.parametrize("spoil", SPOILED)
def test_what_is_not_as_expected_is_named(best_assembly: Assembly, best_dimensions: Dimensions, spoil: str) -> None:
    make, fault = SPOILED[spoil]
    assert any(fault in found for found in part_faults(make(best_assembly), best_dimensions))


@pytest.mark.parametrize("name", ["rod_cup_1_0_elbow", "platform"])
@pytest.mark.parametrize(
    ("how", "fault"),
    [
        (np.diag([1.0, -1.0, 1.0, 1.0]), "mirrored"),
        (np.diag([1.02, 1.02, 1.02, 1.0]), "stretched"),
        (np.eye(4) + 0.05 * np.eye(4, k=1), "stretched"),
        (np.diag([1.0, 1.0, 1.0, 1.01]), "placed nowhere"),
        (np.full((4, 4), np.nan), "placed nowhere"),
    ],
)
def test_a_part_is_moved_to_its_place_and_nothing_else(
    best_assembly: Assembly, best_dimensions: Dimensions, name: str, how: np.ndarray, fault: str
) -> None:
    """As a mirrored copy would be, of a part that looks the same: no contact of these parts sees it."""
    (sound,) = [o for o in best_assembly.occurrences if o.name == name]
    (found,) = part_faults(put(best_assembly, name, placement=sound.placement @ how), best_dimensions)
    assert found.startswith(f"{name} is {fault}")
