"""Maps of a figure over three slices of the cube, Z-width as K-B planes, range of impedance. Loads matplotlib."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import LogNorm, Normalize
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator, NullLocator

from delta_cad.common.picture_style import BLUE, GREEN, ORANGE, VERMILLION, styled
from haptics.feel.loops import LoopSheet, Plane
from haptics.loop.walls import NOBODY

HEIGHTS = ("bottom", "middle", "top")
_FILL, _LINES, _EVEN = 48, 6, 0.02
_WIDE = 5.0  # Ratio of the largest to the smallest value from which the scale is logarithmic
_FLAT = 0.1  # Least range of the scale as a share of the values: what varies less looks even, as it feels


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
    """
    figure = Figure(figsize=(11.0, 4.5), layout="constrained")
    figure.suptitle(title, fontsize=12)
    low, high = float(values.min()), float(values.max())
    missing = max(_FLAT * max(abs(low), abs(high)) - (high - low), 0.0)
    if missing > 0.0 or high == low:
        low, high = low - missing / 2.0 - 1e-12, high + missing / 2.0 + 1e-12
    wide = low > 0.0 and high > _WIDE * low
    levels = np.geomspace(low, high, _FILL + 1) if wide else np.linspace(low, high, _FILL + 1)
    scale = LogNorm(low, high) if wide else Normalize(low, high)
    axes = figure.subplots(1, 3, sharex=True, sharey=True)
    middle = (x_mm[0] + x_mm[-1]) / 2.0, (y_mm[0] + y_mm[-1]) / 2.0
    colours = "viridis_r" if small else "viridis"
    filled = [ax.contourf(x_mm, y_mm, values[k], levels=levels, cmap=colours, norm=scale) for k, ax in enumerate(axes)]
    for k, ax in enumerate(axes):
        least, most = float(values[k].min()), float(values[k].max())
        if most - least > _EVEN * max(abs(most), abs(least)):  # else lines would speak of nothing
            steps = MaxNLocator(_LINES).tick_values(least, most)
            lines = ax.contour(x_mm, y_mm, values[k], levels=steps, colors="black", linewidths=0.6)
            for text in ax.clabel(lines, fontsize=8, fmt="%g"):
                text.set_bbox({"facecolor": "white", "edgecolor": "none", "alpha": 0.75, "pad": 0.6})
        ax.plot(*middle, marker="+", color="white", markeredgewidth=2.2, markersize=9)
        ax.plot(*middle, marker="+", color="black", markersize=8)
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


_COLOURS = (VERMILLION, ORANGE, GREEN, BLUE)  # From the slowest rate to the fastest
_HAND_LINES = {NOBODY: "-", "light": ":", "medium": "--", "firm": "-."}
LEAST = 0.01  # N/mm, foot of the planes


@styled
def z_width(sheet: LoopSheet, name: str) -> Figure:
    """Draws the largest stable stiffness over the damping, by rate and hand, and whose region is passive."""
    figure = Figure(figsize=(10.0, 8.2), layout="constrained")
    panels = figure.subplots(2, 2, sharex=True, sharey=True)
    for ax, ((place, axis), one) in zip(panels.flat, sheet.z_width.items(), strict=True):
        _plane(ax, sheet, one)
        ax.set_title(f"along {axis}, {place}", fontsize=10)
    for ax in panels[1]:
        ax.set_xlabel("damping of the wall, N s/m")
    for ax in panels[:, 0]:
        ax.set_ylabel("largest stable stiffness, N/mm")
    for hand, style in _HAND_LINES.items():
        panels[0, 0].plot([], [], style, color="black", label=f"{hand}{' hand' if hand != NOBODY else ''}")
    figure.suptitle(f"Z-width of {name}: {sheet.loop.label}", fontsize=10)
    figure.legend(*panels[0, 0].get_legend_handles_labels(), ncols=3, fontsize=8, loc="outside lower center")
    return figure


def _plane(ax: Axes, sheet: LoopSheet, one: Plane) -> None:
    for colour, (rate, hands) in zip(_COLOURS[-len(one.stable) :], one.stable.items(), strict=True):
        for hand, limits in hands.items():
            # a limit of 0 is none: the damping alone is too much for that rate
            shown = np.where(limits > 0.0, 1e-3 * limits, np.nan)
            label = f"{rate / 1e3:g} kHz" if hand == NOBODY else None
            ax.plot(
                sheet.dampings, shown, _HAND_LINES[hand], color=colour, linewidth=1.8 if label else 0.9, label=label
            )
    for passive, walls, hatch in ((one.passive, sheet.walls, None), (one.passive_other, sheet.other, "///")):
        label = f"passive with any passive hand, {walls.loop.name} loop: {walls.loop.condition}"
        shade = {"facecolor": BLUE if hatch is None else "none", "alpha": 0.15 if hatch is None else 0.5}
        ax.fill_between(sheet.dampings, 1e-3 * passive, LEAST, hatch=hatch, linewidth=0.0, label=label, **shade)
    ax.axvline(sheet.loop.damping, color="black", linewidth=0.6, alpha=0.5)
    ax.set_xscale("symlog", linthresh=0.5)
    ax.set(xlim=(0.0, sheet.dampings[-1]), ylim=(LEAST, 100.0), yscale="log", xticks=list(sheet.dampings))
    ax.set_xticklabels([f"{b:g}" for b in sheet.dampings])
    ax.xaxis.set_minor_locator(NullLocator())


@styled
def impedance(sheet: LoopSheet, name: str) -> Figure:
    """Draws the range of |Z| over frequency: from the free handle to the stiffest wall that is rendered."""
    figure = Figure(figsize=(8.0, 4.8), layout="constrained")
    ax = figure.subplots()
    for colour, ((place, axis), one) in zip(_COLOURS, sheet.z_width.items(), strict=True):
        ax.loglog(sheet.frequency, one.lower, color=colour, label=f"{place}, {axis}: free handle")
        ax.loglog(sheet.frequency, one.upper, "--", color=colour, label=f"wall of {1e-3 * one.wall:.1f} N/mm")
    line = {"color": "black", "linewidth": 0.7, "linestyle": ":", "label": "first resonance, motors held"}
    ax.axvline(sheet.first_resonance, **line)
    ax.set(xlabel="frequency, Hz", ylabel="|Z|, N s/m", xlim=(1.0, float(sheet.frequency[-1])), ylim=(0.02, 5e3))
    ax.set_title(f"Range of impedance at the handle of {name}", fontsize=11)
    ax.legend(frameon=False, fontsize=8, ncols=2)
    return figure
