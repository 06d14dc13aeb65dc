"""Pictures of the loop: Z-width as K-B planes by rate and hand, and as the range of impedance. Importing this loads
matplotlib.
"""

from __future__ import annotations

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator

from delta_cad.common.picture_style import BLUE, GREEN, ORANGE, VERMILLION, styled
from haptics.feel.loops import LoopSheet, Plane
from haptics.loop.walls import NOBODY

COLOURS = (VERMILLION, ORANGE, GREEN, BLUE)  # From the slowest rate to the fastest
LINES = {NOBODY: "-", "light": ":", "medium": "--", "firm": "-."}
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
    for hand, style in LINES.items():
        panels[0, 0].plot([], [], style, color="black", label=f"{hand}{' hand' if hand != NOBODY else ''}")
    figure.suptitle(f"Z-width of {name}: {sheet.loop.label}", fontsize=10)
    figure.legend(*panels[0, 0].get_legend_handles_labels(), ncols=3, fontsize=8, loc="outside lower center")
    return figure


def _plane(ax: Axes, sheet: LoopSheet, one: Plane) -> None:
    for colour, (rate, hands) in zip(COLOURS[-len(one.stable) :], one.stable.items(), strict=True):
        for hand, limits in hands.items():
            # a limit of 0 is none: the damping alone is too much for that rate
            shown = np.where(limits > 0.0, 1e-3 * limits, np.nan)
            label = f"{rate / 1e3:g} kHz" if hand == NOBODY else None
            ax.plot(sheet.dampings, shown, LINES[hand], color=colour, linewidth=1.8 if label else 0.9, label=label)
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
    for colour, ((place, axis), one) in zip(COLOURS, sheet.z_width.items(), strict=True):
        ax.loglog(sheet.frequency, one.lower, color=colour, label=f"{place}, {axis}: free handle")
        ax.loglog(sheet.frequency, one.upper, "--", color=colour, label=f"wall of {1e-3 * one.wall:.1f} N/mm")
    line = {"color": "black", "linewidth": 0.7, "linestyle": ":", "label": "first resonance, motors held"}
    ax.axvline(sheet.first_resonance, **line)
    ax.set(xlabel="frequency, Hz", ylabel="|Z|, N s/m", xlim=(1.0, float(sheet.frequency[-1])), ylim=(0.02, 5e3))
    ax.set_title(f"Range of impedance at the handle of {name}", fontsize=11)
    ax.legend(frameon=False, fontsize=8, ncols=2)
    return figure
