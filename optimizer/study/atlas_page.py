"""The page of an atlas: its grid, how many sets can be met, and the table."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from typing import Any

from optimizer.paper.page import markdown_table
from optimizer.study.atlas_file import DESIGNS, flat
from optimizer.study.cluster import AtlasRow
from optimizer.study.grid import Grid

LINES_MAX = 500  # rows of the table on the page; all are in the CSV
LEFT_OUT = ("method", "conflict_step", "ending", "seconds")  # columns of the CSV that the page spares


def page(grid: Grid, rows: Sequence[AtlasRow], picture: str | None, folder: str) -> str:
    """Writes the atlas as Markdown.

    Args:
        grid: The grid.
        rows: One for each set, by their index.
        picture: File name of the map; None without one.
        folder: Where the files stand, as commands name it.
    """
    met = sum(row["feasible"] for row in rows)
    reasons = Counter(" and ".join(row["conflict"]) for row in rows if row["conflict"])
    lines = [
        f"# Atlas {grid.name}",
        "",
        f"{len(rows)} sets by `{rows[0]['method']}`; {met} are met, {len(rows) - met} are not.",
        "",
        *(f"- `{axis.field}`: {', '.join(_text(value) for value in axis.values)}" for axis in grid.axes),
        f"- seeds: {', '.join(str(seed) for seed in dict.fromkeys(row['seed'] for row in rows))}",
        "",
    ]
    if reasons:
        counted = "; ".join(f"{reason} ({count})" for reason, count in reasons.most_common())
        lines += [f"What cannot be met together, and in how many sets: {counted}.", ""]
    if picture is not None:
        lines += [f"![{grid.name}]({picture})", ""]
    if any(row.get("machine") for row in rows):
        lines += [
            "Each machine passed the closed forms of its parts, with masses of solids of its hardware; what moves is",
            f"seen to when it is built: `python -m delta_cad build --design {folder}/{DESIGNS}/set-N.json`.",
            "",
        ]
    lines += [
        f"- set {row['index']} has none: {row['message']}" for row in rows if "machine" in row and not row["machine"]
    ]
    lines += [""] if lines[-1] else []
    table = [{name: value for name, value in line.items() if name not in LEFT_OUT} for line in flat(rows)]
    columns = list(dict.fromkeys(name for line in sorted(table, key=len, reverse=True) for name in line))
    cells = [[_text(line.get(name)) for name in columns] for line in table[:LINES_MAX]]
    lines.append(markdown_table(columns, cells))
    if len(table) > LINES_MAX:
        lines += ["", f"The first {LINES_MAX} of {len(table)} rows; all are in atlas.csv."]
    return "\n".join(lines) + "\n"


def mapped(grid: Grid) -> bool:
    """Tells whether the grid can be drawn: two axes of numbers, at least two of each."""
    return len(grid.axes) == 2 and all(
        len(axis.values) > 1 and not any(isinstance(value, list | str) for value in axis.values) for axis in grid.axes
    )


def _text(value: Any) -> str:
    if value is None:
        return ""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, list):
        return "[" + ", ".join(_text(v) for v in value) + "]"
    return f"{value:.5g}" if isinstance(value, float) else str(value)
