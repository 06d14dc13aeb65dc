"""The journal of a search: what was computed is taken up to the last digit, and nothing of another run."""

from __future__ import annotations

from dataclasses import replace
from math import pi
from pathlib import Path
from typing import Any

import pytest

from delta_cad.checks.report import CheckResult
from optimizer.codesign.candidate import Start
from optimizer.codesign.corrections import Corrections, reference
from optimizer.codesign.hardware import Selection
from optimizer.codesign.lengths import Found
from optimizer.codesign.search import Search, SolidResults
from optimizer.codesign.search_log import Journal
from optimizer.problem.brief import brief_from_dict
from optimizer.synthesis.checkpoint import CheckpointError

LENGTHS = (91.0 / 3.0, 2.0, 3.0, 4.0, 5.0, pi)
KEY = {"requirements": "a"}
FOUND = Found(LENGTHS, 2.0 * pi)
RESULTS = [
    CheckResult("clearance", False, 2.0 / 3.0, 2.0, "mm", (1.0, 2.0, pi), ("rod_0_0", "motor_1"), "too close"),
    CheckResult("parts attached", True, None, None, ""),
]


def test_what_was_computed_comes_back_to_the_last_digit(tmp_path: Path) -> None:
    calls: list[str] = []

    def memoize(journal: Journal, of: str) -> Found | None:
        def compute() -> Found | None:
            calls.append(of)
            return FOUND if of == "a" else None

        return journal.memoize("lengths", of, compute, Found | None)

    first = Journal(tmp_path / "j.jsonl", KEY, False)
    assert [memoize(first, of) for of in ("a", "b", "a")] == [FOUND, None, FOUND]
    first.close()
    second = Journal(tmp_path / "j.jsonl", KEY, True)
    assert [memoize(second, of) for of in ("b", "a", "c")] == [None, FOUND, None]
    assert calls == ["a", "b", "c"]


def test_where_a_search_may_begin_comes_back(tmp_path: Path) -> None:
    updated = (
        Corrections(reference())
        .raised("base_radius", 100.0 / 3.0, "keys")
        .with_chains_apart(46.0, 40.0, 1.0 / 3.0, "chains")
    )
    choice = Selection("maxon-re30-310007", "capstan", 4.8, 46.0, {"tube": "cfrp-6x4"}, 0.1)
    required = [None, Start(choice, LENGTHS, Corrections(reference())), Start(choice, LENGTHS, updated)]
    journal = Journal(tmp_path / "j.jsonl", KEY, False)
    for k, one in enumerate(required):
        assert journal.memoize("possible", k, lambda one=one: one, Start | None) == one
    journal.close()
    again = Journal(tmp_path / "j.jsonl", KEY, True)
    found = [again.memoize("possible", k, lambda: pytest.fail("kept"), Start | None) for k in range(len(required))]
    assert found == required
    assert repr(found) == repr(required)  # by which further steps are told apart


def test_checks_and_weights_come_back(tmp_path: Path) -> None:
    made = replace(reference(), gravity_torque_N_m=0.1 / 3.0, own=True), RESULTS, (0.1, 1.0 / 7.0)
    journal = Journal(tmp_path / "j.jsonl", KEY, False)
    journal.memoize("weighed", "x", lambda: made, SolidResults)
    journal.close()
    again = Journal(tmp_path / "j.jsonl", KEY, True)

    def fails() -> Any:
        raise AssertionError

    assert again.memoize("weighed", "x", fails, SolidResults) == made


@pytest.mark.parametrize("kept", [{"lengths_mm": [1.0], "then": 2.0}, {"lengths_mm": [1.0], "score": 2.0, "then": 2.0}])
def test_a_step_that_another_state_of_the_code_kept_is_computed_again(tmp_path: Path, kept: dict[str, Any]) -> None:
    """The key names the version, and between two versions a record may get a field."""
    first = Journal(tmp_path / "j.jsonl", KEY, False)
    first.memoize("lengths", "a", lambda: kept, dict[str, Any])
    first.close()
    again = Journal(tmp_path / "j.jsonl", KEY, True)
    assert again.memoize("lengths", "a", lambda: FOUND, Found | None) == FOUND
    again.close()
    later = Journal(tmp_path / "j.jsonl", KEY, True)
    assert later.memoize("lengths", "a", lambda: None, Found | None) == FOUND


def test_a_figure_that_is_not_finite_is_none_and_can_be_kept(tmp_path: Path) -> None:
    """As a load at a singularity: neither the journal nor `checks.json` or the report's page may end on it."""
    results = [CheckResult("load", False, float("inf"), float("nan"), "N")]
    assert (results[0].value, results[0].limit) == (None, None)
    Journal(tmp_path / "j.jsonl", KEY, False).memoize("moving", "x", lambda: results, list[CheckResult])


def test_a_journal_of_another_run_is_refused(tmp_path: Path) -> None:
    Journal(tmp_path / "j.jsonl", KEY, False).close()
    with pytest.raises(CheckpointError, match="requirements or seed differ"):
        Journal(tmp_path / "j.jsonl", {"requirements": "b"}, True)


def test_a_search_asks_for_no_lengths_twice(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from optimizer.codesign import search as module

    calls: list[Any] = []
    monkeypatch.setattr(module, "best_lengths", lambda *given: calls.append(given) or FOUND)
    brief = brief_from_dict({"name": "b", "requirements": {"envelope_width_mm": 270.0, "envelope_depth_mm": 220.0}})
    choice, corrections = Selection("maxon-re30-310007", "capstan", 4.8, 50.0), Corrections(reference())
    for resume in (False, True):
        journal = Journal(tmp_path / "j.jsonl", KEY, resume)
        search = Search(brief, memoize=journal.memoize)
        assert search._lengths(choice, corrections, None, 1) == FOUND
        assert search._lengths(choice, corrections.updated("why, which changes nothing"), None, 1) == FOUND
        journal.close()
    assert len(calls) == 1
