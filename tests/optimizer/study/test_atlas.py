"""The atlas on real clusters of two processes: the serial rows, whatever happens to workers, command and checkpoint."""

from __future__ import annotations

import csv
import io
import json
import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import TYPE_CHECKING, Any

import distributed
import numpy as np
import pytest

from delta_cad.common.console import INTERRUPTED
from delta_cad.common.refusal import not_installed
from optimizer.commands import cli
from optimizer.problem.requirements import load_requirements
from optimizer.study import cluster
from optimizer.study.atlas import atlas_files, flat, mapped, page
from optimizer.study.cluster import ClusterError, Failure, collect, given_cluster, key_of, local_cluster
from optimizer.study.grid import AtlasRow, Grid, grid_from_dict, load_grid
from optimizer.study.pictures import atlas_map, cells, png
from optimizer.synthesis.checkpoint import Checkpoint
from tests.optimizer.messages import holds
from tests.terminal import said

if TYPE_CHECKING:
    from distributed import Client

JOYSTICK = Path(__file__).parents[2] / "references" / "joystick.toml"
TORQUE, OUTLINE = "requirements.joint_torque_N_m", "limits.outline_radius_max_mm"
GRID = f"""
name = "tiny"
base = "joystick.toml"
method = "sqp"
steps = [1, 2]
[axes]
"{OUTLINE}" = [118, 122]    # R + L_A = 122 is fixed: the first cannot be met
"{TORQUE}" = {{linspace = [0.25, 0.8, 3]}}
"""


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("atlas")
    shutil.copy(JOYSTICK, folder)
    (folder / "tiny.toml").write_text(GRID)
    return folder / "tiny.toml"


@pytest.fixture(scope="module")
def grid(file: Path) -> Grid:
    return load_grid(file)


def bare(rows: list[AtlasRow]) -> list[AtlasRow]:
    """Rows without what may differ, through JSON as the file has them."""
    return [{k: v for k, v in json.loads(json.dumps(row)).items() if k != "seconds"} for row in rows]


@pytest.fixture(scope="module")
def serial(file: Path) -> list[AtlasRow]:
    """One after the other in one process. One BLAS thread, as the workers have: with two the last digits differ."""
    code = (
        "import json, sys\nfrom dataclasses import asdict\nfrom optimizer.study.cluster import solve\n"
        "from optimizer.study.grid import load_grid\n"
        "print(json.dumps([solve(asdict(one)) for one in load_grid(sys.argv[1]).sets]))"
    )
    pinned = os.environ | dict.fromkeys(cluster.THREADS, "1")
    run = subprocess.run([sys.executable, "-c", code, str(file)], env=pinned, stdout=subprocess.PIPE, check=True)
    return json.loads(run.stdout)


@pytest.fixture(scope="module")
def client() -> Iterator[Client]:
    with local_cluster(2) as found:
        yield found


def call(*arguments: str | Path) -> int:
    return cli.main([str(argument) for argument in arguments])


def wording(out: Path) -> list[AtlasRow]:
    return json.loads((out / "atlas" / "tiny" / "atlas.json").read_text())["rows"]


@pytest.mark.slow
def test_infeasible_sets_are_rows_with_the_contradiction_named(serial: list[AtlasRow]) -> None:
    assert [row["feasible"] for row in serial] == [False] * 3 + [True] * 3
    for row in serial[:3]:
        assert row["conflict"] == ["outline"]
        assert row["conflict_step"] == 1
        assert row["message"].startswith("step 1: R + L_A <= 118 mm (limits.outline_radius_max_mm) cannot be met")
        assert row["steps"] == []
    reserve = load_requirements(JOYSTICK).limits.gravity_torque_N_m
    for row in serial[3:]:
        assert row["conflict"] == []
        assert [step["step"] for step in row["steps"]] == [1, 2]
        assert row["steps"][1]["max_torque_N_m"] <= row["inputs"][TORQUE] - reserve + 1e-9
        assert row["seconds"] > 0.0
    half = [row["steps"][1]["objective"] for row in serial[3:6]]
    assert half[0] < half[1]  # more torque, a larger cube, until something else holds it


@pytest.mark.slow
def test_two_processes_give_the_serial_rows_in_any_order(client: Client, grid: Grid, serial: list[AtlasRow]) -> None:
    rows: list[AtlasRow] = []
    assert collect(client, reversed(grid.sets), rows.append) == []
    assert bare(sorted(rows, key=lambda row: row["index"])) == bare(serial)
    there = client.run(lambda: (os.getpid(), *(os.environ.get(name) for name in cluster.THREADS)))
    assert len({pid for pid, *_ in there.values()} | {os.getpid()}) == 3
    assert {pinned for _, *pinned in map(list, there.values()) for pinned in pinned} == {"1"}
    assert all(address.startswith("tcp://127.0.0.1:") for address in there)


@pytest.mark.slow
def test_command_on_a_given_scheduler_writes_the_serial_rows(
    client: Client, file: Path, tmp_path: Path, serial: list[AtlasRow], capsys: pytest.CaptureFixture[str]
) -> None:
    address = client.scheduler_info()["address"]
    assert call("atlas", file, "--scheduler", address, "--out", tmp_path, "--json") == 0
    out, err = capsys.readouterr()
    assert err == ""
    assert json.loads(out)["rows"] == wording(tmp_path)
    assert bare(wording(tmp_path)) == bare(serial)
    assert sorted(path.name for path in (tmp_path / "atlas" / "tiny").iterdir()) == [
        "atlas.csv", "atlas.json", "atlas.md", "atlas.png",
    ]  # fmt: skip


@pytest.mark.slow
def test_a_worker_killed_in_between_costs_no_row(client: Client, grid: Grid, serial: list[AtlasRow]) -> None:
    rows: list[AtlasRow] = []
    first = sorted(client.run(os.getpid).values())[0]

    def take(row: AtlasRow) -> None:
        if not rows:
            os.kill(first, signal.SIGKILL)
        rows.append(row)

    assert collect(client, grid.sets, take) == []
    assert first not in client.run(os.getpid).values()
    assert bare(sorted(rows, key=lambda row: row["index"])) == bare(serial)


def test_a_set_that_raises_is_a_failure_with_its_reason_and_the_others_are_rows(client: Client, grid: Grid) -> None:
    rows: list[AtlasRow] = []
    broken = replace(grid.sets[3], method="magic")
    failed = collect(client, [broken, grid.sets[4]], rows.append)
    assert failed == [Failure(3, "ProblemError: method is 'magic'; it must be one of ga, sqp, ga+sqp, proven")]
    assert [row["index"] for row in rows] == [4]


def test_stop_gives_up_what_is_not_done(client: Client, grid: Grid) -> None:
    rows: list[AtlasRow] = []
    assert collect(client, grid.sets, rows.append, lambda: len(rows) == 2) == []
    assert len(rows) == 2


def test_a_lost_scheduler_and_a_worker_that_dies_again_and_again_are_reported() -> None:
    lost: Any = SimpleNamespace(status="cancelled")
    assert cluster._reason(lost) == "the scheduler was lost"
    worker: Any = SimpleNamespace(address="tcp://127.0.0.1:1")
    killed: Any = SimpleNamespace(status="error", exception=lambda: distributed.KilledWorker("t", worker, 4))
    assert cluster._reason(killed) == "its workers died again and again"


@pytest.mark.slow
def test_ctrl_c_keeps_what_is_done_and_resume_goes_on(
    client: Client, file: Path, tmp_path: Path, serial: list[AtlasRow], capsys: pytest.CaptureFixture[str]
) -> None:
    """SIGINT to the command and all its processes, as a terminal sends it; then a line torn by hand."""
    command = [sys.executable, "-m", "optimizer", "atlas", str(file), "--workers", "1", "--out", str(tmp_path)]
    kept = tmp_path / "atlas" / "tiny" / "rows.jsonl"
    run = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True)
    while run.poll() is None and (not kept.exists() or kept.read_bytes().count(b"\n") < 3):
        with suppress(subprocess.TimeoutExpired):
            run.wait(0.05)
    os.killpg(run.pid, signal.SIGINT)
    out, err = run.communicate()
    assert (run.returncode, out) == (INTERRUPTED, "")
    lines = kept.read_text().splitlines()
    assert said(err) == f"interrupted; {len(lines) - 1} of 6 sets are kept; run again with --resume to go on\n"
    assert [path.name for path in kept.parent.iterdir()] == ["rows.jsonl"]
    kept.write_bytes(kept.read_bytes()[:-20])
    address = client.scheduler_info()["address"]
    assert call("atlas", file, "--scheduler", address, "--out", tmp_path, "--resume") == 0
    assert capsys.readouterr() == (f"6 sets, 3 met, 3 not; {kept.parent / 'atlas.md'}\n", "")
    assert bare(wording(tmp_path)) == bare(serial)
    seconds = {row["index"]: row["seconds"] for row in wording(tmp_path)}
    for line in lines[1:-1]:  # taken over, not solved again
        row = json.loads(line)["record"]["result"]
        assert seconds[row["index"]] == row["seconds"]


def test_a_finished_checkpoint_needs_no_cluster(
    file: Path, grid: Grid, serial: list[AtlasRow], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    rows = Checkpoint(tmp_path / "atlas" / "tiny" / "rows.jsonl", key_of(grid), resume=False)
    for row in reversed(serial):
        rows.finish(f"set/{row['index']}", row)
    rows.close()
    monkeypatch.setattr(cluster, "local_cluster", None)
    assert call("atlas", file, "--out", tmp_path, "--resume") == 0
    assert bare(wording(tmp_path)) == bare(serial)


def test_sets_that_fail_exit_1_and_are_kept_for_resume(
    file: Path, grid: Grid, serial: list[AtlasRow], tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str], client: Client,
) -> None:  # fmt: skip
    def some(_client: object, _sets: object, take: Any, _stop: object) -> list[Failure]:
        take(serial[0])
        return [Failure(5, "OSError: disk full"), Failure(6, "the scheduler was lost")]

    monkeypatch.setattr(cluster, "collect", some)
    address = client.scheduler_info()["address"]
    assert call("atlas", file, "--scheduler", address, "--out", tmp_path) == 1
    assert capsys.readouterr().err == (
        "2 sets came to no result, the first, set 5: OSError: disk full; "
        "1 of 6 sets are kept; run again with --resume to go on\n"
    )
    rows = Checkpoint(tmp_path / "atlas" / "tiny" / "rows.jsonl", key_of(grid), resume=True)
    assert [rows.finished(f"set/{k}") is not None for k in range(6)] == [True, *[False] * 5]
    rows.remove()


def test_a_second_ctrl_c_ends_at_once(
    file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, client: Client, capsys: pytest.CaptureFixture[str]
) -> None:
    def interrupt(*_: object) -> list[Failure]:
        raise KeyboardInterrupt

    monkeypatch.setattr(cluster, "collect", interrupt)
    address = client.scheduler_info()["address"]
    assert call("atlas", file, "--scheduler", address, "--out", tmp_path) == INTERRUPTED
    assert capsys.readouterr().err == "interrupted; 0 of 6 sets are kept; run again with --resume to go on\n"


def test_no_scheduler_and_a_scheduler_without_workers_exit_2(
    file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(cluster, "CONNECT_S", 1)
    for address in ("tcp://127.0.0.1:9", "nonsense://x"):
        assert call("atlas", file, "--scheduler", address, "--out", tmp_path) == 2
        err = capsys.readouterr().err
        assert err.startswith(f"no scheduler answers at {address}: ")
        assert err.count("\n") == 1
    empty = distributed.LocalCluster(n_workers=0, host="127.0.0.1", dashboard_address="127.0.0.1:0", silence_logs=50)
    without = pytest.raises(ClusterError, match="tcp://")
    with empty, without, given_cluster(empty.scheduler_address):
        raise AssertionError


def test_workers_that_cannot_be_started_exit_2(
    file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def refuse(**_: object) -> None:
        raise RuntimeError("Cluster failed\nto start")

    monkeypatch.setattr(distributed, "LocalCluster", refuse)
    before = signal.pthread_sigmask(signal.SIG_BLOCK, set())
    assert call("atlas", file, "--out", tmp_path) == 2
    assert capsys.readouterr().err == "no workers could be started: Cluster failed to start\n"
    assert signal.pthread_sigmask(signal.SIG_BLOCK, set()) == before


def test_usage_that_makes_no_sense_exits_2(file: Path, capsys: Any) -> None:
    assert call("atlas", file, "--workers", "2", "--scheduler", "tcp://x:1") == 2
    assert capsys.readouterr().err.startswith("--workers is of this machine; a cluster given with")


def test_a_bad_grid_or_place_exits_2(file: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    bad = file.with_name("bad.toml")
    bad.write_text(GRID.replace("0.25", "nan"))
    assert call("atlas", bad, "--out", tmp_path) == 2
    assert capsys.readouterr().err == (
        f"bad.toml: axes.{TORQUE}.linspace = [NaN, 0.8, 3]: "
        "must be [first, last, count], finite numbers and 2 to 1000 of them\n"
    )
    (tmp_path / "file").write_text("")
    assert call("atlas", file, "--out", tmp_path / "file") == 2
    assert capsys.readouterr().err.count("\n") == 1


@pytest.mark.parametrize("name", ["dask", "distributed", "matplotlib"])
def test_without_its_extra_one_line_names_it(name: str, file: Path) -> None:
    code = f"import sys; sys.modules[{name!r}] = None\nfrom optimizer.commands.cli import main\n"
    code += "sys.exit(main(sys.argv[1:]))"
    run = subprocess.run([sys.executable, "-c", code, "atlas", str(file)], capture_output=True, text=True)
    assert (run.returncode, said(run.stderr)) == (2, not_installed(name, "optimize,atlas") + "\n")


def test_checkpoint_of_another_atlas_or_no_checkpoint_is_refused(
    file: Path, grid: Grid, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "atlas" / "tiny" / "rows.jsonl"
    Checkpoint(path, key_of(grid) | {"sets": 5}, resume=False).close()
    assert call("atlas", file, "--out", tmp_path, "--resume") == 2
    assert capsys.readouterr().err.startswith("rows.jsonl: is of another run: ")


def test_csv_holds_every_row_and_number(grid: Grid, serial: list[AtlasRow]) -> None:
    lines = list(csv.DictReader(io.StringIO(str(atlas_files(grid, serial, Path(), bytes)[Path("atlas.csv")]))))
    assert len(lines) == 6
    assert lines[0]["conflict"] == "outline"
    assert lines[0]["step_2_half_side_mm"] == lines[0]["upper_arm_length_mm"] == ""
    last, line = serial[-1]["steps"][-1], lines[-1]
    assert float(line["step_2_half_side_mm"]) == last["objective"] == float(line["half_side_mm"])
    assert float(line["max_torque_N_m"]) == last["max_torque_N_m"]
    assert float(line[TORQUE]) == 0.8
    assert list(flat(serial)[-1]) == list(lines[0])  # the order of a full row


def test_page_and_map_say_what_is_met(grid: Grid, serial: list[AtlasRow]) -> None:
    assert mapped(grid)
    table = cells(grid, serial, "step_2_half_side_mm")
    assert np.isnan(table[0]).all()
    expected = [row["steps"][1]["objective"] for row in serial[3:6]]
    np.testing.assert_array_equal(table[1], expected)
    better, worse = json.loads(json.dumps(serial[3])), json.loads(json.dumps(serial[3]))
    better["steps"][1]["objective"] += 1.0
    worse["steps"][1]["objective"] -= 1.0
    assert cells(grid, [worse, better, serial[3]], "step_2_half_side_mm")[1, 0] == expected[0] + 1.0
    assert png(atlas_map(grid, serial)).startswith(b"\x89PNG")
    shown, empty = atlas_map(grid, serial), atlas_map(grid, serial[:3] * 2)
    numbers = [[text.get_text() for text in ax.texts] for ax in shown.axes[:2]]
    assert numbers[1] == [f"{value:.4g}" for value in expected]  # one for each set that is met
    assert [len(ax.texts) for ax in empty.axes] == [0]
    text = page(grid, serial, "map.png", "out/atlas/a")
    assert holds(text.splitlines()[2], "6 3")
    assert "outline (3)" in text
    assert "![tiny](map.png)" in text
    lines = [[cell.strip() for cell in line.strip("|").split("|")] for line in text.splitlines() if line[:1] == "|"]
    shown = [dict(zip(lines[0], line, strict=True)) for line in lines[2:]]
    for row, cell in zip(serial, shown, strict=True):
        assert int(cell["set"]) == row["index"]
        assert float(cell[TORQUE]) == pytest.approx(row["inputs"][TORQUE], rel=1e-4)
        assert (cell["feasible"], cell["conflict"]) == (("yes", "") if row["feasible"] else ("no", "outline"))
    assert float(shown[-1]["step_2_half_side_mm"]) == pytest.approx(expected[-1], rel=1e-4)


@pytest.mark.slow
def test_long_tables_are_cut_on_the_page_and_odd_grids_have_no_map(serial: list[AtlasRow], file: Path) -> None:
    base = {"base": "joystick.toml", "method": "sqp"}
    one = grid_from_dict(base | {"axes": {TORQUE: [0.4, 0.8]}}, "g", file.parent)
    pairs = grid_from_dict(
        base | {"axes": {TORQUE: [0.4, 0.8], "bounds_mm.half_side": [[0, 50], [0, 60]]}}, "g", file.parent
    )
    assert not mapped(one)
    assert not mapped(pairs)
    text = page(one, serial * 90, None, "out")
    assert "The first 500 of 540 rows" in text
    assert "![" not in text
    assert "[0, 60]" in page(pairs, serial, None, "out")
