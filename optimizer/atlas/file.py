"""Files of an atlas: rows as they arrive, so that a killed run can be taken up, and the table as CSV and JSON."""

from __future__ import annotations

import csv
import io
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any, TextIO

from optimizer.atlas.atlas import Row
from optimizer.atlas.grid import Grid
from optimizer.synthesis.checkpoint import CheckpointError

SCHEMA = "delta-atlas/1"


class Rows:
    """Rows in a file: first the atlas's key, then a row a line. A line that a kill cut off is dropped.

    Attributes:
        found: Index of the set -> its row.
    """

    def __init__(self, path: Path, key: dict[str, Any], resume: bool) -> None:
        """Opens the file.

        Args:
            path: The file.
            key: What makes an atlas the same atlas.
            resume: Whether to take up what the file holds; else it is begun anew.

        Raises:
            CheckpointError: The file is of another atlas, or none at all.
            OSError: It cannot be read or written.
        """
        self.found: dict[int, Row] = {}
        self._path = path
        if resume and path.exists():
            text = path.read_text(encoding="utf-8", errors="replace")
            self._take_up(text[: text.rfind("\n") + 1].splitlines(), key)
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("".join(_line(item) for item in ({"key": key}, *self.found.values())), encoding="utf-8")
        self._file: TextIO = path.open("a", encoding="utf-8")

    def add(self, row: Row) -> None:
        """Keeps one more."""
        self.found[row["index"]] = row
        self._file.write(_line(row))
        self._file.flush()

    def close(self) -> None:
        """Closes the file and leaves it."""
        self._file.close()

    def remove(self) -> None:
        """Closes the file and takes it away: the atlas is written."""
        self.close()
        self._path.unlink(missing_ok=True)

    def _take_up(self, lines: list[str], key: dict[str, Any]) -> None:
        try:
            records = [json.loads(line) for line in lines]
            if records and records[0]["key"] != key:
                raise CheckpointError(
                    f"{self._path.name}: is of another atlas: its grid differs; run without --resume to begin anew"
                )
            self.found = {record["index"]: record for record in records[1:]}
        except (json.JSONDecodeError, KeyError, TypeError):
            raise CheckpointError(f"{self._path.name}: is no checkpoint of an atlas") from None


def record(grid: Grid, rows: Sequence[Row]) -> dict[str, Any]:
    """The atlas as JSON types.

    Args:
        grid: What was asked.
        rows: One for each set, by their index.
    """
    return {
        "schema": SCHEMA,
        "name": grid.name,
        "grid_sha256": grid.sha256,
        "axes": [{"field": axis.field, "values": list(axis.values)} for axis in grid.axes],
        "rows": list(rows),
    }


def flat(rows: Sequence[Row]) -> list[dict[str, Any]]:
    """Rows as columns: inputs, seed, method, feasible, what contradicts, each step's objective, the last step's design.

    Args:
        rows: One for each set; what infeasible ones have not is left empty.
    """
    table = []
    for row in rows:
        line: dict[str, Any] = {"set": row["index"]}
        line |= {field: _plain(value) for field, value in row["inputs"].items()}
        line |= {"seed": row["seed"], "method": row["method"], "feasible": row["feasible"]}
        line |= {"conflict": " ".join(row["conflict"]), "conflict_step": row["conflict_step"]}
        line |= {objective_column(step): step["objective"] for step in row["steps"]}
        if row["steps"]:
            last = row["steps"][-1]
            line |= last["variables"] | {"max_torque_N_m": last["max_torque_N_m"], "max_kappa": last["max_kappa"]}
            line |= {"ending": last["status"]}
        table.append(line | {"seconds": row["seconds"]})
    return table


def objective_column(step: dict[str, Any]) -> str:
    """Name of the column of a step's objective."""
    unit = "_mm" if step["objective_name"] == "half_side" else ""
    return f"step_{step['step']}_{step['objective_name']}{unit}"


def csv_text(rows: Sequence[Row]) -> str:
    """The table as CSV, with a header; columns that only some rows have stand where the first of these has them."""
    table = flat(rows)
    fullest = max(table, key=len)
    columns = list(fullest) + [name for name in dict.fromkeys(n for line in table for n in line) if name not in fullest]
    out = io.StringIO()
    writer = csv.DictWriter(out, columns, lineterminator="\n")
    writer.writeheader()
    writer.writerows({name: "" if value is None else value for name, value in line.items()} for line in table)
    return out.getvalue()


def write_text(path: Path, text: str) -> None:
    """Writes a file whole or not at all: beside its place, then renamed."""
    partial = path.with_name(path.name + ".part")
    partial.write_text(text, encoding="utf-8")
    partial.replace(path)


def _plain(value: Any) -> Any:
    return " to ".join(f"{v:g}" for v in value) if isinstance(value, list) else value


def _line(item: dict[str, Any]) -> str:
    return json.dumps(item, separators=(",", ":"), allow_nan=False) + "\n"
