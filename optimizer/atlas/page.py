"""The page of an atlas: what was asked, how many sets can be met, the table, and a map where two numbers vary."""

from __future__ import annotations

import io
import math
from collections import Counter
from collections.abc import Sequence
from typing import Any

import numpy as np

from optimizer.atlas.atlas import AtlasRow
from optimizer.atlas.file import flat, objective_column
from optimizer.atlas.grid import Axis, Grid

LINES_MAX = 500
"""Rows of the table on the page; all are in the CSV."""
CELLS_MAX = 150
"""Up to which each cell of a map shows its number."""
TITLES = {"half_side": "largest half side, mm", "kappa": "smallest worst condition number"}
COLOURS = ("viridis", "viridis_r")  # bright is good: a large half side, a small condition number
SPAN_MIN = 1e-3
"""Share of a value by which a map's colours differ at least: roundings are not painted."""
LEFT_OUT = ("method", "conflict_step", "ending", "seconds")
"""Columns of the CSV that the page spares."""


def page(grid: Grid, rows: Sequence[AtlasRow], picture: str | None) -> str:
    """The atlas as Markdown.

    Args:
        grid: What was asked.
        rows: One for each set, by their index.
        picture: File name of the map; None without one.
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
        lines += ["What cannot be met together, and in how many sets: "]
        lines[-1] += "; ".join(f"{reason} ({count})" for reason, count in reasons.most_common()) + "."
        lines.append("")
    if picture is not None:
        lines += [f"![{grid.name}]({picture})", ""]
    table = [{name: value for name, value in line.items() if name not in LEFT_OUT} for line in flat(rows)]
    columns = list(dict.fromkeys(name for line in sorted(table, key=len, reverse=True) for name in line))
    lines += [f"| {' | '.join(columns)} |", "|" + "---|" * len(columns)]
    lines += [f"| {' | '.join(_text(line.get(name)) for name in columns)} |" for line in table[:LINES_MAX]]
    if len(table) > LINES_MAX:
        lines += ["", f"The first {LINES_MAX} of {len(table)} rows; all are in atlas.csv."]
    return "\n".join(lines) + "\n"


def mapped(grid: Grid) -> bool:
    """Tells whether the grid can be drawn: two axes of numbers, at least two of each."""
    return len(grid.axes) == 2 and all(
        len(axis.values) > 1 and not any(isinstance(value, list) for value in axis.values) for axis in grid.axes
    )


def cells(grid: Grid, rows: Sequence[AtlasRow], column: str) -> np.ndarray:
    """Best objective of each pair of values, over the seeds.

    Args:
        grid: Of two axes.
        rows: One for each set.
        column: As `objective_column` names it.

    Returns:
        (values of the first axis, values of the second); NaN where no seed met the step.
    """
    first, second = grid.axes
    best = np.full((len(first.values), len(second.values)), np.nan)
    smaller = column.endswith("kappa")
    for row in rows:
        found = [step["objective"] for step in row["steps"] if objective_column(step) == column and step["feasible"]]
        if found and found[0] is not None:
            at = first.values.index(row["inputs"][first.field]), second.values.index(row["inputs"][second.field])
            best[at] = (np.fmin if smaller else np.fmax)(best[at], found[0])
    return best


def draw(grid: Grid, rows: Sequence[AtlasRow]) -> bytes:
    """Draws the map: one panel a step, the first axis upwards, hatched where the set cannot be met.

    Args:
        grid: That can be `mapped`.
        rows: One for each set.

    Returns:
        The picture, a PNG.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    columns = list(dict.fromkeys(objective_column(step) for row in rows for step in row["steps"]))
    titles = {objective_column(s): f"step {s['step']}: {TITLES[s['objective_name']]}" for r in rows for s in r["steps"]}
    if not columns:
        columns, titles = [""], {"": "no set can be met"}
    first, second = grid.axes
    figure = Figure(figsize=(1.6 + 4.6 * len(columns), 4.2), layout="constrained")
    FigureCanvasAgg(figure)
    for k, column in enumerate(columns):
        values = cells(grid, rows, column)
        axes = figure.add_subplot(1, len(columns), k + 1)
        axes.set_facecolor("0.85")
        axes.patch.set_hatch("//")
        axes.patch.set_edgecolor("0.6")
        if np.isfinite(values).any():
            low, high = _range(values)
            colours = COLOURS["kappa" in column]
            shown = axes.imshow(values, origin="lower", aspect="auto", cmap=colours, vmin=low, vmax=high)
            figure.colorbar(shown, ax=axes)
            if values.size <= CELLS_MAX:
                _write(axes, values, shown)
        else:
            axes.set_xlim(-0.5, values.shape[1] - 0.5)
            axes.set_ylim(-0.5, values.shape[0] - 0.5)
        _ticks(axes, first, second)
        axes.set_title(titles[column], fontsize=9)
    figure.suptitle(f"{grid.name} (hatched: cannot be met)", fontsize=10)
    picture = io.BytesIO()
    figure.savefig(picture, format="png", dpi=130)
    return picture.getvalue()


def _range(values: np.ndarray) -> tuple[float, float]:
    """Ends of the colours."""
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    room = max(0.0, SPAN_MIN * abs(high) - (high - low)) / 2.0
    return low - room, high + room


def _ticks(axes: Any, first: Axis, second: Axis) -> None:
    for axis, place in ((first, axes.yaxis), (second, axes.xaxis)):
        step = math.ceil(len(axis.values) / 12)
        at = range(0, len(axis.values), step)
        place.set_ticks(list(at), [f"{axis.values[k]:.4g}" for k in at])
        place.set_label_text(axis.field, fontsize=8)
    axes.tick_params(labelsize=8)


def _write(axes: Any, values: np.ndarray, shown: Any) -> None:
    for (i, j), value in np.ndenumerate(values):
        if math.isfinite(value):
            red, green, blue, _ = shown.cmap(shown.norm(value))
            dark = 0.3 * red + 0.59 * green + 0.11 * blue < 0.5
            axes.text(j, i, f"{value:.4g}", ha="center", va="center", fontsize=7, color="white" if dark else "black")


def _text(value: Any) -> str:
    if value is None:
        return ""
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, list):
        return "[" + ", ".join(_text(v) for v in value) + "]"
    return f"{value:.5g}" if isinstance(value, float) else str(value)
