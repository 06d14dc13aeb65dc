"""The page, the table and the facts of a front; a folder that is whole or not there."""

from __future__ import annotations

import csv
import dataclasses
import io
import json
from pathlib import Path

import pytest

from optimizer.search.result import Result
from optimizer.study import front
from optimizer.study.convergence import Trace
from optimizer.study.front import Curve, FrontPoint, at_side, proved, published_designs
from optimizer.study.front_page import COLUMNS, files, notable_points, page, record
from optimizer.study.trade import Trade
from optimizer.synthesis.checkpoint import Checkpoint
from tests.optimizer.front_tasks import joystick, kappa_at

DESIGNS = (
    ((82.0, 107.54, 40.0, 30.0, 46.33, 30.0), ("outline",)),
    ((82.0, 108.9, 40.0, 30.0, 41.59, 36.0), ("outline",)),
    ((82.0, 116.39, 40.0, 30.0, 43.17, 40.0), ("outline", "lean")),
)


@pytest.fixture(scope="module")
def trade() -> Trade:
    given = joystick(half_side_mm=36.0)
    points = tuple(
        FrontPoint(Result(at_side(given, design[5]), "sqp", design, "converged"), active) for design, active in DESIGNS
    )
    main = Curve(given, "as required", "as required", points, 40.0, ("this", "that"))
    empty = Curve(given, "outline 0.9", "R + L_A <= 100 mm", (), beyond=("a", "b"))
    return Trade(main, (empty,), (dataclasses.replace(main, name="torque", words="less"),))


def test_csv_reads_back_to_the_last_bit(trade: Trade) -> None:
    rows = list(csv.DictReader(io.StringIO(files(record(trade, 0, [], []), "")["front.csv"])))
    assert tuple(rows[0]) == COLUMNS
    assert [row["curve"] for row in rows] == ["as required"] * 3 + ["torque"] * 3
    for row, point in zip(rows, trade.main.points, strict=False):
        assert float(row["half_side_mm"]) == point.half_side
        assert float(row["cube_side_mm"]) == 2.0 * point.half_side
        assert float(row["max_kappa"]) == point.kappa
        assert float(row["max_torque_N_m"]) == point.torque
        assert float(row["forearm_length_mm"]) == point.result.design_mm[1]
        assert float(row["bottom_height_mm"]) == point.result.design_mm[4]
        assert (float(row["outline_width_mm"]), float(row["outline_depth_mm"])) == point.outline
        assert row["proven_bound"] == ""
        assert row["active"].split("; ") == list(point.active)


def test_outline_is_equation_1(trade: Trade) -> None:
    # L_c sin 30 + sqrt(3) (R + L_A) and L_c cos 30 / 2 + 3/2 (R + L_A) with L_c = 54 mm
    assert trade.main.points[0].outline == pytest.approx((27.0 + 122.0 * 3.0**0.5, 54.0 * 3.0**0.5 / 4.0 + 183.0))


def test_facts_are_json_without_numbers_that_are_none(trade: Trade) -> None:
    traces = [Trace("ga", 0, (10, 20), (float("nan"), 2.0))]
    facts = record(trade, 7, published_designs(trade.main.given), traces)
    read = json.loads(files(facts, "")["front.json"])
    assert read == facts
    assert (read["seed"], read["status"], read["name"]) == (7, "finished", "dashboard-joystick")
    assert read["curves"][0]["points"][1]["max_kappa"] == trade.main.points[1].kappa
    assert read["curves"][1]["largest_half_side_mm"] is None
    assert read["curves"][1]["beyond"] == ["a", "b"]
    assert read["convergence"][0]["max_kappa"] == [None, 2.0]
    assert read["torque_needed_N_m"] == max(p.torque for p in trade.main.points)
    assert len(read["published"]) == 15


def test_reporting_points_are_the_ends_the_wanted_cube_the_knee_and_new_limits(trade: Trade) -> None:
    found = notable_points(trade)
    assert [point for _, point in found] == list(trade.main.points)
    assert found[0][0] == "smallest"
    assert "the requirements' cube" in found[1][0]
    assert found[2][0] == "other limits bind from here, largest"
    assert sum("knee" in what for what, _ in found) == 1


def test_page_tells_points_fronts_published_designs_and_pictures(trade: Trade) -> None:
    published = published_designs(trade.main.given)
    text = page(record(trade, 0, published, []), 3.0, [("front.png", "the front")])
    tables = [part.splitlines() for part in text.split("\n\n") if part.startswith("| ")]
    shown = [[[cell.strip() for cell in line.strip("|").split("|")] for line in table[2:]] for table in tables]
    fronts, points, adjacent = shown
    for cells, (what, point) in zip(points, notable_points(trade), strict=True):
        assert (cells[0], cells[-1]) == (what, ", ".join(point.active))
        expected = [2.0 * point.half_side, point.kappa, point.torque, *point.result.design_mm[:5]]
        assert [float(cell) for cell in cells[1:-1]] == pytest.approx(expected, rel=1e-3)  # four digits
    assert [cells[0] for cells in fronts] == [curve.name for curve in trade.curves]
    for cells in (fronts[0], fronts[2]):
        assert [float(cells[k]) for k in (2, 3)] == [3, 80.0]
        assert cells[-1] == "this and that"
        assert cells[4] == cells[6] == cells[9] == ""  # nothing is proved, and torque binds nowhere
    assert (fronts[1][2], fronts[1][3], fronts[1][-1]) == ("0", "", "a and b")
    for cells, found in zip(adjacent, published, strict=True):
        assert cells[0] == f"{found.run.table}, {found.run.row}"
        assert [float(cells[k]) for k in (2, 3, 5)] == pytest.approx(
            [2.0 * found.half_side, found.kappa, found.torque], rel=1e-3
        )
        own = kappa_at(trade.main, found.half_side)
        assert cells[4] == "beyond the front" if own is None else float(cells[4]) == pytest.approx(own, rel=1e-3)
    assert {line.count("|") for line in tables[2]} == {8}
    assert "![the front](front.png)" in text
    assert "Interrupted" not in text


def test_page_of_an_interrupted_run_says_so(trade: Trade) -> None:
    stopped = dataclasses.replace(trade, finished=False, main=dataclasses.replace(trade.main, points=(), beyond=()))
    empty = record(stopped, 0, [], [])
    assert "**Interrupted" in page(empty, 3.0, [])
    assert files(empty, "")["front.csv"].splitlines()[0] == ",".join(COLUMNS)


def test_bounds_are_proved_kept_and_reported(trade: Trade, tmp_path: Path) -> None:
    reported: list[tuple[int, int]] = []
    store = Checkpoint(tmp_path / "kept", {}, resume=False)
    found = proved(trade.main, lambda *at: reported.append(at), store=store)
    store.close()
    assert reported == [(1, 4), (2, 4), (3, 4), (4, 4)]
    for point in found.points:
        assert point.bound is not None
        # lengths are rounded to 0.01 mm here, which costs kappa up to 0.1 %
        assert 0.998 * point.kappa < point.bound <= point.kappa
    assert found.largest_bound == pytest.approx(42.4371, rel=2e-4)
    text = page(record(dataclasses.replace(trade, main=found), 0, [], []), 3.0, [])
    gaps = [1.0 - (point.bound or 0.0) / point.kappa for point in found.points]
    assert f"| {2.0 * (found.largest_bound or 0.0):.6g} | " in text
    assert f"| {100.0 * max(gaps):.2g} % | " in text
    store = Checkpoint(tmp_path / "kept", {}, resume=True)
    again = proved(trade.main, stop=lambda: False, store=store)
    store.close()
    assert again == found


def test_stopped_proofs_leave_no_bound_behind(trade: Trade, tmp_path: Path) -> None:
    store = Checkpoint(tmp_path / "kept", {}, resume=False)
    found = proved(trade.main, stop=lambda: True, store=store)
    store.close()
    assert [point.bound for point in found.points] == [None] * 3
    assert (tmp_path / "kept").read_text().count("\n") == 1
    empty = dataclasses.replace(trade.main, points=())
    assert proved(empty) is empty


def test_bound_without_an_incumbent_is_none(trade: Trade, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(front, "BOXES", 0)
    far = dataclasses.replace(trade.main.points[0].result, design_mm=(82.0, 80.0, 40.0, 30.0, 150.0, 42.6))
    point = FrontPoint(dataclasses.replace(far, problem=at_side(joystick(), 42.6)), ())
    assert proved(dataclasses.replace(trade.main, points=(point,))).points[0].bound is None
