"""Style of every picture: colours that the colour-blind tell apart, sizes, and a drawing function under it.

Importing this module loads matplotlib.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import Any, ParamSpec

from matplotlib import rc_context
from matplotlib.figure import Figure

BLACK, ORANGE, SKY, GREEN = "#000000", "#E69F00", "#56B4E9", "#009E73"
# Okabe and Ito's palette.
YELLOW, BLUE, VERMILLION, PURPLE = "#F0E442", "#0072B2", "#D55E00", "#CC79A7"
GREY = "#6E6E6E"
DPI = 150
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
