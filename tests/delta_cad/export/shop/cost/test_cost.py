"""Costs of a whole machine: sums, batches, and what a price or a rate moves."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest

from delta_cad.assembly.machine import Assembly
from delta_cad.dimensions import Dimensions
from delta_cad.export.bom import bill_of_materials
from delta_cad.export.shop.cost.cost import Cost, cost_record, machine_cost
from delta_cad.export.shop.cost.rates import BATCHES, Rates


@pytest.fixture(scope="module")
def cost(best_dimensions: Dimensions, best_assembly: Assembly) -> Cost:
    return machine_cost(best_dimensions, best_assembly, {"sector": 3})


def test_the_bill_of_materials_sums_to_the_total(cost: Cost, best_assembly: Assembly) -> None:
    masses = {part.number: 0.001 for part in best_assembly.parts}
    rows = bill_of_materials(best_assembly, masses, cost)
    assert sum(row.total_cost_EUR or 0.0 for row in rows) == pytest.approx(cost.total_EUR(), abs=1e-6)
    assert all(row.unit_cost_EUR and row.cost_source for row in rows)
    assert {row.part_number for row in rows} == cost.by_number.keys()
    plain = bill_of_materials(best_assembly, masses)
    assert all(row.unit_cost_EUR is None for row in plain)
    for k in range(len(BATCHES)):
        assert cost.total_EUR(k, True) + cost.total_EUR(k, False) == pytest.approx(cost.total_EUR(k))


def test_no_part_is_dearer_in_a_larger_batch(cost: Cost) -> None:
    for line in cost.lines:
        assert list(line.unit_EUR) == sorted(line.unit_EUR, reverse=True), line.number
    assert cost.total_EUR(0) > cost.total_EUR(1) > cost.total_EUR(2) > 0.0


def test_set_up_is_shared_by_the_pieces_of_a_batch(cost: Cost) -> None:
    """A sector's one-off cost less that of a hundred machines is what a batch has, over 3 and over 300 pieces."""
    line = cost.by_number["sector"]
    assert line.making is not None
    assert line.work is not None
    assert line.work.clampings == 3
    batch = line.making.batch_min * cost.rates.hour_EUR / 60.0
    assert line.unit_EUR[0] - line.unit_EUR[2] == pytest.approx(batch * (1 / 3 - 1 / 300), abs=0.011)


def test_parts_with_the_same_coat_are_one_lot(cost: Cost) -> None:
    """Pinions and rods' ends are hard anodised: 30 EUR each of a lot of 60."""
    coated = [line for line in cost.lines if line.work is not None and line.work.anodised]
    assert {line.number for line in coated} == {"pinion", "rod_cup"}
    assert [line.making.batch_EUR for line in coated if line.making] == [30.0, 30.0]


def test_a_dearer_motor_and_a_dearer_hour_are_reported(
    cost: Cost, best_dimensions: Dimensions, best_assembly: Assembly
) -> None:
    dear = replace(best_dimensions, motor=replace(best_dimensions.motor, price_EUR=300.0, price_source="2026, offer"))
    found = machine_cost(dear, best_assembly, {"sector": 3})
    assert found.total_EUR() - cost.total_EUR() == pytest.approx(3 * 40.0)
    assert found.by_number["motor"].source == "2026, offer"
    hour = machine_cost(best_dimensions, best_assembly, {"sector": 3}, Rates(hour_EUR=160.0))
    assert hour.total_EUR(0, False) == cost.total_EUR(0, False)
    assert 1.8 * cost.total_EUR(0, True) < hour.total_EUR(0, True) < 2.0 * cost.total_EUR(0, True)


def test_the_record_holds_all_that_it_rests_on(cost: Cost) -> None:
    record = json.loads(json.dumps(cost_record(cost), allow_nan=False))
    assert record["currency"] == "EUR"
    assert record["machines"] == [1, 10, 100]
    total = sum(line["quantity"] * line["unit_EUR"][1] for line in record["lines"])
    assert total == pytest.approx(record["total_EUR"][1])
    assert record["assumed"]["shop"]["hour_EUR"] == 80.0
    assert "estimate" in record["assumed"]["stock_source"]
    made = [line for line in record["lines"] if line["made"]]
    assert all({"work", "making"} <= line.keys() for line in made)


def test_every_line_of_a_made_part_is_reckoned_anew_from_the_record_alone(cost: Cost) -> None:
    """By the formula as it stands there, with no rate but the file's own."""
    record = json.loads(json.dumps(cost_record(cost), allow_nan=False))
    shop, stocks = record["assumed"]["shop"], record["assumed"]["stock"]
    for line in (line for line in record["lines"] if line["made"]):
        work, reported = line["work"], line["making"]
        holes = work["threads"] * shop["thread_min"] + work["fits"] * shop["fit_min"]
        if work["stock"] == "as bought":
            eroded = work["drilled"] * shop["erode_min"] + holes
            piece = (eroded if work["eroded"] else shop["saw_min"]) + shop["handle_min"]
            batch = shop["setup_min"]
        elif work["stock"] == "sheet":
            piece, batch = shop["handle_min"] + shop["deburr_min"], 0.0
        else:
            cut = work["removed_mm3"] / stocks[line["stock"]]["removal_mm3_min"]
            cut += work["finished_mm2"] / shop["finish_mm2_min"] + work["drilled"] * shop["drill_min"] + holes
            piece = cut * (1.0 + shop["idle_share"]) + work["tools"] * shop["tool_min"]
            piece += work["clampings"] * shop["handle_min"] + shop["deburr_min"]
            batch = shop["program_min"] + work["clampings"] * shop["setup_min"]
        assert (reported["piece_min"], reported["batch_min"]) == pytest.approx((piece, batch), abs=2e-3), line[
            "part_number"
        ]
        extra, lot = 0.0, 0.0
        if work["anodised"]:
            extra, lot = shop["anodise_EUR"], shop["anodise_lot_EUR"] / 2  # pinions and rods' ends
        elif work["stock"] == "sheet":
            extra = work["beam_mm2"] * shop["beam_EUR_mm2"] + work["contours"] * shop["pierce_EUR"]
            lot = shop["beam_lot_EUR"]
        for machines, unit, stock in zip(record["machines"], line["unit_EUR"], line["stock_EUR"], strict=True):
            whole = stock + reported["material_EUR"] + extra + piece * shop["hour_EUR"] / 60.0
            whole += (batch * shop["hour_EUR"] / 60.0 + lot) / (machines * line["quantity"])
            assert unit == pytest.approx(whole, abs=0.011), line["part_number"]
