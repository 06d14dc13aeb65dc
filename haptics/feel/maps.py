"""Maps of a figure over three horizontal slices of the cube. Importing this module loads matplotlib."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from delta_cad.common.picture_style import styled

HEIGHTS = ("bottom", "middle", "top")
FILL, LINES, EVEN = 48, 6, 0.02
WIDE = 5.0  # Ratio of the largest to the smallest value from which the scale is logarithmic
FLAT = 0.1  # Least range of the scale as a share of the values: what varies less looks even, as it feels


@styled
def feel_map(
    title: str, label: str, x_mm: np.ndarray, y_mm: np.ndarray, z_mm: np.ndarray, values: np.ndarray, small: bool
) -> Figure:
    """Draws a figure over the bottom, middle and top of the cube, all with one scale; light is good.

    Args:
        title: What it is.
        label: Label of the scale, with the unit.
        x_mm: (nx,) places.
        y_mm: (ny,) places.
        z_mm: (3,) heights.
        values: (3, ny, nx) in the unit of the label.
        small: Whether less is better: then the scale is turned round, so that light is good everywhere.

    Returns:
        The figure, 11 x 4.5 inches.
    """
    figure = Figure(figsize=(11.0, 4.5), layout="constrained")
    figure.suptitle(title, fontsize=12)
    low, high = float(values.min()), float(values.max())
    missing = max(FLAT * max(abs(low), abs(high)) - (high - low), 0.0)
    if missing > 0.0 or high == low:
        low, high = low - missing / 2.0 - 1e-12, high + missing / 2.0 + 1e-12
    wide = low > 0.0 and high > WIDE * low
    levels = np.geomspace(low, high, FILL + 1) if wide else np.linspace(low, high, FILL + 1)
    scale = LogNorm(low, high) if wide else Normalize(low, high)
    axes = figure.subplots(1, 3, sharex=True, sharey=True)
    colours = "viridis_r" if small else "viridis"
    filled = [ax.contourf(x_mm, y_mm, values[k], levels=levels, cmap=colours, norm=scale) for k, ax in enumerate(axes)]
    for k, ax in enumerate(axes):
        least, most = float(values[k].min()), float(values[k].max())
        if most - least > EVEN * max(abs(most), abs(least)):  # else lines would speak of nothing
            steps = MaxNLocator(LINES).tick_values(least, most)
            lines = ax.contour(x_mm, y_mm, values[k], levels=steps, colors="black", linewidths=0.6)
            for text in ax.clabel(lines, fontsize=8, fmt="%g"):
                text.set_bbox({"facecolor": "white", "edgecolor": "none", "alpha": 0.75, "pad": 0.6})
        ax.plot(0.0, 0.0, marker="+", color="white", markeredgewidth=2.2, markersize=9)
        ax.plot(0.0, 0.0, marker="+", color="black", markersize=8)
        ax.set_title(f"{HEIGHTS[k]}, z = {z_mm[k]:.1f} mm\n{least:.4g} to {most:.4g}")
        ax.set(xlabel="x, mm", aspect="equal")
        ax.grid(visible=False)
    axes[0].set_ylabel("y, mm")
    ticks: Any = MaxNLocator(7)
    if wide:
        round_ones = [float(f"{value:.2g}") for value in np.geomspace(low, high, 7)]
        ticks = [value for value in round_ones if low <= value <= high]
    bar = figure.colorbar(filled[0], ax=axes, shrink=0.9, pad=0.015, ticks=ticks, format="%g")
    bar.ax.minorticks_off()
    bar.set_label(label)
    if small:
        bar.ax.invert_yaxis()  # good is up
    return figure
