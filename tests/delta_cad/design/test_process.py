"""The process of each part: what the design file may say, and what parts are then made of."""

from __future__ import annotations

import json

import pytest

from delta_cad import catalogue
from delta_cad.design import Design, DesignError, design_from_dict, design_hash
from delta_cad.design.process import CUT_FROM, NOT_WITH_CAPSTAN, PRINTABLE, any_printed, is_printed, material_of, softer
from tests.committed import ROOT


def design(name: str = "docs/gallery/direct-83.json", **hardware: object) -> Design:
    data = json.loads((ROOT / name).read_text(encoding="utf-8"))
    data["hardware"] |= hardware
    return design_from_dict(data)


def test_nothing_is_printed_unless_it_is_stated() -> None:
    plain = design()
    assert not any_printed(plain.hardware)
    assert {part: material_of(plain.hardware, part) for part in PRINTABLE} == CUT_FROM
    assert design_hash(plain) == design_hash(design(process=None))


def test_a_single_part_has_another_process_than_the_rest() -> None:
    hardware = design(process="printed", processes={"upper_arm": "machined"}).hardware
    assert not is_printed(hardware, "upper_arm")
    assert {part for part in PRINTABLE if is_printed(hardware, part)} == {*PRINTABLE} - {"upper_arm"}
    assert not is_printed(hardware, "rod_cup")


def test_what_carries_a_capstans_bearings_is_cut() -> None:
    hardware = design("best.json", process="printed").hardware
    assert not any(is_printed(hardware, part) for part in NOT_WITH_CAPSTAN)
    assert is_printed(hardware, "base_plate")


def test_printed_material_is_softer_by_its_creep_modulus() -> None:
    hardware = design(process="printed", print_material="pa12-sls").hardware
    row, metal = catalogue.material("pa12-sls"), catalogue.material("aluminium-6082")
    assert material_of(hardware, "base_plate") == "pa12-sls"
    assert row.creep_modulus_Pa is not None
    assert softer(hardware, "base_plate") == pytest.approx(metal.youngs_modulus_Pa / row.creep_modulus_Pa)


@pytest.mark.parametrize(
    ("entry", "field"),
    [
        ({"process": "cast"}, "hardware.process"),
        ({"processes": {"rod_cup": "printed"}}, "hardware.processes.rod_cup"),
        ({"processes": {"upper_arm": "cast"}}, "hardware.processes"),
        ({"print_material": "steel"}, "hardware.print_material"),
    ],
)
def test_a_process_that_no_part_has_is_refused(entry: dict[str, object], field: str) -> None:
    with pytest.raises(DesignError) as caught:
        design(**entry)
    assert caught.value.field.startswith(field)


def test_a_capstans_cheek_that_is_to_be_printed_is_refused() -> None:
    with pytest.raises(DesignError, match="bearings"):
        design("best.json", processes={"motor_cheek": "printed"})


@pytest.mark.parametrize(
    "row", [row for row in catalogue.material.rows.values() if row.process], ids=lambda row: row.id
)
def test_a_printed_materials_figures_are_in_order(row: catalogue.MaterialData) -> None:
    assert row.creep_modulus_Pa is not None
    assert row.layer_strength_Pa is not None
    assert row.yield_strength_Pa is not None
    assert row.creep_modulus_Pa < row.youngs_modulus_Pa
    assert row.layer_strength_Pa <= row.yield_strength_Pa
    assert row.design_modulus_Pa == row.creep_modulus_Pa
    assert row.design_strength_Pa == row.layer_strength_Pa
