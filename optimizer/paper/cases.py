r"""The published runs of [RCIM2018], tables 3 to 12, as cases: bounds, start, result; and each as a problem of ours.

[RCIM2018] is "GA\SQP optimization for the dimensional synthesis of a delta mechanism based haptic device design",
Robotics and Computer-Integrated Manufacturing 51 (2018) 73-84. Its numbers are in `paper.json`, as they are printed.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from optimizer.problem.evaluator import VARIABLES
from optimizer.problem.requirements import requirements_from_dict
from optimizer.problem.step import Problem, step_problem

FILE = Path(__file__).with_name("paper.json")
LETTERS = ("L_A", "L_B", "R", "r", "H", "L")
"""The paper's letters of `VARIABLES`."""
STEP_OF_TABLE = {4: 1, 6: 1, 7: 2, 8: 3, 9: 1, 10: 2, 11: 3, 12: 3}
"""Tables of results -> the step that they are about."""
STEP_3_HALF_SIDE_MM = 35.0
"""The paper prints no L for step 3; its prototype has a cube of 70 mm."""
SHORTEST_MM = 1.0
"""What our requirements take as the smallest length; the paper has lower bounds of 0."""
EXCHANGED_H = ((9, 1), (9, 2))
"""Table and row of two results whose H look exchanged in print."""
Lengths = tuple[float, ...]


@dataclass(frozen=True)
class Case:
    """One published run; lengths in mm, in the order of `VARIABLES`.

    Attributes:
        table: Number of the table.
        row: Its row, from 1.
        step: 1, 2 or 3.
        method: `GA`, `SQP` or `GA+SQP`.
        lower: (6) lower bounds as printed; of step 3 those that are fixed are filled in.
        upper: (6) upper bounds.
        start: (6) start of SQP; None for the GA.
        result: (6) what was found; None where the paper has "no results".
        objective: As printed: L in mm, or kappa; None without a result.
        note: What the transcription remarks.
    """

    table: int
    row: int
    step: int
    method: str
    lower: Lengths
    upper: Lengths
    start: Lengths | None
    result: Lengths | None
    objective: float | None
    note: str = ""

    @property
    def name(self) -> str:
        """As the page calls it."""
        return f"table {self.table} row {self.row}"


@cache
def numbers() -> dict[str, Any]:
    """The content of `paper.json`."""
    return json.loads(FILE.read_text(encoding="utf-8"))


def cases(tables: tuple[int, ...] = tuple(STEP_OF_TABLE)) -> tuple[Case, ...]:
    r"""The published runs.

    Args:
        tables: Numbers of tables, of `STEP_OF_TABLE`.

    Returns:
        The cases in the order of print.
    """
    data = numbers()
    found: list[Case] = []
    for k, row in enumerate(data["table_4_step1_ga_results"]):
        found.append(_case(4, k, "GA", data["table_3_step1_ga_bounds"] | {"result": row}))
    found.append(_case(6, 0, "GA", data["table_5_step1_ga_bounds"] | {"result": data["table_6_step1_ga_result"]}))
    for k, row in enumerate(data["table_7_step2_ga"]):
        found.append(_case(7, k, "GA", row))
    for table, key, method in (
        (8, "table_8_step3_ga", "GA"),
        (9, "table_9_step1_sqp", "SQP"),
        (10, "table_10_step2_sqp", "SQP"),
        (11, "table_11_step3_sqp", "SQP"),
        (12, "table_12_ga_and_ga_sqp", ""),
    ):
        for k, row in enumerate(data[key]["rows"]):
            found.append(_case(table, k, method or row["method"], row))
    return tuple(case for case in found if case.table in tables)


def _case(table: int, index: int, method: str, row: dict[str, Any]) -> Case:
    step = STEP_OF_TABLE[table]
    result = None if row["result"] is None else _lengths(row["result"], step)
    objective = row.get("objective") if step == 3 else None if result is None else result[-1]
    start = None if row.get("start") is None else _lengths(row["start"], step)
    lower, upper = _lengths(row["lower"], step), _lengths(row["upper"], step)
    return Case(table, index + 1, step, method, lower, upper, start, result, objective, row.get("note", ""))


def _lengths(row: list[float], step: int) -> Lengths:
    """Six lengths; step 3 prints L_B, r, H alone."""
    if step != 3:
        return tuple(float(x) for x in row)
    fixed, (L_B, r, H) = numbers()["constraints"], row
    return (float(fixed["L_A_mm"]), float(L_B), float(fixed["R_mm"]), float(r), float(H), STEP_3_HALF_SIDE_MM)


def posed(case: Case) -> tuple[Problem, tuple[str, ...]]:
    """A case as a problem of ours.

    R and L_A are fixed as table 1 has them, wherever a table's bounds leave them free.

    Args:
        case: The published run.

    Returns:
        The problem; what had to be changed, in words.
    """
    fixed = numbers()["constraints"]
    lower, upper, changed = list(case.lower), list(case.upper), []
    for k, value in ((0, float(fixed["L_A_mm"])), (2, float(fixed["R_mm"]))):
        if (lower[k], upper[k]) != (value, value):
            changed.append(f"{LETTERS[k]} fixed at {value:g} (table 1), printed {lower[k]:g} to {upper[k]:g}")
        lower[k] = upper[k] = value
    for k in range(5):
        if lower[k] < SHORTEST_MM:
            changed.append(f"{LETTERS[k]} from {SHORTEST_MM:g} mm, printed {lower[k]:g}")
            lower[k] = SHORTEST_MM
    depth, width = fixed["envelope_mm"]
    given = requirements_from_dict(
        {
            "name": f"table-{case.table}-row-{case.row}",
            "requirements": {
                "envelope_width_mm": float(width),
                "envelope_depth_mm": float(depth),
                "force_N": float(fixed["force_N"]),
                "joint_torque_N_m": float(fixed["joint_torque_N_m"]),
            },
            "bounds_mm": dict(zip(VARIABLES, zip(lower, upper, strict=True), strict=True)),
            "limits": {"outline_radius_max_mm": float(fixed["R_plus_L_A_max_mm"])},
            "step_3": {"half_side_mm": STEP_3_HALF_SIDE_MM} if case.step == 3 else {},
        }
    )
    return step_problem(given, case.step), tuple(changed)


def start_of(case: Case, problem: Problem) -> tuple[Lengths | None, tuple[str, ...]]:
    """The published start, moved into the bounds.

    Args:
        case: The published run.
        problem: As `posed` gives it.

    Returns:
        (6) lengths, mm, or None where the paper has no start; what was moved, in words.
    """
    if case.start is None:
        return None, ()
    start, moved = [], []
    for letter, value, low, high in zip(LETTERS, case.start, problem.lower, problem.upper, strict=True):
        inside = min(max(value, low), high)
        if inside != value:
            moved.append(f"start {letter} {value:g} moved to {inside:g}, into the bounds")
        start.append(inside)
    return tuple(start), tuple(moved)
