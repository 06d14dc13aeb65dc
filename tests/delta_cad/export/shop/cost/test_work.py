"""Work and cost of blocks, bars and stock as bought, against sums by hand."""

from __future__ import annotations

from dataclasses import replace
from math import pi

import pytest

from delta_cad.export.shop.cost.rates import Rates
from delta_cad.export.shop.cost.work import making, material_id, work_of
from delta_cad.solids.boring import Boring, along_y, along_z, blind, fitted, tapped
from delta_cad.solids.making import material
from delta_cad.solids.part import Bore, Part
from delta_cad.solids.primitive import box, cut, cylinder, one_solid

RATES = Rates(
    hour_EUR=60.0, program_min=10.0, setup_min=5.0, handle_min=2.0, idle_share=0.5, finish_mm2_min=1000.0,
    drill_min=0.5, thread_min=1.0, fit_min=2.0, tool_min=0.25, deburr_min=3.0, allowance_mm=1.0,
)  # fmt: skip
BLOCK = Part("block", "block", box((0, 0, 0), (38, 18, 9)), material("aluminium-6082"), True)


def bored() -> Part:
    boring, z = Boring(), (9.0, 0.0)
    boring.add("4.5 through", [along_z(4.5, (5.0, 9.0), z), along_z(4.5, (33.0, 9.0), z)])
    boring.add("M4 through", [tapped(along_z(0.0, (12.0, 9.0), z), "M4")])
    boring.add("6 H7 through", [fitted(along_z(6.0, (20.0, 9.0), z), "H7")])
    return replace(BLOCK, solid=one_solid(cut(BLOCK.solid, boring.tools), "block"), holes=tuple(boring.holes))


def test_a_block_by_hand() -> None:
    """40 x 20 x 11 mm of stock; 8800 - 6156 mm^3 cut at 20000 a minute, 2376 mm^2 finished, turned over once."""
    work = work_of(BLOCK, 1, RATES)
    assert (work.stock, work.clampings, work.tools, work.drilled) == ("block", 2, 2, 0)
    assert work.stock_mm3 == pytest.approx(8800.0)
    assert work.removed_mm3 == pytest.approx(8800.0 - 6156.0)
    assert work.finished_mm2 == pytest.approx(2 * (38 * 18 + 38 * 9 + 18 * 9))
    found = making(work, "aluminium-6082", RATES)
    assert found.material_EUR == pytest.approx(8.8e-6 * 2700.0 * 9.0)
    piece = 1.5 * (2644.0 / 20_000.0 + 2376.0 / 1000.0) + 2 * 0.25 + 2 * 2.0 + 3.0
    assert found.piece_min == pytest.approx(piece)
    assert found.batch_min == 10.0 + 2 * 5.0
    assert found.of_one(4, RATES) == pytest.approx(8.8e-6 * 2700.0 * 9.0 + piece + 20.0 / 4)


def test_bores_threads_and_fits_take_their_time() -> None:
    plain, work = work_of(BLOCK, 1, RATES), work_of(bored(), 1, RATES)
    assert (work.drilled, work.threads, work.fits, work.tools) == (4, 1, 1, 2 + 3)
    before, after = (making(one, "aluminium-6082", RATES) for one in (plain, work))
    cutting = 4 * 0.5 + 1.0 + 2.0
    cutting += (work.removed_mm3 - plain.removed_mm3) / 20_000.0 + (work.finished_mm2 - plain.finished_mm2) / 1000.0
    assert after.piece_min - before.piece_min == pytest.approx(1.5 * cutting + 3 * 0.25)
    assert after.material_EUR == before.material_EUR


def plate(*bores: Bore) -> Part:
    boring = Boring()
    for k, bore in enumerate(bores):
        boring.add(f"bore {k}", [bore])
    whole = box((0, 0, 0), (98, 58, 8))
    solid = cut(whole, boring.tools) if bores else whole
    return replace(BLOCK, solid=one_solid(solid, "plate"), holes=tuple(boring.holes))


def test_a_plate_keeps_its_milled_faces_and_is_clamped_once_where_all_is_bored_from_one() -> None:
    """100 x 60 x 8 mm of plate, 48000 - 45472 mm^3 cut and 2496 mm^2 of sides finished."""
    from_above = blind(along_z(5.0, (20.0, 20.0), (8.0, 3.0)))
    work = work_of(plate(), 1, RATES)
    assert (work.stock, work.clampings) == ("plate", 1)
    assert work.stock_mm3 == pytest.approx(48_000.0)
    assert work.removed_mm3 == pytest.approx(48_000.0 - 45_472.0)
    assert work.finished_mm2 == pytest.approx(2 * 8 * (98 + 58))
    assert work_of(plate(from_above, along_z(4.0, (50.0, 20.0), (0.0, 8.0))), 1, RATES).clampings == 1
    from_below = blind(along_z(5.0, (70.0, 20.0), (0.0, 5.0)))
    assert work_of(plate(from_above, from_below), 1, RATES).clampings == 2
    assert work_of(plate(blind(along_y(3.0, (50.0, 4.0), (0.0, 9.0)))), 1, RATES).clampings == 2


def test_what_no_plate_in_stock_is_as_thick_as_is_a_block_and_brass_is_not_bought_so() -> None:
    assert work_of(BLOCK, 1, RATES).stock == "block"
    brass = replace(plate(), material=material("brass"))
    assert work_of(brass, 1, RATES).stock == "block"


def test_sheet_is_cut_by_its_contours() -> None:
    """Two sides of 98 and two of 58 mm, and a bore of 6: 2496 + 150.8 mm^2 of faces, two contours."""
    sheet = replace(plate(along_z(6.0, (50.0, 20.0), (0.0, 8.0))), description="eye, cut from sheet 8")
    rates = replace(RATES, beam_lot_EUR=30.0, beam_EUR_mm2=0.002, pierce_EUR=0.5)
    work = work_of(sheet, 1, rates)
    assert (work.stock, work.contours, work.removed_mm3) == ("sheet", 2, 0.0)
    assert work.beam_mm2 == pytest.approx(2496.0 + pi * 6.0 * 8.0, rel=1e-6)
    found = making(work, "aluminium-6082", rates)
    stock = 100 * 60 * 8 * 1e-9 * 2700.0 * 9.0
    assert found.of_one(5, rates) == pytest.approx(stock + 2.0 + 3.0 + 0.002 * work.beam_mm2 + 1.0 + 30.0 / 5)


@pytest.mark.parametrize("ends", [((0, 0, 0), (0, 0, 28)), ((0, 0, 0), (28, 0, 0))])
def test_a_bar_is_turned_about_whatever_axis(ends: tuple[tuple[int, ...], tuple[int, ...]]) -> None:
    pin = replace(BLOCK, solid=cylinder(18.0, *ends))
    work = work_of(pin, 1, RATES)
    assert (work.stock, work.clampings) == ("bar", 1)
    assert work.stock_mm3 == pytest.approx(pi / 4 * 20.0**2 * 30.0)
    assert work.removed_mm3 == pytest.approx(pi / 4 * (20.0**2 * 30.0 - 18.0**2 * 28.0))


def test_a_square_block_with_a_bore_is_milled() -> None:
    square = replace(BLOCK, solid=cut(box((-20, -20, 0), (20, 20, 30)), [cylinder(10.0, (0, 0, -1), (0, 0, 31))]))
    assert work_of(square, 3, RATES).stock == "block"


def test_stock_as_bought_is_only_cut_to_length_or_eroded() -> None:
    tube = replace(BLOCK, order_code="tube 5x3")
    found = making(work_of(tube, 1, RATES), "aluminium-6082", RATES)
    assert (found.material_EUR, found.piece_min, found.batch_min) == (0.0, RATES.saw_min + 2.0, 5.0)
    ball = replace(bored(), order_code="ball 6", description="ball, eroded")
    found = making(work_of(ball, 1, RATES), "steel", RATES)
    assert found.piece_min == pytest.approx(4 * RATES.erode_min + 1.0 + 2.0 + 2.0)


def test_a_coat_costs_a_lot_and_a_piece() -> None:
    coated = making(work_of(replace(BLOCK, description="block, anodised"), 1, RATES), "aluminium-6082", RATES)
    bare = making(work_of(BLOCK, 1, RATES), "aluminium-6082", RATES)
    assert coated.of_one(10, RATES) - bare.of_one(10, RATES) == pytest.approx(0.5 + 60.0 / 10)


def test_what_is_harder_to_cut_takes_longer() -> None:
    work = work_of(BLOCK, 1, RATES)
    times = [making(work, name, RATES).piece_min for name in ("aluminium-6082", "brass", "stainless-1.4305")]
    assert times == sorted(times)
    assert times[0] < times[2]
    assert material_id(BLOCK) == "aluminium-6082"
