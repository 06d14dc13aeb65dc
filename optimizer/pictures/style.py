"""What all pictures share: colours that the colour-blind tell apart, sizes, and how a figure becomes files."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import wraps
from pathlib import Path
from typing import Any, ParamSpec

from matplotlib import rc_context
from matplotlib.axes import Axes
from matplotlib.figure import Figure

BLACK, ORANGE, SKY, GREEN = "#000000", "#E69F00", "#56B4E9", "#009E73"
YELLOW, BLUE, VERMILLION, PURPLE = "#F0E442", "#0072B2", "#D55E00", "#CC79A7"
"""Okabe and Ito's palette."""
GREY = "#6E6E6E"
DPI = 150
WIDE = 10.0
RC: Any = {
    "font.family": "DejaVu Sans",
    "font.size": 9.5,
    "axes.titlesize": 10.5,
    "axes.labelsize": 9.5,
    "legend.fontsize": 8.5,
    "axes.grid": True,
    "grid.color": "#DDDDDD",
    "grid.linewidth": 0.6,
    "axes.axisbelow": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "legend.frameon": True,
    "legend.framealpha": 0.9,
    "legend.edgecolor": "#CCCCCC",
    "svg.hashsalt": "delta-haptics",  # the same picture has the same bytes
}

Given = ParamSpec("Given")


def styled(draw: Callable[Given, Figure]) -> Callable[Given, Figure]:
    """A drawing function under the pictures' style, whatever the user's own settings are."""

    @wraps(draw)
    def drawn(*arguments: Given.args, **named: Given.kwargs) -> Figure:
        with rc_context(RC):
            return draw(*arguments, **named)

    return drawn


def pretty(text: str) -> str:
    """Text with the paper's indices and signs as they are set in print."""
    return (
        text.replace("L_A", "$L_A$")
        .replace("L_B", "$L_B$")
        .replace(">=", "\N{GREATER-THAN OR EQUAL TO}")
        .replace("<=", "\N{LESS-THAN OR EQUAL TO}")
    )


def kappa_scale(ax: Axes, kappas: Sequence[float]) -> None:
    """A logarithmic scale with plain numbers where condition numbers differ by more than `WIDE`."""
    if max(kappas) > WIDE * min(kappas):
        ax.set_yscale("log")
        ax.yaxis.set_major_formatter("{x:g}")


def save(figure: Figure, folder: Path, name: str) -> list[str]:
    """Writes a figure as PNG at 150 dpi and as SVG.

    Args:
        figure: The figure.
        folder: Where to.
        name: Of the files, without ending.

    Returns:
        The files' names.
    """
    with rc_context(RC):
        figure.savefig(folder / f"{name}.png", dpi=DPI, metadata={"Software": None})
        figure.savefig(folder / f"{name}.svg", metadata={"Date": None, "Creator": None})
    return [f"{name}.png", f"{name}.svg"]
