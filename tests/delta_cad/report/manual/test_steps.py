"""What the manual tells: as many parts as the bill of materials has, keys and torques of the screws' sizes."""

from __future__ import annotations

import argparse
from collections import Counter

import pytest

from delta_cad import catalogue
from delta_cad.assembly.machine import Assembly
from delta_cad.common.options import add_options
from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.tolerances import END_TORQUE_N_m
from delta_cad.dimensions.tolerances.zero import CALIBRATED_MM
from delta_cad.export.bom import BomRow, bill_of_materials
from delta_cad.report.manual.steps import Chapter, chapters, scenes
from delta_cad.structure.strength import screw_N, tightening_N_m
from haptics.commands import calibrate


@pytest.fixture(scope="module")
def rows(best_assembly: Assembly) -> list[BomRow]:
    return bill_of_materials(best_assembly, {part.number: 0.001 for part in best_assembly.parts})


@pytest.fixture(scope="module")
def wording(best_assembly: Assembly, rows: list[BomRow]) -> list[Chapter]:
    return chapters(best_assembly, rows, {})


def test_parts_reported_are_those_of_the_bill_times_as_many_units_as_are_made(
    best_assembly: Assembly, rows: list[BomRow], wording: list[Chapter]
) -> None:
    made = Counter(unit.kind for unit in best_assembly.order)
    amounts: Counter[str] = Counter()
    for chapter in wording:
        for step in chapter.steps:
            for line in step.parts:
                amounts[line.number] += line.quantity * made[chapter.kind]
    placed = {part.number for part in best_assembly.parts}
    assert amounts == {row.part_number: row.quantity for row in rows if row.part_number in placed}
    items = {line.number: line.item for chapter in wording for step in chapter.steps for line in step.parts}
    assert all(items[row.part_number] == row.item for row in rows if row.part_number in placed)


def test_every_supply_of_the_bill_is_reported(wording: list[Chapter], best_assembly: Assembly) -> None:
    used = {line.number for chapter in wording for step in chapter.steps for line in step.supplies}
    assert used == {supply.number for supply in best_assembly.supplies}


def test_units_are_reported_once_with_how_many_are_made(wording: list[Chapter]) -> None:
    made = {chapter.kind: chapter.made for chapter in wording}
    assert len(made) == len(wording)
    assert (made["drive"], made["arm"], made["rod"], made["platform"]) == ("Make three", "Make three", "Make six", "")
    assert [step.number for chapter in wording for step in chapter.steps] == list(
        range(1, sum(len(chapter.steps) for chapter in wording) + 1)
    )


def test_what_is_there_grows_by_what_comes_in(best_assembly: Assembly) -> None:
    for unit, steps in scenes(best_assembly.order):
        there: list[str] = []
        for scene in steps:
            assert list(scene.there) == there
            there += [name for _, names in scene.coming for name in names]
        if unit.name == "machine":
            assert sorted(there) == sorted(o.name for o in best_assembly.occurrences)


def test_screws_are_reported_with_key_and_torque(wording: list[Chapter]) -> None:
    steps = {(chapter.kind, step.title): step for chapter in wording for step in chapter.steps}
    motor = steps["cheek", "Motor on its cheek"]
    assert motor.torques == ("5 × screw low-M3x5: 0.7 N m",)
    assert motor.tools[:2] == ("hexagon key 2", "torque key")
    assert steps["drive", "Shoulder shaft"].torques == ("1 × screw M4x10: 2.2 N m",)
    assert steps["drive", "Tension of the cable, set screws"].torques == ("2 × set screw M3x3: 0.4 N m",)


@pytest.mark.parametrize("size", sorted(END_TORQUE_N_m))
def test_torques_are_those_that_the_shaft_states(size: str) -> None:
    """The shaft's were worked out by hand."""
    assert tightening_N_m(catalogue.screw(size)) == pytest.approx(END_TORQUE_N_m[size], abs=0.06)


@pytest.mark.parametrize("size", ["M2", "M3", "M6", "M8"])
def test_a_torque_is_about_a_fifth_of_force_times_diameter(size: str) -> None:
    """The rule of thumb T = 0.2 F d of dry steel."""
    assert tightening_N_m(catalogue.screw(size)) == pytest.approx(
        0.2 * screw_N(catalogue.screw(size)) * float(size[1:]) / 1000.0, rel=0.12
    )


def test_nothing_is_put_through_seats_in_which_bearings_lie(best_assembly: Assembly) -> None:
    """A mandrel of the seats' own diameter goes through them where they are reamed, not when the bearings are in."""
    filled, reamed = set[str](), set[str]()
    for unit in best_assembly.order:
        for step in unit.steps:
            coming = [name for insertion in step.insertions for name in insertion.names]
            filled |= {name.split("_")[1] for name in coming if name.startswith("bearing_")}  # of which chains
            said = " ".join((*step.words, *step.checks, *step.tools))
            if "mandrel" in said or "both seats" in said:
                assert unit.name == f"cheek {unit.name[-1]}", step.title
                assert unit.name[-1] not in filled, (unit.name, step.title)
                reamed.add(unit.name[-1])
    assert filled == reamed == {"0", "1", "2"}


def test_the_last_step_of_a_capstan_machine_connects_it_and_keeps_its_keys(best_assembly: Assembly) -> None:
    said = " ".join(best_assembly.order[-1].steps[-1].words)
    assert "let all wires hang free" in said.lower()
    assert "Keep the cut key" in said


def test_zeros_are_calibrated_by_a_command_that_keeps_what_control_needs(best_assembly: Assembly) -> None:
    """The command in the manual is one that haptics takes, and its accuracy gives the last step's half degree."""
    (step,) = (step for step in best_assembly.order[-1].steps if step.title == "Calibration")
    said = " ".join(step.words)
    assert "Connect motors and sensors" in said
    command = said.partition("python -m haptics calibrate ")[2].partition(". It writes")[0]
    parser = argparse.ArgumentParser()
    add_options(parser, calibrate.OPTIONS)
    given = parser.parse_args(command.split())
    assert (given.frame, given.accuracy) == ("own", CALIBRATED_MM)
    assert "where control is made for 0.5 deg" in step.checks[0]
    assert "within 0.5 deg" in best_assembly.order[-1].steps[-1].checks[1]


def test_a_direct_drive_is_assigned_no_bearing_and_how_far_its_magnet_s_stub_stands_out(
    direct_assembly: Assembly, direct_dimensions: Dimensions
) -> None:
    d, units = direct_dimensions, {unit.name: unit for unit in direct_assembly.order}
    cheek, arm = units["encoder cheek 0"], units["arm 0"]
    assert "earing" not in " ".join(text for step in cheek.steps for text in (step.title, *step.words, *step.checks))
    (stub,) = (step for step in arm.steps if step.title == "Stub of the magnet")
    assert d.shaft.y_mm[0] < d.layers.arm_mm[0]  # the encoder's side
    for text in (stub.words[0], stub.checks[0]):
        assert f"{abs(d.shaft.y_mm[0]) - abs(d.layers.arm_mm[0]):g} mm" in text
