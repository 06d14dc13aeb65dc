r"""The published runs of [RCIM2018], tables 3 to 12: bounds, start and result as printed, each as a problem of ours.

[RCIM2018] is "GA\SQP optimization for the dimensional synthesis of a delta mechanism based haptic device design",
Robotics and Computer-Integrated Manufacturing 51 (2018) 73-84. Its numbers are in `paper.json`, as they are printed.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from optimizer.problem.requirements import requirements_from_dict
from optimizer.problem.step import Problem, step_problem
from optimizer.problem.variables import LENGTHS

FILE = Path(__file__).with_name("paper.json")
LETTERS = ("L_A", "L_B", "R", "r", "H", "L")  # the paper's, in the order of `LENGTHS`
STEP_OF_TABLE = {4: 1, 6: 1, 7: 2, 8: 3, 9: 1, 10: 2, 11: 3, 12: 3}
STEP_3_HALF_SIDE_MM = 35.0  # the paper prints no L for step 3; its prototype has a cube of 70 mm
_SHORTEST_MM = 1.0  # what our requirements take as the smallest length; the paper has lower bounds of 0
EXCHANGED_H = ((9, 1), (9, 2))  # table and row of two results whose H look exchanged in print
Lengths = tuple[float, ...]


@dataclass(frozen=True)
class PublishedRun:
    """One run as it is printed; lengths in mm, in the order of `LENGTHS`.

    Attributes:
        table: Number of the table.
        row: Its row, from 1.
        step: 1, 2 or 3.
        method: `GA`, `SQP` or `GA+SQP`.
        lower: (6) lower bounds; of step 3 those that are fixed are filled in.
        upper: (6) upper bounds.
        start: (6) start of SQP; None for the GA.
        result: (6) the design; None where the paper has "no results".
        objective: L in mm, or kappa; None without a result.
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
        """Table and row, such as "table 4 row 1"."""
        return f"table {self.table} row {self.row}"


@cache
def numbers() -> dict[str, Any]:
    """Reads the content of `paper.json`."""
    return json.loads(FILE.read_text(encoding="utf-8"))


def published_runs(tables: tuple[int, ...] = tuple(STEP_OF_TABLE)) -> tuple[PublishedRun, ...]:
    """Reads the published runs of some tables, of `STEP_OF_TABLE`, in the order of print."""
    data = numbers()
    printed = {
        4: ("GA", [data["table_3_step1_ga_bounds"] | {"result": row} for row in data["table_4_step1_ga_results"]]),
        6: ("GA", [data["table_5_step1_ga_bounds"] | {"result": data["table_6_step1_ga_result"]}]),
        7: ("GA", data["table_7_step2_ga"]),
        8: ("GA", data["table_8_step3_ga"]["rows"]),
        9: ("SQP", data["table_9_step1_sqp"]["rows"]),
        10: ("SQP", data["table_10_step2_sqp"]["rows"]),
        11: ("SQP", data["table_11_step3_sqp"]["rows"]),
        12: ("", data["table_12_ga_and_ga_sqp"]["rows"]),  # each row names its method
    }
    return tuple(
        _run(table, number, method, row)
        for table, (method, rows) in printed.items()
        if table in tables
        for number, row in enumerate(rows, 1)
    )


def _run(table: int, number: int, method: str, row: dict[str, Any]) -> PublishedRun:
    step = STEP_OF_TABLE[table]
    lower, upper, start, result = (_lengths(row.get(key), step) for key in ("lower", "upper", "start", "result"))
    assert lower is not None
    assert upper is not None
    objective = row["objective"] if step == 3 else None if result is None else result[-1]
    method, note = method or row["method"], row.get("note", "")
    return PublishedRun(table, number, step, method, lower, upper, start, result, objective, note)


def _lengths(row: list[float] | None, step: int) -> Lengths | None:
    """Completes a row to six lengths; of step 3 L_B, r and H alone are printed."""
    if row is None or step != 3:
        return None if row is None else tuple(map(float, row))
    fixed, (L_B, r, H) = numbers()["constraints"], map(float, row)
    return (float(fixed["L_A_mm"]), L_B, float(fixed["R_mm"]), r, H, STEP_3_HALF_SIDE_MM)


def problem_of(run: PublishedRun) -> tuple[Problem, tuple[str, ...]]:
    """Poses a published run as a problem of ours, R and L_A fixed as table 1 has them whatever its bounds say.

    Returns:
        The problem; what had to be changed.
    """
    fixed = numbers()["constraints"]
    bounds, changed = list(zip(run.lower, run.upper, strict=True)), []
    for k, value in ((0, float(fixed["L_A_mm"])), (2, float(fixed["R_mm"]))):
        if bounds[k] != (value, value):
            changed.append(f"{LETTERS[k]} fixed at {value:g} (table 1), printed {bounds[k][0]:g} to {bounds[k][1]:g}")
            bounds[k] = (value, value)
    for k, (low, high) in enumerate(bounds[:5]):
        if low < _SHORTEST_MM:
            changed.append(f"{LETTERS[k]} from {_SHORTEST_MM:g} mm, printed {low:g}")
            bounds[k] = (_SHORTEST_MM, high)
    depth, width = fixed["envelope_mm"]
    given = requirements_from_dict(
        {
            "name": f"table-{run.table}-row-{run.row}",
            "requirements": {
                "envelope_width_mm": float(width),
                "envelope_depth_mm": float(depth),
                "force_N": float(fixed["force_N"]),
                "joint_torque_N_m": float(fixed["joint_torque_N_m"]),
            },
            "bounds_mm": dict(zip(LENGTHS, bounds, strict=True)),
            "limits": {"outline_radius_max_mm": float(fixed["R_plus_L_A_max_mm"])},
            "step_3": {"half_side_mm": STEP_3_HALF_SIDE_MM} if run.step == 3 else {},
        }
    )
    return step_problem(given, run.step), tuple(changed)


def start_within(run: PublishedRun, problem: Problem) -> tuple[Lengths | None, tuple[str, ...]]:
    """Moves the published start into the bounds of its problem.

    Args:
        run: The published run.
        problem: As `problem_of` gives it.

    Returns:
        (6) lengths, mm, or None where the paper has no start; what was moved.
    """
    if run.start is None:
        return None, ()
    start = tuple(map(lambda v, low, high: min(max(v, low), high), run.start, problem.lower, problem.upper))
    moved = [
        f"start {letter} {printed:g} moved to {inside:g}, into the bounds"
        for letter, printed, inside in zip(LETTERS, run.start, start, strict=True)
        if printed != inside
    ]
    return start, tuple(moved)
