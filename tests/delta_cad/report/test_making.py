"""Tables of cost and tolerances: numbers of the files beside the page, and nothing where they are not."""

from __future__ import annotations

import json
from pathlib import Path

from delta_cad.dimensions import Dimensions
from delta_cad.dimensions.tolerances.record import tolerance_record
from delta_cad.report.page import cost, tolerances


def test_without_files_there_is_nothing_to_tell(tmp_path: Path) -> None:
    assert cost(tmp_path) is None
    assert tolerances(tmp_path) is None


def test_sums_and_the_dearest_lines_are_reported(tmp_path: Path) -> None:
    lines = [
        {"part_number": f"p{k}", "quantity": 2, "unit_EUR": [1.0 * k, 0.5 * k], "source": "estimate"} for k in range(20)
    ]
    record = {
        "machines": [1, 10],
        "made_EUR": [1000.4, 9.5],
        "bought_EUR": [5.25, 1.0],
        "total_EUR": [1005.65, 10.5],
        "assumed": {"shop": {"hour_EUR": 80.0}, "left_out": ["tax"]},
        "lines": lines,
    }
    (tmp_path / "cost.json").write_text(json.dumps(record), encoding="utf-8")
    found = cost(tmp_path)
    assert found is not None
    assert found["sums"][2] == ("one machine", ["1,006", "10.50"])
    assert len(found["lines"]) == 10
    assert found["lines"][0] == ("2 × p19", ["38.00", "19.00"], "estimate")


def test_every_chain_is_reported_with_its_links(best_dimensions: Dimensions, tmp_path: Path) -> None:
    record = tolerance_record(best_dimensions)
    (tmp_path / "tolerances.json").write_text(json.dumps(record), encoding="utf-8")
    found = tolerances(tmp_path)
    assert found is not None
    assert [line["name"] for line in found["chains"]] == [c["name"] for c in record["chains"] + record["lengths"]]
    reported = {line["name"]: line for line in found["chains"]}
    assert reported["wave spring's height"]["worst"] == "1.1 … 1.54 mm"
    assert reported["wave spring's height"]["holds"] is True
    assert reported["gap of sector and pinion"]["allowed"] == "≥ 0.54 mm"
    assert reported["forearm"]["holds"] is None
    assert len(reported["forearm"]["links"]) == 2
