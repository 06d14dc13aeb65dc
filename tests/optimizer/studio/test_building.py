"""A build from the page: `design` in its own process, its progress, its end, and how it is stopped."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from optimizer.studio import records
from optimizer.studio.building import Build, Progress, downloads
from tests.optimizer.studio.tasks import JOYSTICK, session, until

IMPOSSIBLE = """
name = "impossible"
[requirements]
envelope_width_mm = 270
envelope_depth_mm = 220
cube_side_mm = 215
force_N = 3
"""


def test_progress_is_that_of_design_and_what_is_no_event_is_said() -> None:
    progress = Progress("running")
    step = {"step": 3, "of": 4, "name": "lengths", "done": 1, "total": 8, "best": "80 mm of cube", "left_s": 60.0}
    for event in (
        {"event": "progress", "s": 1.0, "doing": "loading"},
        {"event": "progress", "s": 2.0, "doing": "5:1"} | step,
        {"event": "found", "s": 3.0, "text": "79 mm of cube"} | step | {"done": 2},
        {"event": "verdict", "verdict": "infeasible", "text": "infeasible: x"},
        {"event": "message", "text": "infeasible: x"},
    ):
        progress.hear(json.dumps(event) + "\n")
    progress.hear("[1, 2]\n")
    record = progress.record()
    assert record["at"] == step | {"done": 2}
    assert (record["verdict"], record["now"]) == ("infeasible: x", "[1, 2]")
    assert record["lines"] == ["79 mm of cube", "[1, 2]"]
    progress.hear(json.dumps({"event": "progress", "s": 4.0, "doing": "6:1"}))
    assert (record["at"], progress.now) == (step | {"done": 2}, "6:1")


@pytest.mark.slow  # 20 s of processor: the search's own verdict, by its own process
def test_what_cannot_be_built_has_the_searchs_verdict_before_its_end_and_at_it(tmp_path: Path) -> None:
    said: list[str] = []
    build = Build(tmp_path, lambda: said.append(build.progress.state), lambda _: said.append("ended"))
    build.begin(IMPOSSIBLE, "impossible", None)
    until(lambda: build.progress.verdict or not build.running)
    assert build.running  # a nearest machine is sought, which takes a minute
    build.stop()
    until(lambda: not build.running)
    record = build.progress.record()
    assert (record["state"], build.progress.facts["verdict"]) == ("infeasible", "infeasible")
    assert build.progress.facts["contradiction"]
    assert "ended" not in said
    build.close()


@pytest.mark.parametrize("killed", [False, pytest.param(True, marks=pytest.mark.slow)])
def test_a_build_that_is_stopped_or_dies_ends_and_the_next_goes_on(tmp_path: Path, killed: bool) -> None:
    build = Build(tmp_path, lambda: None, lambda _: None)
    text = JOYSTICK.read_text(encoding="utf-8")
    build.begin(text, "dashboard-joystick", None)
    until(lambda: list(tmp_path.glob("*.design.jsonl")))  # the search has begun
    assert build._process is not None
    build._process.kill() if killed else build.stop()
    until(lambda: not build.running)
    assert build.progress.record()["state"] == ("failed" if killed else "stopped")
    assert build._cut == text
    assert not (tmp_path / "dashboard-joystick").exists()
    build.begin(text, "dashboard-joystick", None)
    assert build._process is not None
    assert "--resume" in str(build._process.args)
    build.close()
    assert not build.running


def test_what_design_refuses_is_said(tmp_path: Path) -> None:
    build = Build(tmp_path, lambda: None, lambda _: None)
    build.begin('name = "x"\n', "x", None)
    until(lambda: not build.running)
    record = build.progress.record()
    assert record["state"] == "failed"
    assert "requirements" in record["error"]
    build.close()


def test_a_session_that_ends_ends_its_build(tmp_path: Path) -> None:
    with session(tmp_path) as (one, kept):
        one.receive({"type": "build"}, "me")
        assert kept.of("build", state="running")
        one.receive({"type": "build"}, "me")
        assert "under way" in kept.of("say", kind="error")[-1]["text"]
        process = one.build._process
        assert process is not None
    assert process.poll() is not None
    assert (tmp_path / "out" / "dashboard-joystick.studio.toml").is_file()


def test_a_folder_without_a_machine_has_no_solids(tmp_path: Path) -> None:
    assert records.solids(tmp_path) is None
    assert downloads(tmp_path) == []
    (tmp_path / "report.html").write_text("<html>", encoding="utf-8")
    (tmp_path / "assembly.glb").write_bytes(b"")
    assert records.solids(tmp_path) is None
