"""A part missing, doubled, on another link, of another kind or stated nowhere is refused by its name."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from delta_cad.assembly.machine import Assembly
from delta_cad.checks.presence import check_presence
from delta_cad.checks.report import CheckResult
from delta_cad.export.bom import bill_of_materials


def without(a: Assembly, *names: str) -> Assembly:
    kept = tuple(o for o in a.occurrences if o.name not in names)
    assert len(kept) == len(a.occurrences) - len(names)
    return replace(a, occurrences=kept)


def put(a: Assembly, name: str, **changes: object) -> Assembly:
    every = tuple(replace(o, **changes) if o.name == name else o for o in a.occurrences)  # type: ignore[arg-type]
    return replace(a, occurrences=every)


def found(a: Assembly) -> CheckResult:
    result = check_presence(a)
    assert result.passed == (result.value == 0)
    return result


def test_statement_assembly_and_bill_of_materials_agree(best_assembly: Assembly) -> None:
    assert found(best_assembly).passed
    rows = bill_of_materials(best_assembly, dict.fromkeys((p.number for p in best_assembly.parts), 0.0))
    stated = sum(row.count for row in best_assembly.stated)
    pieces = sum(bool(o.part.piece_of) for o in best_assembly.occurrences)  # that a cable is drawn in
    assert pieces == 18
    beside = sum(supply.quantity for supply in best_assembly.supplies)
    assert stated == len(best_assembly.occurrences) == sum(row.quantity for row in rows) - beside + pieces


@pytest.mark.parametrize(
    "names",
    [
        ("motor_1", "motor_screw_1_0", "motor_screw_1_1", "motor_screw_1_2"),
        ("bearing_1_e",),
        ("capstan_cable_2_turns",),
        ("base_dowel_0_1",),
        ("crimp_sleeve_1_0", "wave_spring_1"),
        ("knob",),
        ("joint_ball_2_1_wrist",),
    ],
)
def test_a_missing_part_is_named(best_assembly: Assembly, names: tuple[str, ...]) -> None:
    held = [name for name in names if any(o.name == name for o in best_assembly.occurrences)]
    result = found(without(best_assembly, *held))
    assert not result.passed
    assert all(name.rsplit("_", 1)[0] in result.detail for name in held), result.detail


def test_a_rod_without_its_ball_joints_is_refused(best_assembly: Assembly) -> None:
    joints = [o.name for o in best_assembly.occurrences if o.name.startswith(("joint_ball_0_1", "rod_cup_0_1"))]
    result = found(without(best_assembly, *joints))
    assert not result.passed
    assert {"joint_ball_0_1_elbow", "rod_cup_0_1_wrist"} <= set(result.worst_pair or ())


SPOILED: dict[str, tuple[Callable[[Assembly], Assembly], str]] = {
    "doubled": (
        lambda a: replace(a, occurrences=(*a.occurrences, replace(a.occurrences[0], name="a_copy"))),
        "a_copy (base_plate) is stated by no joint and no drive",
    ),
    "two of one name": (
        lambda a: replace(a, occurrences=(*a.occurrences, a.occurrences[0])),
        "base_plate is there 2 times",
    ),
    "on another chain's link": (
        lambda a: put(a, "sector_0", link="upper_arm_1"),
        "sector_0 of drive_0 is on upper_arm_1, stated is upper_arm_0",
    ),
    "another kind": (
        lambda a: put(a, "knob", part=a.occurrences[0].part),
        "knob of handle is a base_plate, stated is knob",
    ),
    "two parts of one number": (
        lambda a: put(a, "bearing_2_m", part=replace(next(p for p in a.parts if p.number == "bearing"), holes=())),
        "different parts of one number bearing",
    ),
}


@pytest.mark.parametrize(
    ("number", "quantity", "order_code", "told"),
    [
        ("tube_adhesive", 0, "", "tube_adhesive is bought in 0 lines"),
        ("rod_cord", 5, "", "5 rod_cord are bought, stated are 6"),
        ("bar_adhesive", 1, "glue stick", "bar_adhesive is ordered as glue stick"),
        ("motor_key", 0, "", "motor_key is bought in 0 lines"),
    ],
)
def test_what_is_bought_beside_the_parts_is_stated_too(
    best_assembly: Assembly, number: str, quantity: int, order_code: str, told: str
) -> None:
    others = [one for one in best_assembly.supplies if one.number != number]
    (sound,) = set(best_assembly.supplies) - set(others)
    spoilt = [replace(sound, quantity=quantity, order_code=order_code or sound.order_code)] if quantity else []
    result = found(replace(best_assembly, supplies=(*others, *spoilt)))
    assert (result.value, result.worst_pair) == (1, (number,))
    assert told in result.detail


@pytest.mark.parametrize("spoil", SPOILED)
def test_what_is_not_as_stated_is_named(best_assembly: Assembly, spoil: str) -> None:
    make, told = SPOILED[spoil]
    result = found(make(best_assembly))
    assert not result.passed
    assert told in result.detail


@pytest.mark.parametrize("name", ["rod_cup_1_0_elbow", "platform", "rod_spring_1_0", "encoder_magnet_1"])
@pytest.mark.parametrize(
    ("how", "told"),
    [
        (np.diag([1.0, -1.0, 1.0, 1.0]), "mirrored by its placement"),
        (np.diag([1.02, 1.02, 1.02, 1.0]), "stretched by its placement"),
        (np.eye(4) + 0.05 * np.eye(4, k=1), "stretched by its placement"),
        (np.diag([1.0, 1.0, 1.0, 1.01]), "placed nowhere"),
        (np.full((4, 4), np.nan), "placed nowhere"),
    ],
)
def test_a_part_is_moved_to_its_place_and_nothing_else(
    best_assembly: Assembly, name: str, how: np.ndarray, told: str
) -> None:
    """As a mirrored copy would be, of a part that looks the same: no contact of these parts sees it."""
    (sound,) = [o for o in best_assembly.occurrences if o.name == name]
    result = found(put(best_assembly, name, placement=sound.placement @ how))
    assert result.value == 1
    assert f"{name} is {told}" in result.detail


def test_what_is_bought_beside_the_parts_and_stated_nowhere_is_named(best_assembly: Assembly) -> None:
    first, *needs = best_assembly.needs
    result = found(replace(best_assembly, needs=tuple(needs)))
    assert f"{first.number} is bought, but stated nowhere" in result.detail


def test_a_machine_that_states_nothing_is_refused(best_assembly: Assembly) -> None:
    result = found(replace(best_assembly, stated=()))
    assert result.value == len(best_assembly.occurrences)
