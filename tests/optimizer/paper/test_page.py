"""What is said of the recomputed tables: numbers and decisions, on the page what the JSON file holds."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from pathlib import Path

import pytest

from optimizer.commands import reproduce
from optimizer.paper.page import page, record
from optimizer.paper.placed import PlacedStep
from optimizer.paper.published import STEP_OF_TABLE, numbers
from optimizer.paper.reproduction import METHODS, ReproducedRun, Reproduction
from tests.optimizer.messages import holds

Runs = list[ReproducedRun]
GOLDEN = Path(__file__).parents[3] / "docs" / "reproduce.md"
# Of the GA, which is small here, and differences of SQP from the optimum, which are roundings.
OTHERS = {"our GA", "our GA+SQP", "its kappa", *(f"our {name.upper()} off by" for name in METHODS)}


def tables(text: str) -> dict[str, list[dict[str, str]]]:
    """The tables of the page by their heading: heading of a column -> cell, of each row."""
    found = {}
    for part in text.split("\n## ")[1:]:
        lines = [[cell.strip() for cell in line.strip("|").split("|")] for line in part.splitlines() if line[:1] == "|"]
        found[part.splitlines()[0].partition(":")[0]] = [dict(zip(lines[0], line, strict=True)) for line in lines[2:]]
    return found


def test_the_page_is_the_committed_one_but_for_what_a_small_ga_finds(
    runs: Runs, made: Reproduction, placed: PlacedStep
) -> None:
    text, golden = page(record(runs, made, placed)), GOLDEN.read_text(encoding="utf-8")
    for heading, rows in tables(golden).items():
        for row, own in zip(rows, tables(text)[heading], strict=True):
            for name in row.keys() - OTHERS - {"ours"}:
                assert own[name] == row[name], f"{heading}: {row}"

    def prose(page: str) -> list[str]:
        return [line for line in page.splitlines() if line[:1] != "|" and not line.startswith("Source")]

    assert prose(text) == prose(golden)


def test_what_came_of_each_step(runs: Runs, made: Reproduction) -> None:
    steps = record(runs, made)["steps"]
    counts = ("runs", "results_in_print", "within_agreement", "within_beside_half_last_digit", "feasible_by_proof")
    assert [tuple(one[name] for name in counts) for one in steps] == [
        (14, 11, 7, 11, 14),
        (8, 7, 0, 0, 8),
        (8, 8, 0, 0, 8),
    ]
    assert [one["largest_difference"] for one in steps] == pytest.approx([0.0036024, 0.378078, 2.1282], rel=1e-4)
    assert [one["largest_gap"] for one in steps] == pytest.approx([0.007354, 0.41107, 0.1611], rel=1e-3)
    for one in steps:
        assert one["off_the_proved_optimum"]["sqp"] < 1e-6


def test_what_is_not_proved_or_found_is_remarked(runs: Runs, made: Reproduction) -> None:
    r = next(r for r in runs if r.run.name == "table 10 row 5")
    outside = replace(r.attempts["sqp"].result, design_mm=(82.0, 130.0, 40.0, 50.0, 40.0, 100.0))
    lost = r.attempts | {"sqp": r.attempts["sqp"]._replace(result=outside, ending="ended 0.1 short")}
    poor = replace(r, proven=replace(r.proven, status="gap not reached", gap=0.01), attempts=lost)
    text = page(record([poor], made))
    assert holds(text, "- row 5: 1.0e-02")
    assert "ended 0.1 short" in text
    assert tables(text)["Table 10"][0]["our SQP"] == tables(text)["Step by step"][0]["our SQP off by"] == "-"
    nothing = replace(r.proven, status="infeasible", objective=math.nan, bound=math.nan, gap=math.nan, design_mm=())
    empty = replace(poor, proven=nothing)
    facts = record([empty], made)
    assert facts["tables"]["10"]["rows"][0]["proven"]["bound"] is None
    assert facts["steps"][0]["feasible_by_proof"] == 0
    assert "- row 5: the proof ended with: infeasible\n" in page(facts)
    json.dumps(facts, allow_nan=False)


def test_defaults_are_the_papers() -> None:
    paper = numbers()["table_2_ga_parameters"]
    table = {row["parameter"].split(" in ")[0]: row for row in record([], Reproduction())["table_2"]}
    assert table["population"]["ours"] == paper["population"] == [100, 220, 220]
    assert table["generations"]["ours"] == paper["generations"] == 100
    assert table["crossover fraction"]["ours"] == paper["crossover_fraction"]
    assert tuple(STEP_OF_TABLE) == reproduce.TABLES
