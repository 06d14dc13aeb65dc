"""The recomputed tables as plain data: what the JSON file holds, verdicts and notes included, and the page shows."""

from __future__ import annotations

import importlib.metadata
import math
from typing import Any

from optimizer.paper.cases import LETTERS, STEP_OF_TABLE, Lengths, numbers
from optimizer.paper.judgement import Judged
from optimizer.paper.runs import AGREEMENT, Recomputed, Reproduction
from optimizer.paper.words import notes, summary, verdict
from optimizer.problem.evaluator import VARIABLES
from optimizer.problem.step import SIDE
from optimizer.search import genetic

SCHEMA = "delta-reproduction/1"
Facts = dict[str, Any]


def facts(rows: list[Recomputed], run: Reproduction) -> Facts:
    """All that was found.

    Args:
        rows: The recomputed runs.
        run: What recomputed them.

    Returns:
        Plain data for JSON: no number in it is infinite.
    """
    told = {table: [_row(row) for row in rows if row.case.table == table] for table in STEP_OF_TABLE}
    return {
        "schema": SCHEMA,
        "source": numbers()["source"],
        "version": importlib.metadata.version("delta-haptics"),
        "seed": run.seed,
        "gap_asked": run.gap,
        "agreement": AGREEMENT,
        "summary": summary(rows),
        "verdict": verdict(rows),
        "table_2": _parameters(run),
        "tables": {
            str(table): {"step": step, "objective": "kappa" if step == 3 else "half_side_mm", "rows": told[table]}
            for table, step in STEP_OF_TABLE.items()
            if told[table]
        },
        "notes": notes(rows),
    }


def lengths(design: Lengths | None) -> dict[str, float] | None:
    """Names of the lengths -> mm."""
    return None if design is None else {f"{n}_mm": v for n, v in zip(VARIABLES, design, strict=True)}


def _row(r: Recomputed) -> Facts:
    p = r.proven
    return {
        "row": r.case.row,
        "method": r.case.method,
        "lower": lengths(r.case.lower),
        "upper": lengths(r.case.upper),
        "start": lengths(r.case.start),
        "changed": list(r.changed),
        "note": r.case.note,
        "printed": lengths(r.case.result),
        "printed_objective": r.case.objective,
        "by_our_equations": _judged(r.published),
        "with_H_exchanged": _judged(r.exchanged),
        "follows": r.follows,
        "difference": r.difference,
        "within_agreement": r.within,
        "within_beside_half_last_digit": r.agrees,
        "gap": r.gap,
        "found": {
            f.method: {
                "start": f.start,
                "objective": f.objective,
                "variables": lengths(f.design_mm),
                "max_kappa": f.kappa,
                "max_torque_N_m": f.torque_N_m,
                "ending": f.ending,
                "evaluations": f.evaluations,
            }
            for f in r.found
        },
        "proven": {
            "objective": _finite(p.objective),
            "bound": _finite(p.bound),
            "gap": _finite(p.gap),
            "status": p.status,
            "boxes": p.boxes,
            "variables": lengths(p.design_mm or None),
        },
    }


def _judged(judged: Judged | None) -> Facts | None:
    if judged is None:
        return None
    return {
        "keeps_its_constraints": not judged.faults,
        "faults": [{"name": f.name, "by": f.by, "unit": f.unit} for f in judged.faults],
        "largest_half_side_mm": judged.largest_mm,
        "max_kappa": judged.kappa,
        "max_kappa_frobenius": judged.kappa_frobenius,
        "max_torque_N_m": judged.torque_N_m,
    }


def _parameters(run: Reproduction) -> list[Facts]:
    """Table 2: the paper's GA and ours."""
    paper = numbers()["table_2_ga_parameters"]
    ours = [genetic.POPULATIONS[step] if run.population is None else run.population for step in (1, 2, 3)]
    generations = genetic.GENERATIONS if run.generations is None else run.generations
    return [
        {"parameter": "population in steps 1, 2, 3", "paper": paper["population"], "ours": ours},
        {"parameter": "variables in steps 1, 2, 3", "paper": paper["variables"], "ours": [6, 6, 3]},
        {"parameter": "crossover fraction", "paper": paper["crossover_fraction"], "ours": genetic.CROSSOVER},
        {"parameter": "migration fraction", "paper": paper["migration_fraction"], "ours": None},
        {"parameter": "generations", "paper": paper["generations"], "ours": generations},
    ]


def free_bounds(row: Facts) -> str:
    """The bounds of the lengths that are free, in words."""
    parts = []
    for letter, name in zip(LETTERS, VARIABLES, strict=True):
        low, high = row["lower"][f"{name}_mm"], row["upper"][f"{name}_mm"]
        if low != high and name != VARIABLES[SIDE]:
            parts.append(f"{letter} {low:g} to {high:g}")
    return ", ".join(parts)


def _finite(value: float) -> float | None:
    return value if math.isfinite(value) else None
