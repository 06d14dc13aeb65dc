"""`design` when its time ends, or Ctrl-C comes: its verdict, what stands, and the command that goes on."""

from __future__ import annotations

import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from delta_cad.commands import pipeline
from delta_cad.commands.pipeline import Outcome
from delta_cad.design import Design
from optimizer.codesign import relaxation, report
from optimizer.codesign.bound import Bound, Family
from optimizer.codesign.run import GRACE_S, HURRIED, NO_BOUND
from optimizer.codesign.search import Search
from optimizer.commands import design as command
from optimizer.search.clock import OutOfTimeError
from tests.optimizer.commands.paper import bound_of, call, finds


@pytest.mark.parametrize("end", ["time", "stopped", "gave up"])
def test_what_a_search_did_not_settle_is_not_infeasible(
    file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys, end: str
) -> None:
    """The time ends, Ctrl-C comes or a candidate is left that the search cannot mend: none shows that there is none."""

    def best(search: Search) -> None:
        search.log.no_progress["a capstan"] = "too weak"
        if end == "gave up":
            search.log.inconclusive.add("a capstan")
            return
        search.log.left = ["b direct"]
        raise OutOfTimeError if end == "time" else KeyboardInterrupt

    monkeypatch.setattr(Search, "best", best)
    monkeypatch.setattr(relaxation, "minimal_relaxations", lambda _: [])
    assert call(file, "--out", tmp_path / "out") == 4
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith("stopped: " if end == "stopped" else "not found in time: ")
    assert ("a capstan" if end == "gave up" else "b direct") in lines[0]
    assert lines[1].endswith("--seed 1" if end == "gave up" else "--resume")
    assert bool(list((tmp_path / "out").glob("*.jsonl"))) == (end != "gave up")


@pytest.mark.usefixtures("paper_build")
def test_a_machine_that_stands_when_the_time_ends_is_built_and_what_was_left_is_named(
    file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys
) -> None:
    def ends() -> None:
        raise OutOfTimeError

    finds(monkeypatch, ends, left=["b direct"])
    assert call(file, "--out", tmp_path / "out") == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith("built: ")
    assert lines[1].endswith("--resume")
    assert "b direct" in lines[2]


@pytest.mark.usefixtures("paper_build")
def test_a_run_whose_time_is_over_can_be_gone_on_with_and_its_remarks_are_gone(
    file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys
) -> None:
    """In no time the machine is built as it was known, without a bound; with time its bound is proved."""
    monkeypatch.setattr("optimizer.codesign.bound.bounded", lambda family, side, *_: bound_of(family, 9.0, side))
    finds(monkeypatch)
    assert call(file, "--out", tmp_path / "out", "--minutes", "1e-9", "--json") == 0
    assert list((tmp_path / "out").glob("*.jsonl"))
    text = (tmp_path / "out/synthesized/design.md").read_text(encoding="utf-8")
    assert HURRIED in text
    assert NO_BOUND in text
    monkeypatch.setattr("optimizer.codesign.bound.bounded", lambda family, side, *_: bound_of(family, 1.01, side))
    shutil.rmtree(tmp_path / "out/synthesized")
    assert call(file, "--out", tmp_path / "out", "--resume", "--json") == 0
    text = (tmp_path / "out/synthesized/design.md").read_text(encoding="utf-8")
    assert HURRIED not in text
    assert NO_BOUND not in text
    capsys.readouterr()


def test_a_build_that_goes_on_beyond_its_time_is_ended_and_leaves_nothing(
    file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys
) -> None:
    """Of two minutes it may take 20 s more, on the clock of the search."""
    seconds = [0.0]

    def build(_design: Design, _out: Path, progress: Callable[[str], None], **_: object) -> Outcome:
        for seconds[0] in (119.0, 121.0, 139.0, 141.0):
            progress("solids")
        raise AssertionError

    finds(monkeypatch, left=["a capstan"])
    monkeypatch.setattr(pipeline, "build", build)
    monkeypatch.setattr(command, "_clock", lambda: lambda: seconds[0])
    assert call(file, "--out", tmp_path / "out", "--minutes", "2") == 4
    assert capsys.readouterr().out.startswith("not found in time: task.toml: not looked at to the end: a capstan\n")
    assert seconds == [141.0]


@pytest.mark.usefixtures("paper_build")
def test_a_bound_leaves_the_time_that_the_end_of_a_build_took_before(
    file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys
) -> None:
    """Of five minutes: of the first build nothing is known; it takes 7 s after its bound, which the second leaves."""
    seconds, stops, written = [200.0], list[list[bool]](), report.DesignReport.write

    def bounded(family: Family, side_mm: float, stop: Callable[[], bool], *_: object) -> Bound:
        looks = []
        for seconds[0] in (292.0, 294.0, 299.0, 301.0):
            looks.append(stop())
        stops.append(looks)
        return bound_of(family, 1.01, side_mm)

    def write(*given: Any) -> None:
        written(*given)
        seconds[0] += 7.0

    monkeypatch.setattr(report.DesignReport, "write", write)
    monkeypatch.setattr("optimizer.codesign.bound.bounded", bounded)
    monkeypatch.setattr(command, "_clock", lambda: lambda: seconds[0])
    finds(monkeypatch, times=2)
    assert call(file, "--out", tmp_path / "out", "--minutes", "5") == 0
    assert stops == [[False, False, False, True], [False, True, True, True]]
    capsys.readouterr()


@pytest.mark.usefixtures("paper_build")
def test_a_build_whose_bound_was_sought_is_ended_whatever_the_time(
    file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys
) -> None:
    """What is left are its last files, which take no longer than those of any other."""
    seconds, paper = [0.0], pipeline.build

    def build(design: Design, out: Path, progress: Callable[[str], None], **given: Any) -> Outcome:
        outcome = paper(design, out, progress, **given)
        seconds[0] = 120.0 + GRACE_S + 1.0
        progress("manifest")
        return outcome

    monkeypatch.setattr(pipeline, "build", build)
    monkeypatch.setattr(command, "_clock", lambda: lambda: seconds[0])
    finds(monkeypatch)
    assert call(file, "--out", tmp_path / "out", "--minutes", "2") == 0
    assert capsys.readouterr().out.startswith("built: ")
