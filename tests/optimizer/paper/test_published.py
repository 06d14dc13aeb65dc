"""The published tables as data: two transcripts, every row with its bounds, starts that are moved."""

from __future__ import annotations

import json
from pathlib import Path

from optimizer.paper.published import FILE, STEP_OF_TABLE, problem_of, published_runs, start_within

REFERENCES = Path(__file__).parents[2] / "references" / "rcim2018.json"


def test_numbers_are_those_of_the_references() -> None:
    """Two transcripts of the same print: what the product ships and what the tests compare with."""
    own, theirs = json.loads(FILE.read_text()), json.loads(REFERENCES.read_text())
    assert "Robotics and Computer-Integrated Manufacturing 51 (2018) 73-84" in own.pop("source")
    assert theirs.pop("source").startswith("RCIM 51 (2018)")
    assert own == theirs


def test_runs_are_all_rows_of_print_with_their_bounds() -> None:
    runs = published_runs()
    count = {table: sum(run.table == table for run in runs) for table in STEP_OF_TABLE}
    assert count == {4: 4, 6: 1, 7: 3, 8: 2, 9: 9, 10: 5, 11: 2, 12: 4}
    last = runs[-1]
    assert (last.name, last.method, last.objective) == ("table 12 row 4", "GA+SQP", 6.009)
    assert last.result == (82.0, 112.079, 40.0, 30.0, 57.112, 35.0)
    assert last.start == (82.0, 113.989, 40.0, 30.0, 58.737, 35.0)
    for run in runs:
        problem, changed = problem_of(run)
        assert problem.step == run.step
        assert problem.lower[0] == problem.upper[0] == 82.0
        assert problem.lower[2] == problem.upper[2] == 40.0
        for k, letter in ((1, "L_B"), (3, "r"), (4, "H")):
            assert (problem.lower[k], problem.upper[k]) == (max(1.0, run.lower[k]), run.upper[k])
            assert (run.lower[k] < 1.0) == any(text.startswith(f"{letter} from 1 mm") for text in changed)
        assert any(text.startswith("L_A fixed at 82") for text in changed) == (run.lower[0] != run.upper[0])
        required = {"outline", "reach"} | ({"torque", "assembly_mode"} if run.step > 1 else set())
        required |= {"balls"} if run.lower[3] == 10.0 else set()  # with r of 20 mm and more they are apart
        assert set(problem.constraints) - {"half_side"} == required
    assert published_runs((8,)) == tuple(run for run in runs if run.table == 8)


def test_starts_outside_the_bounds_are_moved_and_reported() -> None:
    run = next(run for run in published_runs() if run.name == "table 10 row 2")
    problem, _ = problem_of(run)
    start, moved = start_within(run, problem)
    assert start == (82.0, 100.0, 40.0, 40.0, 50.0, 40.0)
    (text,) = moved
    assert text.startswith("start R 30 moved to 40")
    assert start_within(published_runs((8,))[0], problem) == (None, ())
