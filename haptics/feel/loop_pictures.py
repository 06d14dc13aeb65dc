"""Pictures of the loop: the K-B plane by rate and hand, and impedance over frequency. Importing this loads
matplotlib.
"""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import NullLocator

from delta_cad.common.picture_style import BLUE, GREEN, ORANGE, VERMILLION, styled
from haptics.feel.loops import AXIS, LoopSheet
from haptics.stability.walls import NOBODY

COLOURS = (VERMILLION, ORANGE, GREEN, BLUE)  # From the slowest rate to the fastest
ABOVE_LEGEND = 0.26  # Foot of a vertical line, of the axes' height
LINES = {NOBODY: "-", "light": ":", "medium": "--", "firm": "-."}


@styled
def z_width(sheet: LoopSheet, name: str) -> Figure:
    """Draws the largest stiffness over the damping, by rate and hand, and the passive region at the board's rate."""
    figure = Figure(figsize=(8.0, 5.2), layout="constrained")
    ax = figure.subplots()
    for colour, (rate, hands) in zip(COLOURS[-len(sheet.z_width) :], sheet.z_width.items(), strict=True):
        for hand, limits in hands.items():
            # a limit of 0 is none: the damping alone is too much for that rate
            shown = np.where(limits > 0.0, 1e-3 * limits, np.nan)
            label = f"{rate / 1e3:g} kHz" if hand == NOBODY else None
            width = 1.8 if hand == NOBODY else 0.9
            ax.plot(sheet.dampings, shown, LINES[hand], color=colour, linewidth=width, label=label)
    fill = {"color": BLUE, "alpha": 0.12, "linewidth": 0.0, "label": "passive, averaged"}
    ax.fill_between(sheet.dampings, 1e-3 * sheet.passive, **fill)
    for hand, style in LINES.items():
        ax.plot([], [], style, color="black", label=f"{hand}{' hand' if hand != NOBODY else ''}")
    ax.set(xlabel="damping of the wall, N s/m", ylabel="largest stable stiffness, N/mm", yscale="log")
    ax.set_xscale("symlog", linthresh=0.5)
    ax.set(xlim=(0.0, sheet.dampings[-1]), ylim=(0.1, 100.0), xticks=list(sheet.dampings))
    ax.set_xticklabels([f"{b:g}" for b in sheet.dampings])
    ax.xaxis.set_minor_locator(NullLocator())
    ax.axvline(sheet.loop.damping, ymin=ABOVE_LEGEND, color="black", linewidth=0.6, alpha=0.5)
    ax.set_title(f"Z-width of {name} along {AXIS}, centre; the thin line: damping that every wall gets", fontsize=11)
    ax.legend(ncols=3, fontsize=8, loc="lower right", frameon=False)
    return figure


@styled
def impedance(sheet: LoopSheet, name: str) -> Figure:
    """Draws |Z| at the handle over frequency at each place, let go and at a wall."""
    figure = Figure(figsize=(8.0, 4.6), layout="constrained")
    ax = figure.subplots()
    for colour, (place, one) in zip((BLUE, GREEN, VERMILLION), sheet.impedances.items(), strict=True):
        ax.loglog(sheet.frequency, one.free, color=colour, label=f"{place}, let go")
        ax.loglog(sheet.frequency, one.at_wall, "--", color=colour, label=f"at a wall of {1e-3 * one.wall:.1f} N/mm")
    line = {"color": "black", "linewidth": 0.7, "linestyle": ":", "label": "first resonance, motors held"}
    ax.axvline(sheet.first_resonance, ymin=ABOVE_LEGEND, **line)
    ax.set(xlabel="frequency, Hz", ylabel="|Z|, N s/m", xlim=(1.0, float(sheet.frequency[-1])), ylim=(0.02, 5e3))
    ax.set_title(f"Impedance at the handle of {name} along {AXIS}, the structure as soft as asked", fontsize=11)
    ax.legend(frameon=False, fontsize=9, ncols=2)
    return figure
