"""What `synthesize` leaves on disk: no other design replaced, the best so far there before any proof."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import pytest

from delta_cad.common.console import INTERRUPTED
from delta_cad.design import load_design
from optimizer.commands import cli
from optimizer.synthesis import three_step
from optimizer.synthesis.three_step import Run
from tests.committed import BEST
from tests.optimizer.messages import holds
from tests.terminal import interrupted

JOYSTICK = Path(__file__).parents[2] / "references" / "joystick.toml"
SQP = ["--method", "sqp", "--steps", "1"]


def call(*arguments: str | Path) -> int:
    return cli.main([str(argument) for argument in ("synthesize", *arguments)])


def provenance(path: Path) -> dict[str, Any]:
    return json.loads(path.read_text())["provenance"]


def stopped(*_: object, **__: object) -> None:
    raise KeyboardInterrupt


def test_the_file_has_the_requirements_name_and_is_replaced_by_a_run_of_the_same(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    for seed in ("0", "3"):
        assert call(JOYSTICK, *SQP, "--no-proof", "--seed", seed) == 0
        assert [f.name for f in tmp_path.iterdir()] == ["dashboard-joystick.json"]
        assert provenance(tmp_path / "dashboard-joystick.json")["seed"] == int(seed)
    assert capsys.readouterr().err == ""


def changed(**fields: object) -> str:
    data = json.loads(BEST.read_text()) | {"name": "dashboard-joystick"}  # as the requirements here have it
    return json.dumps(data | fields)


OTHERS = {
    "another name": (changed(name="other\x1b[2J"), 'name = "other\\u001b[2J": must be "dashboard-joystick"'),
    "other requirements": (
        changed(provenance=json.loads(BEST.read_text())["provenance"] | {"requirements_sha256": "0" * 64}),
        f'provenance.requirements_sha256 = "{"0" * 40}',
    ),
    "no provenance": (changed(provenance=None), "provenance.requirements_sha256 = null"),
    "text as provenance": (changed(provenance="mine"), "provenance.requirements_sha256 = null"),
    "a list": ("[]", "name = null"),
    "no JSON": ("my notes", "b.json: is not JSON"),
}


@pytest.mark.parametrize(("text", "words"), OTHERS.values(), ids=OTHERS)
def test_another_design_is_refused_before_any_work_and_replaced_by_force(
    text: str, words: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "b.json"
    out.write_text(text)
    with monkeypatch.context() as patch:
        patch.setattr(Run, "results", lambda _: pytest.fail("worked"))
        assert call(JOYSTICK, *SQP, "--out", out) == 2
    err = capsys.readouterr().err
    assert words in err
    assert "--force" in err
    assert err.count("\n") == 1
    assert (out.read_text(), list(tmp_path.iterdir())) == (text, [out])
    with monkeypatch.context() as patch:
        patch.setattr(three_step.proving, "with_bound", stopped)
        assert call(JOYSTICK, *SQP, "--out", out, "--force") == INTERRUPTED
    assert out.read_text() == text  # an unfinished design takes the place of none
    assert holds(capsys.readouterr().err, "b.json is left as it was")
    assert call(JOYSTICK, *SQP, "--out", out, "--force", "--resume") == 0
    assert load_design(out).provenance == provenance(out)
    assert "unfinished" not in provenance(out)


def test_the_design_is_on_disk_before_its_proof_and_is_taken_up_without_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    out, twosteps = tmp_path / "b.json", ["--method", "sqp", "--steps", "1,2", "--out", tmp_path / "b.json"]
    solve, seen = three_step.proving.with_bound, []

    def second(result: Any, *rest: Any) -> Any:
        seen.append(provenance(out))
        if result.problem.step == 2:
            raise KeyboardInterrupt
        return solve(result, *rest)

    with monkeypatch.context() as patch:
        patch.setattr(three_step.proving, "with_bound", second)
        assert call(JOYSTICK, *twosteps) == INTERRUPTED
    assert holds(capsys.readouterr().err, f"best so far in {out}; run again with --resume")
    assert [[step["step"] for step in at["steps"]] for at in seen] == [[1], [1, 2]]
    assert [[step["proven_bound"] is None for step in at["steps"]] for at in seen] == [[True], [False, True]]
    assert [at["unfinished"] for at in seen] == [f"the proof of step {n} is still to come" for n in (1, 2)]
    assert provenance(out) == seen[-1]
    with monkeypatch.context() as patch:
        patch.setattr(three_step.sqp, "search", lambda *_: pytest.fail("searched again"))
        assert call(JOYSTICK, *twosteps, "--resume", "--no-proof") == 0
    last = provenance(out)
    assert "unfinished" not in last
    assert last["command"].endswith("--steps 1,2 --no-proof")
    assert [step["proven_bound"] for step in last["steps"]] == [None, None]
    assert list(tmp_path.iterdir()) == [out]


def test_a_finished_design_is_not_replaced_by_an_unfinished_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "b.json"
    assert call(JOYSTICK, *SQP, "--no-proof", "--out", out) == 0
    before = out.read_bytes()
    monkeypatch.setattr(three_step.proving, "with_bound", stopped)
    assert call(JOYSTICK, *SQP, "--out", out) == INTERRUPTED
    assert holds(capsys.readouterr().err, "b.json is left as it was; run again with --resume")
    assert out.read_bytes() == before


def test_a_proof_ends_with_its_time_and_says_what_it_reached(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    two = ["--method", "sqp", "--steps", "1,2", "--json", "--out", tmp_path / "b.json"]
    assert call(JOYSTICK, *two, "--proof-minutes", "1e-9") == 0
    short = json.loads(capsys.readouterr().out)["steps"]
    assert call(JOYSTICK, *two) == 0
    whole = json.loads(capsys.readouterr().out)["steps"]
    for cut, full in zip(short, whole, strict=True):
        assert cut["objective"] == full["objective"]
        assert cut["boxes"] == 0
        assert "the time was over: raise --proof-minutes" in cut["advice"]
        assert "--boxes" not in cut["advice"]
        assert cut["proven_bound"] is None or cut["proven_bound"] >= full["proven_bound"]
    for wrong in ("0", "-1", "nan", "inf", "a"):
        with pytest.raises(SystemExit) as ended:
            call(JOYSTICK, "--proof-minutes", wrong)
        assert ended.value.code == 2
        assert holds(capsys.readouterr().err, ": must be a number > 0 min")


BARE = """
[requirements]
envelope_width_mm = 270.0
envelope_depth_mm = 220.0
force_N = 3.0
joint_torque_N_m = 0.8
[bounds_mm]
upper_arm_length = [40, 130]
forearm_length = [40, 230]
base_radius = [20, 80]
platform_radius = [20, 45]
bottom_height = [40, 200]
half_side = [0, 100]
"""


@pytest.mark.slow
@pytest.mark.parametrize("method", ["ga+sqp", "proven"])
def test_a_proof_that_takes_minutes_hears_ctrl_c(method: str, tmp_path: Path) -> None:
    """Next to nothing is asked, so that the largest cube touches a fold, where a proof takes millions of boxes."""
    (tmp_path / "bare.toml").write_text('name = "bare"' + BARE)
    out = tmp_path / "bare.json"
    command = [sys.executable, "-m", "optimizer", "synthesize", str(tmp_path / "bare.toml"), "--method", method]
    sizes = ["--population", "20", "--generations", "3", "--out", str(out)]

    def proving() -> bool:
        return out.exists() and len(provenance(out)["steps"]) == 2

    ended = interrupted([*command, *sizes], 2.0, proving)
    assert ended.code == INTERRUPTED
    assert ended.said == f"interrupted; best so far in {out}; run again with --resume to go on\n"
    assert provenance(out)["unfinished"]
    assert load_design(out).cube.half_side_mm > 80.0
    assert {f.name for f in tmp_path.iterdir()} == {"bare.toml", "bare.json", "bare.json.checkpoint.jsonl"}
