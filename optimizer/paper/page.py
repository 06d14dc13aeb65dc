"""The recomputed tables as plain data for JSON, and as a page in Markdown."""

from __future__ import annotations

import importlib.metadata
import math
from collections.abc import Callable, Sequence
from pathlib import Path
from string import Template
from typing import Any

from optimizer.paper.placed import PlacedStep, section
from optimizer.paper.published import LETTERS, STEP_3_HALF_SIDE_MM, STEP_OF_TABLE, numbers
from optimizer.paper.reproduction import AGREEMENT, METHODS, ReproducedRun, Reproduction
from optimizer.problem.step import SIDE
from optimizer.search import genetic
from optimizer.search.result import finite

_SCHEMA = "delta-reproduction/2"
_AIMS = {
    1: "Largest half side L (mm) within the reach.",
    2: "Largest half side L (mm) within the reach and the joint torque.",
    3: "Smallest worst condition number over the cube.",
}
NONE = "-"
_PLACED = "## Step 1 with the placement free"
_WITHIN, _HALF = f"within {100.0 * AGREEMENT:g} %", "with half the last digit"
_Runs = list[ReproducedRun]
_Facts = dict[str, Any]


def _percent(share: float | None, form: str = ".2f") -> str:
    """Writes a share as a percentage; `NONE` where there is none."""
    return NONE if share is None else f"{100.0 * share:{form}} %"


def record(runs: _Runs, made: Reproduction, placed: PlacedStep | None = None) -> _Facts:
    """Gathers all facts as plain data for JSON: no number in it is infinite.

    Args:
        runs: Recomputed.
        made: How.
        placed: Step 1 with the placement free; None where it was not computed.
    """
    rows = {table: [r.record() for r in runs if r.run.table == table] for table in STEP_OF_TABLE}
    return {
        "schema": _SCHEMA,
        "source": numbers()["source"],
        "version": importlib.metadata.version("delta-haptics"),
        "seed": made.seed,
        "gap_asked": made.gap,
        "agreement": AGREEMENT,
        "steps": [_step(step, mine) for step in _AIMS if (mine := [r for r in runs if r.run.step == step])],
        "table_2": _parameters(made),
        "tables": {
            str(table): {"step": step, "objective": "kappa" if step == 3 else "half_side_mm", "rows": rows[table]}
            for table, step in STEP_OF_TABLE.items()
            if rows[table]
        },
        **({} if placed is None else {"step_1_placed": placed.record()}),
    }


def _step(step: int, runs: _Runs) -> _Facts:
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


def summary(facts: _Facts) -> str:
    """Writes what came of each step as a table, from what `record` gives."""
    head = ("step", "runs", "results in print", _WITHIN, _HALF, "off by at most", "gap at most", "feasible by proof")
    rows = []
    for one in facts["steps"]:
        *counts, off, gap, feasible, own = one.values()
        shares = (_percent(share, ".2g") for share in own.values())
        rows.append([*map(str, counts), _percent(off), _percent(gap), str(feasible), *shares])
    return markdown_table([*head, *(f"our {name.upper()} off by" for name in METHODS)], rows)


def _parameters(made: Reproduction) -> list[dict[str, Any]]:
    """Gathers table 2: the parameters of the paper's GA and of ours."""
    paper = numbers()["table_2_ga_parameters"]
    own = [genetic.POPULATIONS[step] if made.population is None else made.population for step in (1, 2, 3)]
    return [
        {"parameter": "population in steps 1, 2, 3", "paper": paper["population"], "ours": own},
        {"parameter": "variables in steps 1, 2, 3", "paper": paper["variables"], "ours": [6, 6, 3]},
        {"parameter": "crossover fraction", "paper": paper["crossover_fraction"], "ours": genetic.CROSSOVER},
        {"parameter": "migration fraction", "paper": paper["migration_fraction"], "ours": None},
        {"parameter": "generations", "paper": paper["generations"], "ours": made.generations},
    ]


def page(facts: _Facts) -> str:
    """Writes the page in Markdown, from what `record` gives."""
    parts = []
    for number, table in facts["tables"].items():
        cells = [[cell(row) for _, cell in COLUMNS] for row in table["rows"]]
        parts += [f"## Table {number}: step {table['step']}", _AIMS[table["step"]]]
        parts += [markdown_table([head for head, _ in COLUMNS], cells)]
        parts += ["\n".join(remarks)] if (remarks := _remarks(table["rows"])) else []
    return Template(Path(__file__).with_suffix(".md").read_text(encoding="utf-8")).substitute(
        source=facts["source"],
        version=facts["version"],
        seed=facts["seed"],
        gap=f"{facts['gap_asked']:g}",
        within=_WITHIN,
        summary=summary(facts),
        parameters=markdown_table(
            ["parameter", "paper", "ours"], [list(map(_value, row.values())) for row in facts["table_2"]]
        ),
        tables="\n\n".join(parts),
        placed=f"{_PLACED}\n\n{section(facts['step_1_placed'])}\n\n" if "step_1_placed" in facts else "",
        half_side=f"{STEP_3_HALF_SIDE_MM:g}",
    )


def markdown_table(head: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """Writes a table in Markdown."""
    return "\n".join("| " + " | ".join(cells) + " |" for cells in (head, ["---"] * len(head), *rows))


def _number(value: float | None, digits: int = 4) -> str:
    return NONE if value is None else f"{value:.{digits}f}"


def _value(value: Any) -> str:
    if isinstance(value, list):
        return ", ".join(map(str, value))
    if value is None or isinstance(value, bool):
        return {None: NONE, True: "yes", False: "no"}[value]
    return f"{value:g}" if isinstance(value, float) else str(value)


def _of_published(name: str) -> Callable[[_Facts], str]:
    return lambda row: _number(row["by_our_equations"] and row["by_our_equations"][name])


def _lengths(row: _Facts) -> str:
    printed = list((row["printed"] or {}).values())
    return ", ".join(f"{printed[k]:g}" for k in (1, 3, 4)) if printed else NONE


def _bounds(row: _Facts) -> str:
    """Writes the bounds of the lengths that are free."""
    bounds = zip(LETTERS[:SIDE], row["lower"].values(), row["upper"].values(), strict=False)
    return ", ".join(f"{letter} {low:g} to {high:g}" for letter, low, high in bounds if low != high)


def _faults(evaluation: _Facts | None) -> str:
    if evaluation is None:
        return "no results"
    faults = (f"{f['name']} missed by {f['by']:.3g} {f['unit']}".strip() for f in evaluation["faults"])
    return ", ".join(faults) or "yes"


# Heading and cell of each column.
COLUMNS: tuple[tuple[str, Callable[[_Facts], str]], ...] = (
    ("row", lambda row: str(row["row"])),
    ("method", lambda row: row["method"]),
    ("bounds", _bounds),
    ("L_B, r, H", _lengths),
    ("printed", lambda row: _value(row["printed_objective"])),
    ("follows: its lengths allow", lambda row: _number(row["follows"])),
    ("off by", lambda row: _percent(row["difference"], "+.2f")),
    (_WITHIN, lambda row: _value(row["within_agreement"])),
    (_HALF, lambda row: _value(row["within_beside_half_last_digit"])),
    ("keeps its constraints", lambda row: _faults(row["by_our_equations"])),
    ("torque, N m", _of_published("max_torque_N_m")),
    ("kappa", _of_published("max_kappa")),
    ("kappa, Frobenius", _of_published("max_kappa_frobenius")),
    *((f"our {name.upper()}", lambda row, name=name: _number(row["found"][name]["objective"])) for name in METHODS),
    ("its kappa", lambda row: _number(row["found"]["ga+sqp"]["max_kappa"])),
    ("proven", lambda row: _number(row["proven"]["bound"], 5)),
    ("gap", lambda row: _percent(row["gap"])),
)


def _remarks(rows: list[_Facts]) -> list[str]:
    """Lists remarks on runs, each once with its rows."""
    about: dict[str, list[str]] = {}
    for row in rows:
        proven, sqp = row["proven"], row["found"]["sqp"]
        texts = [row["note"], *row["changed"]]
        if proven["status"] != "proved":
            gap = "" if proven["gap"] is None else f", gap {proven['gap']:.1e}"
            texts.append(f"the proof ended with: {proven['status']}{gap}")
        if row["with_H_exchanged"] is not None:
            faults = _faults(row["with_H_exchanged"])
            texts.append(f"its H looks exchanged; keeps its constraints with the other row's: {faults}")
        if sqp["start"] == "paper" and sqp["ending"] != "converged":
            texts.append(f"SQP from the paper's start: {sqp['ending']}")
        for text in filter(None, texts):
            about.setdefault(text, []).append(str(row["row"]))
    return [f"- row{'s' * (len(rows) > 1)} {', '.join(rows)}: {text}" for text, rows in about.items()]
