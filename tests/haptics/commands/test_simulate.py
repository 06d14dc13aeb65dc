"""`python -m haptics simulate`: files, facts, pictures, exit codes, one-line refusals, Ctrl-C."""

from __future__ import annotations

import csv
import json
import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import haptics.model.machine
from delta_cad.design import Design, load_design
from haptics.commands.cli import main
from haptics.gravity.published import of_published_lengths
from haptics.loop.assumptions import nominal_plant
from haptics.loop.choice import BOARD, DAMPED, LoopChoice, at_rate
from haptics.model.machine import MachineModel
from haptics.model.plant import Plant
from haptics.scenes.bench import GUIDE, Assumed
from haptics.scenes.home import home
from haptics.scenes.record import Promise, Scene
from tests.committed import BEST, ROOT
from tests.haptics.scene_machine import scene_machine


@pytest.fixture
def call(best: Design, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Callable[..., int]:
    monkeypatch.setattr(haptics.model.machine, "load_machine", lambda *_: scene_machine(best))
    monkeypatch.chdir(tmp_path)

    def run(*arguments: object) -> int:
        try:
            return main(["simulate", "--design", str(BEST), *map(str, arguments)])
        except SystemExit as ended:
            return int(ended.code or 0)

    return run


def refused(capsys: pytest.CaptureFixture[str]) -> str:
    reported = capsys.readouterr()
    assert reported.out == ""
    assert reported.err.count("\n") == 1
    return reported.err


@pytest.mark.quick(1)
@pytest.mark.parametrize("scene", ["home", "wall", "resistance", "noise"])
def test_a_scene_leaves_series_facts_and_a_picture(
    call: Callable[..., int], scene: str, capsys: pytest.CaptureFixture[str], tmp_path: Path, best: Design
) -> None:
    from matplotlib.image import imread

    assert call("--scene", scene, "--plot", "--json", "--seed", 3) == 0
    facts = json.loads(capsys.readouterr().out)
    folder = tmp_path / "out" / f"{best.name}-{scene}"
    assert json.loads((folder / "facts.json").read_text()) == facts
    assert facts["schema"] == "haptics-simulation/1"
    assert facts["assumptions"]["seed"] == 3
    filtered = 3 * 100e-6 / 4  # what the encoder's filter lags more at a quarter of its bandwidth: settled in 100 us
    late = 0.5 * 0.125e-3 + 10e-6 + filtered  # half a period, and the age that the encoder's data sheet tells
    assert facts["assumptions"]["delay_s"] == pytest.approx(late if scene == "noise" else 0.5e-3)
    there = sorted(path.relative_to(folder).as_posix() for path in folder.rglob("[!.]*") if path.is_file())
    assert there == sorted(facts["files"]["names"])
    assert [path.name for path in (tmp_path / "out").iterdir()] == [folder.name]  # nothing left beside it
    for run in facts["runs"]:
        with (folder / "series" / f"{run['name']}.csv").open(newline="") as file:
            header = next(csv.reader(file))
        assert header[0] == "time_s"
        assert header[-1] == "supervisor_bits"
        assert f"series/{run['name']}.parquet" in there
    assert facts["files"]["parquet"] is True
    image = imread(folder / f"{scene}.png")
    assert image.shape[0] > 900
    assert image.shape[1] > 1600
    drawn = (image[..., :3] < 0.98).any(axis=-1)
    assert 0.02 < drawn.mean() < 0.5  # neither blank nor black
    rows, columns = drawn.any(axis=1), drawn.any(axis=0)
    assert rows[:200].any()
    assert rows[-200:].any()
    assert columns[:200].any()
    assert columns[-200:].any()
    assert not drawn[:2].any()  # and nothing is cut off at the edges
    assert not drawn[-2:].any()
    assert not drawn[:, :2].any()
    assert not drawn[:, -2:].any()


def test_text_and_csv_say_what_was_simulated(
    call: Callable[..., int], capsys: pytest.CaptureFixture[str], tmp_path: Path, best: Design
) -> None:
    from pyarrow import parquet

    assert call("--scene", "home", "--out", tmp_path / "there") == 0
    reported = capsys.readouterr().out
    assert "no parquet" not in reported
    scene = home(scene_machine(best), delay=0.5e-3)
    for promise in scene.promises:
        assert f"kept      {promise.text}\n" in reported
    for run in scene.runs:
        assert run.facts["verdict"] in reported
        path = tmp_path / "there" / f"{best.name}-home" / "series" / f"{run.name}.csv"
        read = np.genfromtxt(path, delimiter=",", names=True)
        assert read.dtype.names == tuple(run.series)
        for name, column in run.series.items():
            assert np.array_equal(read[name], column)  # the shortest digits that read back
        table = parquet.read_table(path.with_suffix(".parquet"))
        assert table.column_names == list(run.series)
        assert all(np.array_equal(table[name].to_numpy(), column) for name, column in run.series.items())
    assert not list((tmp_path / "there").rglob("*.png"))


@pytest.mark.slow
def test_without_pyarrow_csv_alone_is_written_and_said(
    call: Callable[..., int], capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    assert call("--scene", "home") == 0
    assert "pyarrow is not installed" in capsys.readouterr().out
    kinds = {path.suffix for path in (tmp_path / "out").rglob("*") if path.is_file()}
    assert kinds == {".csv", ".json"}


def test_a_broken_promise_is_exit_1(
    call: Callable[..., int], capsys: pytest.CaptureFixture[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def smooth(machine: MachineModel, _level: str) -> Plant:
        return nominal_plant(machine)._replace(coulomb=0.0, bristle_damping=0.0)

    monkeypatch.setattr("haptics.loop.wall_trial.with_friction", smooth)
    assert call("--scene", "wall", "--hand", "light", "--delay", 5) == 1  # a light hand, a late loop, nothing sticks
    assert "NOT KEPT" in capsys.readouterr().out
    assert (tmp_path / "out").is_dir()


@pytest.mark.slow
def test_a_handle_that_is_flung_away_is_written_and_exit_1(
    call: Callable[..., int], capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    no_slide = Assumed(hand=GUIDE._replace(mass=0.0, damping=0.0))
    monkeypatch.setattr("haptics.scenes.home.home", partial(home, assumed=no_slide))
    assert call("--scene", "home", "--delay", 10, "--plot", "--json") == 1
    facts = json.loads(capsys.readouterr().out)
    flung = [run for run in facts["runs"] if run["supervisor_fault"]]
    assert flung
    assert not any(run["rings"] for run in flung)
    lost = [run for run in flung if run["oscillation"] == "diverged"]
    assert lost
    assert all(run["swing_um"] is None and run["distance_at_end_mm"] is None for run in lost)
    assert all(run["frequency_Hz"] is None for run in lost)
    assert call("--scene", "home", "--delay", 10) == 1
    assert "fault: " in capsys.readouterr().out


def test_the_delay_is_reported_as_it_was_given(
    call: Callable[..., int], capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    required: list[float] = []

    def nothing(_: MachineModel, delay: float, seed: int) -> Scene:
        required.append(delay)
        return Scene("home", "", [], {"seen": seed}, [Promise("", True)], [])

    monkeypatch.setattr("haptics.scenes.home.home", nothing)
    assert call("--scene", "home", "--delay", "0.33", "--json") == 0
    assert json.loads(capsys.readouterr().out)["assumptions"]["delay_s"] == pytest.approx(0.33e-3)
    assert required == pytest.approx([0.33e-3])


@pytest.mark.parametrize("scene", ["wall", "noise"])
def test_options_choose_the_loop(
    call: Callable[..., int], capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, scene: str
) -> None:
    loops: list[LoopChoice | None] = []

    def nothing(_: MachineModel, *, loop: LoopChoice | None, **__: Any) -> Scene:
        loops.append(loop)
        return Scene(scene, "", [], {}, [Promise("", True)], [])

    monkeypatch.setattr(f"haptics.scenes.{scene}.{scene}", nothing)
    assert call("--scene", scene, "--rate", "4000", "--drive-damping", "0.62", "--json") == 0
    assert call("--scene", scene, "--json") == 0
    reported = capsys.readouterr().out
    assert loops == [at_rate(4000.0, DAMPED), BOARD if scene == "noise" else None]
    assert at_rate(4000.0, DAMPED).label in reported
    assert (BOARD.label in reported) == (scene == "noise")


def test_the_paper_s_figures_are_of_its_machine_or_another(
    call: Callable[..., int], capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("haptics.scenes.wall.wall", lambda *_, **__: Scene("wall", "", [], {}, [], []))
    assert call("--scene", "wall", "--json") == 0
    assert not json.loads(capsys.readouterr().out)["published_lengths"]
    published = load_design(ROOT / "docs" / "gallery" / "published-75.json").geometry
    assert of_published_lengths(published)
    assert not of_published_lengths(replace(published, side_shift=1e-3))


def test_an_output_that_cannot_be_written_is_one_line_and_exit_2(
    call: Callable[..., int], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "file").write_text("mine")
    assert call("--scene", "home", "--out", tmp_path / "file") == 2
    assert "file" in refused(capsys)
    assert (tmp_path / "file").read_text() == "mine"


def test_ctrl_c_leaves_nothing(
    call: Callable[..., int], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def interrupted(*_: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("haptics.scenes.record.write_csv", interrupted)
    assert call("--scene", "home") == 130
    assert refused(capsys) == "interrupted; nothing was written\n"
    assert not (tmp_path / "out").exists()


def test_pictures_without_matplotlib_are_refused_before_anything_is_simulated(
    call: Callable[..., int], monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    assert call("--scene", "home", "--plot") == 2
    assert "matplotlib is not installed" in refused(capsys)
    assert list(tmp_path.iterdir()) == []


def test_a_scene_loads_of_scipy_what_it_needs() -> None:
    """Signals and optimization are of other commands, and take 50 MB: a tenth of what the longest scene takes."""
    code = "import sys, haptics.scenes.resistance; print({'scipy.signal', 'scipy.optimize'} & set(sys.modules))"
    reported = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert reported.stdout == "set()\n"


def test_labels_keep_apart_and_inside() -> None:
    from matplotlib.figure import Figure

    from haptics.scenes.pictures import label_ends

    rng = np.random.default_rng(2)
    for ends in ([0.5] * 6, [1.0] * 6, [2.0, -1.0, 0.9, float("nan")], rng.uniform(0.0, 1.0, 7).tolist(), []):
        ax = Figure().subplots()
        ax.set_ylim(0.0, 1.0)
        label_ends(ax, [(end, f"{k}", "k") for k, end in enumerate(ends)], gap=0.1)
        places = sorted((float(text.get_position()[1]), ends[int(text.get_text())]) for text in ax.texts)
        assert len(places) == sum(np.isfinite(ends)) if ends else not places
        heights = [place for place, _ in places]
        assert all(b - a > 0.0999 for a, b in pairwise(heights))
        assert all(0.0 <= height <= 0.95 + 1e-12 for height in heights)
        assert [end for _, end in places] == sorted(end for _, end in places)  # in the order of the lines
