"""Prices of bought parts: whose they are, what several cost, and that an estimate says so."""

from __future__ import annotations

import csv
from dataclasses import replace

import pytest

from delta_cad import catalogue
from delta_cad.assembly.machine import Assembly
from delta_cad.dimensions import Dimensions
from delta_cad.export.shop.cost.bought import FILE, Price, part_price, prices, row_price
from delta_cad.export.shop.cost.rates import Rates
from delta_cad.export.shop.cost.work import making, material_id, work_of
from delta_cad.solids.bought_parts import make_spacer
from delta_cad.solids.upper_arm import make_shoulder_washer


def test_the_catalogue_s_price_comes_before_the_list_s() -> None:
    row = catalogue.motor("maxon-re30-310009-500")
    price = row_price("motor", row)
    assert (price.one_EUR, price.source) == (348.60, row.price_source)
    assert row_price("motor", catalogue.motor("maxon-re30-310007")).one_EUR == 260.0
    assert row_price("bearing", replace(catalogue.bearing("688"), price_EUR=2.5, price_source="2026, x")).one_EUR == 2.5


def test_a_motor_of_which_nothing_is_known_is_priced_by_its_torque() -> None:
    own = replace(catalogue.motor("maxon-re30-310007"), id="own", nominal_torque_N_m=0.1)
    assert row_price("motor", own).one_EUR == pytest.approx(280.0)
    assert "estimate" in row_price("motor", own).source


def test_every_row_that_a_design_may_choose_has_a_price() -> None:
    for kind in catalogue.CHOSEN:
        for row in catalogue.family(kind).values():
            assert row_price(kind, row).one_EUR > 0.0, row.id


def test_a_stock_spacer_costs_less_than_turning_it_and_the_first_that_fits_is_the_cheapest(
    best_dimensions: Dimensions,
) -> None:
    d, rates = best_dimensions, Rates()
    turned = make_spacer(2.9, 5.0), make_shoulder_washer(replace(d, shaft=replace(d.shaft, washer=None)))
    counts = {"board_spacer": 12, "shoulder_washer": 3}
    for part in turned:
        assert part.make
        made = making(work_of(part, 1, rates), material_id(part), rates).of_one(counts[part.number], rates)
        assert prices(d)[part.number].one_EUR < made
    for thread in ("M2.5", "M3", "M4", "M5"):
        costs = [row_price("spacer", row).one_EUR for row in catalogue.spacer.rows.values() if row.thread == thread]
        assert costs == sorted(costs)


def test_a_washer_without_a_stock_spacer_is_turned() -> None:
    ring = (9.4, 10.1)
    found = catalogue.stock_spacer("M4", 3.0, ring, "stainless-1.4305")
    assert found is not None
    assert found.outer_mm == 10.0
    assert catalogue.stock_spacer("M4", 3.5, ring) is None
    assert catalogue.stock_spacer("M4", 3.0, (9.4, 9.9)) is None
    assert catalogue.stock_spacer("M4", 3.0, ring, "brass") is None
    assert catalogue.stock_spacer("M8", 3.0, ring) is None


def test_what_several_cost() -> None:
    piece, metre = Price(10.0, "piece", ""), Price(3.0, "metre", "", 370.0)
    assert [piece.of_one(3, n) for n in (1, 5, 10, 100, 250)] == [10.0, 10.0, 9.0, 7.5, 7.5]
    assert metre.of_one(3, 1) == pytest.approx(3.0 * 2 / 3)  # two metres of rope for three of 0.37 m
    assert metre.of_one(3, 100) == pytest.approx(3.0 * 0.75 * 111 / 300)
    pack = Price(18.0, "pack", "")
    assert pack.of_one(1, 1) == 18.0
    assert pack.of_one(1, 100) == pytest.approx(18.0 * 0.75 * 10 / 100)


def test_every_line_of_the_list_says_that_it_is_an_estimate() -> None:
    rows = list(csv.DictReader(FILE.read_text(encoding="utf-8").splitlines()))
    for row in rows:
        free = float(row["price_EUR"]) == 0.0
        assert row["source"].startswith("comes with" if free else "estimate"), row
    assert {row["per"] for row in rows} == {"piece", "metre", "pack"}
    assert rows[-1]["id"] == "*"  # after all that are named


def test_every_bought_part_of_the_joystick_is_known_by_name(
    best_dimensions: Dimensions, best_assembly: Assembly
) -> None:
    known = prices(best_dimensions)
    numbers = [part.number for part in best_assembly.parts if not part.make and not part.piece_of]
    numbers += [supply.number for supply in best_assembly.supplies]
    unknown = [n for n in numbers if n not in known and part_price(n) == part_price("nothing known")]
    assert unknown == []
