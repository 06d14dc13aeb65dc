"""`python -m optimizer front`: what it writes, prints and refuses; interrupted runs."""

from __future__ import annotations

import csv
import json
import re
import signal
import subprocess
import sys
from collections.abc import Iterator
from importlib import util
from pathlib import Path
from typing import Any

import pytest

from delta_cad.design import load_design
from optimizer.commands import cli, front
from optimizer.paper.evaluation import mechanism_of
from optimizer.search.result import Result
from optimizer.study.front import Curve, FrontPoint, at_side
from optimizer.study.trade import Trade
from tests.optimizer.front_tasks import JOYSTICK, joystick
from tests.terminal import said

BEST = JOYSTICK.parents[2] / "examples" / "synthesized.json"
FILES = {"front.csv", "front.json", "front.md"} | {
    f"{name}.{end}" for name in ("front", "trade", "workspace", "maps", "convergence") for end in ("png", "svg")
}
SMALL = ["--points", "4", "--seeds", "1"]


@pytest.fixture(scope="module")
def task(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The former task between 36 and 40 mm: little to trace."""
    return requirements(tmp_path_factory.mktemp("task"), half_side="[36, 40]")


def requirements(folder: Path, **replaced: str) -> Path:
    text = JOYSTICK.read_text()
    for name, value in replaced.items():
        text, count = re.subn(rf"(?m)^{name} = .*$", f"{name} = {value}", text)
        assert count == 1
    path = folder / "task.toml"
    path.write_text(text)
    return path


@pytest.fixture(scope="module")
def done(task: Path, tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, Any]]:
    """One run in a process of its own, as a user has it."""
    out = tmp_path_factory.mktemp("front") / "new"
    command = [sys.executable, "-m", "optimizer", "front", str(task), *SMALL, "--json", "--out", str(out)]
    run = subprocess.run(command, capture_output=True, text=True)
    assert (run.returncode, said(run.stderr)) == (0, "")
    return out / "dashboard-joystick-front", json.loads(run.stdout)


def call(*arguments: str | Path) -> int:
    return cli.main(["front", *(str(argument) for argument in arguments)])


@pytest.mark.slow
def test_folder_holds_everything_and_nothing_is_next_to_it(done: tuple[Path, dict[str, Any]]) -> None:
    folder, _ = done
    assert {path.name for path in folder.glob("[!.]*")} == FILES
    assert [path.name for path in folder.parent.iterdir()] == ["dashboard-joystick-front"]


@pytest.mark.slow
def test_json_csv_and_page_say_the_same(done: tuple[Path, dict[str, Any]]) -> None:
    folder, reported = done
    assert json.loads((folder / "front.json").read_text()) == reported
    points = [point for curve in reported["curves"] for point in curve["points"]]
    with (folder / "front.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert [float(row["max_kappa"]) for row in rows] == [point["max_kappa"] for point in points]
    main = reported["curves"][0]
    assert [point["half_side_mm"] for point in main["points"]] == pytest.approx(
        [36.0, 36.0 + 4 / 3, 36.0 + 8 / 3, 40.0]
    )
    assert all(point["proven_bound"] >= point["max_kappa"] * (1.0 - 2e-4) for point in main["points"])
    assert main["proven_half_side_mm"] == 40.0
    text = (folder / "front.md").read_text()
    for name in re.findall(r"!\[[^]]*\]\(([^)]*)\)", text):
        assert (folder / name).is_file()
    assert text.count("![") == 5


@pytest.fixture(scope="module")
def bare() -> Iterator[pytest.MonkeyPatch]:
    """The command with the front as required alone and without drawing."""
    from optimizer.study import pictures, trade

    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(trade, "OUTLINES", ())
        patched.setattr(trade, "TORQUES", ())
        patched.setattr(pictures, "save", lambda *_: [])
        yield patched


@pytest.fixture(scope="module")
def unbroken(task: Path, bare: pytest.MonkeyPatch, tmp_path_factory: pytest.TempPathFactory) -> Path:
    del bare
    out = tmp_path_factory.mktemp("unbroken")
    assert call(task, *SMALL, "--out", out) == 0
    return out


@pytest.mark.slow
@pytest.mark.parametrize("moment", ["point 3", "picture: trade"])
def test_stopped_by_hand_keeps_the_points_and_resumed_is_as_unbroken(
    task: Path,
    tmp_path: Path,
    unbroken: Path,
    bare: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    moment: str,
) -> None:
    from delta_cad.common.console import ProgressLine

    def show(_: ProgressLine, text: str) -> None:
        if moment in text:
            signal.raise_signal(signal.SIGINT)

    capsys.readouterr()
    with bare.context() as patched:
        patched.setattr(ProgressLine, "show", show)
        assert call(task, *SMALL, "--out", tmp_path) == 130
    out, err = capsys.readouterr()
    partial, kept = (tmp_path / f"dashboard-joystick-front.{end}" for end in ("partial", "checkpoint.jsonl"))
    assert out == ""
    count = 3 if moment == "point 3" else 4
    assert err == f"interrupted; {count} points so far in {partial}; run again with --resume to go on\n"
    assert {path.name for path in tmp_path.iterdir()} == {partial.name, kept.name}
    assert {path.name for path in partial.glob("[!.]*")} == {"front.csv", "front.json", "front.md"}
    assert "**Interrupted" in (partial / "front.md").read_text()
    assert json.loads((partial / "front.json").read_text())["status"] == "interrupted"
    assert call(task, *SMALL, "--out", tmp_path, "--resume") == 0
    assert [path.name for path in tmp_path.iterdir()] == ["dashboard-joystick-front"]
    for name in ("front.json", "front.csv", "front.md"):
        first, second = (out / "dashboard-joystick-front" / name for out in (tmp_path, unbroken))
        assert first.read_bytes() == second.read_bytes()


@pytest.mark.slow
def test_text_tells_the_points_and_what_limits(
    task: Path, tmp_path: Path, bare: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    del bare
    assert call(task, "--points", "4", "--seeds", "0", "--out", tmp_path, "--design", BEST) == 0
    out, err = capsys.readouterr()
    assert err == ""
    assert out.startswith("smallest: cube of 72 mm, worst kappa 1.819, torque 0.2782 N m; binds: outline, platform_rad")
    assert "1 % beyond the largest contradict each other: half side <= 40 mm (bounds_mm.half_side)" in out
    assert out.splitlines()[-1] == f"4 points and the pictures in {tmp_path / 'dashboard-joystick-front'}"


def test_design_and_requirements_choose_what_is_pictured() -> None:
    designs = ((82.0, 107.54, 40.0, 30.0, 46.33, 30.0), (82.0, 108.9, 40.0, 30.0, 41.59, 36.0))
    designs = (*designs, (82.0, 116.39, 40.0, 30.0, 43.17, 40.0))
    for wanted, pictured, compared in ((None, 40.0, 36.0), (30.0, 30.0, 30.0)):
        given = joystick(half_side_mm=wanted)
        points = tuple(FrontPoint(Result(at_side(given, d[5]), "sqp", d, "converged"), ()) for d in designs)
        trade = Trade(Curve(given, "as required", "as required", points, 40.0))
        assert trade.knee is points[1]
        assert front.pictured(trade).half_side == pictured
        subject = front.compared(trade)
        assert subject is not None
        assert subject.half_side == compared
        lengths = front.pictured(trade).result.design_mm
        geometry, cube = mechanism_of(lengths)
        assert cube.half_side == pytest.approx(pictured / 1000.0)
        assert geometry.upper_arm_length == pytest.approx(0.082)
        title = front.title_of(lengths, "task")
        assert title.startswith(f"task: cube of {2 * pictured:.4g} mm, R 40, r 30, L_A 82, L_B 1")
    best = load_design(BEST)
    geometry, cube = mechanism_of(front.lengths_of(best))
    assert geometry == best.geometry
    assert cube.bottom_height == pytest.approx(best.cube.bottom_height_mm / 1000.0)
    assert cube.half_side == pytest.approx(best.cube.half_side_mm / 1000.0)


def test_contradiction_exits_1_and_names_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = requirements(tmp_path, half_side="[50, 100]")
    assert call(path, *SMALL, "--out", tmp_path) == 1
    out, err = capsys.readouterr()
    assert out == ""
    assert re.match(r"task\.toml: step 2: .*bounds_mm\.half_side >= 50 mm.* cannot be met together", err)
    assert err.count("\n") == 1
    assert [path.name for path in tmp_path.iterdir()] == ["task.toml"]


def refused(capsys: pytest.CaptureFixture[str], *arguments: str | Path) -> str:
    """What one line a bad call is refused with."""
    assert call(*arguments) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.count("\n") == 1
    return err


def test_bad_input_is_refused_in_one_line(task: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert "3 points are no front" in refused(capsys, task, "--points", "3", "--out", tmp_path)
    one = requirements(tmp_path, half_side="[38, 38]")
    assert "leaves no range of sizes" in refused(capsys, one, *SMALL, "--out", tmp_path / "a")
    assert "must be finite" in refused(capsys, requirements(tmp_path, force_N="nan"), *SMALL, "--out", tmp_path / "a")
    assert "cannot be read" in refused(capsys, tmp_path / "missing.toml", "--out", tmp_path / "a")
    assert "missing.json" in refused(capsys, task, "--design", tmp_path / "missing.json", "--out", tmp_path / "a")
    (tmp_path / "file").write_text("")
    assert "file" in refused(capsys, task, *SMALL, "--out", tmp_path / "file")
    other = tmp_path / "b" / "dashboard-joystick-front.checkpoint.jsonl"
    other.parent.mkdir()
    other.write_text('{"key":{}}\n')
    assert "another run" in refused(capsys, task, *SMALL, "--resume", "--out", tmp_path / "b")
    design = json.loads(BEST.read_text())
    design["mechanism"] |= {"base_radius_mm": 56.122, "platform_radius_mm": 40.0, "forearm_length_mm": 94.266}
    design["cube"] = {"bottom_height_mm": 22.648, "half_side_mm": 43.363}  # its corners are good, its bottom is not
    (tmp_path / "bad.json").write_text(json.dumps(design))
    message = refused(capsys, task, "--design", tmp_path / "bad.json", "--out", tmp_path / "c")
    assert message == f"{tmp_path / 'bad.json'}: the platform is not above the elbows in the whole cube\n"
    assert not (tmp_path / "c").exists()


def test_folder_that_cannot_be_written_is_reported(
    task: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    def run(*_: object) -> int:
        raise OSError(28, "No space left", "x")

    monkeypatch.setattr(front, "_traced", run)
    assert "x: No space left" in refused(capsys, task, *SMALL, "--out", tmp_path)
    assert (tmp_path / "dashboard-joystick-front.checkpoint.jsonl").exists()  # what was solved is kept


def test_without_matplotlib_it_is_refused_before_anything_is_done(
    task: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    true = util.find_spec
    monkeypatch.setattr(front, "find_spec", lambda name: None if name == "matplotlib" else true(name))
    assert "matplotlib is not installed" in refused(capsys, task, "--out", tmp_path)
    assert list(tmp_path.iterdir()) == []
