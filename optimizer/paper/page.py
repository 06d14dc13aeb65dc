"""The recomputed tables as plain data for JSON, and as a page in Markdown."""

from __future__ import annotations

import importlib.metadata
import math
from collections.abc import Callable, Sequence
from typing import Any

from optimizer.paper.evaluation import Evaluation
from optimizer.paper.published import LETTERS, STEP_3_HALF_SIDE_MM, STEP_OF_TABLE, numbers
from optimizer.paper.reproduction import AGREEMENT, METHODS, ReproducedRun, Reproduction
from optimizer.problem.step import SIDE
from optimizer.search import genetic
from optimizer.search.result import finite

SCHEMA = "delta-reproduction/2"
AIMS = {
    1: "Largest half side L (mm) within the reach.",
    2: "Largest half side L (mm) within the reach and the joint torque.",
    3: "Smallest worst condition number over the cube.",
}
NONE = "-"
WITHIN, HALF = f"within {100.0 * AGREEMENT:g} %", "with half the last digit"
READING = (
    "How to read it: *printed* is the paper's number; *follows* is what the printed lengths give by the paper's own "
    "equations: the largest L that they allow with the best H within its bounds, or kappa; *off by* is *printed* "
    f"against *follows*, and two verdicts are given of it: whether it is within {100.0 * AGREEMENT:g} %, and whether "
    "it is with half of the last printed digit added to that; torque and kappa are the printed design's; *ours* are "
    "GA, SQP and GA+SQP under the same bounds (SQP from the paper's start where there is one), *its kappa* is that of "
    "GA+SQP; *proven* is a bound that no design within those bounds can beat; *gap* is how far the printed result is "
    "from that bound, negative where it is beyond it."
)
NOTES = (
    "The proven optima of step 1 lie on the fold H = L_B - L_A with R = r, where upper arm and forearm are in line "
    "above the base's centre. There the condition number has no bound, and a rounding of the printed H or L decides "
    "whether a design keeps its reach.",
    "Torque alone does not see a fold, where it vanishes: the largest cubes of step 2 need a limit on kappa, too.",
    f"The paper prints no L for step 3. {STEP_3_HALF_SIDE_MM:g} mm is taken, half the side of its prototype's cube. "
    "Cubes on the same bottom face contain each other, so that a larger L gives no smaller condition number.",
)
Runs = list[ReproducedRun]


def percent(share: float | None, form: str = ".2f") -> str:
    """Writes a share as a percentage; `NONE` where there is none."""
    return NONE if share is None else f"{100.0 * share:{form}} %"


def record(runs: Runs, made: Reproduction) -> dict[str, Any]:
    """Gathers all facts as plain data for JSON: no number in it is infinite.

    Args:
        runs: The recomputed runs.
        made: What recomputed them.
    """
    rows = {table: [r.record() for r in runs if r.run.table == table] for table in STEP_OF_TABLE}
    return {
        "schema": SCHEMA,
        "source": numbers()["source"],
        "version": importlib.metadata.version("delta-haptics"),
        "seed": made.seed,
        "gap_asked": made.gap,
        "agreement": AGREEMENT,
        "steps": [_step(step, mine) for step in AIMS if (mine := [r for r in runs if r.run.step == step])],
        "table_2": _parameters(made),
        "tables": {
            str(table): {"step": step, "objective": "kappa" if step == 3 else "half_side_mm", "rows": rows[table]}
            for table, step in STEP_OF_TABLE.items()
            if rows[table]
        },
    }


def _step(step: int, runs: Runs) -> dict[str, Any]:
    """Compares the runs of a step with print, and our methods with the proved optimum: the largest differences."""
    off = {
        name: [abs(L / r.proven.objective - 1.0) for r in runs if (L := r.attempts[name].objective) is not None]
        for name in METHODS
    }
    return {
        "step": step,
        "runs": len(runs),
        "results_in_print": sum(r.difference is not None for r in runs),
        "within_agreement": sum(bool(r.within) for r in runs),
        "within_beside_half_last_digit": sum(bool(r.agrees) for r in runs),
        "largest_difference": max((abs(r.difference) for r in runs if r.difference is not None), default=None),
        "largest_gap": max((r.gap for r in runs if r.gap is not None), default=None),
        "feasible_by_proof": sum(r.proven.objective == r.proven.objective for r in runs),
        "off_the_proved_optimum": {name: finite(max(shares, default=math.nan)) for name, shares in off.items()},
    }


def summary(facts: dict[str, Any]) -> str:
    """Writes what came of each step as a table, from what `record` gives."""
    head = ("step", "runs", "results in print", WITHIN, HALF, "off by at most", "gap at most", "feasible by proof")
    rows = []
    for one in facts["steps"]:
        *counts, off, gap, feasible, ours = one.values()
        shares = (percent(share, ".2g") for share in ours.values())
        rows.append([*map(str, counts), percent(off), percent(gap), str(feasible), *shares])
    return markdown_table([*head, *(f"our {name.upper()} off by" for name in METHODS)], rows)


def _parameters(made: Reproduction) -> list[dict[str, Any]]:
    """Gathers table 2: the parameters of the paper's GA and of ours."""
    paper = numbers()["table_2_ga_parameters"]
    ours = [genetic.POPULATIONS[step] if made.population is None else made.population for step in (1, 2, 3)]
    return [
        {"parameter": "population in steps 1, 2, 3", "paper": paper["population"], "ours": ours},
        {"parameter": "variables in steps 1, 2, 3", "paper": paper["variables"], "ours": [6, 6, 3]},
        {"parameter": "crossover fraction", "paper": paper["crossover_fraction"], "ours": genetic.CROSSOVER},
        {"parameter": "migration fraction", "paper": paper["migration_fraction"], "ours": None},
        {"parameter": "generations", "paper": paper["generations"], "ours": made.generations},
    ]


def page(runs: Runs, made: Reproduction) -> str:
    """Writes the page in Markdown; it takes the arguments of `record`."""
    facts = record(runs, made)
    parts = [
        "# The published tables, recomputed",
        f"Source: {facts['source']}. Ours: version {facts['version']}, seed {made.seed}; proofs to a gap of "
        f"{made.gap:g}. Lengths in mm.",
        READING,
        "## Step by step",
        summary(facts),
        "## Table 2: parameters of the genetic algorithm",
        markdown_table(["parameter", "paper", "ours"], [list(map(_value, row.values())) for row in facts["table_2"]]),
        "Ours has one island, so that nothing migrates.",
    ]
    for table, step in STEP_OF_TABLE.items():
        if mine := [r for r in runs if r.run.table == table]:
            cells = [[cell(r) for _, cell in COLUMNS] for r in mine]
            parts += [
                f"## Table {table}: step {step}",
                AIMS[step],
                markdown_table([head for head, _ in COLUMNS], cells),
            ]
            parts += ["\n".join(remarks)] if (remarks := _remarks(mine)) else []
    parts += ["## Notes", "\n".join(f"- {text}" for text in NOTES)]
    return "\n\n".join(parts) + "\n"


def markdown_table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Writes a table in Markdown."""
    return "\n".join("| " + " | ".join(cells) + " |" for cells in (head, ["---"] * len(head), *rows))


def _number(value: float | None, digits: int = 4) -> str:
    return NONE if value is None or value != value else f"{value:.{digits}f}"


def _value(value: Any) -> str:
    if isinstance(value, list):
        return ", ".join(map(str, value))
    if value is None or isinstance(value, bool):
        return {None: NONE, True: "yes", False: "no"}[value]
    return f"{value:g}" if isinstance(value, float) else str(value)


def _of_published(name: str) -> Callable[[ReproducedRun], str]:
    return lambda r: _number(r.published and getattr(r.published, name))


def _of_method(name: str) -> Callable[[ReproducedRun], str]:
    return lambda r: _number(r.attempts[name].objective)


def _lengths(r: ReproducedRun) -> str:
    return NONE if r.run.result is None else ", ".join(f"{r.run.result[k]:g}" for k in (1, 3, 4))


def _bounds(r: ReproducedRun) -> str:
    """Writes the bounds of the lengths that are free."""
    bounds = zip(LETTERS[:SIDE], r.run.lower, r.run.upper, strict=False)
    return ", ".join(f"{letter} {low:g} to {high:g}" for letter, low, high in bounds if low != high)


def _faults(published: Evaluation | None) -> str:
    return "no results" if published is None else ", ".join(map(str, published.faults)) or "yes"


# Heading and cell of each column.
COLUMNS: tuple[tuple[str, Callable[[ReproducedRun], str]], ...] = (
    ("row", lambda r: str(r.run.row)),
    ("method", lambda r: r.run.method),
    ("bounds", _bounds),
    ("L_B, r, H", _lengths),
    ("printed", lambda r: _value(r.run.objective)),
    ("follows: its lengths allow", lambda r: _number(r.follows)),
    ("off by", lambda r: percent(r.difference, "+.2f")),
    (WITHIN, lambda r: _value(r.within)),
    (HALF, lambda r: _value(r.agrees)),
    ("keeps its constraints", lambda r: _faults(r.published)),
    ("torque, N m", _of_published("max_torque_N_m")),
    ("kappa", _of_published("max_kappa")),
    ("kappa, Frobenius", _of_published("max_kappa_frobenius")),
    *((f"our {name.upper()}", _of_method(name)) for name in METHODS),
    ("its kappa", lambda r: _number(finite(r.attempts["ga+sqp"].result.max_kappa))),
    ("proven", lambda r: _number(r.proven.bound, 5)),
    ("gap", lambda r: percent(r.gap)),
)


def _remarks(runs: Runs) -> list[str]:
    """Lists what must be known of runs beside their numbers, each remark once, with its rows."""
    about: dict[str, list[str]] = {}
    for r in runs:
        proven, sqp = r.proven, r.attempts["sqp"]
        texts = [r.run.note, *r.changed]
        if proven.status != "proved":
            gap = f", gap {proven.gap:.1e}" if proven.gap == proven.gap else ""
            texts.append(f"the proof ended with: {proven.status}{gap}")
        if r.exchanged is not None:
            texts.append(f"its H looks exchanged; keeps its constraints with the other row's: {_faults(r.exchanged)}")
        if sqp.start == "paper" and sqp.ending != "converged":
            texts.append(f"SQP from the paper's start: {sqp.ending}")
        for text in filter(None, texts):
            about.setdefault(text, []).append(str(r.run.row))
    return [f"- row{'s' * (len(rows) > 1)} {', '.join(rows)}: {text}" for text, rows in about.items()]
