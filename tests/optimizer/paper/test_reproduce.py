"""The published tables recomputed: against the equations written out here, print, and each other."""

from __future__ import annotations

import json
import math
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from optimizer.commands import cli, reproduce
from optimizer.paper.cases import FILE, STEP_OF_TABLE, Case, cases, numbers, posed, start_of
from optimizer.paper.facts import Facts, facts
from optimizer.paper.judgement import judge, largest_half_side
from optimizer.paper.page import page
from optimizer.paper.runs import Recomputed, Reproduction

REFERENCES = Path(__file__).parents[2] / "references" / "rcim2018.json"
TURN = 2.0 * np.pi / 3.0


@pytest.fixture(scope="module")
def run() -> Reproduction:
    return Reproduction(population=12, generations=3)


@pytest.fixture(scope="module")
def rows(run: Reproduction) -> list[Recomputed]:
    """All tables, with a small GA: proofs and SQP do not depend on it."""
    return run.recompute(cases())


@pytest.fixture(scope="module")
def told(rows: list[Recomputed], run: Reproduction) -> Facts:
    return facts(rows, run)


# The equations of [RCIM2018], written out: closure (2)-(5) with its trigonometric root, reach (7), J from the closure's
# derivatives, torque (8)-(12), condition number (13)-(16). Nothing of ours is used.


def surface(design_mm: tuple[float, ...], n: int = 31) -> np.ndarray:
    H, L = design_mm[4], design_mm[5]
    line = np.linspace(-1.0, 1.0, n)
    grid = np.stack(np.meshgrid(line, line, line, indexing="ij"), axis=-1).reshape(-1, 3)
    return np.array([0.0, 0.0, H + L]) + L * grid[(np.abs(grid) == 1.0).any(axis=1)]


def reach(design_mm: tuple[float, ...], p: np.ndarray) -> np.ndarray:
    """(n, 3) eq. (7), h <= 0 within the reach."""
    A, B, C = coefficients(design_mm, p)
    return C**2 - A**2 - B**2


def coefficients(design_mm: tuple[float, ...], p: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    L_A, L_B, R, r = design_mm[:4]
    phi = TURN * np.arange(3)
    u = p[:, :1] * np.cos(phi) + p[:, 1:2] * np.sin(phi)
    z = p[:, 2:]
    A, B = 2.0 * L_A * (R - r - u), -2.0 * L_A * z + 0.0 * u
    C = L_A**2 - L_B**2 + (R - r) ** 2 + (p**2).sum(axis=1, keepdims=True) - 2.0 * (R - r) * u
    return A, B, C


def statics(design_mm: tuple[float, ...], p: np.ndarray, force: float) -> tuple[float, float, float]:
    """Worst torque in N m, worst kappa in the 2-norm and in Frobenius's over some positions in mm."""
    L_A, _, R, r = design_mm[:4]
    A, B, C = coefficients(design_mm, p)
    root = np.arccos(np.clip(-C / np.hypot(A, B), -1.0, 1.0))
    theta = np.arctan2(B, A) + np.stack([root, -root])  # both branches
    outwards = np.argmax(np.cos(theta), axis=0)
    theta = np.take_along_axis(theta, outwards[None], axis=0)[0]
    phi = TURN * np.arange(3)
    radial = np.stack([np.cos(phi), np.sin(phi), np.zeros(3)], axis=-1)
    up = np.array([0.0, 0.0, 1.0])
    elbow = (R - r + L_A * np.cos(theta))[..., None] * radial + L_A * np.sin(theta)[..., None] * up
    s = p[:, None, :] - elbow
    turning = L_A * (-np.sin(theta)[..., None] * radial + np.cos(theta)[..., None] * up)
    # s . v = s . turning theta_dot
    rates = s / (s * turning).sum(axis=-1, keepdims=True)  # joint rates of a velocity, rad/mm
    J = np.linalg.inv(rates) / 1e3  # m
    torque = force * np.linalg.norm(np.swapaxes(J, -1, -2), axis=-1).max()
    frobenius = np.linalg.norm(J, axis=(-2, -1)) * np.linalg.norm(np.linalg.inv(J), axis=(-2, -1))
    return float(torque), float(np.linalg.cond(J).max()), float(frobenius.max())


def test_the_figures_of_every_published_design_are_those_of_the_equations(rows: list[Recomputed]) -> None:
    checked = 0
    for row in rows:
        judged = row.published
        if judged is None:
            continue
        points = surface(judged.design_mm)
        out_of_reach = bool((reach(judged.design_mm, points) > 0.0).any())
        assert out_of_reach == any(f.name == "reach" for f in judged.faults), row.case.name
        if row.case.step == 1:
            continue
        torque, kappa, frobenius = statics(judged.design_mm, points, 3.0)
        # ours is the polished maximum: never below a sample, and above it by what a grid of 2 mm misses
        for ours, sampled in (
            (judged.torque_N_m, torque),
            (judged.kappa, kappa),
            (judged.kappa_frobenius, frobenius),
        ):
            assert ours is not None
            assert sampled * (1.0 - 1e-9) <= ours <= sampled * (1.0 + 1e-3)
        assert torque < 0.8
        assert judged.faults == ()
        checked += 1
    assert checked == 15


def allowed_by_scan(case: Case) -> float:
    """Largest half side of a published run's L_B, R, r: every H of a fine scan, halving over L, eq. (7) on a grid."""
    assert case.result is not None
    best = 0.0
    stretch = case.result[1] - case.result[0]
    for H in np.concatenate([[stretch], np.linspace(case.lower[4], case.upper[4], 60)]):
        low, high = 0.0, 100.0
        while high - low > 1e-4:
            side = (low + high) / 2.0
            design = (*case.result[:4], float(H), side)
            # where the chains fold first, right above their shoulder axes, is no point of a grid
            a, phi = case.result[2] - case.result[3], TURN * np.arange(3)
            feet = np.stack([a * np.cos(phi), a * np.sin(phi), np.full(3, H)], axis=-1)
            feet = feet[(np.abs(feet[:, :2]) <= side).all(axis=1)]
            worst = reach(design, np.concatenate([surface(design, 9), feet])).max()
            low, high = (side, high) if worst <= 1e-6 else (low, side)  # mm^4: the fold itself, to its rounding
        best = max(best, low)
    return best


def test_step_1_reproduces_within_0_3_percent_and_half_the_last_printed_digit(rows: list[Recomputed]) -> None:
    """Tables 4, 6, 9: print against a scan; half of the last digit, or all of an illegible one, is print's."""
    bare: list[tuple[int, int]] = []
    mine = [row for row in rows if row.case.step == 1 and row.case.result is not None]
    assert len(mine) == 11
    for row in mine:
        scanned, printed = allowed_by_scan(row.case), row.case.objective
        assert row.follows == pytest.approx(scanned, abs=3e-4)
        assert printed is not None
        digits = 0.1 if "illegible" in row.case.note else 0.05
        assert abs(printed - scanned) <= 3e-3 * scanned + digits
        assert row.agrees
        assert row.within is (abs(printed / scanned - 1.0) <= 3e-3)
        if not row.within:
            bare.append((row.case.table, row.case.row))
        # no published cube is larger than what is possible, but for the same digits
        assert printed <= row.proven.bound * (1.0 + 3e-3) + digits
        assert row.proven.objective <= row.proven.bound
        assert row.proven.bound >= scanned - 1e-3
        assert row.gap == pytest.approx(1.0 - printed / row.proven.bound, abs=1e-15)
    assert bare == [(9, 2), (9, 4), (9, 6), (9, 8)]


def test_steps_2_and_3_do_not_follow_and_are_far_from_the_optimum(rows: list[Recomputed]) -> None:
    for row in rows:
        assert row.proven.status == "proved"
        assert row.proven.gap <= 1e-5
        if row.case.step == 1 or row.case.result is None:
            continue
        assert row.agrees is False
        assert row.gap is not None
        assert row.gap > 0.1
        judged = row.published
        assert judged is not None
        if row.case.step == 2:
            assert row.case.objective is not None
            assert row.gap == pytest.approx(1.0 - row.case.objective / row.proven.bound, abs=1e-15)
        else:
            assert judged.kappa is not None
            assert row.gap == pytest.approx(judged.kappa / row.proven.bound - 1.0, abs=1e-15)


def test_our_optima_keep_the_equations_and_no_method_beats_the_proof(rows: list[Recomputed]) -> None:
    for row in rows:
        assert row.proven.bound != row.proven.objective
        for found in row.found:
            if found.objective is None:
                continue
            slack = 1e-9 * found.objective  # of SQP's own rounding
            if row.case.step == 3:
                assert found.objective >= row.proven.bound - slack
            else:
                assert found.objective <= row.proven.bound + slack
            # 1e-3 mm^4 of 1e7: reach to the rounding of lengths
            assert reach(found.design_mm, surface(found.design_mm)).max() <= 1e-3
            if row.case.step > 1:
                assert statics(found.design_mm, surface(found.design_mm), 3.0)[0] <= 0.8
        assert row.method("ga+sqp").objective is not None
        best, start = row.method("ga+sqp").objective, row.method("ga").objective
        if best is not None and start is not None:
            assert best <= start * (1 + 1e-12) if row.case.step == 3 else best >= start * (1 - 1e-12)


def test_sqp_from_the_papers_starts(rows: list[Recomputed]) -> None:
    for row in rows:
        found = row.method("sqp")
        assert found.start == ("ours" if row.case.start is None else "paper")
        assert found.objective is not None
        assert found.objective == pytest.approx(row.proven.objective, rel=1e-6)


def test_exchanged_h(rows: list[Recomputed]) -> None:
    both = [row for row in rows if row.exchanged is not None]
    assert [(row.case.table, row.case.row) for row in both] == [(9, 1), (9, 2)]
    for row in both:
        assert row.published is not None
        assert row.exchanged is not None
        assert [f.name for f in row.published.faults] == ["reach"]
        assert row.exchanged.faults == ()
        assert row.exchanged.design_mm[4] == row.exchanged.design_mm[1] - 82.0  # on the fold


def test_faults_are_measured_in_units(rows: list[Recomputed]) -> None:
    case = next(row.case for row in rows if row.case.table == 10)
    problem, _ = posed(case)
    base = (82.0, 122.8, 40.0, 19.6, 60.0, 39.2)
    assert judge(problem, base).faults == ()
    low = judge(problem, (82.0, 122.8, 40.0, 19.6, 30.0, 39.2))
    # a = 20.4 mm lies inside the cube: the fold wants H >= L_B - L_A = 40.8 mm, reach is short by 10.8 mm there
    faults = {f.name: (f.by, f.unit) for f in low.faults}
    assert faults["reach"] == (pytest.approx(10.8, abs=1e-3), "mm")
    assert faults["bounds of H"] == (pytest.approx(10.0, abs=1e-12), "mm")
    wide = {f.name: (f.by, f.unit) for f in judge(problem, (82.0, 122.8, 45.0, 24.6, 60.0, 39.2)).faults}
    assert wide == {"outline": (5.0, "mm"), "bounds of R": (5.0, "mm")}
    weak = posed_with_torque(problem, 0.25)
    faults = {f.name: (f.by, f.unit) for f in judge(weak, base).faults}
    torque = statics(base, surface(base, 61), 3.0)[0]
    assert faults == {"torque": (pytest.approx(torque - 0.25, abs=1e-4), "N m")}
    flat = judge(problem, (82.0, 94.266, 40.0, 23.878, 22.648, 43.363))  # a hidden singularity, docs of the mechanism
    names = [f.name for f in flat.faults]
    assert "singularity" in names
    assert flat.kappa is flat.kappa_frobenius is flat.torque_N_m is None


def posed_with_torque(problem: Any, torque: float) -> Any:
    given = problem.requirements
    task = given.requirements.model_copy(update={"joint_torque_N_m": torque})
    return replace(problem, requirements=given.model_copy(update={"requirements": task}))


def test_lengths_that_allow_no_cube_have_no_largest_one(rows: list[Recomputed]) -> None:
    problem, _ = posed(rows[0].case)
    assert largest_half_side(problem, (82.0, 300.0, 40.0, 40.0, 60.0, 10.0)) is None  # folds above H = 100
    short = judge(problem, (82.0, 300.0, 40.0, 40.0, 60.0, 10.0))
    assert [f.name for f in short.faults] == ["reach", "bounds of L_B"]


def test_numbers_are_those_of_the_references() -> None:
    """Two transcripts of the same print: what the product ships and what the tests compare with."""
    ours, theirs = json.loads(FILE.read_text()), json.loads(REFERENCES.read_text())
    assert theirs["source"].startswith("RCIM 51 (2018)")
    assert "Robotics and Computer-Integrated Manufacturing 51 (2018) 73-84" in ours["source"]
    assert {k: v for k, v in ours.items() if k != "source"} == {k: v for k, v in theirs.items() if k != "source"}


def test_cases_are_all_rows_of_print_with_their_bounds() -> None:
    found = cases()
    count = {table: sum(case.table == table for case in found) for table in STEP_OF_TABLE}
    assert count == {4: 4, 6: 1, 7: 3, 8: 2, 9: 9, 10: 5, 11: 2, 12: 4}
    last = found[-1]
    assert (last.name, last.method, last.objective) == ("table 12 row 4", "GA+SQP", 6.009)
    assert last.result == (82.0, 112.079, 40.0, 30.0, 57.112, 35.0)
    assert last.start == (82.0, 113.989, 40.0, 30.0, 58.737, 35.0)
    for case in found:
        problem, changed = posed(case)
        assert problem.step == case.step
        assert problem.lower[0] == problem.upper[0] == 82.0
        assert problem.lower[2] == problem.upper[2] == 40.0
        for k, letter in ((1, "L_B"), (3, "r"), (4, "H")):
            assert (problem.lower[k], problem.upper[k]) == (max(1.0, case.lower[k]), case.upper[k])
            assert (case.lower[k] < 1.0) == (f"{letter} from 1 mm, printed 0" in changed)
        assert set(problem.constraints) - {"half_side"} == {"outline", "reach"} | (
            {"torque"} if case.step > 1 else set()
        )
    assert cases((8,)) == tuple(case for case in found if case.table == 8)


def test_starts_outside_the_bounds_are_moved_and_told() -> None:
    case = next(case for case in cases() if case.name == "table 10 row 2")
    problem, _ = posed(case)
    start, moved = start_of(case, problem)
    assert start == (82.0, 100.0, 40.0, 40.0, 50.0, 40.0)
    assert moved == ("start R 30 moved to 40, into the bounds",)
    assert start_of(cases((8,))[0], problem) == (None, ())


def cells(text: str, heading: str) -> list[dict[str, str]]:
    """The table under a heading of the page."""
    part = text.split(f"## {heading}")[1].split("\n## ")[0]
    lines = [[cell.strip() for cell in line.strip("|").split("|")] for line in part.splitlines() if line[:1] == "|"]
    return [dict(zip(lines[0], line, strict=True)) for line in lines[2:]]


def test_page_and_json_tell_the_same(told: Facts) -> None:
    text = page(told)
    assert text.startswith(f"# The published tables, recomputed\n\n**{told['summary']}**\n")
    for sentence in (*told["verdict"], *told["notes"], told["source"]):
        assert sentence in text
    columns = {
        "our GA": ("ga", "objective"),
        "our SQP": ("sqp", "objective"),
        "our GA+SQP": ("ga+sqp", "objective"),
    }
    seen = 0
    for number, table in told["tables"].items():
        heading = next(line[3:] for line in text.splitlines() if re.match(rf"## Tables? (\d+ and )?{number}:", line))
        for row, shown in zip(table["rows"], cells(text, heading), strict=True):
            kappa = table["objective"] == "kappa"
            ours = row["by_our_equations"]
            expected = {name: row["found"][method][field] for name, (method, field) in columns.items()}
            expected["proven kappa at least" if kappa else "proven L at most"] = row["proven"]["bound"]
            expected["printed kappa" if kappa else "printed L"] = row["printed_objective"]
            expected["follows: kappa" if kappa else "follows: its lengths allow L"] = row["follows"]
            if kappa:
                expected |= {"Frobenius": ours["max_kappa_frobenius"], "torque, N m": ours["max_torque_N_m"]}
            elif table["step"] == 2 and ours:
                expected["its kappa"] = ours["max_kappa"]
                expected["torque of the printed design, N m"] = ours["max_torque_N_m"]
            for name, value in expected.items():
                if value is None:
                    assert shown[name] == "-"
                else:
                    decimals = len(shown[name].partition(".")[2])
                    assert float(shown[name]) == pytest.approx(value, abs=0.501 * 10.0**-decimals)
                    seen += 1
            assert shown["row"] == str(row["row"])
            assert shown["gap"] == ("-" if row["gap"] is None else f"{100 * row['gap']:.2f} %")
            words = {None: "-", True: "yes", False: "no"}
            assert shown["within 0.3 %"] == words[row["within_agreement"]]
            assert shown["with half the last digit"] == words[row["within_beside_half_last_digit"]]
            if row["difference"] is None:
                assert shown["off by"] == "-"
            else:
                assert float(shown["off by"].removesuffix(" %")) == pytest.approx(100 * row["difference"], abs=5.01e-3)
            kept = "no results" if ours is None else "yes" if ours["keeps_its_constraints"] else None
            assert shown["keeps its constraints"] == kept or kept is None
            for fault in ours["faults"] if ours else ():
                assert f"{fault['name']} missed by {fault['by']:.3g} {fault['unit']}" in shown["keeps its constraints"]
            for remark in (row["note"], *row["changed"]):
                assert remark in text
    assert seen > 200
    for parameter, shown in zip(told["table_2"], cells(text, "Table 2"), strict=True):
        assert shown["parameter"] == parameter["parameter"]
    json.dumps(told, allow_nan=False)


def test_the_verdict_is_computed_and_says_so(told: Facts, rows: list[Recomputed], run: Reproduction) -> None:
    assert told["summary"].startswith(
        "Step 1 reproduces within 0.3 % in 7 of 11 rows, and in 4 more only with half of their last printed digit "
        "(table 9 row 2 -0.36 %, table 9 row 4 +0.31 %, table 9 row 6 +0.31 %, table 9 row 8 +0.31 %), "
        "step 2 does not reproduce (off by up to 37.8 %)"
    )
    assert told["verdict"][0].startswith(told["summary"].split("), ")[0] + "): the 11 printed half sides differ by at")
    assert [sentence.split(":")[0] for sentence in told["verdict"][1:]] == [
        "Step 2 does not reproduce",
        "Step 3 does not reproduce",
    ]
    assert "need 0.303 to 0.329 N m for 3 N" in told["verdict"][1]
    assert "the paper's equations give 2.035 to 2.100" in told["verdict"][2]
    # other rows, other words
    false = [replace(row, agrees=False) if row.case.table == 6 else row for row in rows]
    assert facts(false, run)["verdict"][0].startswith("Step 1 reproduces within 0.3 % in 6 of 11 rows, and in 4 more")
    assert "row 8 +0.31 %) (off by up to 0.4 %), step 2" in facts(false, run)["summary"]
    true = [replace(row, agrees=True, difference=3e-3) for row in rows]
    assert facts(true, run)["verdict"][1].startswith("Step 2 reproduces within 0.3 %: ")
    assert facts(true, run)["summary"].startswith("Step 1 reproduces within 0.3 %, step 2")
    none = facts([row for row in rows if row.case.result is None], run)
    assert none["summary"] == "No published result is among these tables."
    assert none["verdict"] == []
    assert "in Frobenius's" not in page(none)


def test_notes_say_what_explains_the_numbers(told: Facts) -> None:
    text = "\n".join(told["notes"])
    assert "table 9 row 2: 65 is printed where the lengths give 65.235, -0.36 % (last digit of L illegible); " in text
    assert (
        "table 9 row 4, table 9 row 6, table 9 row 8: 64.4 is printed where the lengths give 64.201, +0.31 %, and the "
        "5 other rows with this proven optimum print 64.2 to 64.25."
    ) in text
    assert "row 1 misses reach by 7.48 mm as printed, nothing with the other's H" in text
    assert "row 2 misses reach by 10.00 mm as printed, nothing with the other's H" in text
    assert '4 of the 4 runs for which the paper has "no results" have feasible designs' in text
    assert "table 9 row 5 reaches 64.201 mm (converged)" in text
    assert "have a worst kappa of 18.2 to " in text
    assert "rows 1 and 2: 8.54 % as printed, 3.12 % by our equations" in text
    assert "35 mm is taken, half the side of its prototype's cube of 70 mm" in text


def test_what_is_not_proved_or_found_is_remarked(rows: list[Recomputed], run: Reproduction) -> None:
    row = next(row for row in rows if row.case.name == "table 10 row 5")
    poor = replace(
        row,
        proven=replace(row.proven, status="gap not reached", gap=0.01),
        found=tuple(
            replace(f, objective=None, ending="ended 0.1 short") if f.method == "sqp" else f for f in row.found
        ),
    )
    told = facts([poor], run)
    text = page(told)
    assert "- row 5: the proof ended with: gap not reached, gap 1.0e-02" in text
    assert "- row 5: SQP from the paper's start: ended 0.1 short" in text
    assert "table 10 row 5 ends infeasible (ended 0.1 short)" in text
    assert "SQP none (1 rows without result)" in text
    assert cells(text, "Table 10")[0]["our SQP"] == "-"
    nothing = replace(row.proven, status="infeasible", objective=math.nan, bound=math.nan, gap=math.nan, design_mm=())
    told = facts([replace(poor, proven=nothing)], run)
    assert told["tables"]["10"]["rows"][0]["proven"]["bound"] is None
    assert "- row 5: the proof ended with: infeasible\n" in page(told)
    json.dumps(told, allow_nan=False)


def test_defaults_are_the_papers() -> None:
    run, paper = Reproduction(), numbers()["table_2_ga_parameters"]
    told = {row["parameter"].split(" in ")[0]: row for row in facts([], run)["table_2"]}
    assert told["population"]["ours"] == paper["population"] == [100, 220, 220]
    assert told["generations"]["ours"] == paper["generations"] == 100
    assert told["crossover fraction"]["ours"] == paper["crossover_fraction"]
    assert tuple(STEP_OF_TABLE) == reproduce.TABLES


def test_command_exits_1_where_a_proof_or_method_fails(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, rows: list[Recomputed]
) -> None:
    row = rows[8]
    lost = tuple(replace(f, objective=None) for f in row.found)
    poor = replace(row, proven=replace(row.proven, status="gap not reached"), found=lost)
    monkeypatch.setattr(Reproduction, "recompute", lambda *_: [poor])
    assert cli.main([str(a) for a in ("reproduce", "--out", tmp_path, "--tables", "8")]) == 1
    err = capsys.readouterr().err
    assert err == "the optimum of table 8 row 1 is not proved; GA+SQP fails on table 8 row 1\n"
    assert (tmp_path / "reproduce.md").exists()
