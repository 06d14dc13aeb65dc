"""Files of an atlas: rows as they arrive, so that a killed run can be taken up, and the table as CSV and JSON."""

from __future__ import annotations

import csv
import io
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from delta_cad.common.refusal import as_cell
from optimizer.study.cluster import AtlasRow
from optimizer.study.grid import Grid
from optimizer.synthesis.checkpoint import Records

SCHEMA = "delta-atlas/1"
DESIGNS = "designs"
UNITS = {"half_side": "_mm", "cube_side": "_mm", "outline": "_mm", "effective_mass": "_kg", "cost": "_EUR"}
FIELDS = {"index", "inputs", "method", "seed", "feasible", "steps", "conflict", "conflict_step", "message", "seconds"}


class RowFile(Records):
    """The rows of an atlas in a file, appended as they arrive in any order.

    Attributes:
        rows: Index of the set -> its row.
    """

    OTHER = "is of another atlas: its grid differs"

    def __init__(self, path: Path, key: dict[str, Any], resume: bool) -> None:
        """Opens the file; see `Records`."""
        self.rows: dict[int, AtlasRow] = {}
        super().__init__(path, key, resume)

    def take(self, record: dict[str, Any]) -> None:
        """Takes up a row."""
        if not record.keys() >= FIELDS:
            raise KeyError
        self.rows[int(record["index"])] = record

    def add(self, row: AtlasRow) -> None:
        """Keeps one more row."""
        self.rows[row["index"]] = row
        self.append(row)


def record(grid: Grid, rows: Sequence[AtlasRow]) -> dict[str, Any]:
    """Gathers the atlas as plain data for JSON.

    Args:
        grid: The grid.
        rows: One for each set, by their index.
    """
    return {
        "schema": SCHEMA,
        "name": grid.name,
        "grid_sha256": grid.sha256,
        "axes": [{"field": axis.field, "values": list(axis.values)} for axis in grid.axes],
        "rows": list(rows),
    }


def flat(rows: Sequence[AtlasRow]) -> list[dict[str, Any]]:
    """Lays rows out as columns: inputs, seed, method, what contradicts, each step's objective, the last step's design.

    Args:
        rows: One for each set; what infeasible ones have not is left empty.
    """
    table = []
    for row in rows:
        line: dict[str, Any] = {"set": row["index"]}
        line |= {field: _plain(value) for field, value in row["inputs"].items()}
        line |= {"seed": row["seed"], "method": row["method"], "feasible": row["feasible"]}
        line |= {"conflict": " ".join(row["conflict"]), "conflict_step": row["conflict_step"]}
        line |= row.get("machine") or {}
        line |= {objective_column(step): step["objective"] for step in row["steps"]}
        if row["steps"]:
            last = row["steps"][-1]
            line |= last["variables"] | {"max_torque_N_m": last["max_torque_N_m"], "max_kappa": last["max_kappa"]}
            line |= {"ending": last["status"]}
        table.append(line | {"seconds": row["seconds"]})
    return table


def objective_column(step: dict[str, Any]) -> str:
    """Names the column of a step's objective."""
    name = step["objective_name"]
    return f"step_{step['step']}_{name}{UNITS.get(name, '')}"


def design_files(rows: Sequence[AtlasRow]) -> dict[str, str]:
    """Gives name and text of the design file of every machine."""
    return {f"{DESIGNS}/set-{row['index']}.json": row["design"] for row in rows if row.get("machine")}


def csv_text(rows: Sequence[AtlasRow]) -> str:
    """Writes the table as CSV; columns that only some rows have stand where the first of these has them."""
    table = flat(rows)
    fullest = max(table, key=len)
    columns = list(fullest) + [name for name in dict.fromkeys(n for line in table for n in line) if name not in fullest]
    out = io.StringIO()
    writer = csv.DictWriter(out, columns, lineterminator="\n")
    writer.writeheader()
    writer.writerows({name: "" if value is None else as_cell(value) for name, value in line.items()} for line in table)
    return out.getvalue()


def _plain(value: Any) -> Any:
    return " to ".join(f"{v:g}" for v in value) if isinstance(value, list) else value
