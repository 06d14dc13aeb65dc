"""The three steps in a row, their results, and what is said when they cannot be met."""

from __future__ import annotations

import json
import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from delta_cad.mechanism import Cube, DeltaGeometry, cube_extremes
from optimizer.problem.extremes import design_worst
from optimizer.problem.requirements import Requirements
from optimizer.problem.step import CONSTRAINTS, Problem, ProblemError, step_problem
from optimizer.search.genetic import Population, evolve
from optimizer.search.result import ADVICE, Result
from optimizer.search.sqp import Ending, Search
from optimizer.synthesis import three_step
from optimizer.synthesis.infeasible import InfeasibleError, _smallest, explain
from optimizer.synthesis.three_step import METHODS, Progress, Run, best_holding
from tests.optimizer.messages import refuses
from tests.optimizer.tasks import Memory, task

PAPER = task(platform_radius=(30, 45), half_side_mm=35)
OPTIMA = (64.2015, 62.0154, 1.76687)
"""Closed form; README of the paper (62.02); README of the paper (1.767), each with the digits we reach."""
SMALL: dict[str, Any] = {"population": 16, "generations": 5}


def run(given: Requirements = PAPER, method: str = "ga+sqp", seed: int = 0, **other: Any) -> list[Result]:
    return Run(given, method, seed, **(SMALL | other)).results()


@pytest.mark.parametrize("seed", range(3))
def test_ga_and_sqp_end_at_the_optima_whatever_the_seed(seed: int) -> None:
    for result, optimum in zip(run(seed=seed), OPTIMA, strict=True):
        assert result.objective == pytest.approx(optimum, rel=5e-3)
        assert result.feasible
        assert result.status == "converged"


def test_sqp_alone_ends_there_too() -> None:
    for result, optimum in zip(run(method="sqp"), OPTIMA, strict=True):
        assert result.objective == pytest.approx(optimum, rel=1e-5)


def test_ga_and_sqp_is_never_worse_than_ga() -> None:
    for alone, both in zip(run(method="ga", steps=(1, 2)), run(steps=(1, 2)), strict=True):
        assert alone.feasible
        assert not alone.better_than(both)
        assert both.evaluations > alone.evaluations
    same_side = task(platform_radius=(30, 45), half_side_mm=30)
    assert run(same_side, "ga", steps=(3,))[0].objective >= run(same_side, steps=(3,))[0].objective


def test_what_a_step_reaches_bounds_the_next() -> None:
    one, two, three = run(task(platform_radius=(30, 45), limits={"kappa_max": 2.5, "lean_max_deg": 28}))
    assert two.objective < one.objective
    assert two.problem.upper[5] == one.objective
    assert three.design_mm[5] == two.objective
    assert three.objective <= two.max_kappa + 1e-9
    assert two.max_kappa == pytest.approx(2.5, rel=1e-6)


@pytest.mark.parametrize("method", METHODS)
def test_every_number_is_decided_by_the_seed(method: str) -> None:
    first, second = (run(method=method, seed=3, steps=(3,))[0].record() for _ in range(2))
    assert first == second


def test_results_agree_with_another_search_of_the_cube() -> None:
    """`cube_extremes` works on the mechanism's own functions with another grid and another polish."""
    for result in run(method="sqp", steps=(2, 3)):
        L_A, L_B, R, r, H, L = (value / 1000.0 for value in result.design_mm[:6])
        e = cube_extremes(DeltaGeometry(R, r, L_A, L_B), Cube(H, L), 3.0, 15)
        # both are polished to 1e-5 of L or better
        assert result.max_torque == pytest.approx(e.torque_max.value, rel=1e-8)
        if result.max_kappa < 100.0:  # near the fold of step 2 kappa rises without bound within a micrometre
            assert result.max_kappa == pytest.approx(e.kappa_max.value, rel=1e-8)
        assert e.direct_margin_min.value > 0.0


def test_a_result_sees_its_own_violations() -> None:
    good = run(method="sqp", steps=(3,))[0]
    assert good.violations == dict.fromkeys(good.problem.constraints, 0.0)
    larger = replace(good, design_mm=(*good.design_mm[:5], 70.0))
    assert larger.violations["reach"] > 0.01
    assert not larger.feasible
    assert good.better_than(larger)
    assert not larger.better_than(good)
    larger_still = replace(good, design_mm=(*good.design_mm[:5], 75.0))
    assert larger.better_than(larger_still)
    smaller = replace(good, design_mm=(*good.design_mm[:5], 30.0))
    assert smaller.violations["half_side"] == pytest.approx(5 / 35, rel=1e-12)


def test_a_record_is_plain_json_and_what_is_infinite_is_null() -> None:
    one, _, three = run(method="sqp")
    record = json.loads(json.dumps([one.record(), three.record()], allow_nan=False))
    assert record[0]["max_kappa"] is None
    assert one.max_torque == math.inf
    assert record[0]["proven_bound"] is None
    assert record[1]["variables"]["forearm_length_mm"] == three.design_mm[1]
    assert list(record[1]["variables"]) == [
        "upper_arm_length_mm",
        "forearm_length_mm",
        "base_radius_mm",
        "platform_radius_mm",
        "bottom_height_mm",
        "half_side_mm",
    ]
    assert record[1]["advice"] == ADVICE["converged"]
    assert record[1]["outline"] == "straight"
    assert all(start["reason"] for start in record[0]["starts"])


@pytest.mark.parametrize("count", [3, 6, 9])
def test_a_run_that_was_stopped_is_taken_up_to_the_same_result(count: int) -> None:
    steps = (2, 3)
    whole = [r.record() for r in run(seed=2, steps=steps)]
    store, reported = Memory(), []
    part = run(seed=2, steps=steps, store=store, report=reported.append, stop=lambda: len(reported) >= count)
    assert part[-1].status == "interrupted"
    assert part[-1].design_mm
    assert [r.record() for r in run(seed=2, steps=steps, store=store)] == whole
    assert [r.record() for r in run(seed=2, steps=steps, store=store)] == whole  # all from the store


def test_progress_tells_step_phase_and_best() -> None:
    reported: list[Progress] = []
    run(steps=(3,), report=reported.append)
    assert [t.phase for t in reported] == ["ga"] * 5 + ["sqp"]
    assert reported[-1].best == pytest.approx(OPTIMA[2], rel=1e-5)
    assert {t.step for t in reported} == {3}
    assert reported[4].done == reported[4].total == 5


def test_a_step_without_a_feasible_design_bounds_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    def too_large(problem: Problem, last: Population) -> np.ndarray:
        return last.x[0] * np.where(np.array(problem.free) == "half_side", 1.1, 1.0)

    monkeypatch.setattr(three_step, "best_holding", too_large)
    one, two = run(task((82, 140), (30, 45), limits={"kappa_max": 2.27}), "ga", generations=30)
    assert not one.feasible
    assert two.problem.upper[5] == 100.0
    assert not two.feasible  # and there is no step 3, which would go on at a half side that cannot be


@pytest.mark.slow
def test_a_cube_below_a_micrometre_ends_the_run() -> None:
    results = run(task((82, 140), (30, 45), limits={"shoulder_deg": (10, 10.0001)}), "sqp", prove=True)
    assert [result.problem.step for result in results] == [1, 2]
    assert results[-1].tiny
    assert results[-1].proof is None


def test_no_set_of_constraints_is_smaller_than_the_one_that_is_named() -> None:
    """Against all subsets: contradictions of random members, of which the smallest must be found."""
    random, names = np.random.default_rng(0), CONSTRAINTS
    for _ in range(200):
        conflicts = [
            frozenset(random.choice(names, size, replace=False).tolist()) for size in random.integers(1, 6, size=3)
        ]
        requested: list[frozenset[str]] = []

        def impossible(
            trial: frozenset[str],
            requested: list[frozenset[str]] = requested,
            conflicts: list[frozenset[str]] = conflicts,
        ) -> bool:
            requested.append(trial)
            return any(one <= trial for one in conflicts)

        found = _smallest(names, impossible)
        assert found in conflicts
        assert len(found) == min(map(len, conflicts))
        assert len(set(requested)) == len(requested)


CONFLICTS = [
    (task(torque=0.01, half_side=(20, 100)), 2, ("torque", "half_side")),
    (task(half_side=(70, 100)), 1, ("reach", "half_side")),
    (task(upper_arm_length=(90, 95)), 1, ("outline",)),
    (task(limits={"kappa_max": 1.5, "clearance_min_mm": 2}, half_side_mm=40), 3, ("kappa", "half_side")),
    (task(platform_radius=(20, 22), limits={"clearance_min_mm": 9}), 2, ("clearance",)),
]


@pytest.mark.parametrize(("given", "step", "conflict"), CONFLICTS, ids=["+".join(c) for _, _, c in CONFLICTS])
def test_smallest_contradiction_is_named(given: Requirements, step: int, conflict: tuple[str, ...]) -> None:
    with pytest.raises(InfeasibleError, match=f"^step {step}: ") as caught:
        run(given, "sqp", steps=(step,))
    assert caught.value.conflict == conflict
    problem = step_problem(given, step)
    assert all(problem.describe(name) in str(caught.value) for name in conflict)
    # irreducible: without any one of them the others can be met
    for name in conflict:
        assert explain(given, step_problem(given, step, without=frozenset({name})), None, 0) is None


def test_one_constraint_alone_is_named_before_two_others() -> None:
    """Reach and half side contradict each other too, but the outline cannot be met whatever else is given up."""
    given = task(half_side=(100, 100), limits={"outline_radius_max_mm": 100.0})
    with refuses(InfeasibleError, "1", "L_A", "100") as caught:
        run(given, "sqp", steps=(1,))
    assert caught.value.conflict == ("outline",)
    others = explain(given, step_problem(given, 1, without=frozenset({"outline"})), None, 0)
    assert others is not None


def test_the_ga_alone_finds_the_contradiction_too() -> None:
    with pytest.raises(InfeasibleError, match=r"limits\.kappa_max = 1\.2 .*step_3\.half_side_mm = 40 mm "):
        run(task(limits={"kappa_max": 1.2}, half_side_mm=40), "ga", steps=(3,))


def test_a_ga_that_meets_no_feasible_design_says_what_to_do() -> None:
    result = run(task((82, 200), limits={"kappa_max": 1.78}, half_side_mm=35), "ga", steps=(3,), generations=1)[0]
    assert result.status == "no feasible design"
    assert not result.feasible


@pytest.mark.parametrize(
    ("other", "words"),
    [
        ({"method": "magic"}, "'magic'"),
        ({"steps": (2, 1)}, r"\[2, 1\]"),
        ({"steps": ()}, r"\[\]"),
        ({"given": task(), "steps": (1, 3)}, "step 3"),
    ],
)
def test_runs_that_make_no_sense_are_refused(other: dict[str, Any], words: str) -> None:
    with pytest.raises(ProblemError, match=words):
        run(**other)


def test_a_ga_that_fails_between_its_samples_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    """The best of the sample, made 10 % larger, stands for one that is too large between the samples."""
    given = task((82, 140), (30, 45), limits={"kappa_max": 2.27})

    def too_large(problem: Problem, last: Population) -> np.ndarray:
        return last.x[0] * np.where(np.array(problem.free) == "half_side", 1.1, 1.0)

    monkeypatch.setattr(three_step, "best_holding", too_large)
    result = run(given, "ga", steps=(2,), generations=12)[0]
    assert result.status == "between the samples"
    assert result.violations["kappa"] > 1e-6


def test_what_is_too_large_between_the_samples_is_made_smaller_until_it_holds() -> None:
    problem = step_problem(task((82, 140), (30, 45), limits={"kappa_max": 2.27}), 2)
    last = evolve(problem, 0, 16, 12)
    k = problem.free.index("half_side")
    x = last.x[:1].copy()
    x[0, k] *= 1.02
    found = best_holding(problem, replace(last, x=x))
    np.testing.assert_array_equal(np.delete(found, k), np.delete(x[0], k))
    worst = design_worst(problem, problem.designs(found[None])[0], 41)["kappa"].values[0]
    # it holds, and a cube 1e-5 larger would not, or the whole of it held
    assert worst >= -1e-9
    assert found[k] == x[0, k] or worst < 1e-5
    x[0, k] *= 2.0
    np.testing.assert_array_equal(best_holding(problem, replace(last, x=x)), x[0])


def test_an_sqp_that_finds_nothing_better_keeps_its_start(monkeypatch: pytest.MonkeyPatch) -> None:
    alone = run(method="ga", steps=(3,))[0]

    def fail(_: object, starts: np.ndarray, *__: object) -> Search:
        return Search([Ending(tuple(x), tuple(x * 0.0), 0.1, False, "made to fail", (0.1,)) for x in starts], 1)

    monkeypatch.setattr(three_step.sqp, "search", fail)
    both = run(steps=(3,))[0]
    assert both.design_mm == alone.design_mm
    assert both.status == "not improved"
    assert both.record()["starts"][0]["reason"] == "made to fail"
    assert both.advice == ADVICE["not improved"]


def test_step_3_keeps_what_step_2_found_where_nothing_better_can_be_reached() -> None:
    """Conditioning and torque both hold step 2's cube: from its design no way leads on, from others to 1e-6 outside."""
    limits = {"outline_radius_max_mm": 121.0, "kappa_max": 2.27, "lean_max_deg": 28.0, "gravity_torque_N_m": 0.11}
    limits |= {"clearance_min_mm": 2.0, "joint_diameter_mm": 11.0, "parallelogram_width_mm": 54.0}
    given = task((80, 180), (30, 45), (20, 150), upper_arm_length=(60, 90), limits=limits, torque=0.29)
    *_, second, third = Run(given, "sqp").results()
    assert second.feasible
    assert third.feasible
    np.testing.assert_allclose(third.design_mm, second.design_mm, rtol=1e-5)
