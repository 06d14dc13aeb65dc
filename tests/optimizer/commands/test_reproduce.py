"""`python -m optimizer reproduce`: its files, exit codes, refusals and progress."""

from __future__ import annotations

import json
import os
import signal
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from delta_cad.common import console
from optimizer.commands import cli
from optimizer.paper.published import published_runs
from optimizer.paper.reproduction import Reproduction
from tests.optimizer.messages import holds
from tests.terminal import shown_on_a_terminal

SMALL = ["--population", "12", "--generations", "3"]


def call(*arguments: str | Path) -> int:
    return cli.main([str(argument) for argument in arguments])


@pytest.mark.slow
def test_command_writes_page_and_json_and_the_same_again(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for name in ("a", "b"):
        assert call("reproduce", "--out", tmp_path / name / "new", "--tables", "11,8", *SMALL, "--seed", "3") == 0
        out, err = capsys.readouterr()
        assert err == ""
        assert "| 3 | 4 | 4 | 0 | 0 | 212.82 % |" in out
        assert sorted(f.name for f in (tmp_path / name / "new").iterdir()) == ["reproduce.json", "reproduce.md"]
    for name in ("reproduce.json", "reproduce.md"):
        assert (tmp_path / "a" / "new" / name).read_bytes() == (tmp_path / "b" / "new" / name).read_bytes()
    reported = json.loads((tmp_path / "a" / "new" / "reproduce.json").read_text())
    assert (list(reported["tables"]), reported["seed"]) == (["8", "11"], 3)
    assert call("reproduce", "--out", tmp_path / "a", "--tables", "8", *SMALL, "--json") == 0
    assert capsys.readouterr().out == (tmp_path / "a" / "reproduce.json").read_text()


def test_bad_input_exits_2_in_one_line_and_writes_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file").write_text("")
    cases_ = (
        (("--tables", "5"), "--tables 4 6 7 8 9 10 11 12"),
        (("--tables", "x"), "--tables"),
        (("--seed", "-1"), "--seed -1"),
        (("--tables", "8", "--population", "2"), "3 2 100"),
        (("--tables", "8", "--generations", "0"), "3 220 0"),
        (("--tables", "8", *SMALL, "--out", "file"), "file: "),
    )
    for arguments, words in cases_:
        try:
            code = call("reproduce", *arguments)
        except SystemExit as error:
            code = int(error.code or 0)
        out, err = capsys.readouterr()
        assert (code, out) == (2, "")
        assert holds(err, words)
        assert err.count("\n") == 1
        assert [f.name for f in tmp_path.iterdir()] == ["file"]


def test_an_interrupted_run_writes_nothing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    shown = []

    def show(_line: object, text: str) -> None:
        if text.startswith("table"):
            shown.append(text)
        if len(shown) == 2:
            os.kill(os.getpid(), signal.SIGINT)

    monkeypatch.setattr(console.ProgressLine, "show", show)
    assert call("reproduce", "--out", tmp_path / "out", "--tables", "8", *SMALL) == console.INTERRUPTED
    assert capsys.readouterr().err == "interrupted; nothing was written\n"
    assert shown == ["table 8 row 1 (1 of 2): ga", "table 8 row 1 (1 of 2): sqp"]
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_progress_appears_on_a_terminal_only(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "optimizer", "reproduce", "--out", str(tmp_path), "--tables", "8", *SMALL]
    code, shown = shown_on_a_terminal(command)
    assert code == 0
    assert b"table 8 row 2 (2 of 2): proof of the optimum" in shown
    assert shown.endswith(b"\r\x1b[K")


def test_exit_code_1_where_a_proof_or_method_fails(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    (r,) = Reproduction(population=12, generations=3).recompute(published_runs((8,))[:1])
    outside = replace(r.attempts["ga+sqp"].result, design_mm=(82.0, 130.0, 40.0, 50.0, 40.0, 100.0))
    found = r.attempts | {"ga+sqp": r.attempts["ga+sqp"]._replace(result=outside)}
    poor = replace(r, proven=replace(r.proven, status="gap not reached"), attempts=found)
    monkeypatch.setattr(Reproduction, "recompute", lambda *_: [poor])
    assert call("reproduce", "--out", tmp_path, "--tables", "8") == 1
    err = capsys.readouterr().err
    assert err == "the optimum of table 8 row 1 is not proved; GA+SQP fails on table 8 row 1\n"
    assert (tmp_path / "reproduce.md").exists()
