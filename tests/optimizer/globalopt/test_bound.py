"""The method `proven` in the three steps, bounds beside the other methods, contradictions that are proved."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import pytest

from optimizer.commands import cli
from optimizer.globalopt import bound as proving
from optimizer.globalopt.bound import Effort
from optimizer.globalopt.optimum import STEEP_BOXES
from optimizer.problem.step import SIDE, ProblemError, step_problem
from optimizer.search.result import ADVICE, CAPPED, FULL_SIDE, STEEP, Result
from optimizer.synthesis import infeasible
from optimizer.synthesis.infeasible import InfeasibleError, explain_proved
from optimizer.synthesis.three_step import Progress, Run
from tests.optimizer.tasks import Memory, task

PAPER = task(platform_radius=(30, 45), half_side_mm=35)
OPTIMA = (64.2015, 62.0154, 1.76687)
"""Closed form; README of the paper (62.02); README of the paper (1.767), each with the digits we reach."""
SMALL: dict[str, Any] = {"population": 16, "generations": 4}
IMPOSSIBLE = task(limits={"kappa_max": 1.2}, half_side_mm=40)
ROOT = Path(__file__).parents[3]


def run(given: Any = PAPER, method: str = "proven", **other: Any) -> list[Result]:
    return Run(given, method, **(SMALL | other)).results()


def test_the_three_steps_are_proved() -> None:
    for result, optimum in zip(run(), OPTIMA, strict=True):
        assert result.status == "proved"
        assert result.feasible
        assert result.objective == pytest.approx(optimum, rel=1e-5)
        record = json.loads(json.dumps(result.record(), allow_nan=False))
        assert record["gap"] <= 1e-5
        assert record["gap"] == pytest.approx(abs(record["objective"] - record["proven_bound"]) / record["objective"])
        assert (record["proven_bound"] < record["objective"]) == (result.problem.step == 3)
        assert record["boxes"] > 0
        assert record["advice"] == ADVICE["proved"]


def test_what_is_proved_is_no_better_than_what_is_sampled() -> None:
    last = run(steps=(3,))[0]
    assert last.max_kappa <= last.objective <= last.max_kappa * (1.0 + 1e-6)


@pytest.mark.slow
def test_what_a_step_reaches_bounds_the_next() -> None:
    one, two, three = run(task(platform_radius=(30, 45), limits={"kappa_max": 2.5, "lean_max_deg": 28}))
    assert one.proof is not None
    assert two.problem.upper[SIDE] == one.proof.bound  # what is proved of step 1, not what it reached
    assert three.design_mm[SIDE] == two.objective
    assert three.objective <= 2.5


@pytest.mark.quick(1)
@pytest.mark.parametrize("method", ["ga", "sqp", "ga+sqp"])
def test_the_other_methods_get_a_bound_and_their_own_gap(method: str) -> None:
    proved = {result.problem.step: result for result in run(steps=(2, 3))}
    for result in run(method=method, steps=(2,), prove=True) + run(method=method, steps=(3,), prove=True):
        assert result.proof is not None
        assert result.proof.certified is None
        best, bound, gap = proved[result.problem.step].objective, result.proof.bound, result.proof.gap
        assert bound == pytest.approx(best, rel=1.1e-5)
        assert gap == pytest.approx(abs(result.objective - best) / result.objective, abs=2e-5)
        assert gap is not None
        assert gap > 1e-4 if method == "ga" else gap < 2e-5
        if result.problem.step == 2:
            assert result.objective <= bound
        else:
            assert result.objective >= bound


def test_without_being_required_they_get_none() -> None:
    record = run(method="sqp", steps=(1,))[0].record()
    assert record["proven_bound"] is record["gap"] is record["boxes"] is None


@pytest.mark.slow
@pytest.mark.parametrize(("method", "count"), [("proven", 2), ("proven", 5), ("sqp", 9), ("ga+sqp", 8)])
def test_a_run_that_was_stopped_is_taken_up_to_the_same_result(method: str, count: int) -> None:
    other: dict[str, Any] = {"method": method, "prove": True, "steps": (2, 3)}
    whole = [r.record() for r in run(**other)]
    store, reported = Memory(), []
    part = run(**other, store=store, report=reported.append, stop=lambda: len(reported) >= count)
    assert part[-1].status == "interrupted"
    assert part[-1].design_mm
    assert [r.record() for r in run(**other, store=store)] == whole
    assert [r.record() for r in run(**other, store=store)] == whole  # all from the store


def test_progress_tells_best_and_bound() -> None:
    reported: list[Progress] = []
    last = run(steps=(3,), report=reported.append)[0]
    assert {now.phase for now in reported} == {"proof"}
    assert math.isnan(reported[0].best)
    assert reported[-1].best == last.objective
    assert last.proof is not None
    assert reported[-1].bound == last.proof.bound
    assert [now.bound for now in reported] == sorted(now.bound for now in reported)
    assert {now.total for now in reported} == {Effort().boxes}


def test_the_bound_of_step_2_is_of_the_requirements_not_of_what_a_search_reached() -> None:
    """A GA of one generation ends at half of what is possible; step 2 may not call that the best there is."""
    one, two = run(task(), "ga", seed=5, population=4, generations=1, steps=(1, 2), prove=True)
    assert two.problem.upper[SIDE] == one.design_mm[SIDE] < 40.0
    best = run(task(), steps=(2,))[0].objective
    assert two.proof is not None
    assert two.proof.bound == pytest.approx(best, rel=2.1e-5)
    assert two.proof.gap == pytest.approx(best / two.objective - 1.0, abs=1e-4)
    assert CAPPED in two.advice
    assert "still be gained" in two.advice
    store = Memory()
    kept: dict[str, Any] = {"seed": 5, "population": 4, "generations": 1, "steps": (1, 2), "prove": True}
    first = [r.record() for r in run(task(), "ga", store=store, **kept)]
    assert [r.record() for r in run(task(), "ga", store=store, **kept)] == first == [one.record(), two.record()]


@pytest.mark.slow
def test_three_steps_of_the_contract_without_a_half_side_end_in_the_design_of_step_2() -> None:
    """Its cube touches a fold, where kappa cannot be proved: the design stands, with the gap that there is."""
    _, two, three = run(task())
    assert two.status == "proved"
    assert three.feasible
    assert three.design_mm == two.design_mm
    assert three.status == "gap not reached"
    assert three.proof is not None
    assert three.proof.bound is not None
    assert three.proof.certified is None
    assert three.objective == three.max_kappa > 1e3
    assert three.proof.gap == pytest.approx(1.0 - three.proof.bound / three.objective, rel=1e-3)
    assert three.proof.boxes <= STEEP_BOXES
    assert three.advice == f"{STEEP}; {FULL_SIDE}"


def test_few_boxes_leave_an_honest_gap() -> None:
    result = run(steps=(3,), effort=Effort(1e-5, 200))[0]
    assert result.status == "gap not reached"
    assert result.feasible
    assert result.proof is not None
    assert result.proof.gap is not None
    assert result.proof.gap > 1e-5


@pytest.mark.parametrize("method", ["proven", "sqp"])
def test_a_contradiction_is_named_and_proved(method: str) -> None:
    with pytest.raises(InfeasibleError) as caught:
        run(IMPOSSIBLE, method, steps=(3,), prove=True)
    assert caught.value.proved
    assert caught.value.conflict == ("kappa", "half_side")


def test_a_contradiction_that_is_not_proved_does_not_say_so() -> None:
    with pytest.raises(InfeasibleError) as caught:
        run(IMPOSSIBLE, "sqp", steps=(3,))
    assert not caught.value.proved


def test_what_only_the_proof_sees_names_all_constraints(monkeypatch: pytest.MonkeyPatch) -> None:
    """Short of feasible by less than the searches resolve."""
    monkeypatch.setattr(infeasible, "best_level", lambda *_: -1e-9)
    problem = step_problem(IMPOSSIBLE, 3)
    error = explain_proved(IMPOSSIBLE, problem, None, 0)
    assert error.conflict == problem.constraints
    assert error.shortfall == 1e-9
    assert error.proved


def test_without_numba_there_is_no_proof(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(proving, "find_spec", lambda _: None)
    with pytest.raises(ProblemError, match="numba"):
        run(steps=(1,))
    assert run(method="sqp", steps=(1,), prove=True)[0].proof is None


def test_a_bound_that_does_not_exist_is_left_out() -> None:
    """A design that is feasible to a rounding, where not one is feasible: the least cube is 1e-9 too large."""
    side = run(steps=(1,))[0].design_mm[SIDE] * (1.0 + 1e-7)
    given = task(platform_radius=(30, 45), half_side=(side, 100))
    problem = step_problem(given, 1)
    design = (82.0, 130.0, 40.0, 40.0, 48.0, side)
    result = Result(problem, "sqp", design, "converged")
    assert proving.with_bound(result, 0, Effort()) == result


def call(capsys: pytest.CaptureFixture[str], *arguments: object) -> tuple[int, str, str]:
    code = cli.main([str(argument) for argument in arguments])
    return code, *capsys.readouterr()


def test_command_line_tells_bound_and_gap(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "best.json"
    task_file = ROOT / "tests/references/joystick.toml"
    code, text, err = call(capsys, "synthesize", task_file, "--method", "proven", "--out", out)
    assert (code, err) == (0, "")
    assert text.count("proved: none above") == 2
    assert "step 3 proven: worst kappa 2.27 at" in text
    assert "proved: none below 2.26" in text
    steps = json.loads(out.read_text())["provenance"]["steps"]
    assert all(step["gap"] <= 1e-5 for step in steps)
    code, text, err = call(
        capsys, "synthesize", task_file, "--method", "sqp", "--steps", "1", "--json", "--no-proof", "--out", out
    )
    assert json.loads(text)["steps"][0]["proven_bound"] is None
    code, text, err = call(
        capsys, "synthesize", task_file, "--method", "sqp", "--steps", "1", "--json", "--gap", "1e-3", "--out", out
    )
    assert 1e-5 < json.loads(text)["steps"][0]["gap"] <= 1e-3


def test_command_line_names_what_is_undecided(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = (
        (ROOT / "tests/references/joystick.toml").read_text().replace("half_side = [0, 100]", "half_side = [60, 100]")
    )
    (tmp_path / "task.toml").write_text(text)
    command = ("synthesize", tmp_path / "task.toml", "--method", "proven", "--steps", "2", "--out", tmp_path / "b.json")
    code, text, err = call(capsys, *command, "--boxes", "0")
    assert code == 1
    assert ADVICE["undecided"] in err
    assert "undecided" in text
    code, text, err = call(capsys, *command)
    assert code == 1
    assert "proved: no design within bounds_mm" in err
    assert err.count("\n") == 1


@pytest.mark.parametrize("gap", ["0", "-1", "nan", "inf", "x"])
def test_a_gap_that_is_none_is_refused(gap: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        cli.main(["synthesize", "joystick.toml", "--gap", gap])
    assert ended.value.code == 2
    error = capsys.readouterr().err
    assert "--gap: " in error
    assert "must be a number > 0" in error
