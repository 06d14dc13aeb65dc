"""Map of an atlas over two axes of numbers: the objective of each step, hatched where a set cannot be met."""

from __future__ import annotations

import io
import math
from collections.abc import Sequence
from typing import Any

import numpy as np
from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from delta_cad.common.picture_style import DPI, RC, styled
from optimizer.study.atlas_file import objective_column
from optimizer.study.cluster import AtlasRow
from optimizer.study.grid import Axis, Grid

CELLS_MAX = 150  # cells up to which each shows its number
TITLES = {
    "half_side": "largest half side, mm",
    "kappa": "smallest worst condition number",
    "cube_side": "largest cube, mm",
    "outline": "least width of the outline, mm",
    "effective_mass": "least effective mass, kg",
    "cost": "least price, EUR by estimate",
}
LARGE = "half_side_mm", "cube_side_mm"  # what is the better the larger it is: ends of columns
COLOURS = ("viridis_r", "viridis")  # bright is good: a large cube, a small condition number
SPAN_MIN = 1e-3  # share of a value by which the colours of a map differ at least: roundings are not painted
TICKS = 12  # labels of an axis at most


def png(grid: Grid, rows: Sequence[AtlasRow]) -> bytes:
    """Draws the map as a PNG file; it takes the arguments of `atlas_map`."""
    picture = io.BytesIO()
    with rc_context(RC):
        atlas_map(grid, rows).savefig(picture, format="png", dpi=DPI, metadata={"Software": None})
    return picture.getvalue()


@styled
def atlas_map(grid: Grid, rows: Sequence[AtlasRow]) -> Figure:
    """Draws the map: one panel a step, the first axis upwards.

    Args:
        grid: A grid that can be `mapped`.
        rows: One for each set.

    Returns:
        The figure, 4.2 inches high.
    """
    titles = {objective_column(s): f"step {s['step']}: {TITLES[s['objective_name']]}" for r in rows for s in r["steps"]}
    titles = titles or {"": "no set can be met"}
    figure = Figure(figsize=(1.6 + 4.6 * len(titles), 4.2), layout="constrained")
    figure.suptitle(f"{grid.name} (hatched: cannot be met)", fontsize=12)
    for ax, (column, title) in zip(figure.subplots(1, len(titles), squeeze=False)[0], titles.items(), strict=True):
        _panel(ax, cells(grid, rows, column), COLOURS[column.endswith(LARGE)])
        for axis, place in zip(grid.axes, (ax.yaxis, ax.xaxis), strict=True):
            _ticks(axis, place)
        ax.set_title(title)
        ax.grid(False)
    return figure


def cells(grid: Grid, rows: Sequence[AtlasRow], column: str) -> np.ndarray:
    """Finds the best objective of each pair of values, over the seeds.

    Args:
        grid: A grid of two axes.
        rows: One for each set.
        column: As `objective_column` names it.

    Returns:
        (values of the first axis, values of the second); NaN where no seed met the step.
    """
    first, second = grid.axes
    best = np.full((len(first.values), len(second.values)), np.nan)
    larger = column.endswith(LARGE)
    for row in rows:
        objectives = [
            step["objective"] for step in row["steps"] if objective_column(step) == column and step["feasible"]
        ]
        if objectives and objectives[0] is not None:
            at = first.values.index(row["inputs"][first.field]), second.values.index(row["inputs"][second.field])
            best[at] = (np.fmax if larger else np.fmin)(best[at], objectives[0])
    return best


def _panel(ax: Axes, values: np.ndarray, colours: str) -> None:
    ax.set_facecolor("0.85")
    ax.patch.set_hatch("//")
    ax.patch.set_edgecolor("0.6")
    ax.set(xlim=(-0.5, values.shape[1] - 0.5), ylim=(-0.5, values.shape[0] - 0.5))
    if not np.isfinite(values).any():
        return
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    room = max(0.0, SPAN_MIN * abs(high) - (high - low)) / 2.0
    shown: Any = ax.imshow(values, origin="lower", aspect="auto", cmap=colours, vmin=low - room, vmax=high + room)
    ax.figure.colorbar(shown, ax=ax)
    for (i, j), value in np.ndenumerate(values if values.size <= CELLS_MAX else np.empty((0, 0))):
        if math.isfinite(value):
            red, green, blue, _ = shown.cmap(shown.norm(value))
            dark = 0.3 * red + 0.59 * green + 0.11 * blue < 0.5
            ax.text(j, i, f"{value:.4g}", ha="center", va="center", fontsize=7, color="white" if dark else "black")


def _ticks(axis: Axis, place: Any) -> None:
    at = range(0, len(axis.values), math.ceil(len(axis.values) / TICKS))
    place.set_ticks(list(at), [f"{axis.values[k]:.4g}" for k in at])
    place.set_label_text(axis.field)
