"""What is said of the recomputed tables: numbers and decisions, on the page what the JSON file holds."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from typing import Any

import pytest

from optimizer.commands import reproduce
from optimizer.paper.page import page, record
from optimizer.paper.published import STEP_OF_TABLE, numbers
from optimizer.paper.reproduction import ReproducedRun, Reproduction
from optimizer.paper.statements import NOTES, VERDICT, Span, figures, statements, summary
from tests.optimizer.messages import holds

Runs = list[ReproducedRun]


def tables(text: str) -> dict[str, list[dict[str, str]]]:
    """The tables of the page by their number: heading -> cell of each row."""
    found = {}
    for part in text.split("\n## Table ")[1:]:
        lines = [[cell.strip() for cell in line.strip("|").split("|")] for line in part.splitlines() if line[:1] == "|"]
        found[part.split(":")[0]] = [dict(zip(lines[0], line, strict=True)) for line in lines[2:]]
    return found


def printed_as(r: ReproducedRun, objective: float) -> ReproducedRun:
    """A run with another objective in print."""
    return replace(r, run=replace(r.run, objective=objective))


def test_the_page_shows_the_numbers_of_the_json_file(runs: Runs, made: Reproduction) -> None:
    facts, text = record(runs, made), page(runs, made)
    json.dumps(facts, allow_nan=False)
    for sentence in (facts["summary"], *facts["verdict"], *facts["notes"], facts["source"]):
        assert sentence in text
    shown, seen = tables(text), 0
    for number, table in facts["tables"].items():
        for row, cells in zip(table["rows"], shown[number], strict=True):
            ours = row["by_our_equations"] or {}
            expected: dict[str, Any] = {
                "row": row["row"],
                "printed": row["printed_objective"],
                "follows: its lengths allow": row["follows"],
                "torque, N m": ours.get("max_torque_N_m"),
                "kappa": ours.get("max_kappa"),
                "kappa, Frobenius": ours.get("max_kappa_frobenius"),
                **{f"our {name.upper()}": found["objective"] for name, found in row["found"].items()},
                "its kappa": row["found"]["ga+sqp"]["max_kappa"],
                "proven": row["proven"]["bound"],
                "off by": None if row["difference"] is None else 100.0 * row["difference"],
                "gap": None if row["gap"] is None else 100.0 * row["gap"],
            }
            for name, value in expected.items():
                cell = cells[name].removesuffix(" %")
                if value is None:
                    assert cell == "-"
                else:
                    decimals = len(cell.partition(".")[2])
                    assert float(cell) == pytest.approx(value, abs=0.501 * 10.0**-decimals)
                    seen += 1
            words = {None: "-", True: "yes", False: "no"}
            assert cells["within 0.3 %"] == words[row["within_agreement"]]
            assert cells["with half the last digit"] == words[row["within_beside_half_last_digit"]]
            kept = "no results" if not ours else "yes" if ours["keeps_its_constraints"] else "missed by"
            assert kept in cells["keeps its constraints"]
            for fault in ours.get("faults", ()):
                assert f"{fault['name']} missed by" in cells["keeps its constraints"]
            assert all(remark in text for remark in (row["note"], *row["changed"]))
    assert seen > 300
    assert [row["parameter"] for row in facts["table_2"]] == [cells["parameter"] for cells in shown["2"]]


def test_the_numbers_of_the_statements(runs: Runs) -> None:
    found = figures(runs)
    close = {
        "count": 11, "off": 0.3602, "below": 0.7354, "torque": (0.30295, 0.32887), "best_sides": (60.528, 63.843),
        "printed_sides": (37.5, 39.2), "printed_kappas": (6.009, 6.57), "kappas": (2.0347, 2.1002),
        "frobenius": (3.5334, 3.5943), "best_kappas": (1.7669, 1.8367), "above": (14.352, 16.110),
        "infinite": 14, "step_1_runs": 14, "missing": 8, "missed": (0.011837, 0.48061), "feasible": 4, "unsolved": 4,
        "least_ridge": 18.15, "side_mm": 35.0, "cube_mm": 70.0, "force_N": 3, "joint_torque_N_m": 0.8,
    }  # fmt: skip
    for name, value in close.items():
        assert found[name] == pytest.approx(value, rel=2e-4), name
    assert found["fold_mm"] < 1e-4
    assert found["radii_mm"] < 1e-4
    assert found["worst"].startswith("table 9 row 2")
    assert "row 1 misses reach by 7.48 mm as printed, nothing" in found["exchanged"]
    assert "8.54 % as printed, 3.12 % by our equations" in found["second_method"]
    assert "the 5 other rows with this proven optimum print 64.2 to 64.25" in found["rounded"]
    assert "from 120 to 130 mm" in found["longer"]
    assert len(statements(runs, VERDICT)) == len(VERDICT)
    assert len(statements(runs, NOTES)) == len(NOTES)
    assert f"{Span(1.04, 1.0):.1f}" == "1.0"
    assert f"{Span(1.0, 1.1):.1f}" == "1.0 to 1.1"


def test_whether_a_step_reproduces_is_decided_from_its_runs(runs: Runs) -> None:
    assert "Step 1 reproduces within 0.3 % in 7 of 11 rows, and in 4 more only with half" in summary(runs)
    assert "step 2 does not reproduce (off by up to 37.8 %)" in summary(runs)
    assert figures(runs)["step_3"] == "does not reproduce"
    # other print, other words
    poor = [printed_as(r, 60.0) if r.run.table == 6 else r for r in runs]
    assert figures(poor)["step_1"].startswith("reproduces within 0.3 % in 6 of 11 rows")
    assert "(off by up to 10.7 %), step 2" in summary(poor)
    good = [r if r.follows is None else printed_as(r, r.follows * 1.0029) for r in runs]
    assert [figures(good)[f"step_{n}"] for n in (1, 2, 3)] == ["reproduces within 0.3 %"] * 3
    none = [r for r in runs if r.run.result is None]
    assert summary(none) == "No published result is among these tables."
    assert statements(none, VERDICT) == []
    assert not {"torque", "kappas", "exchanged", "second_method", "side_mm", "missed"} & figures(none).keys()


def test_what_is_not_proved_or_found_is_remarked(runs: Runs, made: Reproduction) -> None:
    r = next(r for r in runs if r.run.name == "table 10 row 5")
    outside = replace(r.attempts["sqp"].result, design_mm=(82.0, 130.0, 40.0, 50.0, 40.0, 100.0))
    lost = r.attempts | {"sqp": r.attempts["sqp"]._replace(result=outside, ending="ended 0.1 short")}
    poor = replace(r, proven=replace(r.proven, status="gap not reached", gap=0.01), attempts=lost)
    text = page([poor], made)
    assert holds(text, "- row 5: 1.0e-02")
    assert "ended 0.1 short" in text
    assert "ends infeasible" in figures([poor])["solved"]
    assert "SQP none (1 rows without result)" in figures([poor])["distances"]
    assert tables(text)["10"][0]["our SQP"] == "-"
    nothing = replace(r.proven, status="infeasible", objective=math.nan, bound=math.nan, gap=math.nan, design_mm=())
    empty = replace(poor, proven=nothing)
    facts = record([empty], made)
    assert facts["tables"]["10"]["rows"][0]["proven"]["bound"] is None
    assert "- row 5: the proof ended with: infeasible\n" in page([empty], made)
    json.dumps(facts, allow_nan=False)


def test_defaults_are_the_papers() -> None:
    paper = numbers()["table_2_ga_parameters"]
    table = {row["parameter"].split(" in ")[0]: row for row in record([], Reproduction())["table_2"]}
    assert table["population"]["ours"] == paper["population"] == [100, 220, 220]
    assert table["generations"]["ours"] == paper["generations"] == 100
    assert table["crossover fraction"]["ours"] == paper["crossover_fraction"]
    assert tuple(STEP_OF_TABLE) == reproduce.TABLES
