"""`python -m optimizer synthesize`: what it writes, prints and refuses; interrupted and killed runs."""

from __future__ import annotations

import json
import math
import os
import re
import signal
import subprocess
import sys
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest

from delta_cad.common import console
from delta_cad.design import DesignError, load_design
from optimizer.commands import cli, synthesize
from optimizer.problem.requirements import load_requirements, requirements_hash
from optimizer.search.genetic import Scores
from optimizer.synthesis.checkpoint import Checkpoint, CheckpointError, remembered
from optimizer.synthesis.output import design_of, write_design
from optimizer.synthesis.three_step import METHODS, Run
from tests.optimizer.messages import refuses
from tests.terminal import said, shown_on_a_terminal

JOYSTICK = Path(__file__).parents[2] / "references" / "joystick.toml"
SMALL = ["--population", "12", "--generations", "4"]


@pytest.fixture(scope="module")
def done(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, Any]]:
    """The former task solved once, as a user would, with a small GA."""
    out = tmp_path_factory.mktemp("synthesis") / "new" / "best.json"
    command = [sys.executable, "-m", "optimizer", "synthesize", str(JOYSTICK), "--seed", "1", "--json", *SMALL]
    run = subprocess.run([*command, "--out", str(out)], capture_output=True, text=True)
    assert (run.returncode, said(run.stderr)) == (0, "")
    return out, json.loads(run.stdout)


def call(*arguments: str | Path) -> int:
    return cli.main([str(argument) for argument in arguments])


@pytest.mark.slow
def test_design_file_is_the_last_step_and_passes_its_own_limits(done: tuple[Path, dict[str, Any]]) -> None:
    out, reported = done
    design = load_design(out)
    variables = reported["steps"][2]["variables"]
    written = design.mechanism.model_dump() | design.cube.model_dump()
    for name, found in variables.items():
        assert written[name] == round(written[name], 3)  # whole micrometres, beside what was found
        assert abs(written[name] - found) < 2e-3
    assert written["half_side_mm"] <= variables["half_side_mm"]
    assert design.mechanism.parallelogram_width_mm == 54.0
    assert design.requirements.kappa_max == 2.27
    assert design.requirements.lean_max_deg == 28.0
    assert design.provenance["seed"] == 1
    assert design.provenance["method"] == "ga+sqp"
    assert design.provenance["requirements_sha256"] == requirements_hash(load_requirements(JOYSTICK))
    assert [f.name for f in out.parent.iterdir()] == ["best.json"]


def test_joystick_has_a_cube_of_84_mm_at_the_published_conditioning(done: tuple[Path, dict[str, Any]]) -> None:
    _, reported = done
    last = reported["steps"][2]
    assert 2.0 * last["variables"]["half_side_mm"] >= 84.0
    assert last["max_kappa"] <= 2.27
    assert last["max_torque_N_m"] <= 0.8 - 0.11


def test_json_has_the_contracts_names(done: tuple[Path, dict[str, Any]]) -> None:
    _, reported = done
    assert [step["step"] for step in reported["steps"]] == [1, 2, 3]
    for step in reported["steps"]:
        assert {"method", "objective", "variables", "max_torque_N_m", "max_kappa", "proven_bound", "gap"} <= set(step)
    assert reported["steps"][0]["objective"] == reported["steps"][0]["variables"]["half_side_mm"]


def test_text_says_step_lengths_and_ending(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert call("synthesize", JOYSTICK, "--method", "sqp", "--steps", "1", "--out", tmp_path / "b.json") == 0
    out, err = capsys.readouterr()
    assert out.startswith("step 1 sqp: half side 68.301 mm at L_A 82, L_B 180, R 40, r 40, H 98, L 68.3 mm; ")
    assert "converged: the best there is within the bounds, but for the gap" in out
    assert err == ""


def requirements(tmp_path: Path, **replaced: str) -> Path:
    text = JOYSTICK.read_text()
    for name, value in replaced.items():
        text, count = re.subn(rf"(?m)^{name} = .*$", f"{name} = {value}", text)
        assert count == 1
    path = tmp_path / "task.toml"
    path.write_text(text)
    return path


def test_contradiction_exits_1_and_names_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    task = requirements(tmp_path, half_side="[75, 100]")
    assert call("synthesize", task, "--method", "sqp", "--out", tmp_path / "b.json") == 1
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("task.toml: step 1: reach of the whole cube and bounds_mm.half_side >= 75 mm cannot be met")
    assert err.count("\n") == 1
    assert [f.name for f in tmp_path.iterdir()] == ["task.toml"]


def test_ga_that_ends_outside_its_constraints_exits_1(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    task = requirements(tmp_path, kappa_max="1.9", half_side="[30, 100]")
    code = call(
        "synthesize", task, "--method", "ga", "--steps", "2", "--out", tmp_path / "b.json", "--population", "4",
        "--generations", "1",
    )  # fmt: skip
    assert code == 1
    out, err = capsys.readouterr()
    assert "step 2 ga: half side" in out
    assert re.match(r"task\.toml: b\.json was not written: step 2 misses .* by .*; the GA met no feasible design", err)


def test_lengths_that_the_design_file_would_refuse_are_no_result(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    task = requirements(tmp_path, parallelogram_width_mm="400", clearance_min_mm="0", joint_diameter_mm="0.5")
    assert call("synthesize", task, "--method", "sqp", "--steps", "1", "--out", tmp_path / "c.json") == 1
    err = capsys.readouterr().err
    assert err.startswith("task.toml: step 1: balls of 8 mm that do not meet at the platform (parallelogram_width_mm")
    assert err.count("\n") == 1
    assert not (tmp_path / "c.json").exists()


REFUSED = [
    (["synthesize", "none.toml"], "none.toml: cannot be read: No such file or directory"),
    (["synthesize"], "python -m optimizer synthesize: the following arguments are required: REQ.toml"),
    (["synthesize", "x", "--method", "magic"], "python -m optimizer synthesize: argument --method: invalid choice"),
    (["synthesize", "x", "--seed", "-1"], "python -m optimizer synthesize: argument --seed: -1: must be a whole"),
    (["synthesize", "x", "--seed", "a"], "python -m optimizer synthesize: argument --seed: a: must be a whole"),
    (["synthesize", "x", "--steps", "3,1"], "python -m optimizer synthesize: argument --steps: 3,1: must be a list"),
    (["synthesize", "x", "--steps", "4"], "python -m optimizer synthesize: argument --steps: 4: must be a list"),
    ([], "python -m optimizer: the following arguments are required: COMMAND"),
]


@pytest.mark.parametrize(("arguments", "words"), REFUSED, ids=[" ".join(a) or "nothing" for a, _ in REFUSED])
def test_wrong_usage_exits_2_in_one_line(arguments: list[str], words: str, capsys: pytest.CaptureFixture[str]) -> None:
    try:
        code = cli.main(arguments)
    except SystemExit as error:
        code = error.code
    assert code == 2
    err = capsys.readouterr().err
    assert err.startswith(words)
    assert err.count("\n") == 1


@pytest.mark.parametrize(
    ("more", "words"),
    [
        (["--steps", "3"], "joystick.toml: step 3 needs step_3.half_side_mm or what step 2 reached"),
        *(
            (["--population", n], f"joystick.toml: 4 free variables, {n} individuals, 100 generations: at least 1, 4")
            for n in ("0", "2", "3")
        ),
    ],
)
def test_runs_that_make_no_sense_exit_2(
    tmp_path: Path, more: list[str], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert call("synthesize", JOYSTICK, "--out", tmp_path / "b.json", *more) == 2
    assert capsys.readouterr().err.startswith(words)
    assert list(tmp_path.iterdir()) == []


def test_a_place_that_cannot_be_written_exits_2(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "file").write_text("")
    assert call("synthesize", JOYSTICK, "--out", tmp_path / "file" / "b.json") == 2
    assert capsys.readouterr().err.count("\n") == 1
    (tmp_path / "b.json").mkdir()
    code = call("synthesize", JOYSTICK, "--method", "sqp", "--steps", "1", "--out", tmp_path / "b.json")
    assert code == 2
    assert "b.json: Is a directory" in capsys.readouterr().err


def test_ctrl_c_leaves_the_best_so_far_and_resume_ends_as_an_unbroken_run(
    tmp_path: Path,
    done: tuple[Path, dict[str, Any]],
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    whole, reported = done
    out = tmp_path / "best.json"
    shown = list[int]()

    def show(_line: object, at: str) -> None:
        shown.append(at.number if isinstance(at, console.Step) else 0)
        if shown.count(2) == 2:
            os.kill(os.getpid(), signal.SIGINT)

    command = ["synthesize", JOYSTICK, "--seed", "1", "--json", *SMALL, "--out", out]
    with monkeypatch.context() as patch:
        patch.setattr(console.ProgressLine, "show", show)
        patch.setattr(console, "GRACE_S", 60.0)  # the run is to end by itself
        assert call(*command) == console.INTERRUPTED
    text, err = capsys.readouterr()
    assert re.fullmatch(r"interrupted; best so far in .*best\.json; run again with --resume to go on\n", err)
    assert [step["status"] for step in json.loads(text)["steps"]] == ["converged", "interrupted"]
    assert load_design(out).provenance["steps"][-1]["status"] == "interrupted"  # type: ignore[index, call-overload]
    assert call(*command, "--resume") == 0
    resumed = json.loads(capsys.readouterr().out)
    assert resumed == reported
    assert out.read_bytes() == whole.read_bytes()
    assert [f.name for f in tmp_path.iterdir()] == ["best.json"]


@pytest.mark.slow
def test_a_killed_run_is_taken_up_to_the_same_file(tmp_path: Path, done: tuple[Path, dict[str, Any]]) -> None:
    """SIGKILL as soon as the checkpoint holds three generations; its last line is then torn by hand as well."""
    whole, _ = done
    out = tmp_path / "best.json"
    command = [sys.executable, "-m", "optimizer", "synthesize", str(JOYSTICK), "--seed", "1", *SMALL, "--out", str(out)]
    lines = tmp_path / "best.json.checkpoint.jsonl"
    run = subprocess.Popen(command, stdout=subprocess.DEVNULL)
    while run.poll() is None and (not lines.exists() or lines.read_bytes().count(b"\n") < 4):
        with suppress(subprocess.TimeoutExpired):  # asking without a pause takes half of a machine of two cores
            run.wait(0.01)
    run.kill()
    assert run.wait() == -signal.SIGKILL
    lines.write_bytes(lines.read_bytes()[:-20])
    assert subprocess.run([*command, "--resume"], capture_output=True).returncode == 0
    assert out.read_bytes() == whole.read_bytes()


def test_an_interrupt_before_the_search_is_one_line(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def interrupt(_: object) -> int:
        raise KeyboardInterrupt

    monkeypatch.setattr(synthesize, "run", interrupt)
    assert call("synthesize", JOYSTICK) == console.INTERRUPTED
    assert capsys.readouterr().err == "interrupted; nothing was written\n"


@pytest.mark.slow
def test_a_reader_that_goes_away_is_no_error(tmp_path: Path) -> None:
    command = f"'{sys.executable}' -m optimizer synthesize '{JOYSTICK}' --method sqp --steps 1 --out b.json | true"
    run = subprocess.run(["bash", "-c", f"set -o pipefail; {command}"], cwd=tmp_path, capture_output=True, text=True)
    assert (run.returncode, said(run.stderr)) == (0, "")


@pytest.mark.slow
def test_progress_appears_on_a_terminal_only(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "optimizer", "synthesize", str(JOYSTICK), "--method", "sqp", "--steps", "1"]
    code, shown = shown_on_a_terminal([*command, "--out", str(tmp_path / "b.json")])
    assert code == 0
    assert b"step 1 of 3, " in shown  # which steps are seen depends on how long each takes
    assert b"best so far half side 68.301" in shown
    assert shown.endswith(b"\r\x1b[K")


KEY = {"seed": 1, "steps": (1, 2)}
SCORES = ([0.1, 1.0 / 3.0], [[1e-300, -2.0], [math.pi, 0.0]])


def never() -> Any:
    raise AssertionError


def test_checkpoint_gives_back_every_bit(tmp_path: Path) -> None:
    path = tmp_path / "c.jsonl"
    store = Checkpoint(path, KEY, resume=True)
    assert remembered(store, "1/ga", lambda: SCORES, Scores, b"x") is SCORES
    assert remembered(store, "1/sqp", lambda: None) is None  # stopped: not kept
    store.close()
    again = Checkpoint(path, KEY, resume=True)
    assert remembered(again, "1/ga", never, Scores, b"x") == SCORES
    assert remembered(again, "1/ga", lambda: None, Scores, b"y") is None
    assert remembered(again, "1/sqp", lambda: 3) == 3
    again.close()
    anew = Checkpoint(path, KEY, resume=False)
    assert remembered(anew, "1/ga", lambda: None, Scores, b"x") is None
    anew.remove()
    assert not path.exists()


def test_checkpoint_of_another_run_or_no_checkpoint_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "b.json.checkpoint.jsonl"
    Checkpoint(path, KEY, resume=False).close()
    with pytest.raises(CheckpointError, match="another run"):
        Checkpoint(path, KEY | {"seed": 2}, resume=True)
    assert call("synthesize", JOYSTICK, "--out", tmp_path / "b.json", "--resume") == 2
    assert capsys.readouterr().err.startswith("b.json.checkpoint.jsonl: is of another run: requirements, method, seed")


def test_design_of_a_result_carries_the_limits_and_refuses_what_the_design_file_refuses(tmp_path: Path) -> None:
    task = load_requirements(requirements(tmp_path, shoulder_deg="[-60, 85]"))
    results = Run(task, "sqp", steps=(1,)).results()
    design = design_of(task, results, "sqp", 0, "b.json")
    assert (design.requirements.shoulder_min_deg, design.requirements.shoulder_max_deg) == (-60.0, 85.0)
    write_design(design, tmp_path / "b.json")
    assert load_design(tmp_path / "b.json") == design
    wide = load_requirements(requirements(tmp_path, parallelogram_width_mm="400"))
    with refuses(DesignError, "b.json", "mechanism.parallelogram_width_mm", "400.0"):
        design_of(wide, results, "sqp", 0, "b.json")


def test_methods_on_the_command_line_are_those_of_the_library() -> None:
    assert synthesize.METHODS == METHODS


def test_help_of_every_command_loads_nothing_heavy() -> None:
    """A command is named beside the first library that its help loads."""
    heavy = ("numpy", "scipy", "pymoo", "numba", "pydantic", "cadquery", "OCP", "matplotlib", "dask", "distributed")
    code = (
        "import sys\nfrom optimizer.commands.cli import main\nfor name in sys.argv[1:]:\n"
        "    try: main([*name.split(), '--help'])\n    except SystemExit: pass\n"
        f"    loaded = [m for m in {heavy} if m in sys.modules]\n    if loaded: print(name, loaded, file=sys.stderr)"
    )
    names = ["", *(command.NAME for command in cli.COMMANDS)]
    run = subprocess.run([sys.executable, "-c", code, *names], capture_output=True, text=True, check=True)
    assert run.stderr == ""
    assert run.stdout.count("exit codes: 0 done") == len(names)


CONTRACT = """
name = "dashboard-joystick"
[requirements]
envelope_width_mm = 270.0
envelope_depth_mm = 220.0
force_N = 3.0
joint_torque_N_m = 0.8
[bounds_mm]
upper_arm_length = [82, 82]
forearm_length = [40, 130]
base_radius = [40, 40]
platform_radius = [20, 45]
bottom_height = [40, 100]
half_side = [0, 100]
[limits]
outline_radius_max_mm = 122
kappa_max = 3.0
lean_max_deg = 28
shoulder_deg = [-45, 80]
[step_3]
half_side_mm = 35.0
"""


def test_example_of_the_contract_ends_in_a_design(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "req.toml").write_text(CONTRACT)
    out = tmp_path / "best.json"
    assert call("synthesize", tmp_path / "req.toml", "--method", "sqp", "--json", "--out", out) == 0
    steps = json.loads(capsys.readouterr().out)["steps"]
    assert steps[0]["objective"] == pytest.approx(64.2, rel=3e-3)  # table 4
    assert steps[2]["variables"]["half_side_mm"] == load_design(out).cube.half_side_mm == 35.0
    assert steps[2]["max_kappa"] < 1.767  # what r >= 30 allows


TINY = [
    ("kappa_max = 2.27", "kappa_max = 1.0", "ga+sqp", 2),
    ("shoulder_deg = [-65.5, 70]", "shoulder_deg = [10, 10.001]", "sqp", 2),
    ("half_side = [0, 100]", "half_side = [1e-9, 1e-9]", "sqp", 1),
]


@pytest.mark.slow
@pytest.mark.parametrize(("old", "new", "method", "step"), TINY, ids=[one[1] for one in TINY])
def test_a_cube_below_a_micrometre_is_one_line(
    old: str, new: str, method: str, step: int, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = JOYSTICK.read_text()
    assert old in text
    (tmp_path / "t.toml").write_text(text.replace(old, new))
    out = tmp_path / "b.json"
    assert call("synthesize", tmp_path / "t.toml", "--method", method, "--out", out) == 1
    err = capsys.readouterr().err
    assert err.startswith(f"t.toml: b.json was not written: the half side of step {step} is ")
    assert "less than a micrometre" in err
    assert err.count("\n") == 1
    assert list(tmp_path.iterdir()) == [tmp_path / "t.toml"]


def test_two_runs_never_share_a_checkpoint(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "b.json.checkpoint.jsonl"
    first = Checkpoint(path, KEY, resume=False)
    remembered(first, "1/ga", lambda: SCORES, Scores)
    before = path.read_bytes()
    for more in ([], ["--resume"]):
        assert call("synthesize", JOYSTICK, "--out", tmp_path / "b.json", *more) == 2
        err = capsys.readouterr().err
        assert err.startswith("b.json.checkpoint.jsonl: another run is writing it")
        assert err.count("\n") == 1
        assert path.read_bytes() == before
    first.close()
    again = Checkpoint(path, KEY, resume=True)
    assert remembered(again, "1/ga", never, Scores) == SCORES
    first.remove()  # was closed: what is there now is another's
    assert path.exists()
    again.remove()
